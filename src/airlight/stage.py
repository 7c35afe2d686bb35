"""What a stage is: a frozen dataclass, the slot that it fills, its parameters, and what it needs on the device.

A stage is the host half of one exchangeable step; its device half is a WGSL file. A new stage is one dataclass, one WGSL
file and one function of the reference; the command line, the viewer, parity tests and tables of the docs follow from the class.
"""

from __future__ import annotations

import dataclasses
import inspect
import numbers
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeVar, get_args, get_type_hints

import numpy as np
import numpy.typing as npt

from .errors import StageError, ValueRangeError
from .handed import Kind

if TYPE_CHECKING:
    from .clips import Clip
    from .labels import LabelNumbers, Labels
    from .transfer.function import TransferFunction
    from .volume import Volume

Stretches = tuple[tuple[float, float], ...]
"""Closed intervals of values, each with its first and its last; they may reach to infinity."""

Conditions = tuple[tuple[tuple[int | str, float, float], ...], ...]
"""Conditions, each with its alternatives: that a variable lies in a closed interval. A variable is the place of a channel among
those of the layer, or the name of what is made of them: ``"gradient"``, ``"second"``."""

# -- types of WGSL, as annotations that a type checker sees as plain Python types

F32 = Annotated[float, "f32"]
I32 = Annotated[int, "i32"]
U32 = Annotated[int, "u32"]
Bool = Annotated[bool, "u32"]  # bool cannot be shared with a host
Vec2f = Annotated[tuple[float, float], "vec2f"]
Vec3f = Annotated[tuple[float, float, float], "vec3f"]
Vec4f = Annotated[tuple[float, float, float, float], "vec4f"]
Vec2u = Annotated[tuple[int, int], "vec2u"]
Vec3u = Annotated[tuple[int, int, int], "vec3u"]
Mat3f = Annotated[npt.NDArray[np.float64], "mat3x3f"]
Mat4f = Annotated[npt.NDArray[np.float64], "mat4x4f"]


