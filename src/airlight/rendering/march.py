"""The march driver: its program, and the bands and tiles in which it runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar
from weakref import proxy

import numpy as np

from ..clips import Clip, Solid
from ..environment import Environment
from ..errors import StageError
from ..gpu import compute
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..gpu.tiles import FIRST_TILE_PIXELS, Pace, Tile, run_tiles, tiles
from ..handed import COLOUR, DEPTH, PIXEL_BYTES
from ..scene import Scene
from ..shader.link import parse, stage_source
from ..shader.program import (
    CHOSEN_WIDTH,
    FrameUniforms,
    Program,
    ProgramKey,
    Switches,
    build_program,
    stage_key,
)
from ..stage import Resource, Stage
from ..stages import tone as tones
from ..stages.blocks import block_bounds, block_leaps
from ..stages.driver import gains_from_curvature, may_lengthen
from ..stages.driver_slices import SliceDriver
from ..stages.field import Linear, LinearExact
from ..stages.passes import Pass
from ..stages.transfer import Transfer
from ..volume import FloatArray
from .bounding import reaches
from .clips import first_clips, pack_clips
from .covers import Covers
from .hits import HIT_BYTES, Hits
from .layers import check_layers, check_textures, marched_apart
from .outlines import Outlines
from .resources import DrawnLayer, bound_resources, light_count, pack_uniforms, told_leaps, uniform_values, write_lights
from .shown import IntArray, shown_columns

T = TypeVar("T")

SAME_STEP = 1e-6  # of a voxel
TRILINEAR = (Linear, LinearExact)
SKIN_VOXELS = 4.0  # of what lies behind the face of a cut and is lit as that is
FAR = 3.4e38  # as devices hold it, where nothing is met


class Clock:
    """Milliseconds by name; what runs inside another block counts for itself alone, so that the parts add up."""

    def __init__(self) -> None:
        self.milliseconds: dict[str, float] = {}
        self._inner: list[float] = []

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time a block."""
        start = time.perf_counter()
        self._inner.append(0.0)
        try:
            yield
        finally:
            spent = 1e3 * (time.perf_counter() - start)
            self.milliseconds[name] = self.milliseconds.get(name, 0.0) + spent - self._inner.pop()
            if self._inner:
                self._inner[-1] += spent


@dataclass(frozen=True, eq=False)
class MarchFrame:
    """What the passes of one frame share. ``chosen`` are pixels (n, 2), x and y: no others are drawn; None is all."""

    device: Device
    scene: Scene
    given: Scene
    scene_stages: Mapping[str, Stage]
    layers: tuple[DrawnLayer, ...]
    size_px: tuple[int, int]
    step_world: float
    t_offset_world: float
    anchor_world: FloatArray
    skip: str
    check: Callable[[], None]
    progress: Progress
    clock: Clock = field(default_factory=Clock)
    measured: dict[str, float] = field(default_factory=dict)
    keeps_hits: bool = False
    found: Hits | None = None
    clip_groups: tuple[tuple[Clip, ...], ...] = ((),)
    chosen: IntArray | None = None
    kept_hits: list[np.ndarray[Any, Any]] = field(default_factory=list)
    passes: tuple[Pass, ...] = ()
    shared: dict[str, Any] = field(default_factory=dict)
    ran: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)

    def stages_of(self, layer: DrawnLayer) -> dict[str, Stage]:
        """Return all stages that draw a layer: its own, and those that belong to none."""
        return {**self.scene_stages, **layer.stages}

    @property
    def scene_resources(self) -> dict[str, Mapping[str, Resource]]:
        """Resources of the stages that belong to no layer."""
        return {slot: stage.resources(self.layers[0].context) for slot, stage in self.scene_stages.items()}

    @property
    def clips(self) -> tuple[Clip, ...]:
        """Clips that cut something, those of all layers first."""
        return tuple(clip for group in self.clip_groups for clip in group)

    @property
    def met_clips(self) -> tuple[tuple[Clip, ...], ...]:
        """Groups of clips as rays meet them: layers that are marched apart have all that cut them in their own."""
        shared, *own = self.clip_groups
        return ((), *(shared + group for group in own)) if own and marched_apart(self.layers) else self.clip_groups

    @cached_property
    def covers(self) -> Covers:
        """Meshes, and what rays meet of them."""
        return Covers(proxy(self))  # no ring, which would keep volumes until garbage is collected

    @cached_property
    def outlines(self) -> Outlines:
        """Closed meshes that clip."""
        return Outlines(proxy(self))

    @property
    def shows_environment(self) -> bool:
        """Whether an environment is seen behind the layers."""
        return isinstance(self.scene.background, Environment)

    @property
    def tones_late(self) -> bool:
        """Whether tones are mapped in a pass of their own, once the whole scene is there."""
        early = any(one.over == "scene" or "luminance" in one.reads for one in self.passes)
        adds = getattr(self.scene_stages["driver"], "adds_lights", False) and len(self.given.lights) > 1
        return self.shows_environment or early or adds or bool(self.scene_stages["tone"].reads)

    def once(self, make: Callable[..., T], *given: Hashable) -> T:
        """Return what a function makes of the frame and of what is given beside it; it is made once."""
        made: dict[Any, T] = self.__dict__.setdefault("_made", {})
        if (make, given) not in made:
            made[make, given] = make(self, *given)
        return made[make, given]

    def program(self, root: str | Path, outputs: tuple[str, ...], extra: tuple[str, ...] = (), **instead: Stage) -> Program:
        """Program of a root with the frame's stages, some replaced."""
        return build_program(program_key(self, root, outputs, extra, **instead))


