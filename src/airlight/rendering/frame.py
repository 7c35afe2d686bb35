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

from ..clips import Clip
from ..environment import Environment
from ..errors import DataError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Layer, Scene
from ..shader.program import Program
from ..stage import SLOTS, Context, Stage, make_stage
from ..stages.blocks import block_leaps
from ..stages.driver import sharpens_surfaces
from ..stages.transfer import Transfer
from ..volume import statistics
from .background import background_statistics, plain_background, without_layers
from .clips import clip_statistics, cutting_clips, nothing_left
from .covers import check_covers, visible_corners
from .hits import Hits, check_keeps, check_relights, check_same
from .image import Image
from .march import MarchFrame, draw_march, draws_caps, march_program
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
    keep_hits: bool = False

    def __post_init__(self) -> None:
        """Check the numbers."""
        width, height = self.size_px
        if not (0 < width <= 1 << 16 and 0 < height <= 1 << 16):
            raise ValueRangeError("size", f"is {self.size_px}, width and height must lie in [1, 65536]")
        if not 1e-3 <= self.step <= 1e3:
            raise ValueRangeError("step", f"is {self.step}, must lie in [0.001, 1000] voxels")
        if self.skip not in SKIPS:
            raise ValueRangeError("skip", f"is {self.skip!r}, must be one of {', '.join(SKIPS)}")
        if self.skip == "geometry":
            raise ValueRangeError("skip", "'geometry' cannot be asked for yet", "use auto or blocks; the image is the same")


