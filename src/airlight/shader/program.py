"""Programs: what the host declares for a driver and its stages, linked with them into one text.

Everything that the host knows reaches WGSL through ``import generated::...``: parameters of stages as members of one uniform
struct, static fields as constants, textures and tables with their bindings. Bind groups: 0 frame, 1 layers, 2 tables, 3 pass.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from ..errors import StageError
from ..stage import (
    BLOCK_VOXELS,
    BOUND_GROUP_VOXELS,
    BOUND_VOXELS,
    F32,
    I32,
    MOST_LEAP,
    SLOTS,
    U32,
    BlockBounds,
    BlockLeaps,
    Bool,
    ClassifiedGrid,
    DirectionGrid,
    GradientEncoding,
    GradientGrid,
    Grid,
    LabelCells,
    LitDirections,
    Mat3f,
    Mat4f,
    OpennessGrid,
    Resource,
    ShadowGrid,
    SlabTable,
    Stack,
    Stage,
    Table,
    Vec2u,
    Vec3f,
    Vec3u,
    Vec4f,
    param,
    stage_fields,
    uniform_fields,
)
from .layout import Struct, class_struct, make_struct
from .link import Generated, Linked, link, package_source, parse, stage_source

LUMINANCE_SUMS = 4096
SURROUND_STEPS = 24  # of luminance, in which it is averaged round pixels
CHOSEN_WIDTH = 256  # pixels to a row of a list of them


@dataclass(frozen=True)
class FrameUniforms:
    """The image, the part of it that a dispatch draws, and the step."""

    size_px: Vec2u = param((1, 1), unit="px")
    tile_origin_px: Vec2u = param((0, 0), unit="px")
    tile_size_px: Vec2u = param((1, 1), unit="px")
    band_first_row: U32 = param(0, unit="px")
    band_rows: U32 = param(1, unit="px")
    step_world: F32 = param(1.0, unit="world")
    strands: U32 = param(1)  # into so many sets of rows, dealt out in turn, a dispatch is cut
    t_offset_world: F32 = param(0.0, unit="world")
    cover_count: U32 = param(0)
    skin_world: F32 = param(0.0, unit="world")
    fragment_slots: U32 = param(0)
    change_slots: U32 = param(0)


@dataclass(frozen=True, eq=False)
class LayerUniforms:
    """The grid of a layer, its place in the world, and how its texels become values.

    Matrices have a column for each group of a value, and in it a row for each channel of the group.
    """

    index_from_world: Mat4f = param(None)
    gradient_world_from_index: Mat3f = param(None)
    size: Vec3f = param((1.0, 1.0, 1.0), unit="voxel")
    inverse_size: Vec3f = param((1.0, 1.0, 1.0), unit="1/voxel")
    domain_low: Vec3f = param((0.0, 0.0, 0.0), unit="voxel")
    domain_high: Vec3f = param((0.0, 0.0, 0.0), unit="voxel")
    value_scale: F32 = param(1.0, unit="data")
    value_offset: F32 = param(0.0, unit="data")
    channel_scale: Mat4f = param(None, unit="data")
    channel_offset: Mat4f = param(None, unit="data")
    first_clip: U32 = param(0)  # of those that cut this layer alone
    stack_axis: U32 = param(2)  # along which its layers of 2-D textures lie, if it is read from such


@dataclass(frozen=True)
class LightRecord:
    """A light as the device sees it; ``radius`` 0 means without fall-off."""

    kind: U32 = param(0)
    rgb: Vec3f = param((1.0, 1.0, 1.0), unit="radiance")
    vector: Vec3f = param((0.0, 0.0, 1.0), unit="world")
    radius: F32 = param(0.0, unit="world")


@dataclass(frozen=True)
class ClipRecord:
    """A clip as the device sees it: rows of the way to where its shape is that of its kind; see ``airlight.clips``.

    They lie in groups, those of all layers first: each tells where its own ends, and a mesh which of the outlines is its own.
    """

    x: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="1/world")
    y: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="1/world")
    z: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="1/world")
    kind: U32 = param(0)
    keeps_inside: Bool = param(True)
    capped: Bool = param(False)
    cuts: U32 = param(0)
    list: U32 = param(0)
    end: U32 = param(0)


@dataclass(frozen=True)
class LuminanceUniforms:
    """What the luminance pass found."""

    log_average: F32 = param(0.0, unit="radiance")


@dataclass(frozen=True)
class SurroundUniforms:
    """Cells of pixels and steps of luminance in which it is averaged round pixels; ``middle_stops`` is the steps' middle."""

    cells: Vec2u = param((1, 1))
    cell_px: U32 = param(1, unit="px")
    middle_stops: F32 = param(0.0, unit="stop")
    step_stops: F32 = param(1.0, unit="stop")


