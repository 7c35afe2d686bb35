"""Shapes of transfer functions of two and three variables: how much of a medium there is at each place of a histogram.

A shape has a weight between 0 and 1, and none outside of its bounds. Coordinates are ``(..., k)`` for k variables, in the
variables' own units; ``spans`` (k,) are the widths of the function's axes, which angles need: they are as seen on a square
picture of the histogram. Shapes of the plane (`Triangle`, `Polygon`) reach along a third axis over ``third``, an interval
with both its ends, or over the whole axis where that is None.
"""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .colour import Colour, linear_rgb
from .function import FloatArray
from .given import finite, finite_numbers, listed, not_negative, set_fields, share
from .joint_axes import Ramp

GAUSS_AT_RADIUS = float(np.exp(-4.5))
"""What a Gaussian has left at three standard deviations, which is where an ellipse ends."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """What all shapes have in common.

    Parameters
    ----------
    colour
        Linear ``(r, g, b)`` or an sRGB word (stored linear); in associated functions the source per world unit.
    extinction
        Per world unit of length, where the weight is 1.
    ramp
        Colours along an axis, instead of ``colour``.
    """

    colour: Colour = (1.0, 1.0, 1.0)
    extinction: float = 1.0
    ramp: Ramp | None = None

    kind: ClassVar[str]

    def __post_init__(self) -> None:
        extinction = not_negative(self.extinction, f"{self.kind}.extinction")
        if self.ramp is not None and not isinstance(self.ramp, Ramp):
            raise ValueRangeError(f"{self.kind}.ramp", f"is {self.ramp!r}", "pass a Ramp")
        set_fields(self, colour=linear_rgb(self.colour, f"{self.kind}.colour"), extinction=extinction)

    @property
    @abstractmethod
    def dimensions(self) -> tuple[int, ...]:
        """Numbers of variables that the shape can have."""

    @abstractmethod
    def bounds(self, spans: FloatArray) -> FloatArray:
        """Lowest and highest coordinates (k, 2) of the shape; infinite along axes that it fills."""

    @abstractmethod
    def weight(self, coordinates: FloatArray, spans: FloatArray) -> FloatArray:
        """Weight (...) in [0, 1] at finite coordinates (..., k)."""

    def colours(self, coordinates: FloatArray) -> FloatArray:
        """Linear colours (..., 3), or (3,) where one holds everywhere."""
        return np.array(self.colour) if self.ramp is None else self.ramp(coordinates)

    @property
    def is_black(self) -> bool:
        """Whether all its colours are black."""
        colours = [self.colour] if self.ramp is None else [c for _, c in self.ramp.points]
        return not np.any(colours)

    def chosen(self) -> dict[str, Any]:
        """Fields that are not left to their defaults, by name, in the order in which a call takes them."""
        fields = sorted(dataclasses.fields(self), key=lambda field: bool(field.kw_only))
        return {f.name: v for f in fields if (v := getattr(self, f.name)) != f.default or f.name in ("colour", "extinction")}

    def to_dict(self) -> dict[str, Any]:
        """Plain data: ``kind``, and the fields that were chosen."""
        chosen = {n: dataclasses.asdict(v) if isinstance(v, Ramp) else v for n, v in self.chosen().items()}
        return {"kind": self.kind} | {name: _plain(value) for name, value in chosen.items()}

    # Checks of fields, which name the shape's kind and the field.

    def _number(self, name: str) -> float:
        return finite(getattr(self, name), f"{self.kind}.{name}")

    def _share(self, name: str) -> float:
        return share(getattr(self, name), f"{self.kind}.{name}")

    def _numbers(self, name: str, *lengths: int) -> tuple[float, ...]:
        return finite_numbers(getattr(self, name), f"{self.kind}.{name}", *lengths)

    def _interval(self, name: str) -> tuple[float, float] | None:
        if getattr(self, name) is None:
            return None
        low, high = self._numbers(name, 2)
        if not high > low:
            raise ValueRangeError(f"{self.kind}.{name}", f"is ({low:g}, {high:g}), must rise")
        return low, high


@dataclass(frozen=True)
class Box(Shape):
    """A box with soft or hard edges.

    Parameters
    ----------
    low, high
        Corners, one coordinate a variable; ``high`` above ``low``.
    edge
        Share of the half widths over which the weight rises from 0 at the sides to 1 inside; 0 is hard, sides included.

    Raises
    ------
    ValueRangeError
        For coordinates that are not finite, ``high`` not above ``low``, an edge outside of [0, 1].
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    edge: float = 0.0

    kind: ClassVar[str] = "box"

    def __post_init__(self) -> None:
        super().__post_init__()
        low = self._numbers("low", 2, 3)
        high = self._numbers("high", len(low))
        if not all(h > lo for lo, h in zip(low, high, strict=True)):
            raise ValueRangeError("box.high", f"is {high}, must be above low {low} along each axis")
        set_fields(self, low=low, high=high, edge=self._share("edge"))

    @property
    def dimensions(self) -> tuple[int, ...]:
        """As many variables as the corners have coordinates."""
        return (len(self.low),)

    def bounds(self, spans: FloatArray) -> FloatArray:
        """Both corners."""
        return np.array([self.low, self.high]).T

    def weight(self, coordinates: FloatArray, spans: FloatArray) -> FloatArray:
        """Rise with the distance from the nearest side, in half widths."""
        low, high = np.array(self.low), np.array(self.high)
        inside = np.minimum(coordinates - low, high - coordinates) / ((high - low) / 2)
        return _risen(np.asarray(inside.min(axis=-1)), self.edge)


