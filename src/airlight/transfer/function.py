"""Transfer functions of one variable: from values to linear-light colour and extinction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from . import attenuation, colormaps, combine, conversions, opacity, saving, shapes
from . import surfaces as sheets
from .colour import MOST_COLOUR, Colour, linear_rgb
from .given import finite, flag, listed, not_negative, rising_range
from .surfaces import Surface, checked_surfaces

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, tuple[float, float, float], float]


@dataclass(frozen=True)
class TransferFunction(saving.Kept):
    """Piecewise linear in (colour, extinction) between control points, constant beyond the ends.

    Parameters
    ----------
    points
        ``(value, colour, extinction)``, values in data units and not decreasing, colours linear ``(r, g, b)`` or sRGB words,
        extinction per world unit. Two points at one value are a step; at the value itself the later one holds. 1 is all of the
        light; colours may glow up to 16.
    associated
        Colours are source terms ``c~`` as they stand, without the factor extinction; they may glow where extinction is 0, and
        as much as they like.
    surfaces
        Surfaces of equal value beside the medium, at most 1024 `Surface`; no two at one value. They are kept in order.

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
    surfaces: tuple[Surface, ...] = ()

    def __init__(
        self,
        points: Iterable[tuple[float, Colour, float]],
        associated: bool = False,
        surfaces: Iterable[Surface] = (),
    ) -> None:
        object.__setattr__(self, "associated", flag(associated, "transfer.associated"))
        object.__setattr__(self, "points", _checked(points, None if self.associated else MOST_COLOUR))
        object.__setattr__(self, "surfaces", checked_surfaces(surfaces))

    @cached_property
    def _hash(self) -> int:
        return hash((self.associated, self.points, self.surfaces))

    def __hash__(self) -> int:
        """Return the hash of the content, found once: many things are kept by function."""
        return self._hash

    @cached_property
    def values(self) -> FloatArray:
        """Values (n,) of the control points."""
        return _read_only(np.array([p[0] for p in self.points]))

    @cached_property
    def colours(self) -> FloatArray:
        """Linear colours (n, 3) of the control points."""
        return _read_only(np.array([p[1] for p in self.points]))

    @cached_property
    def extinctions(self) -> FloatArray:
        """Extinctions (n,) of the control points, per world unit."""
        return _read_only(np.array([p[2] for p in self.points]))

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
        """Closed intervals of values, ends included, on which extinction and source are zero; they may reach to infinity.

        No surface lies between two values of one interval: intervals are cut at surfaces, which belong to the upper part.
        """
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
        return sheets.cut_stretches(found, self.surfaces)

    @cached_property
    def plateaus(self) -> tuple[tuple[float, float], ...]:
        """Closed intervals of values, ends included, on which one medium is that is not nothing; they may reach to infinity."""
        media = np.column_stack([self.colours, self.extinctions])
        first = np.flatnonzero(np.append(True, (media[1:] != media[:-1]).any(axis=1)))
        last = np.append(first[1:] - 1, len(media) - 1)
        is_full = (self.extinctions > 0) | (self.associated & (self.colours > 0).any(axis=1))
        found = []
        for a, b in zip(first[is_full[first]], last[is_full[first]], strict=True):
            low, high = float(self.values[a]), float(self.values[b])
            # A step holds at its very value, so the stretch before it ends just below it.
            if b + 1 < len(media) and self.values[b + 1] == high:
                high = float(np.nextafter(np.float32(high), np.float32(-np.inf)))
            ends = (low if a else -np.inf, high if b + 1 < len(media) else np.inf)
            found += [ends] if ends[0] < ends[1] else []
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
        """Return the function with extinctions (and associated colours) multiplied by ``density``.

        So are the optical thicknesses of surfaces: their opacities become ``1 - (1 - opacity)**density``.
        """
        density = not_negative(density, "density")
        tint = density if self.associated else 1.0
        points = [(v, tuple(tint * c for c in rgb), density * e) for v, rgb, e in self.points]
        return replace_points(self, points, (surface.scaled(density) for surface in self.surfaces))

    def with_opacity(self, opacity_over: float, length: float) -> TransferFunction:
        """Return the function scaled so that its greatest extinction has an opacity in [0, 1] over a length in world units.

        Surfaces stay as they are.

        Raises
        ------
        ValueRangeError
            When the opacity or the length is out of range, or the function has no extinction to scale.
        """
        wanted = float(opacity.extinction_from_opacity(opacity_over, length))
        greatest = float(self.extinctions.max())
        if greatest == 0:
            raise ValueRangeError("transfer", "has no extinction", "there is nothing to scale")
        return replace(self.scaled(wanted / greatest), surfaces=self.surfaces)

    def shifted(self, by: float) -> TransferFunction:
        """Return the function with all values moved up by ``by``, in data units."""
        by = finite(by, "transfer.shifted.by")
        moved = (replace(surface, value=surface.value + by) for surface in self.surfaces)
        return replace_points(self, [(v + by, rgb, e) for v, rgb, e in self.points], moved)

    def rescaled(self, to: tuple[float, float]) -> TransferFunction:
        """Return the function for another range of values: its domain is stretched and moved onto ``to``, extinctions stay.

        Surfaces are moved in the same way.

        Raises
        ------
        ValueRangeError
            When ``to`` does not rise, or the function has one value alone.
        """
        (first, last), (low, high) = self.domain, rising_range(to, "transfer.rescaled.to")
        if first == last:
            raise ValueRangeError("transfer", f"has the one value {first:g}, which has no range", "use shifted")
        shares = ((v - first) / (last - first) for v, _, _ in self.points)
        # The last point lies on the very end.
        values = [low + share * (high - low) if share < 1 else high for share in shares]
        places = [low + (surface.value - first) / (last - first) * (high - low) for surface in self.surfaces]
        moved = (replace(surface, value=v) for v, surface in zip(places, self.surfaces, strict=True))
        return replace_points(self, [(v, rgb, e) for v, (_, rgb, e) in zip(values, self.points, strict=True)], moved)

    def clipped(self, low: float, high: float) -> TransferFunction:
        """Return what lies in ``[low, high)``, in data units; outside there is nothing. Its steps are exact.

        Raises
        ------
        ValueRangeError
            When the range does not rise.
        """
        low, high = rising_range((low, high), "transfer.clipped")
        inside = (surface for surface in self.surfaces if low <= surface.value < high)
        return replace_points(self, combine.clipped(self, low, high), inside)

    def with_reversed_colours(self) -> TransferFunction:
        """Return the function with its colours in the opposite order over its domain; extinctions stay where they are."""
        return replace_points(self, combine.mirrored(self))

    def __add__(self, other: TransferFunction) -> TransferFunction:
        """Return both media in one place: extinctions and sources add, so colours are weighted by extinction.

        Extinction is exact; colour is within 1/1000 of the brightest colour, by points that are put in. All control points and
        steps stay.

        Raises
        ------
        ValueRangeError
            When one is associated and the other is not, or both have a surface at one value.
        """
        if not isinstance(other, TransferFunction):
            return NotImplemented
        return replace_points(self, combine.added(self, other), (*self.surfaces, *other.surfaces))

    def __or__(self, other: TransferFunction) -> TransferFunction:
        """Return, at each value, the one with the greater extinction; the mean of both colours where they are equal.

        Crossings become points. Nothing is approximated.

        Raises
        ------
        ValueRangeError
            When one is associated and the other is not, or both have a surface at one value.
        """
        if not isinstance(other, TransferFunction):
            return NotImplemented
        return replace_points(self, combine.greater(self, other), (*self.surfaces, *other.surfaces))

    def picture(self) -> npt.NDArray[np.uint8]:
        """Picture ``(h, w, 3)``, sRGB: extinction by value in the function's colours; notebooks show it."""
        from .function_picture import function_picture

        return function_picture(self)

    def _repr_png_(self) -> bytes:
        from .histogram_picture import png

        return png(self.picture())

    # Constructors and conversions, each in the module of its kind.
    gaussian = classmethod(shapes.gaussian)
    box = classmethod(shapes.box)
    peak = classmethod(shapes.peak)
    step = classmethod(shapes.step)
    ramp = classmethod(shapes.ramp)
    random = classmethod(shapes.random)
    random_surfaces = classmethod(sheets.random_surfaces)
    from_surfaces, with_surfaces = classmethod(sheets.from_surfaces), sheets.with_surfaces
    from_colormap = classmethod(colormaps.from_colormap)
    from_table = classmethod(conversions.from_table)
    from_hounsfield = classmethod(attenuation.from_hounsfield)
    from_vtk, to_vtk = classmethod(conversions.from_vtk), conversions.to_vtk
    from_ospray, to_ospray = classmethod(conversions.from_ospray), conversions.to_ospray
    from_anari, to_anari = classmethod(conversions.from_anari), conversions.to_anari
    as_code = saving.as_code

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as scene files keep it."""
        data: dict[str, Any] = {"points": [[v, list(rgb), e] for v, rgb, e in self.points]}
        data |= {"associated": True} if self.associated else {}
        return data | ({"surfaces": [surface.to_dict() for surface in self.surfaces]} if self.surfaces else {})

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> TransferFunction:
        """Return the function that ``to_dict`` wrote.

        Raises
        ------
        ValueRangeError
            Names the entry that is unknown or wrong.
        """
        saving.check_data(data, ("points", "associated", "surfaces"))
        return cls(data.get("points", ()), data.get("associated", False), data.get("surfaces", ()))


def replace_points(
    function: TransferFunction, points: Iterable[tuple[float, Colour, float]], surfaces: Iterable[Surface] | None = None
) -> TransferFunction:
    """Return the same function with other points, and other surfaces if given."""
    kept = function.surfaces if surfaces is None else tuple(surfaces)
    return replace(function, points=tuple(points), surfaces=kept)  # type: ignore[arg-type]


def _checked(points: Iterable[tuple[float, Colour, float]], most_colour: float | None) -> tuple[Point, ...]:
    checked: list[Point] = []
    for number, point in enumerate(listed(points, "transfer.points", "give (value, colour, extinction) of each")):
        where = f"transfer.points[{number}]"
        if not isinstance(point, (tuple, list)) or len(point) != 3:
            raise ValueRangeError(where, f"is {point!r}", "give (value, colour, extinction)")
        value, extinction = finite(point[0], f"{where}.value"), not_negative(point[2], f"{where}.extinction")
        if checked and value < checked[-1][0]:
            raise ValueRangeError(where, f"has value {value:g}, below the {checked[-1][0]:g} before it", "sort the points")
        checked.append((value, linear_rgb(point[1], f"{where}.colour", most_colour), extinction))
    if not checked:
        raise ValueRangeError("transfer.points", "is empty", "give at least one (value, colour, extinction)")
    return tuple(checked)


def _read_only(array: FloatArray) -> FloatArray:
    array.flags.writeable = False
    return array
