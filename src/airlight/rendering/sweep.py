"""Slice drivers: groups of slices, each a render pass over what the group may show, from where the one before left off."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ..errors import LimitError, StageError, ValueRangeError
from ..gpu import compute, raster
from ..gpu.tiles import Pace, Tile
from ..scene import Layer, Scene
from ..shader.layout import size_in
from ..shader.program import GroupUniforms, PlaneUniforms, Program
from ..stage import Stage
from ..stages.camera import Camera, Orthographic, Perspective
from ..stages.driver_slices import Planes, SliceDriver
from ..stages.view_rays import least_cosine
from ..stages.visibility import NoOcclusion
from ..volume import FloatArray, domain_index
from .layers import check_layers, check_textures, context_of
from .march import (
    Band,
    MarchFrame,
    bound_groups,
    check_refines,
    declares,
    drawn_meshes,
    late_tones,
    looked_at,
    uploaded,
    written_clips,
)
from .proxies.pieces import Pieces, pieces_of
from .proxies.polyhedra import Polyhedron, box, inflated
from .proxies.shells import shell_pieces
from .rasterised import depths_between, skin_world, tiles_of
from .resources import pack_uniforms
from .shown import corners_world

MOST_SLICES = 65536
LEAST_COSINE = 0.02  # between a ray and the normal of the planes that it passes


@dataclass(frozen=True)
class Numbers:
    """Samples of a sweep by number, and those between which something may be seen: groups go from one of them to the next."""

    first: int
    last: int
    group: int
    shown: tuple[int, int]

    @property
    def groups(self) -> tuple[tuple[int, int], ...]:
        """First and last sample of each group, away from the eye."""
        first, last = self.shown
        return tuple((k, min(k + self.group, last)) for k in range(first, last, self.group))


def check_sweep(frame: MarchFrame) -> None:
    """Refuse what slices cannot draw.

    Raises
    ------
    StageError
        For kept surfaces, single pixels, and orders that the integrate stage has not.
    """
    driver = frame.scene_stages["driver"]
    assert isinstance(driver, SliceDriver)
    where = f"driver {driver.name!r}"
    if frame.keeps_hits or frame.chosen is not None:
        raise StageError(where, "keeps no surfaces and draws whole images", 'use driver="march"')
    if not driver.back_to_front:
        return
    integrate = frame.scene_stages["integrate"]
    if not declares(integrate, "join"):
        raise StageError(f"{where}.back_to_front", f"cannot put parts together of {integrate.name}", "draw front to back")
    if frame.covers.meshes:
        raise StageError(f"{where}.back_to_front", "has no order for meshes", "draw front to back")


def planes_of(frame: MarchFrame) -> Planes | None:
    """Planes of the frame's slices in the device's world, numbered from where the domain begins; None for shells.

    Raises
    ------
    ValueRangeError
        When rays of the image do not all pass the planes in one direction.
    """
    driver, context = frame.scene_stages["driver"], frame.layers[0].context
    assert isinstance(driver, SliceDriver)
    camera = context.camera
    planes = driver.planes(camera, replace(context, step_world=frame.step_world))
    if planes is None:
        return None
    cosine_of(planes, camera, frame.size_px, driver, _corners(frame) + frame.anchor_world)
    return planes.seen_from(frame.anchor_world).numbered_from(_corners(frame))


def longest_slab(driver: Stage, layers: Sequence[Layer], scene: Scene, size_px: tuple[int, int], step_world: float) -> float:
    """Length of the longest slab of a frame [world]: rays that pass slices askew have longer ones.

    Raises
    ------
    StageError
        For cameras without a rasteriser's projection.
    ValueRangeError
        When rays of the image do not all pass the slices in one direction.
    """
    assert isinstance(driver, SliceDriver)
    camera: Any = scene.camera
    if not isinstance(camera, (Perspective, Orthographic)):
        raise StageError(f"driver {driver.name!r}", f"draws no {camera.name} images", 'use driver="march"')
    planes = driver.planes(camera, context_of(layers[0], step_world, size_px))
    corners = np.concatenate([one.volume.corners_world(cells=True) for one in layers])
    return step_world if planes is None else planes.spacing_world / cosine_of(planes, camera, size_px, driver, corners)


def cosine_of(
    planes: Planes, camera: Camera, size_px: tuple[int, int], driver: SliceDriver, corners_world: FloatArray
) -> float:
    """Least cosine between rays that may meet what lies between corners (n, 3) and the normal of planes.

    Raises
    ------
    ValueRangeError
        When rays run along planes, or pass them in both directions.
    """
    least = least_cosine(planes.normal, camera, size_px, corners_world)
    if least < LEAST_COSINE:
        raise ValueRangeError(
            "camera",
            f"sees slices of the driver {driver.name!r} from the edge, or from both sides",
            'move the eye away, take a smaller angle of view, an orthographic camera, or driver="shells"',
        )
    return least


def numbers_of(frame: MarchFrame) -> Numbers:
    """Samples between which the domain lies."""
    driver, planes = frame.scene_stages["driver"], frame.once(planes_of)
    assert isinstance(driver, SliceDriver)
    corners = _corners(frame)
    if planes is not None:
        places = (corners @ planes.normal - planes.first) / planes.spacing_world
    else:
        camera: Any = frame.scene_stages["camera"]
        away = corners - np.asarray(camera.eye)
        if isinstance(camera, Orthographic):
            places = away @ camera.basis()[2] / frame.step_world
        else:
            nearest = _distance_to_box(corners, np.asarray(camera.eye))
            places = np.append(np.linalg.norm(away, axis=1), nearest) / frame.step_world
    first, last = max(int(np.floor(places.min())), 0), int(np.ceil(places.max()))
    if planes is not None:
        first = int(np.floor(places.min()))
    if last - first > MOST_SLICES:
        raise LimitError(
            "step", f"needs {last - first:,} slices, at most {MOST_SLICES:,} are drawn", "take a larger step, or the march"
        )
    last = max(first, last)
    return Numbers(first, last, driver.group, (first, last) if planes is None else _shown_between(frame, planes, first, last))


def _shown_between(frame: MarchFrame, planes: Planes, first: int, last: int) -> tuple[int, int]:
    """Numbers of planes between which all lies that may be seen, among those from first to last."""
    places = ((shown_in(frame) - frame.anchor_world) @ planes.normal - planes.first) / planes.spacing_world
    skin = skin_world(frame) / planes.spacing_world
    begin, end = (int(np.clip(place, first, last)) for place in (np.floor(places.min() - skin), np.ceil(places.max() + skin)))
    return begin, max(begin, end)


def _distance_to_box(corners: FloatArray, point: FloatArray) -> float:
    """Distance of a point to the axis-aligned box round corners (n, 3), 0 inside: at most that to what they bound."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    return float(np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0)))