@dataclass(frozen=True)
class Triangle(Shape):
    """Triangle on its tip over a value: a surface of constant thickness, whatever its contrast.

    Levoy 1988, section 3 (iso-value regions): where the gradient is g, values within ``r g`` of the iso-value lie within about
    r of the surface. The tip stands at ``(value, tip)``; at ``top`` the half width is ``half_width``, so r is
    ``half_width / (top - tip)``. Cut off below ``low`` it leaves out what is homogeneous (the triangular widget of Kniss,
    Kindlmann and Hansen 2002).

    Parameters
    ----------
    value
        Coordinate of the tip and the middle along the first axis.
    half_width
        Half the width at ``top``, in units of the first axis.
    top
        Where it ends along the second axis (the gradient's, mostly).
    low
        Where it begins along the second axis, from ``tip`` to below ``top``; the tip when left out.
    tip
        Where its width is 0.
    edge
        Share of the half width over which the weight falls to 0 at the sides; 1, a tent, is Levoy's.
    third
        Interval along the third axis, for functions of three variables.

    Raises
    ------
    ValueRangeError
        For numbers that are not finite, a half width not above 0, and unless ``tip <= low < top``.
    """

    value: float
    half_width: float
    top: float
    low: float | None = None
    tip: float = 0.0
    edge: float = 1.0
    third: tuple[float, float] | None = None

    kind: ClassVar[str] = "triangle"

    def __post_init__(self) -> None:
        super().__post_init__()
        value, half_width, top, tip = (self._number(name) for name in ("value", "half_width", "top", "tip"))
        low = None if self.low is None else self._number("low")
        if not half_width > 0:
            raise ValueRangeError("triangle.half_width", f"is {half_width:g}, must be positive")
        if not tip < top:
            raise ValueRangeError("triangle.top", f"is {top:g}, must be above the tip {tip:g}")
        if low is not None and not tip <= low < top:
            raise ValueRangeError("triangle.low", f"is {low:g}, must lie from the tip {tip:g} to below the top {top:g}")
        set_fields(self, value=value, half_width=half_width, top=top, low=low, tip=tip)
        set_fields(self, edge=self._share("edge"), third=self._interval("third"))

    @property
    def dimensions(self) -> tuple[int, ...]:
        """Two, or three with the interval ``third``."""
        return (2, 3) if self.third is None else (3,)

    @property
    def _begin(self) -> float:
        return self.tip if self.low is None else self.low

    def bounds(self, spans: FloatArray) -> FloatArray:
        """Half width to both sides, from ``low`` to ``top``."""
        across = self.value - self.half_width, self.value + self.half_width
        return _with_third([across, (self._begin, self.top)], self.third, spans)

    def weight(self, coordinates: FloatArray, spans: FloatArray) -> FloatArray:
        """Fall to the sides; nothing at the tip itself, which has no width."""
        above = coordinates[..., 1]
        half = self.half_width * (above - self.tip) / (self.top - self.tip)
        wide = (above >= self._begin) & (above <= self.top) & (above > self.tip)
        # Just above the tip the width may be too small to divide by.
        wide &= half > 1e-300
        near = np.abs(coordinates[..., 0] - self.value) <= half
        aside = np.where(wide & near, np.abs(coordinates[..., 0] - self.value) / np.where(wide & near, half, 1.0), 2.0)
        return np.asarray(_risen(1 - aside, self.edge) * _in_third(coordinates, self.third))


