"""Transfer functions of two and three variables: shapes painted onto a joint histogram, as values."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from . import joint_saving, saving
from .colour import check_colour
from .function import FloatArray
from .given import flag, listed, not_negative
from .joint_axes import Axis, Ramp, check_axes

if TYPE_CHECKING:
    from .joint_shapes import Shape

TABLE_ENTRIES = {2: 256, 3: 64}
MOST_ENTRIES = {2: 2048, 3: 256}


@dataclass(frozen=True)
class JointFunction(saving.Kept):
    """Colour and extinction by two or three variables: shapes on a joint histogram, and nothing outside of them.

    Where shapes overlap, several media share one place: their extinctions add, and so do their sources, so that the colour is
    the mean of theirs weighted by extinction.

    Parameters
    ----------
    axes
        Two or three variables. Outside of the box of the axes the function is empty.
    shapes
        Any number of `Box`, `Triangle`, `Ellipse`, `Polygon`; all of each lies in the box of the axes.
    associated
        Colours are source terms per world unit as they stand, without the factor extinction; they may glow where that is 0.

    Raises
    ------
    ValueRangeError
        For other numbers of axes, a variable given twice, and shapes that have another number of variables or that reach
        outside of the axes; it names the shape.

    Examples
    --------
    >>> axes = Axis("value", 0, 255), Axis("gradient", 0, 40)
    >>> shape = Box((100, 5), (160, 30), colour="white", extinction=2.0)
    >>> rgb, extinction = JointFunction(axes, [shape])([[120, 10], [120, 35]])
    >>> extinction.tolist()
    [2.0, 0.0]
    """

    axes: tuple[Axis, ...]
    shapes: tuple[Shape, ...]
    associated: bool = False

    def __init__(self, axes: Iterable[Axis], shapes: Iterable[Shape] = (), associated: bool = False) -> None:
        object.__setattr__(self, "axes", check_axes(axes))
        object.__setattr__(self, "shapes", listed(shapes, "transfer.shapes", "pass [Box(...), ...]"))
        object.__setattr__(self, "associated", flag(associated, "transfer.associated"))
        for number, shape in enumerate(self.shapes):
            self._check(shape, f"transfer.shapes[{number}]")

    def _check(self, shape: Shape, where: str) -> None:
        from .joint_shapes import Shape  # here: four classes that most programs do without

        if not isinstance(shape, Shape):
            raise ValueRangeError(where, f"is a {type(shape).__name__}", "pass a Box, Triangle, Ellipse or Polygon")
        where = f"{where} ({shape.kind})"
        k = len(self.axes)
        if k not in shape.dimensions:
            raise ValueRangeError(where, f"is for {shape.dimensions[-1]} variables, the function has {k}")
        if shape.ramp is not None and shape.ramp.axis >= k:
            raise ValueRangeError(f"{where}.ramp.axis", f"is {shape.ramp.axis}, must be less than {k}")
        if not self.associated:
            check_colour(shape.colour, f"{where}.colour")
            for number, (_, rgb) in enumerate(shape.ramp.points if shape.ramp else ()):
                check_colour(rgb, f"{where}.ramp.points[{number}].colour")
        for axis, (low, high) in zip(self.axes, shape.bounds(self._spans), strict=True):
            allowance = 1e-9 * axis.span
            if (np.isfinite(low) and low < axis.low - allowance) or (np.isfinite(high) and high > axis.high + allowance):
                found = f"reaches from {low:g} to {high:g} along {axis.variable!r}: shape outside the histogram"
                raise ValueRangeError(where, found, f"must lie in [{axis.low:g}, {axis.high:g}]")

    @cached_property
    def _spans(self) -> FloatArray:
        return np.array([axis.span for axis in self.axes])

    @property
    def variables(self) -> tuple[str | int, ...]:
        """The variables of the axes."""
        return tuple(axis.variable for axis in self.axes)

    def __call__(self, coordinates: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Colour (..., 3) and extinction (...) at coordinates (..., k), float64; the colour is 0 where nothing is."""
        source, extinction = self._sums(coordinates)
        if self.associated:
            return source, extinction
        there = extinction > 0
        return source / np.where(there, extinction, 1.0)[..., None], extinction

    def source(self, coordinates: npt.ArrayLike) -> FloatArray:
        """Source term (..., 3) per world unit at coordinates (..., k): the sum over the shapes."""
        return self._sums(coordinates)[0]

    def _sums(self, coordinates: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        c = np.asarray(coordinates, dtype=np.float64)
        if c.shape[-1:] != (len(self.axes),):
            raise ValueRangeError("coordinates", f"have shape {c.shape}, must end in {len(self.axes)}, one a variable")
        inside = np.logical_and.reduce([(c[..., i] >= a.low) & (c[..., i] <= a.high) for i, a in enumerate(self.axes)])
        # What lies outside, NaN and infinity too, is moved to where weights can be computed, and then counts for nothing.
        c = np.where(inside[..., None], c, [a.low for a in self.axes])
        source, extinction = np.zeros((*c.shape[:-1], 3)), np.zeros(c.shape[:-1])
        for shape in self.shapes:
            weight = shape.weight(c, self._spans) * inside
            factor = weight if self.associated else weight * shape.extinction
            source += factor[..., None] * shape.colours(c)
            extinction += weight * shape.extinction
        return source, extinction

    def table(self, entries: int | None = None) -> npt.NDArray[np.float32]:
        """Texels of (source r, g, b, extinction), all per world unit, at evenly spaced entries from low to high of each axis.

        Sources, not colours: they are what is associated, so that texels mixed by interpolation are right, and no black from
        empty texels bleeds into colours. Two variables: ``(1, n, n, 4)``; three: ``(n, n, n, 4)``; the last axis before the
        channels is the first variable's. Float32, read-only, kept for functions that were asked for lately. Texels know
        nothing of the outside: clamped look-ups go on at the borders, where the function ends.

        Parameters
        ----------
        entries
            Number along each axis, from 2 to 2048, or 256 in three variables; 256 and 64 when left out.

        Raises
        ------
        ValueRangeError
            For other numbers of entries.
        """
        k = len(self.axes)
        n = TABLE_ENTRIES[k] if entries is None else entries
        if not (isinstance(n, Integral) and 2 <= n <= MOST_ENTRIES[k]):
            raise ValueRangeError("entries", f"is {n}, must lie in [2, {MOST_ENTRIES[k]}] for {k} variables")
        return _table(self, int(n))

    @property
    def empty_values(self) -> tuple[tuple[float, float], ...]:
        """Closed intervals of the first variable on which the function is empty, whatever the others are.

        They reach to infinity at both ends, and stop a float32 short of the shapes, like `TransferFunction.empty_stretches`.
        """
        return self.empty_values_widened(0.0)

    def bounds_widened(self, margins: Iterable[float]) -> list[tuple[tuple[float, float], ...]]:
        """Bounds of each shape that holds anything, (low, high) of each variable, further by a margin of each."""
        # A shape that is told to be larger does not get out of the axes' box, where the function ends.
        return [
            tuple(
                (max(float(low) - margin, axis.low), min(float(high) + margin, axis.high))
                for axis, margin, (low, high) in zip(self.axes, margins, shape.bounds(self._spans), strict=True)
            )
            for shape in self.shapes
            if shape.extinction > 0 or (self.associated and not shape.is_black)
        ]

    def empty_values_widened(self, margin: float) -> tuple[tuple[float, float], ...]:
        """``empty_values`` where each shape reaches further by ``margin``, in units of the first variable.

        A table of n entries that is interpolated reaches further than its shapes by up to ``axes[0].span / (n - 1)``.
        """
        taken = sorted(bounds[0] for bounds in self.bounds_widened((margin,) * len(self.axes)))
        found: list[tuple[float, float]] = []
        begin = -np.inf
        for low, high in taken:
            end = just(low, -np.inf)
            if end > begin:
                found.append((begin, end))
            begin = max(begin, just(high, np.inf))
        return (*found, (begin, np.inf))

    def scaled(self, density: float) -> JointFunction:
        """Return the function with extinctions (and associated colours) multiplied by ``density``."""
        density = not_negative(density, "density")
        tint = density if self.associated else 1.0
        return JointFunction(self.axes, [_scaled(shape, density, tint) for shape in self.shapes], self.associated)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as scene files keep it."""
        axes = [{"variable": a.variable, "low": a.low, "high": a.high} for a in self.axes]
        data = {"axes": axes, "shapes": [shape.to_dict() for shape in self.shapes]}
        return data | ({"associated": True} if self.associated else {})

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> JointFunction:
        """Return the function that ``to_dict`` wrote.

        Raises
        ------
        ValueRangeError
            For entries that are unknown, missing or not legal; it names them.
        """
        unknown = sorted(set(data) - {"axes", "shapes", "associated"})
        if unknown:
            raise ValueRangeError("transfer", f"has unknown entries {unknown}", "use axes, shapes and associated")
        given = {name: listed(data.get(name, ()), f"transfer.{name}", "write a list of tables") for name in ("axes", "shapes")}
        axes = [_made(_axis_from_dict, a, f"transfer.axes[{i}]") for i, a in enumerate(given["axes"])]
        from .joint_shapes import shape_from_dict

        shapes = [_made(shape_from_dict, s, f"transfer.shapes[{i}]") for i, s in enumerate(given["shapes"])]
        return cls(axes, shapes, associated=data.get("associated", False))

    as_code = joint_saving.as_code


@lru_cache(maxsize=4)
def _table(function: JointFunction, n: int) -> npt.NDArray[np.float32]:
    lines = [np.linspace(axis.low, axis.high, n) for axis in function.axes]
    texels = np.empty((1 if len(lines) == 2 else n, n, n, 4), dtype=np.float32)
    # A layer at a time: float64 of all entries of three variables would be large.
    for layer, third in enumerate(lines[2] if len(lines) == 3 else (None,)):
        second, first = np.meshgrid(lines[1], lines[0], indexing="ij")
        parts = [first, second] if third is None else [first, second, np.full_like(first, third)]
        source, extinction = function._sums(np.stack(parts, axis=-1))
        texels[layer, ..., :3], texels[layer, ..., 3] = source, extinction
    texels.flags.writeable = False
    return texels


def just(value: float, towards: float) -> float:
    """Return the next float32 behind a value."""
    return float(np.nextafter(np.float32(value), np.float32(towards)))


def _scaled(shape: Shape, density: float, tint: float) -> Shape:
    rgb = tuple(tint * float(c) for c in shape.colour)
    ramp = shape.ramp
    if ramp is not None:
        ramp = Ramp(ramp.axis, tuple((c, tuple(tint * float(x) for x in colour)) for c, colour in ramp.points))
    return dataclasses.replace(shape, colour=rgb, extinction=density * shape.extinction, ramp=ramp)


def _axis_from_dict(data: dict[str, Any]) -> Axis:
    if set(data) != {"variable", "low", "high"}:
        raise ValueRangeError("axis", f"has entries {sorted(data)}", "give variable, low and high")
    return Axis(**data)


def _made(make: Any, data: Any, where: str) -> Any:
    """Make a part of plain data; what is wrong with it is told with its place."""
    if not isinstance(data, dict):
        raise ValueRangeError(where, f"is {data!r}, must be a table")
    try:
        return make(data)
    except ValueRangeError as error:
        raise ValueRangeError(f"{where} {error.where}", error.what, error.remedy) from None