def program_key(
    frame: MarchFrame, root: str | Path, outputs: tuple[str, ...], extra: tuple[str, ...] = (), **instead: Stage
) -> ProgramKey:
    """Key of the program for a frame."""
    resources = frame.scene_resources
    scene = tuple(
        (slot, stage_key(instead.get(slot, stage), resources[slot]))
        for slot, stage in frame.scene_stages.items()
        if slot not in frame.layers[0].stages
    )
    layers = tuple(
        tuple((slot, stage_key(s, layer.resources[slot], s.variant(layer.context))) for slot, s in layer.stages.items())
        for layer in frame.layers
    )
    groups = tuple(layer.field.groups(layer.context) for layer in frame.layers)
    lights = light_count(frame.scene.lights)
    several = groups if len(groups) > 1 else ()
    switches = frame.once(switches_of)
    return ProgramKey(root, scene, layers, outputs, extra, switches, frame.device.traits, max(groups), lights, several)


def has_empty(layer: DrawnLayer) -> bool:
    """Whether the layer's function leaves some slabs empty."""
    transfer = layer.stages["transfer"]
    return isinstance(transfer, Transfer) and transfer.has_empty(layer.context)


def switches_of(frame: MarchFrame) -> Switches:
    """What the stages and the data say of each other, and a driver can make use of."""
    integrate = frame.scene_stages["integrate"]
    classifies = bool(getattr(integrate, "classifies", True))
    lit = any(layer.stages["lighting"].name != "unlit" for layer in frame.layers)
    leaps = [told_leaps(layer) for layer in frame.layers]
    has_stretches = any(has_empty(layer) and not layer.is_full for layer in frame.layers) or any(leaps)
    skips_empty = bool(getattr(integrate, "skips_empty", False)) and frame.skip != "none" and has_stretches
    know_more = any(one is not None and not one.known_to_slabs for one in leaps)
    return Switches(
        has_empty=any(layer.field.masked for layer in frame.layers),
        skips_empty=skips_empty,
        surfaces_only=bool(getattr(integrate, "surfaces_only", False)),
        classifies=classifies,
        curved=is_curved(frame),
        lights_ends=any(getattr(layer.stages["lighting"], "lights_ends", False) for layer in frame.layers),
        skips_blocks=any(leaps),
        fills=bool(getattr(integrate, "fills", False)),
        blocks_know_more=know_more,
        hides=know_more or any(declares(layer.stages["region"], "hidden_at") for layer in frame.layers),
        walks_blocks=walks_blocks(frame),
        walks_cells=walks_blocks(frame) and refine_of(frame) == "cells",
        has_crossings=classifies and any(offers_crossings(layer) for layer in frame.layers),
        lights_faces=bool(frame.clips) and lit,
        draws_caps=draws_caps(frame),
        adaptive=is_adaptive(frame),
        lit=classifies and lit,
        crosses_even=any(layer.is_even for layer in frame.layers),
        in_parts=isinstance(frame.scene_stages["driver"], SliceDriver),
        cuts_at_covers=frame.covers.cut_slabs,
        cuts_layers=len(frame.clip_groups) > 1,
    )


def with_blocks(layer: DrawnLayer, integrate: Stage) -> DrawnLayer:
    """Return a layer whose field is asked, too, in which blocks nothing is to be seen, where its stages tell."""
    stages, context = layer.stages, layer.context
    moves = gains_from_curvature({**stages, "integrate": integrate}) and not declares(stages["transfer"], "held")
    told = {"leaps": block_leaps(stages, integrate, context, moves), "bounds": block_bounds(stages, integrate, context)}
    asked = {name: resource for name, resource in told.items() if resource is not None}
    return replace(layer, resources={**layer.resources, "field": {**layer.resources["field"], **asked}})


