"""Transfer functions of one variable: from values to linear-light colour and extinction."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .colour import Colour, linear_rgb

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, tuple[float, float, float], float]


@dataclass(frozen=True)
class TransferFunction:
    """Piecewise linear in (colour, extinction) between control points, constant beyond the ends.

    Parameters
    ----------
    points
        ``(value, colour, extinction)``, values in data units and not decreasing, colours linear ``(r, g, b)`` or sRGB words,
        extinction per world unit. Two points at one value are a step; at the value itself the later one holds.
    associated
        Colours are source terms ``c~`` as they stand, without the factor extinction; they may glow where extinction is 0.

    Raises
    ------
    ValueRangeError
        Names the point whose value is not finite or out of order, whose extinction is negative, or whose colour is not legal.

    Examples
    --------
    >>> tf = TransferFunction([(0, "black", 0.0), (300, (1, 0.6, 0.4), 0.02), (1200, "white", 0.5)])
    >>> rgb, extinction = tf([300.0, 750.0])
    >>> extinction.tolist()
    [0.02, 0.26]
    """

    points: tuple[Point, ...]
    associated: bool = False

    def __init__(self, points: Iterable[tuple[float, Colour, float]], associated: bool = False) -> None:
        object.__setattr__(self, "points", _checked(points))
        object.__setattr__(self, "associated", bool(associated))

    @cached_property
    def values(self) -> FloatArray:
        """Values (n,) of the control points."""
        return np.array([p[0] for p in self.points])

    @cached_property
    def colours(self) -> FloatArray:
        """Linear colours (n, 3) of the control points."""
        return np.array([p[1] for p in self.points])

    @cached_property
    def extinctions(self) -> FloatArray:
        """Extinctions (n,) of the control points, per world unit."""
        return np.array([p[2] for p in self.points])

    @property
    def domain(self) -> tuple[float, float]:
        """First and last value."""
        return self.points[0][0], self.points[-1][0]

    @cached_property
    def half_extinction_value(self) -> float:
        """Least value at which extinction reaches half of its maximum; beyond all values where there is no extinction."""
        half = self.extinctions.max() / 2
        if half == 0:
            return float(np.finfo(np.float32).max)
        last = int(np.argmax(self.extinctions >= half))
        if last == 0 or self.extinctions[last] == self.extinctions[last - 1]:
            return float(self.values[last])
        share = (half - self.extinctions[last - 1]) / (self.extinctions[last] - self.extinctions[last - 1])
        return float(self.values[last - 1] + share * (self.values[last] - self.values[last - 1]))

    @cached_property
    def empty_stretches(self) -> tuple[tuple[float, float], ...]:
        """Closed intervals of values, ends included, on which extinction and source are zero; they may reach to infinity."""
        full = (self.extinctions > 0) | (self.associated & (self.colours > 0).any(axis=1))
        # A segment is empty where both its ends are; a stretch is a run of empty points, and infinite beyond the ends.
        found: list[tuple[float, float]] = []
        low: float | None = -np.inf
        last = -np.inf
        for value, is_full in zip(self.values, full, strict=True):
            if is_full:
                # A step holds at its very value, so the stretch before it ends just below it.
                end = float(np.nextafter(np.float32(last), np.float32(-np.inf))) if value == last else last
                if low is not None and end > low:
                    found.append((low, end))
                low = None
            elif low is None:
                low = float(value)
            last = float(value)
        if low is not None:
            found.append((low, np.inf))
        return tuple(found)

    def __call__(self, values: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Colour (..., 3) and extinction (...) at values (...), float64."""
        s = np.asarray(values, dtype=np.float64)
        upper = np.searchsorted(self.values, s, side="right")
        lower = np.clip(upper - 1, 0, len(self.values) - 1)
        upper = np.clip(upper, 0, len(self.values) - 1)
        width = self.values[upper] - self.values[lower]
        share = np.where(width > 0, (s - self.values[lower]) / np.where(width > 0, width, 1.0), 0.0)
        rgb = self.colours[lower] * (1 - share[..., None]) + self.colours[upper] * share[..., None]
        return rgb, self.extinctions[lower] * (1 - share) + self.extinctions[upper] * share

    def source(self, values: npt.ArrayLike) -> FloatArray:
        """Source term (..., 3) per world unit: colour times extinction, or the colour itself where associated."""
        rgb, extinction = self(values)
        return rgb if self.associated else rgb * extinction[..., None]

    def scaled(self, density: float) -> TransferFunction:
        """Return the function with extinctions (and associated colours) multiplied by ``density``."""
        if not (np.isfinite(density) and density >= 0):
            raise ValueRangeError("density", f"is {density}, must be at least 0")
        tint = density if self.associated else 1.0
        return replace_points(self, [(v, tuple(tint * c for c in rgb), density * e) for v, rgb, e in self.points])

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as scene files keep it."""
        data: dict[str, Any] = {"points": [[v, list(rgb), e] for v, rgb, e in self.points]}
        return data | ({"associated": True} if self.associated else {})

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> TransferFunction:
        """Return the function that ``to_dict`` wrote."""
        unknown = set(data) - {"points", "associated"}
        if unknown:
            raise ValueRangeError("transfer", f"has unknown entries {sorted(unknown)}", "use points and associated")
        return cls([tuple(p) for p in data.get("points", ())], associated=data.get("associated", False))


def replace_points(function: TransferFunction, points: Iterable[tuple[float, Colour, float]]) -> TransferFunction:
    """Return the same function with other points."""
    return replace(function, points=tuple(points))  # type: ignore[arg-type]


def _checked(points: Iterable[tuple[float, Colour, float]]) -> tuple[Point, ...]:
    checked: list[Point] = []
    for number, point in enumerate(points):
        where = f"transfer.points[{number}]"
        if not isinstance(point, (tuple, list)) or len(point) != 3:
            raise ValueRangeError(where, f"is {point!r}", "give (value, colour, extinction)")
        value, colour, extinction = float(point[0]), point[1], float(point[2])
        if not np.isfinite(value):
            raise ValueRangeError(where, f"has value {value}, must be finite")
        if not np.isfinite(extinction) or extinction < 0:
            raise ValueRangeError(where, f"has extinction {extinction}, must be finite and at least 0")
        if checked and value < checked[-1][0]:
            raise ValueRangeError(where, f"has value {value:g}, below the {checked[-1][0]:g} before it", "sort the points")
        checked.append((value, linear_rgb(colour, f"{where}.colour"), extinction))
    if not checked:
        raise ValueRangeError("transfer.points", "is empty", "give at least one (value, colour, extinction)")
    return tuple(checked)