@dataclass(frozen=True)
class PlaneUniforms:
    """Planes ``dot(normal, p) = first + k * spacing_world`` at which samples lie; see ``airlight.stages.driver_slices``."""

    normal: Vec3f = param((0.0, 0.0, 1.0))
    first: F32 = param(0.0, unit="world")
    spacing_world: F32 = param(1.0, unit="world")
    is_measured: Bool = param(True)


@dataclass(frozen=True)
class GroupUniforms:
    """The slabs of a sweep that a pass draws, from sample ``first`` to ``last``, and the depths between which it sees."""

    first: F32 = param(0.0)
    last: F32 = param(1.0)
    near_world: F32 = param(0.0, unit="world")
    far_world: F32 = param(1.0, unit="world")


@dataclass(frozen=True)
class PictureUniforms:
    """The first row of what a pass sees of a picture, and how far it looks."""

    first_row: I32 = param(0, unit="px")
    reach_px: I32 = param(0, unit="px")


@dataclass(frozen=True, eq=False)
class LampUniforms:
    """A light that passes a group of slices: its buffer, its picture, and its planes, ``1/per_world`` apart from ``first`` on.

    ``right`` and ``up`` span what lies across its rays; ``spread_world`` is by how much light goes aside that spreads at an
    angle of 45 degrees.
    """

    light_from_world: Mat4f = param(None)
    picture_from_world: Mat4f = param(None)
    normal: Vec3f = param((0.0, 0.0, 1.0))
    first: F32 = param(0.0, unit="world")
    right: Vec3f = param((1.0, 0.0, 0.0))
    per_world: F32 = param(1.0, unit="1/world")
    up: Vec3f = param((0.0, 1.0, 0.0))
    spread_world: F32 = param(0.0, unit="world")
    ambient: F32 = param(1.0)
    begins: Vec4f = param((1.0, 1.0, 1.0, 1.0))


@dataclass(frozen=True)
class SliceUniforms:
    """The first of the slices of voxels that a dispatch computes."""

    first_z: U32 = param(0, unit="voxel")


@dataclass(frozen=True)
class SteepUniforms:
    """The gradient from which on voxels have a direction."""

    threshold: F32 = param(0.0, unit="data/world")


@dataclass(frozen=True)
class ClassifyUniforms:
    """Whether colours of voxels are kept times their extinction."""

    weighs: Bool = param(False)


@dataclass(frozen=True, eq=False)
class OcclusionUniforms:
    """Cells of voxels, and the rays that look round from them."""

    block: Vec3u = param((1, 1, 1), unit="voxel")
    cells: Vec3u = param((1, 1, 1))
    spacing: Vec3f = param((1.0, 1.0, 1.0), unit="world")
    cells_from_world: Mat3f = param(None, unit="cell/world")
    cell_world: F32 = param(1.0, unit="world")
    directions: U32 = param(1)
    tint: F32 = param(0.0)


@dataclass(frozen=True, eq=False)
class ShadowUniforms:
    """A light as cells see it, and the cells that a dispatch looks at; those are counted with one more all round.

    ``light`` is where it is, with 1, or the direction towards it, with 0. A sweep goes against ``towards`` along ``axis``.
    """

    light: Vec4f = param((0.0, 0.0, 1.0, 0.0), unit="cell")
    low: Vec3f = param((0.0, 0.0, 0.0), unit="cell")
    high: Vec3f = param((1.0, 1.0, 1.0), unit="cell")
    world_from_cells: Mat3f = param(None, unit="world/cell")
    axis: U32 = param(2)
    towards: F32 = param(1.0)
    slice: U32 = param(0, unit="cell")
    is_odd: Bool = param(False)
    stack_z: U32 = param(0)


@dataclass(frozen=True)
class SlabTableUniforms:
    """The table that is filled, the length of its slabs, and the diagonals that a dispatch fills."""

    entries: U32 = param(2)
    lengths: U32 = param(2)
    layer: U32 = param(1)
    first_diagonal: U32 = param(0)
    diagonals: U32 = param(1)
    length_world: F32 = param(1.0, unit="world")
    associated: Bool = param(False)


