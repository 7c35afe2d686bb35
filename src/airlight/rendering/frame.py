"""One frame, from scene to image. Read this first.

A scene is resolved (automatic transfer functions, named views), each layer gets its stages and what they may look at, the
driver draws its passes, and the result comes back as an ``Image``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..errors import DataError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Layer, Scene
from ..shader.program import Program
from ..stage import SLOTS, Context, Stage
from ..volume import statistics
from .image import Image
from .march import MarchFrame, draw_march, march_program
from .nearby import chosen_anchor, near_camera, shifted_lights
from .resources import DrawnLayer
from .stats import frame_statistics

GREATEST_VALUE = 1e37
SKIPS = ("auto", "none", "blocks", "geometry")


@dataclass(frozen=True)
class Request:
    """What is asked of a frame beside its scene."""

    size_px: tuple[int, int]
    driver: Stage
    step: float = 1.0
    skip: str = "auto"

    def __post_init__(self) -> None:
        """Check the numbers."""
        width, height = self.size_px
        if not (0 < width <= 1 << 16 and 0 < height <= 1 << 16):
            raise ValueRangeError("size", f"is {self.size_px}, width and height must lie in [1, 65536]")
        if not 1e-3 <= self.step <= 1e3:
            raise ValueRangeError("step", f"is {self.step}, must lie in [0.001, 1000] voxels")
        if self.skip not in SKIPS:
            raise ValueRangeError("skip", f"is {self.skip!r}, must be one of {', '.join(SKIPS)}")
        if self.skip in ("blocks", "geometry"):
            raise ValueRangeError("skip", f"{self.skip!r} is not built yet", "use auto or none; the image is the same")


def draw(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Image:
    """Draw a frame on a device. ``check`` may raise between tiles, ``progress`` is told of uploads and tiles."""
    start = time.perf_counter()
    if not scene.visible_layers:
        width, height = request.size_px
        nothing = np.zeros((height, width, 4), dtype=np.float32)
        return Image(nothing, np.full((height, width), np.inf, np.float32), scene.background, {"reason": "no visible layer"})
    frame = prepare(device, scene, request, check, progress)
    rgba, depth, samples = draw_march(frame)
    stats = frame_statistics(frame, request.step) | {"samples": int(samples), "milliseconds": frame.clock.milliseconds}
    frame.clock.milliseconds["total"] = 1e3 * (time.perf_counter() - start)
    return Image(rgba, depth, frame.scene.background, stats)


def explain(device: Device, scene: Scene, request: Request) -> Program:
    """Link the program that would draw a frame, without drawing it."""
    return march_program(prepare(device, scene, request, lambda: None, lambda *_: None))


def prepare(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> MarchFrame:
    """Resolve a scene and gather what its passes share."""
    scene = resolve(scene, request.size_px)
    visible = scene.visible_layers
    if len(visible) != 1:
        raise LimitError(
            "scene.layers", f"has {len(visible)} visible layers; this version draws one at a time", "hide the others"
        )
    step_world = request.step * min(min(layer.volume.spacing) for layer in visible)
    layers = tuple(drawn_layer(layer, step_world, request.size_px) for layer in visible)
    stages = visible[0].look.stages()
    anchor_world = chosen_anchor(layers[0])
    camera, t_offset_world = near_camera(scene.camera, anchor_world, layers[0], step_world)  # type: ignore[arg-type]
    scene = replace(scene, lights=shifted_lights(scene.lights, anchor_world))
    scene_stages: dict[str, Stage] = {"driver": request.driver, "camera": camera}
    scene_stages |= {slot: stage for slot, stage in stages.items() if not SLOTS[slot].per_layer}
    return MarchFrame(
        device=device,
        scene=scene,
        scene_stages=scene_stages,
        layers=layers,
        size_px=request.size_px,
        step_world=step_world,
        t_offset_world=t_offset_world,
        anchor_world=anchor_world,
        skip=request.skip,
        check=check,
        progress=progress,
    )


def drawn_layer(layer: Layer, step_world: float, size_px: tuple[int, int]) -> DrawnLayer:
    """Give a layer its stages and their resources; a volume with empty samples gets the field that keeps them apart."""
    assert layer.transfer is not None
    for channel in layer.channels:
        known = statistics(layer.volume, channel, layer.time)
        if max(abs(known.minimum), abs(known.maximum)) > GREATEST_VALUE:
            raise DataError(
                "volume",
                f"has values from {known.minimum:.3g} to {known.maximum:.3g}, beyond what devices hold ({GREATEST_VALUE:g})",
                "scale it, e.g. volume / 1e30, and the transfer function with it",
            )
    context = Context(layer.volume, layer.function, layer.channels, layer.time, step_world, size_px, layer.labels)
    stages = {slot: stage for slot, stage in layer.stages().items() if SLOTS[slot].per_layer}
    return DrawnLayer(stages, context, {slot: stage.resources(context) for slot, stage in stages.items()})