@dataclass(frozen=True)
class Bounds:
    """What a parameter may be: an interval, or one of several words."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    up_to: float | None = None
    choices: tuple[str, ...] = ()

    def allows(self, value: Any) -> bool:
        """Whether the value, or each component of a vector, is finite and lies inside."""
        if self.choices:
            return value in self.choices
        if value is None or isinstance(value, (str, bool)):
            return True
        parts = np.asarray(value, dtype=np.float64)
        return bool(
            np.isfinite(parts).all()
            and (self.above is None or (parts > self.above).all())
            and (self.at_least is None or (parts >= self.at_least).all())
            and (self.below is None or (parts < self.below).all())
            and (self.up_to is None or (parts <= self.up_to).all())
        )

    def __str__(self) -> str:
        if self.choices:
            return "must be one of " + ", ".join(self.choices)
        low, high = (self.above, self.at_least), (self.below, self.up_to)
        if low == (None, None) and high == (None, None):
            return "must be finite"
        left = f"({self.above:g}" if self.above is not None else f"[{self.at_least:g}" if self.at_least is not None else "(-inf"
        right = f"{self.below:g})" if self.below is not None else f"{self.up_to:g}]" if self.up_to is not None else "inf)"
        return f"must lie in {left}, {right}"


def param(
    default: Any,
    *,
    unit: str = "1",
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    up_to: float | None = None,
    help: str = "",
) -> Any:
    """Field of a stage that becomes a uniform: changing it changes bytes on the device and nothing else."""
    bounds = Bounds(above=above, at_least=at_least, below=below, up_to=up_to)
    return dataclasses.field(default=default, metadata={"kind": "param", "unit": unit, "bounds": bounds, "help": help})


def static(default: Any, *, choices: tuple[str, ...] = (), help: str = "") -> Any:
    """Field of a stage that becomes a constant of the program: changing it links another program."""
    return dataclasses.field(
        default=default, metadata={"kind": "static", "unit": "", "bounds": Bounds(choices=choices), "help": help}
    )


def value(default: Any, *, at_least: float | None = None, up_to: float | None = None, help: str = "") -> Any:
    """Field of a stage that is a value of its own, of which uniforms and resources are made; its class checks the rest."""
    bounds = Bounds(at_least=at_least, up_to=up_to)
    return dataclasses.field(default=default, metadata={"kind": "value", "unit": "", "bounds": bounds, "help": help})


# -- what a stage asks of the device


@dataclass(frozen=True, eq=False)
class Table:
    """A table of float32 texels, ``(depth, height, width, 4)``.

    WGSL reads it through ``slot::lookup::table_at(name, name_sampler, place_unit)``, linear between entries.
    """

    texels: npt.NDArray[np.float32]


@dataclass(frozen=True)
class SlabTable:
    """Slabs of a function, ``entries`` x ``entries`` for ``lengths`` lengths up to ``length``; made on the device.

    WGSL reads it like a ``Table``; see ``wgsl/passes/slab_table.wgsl``. ``weighted`` adds the shares of the back.
    """

    function: TransferFunction
    length: float
    entries: int
    lengths: int
    weighted: bool = False


@dataclass(frozen=True)
class Grid:
    """Samples of channels at one time step as a 3-D texture.

    Several channels lie four to a texel, groups of four one behind the other along z. ``filtered`` when the sampler
    interpolates; ``masked`` when empty samples are marked by ``EMPTY``, in 32-bit floats; ``levels`` when the texture has all
    coarser levels of means, of one channel.
    """

    volume: Volume
    channels: tuple[int, ...]
    time: int
    filtered: bool
    masked: bool = False
    levels: bool = False


@dataclass(frozen=True)
class Stack(Grid):
    """The same samples as layers of 2-D textures along an axis of the grid: 0 is x, 1 y, 2 z; WGSL: ``package::field::layers``.

    Layers are planes of the other two axes, in rising order. Groups of four channels lie one behind the other. Coarser levels
    have fewer layers, the first of the array, and end where a layer is a single sample.
    """

    axis: int = 2

    @property
    def solid(self) -> Grid:
        """The grid without regard to how its samples lie."""
        return Grid(self.volume, self.channels, self.time, self.filtered, self.masked, self.levels)


@dataclass(frozen=True)
class GradientEncoding:
    """How gradients and values lie in texels: ``gradient = xyz * scale``, ``value = w * value_scale + value_offset``.

    Gradients longer than ``longest * scale`` are cut to that length. With ``value_scale`` 0 no values are kept.
    """

    scale: F32 = param(1.0, unit="data/world")
    longest: F32 = param(6e4)
    value_scale: F32 = param(0.0, unit="data")
    value_offset: F32 = param(0.0, unit="data")


@dataclass(frozen=True)
class GradientGrid:
    """Gradients at all voxels as a 3-D texture, made on the device by the gradient stage ``method``.

    Values beside them are those of which gradients are taken. ``reader`` is the field at the voxels; None is the layer's own.
    """

    method: Stage
    format: str
    encoding: GradientEncoding
    reader: Stage | None = None

    @property
    def texel_format(self) -> str:
        """Format of the texture."""
        return {"float16": "rgba16float", "snorm8": "rgba8snorm"}[self.format]


@dataclass(frozen=True)
class ClassifiedGrid:
    """Colour and extinction of a function at all voxels of a grid, made on the device; a ``Table`` to WGSL.

    ``field`` reads the grid at the voxels, ``transfer`` classifies what it finds; ``weighted`` colours are times extinction.
    """

    grid: Grid
    function: TransferFunction
    weighted: bool
    field: Stage
    transfer: Stage


@dataclass(frozen=True)
class LabelCells:
    """Labels at the voxels of a grid with one voxel of background round it, as a 3-D texture of whole numbers.

    Twice the label's number; plus one where the eight voxels from this one upwards do not all have the same.
    """

    numbers: LabelNumbers


@dataclass(frozen=True)
class BlockRanges:
    """The least and the greatest value of a field in each block of ``BLOCK_VOXELS`` a side, made by NumPy.

    Of the channel at a place among the grid's. Samples count up to ``reach`` voxels beyond a block's faces, and the field
    leaves their range by ``overshoot`` times that range.
    """

    grid: Grid
    place: int = 0
    reach: int = 0
    overshoot: float = 0.0


@dataclass(frozen=True)
class BlockSlopes:
    """Bounds of gradients' lengths in each block: from 0 to ``per_value`` [1/world] times the width of a range of values."""

    ranges: BlockRanges
    per_value: float


@dataclass(frozen=True)
class BlockShares:
    """The least and the greatest share that drawn labels take of a place, 0 or 1, in each block of the labels' voxels.

    ``drawn`` tells which are, 1 or 0, in rising order of the labels; those up to ``reach`` voxels beyond a block's faces count.
    """

    numbers: LabelNumbers
    drawn: bytes
    reach: int


BlockVariable = BlockRanges | BlockSlopes | BlockShares