@dataclass(frozen=True, eq=False)
class MeshUniforms:
    """A mesh, the depths between which meshes lie, how many layers of them are kept, and whether it is the first of those.

    ``stride`` is how many vectors a vertex has: position, normal, and colour if there are three. Triangles are numbered through
    all meshes, from ``first_triangle`` on. ``seen_px`` is the pixel of the tile from which on pixels are looked at.
    """

    world_from_mesh: Mat4f = param(None)
    normal_from_mesh: Mat3f = param(None)
    rgb: Vec3f = param((1.0, 1.0, 1.0))
    opacity: F32 = param(1.0)
    near_world: F32 = param(0.0, unit="world")
    far_world: F32 = param(1.0, unit="world")
    number: U32 = param(0)
    stride: U32 = param(2)
    layers: U32 = param(0)
    is_first: Bool = param(False)
    first_triangle: U32 = param(0)
    triangles: U32 = param(0)
    seen_px: Vec2u = param((0, 0), unit="px")
    is_smooth: Bool = param(True)
    is_lit: Bool = param(True)
    is_opaque: Bool = param(True)


@dataclass(frozen=True)
class OutlineUniforms:
    """A closed mesh that clips; see ``airlight.clips``. ``faces_out`` is -1 where its faces look in."""

    list: U32 = param(0)
    cuts: U32 = param(0)
    keeps_inside: Bool = param(True)
    capped: Bool = param(False)
    faces_out: F32 = param(1.0)


EXTRA_UNIFORMS: dict[str, type] = {
    "luminance": LuminanceUniforms,
    "surround": SurroundUniforms,
    "picture": PictureUniforms,
    "slice": SliceUniforms,
    "planes": PlaneUniforms,
    "group": GroupUniforms,
    "lamp": LampUniforms,
    "steep": SteepUniforms,
    "classify": ClassifyUniforms,
    "encoding": GradientEncoding,
    "mesh": MeshUniforms,
    "outline": OutlineUniforms,
    "slab_table": SlabTableUniforms,
    "occlusion": OcclusionUniforms,
    "shadow": ShadowUniforms,
}

SPACES = {"uniform": "<uniform>", "lights": "<uniform>", "read": "<storage, read>", "buffer": "<storage, read_write>"}

# What passes write and read, by name: WGSL type, and format for storage textures.
PASS_RESOURCES: dict[str, str] = {
    "radiance": "array<vec4f>",
    "depth": "array<vec2f>",
    "sums": "array<vec2f>",
    "surround_sums": "array<vec2f>",
    "surround_out": "texture_storage_3d<rg32float, write>",
    "surround": "texture_3d<f32>",
    "segments": "array<vec4f>",
    "unfinished": "array<Unfinished>",
    "waiting": "array<vec4f>",
    "slab_table_out": "texture_storage_2d_array<rgba32float, write>",
    "gradients_float16_out": "texture_storage_3d<rgba16float, write>",
    "gradients_snorm8_out": "texture_storage_3d<rgba8snorm, write>",
    "classified_out": "texture_storage_3d<rgba32float, write>",
    "classified_stack_out": "texture_storage_2d_array<rgba32float, write>",
    "numbers8_out": "texture_storage_3d<rgba8uint, write>",
    "numbers16_out": "texture_storage_3d<rgba16uint, write>",
    "lit_directions_out": "texture_storage_3d<rgba32float, write>",
    "occluders_out": "texture_storage_3d<rgba16float, write>",
    "occluders": "texture_3d<f32>",
    "openness_out": "texture_storage_3d<rgba16float, write>",
    "shadows_out": "texture_storage_3d<rgba16float, write>",
    "shadows_before": "texture_3d<f32>",
    "shadow_slices": "array<vec4f>",
    "hits": "array<vec4f>",
    "chosen": "array<u32>",
    "clips": "array<ClipRecord>",
    "covers": "array<f32>",
    "cover_counts": "array<atomic<u32>>",
    "changes": "array<vec2u>",
    "fragments": "array<u32>",
    "fragment_counts": "array<atomic<u32>>",
    "fragment_times": "array<f32>",
    "most_fragments": "array<atomic<u32>>",
    "mesh_vertices": "array<vec4f>",
    "mesh_faces": "array<u32>",
    "triangles": "texture_2d<u32>",
    "reach_first": "texture_2d<f32>",
    "reach_last": "texture_2d<f32>",
    "opaque_depth": "texture_depth_2d",
    "light_before": "texture_2d<f32>",
    "light_planes": "texture_3d<f32>",
    "light_planes_out": "texture_storage_3d<rgba16float, write>",
    "light_picture": "texture_2d<f32>",
    "added_radiance": "array<vec4f>",
    "added_depth": "array<vec2f>",
}
ARRAYS = ("layers", "stack", "loaded_stack")  # kinds of bindings that are arrays of 2-D textures
READ_ONLY = ("chosen", "clips", "mesh_vertices", "mesh_faces")