def offers_crossings(layer: DrawnLayer) -> bool:
    """Whether the layer's transfer stage tells surfaces at which slabs are cut."""
    return declares(layer.stages["transfer"], "next_crossing")


def declares(stage: Stage, function: str) -> bool:
    """Whether a stage has an optional part of its slot."""
    return function in parse(stage_source(stage.wgsl, stage.name)).declared


def draws_caps(frame: MarchFrame) -> bool:
    """Whether some cut is drawn as a solid face: what attenuates nothing has none."""
    integrate = frame.scene_stages["integrate"]
    attenuates = getattr(integrate, "uses_slabs", True) and getattr(integrate, "classifies", True)
    return attenuates and any(clip.capped for clip in frame.clips)


def is_adaptive(frame: MarchFrame) -> bool:
    """Whether slabs get longer where little gets through: of one layer."""
    asked = bool(getattr(frame.scene_stages["driver"], "adaptive", False)) and len(frame.layers) == 1
    layer = frame.layers[0]
    return asked and may_lengthen(frame.stages_of(layer), layer.context.transfer, layer.context.labels)


def is_curved(frame: MarchFrame) -> bool:
    """Whether values are put right for curvature: asked of the driver, and of use to all layers."""
    asked = bool(getattr(frame.scene_stages["driver"], "curved", False)) and not walks_blocks(frame)
    return asked and all(gains_from_curvature(frame.stages_of(layer)) for layer in frame.layers)


def walks_blocks(frame: MarchFrame) -> bool:
    """Whether surfaces are looked for block by block; those of several layers are on the lattice that they share.

    Surfaces of the function are where steps are longer than a voxel.
    """
    integrate, layer = frame.scene_stages["integrate"], frame.layers[0]
    if len(frame.layers) > 1 or not getattr(frame.scene_stages["driver"], "blocks", False):
        return False
    is_coarse = frame.step_world > (1 + SAME_STEP) * min(layer.context.volume.spacing)
    are_cut = bool(getattr(integrate, "classifies", True)) and offers_crossings(layer) and is_coarse
    return are_cut or bool(getattr(integrate, "surfaces_only", False))


def refine_of(frame: MarchFrame) -> str:
    """Return how the driver sharpens the places of surfaces."""
    return str(getattr(frame.scene_stages["driver"], "refine", "none"))


def check_refines(frame: MarchFrame) -> None:
    """Refuse roots of cubics where the field is no cubic along a ray, and those of all cells where rays go from step to step.

    Raises
    ------
    StageError
        For ``exact`` and ``cells`` where fields are not trilinear; for ``cells`` but for the first hit of one volume in blocks.
    """
    switches, refine = frame.once(switches_of), refine_of(frame)
    if refine not in ("exact", "cells") or not (switches.surfaces_only or switches.has_crossings):
        return
    where = f'driver.refine "{refine}"'
    for layer in frame.layers:
        if not isinstance(layer.field, TRILINEAR):
            raise StageError(where, f"is for trilinear fields, and {layer.field.name} is none", "use secant")
    if refine == "cells" and not (switches.surfaces_only and switches.walks_blocks):
        what = "looks through blocks for the first hit of one volume, and here rays go from step to step"
        raise StageError(where, what, "use exact, or first_hit with blocks=True")


def march_program(frame: MarchFrame) -> Program:
    """Program of the march; a tone stage that looks at the whole image first gets a pass of its own."""
    check_refines(frame)
    check_layers(frame)
    wanted = {"hits": frame.keeps_hits, "chosen": frame.chosen is not None}
    wanted |= dict.fromkeys(("reach_first", "reach_last"), frame.skip == "geometry")
    outputs = ("radiance", "depth", *looked_at(frame), *(name for name, is_wanted in wanted.items() if is_wanted))
    program = frame.program(frame.scene_stages["driver"].wgsl, outputs, (), **late_tones(frame))
    check_textures(frame, program)
    return program


def looked_at(frame: MarchFrame) -> tuple[str, ...]:
    """Names of what rays look at beside layers: clips, outlines of meshes that clip, and meshes."""
    outlined = any(isinstance(clip, Solid) for clip in frame.clips)
    wanted = {"covers": frame.covers.meshes, "clips": frame.clips, "changes": outlined}
    return tuple(name for name, is_wanted in wanted.items() if is_wanted)