def corners_of(frame: MarchFrame) -> FloatArray:
    """Corners (n, 3) of the domains of all layers in the user's world."""
    return np.concatenate([layer.context.volume.corners_world(layer.field.cells) for layer in frame.layers])


def _corners(frame: MarchFrame) -> FloatArray:
    """Corners (n, 3) of the domains of all layers in the device's world."""
    return np.asarray(corners_of(frame) - frame.anchor_world)


def shown_in(frame: MarchFrame) -> FloatArray:
    """Points (n, 3) of the user's world between which all lies that may be seen: corners of blocks, or those of the domains."""
    if getattr(frame.scene_stages["integrate"], "fills", False):
        return corners_of(frame)
    leaps = all("leaps" in layer.resources["field"] for layer in frame.layers)
    shown = [corners_world(frame, layer).reshape(-1, 3) for layer in frame.layers] if leaps else []
    return np.concatenate(shown) if any(map(len, shown)) else corners_of(frame)


def hull_of(frame: MarchFrame) -> Polyhedron:
    """What may show something, in the device's world: the box of the blocks that do, or that of all layers."""
    shift = np.eye(4)
    shift[:3, 3] = -frame.anchor_world
    layer = frame.layers[0]
    skin = skin_world(frame)
    if len(frame.layers) > 1:
        corners = _corners(frame)
        return inflated(box(corners.min(axis=0), corners.max(axis=0), np.eye(4)), skin)
    volume = layer.context.volume
    low, high = domain_index(volume.size, layer.field.cells)
    if "leaps" in layer.resources["field"] and not getattr(frame.scene_stages["integrate"], "fills", False):
        seen = corners_world(frame, layer).reshape(-1, 3)
        p_index = seen @ volume.index_from_world[:3, :3].T + volume.index_from_world[:3, 3]
        if len(p_index):
            low, high = np.maximum(low, p_index.min(axis=0)), np.minimum(high, p_index.max(axis=0))
    return inflated(box(low, high, shift @ volume.world_from_index), skin)