@dataclass(frozen=True)
class Ellipse(Shape):
    """Gaussian over an ellipse, or an ellipsoid in three variables.

    The weight is a Gaussian whose third standard deviation is the border, lowered and scaled so that it is 1 in the middle
    and 0 at the border and beyond.

    Parameters
    ----------
    centre
        One coordinate a variable.
    radii
        Half axes, in units of the variables.
    angle_rad
        Turn in the plane of the first two axes, from the first towards the second, as seen on a square histogram.

    Raises
    ------
    ValueRangeError
        For numbers that are not finite, and radii that are not positive.
    """

    centre: tuple[float, ...]
    radii: tuple[float, ...]
    angle_rad: float = 0.0

    kind: ClassVar[str] = "ellipse"

    def __post_init__(self) -> None:
        super().__post_init__()
        centre = self._numbers("centre", 2, 3)
        radii = self._numbers("radii", len(centre))
        if not all(r > 0 for r in radii):
            raise ValueRangeError("ellipse.radii", f"are {radii}, must be positive")
        set_fields(self, centre=centre, radii=radii, angle_rad=self._number("angle_rad"))

    @property
    def dimensions(self) -> tuple[int, ...]:
        """As many variables as the centre has coordinates."""
        return (len(self.centre),)

    def bounds(self, spans: FloatArray) -> FloatArray:
        """Box around the turned ellipse."""
        reach = np.array(self.radii)
        if self.angle_rad:
            c, s = np.cos(self.angle_rad), np.sin(self.angle_rad)
            across, up = reach[:2] / spans[:2]
            reach[:2] = np.hypot([across * c, across * s], [up * s, up * c]) * spans[:2]
        return np.array(self.centre)[:, None] + np.outer(reach, [-1.0, 1.0])

    def weight(self, coordinates: FloatArray, spans: FloatArray) -> FloatArray:
        """Gaussian of the distance from the centre in radii."""
        away = coordinates - np.array(self.centre)
        if self.angle_rad:
            c, s = np.cos(self.angle_rad), np.sin(self.angle_rad)
            x, y = away[..., 0] / spans[0], away[..., 1] / spans[1]
            away[..., 0], away[..., 1] = (c * x + s * y) * spans[0], (c * y - s * x) * spans[1]
        squared = np.minimum(((away / np.array(self.radii)) ** 2).sum(axis=-1), 1.0)
        return np.asarray((np.exp(-4.5 * squared) - GAUSS_AT_RADIUS) / (1 - GAUSS_AT_RADIUS))


