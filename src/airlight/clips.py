"""Clips: shapes in the world of which what lies inside, or what lies outside, is drawn."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .errors import DataError, ValueRangeError
from .geometry.mesh import Mesh
from .geometry.saving import SOLID_ENTRIES, solid_from_dict, to_dict
from .transfer.given import check_names, direction, finite_numbers, flag, kind_of, listed_values, positive, set_fields
from .volume import FloatArray, checked_affine

Vector = tuple[float, float, float]
Row = tuple[float, float, float, float]

KEEP = ("inside", "outside")
CUTS = ("volume", "front", "back")


@dataclass(frozen=True)
class Clip:
    """Part of the world that is drawn; make one with ``Clip.plane``, ``.box``, ``.sphere`` or ``.mesh``.

    A point is drawn when every clip keeps it. Slabs end where rays pass a clip's surface, whatever the step.

    Attributes
    ----------
    keep
        Which side is drawn: ``"inside"`` or ``"outside"`` of the shape. Inside of a plane is where its normal points to.
    capped
        Whether the cut is drawn as a solid face, in the colours of the transfer function, wherever that has an extinction.
    cuts
        What of a ray that meets the shape is cut away: ``"volume"``, what lies on the other side. ``"front"``, only what is in
        front: the ray begins where it enters what is kept inside, or behind the shape that is cut away. ``"back"``, only what
        is behind: it ends behind what is kept inside, or before the shape, as at something opaque. With these two, rays that
        miss the shape stay whole.
    """

    kind: ClassVar[str] = "none"
    keep: str = dataclasses.field(default="inside", kw_only=True)
    capped: bool = dataclasses.field(default=False, kw_only=True)
    cuts: str = dataclasses.field(default="volume", kw_only=True)

    def __post_init__(self) -> None:
        """Check the values."""
        for name, allowed in (("keep", KEEP), ("cuts", CUTS)):
            if getattr(self, name) not in allowed:
                raise ValueRangeError(f"clip.{name}", f"is {getattr(self, name)!r}, must be one of {', '.join(allowed)}")
        set_fields(self, capped=flag(self.capped, "clip.capped"))

    @staticmethod
    def plane(*, point: Vector, normal: Vector, keep: str = "inside", capped: bool = False, cuts: str = "volume") -> Plane:
        """Half of the world: the side of a plane through ``point`` that ``normal`` points to."""
        return Plane(point, normal, keep=keep, capped=capped, cuts=cuts)

    @staticmethod
    def box(
        *,
        low: Vector,
        high: Vector,
        world_from_box: npt.ArrayLike | None = None,
        keep: str = "inside",
        capped: bool = False,
        cuts: str = "volume",
    ) -> Box:
        """Box from ``low`` to ``high``, in the world or in coordinates that ``world_from_box`` maps to it.

        ``world_from_box`` is a matrix (4, 4), or a turn (3, 3); with ``volume.world_from_index`` the box is one of voxels. A
        box that it shears is a wedge.
        """
        rows: Any = world_from_box  # they are made there
        return Box(low, high, rows, keep=keep, capped=capped, cuts=cuts)

    @staticmethod
    def sphere(*, center: Vector, radius: float, keep: str = "inside", capped: bool = False, cuts: str = "volume") -> Sphere:
        """Sphere, in world units."""
        return Sphere(center, radius, keep=keep, capped=capped, cuts=cuts)

    @staticmethod
    def mesh(mesh: Any, *, keep: str = "inside", capped: bool = False, cuts: str = "volume") -> Solid:
        """Closed mesh, an ``airlight.Mesh`` or what makes one; its colours do not matter.

        Raises
        ------
        DataError
            For meshes that are open, or enclose nothing.
        """
        return Solid(mesh, keep=keep, capped=capped, cuts=cuts)

    @property
    def unit_from_world(self) -> FloatArray:
        """Matrix (3, 4) to where the shape is x >= 0 (plane), a box from -1 to 1, or a sphere of radius 1."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for scene files: the kind, and the parameters of the function of that name."""
        values = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return {"kind": self.kind} | {name: _plain(value) for name, value in values.items() if value is not None}

    @staticmethod
    def from_dict(data: Mapping[str, Any], place: Callable[[str], str] = str) -> Clip:
        """Return the clip that ``to_dict`` wrote, or a person; ``place`` finds a file that is named relative to another.

        Raises
        ------
        ValueRangeError
            For entries that are unknown, missing or not legal; it names them.
        """
        kind = kind_of(data, KINDS, "clip")
        if kind == "mesh" and "closed" not in data:
            common = {f.name for f in dataclasses.fields(Clip)}
            check_names(data, (*SOLID_ENTRIES, *common), "clip", kind)
            solid = solid_from_dict({name: value for name, value in data.items() if name in SOLID_ENTRIES}, place)
            data = {"closed": solid} | {name: value for name, value in data.items() if name not in SOLID_ENTRIES}
        known = {f.name: f for f in dataclasses.fields(KINDS[kind])}
        given = {name: value for name, value in data.items() if name != "kind"}
        check_names(data, known, "clip", kind)
        for name, field in known.items():
            if field.default is dataclasses.MISSING and name not in given:
                raise ValueRangeError(f"clip.{name}", "is missing", f"a {kind} needs {', '.join(_needed(kind))}")
        return KINDS[kind](**given)