def draw(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Image:
    """Draw a frame on a device. ``check`` may raise between tiles, ``progress`` is told of uploads and tiles."""
    start = time.perf_counter()
    device.kept.begin_frame()
    reason = nothing_left(scene) if scene.visible_layers else "no visible layer"
    if reason and (scene.meshes or isinstance(scene.background, Environment)):
        scene = without_layers(scene)
    elif reason:
        width, height = request.size_px
        nothing = np.zeros((height, width, 4), dtype=np.float32)
        far = np.full((height, width), np.inf, np.float32)
        return Image(nothing, far, plain_background(scene), {"reason": reason}, scene=scene)
    image = _finished(prepare(device, scene, request, check, progress), request, start)
    image.stats.update({"reason": reason} if reason else {})
    return image


def relight(device: Device, image: Image, scene: Scene, check: Callable[[], None], progress: Progress) -> Image:
    """Light the surfaces of an image again, for changed lights, materials, colours and tones.

    Raises
    ------
    DataError
        When the image is none or has kept no surfaces, or those of the scene are others.
    """
    start = time.perf_counter()
    if not isinstance(image, Image):
        raise DataError("image", f"is a {type(image).__name__}", "pass what airlight.render returned, then the scene")
    if not isinstance(scene, Scene):
        raise DataError("scene", f"is a {type(scene).__name__}", "pass an airlight.Scene")
    if image.hits is None:
        raise DataError("image", "has kept no surfaces", "render it with keep_hits=True")
    if len(scene.visible_layers) != 1:
        raise DataError("scene", f"has {len(scene.visible_layers)} visible layers, and the image shows one", "render it")
    scene = resolve(scene, image.size)
    check_same(image.hits, scene, image.size)
    device.kept.begin_frame()
    request = Request(image.size, make_stage("driver", "march"), image.stats["step"])
    frame = replace(prepare(device, scene, request, check, progress), found=image.hits)
    check_covers(frame)
    check_relights(frame)
    return replace(_finished(frame, request, start), hits=replace(image.hits, scene=scene))


def _finished(frame: MarchFrame, request: Request, start: float) -> Image:
    device = frame.device
    rgba, depth, samples = draw_march(frame)
    device.kept.trim()
    stats = frame_statistics(frame, request.step) | background_statistics(frame.scene) | frame.covers.statistics()
    is_nothing = samples == 0 and frame.found is None and not frame.covers.meshes
    stats |= clip_statistics(frame.given, frame.clips, draws_caps(frame), is_nothing)
    stats |= {"samples": int(samples), "milliseconds": frame.clock.milliseconds}
    frame.clock.milliseconds["total"] = 1e3 * (time.perf_counter() - start)
    hits = Hits(frame.kept_hits[0], frame.given) if frame.keeps_hits else None
    return Image(rgba, depth, plain_background(frame.scene), stats, hits, frame.given)


def explain(device: Device, scene: Scene, request: Request) -> Program:
    """Link the program that would draw a frame, without drawing it."""
    return march_program(prepare(device, scene, request, lambda: None, lambda *_: None))


def prepare(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> MarchFrame:
    """Resolve a scene and gather what its passes share."""
    given = scene = resolve(scene, request.size_px)
    visible = scene.visible_layers
    if len(visible) != 1:
        raise LimitError(
            "scene.layers", f"has {len(visible)} visible layers; this version draws one at a time", "hide the others"
        )
    step_world = request.step * min(min(layer.volume.spacing) for layer in visible)
    skips, keeps, sharpens = request.skip != "none", request.keep_hits, sharpens_surfaces(request.driver)
    clips = cutting_clips(scene, visible[0])
    layers = tuple(
        drawn_layer(layer, step_world, request.size_px, skips, scene.camera, keeps, sharpens, clips) for layer in visible
    )
    stages = visible[0].look.stages()
    anchor_world = chosen_anchor(layers[0])
    others = visible_corners(scene)
    camera, t_offset_world = near_camera(scene.camera, anchor_world, layers[0], step_world, others)  # type: ignore[arg-type]
    scene = replace(scene, lights=shifted_lights(scene.lights, anchor_world))
    scene_stages: dict[str, Stage] = {"driver": request.driver, "camera": camera}
    scene_stages |= {slot: stage for slot, stage in stages.items() if not SLOTS[slot].per_layer}
    frame = MarchFrame(
        device=device,
        scene=scene,
        given=given,
        scene_stages=scene_stages,
        layers=layers,
        size_px=request.size_px,
        step_world=step_world,
        t_offset_world=t_offset_world,
        anchor_world=anchor_world,
        skip=request.skip,
        check=check,
        progress=progress,
        keeps_hits=request.keep_hits,
        clips=clips,
    )
    if request.keep_hits:
        check_keeps(frame)
    check_covers(frame)
    return frame


def drawn_layer(
    layer: Layer,
    step_world: float,
    size_px: tuple[int, int],
    skips: bool,
    camera: Any = None,
    keeps_hits: bool = False,
    sharpens: bool = False,
    clips: tuple[Clip, ...] = (),
) -> DrawnLayer:
    """Give a layer its stages and their resources; a volume with empty samples gets the field that keeps them apart.

    Where surfaces alone are drawn, and space may be skipped, the field knows how far to leap over blocks without one. Surfaces
    that are kept have gradients although nothing may be lit. ``sharpens`` tells that the driver looks for the places of
    surfaces. ``clips`` are those that cut the layer.
    """
    assert layer.transfer is not None
    for channel in layer.channels:
        known = statistics(layer.volume, channel, layer.time)
        if max(abs(known.minimum), abs(known.maximum)) > GREATEST_VALUE:
            raise DataError(
                "volume",
                f"has values from {known.minimum:.3g} to {known.maximum:.3g}, beyond what devices hold ({GREATEST_VALUE:g})",
                "scale it, e.g. volume / 1e30, and the transfer function with it",
            )
    context = Context(
        layer.volume, layer.function, layer.channels, layer.time, step_world, size_px, layer.labels, camera, clips
    )
    stages = {slot: stage for slot, stage in layer.stages(keeps_hits).items() if SLOTS[slot].per_layer}
    if isinstance(stages["transfer"], Transfer):
        transfer = stages["transfer"].for_context(context)
        stages["transfer"] = transfer.sharpened() if sharpens else transfer
    drawn = DrawnLayer(stages, context, {slot: stage.resources(context) for slot, stage in stages.items()})
    if skips and (leaps := block_leaps(drawn.field, layer.look.integrate, stages["transfer"], context)):
        resources = {**drawn.resources, "field": {**drawn.resources["field"], "leaps": leaps}}
        drawn = replace(drawn, resources=resources)
    return drawn