@dataclass(frozen=True)
class Polygon(Shape):
    """Any polygon in the plane of the first two axes; where it crosses itself, what is enclosed an odd number of times.

    Parameters
    ----------
    vertices
        Three or more ``(first, second)``; the last is joined to the first.
    edge
        Share of half the size of the bounding box over which the weight rises from 0 at the border to 1 inside: distances are
        taken where that box is a square. A rectangle is the same as a `Box`.
    third
        Interval along the third axis, for functions of three variables.

    Raises
    ------
    ValueRangeError
        For less than three vertices, numbers that are not finite, no extent along an axis, an edge outside of [0, 1].
    """

    vertices: tuple[tuple[float, float], ...]
    edge: float = 0.0
    third: tuple[float, float] | None = None

    kind: ClassVar[str] = "polygon"

    def __post_init__(self) -> None:
        super().__post_init__()
        given = listed(self.vertices, "polygon.vertices", "give three or more (first, second)")
        vertices = tuple(finite_numbers(v, f"polygon.vertices[{i}]", 2) for i, v in enumerate(given))
        if len(vertices) < 3 or not np.ptp(np.array(vertices), axis=0).all():
            raise ValueRangeError("polygon.vertices", f"are {vertices}", "give three or more, not on one line along an axis")
        set_fields(self, vertices=vertices, edge=self._share("edge"), third=self._interval("third"))

    @property
    def dimensions(self) -> tuple[int, ...]:
        """Two, or three with the interval ``third``."""
        return (2, 3) if self.third is None else (3,)

    def bounds(self, spans: FloatArray) -> FloatArray:
        """Box around the vertices."""
        first, second = np.array(self.vertices).T
        return _with_third([(first.min(), first.max()), (second.min(), second.max())], self.third, spans)

    def weight(self, coordinates: FloatArray, spans: FloatArray) -> FloatArray:
        """Rise with the distance from the border."""
        corners = np.array(self.vertices)
        low, half = corners.min(axis=0), np.ptp(corners, axis=0) / 2
        corners = (corners - low) / half
        x, y = np.moveaxis((coordinates[..., :2] - low) / half, -1, 0)
        inside = np.zeros(x.shape, dtype=bool)
        squared = np.full(x.shape, np.inf)
        for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            dx, dy = bx - ax, by - ay
            passes = (ay > y) != (by > y)
            inside ^= passes & (x < ax + np.where(passes, y - ay, 0.0) / (dy or 1.0) * dx)
            along = np.clip(((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-300), 0.0, 1.0)
            squared = np.minimum(squared, (x - ax - along * dx) ** 2 + (y - ay - along * dy) ** 2)
        risen = _risen(np.sqrt(squared), self.edge)
        return np.asarray(risen * inside * _in_third(coordinates, self.third))


SHAPES: dict[str, type[Shape]] = {cls.kind: cls for cls in (Box, Triangle, Ellipse, Polygon)}


def shape_from_dict(data: dict[str, Any]) -> Shape:
    """Return the shape that ``Shape.to_dict`` wrote.

    Raises
    ------
    ValueRangeError
        For an unknown kind, and fields that are unknown, missing or not legal.
    """
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ValueRangeError("kind", f"is {kind!r}, must be one of {', '.join(SHAPES)}")
    cls = SHAPES[kind]
    known = {f.name: f.default for f in dataclasses.fields(cls)}
    values = {name: value for name, value in data.items() if name != "kind"}
    unknown = sorted(set(values) - set(known))
    missing = sorted(n for n, default in known.items() if default is dataclasses.MISSING and n not in values)
    if unknown or missing:
        what = f"has unknown entries {unknown}" if unknown else f"lacks {', '.join(missing)}"
        raise ValueRangeError(kind, what, f"it has {', '.join(known)}")
    if isinstance(values.get("ramp"), dict):
        if set(values["ramp"]) != {"axis", "points"}:
            raise ValueRangeError(f"{kind}.ramp", f"has entries {sorted(values['ramp'])}", "give axis and points")
        values["ramp"] = Ramp(**values["ramp"])
    return cls(**values)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def _risen(distance: FloatArray, edge: float) -> FloatArray:
    """1 from a distance of ``edge`` inside, falling to 0 at the border; a hard border belongs to the inside."""
    return np.clip(distance / edge, 0.0, 1.0) if edge > 1e-9 else (distance >= 0).astype(np.float64)


def _in_third(coordinates: FloatArray, third: tuple[float, float] | None) -> npt.NDArray[np.bool_] | float:
    if third is None:
        return 1.0
    return np.asarray((coordinates[..., 2] >= third[0]) & (coordinates[..., 2] <= third[1]))


def _with_third(plane: list[tuple[float, float]], third: tuple[float, float] | None, spans: FloatArray) -> FloatArray:
    return np.array([*plane, third or (-np.inf, np.inf)][: len(spans)], dtype=np.float64)
