"""Clips: shapes in the world of which what lies inside, or what lies outside, is drawn."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .errors import DataError, ValueRangeError
from .transfer.given import direction, finite_numbers, flag, listed, positive, set_fields
from .volume import FloatArray, checked_affine

Vector = tuple[float, float, float]
Row = tuple[float, float, float, float]

KEEP = ("inside", "outside")


@dataclass(frozen=True)
class Clip:
    """Part of the world that is drawn; make one with ``Clip.plane``, ``Clip.box`` or ``Clip.sphere``.

    A point is drawn when every clip keeps it. Slabs end where rays pass a clip's surface, whatever the step.

    Attributes
    ----------
    keep
        Which side is drawn: ``"inside"`` or ``"outside"`` of the shape. Inside of a plane is where its normal points to.
    capped
        Whether the cut is drawn as a solid face, in the colours of the transfer function, wherever that has an extinction.
    """

    kind: ClassVar[str] = "none"
    keep: str = dataclasses.field(default="inside", kw_only=True)
    capped: bool = dataclasses.field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        """Check the values."""
        if self.keep not in KEEP:
            raise ValueRangeError("clip.keep", f"is {self.keep!r}, must be one of {', '.join(KEEP)}")
        set_fields(self, capped=flag(self.capped, "clip.capped"))

    @staticmethod
    def plane(*, point: Vector, normal: Vector, keep: str = "inside", capped: bool = False) -> Plane:
        """Half of the world: the side of a plane through ``point`` that ``normal`` points to."""
        return Plane(point, normal, keep=keep, capped=capped)

    @staticmethod
    def box(
        *, low: Vector, high: Vector, world_from_box: npt.ArrayLike | None = None, keep: str = "inside", capped: bool = False
    ) -> Box:
        """Box from ``low`` to ``high``, in the world or in coordinates that ``world_from_box`` maps to it.

        ``world_from_box`` is a matrix (4, 4), or a turn (3, 3); with ``volume.world_from_index`` the box is one of voxels. A
        box that it shears is a wedge.
        """
        return Box(low, high, world_from_box, keep=keep, capped=capped)  # type: ignore[arg-type]  # rows are made there

    @staticmethod
    def sphere(*, center: Vector, radius: float, keep: str = "inside", capped: bool = False) -> Sphere:
        """Sphere, in world units."""
        return Sphere(center, radius, keep=keep, capped=capped)

    @property
    def unit_from_world(self) -> FloatArray:
        """Matrix (3, 4) to where the shape is x >= 0 (plane), a box from -1 to 1, or a sphere of radius 1."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for scene files: the kind, and the parameters of the function of that name."""
        values = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return {"kind": self.kind} | {name: _plain(value) for name, value in values.items() if value is not None}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Clip:
        """Return the clip that ``to_dict`` wrote, or a person.

        Raises
        ------
        ValueRangeError
            For entries that are unknown, missing or not legal; it names them.
        """
        kind = data.get("kind")
        if not isinstance(kind, str) or kind not in KINDS:
            raise ValueRangeError("clip.kind", f"is {kind!r}, must be one of {', '.join(KINDS)}")
        known = {f.name: f for f in dataclasses.fields(KINDS[kind])}
        given = {name: value for name, value in data.items() if name != "kind"}
        for name in given:
            if name not in known:
                raise ValueRangeError(f"clip.{name}", f"is no parameter of {kind}", f"it has {', '.join(known)}")
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


KINDS: dict[str, type[Clip]] = {cls.kind: cls for cls in (Plane, Box, Sphere)}


def checked_clips(given: Iterable[Clip], where: str) -> tuple[Clip, ...]:
    """Return clips as a tuple.

    Raises
    ------
    DataError
        When something else is among them.
    """
    clips = listed(given, where, "pass a list: clips=[airlight.Clip.plane(point=..., normal=...)]")
    for clip in clips:
        if not isinstance(clip, Clip) or clip.kind not in KINDS:
            raise DataError(where, f"holds {clip!r}", "make clips with Clip.plane(), .box() or .sphere()")
    return clips


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