@dataclass(frozen=True)
class Within:
    """That all of a variable's values in a block lie in a closed interval."""

    variable: BlockVariable
    low: float
    high: float


@dataclass(frozen=True)
class EvenBlocks:
    """Blocks in which one medium is, lit everywhere alike.

    They are where the field has one value as far as gradients reach (``around``), or all values to which curvature may move
    samples (``moved``) lie on one of some ``plateaus`` of the function. ``values``, of the block alone, tell whether to ask.
    """

    values: BlockRanges
    around: BlockRanges
    moved: BlockRanges
    plateaus: Stretches = ()


@dataclass(frozen=True)
class BlockLeaps:
    """How far rays may leap from each block over blocks in which nothing is.

    Nothing is where of each of several conditions one alternative holds: ``empty`` has the conditions. ``known_to_slabs`` tells
    whether the two samples of a slab tell the same. A 3-D texture; WGSL: ``package::blocks`` and ``slot::blocks::leap_of``.

    ``even`` tells of which other blocks one slab may go through several: ``slot::blocks::even_of``.
    """

    empty: tuple[tuple[Within, ...], ...]
    known_to_slabs: bool = True
    even: EvenBlocks | None = None


@dataclass(frozen=True)
class BlockBounds:
    """The greatest value of a field in each block of ``BOUND_VOXELS`` a side, or the least, and that in a group of them.

    A 3-D texture of half floats that are not rounded inwards; WGSL: ``slot::blocks::bounds_of``.
    """

    ranges: BlockRanges
    of_least: bool


BLOCK_VOXELS = 4
MOST_LEAP = 15  # blocks: those before the next one that counts; numbers above go through even blocks
BOUND_VOXELS = 8
BOUND_GROUP_VOXELS = 32


@dataclass(frozen=True)
class OccluderGrid:
    """What hides, as the optical depth of cells of voxels: a 3-D texture that the sampler interpolates.

    ``cells`` of them along x, y and z, of ``block`` voxels each, with a mean side ``cell_world``; what ``clips`` cut away hides
    nothing. By colour: with ``tint`` 1 a medium hides nothing of its own. ``asked`` is how many cells were asked for along the
    longest side. Made on the device by the layer's stages; see ``wgsl/passes/occluders.wgsl``.
    """

    cells: tuple[int, int, int]
    block: tuple[int, int, int]
    cell_world: float
    clips: tuple[Clip, ...] = ()
    tint: float = 0.0
    asked: int = 64


@dataclass(frozen=True)
class OpennessGrid:
    """Share of light from all directions that reaches cells, as a 3-D texture that the sampler interpolates.

    Made on the device; see ``wgsl/passes/openness.wgsl``.
    """

    occluders: OccluderGrid
    radius_world: float
    directions: int


@dataclass(frozen=True)
class ShadowGrid:
    """Share of each light, by colour, that reaches cells, as a 3-D texture that the sampler interpolates.

    Cells have one more all round them; lights, each by its kind and where it comes from, lie one behind the other along z.
    Made on the device; see ``wgsl/passes/shadow_sweep.wgsl``, ``shadow_rays.wgsl`` and ``shadow_beside.wgsl``.
    """

    occluders: OccluderGrid
    lights: tuple[tuple[str, tuple[float, float, float]], ...]
    by: str

    @property
    def size(self) -> tuple[int, int, int]:
        """Texels along x, y and z."""
        x, y, z = self.occluders.cells
        return x + 2, y + 2, (z + 2) * max(1, len(self.lights))


@dataclass(frozen=True)
class DirectionGrid:
    """Number of the direction, in a ``Table`` of normals, that is nearest to that of each voxel, four along x to a texel.

    Numbers count from 1; 0 is a gradient too weak to mean a surface. Made on the device by the layer's field and gradient.
    """

    normals: Table

    @property
    def bits(self) -> int:
        """Bits of a number: 8 as long as they suffice."""
        return 8 if self.normals.texels.shape[2] < 256 else 16


@dataclass(frozen=True)
class LitDirections:
    """How each direction of a ``Table`` of normals is lit in this frame; to WGSL a ``Table`` of diffuse and specular light."""

    normals: Table


Resource = (
    Table
    | SlabTable
    | Grid
    | Stack
    | GradientGrid
    | ClassifiedGrid
    | LabelCells
    | BlockLeaps
    | BlockBounds
    | OpennessGrid
    | ShadowGrid
    | DirectionGrid
    | LitDirections
)


