"""Axes of joint histograms and functions, and colours along them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import DataError, ValueRangeError
from ..volume import Volume
from .colour import Colour, linear_rgb
from .function import FloatArray
from .given import finite, listed, set_fields

VARIABLES = ("value", "gradient", "second")


@dataclass(frozen=True)
class Axis:
    """One variable of a joint histogram or function, and the stretch of it that is looked at.

    Parameters
    ----------
    variable
        ``"value"``: the value of the layer's channel, in data units; ``"gradient"``: the magnitude of its gradient, in data
        units per world unit; ``"second"``: its second derivative along the gradient, in data units per world unit squared; or
        a channel by number or name, in its own units. A channel with one of these three names goes by its number.
    low, high
        Both ends, which belong to it.

    Raises
    ------
    ValueRangeError
        For ends that are not finite, ``high`` not above ``low``, and variables that are neither words nor channel numbers.
    """

    variable: str | int
    low: float
    high: float

    def __post_init__(self) -> None:
        variable = check_variable(self.variable, "axis.variable")
        low, high = (finite(end, f"axis {variable!r}") for end in (self.low, self.high))
        if not (high > low and high - low < np.finfo(np.float64).max):
            raise ValueRangeError(f"axis {variable!r}", f"reaches from {low:g} to {high:g}", "give high above low")
        set_fields(self, variable=variable, low=low, high=high)

    @property
    def span(self) -> float:
        """Width from low to high."""
        return self.high - self.low


@dataclass(frozen=True)
class Ramp:
    """Colours along an axis of the histogram, piecewise linear and constant beyond the ends.

    Parameters
    ----------
    axis
        Number of the axis: 0 for the first variable.
    points
        ``(coordinate, colour)``, coordinates rising, colours linear ``(r, g, b)`` or sRGB words (stored linear).

    Raises
    ------
    ValueRangeError
        For an axis that is not 0, 1 or 2, less than two points, and coordinates that do not rise.
    """

    axis: int
    points: tuple[tuple[float, Colour], ...]

    def __post_init__(self) -> None:
        if isinstance(self.axis, bool) or self.axis not in (0, 1, 2):
            raise ValueRangeError("ramp.axis", f"is {self.axis!r}, must be 0, 1 or 2")
        points: list[tuple[float, Colour]] = []
        for i, point in enumerate(listed(self.points, "ramp.points", "give (coordinate, colour) of each")):
            where = f"ramp.points[{i}]"
            if not isinstance(point, (tuple, list)) or len(point) != 2:
                raise ValueRangeError(where, f"is {point!r}", "give (coordinate, colour)")
            points.append((finite(point[0], where), linear_rgb(point[1], f"{where}.colour")))
        places = [c for c, _ in points]
        if len(points) < 2 or not (np.diff(places) > 0).all():
            raise ValueRangeError("ramp.points", f"have coordinates {places}", "give two or more, rising")
        set_fields(self, axis=int(self.axis), points=tuple(points))

    def __call__(self, coordinates: FloatArray) -> FloatArray:
        """Linear colours (..., 3) at coordinates (..., k)."""
        places, colours = [c for c, _ in self.points], np.array([rgb for _, rgb in self.points])
        return np.stack([np.interp(coordinates[..., self.axis], places, colours[:, i]) for i in range(3)], axis=-1)


def check_variable(variable: Any, where: str) -> str | int:
    """Return the variable where it is a word or a channel number.

    Raises
    ------
    ValueRangeError
        Where it is anything else.
    """
    if isinstance(variable, str) and variable:
        return variable
    if isinstance(variable, (int, np.integer)) and not isinstance(variable, bool) and variable >= 0:
        return int(variable)
    known = ", ".join(repr(v) for v in VARIABLES)
    raise ValueRangeError(where, f"is {variable!r}", f"use {known}, or a channel's number or name")


def channel_of(variable: str | int, volume: Volume, where: str) -> int:
    """Number of the channel of a volume that a variable, none of ``"value"``, ``"gradient"`` and ``"second"``, stands for.

    Raises
    ------
    DataError
        When the volume has no such channel; it names all variables that there are.
    """
    try:
        return volume.channel_index(variable)
    except DataError:
        count = volume.channel_count
        known = f"{count} channels, 0 to {count - 1}" if count > 1 else "one channel, 0"
        known += f" ({', '.join(volume.channel_names)})" if volume.channel_names else ""
        found = f"is {variable!r}, which is no variable" if isinstance(variable, str) else f"is channel {variable}"
        what = f"{found}; the volume has {known}"
        raise DataError(where, what, "use value, gradient, second or one of its channels") from None


def check_axes(axes: Iterable[Axis], least: int = 2) -> tuple[Axis, ...]:
    """Return the axes as a tuple where they are ``least`` to three of different variables.

    Raises
    ------
    ValueRangeError
        Where they are not.
    """
    checked = listed(axes, "transfer.axes", "pass two or three Axis(variable, low, high)")
    for number, axis in enumerate(checked):
        if not isinstance(axis, Axis):
            raise ValueRangeError(f"transfer.axes[{number}]", f"is {axis!r}", "pass an Axis(variable, low, high)")
    variables = [axis.variable for axis in checked]
    if not least <= len(checked) <= 3 or len(set(variables)) < len(variables):
        raise ValueRangeError("transfer.axes", f"are of {variables}", "give two or three different variables")
    return checked