# What voxels add to sums, by whether their samples are packed, and whether some are marked as empty.
TAPS = {(False, False): "one", (False, True): "masked", (True, False): "packed", (True, True): "packed_masked"}


@dataclass(frozen=True)
class Traits:
    """What of a device decides which program is linked.

    ``holds_uniforms``: entry points copy uniforms and lights into variables first, as each look at a uniform costs as much as
    some arithmetic, and again in every turn of a loop.
    """

    filters_float32: bool
    workgroup: tuple[int, int]
    holds_uniforms: bool = False


@dataclass(frozen=True)
class Binding:
    """A resource of a program. ``kind`` tells how it is bound; a ``loaded_grid`` is never sampled with a filter."""

    group: int
    index: int
    name: str
    type: str
    kind: str
    owner: tuple[str, int | None, str] = ("", None, "")

    @property
    def wgsl(self) -> str:
        """Declaration."""
        space = SPACES.get(self.kind, "")
        return f"@group({self.group}) @binding({self.index}) var{space} {self.name}: {self.type};"


@dataclass(frozen=True, eq=False)
class Program:
    """A linked text with its uniform struct and bindings; there is one for a key."""

    linked: Linked
    uniforms: Struct
    bindings: tuple[Binding, ...]
    key: ProgramKey


@dataclass(frozen=True)
class StageKey:
    """What of a stage decides the program's text: its class and static fields, and the kinds of its resources."""

    cls: type[Stage]
    statics: tuple[tuple[str, Any], ...]
    resources: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Switches:
    """Constants of ``generated::sizes``, in capitals, by which drivers leave out what a frame does not need.

    ``has_empty``: fields may hold marked samples. ``skips_empty``: slabs that the transfer stage calls empty need not be taken.
    ``surfaces_only``: slabs without a surface need not be taken. ``classifies``: colour and opacity of slabs are looked at.
    ``weighted``: a table of slabs tells which share of the light lies towards the back. ``curved``: values are put right for
    how the field curves along the ray. ``lights_ends``: lighting keeps how ends of slabs are lit.
    ``skips_blocks``: blocks of voxels in which nothing is are passed over; ``fills``: a ray shows something even where all of
    its blocks are. ``blocks_know_more``: two samples do not tell that slabs in these are empty; ``hides``: of some slabs that
    are passed over they do not tell that nothing is seen of them. ``walks_blocks``: each of the other blocks is sampled,
    whatever the step; ``walks_cells``: each of their cells of eight voxels is looked through.
    ``lit``: slabs are lit, which takes long. ``has_crossings``: slabs are cut at surfaces of the transfer function.
    ``lights_faces``: where clips cut, light comes from their faces. ``draws_caps``: such faces may be solid.
    ``cuts_at_covers``: slabs are cut where meshes let light pass.
    ``adaptive``: slabs are longer where little of them gets through to the eye; ``crosses_even``: one slab goes through blocks
    in which one medium is. ``in_parts``: rays are marched part by part.
    ``cuts_layers``: clips cut some of several layers alone.
    """

    has_empty: bool = False
    skips_empty: bool = False
    surfaces_only: bool = False
    classifies: bool = False
    weighted: bool = False
    curved: bool = False
    lights_ends: bool = False
    skips_blocks: bool = False
    fills: bool = False
    blocks_know_more: bool = False
    hides: bool = False
    walks_blocks: bool = False
    walks_cells: bool = False
    lit: bool = False
    has_crossings: bool = False
    cuts_at_covers: bool = False
    lights_faces: bool = False
    draws_caps: bool = False
    adaptive: bool = False
    crosses_even: bool = False
    in_parts: bool = False
    cuts_layers: bool = False