def pieces_in(frame: MarchFrame, planes: Planes | None, numbers: Numbers) -> Pieces:
    """Proxy of each group: triangles that cover all that it may show."""
    edges = np.array([begin for begin, _ in numbers.groups] + [numbers.shown[1]], dtype=np.float64)
    hull = hull_of(frame)
    if planes is not None:
        return pieces_of(hull, planes.normal, planes.first + edges * planes.spacing_world)
    camera: Any = frame.scene_stages["camera"]
    if isinstance(camera, Orthographic):
        forward = camera.basis()[2]
        return pieces_of(hull, forward, float(forward @ np.asarray(camera.eye)) + edges * frame.step_world)
    return shell_pieces(hull, np.asarray(camera.eye), edges * frame.step_world)


class Beside(Protocol):
    """What goes on beside a sweep, group by group: its program looks at ``outputs`` and has the uniforms ``extra``."""

    extra: tuple[str, ...]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of what the program looks at."""
        ...

    def begin(self, planes: Planes | None, ends: Sequence[tuple[int, int]]) -> dict[str, Any]:
        """Take note of the planes, and of the first and last sample of each group, in the order in which they are drawn.

        Returns values for the uniforms until ``carry`` tells others.
        """
        ...

    def looked_at(self) -> dict[str, Any]:
        """Return what the passes of groups look at."""
        ...

    def start(self) -> None:
        """Begin a sweep; there is one for each part of the image."""
        ...

    def carry(self, turn: int) -> dict[str, Any]:
        """Do what comes before a group, by its turn; return values of its uniforms."""
        ...


def sweep_program(frame: MarchFrame, beside: Beside | None = None) -> Program:
    """Program of the passes over groups."""
    check_sweep(frame)
    check_refines(frame)
    check_layers(frame)
    outputs = ("unfinished", *looked_at(frame), *(beside.outputs if beside else ()))
    extra = ("group", *_planar(frame.once(planes_of)), *(beside.extra if beside else ()))
    program = frame.program(frame.scene_stages["driver"].wgsl, outputs, extra, **late_tones(frame))
    check_textures(frame, program)
    return program


def _planar(planes: Planes | None) -> tuple[str, ...]:
    """Uniforms of planes, where samples lie on some."""
    return () if planes is None else ("planes",)


def draw_groups(frame: MarchFrame, bands: Sequence[Band], beside: Beside | None = None) -> None:
    """Draw all groups of slices of bands of rows, and finish their pixels."""
    device = frame.device
    with frame.clock("link and compile"):
        planes = frame.once(planes_of)
        program = sweep_program(frame, beside)
        pipeline = raster.sweep_pipeline(device, program)
        # Nothing is lit any more: what goes on beside is not asked.
        instead = late_tones(frame) | ({} if beside is None else {"visibility": NoOcclusion()})
        outputs = ("unfinished", "radiance", "depth", *looked_at(frame))
        finish = frame.program("passes/finished.wgsl", outputs, _planar(planes), **instead)
        bytes_per_pixel = size_in(program.linked.text, "Unfinished")
    with frame.clock("proxies"):
        numbers = frame.once(numbers_of)
        pieces = pieces_in(frame, planes, numbers)
        order = list(enumerate(numbers.groups))
        order = order[::-1] if frame.scene_stages["driver"].back_to_front else order  # type: ignore[attr-defined]
        order = [(n, ends) for n, ends in order if pieces.first[n + 1] > pieces.first[n]]
        vertices = raster.write_corners(device, "corners of sweep", pieces.corners)
        near, far = depths_between(pieces.corners.reshape(-1, 3), frame)
    with frame.clock("upload"):
        values = uploaded(frame, program)
        if planes is not None:
            values["planes"] = PlaneUniforms(tuple(planes.normal), planes.first, planes.spacing_world, planes.measured)
        if beside is not None:
            values |= beside.begin(planes, [ends for _, ends in order])
    tiles = [list(tiles_of(frame, band, bytes_per_pixel // 4)) for band in bands]
    total, done = len(order) * sum(map(len, tiles)), 0
    pace: Pace = device.kept.get(("pace", program.key, frame.step_world), Pace)
    extra = written_clips(frame)
    for band, parts in zip(bands, tiles, strict=True):
        read = extra | drawn_meshes(frame, band)
        for tile in parts:
            size = tile.width * tile.height * bytes_per_pixel
            state = compute.storage_buffer(device, "unfinished", size)
            raster.clear_buffer(device, state, size)
            part = band.uniforms(tile)
            some = values | {"group": GroupUniforms(0.0, 1.0, near, far)}
            found = {} if beside is None else beside.looked_at()
            data = pack_uniforms(program, part, some)
            groups = bound_groups(frame, pipeline, {"unfinished": state} | read | found, "sweep", data)
            target = device.kept.find(("buffer", "uniforms of sweep"))
            if beside is not None:
                beside.start()
            waiting, start = 0, time.perf_counter()
            for turn, (n, (begin, end)) in enumerate(order):
                frame.check()
                told = {} if beside is None else beside.carry(turn)
                some = values | {"group": GroupUniforms(float(begin), float(end), near, far)} | told
                device.queue.write_buffer(target, 0, pack_uniforms(program, part, some))
                triangles = slice(int(pieces.first[n]), int(pieces.first[n + 1]))
                raster.draw_some(device, pipeline, groups, (tile.width, tile.height), vertices, triangles)
                done, waiting = done + 1, waiting + tile.width * tile.height
                if waiting < pace.pixels() and (n, (begin, end)) != order[-1]:
                    continue
                device.wait()
                pace.learn(waiting, time.perf_counter() - start)
                waiting, start = 0, time.perf_counter()
                frame.progress("render", done, total)
            _finish(frame, finish, band, tile, {"unfinished": state} | read, pack_uniforms(finish, part, values))


def slice_statistics(frame: MarchFrame) -> dict[str, Any]:
    """What ``image.stats`` says of slices: how many there are, how far apart, in how many groups, and in which order."""
    driver = frame.scene_stages["driver"]
    assert isinstance(driver, SliceDriver)
    planes, numbers = frame.once(planes_of), frame.once(numbers_of)
    spacing = frame.step_world if planes is None else planes.spacing_world
    order = "back to front" if driver.back_to_front else "front to back"
    if driver.back_to_front and hasattr(frame.scene_stages["integrate"], "opaque_at"):
        order += ", without depth"  # where opacity passes one half is seen from the front alone
    count = numbers.last - numbers.first + 1
    return {"slices": {"count": count, "groups": len(numbers.groups), "order": order, "spacing_world": spacing}}


def _finish(frame: MarchFrame, program: Program, band: Band, tile: Tile, resources: dict[str, Any], data: bytes) -> None:
    device = frame.device
    pipeline = compute.pipeline_of(device, program)
    looked_at = resources | {"radiance": band.radiance, "depth": band.depth}
    groups = bound_groups(frame, pipeline, looked_at, "finished", data)
    compute.dispatch_pixels(device, pipeline, groups, tile.width, tile.height)
