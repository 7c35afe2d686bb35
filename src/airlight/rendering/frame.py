"""One frame, from scene to image. Read this first.

A scene is resolved (automatic transfer functions, named views), each layer gets its stages and what they may look at, the
driver draws its passes, and the result comes back as an ``Image``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..environment import Environment
from ..errors import DataError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Layer, Scene, check_scene
from ..shader.program import Program
from ..stage import SLOTS, Context, Stage, make_stage
from ..stages.blocks import even_blocks
from ..stages.driver import sharpens_surfaces
from ..stages.passes import Pass
from ..stages.transfer import Transfer
from ..volume import statistics
from .annotating import annotated, noted
from .background import background_statistics, plain_background, without_layers
from .clips import clip_statistics, cutting_clips, nothing_left
from .covers import check_covers, visible_corners
from .half_angle import check_pictures
from .hits import Hits, check_keeps, check_relights, check_same
from .image import FloatImage, Image
from .layers import checked_layers, context_of, layer_statistics, own_slots, read_layers
from .march import MarchFrame, draws_caps, with_blocks
from .nearby import chosen_anchor, near_camera, shifted_lights
from .outlines import check_outlines
from .passes import check_bounds, check_reads
from .resources import DrawnLayer, if_even, told_leaps, unless_full
from .shown import IntArray
from .stats import disagreement_statistics, frame_statistics
from .ways import RAYS, draw_frame, way_of

GREATEST_VALUE = 1e37
LEAST_TOLERANCE = 1e-5
SKIPS = ("auto", "none", "blocks", "geometry")


@dataclass(frozen=True)
class Request:
    """What is asked of a frame beside its scene.

    ``tolerance`` bounds the error of its pixels, and ``budget_ms`` the time that it takes: see ``tolerance.py``, ``budget.py``.
    ``passes`` are those of users. ``converges``: stages that are quick at the cost of an error, which no smaller step mends,
    give way to those that are not.
    """

    size_px: tuple[int, int]
    driver: Stage
    step: float = 1.0
    skip: str = "auto"
    keep_hits: bool = False
    tolerance: float | None = None
    budget_ms: float | None = None
    converges: bool = False
    passes: tuple[Pass, ...] = ()

    def __post_init__(self) -> None:
        """Check the numbers."""
        width, height = self.size_px
        if not (0 < width <= 1 << 16 and 0 < height <= 1 << 16):
            raise ValueRangeError("size", f"is {self.size_px}, width and height must lie in [1, 65536]")
        if not 1e-3 <= self.step <= 1e3:
            raise ValueRangeError("step", f"is {self.step}, must lie in [0.001, 1000] voxels")
        if self.step < getattr(self.driver, "least_step", 0.0):
            found = f"is {self.step} voxels, and the driver {self.driver.name!r} has no slices between layers"
            raise ValueRangeError("step", found, 'use driver="interpolated_slices", or a step of 1 or more')
        if self.tolerance is not None and not LEAST_TOLERANCE <= self.tolerance < 1:
            small = 0 <= self.tolerance < LEAST_TOLERANCE
            remedy = "32-bit floats hold no less" if small else "e.g. 1/255, a step of 8 bits"
            raise ValueRangeError("tolerance", f"is {self.tolerance}, must lie in [{LEAST_TOLERANCE:g}, 1)", remedy)
        if self.budget_ms is not None and not 0 < self.budget_ms < math.inf:
            raise ValueRangeError("budget_ms", f"is {self.budget_ms}, must be a positive number of milliseconds")
        chosen = {"tolerance": self.tolerance, "budget_ms": self.budget_ms, "step": None if self.step == 1 else self.step}
        given = [name for name, number in chosen.items() if number is not None]
        if len(given) > 1:
            raise ValueRangeError(given[0], f"is given beside {given[1]}, and each chooses the step", "leave one out")
        if self.tolerance is not None:
            check_bounds(self.passes)
        if self.tolerance is not None and way_of(self.driver) is not RAYS:
            raise ValueRangeError("tolerance", f"is given, and the driver {self.driver.name} draws whole images", "use march")
        if self.skip not in SKIPS:
            raise ValueRangeError("skip", f"is {self.skip!r}, must be one of {', '.join(SKIPS)}")
        if self.skip == "geometry" and self.driver.name != "march":
            found = f"is 'geometry', and the driver is {self.driver.name}"
            raise ValueRangeError("skip", found, "use auto: slices have proxies")


def draw(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Image:
    """Draw a frame on a device. ``check`` may raise between tiles, ``progress`` is told of uploads and tiles.

    Raises
    ------
    LimitError
        When the device ends rays before they are through.
    """
    given = resolve(scene, request.size_px)
    scene, notes = annotated(given, request.size_px)
    image, samples = draw_pixels(device, scene, request, check, progress)
    check_ended(device, samples)
    return noted(image, given, notes)


def check_ended(device: Device, samples: FloatImage) -> None:
    """Refuse what a device has not drawn to the end."""
    if (samples < 0).any():
        raise LimitError(
            f"device {device.info.name!r}",
            f"ended rays before they were through, after {int(-samples.min())} samples: its driver bounds loops",
            "draw with a larger step, central instead of Sobel gradients, or fewer lights",
        )


def draw_pixels(
    device: Device,
    scene: Scene,
    request: Request,
    check: Callable[[], None],
    progress: Progress,
    chosen: IntArray | None = None,
) -> tuple[Image, FloatImage]:
    """Draw chosen pixels (n, 2), x and y, or all, of a scene without annotations.

    The image, and samples (h, w), negative where the device ended the ray. Where nothing of the layers is left, background and
    meshes are drawn alone.
    """
    start = time.perf_counter()
    device.kept.begin_frame()
    if not scene.layers:
        check_reads(request.passes, "domains", "the scene has no volume", "leave it out")
    scene, reason = left_to_draw(scene)
    if reason and not (scene.meshes or request.passes or isinstance(scene.background, Environment)):
        width, height = request.size_px
        nothing = np.zeros((height, width, 4), dtype=np.float32)
        far = np.full((height, width), np.inf, np.float32)
        return Image(nothing, far, plain_background(scene), {"reason": reason}), np.zeros_like(far)
    frame = replace(prepare(device, scene, request, check, progress), chosen=chosen)
    image, samples = _finished(frame, request, start)
    image.stats.update({"reason": reason} if reason else {})
    return image, samples


def left_to_draw(scene: Scene) -> tuple[Scene, str]:
    """Return a scene, without its layers where nothing of them is left, and why that is so."""
    reason = nothing_left(scene) if scene.visible_layers else "no visible layer"
    return (without_layers(scene) if reason else scene), reason


def relight(
    device: Device,
    image: Image,
    scene: Scene,
    check: Callable[[], None],
    progress: Progress,
    passes: tuple[Pass, ...] = (),
) -> Image:
    """Light the surfaces of an image again, for changed lights, materials, colours and tones.

    Raises
    ------
    DataError
        When the image is none or has kept no surfaces, or those of the scene are others.
    """
    start = time.perf_counter()
    if not isinstance(image, Image):
        raise DataError("image", f"is a {type(image).__name__}", "pass what airlight.render returned, then the scene")
    check_scene(scene)
    if image.hits is None:
        raise DataError("image", "has kept no surfaces", "render it with keep_hits=True")
    if not scene.visible_layers:
        raise DataError("scene", "has 0 visible layers, and there is nothing to light", "render the scene")
    given = resolve(scene, image.size)
    scene, notes = annotated(given, image.size)
    check_same(image.hits, scene, image.size)
    device.kept.begin_frame()
    request = Request(image.size, make_stage("driver", "march"), image.stats["step"], passes=passes)
    frame = replace(prepare(device, scene, request, check, progress), found=image.hits)
    check_covers(frame)
    check_relights(frame)
    lit, _ = _finished(frame, request, start)
    return noted(replace(lit, hits=replace(image.hits, scene=scene)), given, notes)


def _finished(frame: MarchFrame, request: Request, start: float) -> tuple[Image, FloatImage]:
    device = frame.device
    rgba, depth, samples = draw_frame(frame)
    device.kept.trim()
    stats = frame_statistics(frame, request.step) | background_statistics(frame.scene) | frame.covers.statistics()
    taken = float(np.abs(samples).sum(dtype=np.float64))
    is_nothing = taken == 0 and frame.found is None and not frame.covers.meshes
    stats |= clip_statistics(frame.given, frame.clips, draws_caps(frame), is_nothing) | layer_statistics(frame)
    stats |= {"samples": int(taken), "milliseconds": frame.clock.milliseconds}
    stats |= way_of(frame.scene_stages["driver"]).statistics(frame)
    stats["passes"] = {"drawn": list(frame.ran), "left_out": list(frame.left_out)}
    stats |= {name: frame.measured[name] for name in ("luminance",) if name in frame.measured}
    if frame.found is None and frame.chosen is None:
        stats |= disagreement_statistics(frame, rgba)
    frame.clock.milliseconds["total"] = 1e3 * (time.perf_counter() - start)
    hits = Hits(frame.kept_hits[0], frame.given) if frame.keeps_hits else None
    return Image(rgba, depth, plain_background(frame.scene), stats, hits), samples


def explain(device: Device, scene: Scene, request: Request) -> Program:
    """Link the program that would draw a frame, without drawing it."""
    scene, _ = left_to_draw(annotated(resolve(scene, request.size_px), request.size_px)[0])
    frame = prepare(device, scene, request, lambda: None, lambda *_: None)
    return way_of(request.driver).program(frame)


def prepare(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> MarchFrame:
    """Resolve a scene and gather what its passes share."""
    given = scene = resolve(scene, request.size_px)
    visible = read_layers(checked_layers(scene), request.driver)
    step_world = request.step * min(min(layer.volume.spacing) for layer in visible)
    skips, keeps = request.skip != "none", request.keep_hits
    sharpens = sharpens_surfaces(request.driver) and len(visible) == 1
    clips = cutting_clips(scene, visible)
    clips_of = [clips[0] + own for own in clips[1:]] or [clips[0]] * len(visible)
    check_pictures(scene, request.driver)
    slab_world = way_of(request.driver).longest(request.driver, visible, scene, request.size_px, step_world)
    told = {"camera": scene.camera, "progress": progress, "lights": scene.lights}
    contexts = [
        context_of(layer, slab_world, request.size_px, clips=own, **told) for layer, own in zip(visible, clips_of, strict=True)
    ]
    layers = tuple(
        drawn_layer(layer, context, skips, keeps, sharpens, request.converges, own_slots(visible))
        for layer, context in zip(visible, contexts, strict=True)
    )
    stages = visible[0].look.stages()
    if request.skip in ("auto", "blocks") and len(layers) == 1 and way_of(request.driver) is RAYS:
        asked = even_blocks({**stages, **layers[0].stages}, stages["integrate"], contexts[0], told_leaps(layers[0]))
        layers = (if_even(device, layers[0], asked),)
    if request.skip == "auto" and len(layers) == 1 and getattr(stages["integrate"], "skips_empty", False):
        layers = (unless_full(device, layers[0]),)
    anchor_world = chosen_anchor(layers[0])
    others = [*visible_corners(scene), *(layer.context.volume.corners_world(layer.field.cells) for layer in layers[1:])]
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
        clip_groups=clips,
        passes=request.passes,
    )
    if request.keep_hits:
        check_keeps(frame)
    check_covers(frame)
    check_outlines(frame)
    return frame


def drawn_layer(
    layer: Layer,
    context: Context,
    skips: bool = False,
    keeps_hits: bool = False,
    sharpens: bool = False,
    converges: bool = False,
    own: frozenset[str] = frozenset(),
) -> DrawnLayer:
    """Give a layer its stages and their resources; a volume with empty samples gets the field that keeps them apart.

    Where surfaces alone are drawn, and space may be skipped, the field knows how far to leap over blocks without one. Surfaces
    that are kept have gradients although nothing may be lit. ``sharpens`` tells that the driver looks for the places of
    surfaces. ``converges`` is told of in ``Request``. ``own`` are slots of a ray that the layer fills by itself.
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
    stages = {slot: stage for slot, stage in layer.stages(keeps_hits).items() if SLOTS[slot].per_layer or slot in own}
    if isinstance(stages["transfer"], Transfer):
        transfer = stages["transfer"].for_context(context)
        transfer = transfer.converging() if converges else transfer
        stages["transfer"] = transfer.sharpened() if sharpens else transfer
    drawn = DrawnLayer(stages, context, {slot: stage.resources(context) for slot, stage in stages.items()})
    return with_blocks(drawn, layer.look.integrate) if skips else drawn