@dataclass(frozen=True)
class ProgramKey:
    """What a program's text depends on; equal keys share text, module and pipeline."""

    root: str | Path
    scene: tuple[tuple[str, StageKey], ...]
    layers: tuple[tuple[tuple[str, StageKey], ...], ...]
    outputs: tuple[str, ...]
    extra: tuple[str, ...]
    switches: Switches
    traits: Traits
    groups: int = 0  # vectors of four in a value; 0 where it is a single number
    lights: int = 1
    groups_of_layers: tuple[int, ...] = ()  # of each, where there are several
    reads: tuple[tuple[str, str], ...] = ()  # lists that a pass over pictures reads, with the type of what they hold
    written: str = ""  # type of what it makes of a pixel

    @cached_property
    def _hash(self) -> int:
        return hash(tuple(getattr(self, one.name) for one in dataclasses.fields(self)))

    def __hash__(self) -> int:
        """Return the hash of all fields, found once: keys are asked for it many times a frame."""
        return self._hash

    @property
    def group_px(self) -> tuple[int, int]:
        """Width and height of the pixels that a workgroup draws.

        Where rays pass over what is empty, pixels close together take about as long: squares. Rows read samples faster.
        """
        x, y = self.traits.workgroup
        walks = self.switches.skips_empty or self.switches.surfaces_only
        side = math.isqrt(x * y)
        return (side, x * y // side) if walks and y == 1 and "chosen" not in self.outputs else (x, y)

    def __str__(self) -> str:
        def one(slot: str, key: StageKey) -> str:
            statics = ", ".join(f"{n}={v!r}" for n, v in key.statics)
            return f"{slot}={key.cls.name}" + (f"({statics})" if statics else "")

        scene = " ".join(one(*item) for item in self.scene)
        layers = " | ".join(" ".join(one(*item) for item in layer) for layer in self.layers)
        return f"{self.root} {scene} [{layers}] {self.traits}"


def stage_key(
    stage: Stage, resources: Mapping[str, Resource] | None = None, variant: Mapping[str, bool] | None = None
) -> StageKey:
    """Key of a stage with the resources that it asks for and its variant."""
    kinds = tuple((name, _kind(r)) for name, r in (resources or {}).items())
    return StageKey(type(stage), tuple((stage.statics() | dict(variant or {})).items()), kinds)


def _kind(resource: Resource) -> str:
    match resource:
        case ClassifiedGrid():
            return "layers" if isinstance(resource.grid, Stack) else "table"
        case Table() | LitDirections():
            return "table"
        case SlabTable():
            return "layers"
        case Stack():
            return "stack" if resource.filtered else "loaded_stack"
        case Grid():
            return "grid" if resource.filtered else "loaded_grid"
        case BlockBounds():
            return "loaded_grid"
        case GradientGrid():
            return "gradients"
        case LabelCells() | BlockLeaps() | DirectionGrid():
            return "labels"
        case OpennessGrid() | ShadowGrid():
            return "openness"
    known = "use Table, SlabTable, Grid, Stack, GradientGrid, ClassifiedGrid, LabelCells, BlockLeaps or OpennessGrid"
    raise StageError("a stage", f"asks for a {type(resource).__name__}", known)


@lru_cache(maxsize=128)
def build_program(key: ProgramKey) -> Program:
    """Declare and link what a key asks for.

    Raises
    ------
    ShaderError
        When the files do not link; see ``link``.
    StageError
        When a stage asks for a resource of an unknown kind.
    """
    build = _Builder()
    members: list[tuple[str, str | Struct, str]] = [("frame", class_struct(FrameUniforms, "Frame"), "")]
    build.names["frame", None, "frame"] = "uniforms.frame"
    slots: dict[str, tuple[tuple[str, Any], ...]] = {}
    for slot, stage in key.scene:
        members += build.stage(slot, stage, None)
        if slot in SLOTS:
            slots[slot] = ((stage.cls.name, stage_source(stage.cls.wgsl, stage.cls.name)),)
    for i, layer in enumerate(key.layers):
        members.append((f"layer_{i}", class_struct(LayerUniforms, "Layer"), ""))
        build.names["layer", i, "layer"] = f"uniforms.layer_{i}"
        for slot, stage in layer:
            members += build.stage(slot, stage, i)
            slots[slot] = (*slots.get(slot, ()), (stage.cls.name, stage_source(stage.cls.wgsl, stage.cls.name)))
            if slot == "transfer":
                piece = getattr(stage.cls, "piece", "unattenuated")
                slots["piece"] = (*slots.get("piece", ()), (piece, package_source(f"transfer/{piece}.wgsl")))
            if slot == "field":
                told = dict(stage.statics)
                taps = TAPS[bool(told.get("packed")), bool(told.get("masked"))]
                slots["taps"] = (*slots.get("taps", ()), (taps, package_source(f"taps/{taps}.wgsl")))
                voxels = "stack" if dict(stage.resources).get("grid", "").endswith("stack") else "grid"
                if voxels == "stack":
                    _check_reads_layers(stage.cls)
                slots["voxels"] = (*slots.get("voxels", ()), (voxels, package_source(f"voxels/{voxels}.wgsl")))
                asks = key.switches.skips_blocks or key.switches.crosses_even
                is_told = asks and any(name == "leaps" for name, _ in stage.resources)
                blocks = "bounds" if _tells_bounds(stage) else "leaps" if is_told else "unknown"
                slots["blocks"] = (*slots.get("blocks", ()), (blocks, package_source(f"blocks/{blocks}.wgsl")))
    for name in key.extra:
        cls = EXTRA_UNIFORMS[name]
        members.append((name, class_struct(cls, name.title()), ""))
        build.names[name, None, "params"] = f"uniforms.{name}"
    slots["lookup"] = (
        ("lookup", package_source("lookup/filtered.wgsl" if key.traits.filters_float32 else "lookup/loaded.wgsl")),
    )
    slots.setdefault("blocks", (("unknown", package_source("blocks/unknown.wgsl")),))
    crossings = "cut" if key.switches.has_crossings else "none"
    slots["crossings"] = ((crossings, package_source(f"crossings/{crossings}.wgsl")),)
    has_surface = any("surface" in parse(source).declared for _, source in slots.get("integrate", ()))
    met = "surface" if has_surface else "nothing"
    slots["met"] = ((met, package_source(f"met/{met}.wgsl")),)
    walk = "cells" if key.switches.walks_cells else "surfaces" if key.switches.walks_blocks else "lattice"
    # Surfaces of several layers are looked for by one stage with parameters of each.
    if key.switches.surfaces_only:
        slots["integrate"] = slots["integrate"][:1]
    apart = len(slots.get("integrate", ())) > 1
    fields = [dict(layer).get("field") for layer in key.layers if apart or len(key.layers) == 1] or [None]
    walks = ["extremes" if field is not None and _tells_bounds(field) else walk for field in fields]
    slots["walk"] = tuple((one, package_source(f"walk/{one}.wgsl")) for one in walks)
    rays = "apart" if apart else "together"
    slots["rays"] = ((rays, package_source(f"rays/{rays}.wgsl")),)
    covers = "meshes" if "covers" in key.outputs else "none"
    slots["covers"] = ((covers, package_source(f"covers/{covers}.wgsl")),)
    clips = "cut" if "clips" in key.outputs else "whole"
    slots["clips"] = ((clips, package_source(f"clips/{clips}.wgsl")),)
    seen = "cut" if {"clips", "mesh_faces"} <= set(key.outputs) else "whole"
    slots["seen"] = ((seen, package_source(f"seen/{seen}.wgsl")),)
    outlines = "met" if "changes" in key.outputs else "none"
    slots["outlines"] = ((outlines, package_source(f"outlines/{outlines}.wgsl")),)
    pixels = "chosen" if "chosen" in key.outputs else "tile"
    slots["pixels"] = ((pixels, package_source(f"pixels/{pixels}.wgsl")),)
    driver = next((dict(stage.statics) for slot, stage in key.scene if slot == "driver"), {})
    offsets = driver.get("offsets", "none")
    lattice = "planes" if "planes" in key.extra else "distance"
    slots["lattice"] = (("lattice", package_source(f"lattice/{lattice}.wgsl")),)
    slots["offsets"] = ((offsets, package_source(f"offsets/{offsets}.wgsl")),)
    before = "plane" if "light_before" in key.outputs else "nothing"
    slots["before"] = ((before, package_source(f"before/{before}.wgsl")),)
    beam = "thrown" if "light_picture" in key.outputs else "everywhere"
    slots["beam"] = ((beam, package_source(f"beam/{beam}.wgsl")),)
    reach = "bounded" if "reach_first" in key.outputs else "whole"
    slots["reach"] = ((reach, package_source(f"reach/{reach}.wgsl")),)
    hits = "kept" if "hits" in key.outputs else "dropped"
    slots["hits"] = ((hits, package_source(f"hits/{hits}.wgsl")),)
    several = len(key.layers) > 1
    values = ["packed" if groups else "one" for groups in (key.groups_of_layers if several else (key.groups,))]
    slots["values"] = tuple(("values", package_source(f"values/{name}.wgsl")) for name in values)
    uniforms = make_struct("Uniforms", members)
    build.bind(0, "uniforms", "Uniforms", "uniform")
    if any(slot == "shade" for layer in key.layers for slot, _ in layer):
        build.names["lights", None, "lights"] = build.bind(0, "lights", "array<LightRecord, LIGHTS>", "lights")
        build.names["lights", None, "LightRecord"] = "LightRecord"
    for name in key.outputs:
        wgsl = PASS_RESOURCES[name]
        kind = _pass_kind(name, wgsl)
        build.names["pass", None, name] = build.bind(3, name, wgsl, kind)
        if kind in ("filtered", "filtered_2d", "table"):
            build.names["pass", None, f"{name}_sampler"] = build.bind(3, f"{name}_sampler", "sampler", "sampler")
    for name, wgsl in key.reads:
        build.names["pass", None, name] = build.bind(3, f"read_{name}", f"array<{wgsl}>", "read")
    if key.written:
        build.names["picture", None, "written"] = build.bind(3, "written", f"array<{key.written}>", "buffer")
    x, y = key.traits.workgroup
    constants = {"WORKGROUP_X": x, "WORKGROUP_Y": y, "LUMINANCE_SUMS": LUMINANCE_SUMS, "GROUPS": key.groups}
    constants |= {"SURROUND_STEPS": SURROUND_STEPS}
    constants |= {"BLOCK_VOXELS": BLOCK_VOXELS, "LIGHTS": key.lights, "CHOSEN_WIDTH": CHOSEN_WIDTH}
    constants |= {"MOST_LEAP": MOST_LEAP}
    constants |= {"GROUP_X": key.group_px[0], "GROUP_Y": key.group_px[1]}
    constants |= {"BOUND_VOXELS": BOUND_VOXELS, "BOUND_GROUP_VOXELS": BOUND_GROUP_VOXELS}
    switches = {name.upper(): str(value).lower() for name, value in dataclasses.asdict(key.switches).items()}
    kinds = {"Values": _values_type(key.groups)}
    if several:
        # A value of all layers is that of each, in a chain; which of them hold nothing each looks for by itself.
        kinds = {f"Values_{i}": _values_type(n) for i, n in enumerate(key.groups_of_layers)}
        constants |= {f"GROUPS_{i}": n for i, n in enumerate(key.groups_of_layers)}
        switches |= {"HAS_EMPTY": "false", "SOME_EMPTY": switches["HAS_EMPTY"]}
        for i in range(len(key.layers)):
            own = {"Values": f"Values_{i}", "GROUPS": f"GROUPS_{i}", "HAS_EMPTY": "SOME_EMPTY"}
            build.names |= {("sizes", i, name): wgsl for name, wgsl in own.items()}
    for name in ("Values", *switches, *constants):
        build.names["sizes", None, name] = "Fetches_0" if name == "Values" and several else name
    structs = {m.struct.name: m.struct for m in uniforms.members if m.struct}
    structs["LightRecord"] = class_struct(LightRecord, "LightRecord")
    structs["ClipRecord"] = class_struct(ClipRecord, "ClipRecord")
    build.names["clips", None, "ClipRecord"] = "ClipRecord"
    held = [b for b in build.bindings if key.traits.holds_uniforms and b.kind in ("uniform", "lights")]
    first = [f"{b.name} = given_{b.name};" for b in held]
    text = "\n".join(
        [
            *(f"alias {name} = {wgsl};" for name, wgsl in kinds.items()),
            *(f"const {name}: bool = {value};" for name, value in switches.items()),
            *(f"const {name}: u32 = {value}u;" for name, value in constants.items()),
            *build.constants,
            *(struct.wgsl for struct in structs.values()),
            uniforms.wgsl,
            *((dataclasses.replace(b, name=f"given_{b.name}") if b in held else b).wgsl for b in build.bindings),
            *(f"var<private> {b.name}: {b.type};" for b in held),
        ]
    )
    linked = link(stage_source(key.root, "driver"), slots, Generated(text, build.names, " ".join(first)))
    return Program(linked, uniforms, tuple(build.bindings), key)


def _check_reads_layers(cls: type[Stage]) -> None:
    """Refuse a field over layers whose device half looks into a 3-D texture itself."""
    used = {item.name for item in parse(stage_source(cls.wgsl, cls.name)).imports if item.path[0] == "generated"}
    if used & {"grid", "grid_sampler"}:
        what = "looks into the grid's 3-D texture itself, and the driver reads layers of 2-D textures"
        raise StageError(f"look.field {cls.name!r}", what, "read it by slot::voxels, or use driver='slices'")


def _tells_bounds(field: StageKey) -> bool:
    """Whether blocks are passed over whose values cannot change what has been found."""
    return any(name == "bounds" for name, _ in field.resources)


def _values_type(groups: int) -> str:
    """WGSL type of a sample."""
    return f"array<vec4f, {groups}>" if groups else "f32"


def _pass_kind(name: str, wgsl: str) -> str:
    """How a resource of a pass is bound."""
    if wgsl.startswith("array"):
        return "read" if name in READ_ONLY else "buffer"
    if name == "surround":
        return "table"  # of 32-bit floats, which not all devices filter
    if name in ("light_before", "reach_first", "reach_last"):
        return "loaded_2d"
    kinds = {"texture_2d<u32>": "numbers_2d", "texture_depth_2d": "depth_2d", "texture_2d<f32>": "filtered_2d"}
    return kinds.get(wgsl, "storage_texture" if "storage" in wgsl else "filtered")


class _Builder:
    """What is declared so far."""

    def __init__(self) -> None:
        self.names: dict[tuple[str, int | None, str], str] = {}
        self.bindings: list[Binding] = []
        self.constants: list[str] = []

    def bind(
        self, group: int, name: str, kind_wgsl: str, kind: str, owner: tuple[str, int | None, str] = ("", None, "")
    ) -> str:
        index = sum(b.group == group for b in self.bindings)
        self.bindings.append(Binding(group, index, name, kind_wgsl, kind, owner))
        return name

    def stage(self, slot: str, key: StageKey, layer: int | None) -> list[tuple[str, str | Struct, str]]:
        """Declare a stage's constants and resources; return its member of the uniform struct, if it has parameters."""
        suffix = "" if layer is None else f"_{layer}"
        for name, value in key.statics:
            constant = f"{slot}_{name}{suffix}".upper()
            self.constants.append(f"const {constant}: {_constant(key.cls, name, value)};")
            self.names[slot, layer, name.upper()] = constant
        for name, kind in key.resources:
            self.resource(slot, layer, name, kind, f"{slot}_{name}{suffix}")
        cls = key.cls.uniform_type or key.cls
        if not uniform_fields(cls):
            return []
        self.names[slot, layer, "params"] = f"uniforms.{slot}{suffix}"
        return [(f"{slot}{suffix}", class_struct(cls, f"{slot.title()}{cls.__name__}"), "")]

    def resource(self, slot: str, layer: int | None, name: str, kind: str, full: str) -> None:
        group = 2 if kind in ("table", "layers") else 1
        owner = (slot, layer, name)
        if kind == "labels":
            self.names[slot, layer, name] = self.bind(group, full, "texture_3d<u32>", kind, owner)
            return
        texture = "texture_2d_array<f32>" if kind in ARRAYS else "texture_3d<f32>"
        self.names[slot, layer, name] = self.bind(group, full, texture, kind, owner)
        sampler = f"{name}_sampler"
        self.names[slot, layer, sampler] = self.bind(group, f"{full}_sampler", "sampler", "sampler", owner)


def _constant(cls: type[Stage], name: str, value: Any) -> str:
    """Type and value of a static field; a word becomes its number among the choices."""
    if isinstance(value, bool):
        return f"bool = {str(value).lower()}"
    if isinstance(value, int):
        return f"i32 = {value}"
    if isinstance(value, float):
        return f"f32 = {value!r}"
    field = next(f for f in stage_fields(cls) if f.name == name)
    choices = field.metadata["bounds"].choices
    if value not in choices:
        raise StageError(f"{cls.__name__}.{name}", f"is {value!r}", "static fields are bool, int, float or one of choices")
    return f"u32 = {choices.index(value)}u"