@dataclass(frozen=True)
class Plane(Clip):
    """The side of a plane through ``point`` that ``normal`` points to; its length does not matter."""

    kind: ClassVar[str] = "plane"
    point: Vector
    normal: Vector

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        point, normal = finite_numbers(self.point, "clip.point", 3), direction(self.normal, "clip.normal")
        set_fields(self, point=point, normal=normal)

    @cached_property
    def unit_from_world(self) -> FloatArray:
        """Matrix (3, 4) whose first row is the distance from the plane."""
        normal = np.array(self.normal)
        return np.array([[*normal, -normal @ self.point], [0, 0, 0, 0], [0, 0, 0, 0]])


@dataclass(frozen=True)
class Box(Clip):
    """A box in the world, or in coordinates that ``world_from_box``, four rows of four, maps to it."""

    kind: ClassVar[str] = "box"
    low: Vector
    high: Vector
    world_from_box: tuple[Row, ...] | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        low, high = finite_numbers(self.low, "clip.low", 3), finite_numbers(self.high, "clip.high", 3)
        if not all(a < b for a, b in zip(low, high, strict=True)):
            raise ValueRangeError("clip.high", f"is {high}, and low is {low}", "high must be above low along x, y and z")
        set_fields(self, low=low, high=high, world_from_box=_rows(self.world_from_box))

    @property
    def matrix(self) -> FloatArray:
        """``world_from_box`` as an array (4, 4)."""
        return np.eye(4) if self.world_from_box is None else np.array(self.world_from_box)

    @cached_property
    def unit_from_world(self) -> FloatArray:
        """Matrix (3, 4) that maps low to -1 and high to 1."""
        low, high = np.array(self.low), np.array(self.high)
        rows = np.linalg.inv(self.matrix)[:3]
        rows[:, 3] -= (low + high) / 2
        return np.asarray(rows * (2 / (high - low))[:, None], dtype=np.float64)


@dataclass(frozen=True)
class Sphere(Clip):
    """A sphere, in world units."""

    kind: ClassVar[str] = "sphere"
    center: Vector
    radius: float

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        set_fields(self, center=finite_numbers(self.center, "clip.center", 3), radius=positive(self.radius, "clip.radius"))

    @cached_property
    def unit_from_world(self) -> FloatArray:
        """Matrix (3, 4) to the sphere's middle, in radii."""
        return np.column_stack([np.eye(3), -np.array(self.center)]) / self.radius


@dataclass(frozen=True)
class Solid(Clip):
    """What a closed mesh encloses: where the faces round a point look out in sum."""

    kind: ClassVar[str] = "mesh"
    closed: Mesh

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        closed = self.closed if isinstance(self.closed, Mesh) else Mesh(self.closed)
        set_fields(self, closed=closed)
        assert closed.outward  # told while the clip is made, not while it is drawn

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; the mesh is named by its file.

        Raises
        ------
        DataError
            For meshes that came from no file, or were changed since.
        """
        named = to_dict(self.closed, "clip.mesh")
        common = {f.name: getattr(self, f.name) for f in dataclasses.fields(Clip)}
        return {"kind": self.kind} | {name: named[name] for name in SOLID_ENTRIES if name in named} | common


KINDS: dict[str, type[Clip]] = {cls.kind: cls for cls in (Plane, Box, Sphere, Solid)}


def checked_clips(given: Iterable[Clip], where: str) -> tuple[Clip, ...]:
    """Return clips as a tuple.

    Raises
    ------
    DataError
        When something else is among them.
    """
    listing = "pass a list: clips=[airlight.Clip.plane(point=..., normal=...)]"
    making = "make clips with Clip.plane(), .box(), .sphere() or .mesh()"
    return listed_values(given, tuple(KINDS.values()), where, listing, making)


def _rows(matrix: Any) -> tuple[Row, ...] | None:
    """Rows of a matrix (4, 4), or of one (3, 3) without a shift."""
    if matrix is None:
        return None
    where = "clip.world_from_box"
    try:
        given = np.array(matrix, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape not in ((3, 3), (4, 4)):
        raise ValueRangeError(where, f"is {matrix!r}", "give a matrix, (4, 4), or a turn, (3, 3)")
    full = np.eye(4)
    full[: len(given), : len(given)] = given
    try:
        checked = checked_affine(full, where)
    except DataError as error:
        raise ValueRangeError(where, error.what) from None
    return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in checked)


def _needed(kind: str) -> list[str]:
    return [f.name for f in dataclasses.fields(KINDS[kind]) if f.default is dataclasses.MISSING]


def _plain(value: Any) -> Any:
    return [_plain(part) for part in value] if isinstance(value, tuple) else value