def late_tones(frame: MarchFrame) -> dict[str, Stage]:
    """What stands in for the tone stage where tones are mapped in a pass of their own."""
    return {"tone": tones.Linear()} if frame.tones_late else {}


class Band:
    """Rows of an image whose pixels fit into one binding."""

    def __init__(self, frame: MarchFrame, number: int, first_row: int, rows: int) -> None:
        width = frame.size_px[0]
        self.first_row, self.rows, self.pixels = first_row, rows, rows * width
        self.number = number
        self.pictures = {
            name: compute.storage_buffer(frame.device, ("band", name, number), self.pixels * PIXEL_BYTES[kind.wgsl])
            for name, kind in (("radiance", COLOUR), ("depth", DEPTH))
        }
        self.spare: dict[str, Any] = {}
        if frame.keeps_hits or frame.found is not None:
            self.hits = compute.storage_buffer(frame.device, ("band", "hits", number), self.pixels * HIT_BYTES)
        self.frame = frame

    @property
    def radiance(self) -> Any:
        """Buffer of colours and opacities."""
        return self.pictures["radiance"]

    @property
    def depth(self) -> Any:
        """Buffer of depths and samples."""
        return self.pictures["depth"]

    def other(self, name: str, pixel_bytes: int) -> Any:
        """Return a buffer for a picture of this name that is not the one it has."""
        if name in self.spare:
            return self.spare[name]
        key = ("band", name, self.number) + (("other",) if name in self.pictures else ())
        return compute.storage_buffer(self.frame.device, key, self.pixels * pixel_bytes)

    def put(self, name: str, picture: Any) -> None:
        """Take a picture of this name; what it was before may be written over."""
        if name in self.pictures:
            self.spare[name] = self.pictures[name]
        self.pictures[name] = picture

    def uniforms(self, tile: Tile | None = None, **told: Any) -> FrameUniforms:
        """Return the frame's own uniforms for these rows, of which a dispatch draws a tile, if any."""
        if tile is not None:
            told |= {"tile_origin_px": (tile.x, tile.y), "tile_size_px": (tile.width, tile.height)}
        return FrameUniforms(
            **told,
            size_px=self.frame.size_px,
            band_first_row=self.first_row,
            band_rows=self.rows,
            step_world=self.frame.step_world,
            t_offset_world=self.frame.t_offset_world,
            strands=self.frame.device.strands,
            skin_world=SKIN_VOXELS * min(min(layer.context.volume.spacing) for layer in self.frame.layers),
            cover_count=self.frame.covers.layers * self.frame.covers.see_through,
            change_slots=self.frame.outlines.slots + 1,
        )

    def chosen_rows(self) -> np.ndarray[Any, Any]:
        """Return the chosen pixels of these rows, uint32 (n, CHOSEN_WIDTH), x below y; the last one fills the rest."""
        assert self.frame.chosen is not None
        x, y = self.frame.chosen.T
        inside = (y >= self.first_row) & (y < self.first_row + self.rows)
        packed = (x[inside] | y[inside] << 16).astype(np.uint32)
        rest = -len(packed) % CHOSEN_WIDTH if len(packed) else 0
        return np.pad(packed, (0, rest), mode="edge" if len(packed) else "constant").reshape(-1, CHOSEN_WIDTH)

    def clear(self) -> None:
        """Fill it as pixels are that show nothing."""
        compute.clear(self.frame.device, self.radiance)
        compute.repeat(self.frame.device, np.array([FAR, 0.0], dtype=np.float32), self.pixels, self.depth)

    def read(self, rgba: np.ndarray[Any, Any], depth: np.ndarray[Any, Any]) -> None:
        """Read the rows back into those of an image."""
        part = slice(self.first_row, self.first_row + self.rows)
        compute.read_into(self.frame.device, [(self.radiance, rgba[part]), (self.depth, depth[part])])

    def read_hits(self) -> np.ndarray[Any, Any]:
        """Read back what was kept at surfaces."""
        data = self.frame.device.queue.read_buffer(self.hits, 0, self.pixels * HIT_BYTES)
        return np.frombuffer(data, dtype=np.float32).reshape(self.rows, self.frame.size_px[0], HIT_BYTES // 4)


def bound_groups(
    frame: MarchFrame, pipeline: compute.Pipeline, buffers: Mapping[str, Any], name: str, data: bytes
) -> list[Any]:
    """Bind groups of a pass: what its layers look at, buffers, lights, and uniforms under a name."""
    device, program = frame.device, pipeline.program
    resources = {
        **frame.once(views_of, program),
        **buffers,
        "uniforms": compute.write_uniforms(device, f"uniforms of {name}", data),
        "lights": write_lights(device, frame.scene.lights),
    }
    return compute.bind_groups(device, pipeline, resources)


def uploaded(frame: MarchFrame, program: Program) -> dict[str, Any]:
    """Values of the uniforms of a driver's program, of which all resources are on the device then."""
    device = frame.device
    values = uniform_values(device, frame.scene_stages, frame.layers, frame.anchor_world, frame.progress)
    frame.once(views_of, program)
    for number, first in enumerate(first_clips(frame.met_clips)[1:-1]):
        values[f"layer_{number}"] = replace(values[f"layer_{number}"], first_clip=first)
    return values | late_tones(frame)


def views_of(frame: MarchFrame, program: Program) -> dict[str, Any]:
    """Views and samplers of what the frame's stages let a program look at."""
    return bound_resources(frame.device, program, frame.layers, frame.scene_resources, frame.anchor_world, frame.progress)


def written_clips(frame: MarchFrame) -> dict[str, Any]:
    """Buffer of the clips, where there are some."""
    if not frame.clips:
        return {}
    world_from_device = np.eye(4)
    world_from_device[:3, 3] = frame.anchor_world
    packed = pack_clips(frame.met_clips, world_from_device, frame.outlines.solids)
    return {"clips": compute.write_storage(frame.device, "clips", packed)}


def drawn_meshes(frame: MarchFrame, band: Band) -> dict[str, Any]:
    """Buffers of what the rays of a band meet of meshes, those that clip and those that are seen."""
    found = {}
    if frame.outlines.solids:
        with frame.clock("clips"):
            found = {"changes": frame.outlines.draw(band)}
    if frame.covers.meshes:
        with frame.clock("meshes"):
            found |= {"covers": frame.covers.draw(band, found)}
    return found


def march_rays(frame: MarchFrame, bands: list[Band]) -> None:
    """Draw bands of rows by a ray a pixel."""
    device = frame.device
    with frame.clock("link and compile"):
        program = march_program(frame)
        pipeline = compute.pipeline_of(device, program)
    with frame.clock("upload"):
        values = uploaded(frame, program)
    x, y = program.key.group_px
    sizes = tuple(layer.context.volume.size for layer in frame.layers)
    step = frame.step_world / min(min(layer.context.volume.spacing) for layer in frame.layers)
    # Small steps take long, and where they are asked for the quick pixels are done already.
    first = max(64, int(FIRST_TILE_PIXELS * min(step, 1.0)))
    pace: Pace = device.kept.get(("pace", program.key, frame.step_world, sizes), lambda: Pace(first))
    total = frame.size_px[0] * frame.size_px[1] if frame.chosen is None else len(frame.chosen)
    before = 0
    shown = shown_columns(frame) if frame.chosen is None else None
    extra = written_clips(frame)
    for band in bands:
        if shown is not None or frame.chosen is not None:
            band.clear()
        rows = band.chosen_rows() if frame.chosen is not None else None
        if rows is not None and not rows.size:
            continue
        if rows is not None:
            extra["chosen"] = compute.write_storage(device, "chosen", rows.tobytes())
        groups = bound_groups(
            frame,
            pipeline,
            {"radiance": band.radiance, "depth": band.depth}
            | extra
            | drawn_meshes(frame, band)
            | reaches(frame, band)
            | ({"hits": band.hits} if frame.keeps_hits else {}),
            "march",
            pack_uniforms(program, band.uniforms(), values),
        )
        target = device.kept.find(("buffer", "uniforms of march"))

        def submit(tile: Tile, band: Band = band, groups: list[Any] = groups, target: Any = target) -> None:
            part = band.uniforms(tile)
            device.queue.write_buffer(target, 0, pack_uniforms(program, part, values))
            rows = device.strands * -(-tile.height // (y * device.strands))
            compute.dispatch(device, pipeline, groups, (-(-tile.width // x), rows, 1))

        def done(pixels: int, before: int = before) -> None:
            frame.progress("render", min(before + pixels, total), total)

        parts = tiles(shown.width if shown else frame.size_px[0], band.first_row, band.rows, pace, y)
        if rows is not None:
            parts = tiles(CHOSEN_WIDTH, 0, len(rows), pace, y)
        if shown is not None:
            parts = shown.trimmed(parts)
        run_tiles(device, parts, submit, pace, frame.check, done)
        before += band.pixels if rows is None else min(rows.size, total - before)
        frame.progress("render", before, total)