Estimate = float | Callable[[], float]


@dataclass(frozen=True)
class Context:
    """What a stage may look at when it makes its uniforms and resources."""

    volume: Volume
    transfer: Any
    channels: tuple[int, ...]
    time: int
    step_world: float
    size_px: tuple[int, int]
    labels: Labels | None = None
    camera: Any = None
    clips: tuple[Clip, ...] = ()
    # Called with what is done, how much of it, and how much there is.
    progress: Callable[[str, int, int], None] | None = dataclasses.field(default=None, compare=False)
    lights: tuple[Any, ...] = ()

    @property
    def channel(self) -> int:
        """Number of the first channel."""
        return self.channels[0]


class Stage:
    """Base of all stages; see ``docs/slots`` for each slot's contract.

    Attributes
    ----------
    slot
        Name of the slot that the stage fills.
    name
        What users type.
    wgsl
        The device half: a path below ``airlight/wgsl``, a ``Path`` anywhere, or the text itself if it has several lines.
    uniform_type
        Dataclass that is packed for the device; None when it is the stage itself.
    reads
        Names and types of what the stage reads of the whole image: see ``airlight.handed``.
    """

    slot: ClassVar[str]
    name: ClassVar[str]
    wgsl: ClassVar[str | Path]
    uniform_type: ClassVar[type | None] = None
    reads: ClassVar[Mapping[str, Kind]] = MappingProxyType({})

    def __post_init__(self) -> None:
        """Check every parameter against its type and its bounds."""
        hints = type_hints(type(self))
        for field in stage_fields(type(self)):
            value, bounds = getattr(self, field.name), field.metadata["bounds"]
            kind = _kind_of(hints[field.name])
            if kind and not (value is None and _is_optional(hints[field.name])) and not _fits(value, kind):
                raise ValueRangeError(f"{self.slot}.{self.name}.{field.name}", f"is {value!r}, must be {_KINDS[kind]}")
            if field.metadata["kind"] != "value" and not bounds.allows(value):
                raise ValueRangeError(f"{self.slot}.{self.name}.{field.name}", f"is {value!r}, {bounds}")

    def uniforms(self, context: Context) -> Any:
        """Return the value to be packed for the device, an instance of ``uniform_type`` or of the stage."""
        return self

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return textures and tables by the names under which WGSL imports them."""
        return {}

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return the approximations that the stage makes, by what they are of, for ``image.stats``.

        What takes time is given as a function, which holds no volume: it is called when somebody reads the number.
        """
        return {}

    def variant(self, context: Context) -> dict[str, bool]:
        """Return further constants of the program, which follow from the function or the data."""
        return {}

    def converging(self) -> Stage:
        """Return the stage for pictures of a known error: itself, unless it is quick at a cost that no smaller step mends."""
        return self

    def statics(self) -> dict[str, Any]:
        """Return the fields that are part of the program's key."""
        return {f.name: getattr(self, f.name) for f in stage_fields(type(self)) if f.metadata["kind"] == "static"}


_KINDS = {
    "f32": "a number",
    "u32": "a whole number of at least 0",
    "i32": "a whole number",
    "vec2f": "two numbers",
    "vec3f": "three numbers",
    "vec4f": "four numbers",
}


_HINTS: dict[type, dict[str, Any]] = {}


def type_hints(cls: type) -> dict[str, Any]:
    """Annotations of a stage's fields with the WGSL types that they carry."""
    if cls not in _HINTS:
        _HINTS[cls] = get_type_hints(cls, include_extras=True)
    return _HINTS[cls]


def _kind_of(hint: Any) -> str:
    """WGSL type that an annotation carries, alone or beside None; empty for those that are not checked here."""
    for part in (hint, *get_args(hint)):
        for note in getattr(part, "__metadata__", ()):
            if note in _KINDS:
                return str(note)
    return ""


def _is_optional(hint: Any) -> bool:
    return type(None) in get_args(hint)


def _fits(value: Any, kind: str) -> bool:
    """Whether a value can be packed as a WGSL type."""
    if kind.startswith("vec"):
        return np.shape(value) == (int(kind[3]),) and all(isinstance(v, numbers.Real) for v in value)
    if kind == "f32":
        return isinstance(value, numbers.Real) and not isinstance(value, bool)
    if isinstance(value, bool):
        return kind == "u32"
    return isinstance(value, numbers.Integral) and (kind == "i32" or int(value) >= 0)


StageType = TypeVar("StageType", bound=type[Stage])


