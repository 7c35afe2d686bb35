"""One frame, from scene to image. Read this first.

A scene is resolved (automatic transfer functions, named views), each layer gets its stages and what they may look at, the
driver draws its passes, and the result comes back as an ``Image``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import DataError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Layer, Scene
from ..shader.program import Program
from ..stage import SLOTS, Context, Grid, Stage, Table
from ..stages.camera import Camera, Orthographic
from ..stages.field import Field
from ..volume import FloatArray, statistics
from .image import Image
from .march import MarchFrame, draw_march, march_program
from .resources import DrawnLayer, grid_texture

GREATEST_VALUE = 1e37
FAR_AWAY = 100.0  # times the reach of a volume
MOST_STEPS_AWAY = 1 << 18
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
    stats = statistics_of(frame, request) | {"samples": int(samples), "milliseconds": frame.clock.milliseconds}
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
    if visible[0].labels is not None:
        raise LimitError("layer.labels", "are not drawn by this version", "leave them out")
    step_world = request.step * min(min(layer.volume.spacing) for layer in visible)
    layers = tuple(drawn_layer(layer, step_world, request.size_px) for layer in visible)
    stages = visible[0].look.stages()
    anchor_world = chosen_anchor(layers[0])
    camera, t_offset_world = near_camera(scene.camera, anchor_world, layers[0], step_world)  # type: ignore[arg-type]
    lights = tuple(
        replace(light, vector=shifted(light.vector, anchor_world)) if light.kind == "point" else light for light in scene.lights
    )
    scene = replace(scene, lights=lights)
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


def chosen_anchor(layer: DrawnLayer) -> FloatArray:
    """Origin of the device's world: that of the user's, or the middle of a volume that lies far from it.

    32-bit floats hold seven digits: positions of a survey in metres from the equator would jump by half a metre.
    """
    corners = layer.context.volume.corners_world()
    middle = corners.mean(axis=0)
    reach = float(np.linalg.norm(corners - middle, axis=1).max()) + layer.context.step_world
    far = float(np.linalg.norm(middle)) > FAR_AWAY * reach
    return middle if far else np.zeros(3)


def near_camera(camera: Camera, anchor_world: FloatArray, layer: DrawnLayer, step_world: float) -> tuple[Camera, float]:
    """Camera in the device's world, and the distance by which its rays begin later than at the eye.

    Parallel rays begin a whole number of steps later, in front of the volume, so that samples stay where they are.

    Raises
    ------
    ValueRangeError
        When a perspective camera is so far away that samples cannot be told apart in 32 bits.
    """
    corners = layer.context.volume.corners_world(layer.field.cells)
    _, _, forward = camera.basis()
    nearest = float(((corners - np.asarray(camera.eye)) @ forward).min())
    steps = int(nearest / step_world) - 1
    eye, target = np.asarray(camera.eye), np.asarray(camera.target)
    if steps > MOST_STEPS_AWAY and not isinstance(camera, Orthographic):
        raise ValueRangeError(
            "camera",
            f"is {steps:,} steps away from the volume, at most {MOST_STEPS_AWAY:,} are told apart",
            "use Camera.orthographic",
        )
    t_offset_world = steps * step_world if isinstance(camera, Orthographic) and steps > 0 else 0.0
    moved: Camera = replace(
        camera,  # type: ignore[type-var]
        eye=shifted(eye + t_offset_world * forward, anchor_world),
        target=shifted(target + t_offset_world * forward, anchor_world),
    )
    return moved, t_offset_world


def shifted(point: Any, anchor_world: FloatArray) -> tuple[float, float, float]:
    """Point in the device's world."""
    x, y, z = np.asarray(point, dtype=np.float64) - anchor_world
    return float(x), float(y), float(z)


def drawn_layer(layer: Layer, step_world: float, size_px: tuple[int, int]) -> DrawnLayer:
    """Give a layer its stages and their resources; a volume with empty samples gets the field that keeps them apart."""
    assert layer.transfer is not None
    channel = layer.volume.channel_index(layer.channel)
    known = statistics(layer.volume, channel, layer.time)
    if max(abs(known.minimum), abs(known.maximum)) > GREATEST_VALUE:
        raise DataError(
            "volume",
            f"has values from {known.minimum:.3g} to {known.maximum:.3g}, beyond what devices hold ({GREATEST_VALUE:g})",
            "scale it, e.g. volume / 1e30, and the transfer function with it",
        )
    transfer = layer.transfer if layer.density == 1 else layer.transfer.scaled(layer.density)
    context = Context(layer.volume, transfer, channel, layer.time, step_world, size_px)
    stages = {slot: stage for slot, stage in layer.look.stages().items() if SLOTS[slot].per_layer}
    field = stages["field"]
    if isinstance(field, Field) and not field.masked and known.empty:
        stages["field"] = field.for_empty()
    return DrawnLayer(stages, context, {slot: stage.resources(context) for slot, stage in stages.items()})


def statistics_of(frame: MarchFrame, request: Request) -> dict[str, Any]:
    """What ``image.stats`` says of a frame beside times and counts."""
    info = frame.device.info
    layers = []
    for layer in frame.layers:
        grids = [r for r in layer.resources["field"].values() if isinstance(r, Grid)]
        textures = [grid_texture(frame.device, grid, frame.progress) for grid in grids]
        tables = {
            f"{slot}.{name}": list(r.texels.shape)
            for slot, resources in layer.resources.items()
            for name, r in resources.items()
            if isinstance(r, Table)
        }
        layers.append(
            {
                "stages": {slot: stage.name for slot, stage in layer.stages.items()},
                "textures": [{"format": t.encoding.format, "error": t.encoding.error, "bytes": t.bytes} for t in textures],
                "tables": tables,
                "errors": {
                    f"{slot}: {what}": error
                    for slot, stage in layer.stages.items()
                    for what, error in stage.errors(layer.context).items()
                },
                "level": 0,
            }
        )
    return {
        "adapter": {"name": info.name, "kind": info.kind, "backend": info.backend, "driver": info.driver},
        "core": frame.device.core,
        "driver": request.driver.name,
        "size": list(request.size_px),
        "step": request.step,
        "step_world": frame.step_world,
        "skip": {"asked": request.skip, "done": "none"},
        "layers": layers,
    }