def stage_fields(cls: type) -> tuple[dataclasses.Field[Any], ...]:
    """Fields of a stage that were made by ``param`` or ``static``."""
    return tuple(f for f in dataclasses.fields(cls) if "kind" in f.metadata)


def summary_of(cls: type) -> str:
    """First paragraph of a stage's docstring, on one line: what lists, panels and pages say of it."""
    return (inspect.getdoc(cls) or "").partition("\n\n")[0].replace("\n", " ")


def uniform_fields(cls: type) -> list[tuple[str, str, str]]:
    """(name, WGSL type, unit) of the fields that are packed for the device, in the order of the class."""
    hints = type_hints(cls)
    found = []
    for field in dataclasses.fields(cls):
        if field.metadata.get("kind", "param") != "param":
            continue
        meta = getattr(hints[field.name], "__metadata__", None)
        if meta is None:
            raise StageError(f"{cls.__name__}.{field.name}", "has no WGSL type", "annotate it with F32, Vec3f, ...")
        found.append((field.name, str(meta[0]), str(field.metadata.get("unit", ""))))
    return found


# -- slots


@dataclass(frozen=True)
class Slot:
    """A place that a stage fills: the WGSL functions that it must define, and those that it may.

    What it leaves out comes from ``wgsl/defaults/NAME.wgsl``; ``defaults`` names the file of those that go together.
    """

    name: str
    functions: Mapping[str, str]
    optional: Mapping[str, str] = dataclasses.field(default_factory=dict)
    defaults: Mapping[str, str] = dataclasses.field(default_factory=dict)
    per_layer: bool = False
    help: str = ""


SLOTS: dict[str, Slot] = {
    slot.name: slot
    for slot in (
        Slot(
            "driver",
            {},
            help="What walks through the volume and calls the other slots.",
        ),
        Slot(
            "camera",
            {"eye_ray": "fn(vec2f) -> Ray"},
            help="The ray of a pixel.",
        ),
        Slot(
            "field",
            {
                "locate": "fn(vec3f) -> Place",
                "field_value": "fn(Place) -> Values",
                "extent": "fn(Place, vec3f) -> f32",
            },
            {"field_scalar": "fn(Place) -> f32", "field_derivative": "fn(Place) -> vec3f"},
            per_layer=True,
            help="The continuous function that reconstruction makes of the samples.",
        ),
        Slot(
            "gradient",
            {"field_gradient": "fn(Place) -> vec3f"},
            per_layer=True,
            help="The derivative of the field, in data units per world unit.",
        ),
        Slot(
            "transfer",
            {"medium": "fn(Sample) -> Medium", "classify": "fn(Sample, Sample, f32) -> Slab"},
            {
                "next_crossing": "fn(Sample, Sample, u32) -> Sheet",
                "know_crossing": "fn(Sheet, Sample, bool) -> Known",
                "empty_slab": "fn(Sample, Sample) -> bool",
                "held": "fn(Values, Values) -> Values",
                "opacity_share": "fn(Sample, Sample, f32, f32, f32) -> f32",
                "Known": "struct",
                "know": "fn(Sample) -> Known",
                "know_empty": "fn(Sample) -> Known",
                "classify_known": "fn(Sample, Known, Sample, Known, f32) -> Slab",
            },
            defaults={"Known": "known", "know": "known", "know_empty": "known", "classify_known": "known"},
            per_layer=True,
            help="From values to colour and extinction, at a sample and over a slab.",
        ),
        Slot(
            "modulation",
            {"weight": "fn(Sample, Sample, f32) -> f32"},
            per_layer=True,
            help="By what the extinction of a slab is multiplied, beside its transfer function.",
        ),
        Slot(
            "region",
            {"part_at": "fn(vec3f) -> Part"},
            {"hidden_at": "fn(vec3f) -> bool"},
            per_layer=True,
            help="What of a place is drawn, and in which tint: the regions of labels.",
        ),
        Slot(
            "shade",
            {"light": "fn(Sample, vec3f, vec3f) -> Lit"},
            per_layer=True,
            help="How a point answers to light.",
        ),
        Slot(
            "visibility",
            {"visibility": "fn(u32, vec3f) -> vec3f", "ambient_visibility": "fn(vec3f) -> f32"},
            help="How much of a light reaches a point.",
        ),
        Slot(
            "transport",
            {"passing": "fn(Slab) -> vec4f"},
            {
                "lasting": "fn(vec4f) -> bool",
                "Gathered": "struct",
                "gathered": "fn(vec4f, vec3f) -> Gathered",
                "carried": "fn(vec4f, Gathered, vec4f, f32) -> vec4f",
                "comes_through": "fn(vec4f, vec3f) -> vec3f",
            },
            defaults={"Gathered": "carried", "gathered": "carried"},
            help="What becomes of a light on its way from plane to plane, by the driver half_angle.",
        ),
        Slot(
            "lighting",
            {"light_slab": "fn(Sample, Sample, Slab, Ray) -> vec3f"},
            {
                "LitEnd": "struct",
                "know_light": "fn(Sample, Ray) -> LitEnd",
                "light_known": "fn(Sample, LitEnd, Sample, LitEnd, Slab, Ray) -> vec3f",
            },
            defaults={"LitEnd": "lit_end", "know_light": "lit_end", "light_known": "lit_end"},
            per_layer=True,
            help="Where within a slab light is evaluated.",
        ),
        Slot(
            "integrate",
            {
                "begin": "fn() -> Accumulated",
                "take": "fn(ptr<function, Accumulated>, Sample, Sample, Slab, vec3f, f32) -> bool",
                "finish": "fn(Accumulated) -> Result",
            },
            {
                "surface": "fn(Sample, Sample) -> f32",
                "level": "fn(Sample, Sample) -> f32",
                "surface_rgb": "fn(Sample, Sample, Sample, vec3f) -> vec3f",
                "settled": "fn(ptr<function, Accumulated>, f32, f32) -> bool",
                "through": "fn(Accumulated) -> f32",
                "Paused": "struct",
                "pause": "fn(Accumulated) -> Paused",
                "resume": "fn(Paused) -> Accumulated",
                "join": "fn(Accumulated, Accumulated) -> Accumulated",
            },
            defaults={"level": "surface", "surface_rgb": "surface", "Paused": "paused", "pause": "paused", "resume": "paused"},
            help="What becomes of the slabs along a ray.",
        ),
        Slot(
            "background",
            {"behind": "fn(Ray) -> vec3f"},
            help="What is seen behind all layers, as part of the scene.",
        ),
        Slot(
            "tone",
            {"tone": "fn(vec3f, vec2f) -> vec3f"},
            help="From the scene's radiance to what a display can show.",
        ),
        Slot(
            "passes",
            {"pixel": "fn(vec2i) -> T"},
            help="What is made of a picture, pixel by pixel, once it is there.",
        ),
    )
}

STAGES: dict[str, dict[str, type[Stage]]] = {name: {} for name in SLOTS}


def register(cls: StageType) -> StageType:
    """Make a stage known by its name, to the API and the command line. Usable as a decorator.

    Raises
    ------
    StageError
        When the class is no frozen dataclass, names no slot, has no device half, or its name is taken by another class.
    """
    where = getattr(cls, "__qualname__", str(cls))
    if not (isinstance(cls, type) and issubclass(cls, Stage)):
        raise StageError(where, "is no stage", "derive it from airlight.Stage")
    if not dataclasses.is_dataclass(cls) or not cls.__dataclass_params__.frozen:
        raise StageError(where, "is no frozen dataclass", "decorate it with @dataclass(frozen=True)")
    for attribute in ("slot", "name", "wgsl"):
        if not hasattr(cls, attribute):
            raise StageError(where, f"has no {attribute!r}", "set it as a ClassVar")
    if cls.slot not in SLOTS:
        raise StageError(where, f"names the slot {cls.slot!r}", "choose one of " + ", ".join(SLOTS))
    known = STAGES[cls.slot].get(cls.name)
    if known is not None and known is not cls and (known.__module__, known.__qualname__) != (cls.__module__, where):
        raise StageError(where, f"takes the name {cls.name!r} of {known.__qualname__} in slot {cls.slot}", "rename it")
    uniform_fields(cls.uniform_type or cls)
    STAGES[cls.slot][cls.name] = cls
    return cls


def make_stage(slot: str, choice: str | Stage, where: str = "") -> Stage:
    """Return the stage of a slot, given by name or as it is; errors name the slot of a look unless told ``where``."""
    where = where or f"look.{slot}"
    if isinstance(choice, Stage):
        if choice.slot != slot:
            raise StageError(where, f"got {type(choice).__name__}, a stage of the slot {choice.slot}")
        return choice
    if choice not in STAGES[slot]:
        raise ValueRangeError(where, f"is {choice!r}, must be one of " + ", ".join(sorted(STAGES[slot])))
    return STAGES[slot][choice]()
