"""Surfaces of equal value: sheets without width that a transfer function holds beside its medium.

A ray meets a surface where its value passes the surface's. What lies at or above the value is its inside: a sample on the very
value is inside, so no crossing is lost or counted twice (half-open). A ray on its way up, into the inside, sees ``colour`` and
``opacity``; on its way down, out of it, ``back_colour`` and ``back_opacity`` (Engel and Ertl 2002, section 8.3, figure 41).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ValueRangeError
from .colour import MOST_COLOUR, Colour, linear_rgb
from .given import finite, listed, rising_range, set_fields, share, whole

if TYPE_CHECKING:
    from .function import TransferFunction

MOST_SURFACES = 1024
HOW_GIVEN = "give a Surface, or (value, colour, opacity)"
Side = tuple[tuple[float, float, float], float]


@dataclass(frozen=True)
class Surface:
    """A surface of equal value, with a colour and an opacity for each side.

    Parameters
    ----------
    value
        Iso-value, in data units.
    colour
        Of the side towards lower values: linear ``(r, g, b)``, or an sRGB word.
    opacity
        Of that side, in [0, 1]: it counts once for each crossing, whatever the step.
    back_colour, back_opacity
        Of the side towards higher values; None takes that of the front.

    Raises
    ------
    ValueRangeError
        When the value is not finite, a colour is not legal, or an opacity lies outside of [0, 1].
    """

    value: float
    colour: Colour = (1.0, 1.0, 1.0)
    opacity: float = 1.0
    back_colour: Colour | None = None
    back_opacity: float | None = None

    def __post_init__(self) -> None:
        """Check the values; colours become linear tuples."""
        where = "transfer.surface"
        set_fields(self, value=finite(self.value, f"{where}.value"), opacity=share(self.opacity, f"{where}.opacity"))
        set_fields(self, colour=linear_rgb(self.colour, f"{where}.colour", MOST_COLOUR))
        if self.back_opacity is not None:
            set_fields(self, back_opacity=share(self.back_opacity, f"{where}.back_opacity"))
        if self.back_colour is not None:
            set_fields(self, back_colour=linear_rgb(self.back_colour, f"{where}.back_colour", MOST_COLOUR))

    @property
    def front(self) -> Side:
        """Linear colour and opacity for rays that go up through the value."""
        return self.colour, self.opacity  # type: ignore[return-value]

    @property
    def back(self) -> Side:
        """Linear colour and opacity for rays that go down through the value."""
        colour = self.colour if self.back_colour is None else self.back_colour
        return colour, self.opacity if self.back_opacity is None else self.back_opacity  # type: ignore[return-value]

    def scaled(self, density: float) -> Surface:
        """Return the surface with its optical thickness multiplied: opacities become ``1 - (1 - opacity)**density``."""
        back = None if self.back_opacity is None else 1 - (1 - self.back_opacity) ** density
        return replace(self, opacity=1 - (1 - self.opacity) ** density, back_opacity=back)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, without what is None."""
        data = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in data.items() if v is not None}

    def as_code(self) -> str:
        """Return Python text that makes an equal surface, where airlight is imported as ``al``."""
        parts = ((field.name, getattr(self, field.name)) for field in fields(self))
        return f"al.Surface({', '.join(f'{name}={v!r}' for name, v in parts if v is not None)})"


def checked_surfaces(given: Iterable[Any]) -> tuple[Surface, ...]:
    """Return surfaces in the order of their values; tuples are taken for the parameters of a `Surface`, tables for `to_dict`'s.

    Raises
    ------
    ValueRangeError
        Names what is none, a value that comes twice, or a number of surfaces that no table holds.
    """
    found = [
        _surface(part, f"transfer.surfaces[{number}]")
        for number, part in enumerate(listed(given, "transfer.surfaces", HOW_GIVEN))
    ]
    if len(found) > MOST_SURFACES:
        remedy = "a function of narrow peaks (TransferFunction.random) draws more"
        raise ValueRangeError("transfer.surfaces", f"are {len(found)}, must be at most {MOST_SURFACES}", remedy)
    found.sort(key=lambda surface: surface.value)
    for one, other in pairwise(found):
        if one.value == other.value:
            raise ValueRangeError("transfer.surfaces", f"has two at the value {one.value:g}", "make them one, or move one")
    return tuple(found)


def _surface(given: Any, where: str) -> Surface:
    names = [field.name for field in fields(Surface)]
    try:
        match given:
            case Surface():
                return given
            case dict():
                unknown = sorted(set(given) - set(names))
                if unknown or "value" not in given:
                    raise ValueRangeError("", f"has the entries {sorted(given)}", f"give value, and of {', '.join(names[1:])}")
                return Surface(**given)
            case tuple() | list() if 1 <= len(given) <= len(names):
                return Surface(*given)
    except ValueRangeError as error:
        raise ValueRangeError(where + error.where.removeprefix("transfer.surface"), error.what, error.remedy) from None
    raise ValueRangeError(where, f"is {given!r}", HOW_GIVEN)


# -- functions with surfaces; each a method of TransferFunction


def with_surfaces(function: TransferFunction, surfaces: Iterable[Any]) -> TransferFunction:
    """Return the function with these surfaces in the place of those that it has.

    Parameters
    ----------
    surfaces
        ``Surface`` values, or tuples ``(value, colour, opacity, back_colour, back_opacity)`` of which the value must be there.

    Raises
    ------
    ValueRangeError
        When two have the same value, there are more than 1024, or one is not legal.

    Examples
    --------
    >>> import airlight as al
    >>> fog = al.TransferFunction([(0, "white", 0.0), (100, "white", 0.01)])
    >>> with_skin = fog.with_surfaces([al.Surface(60, "salmon", 0.4, back_colour="maroon")])
    """
    return replace(function, surfaces=checked_surfaces(surfaces))


def from_surfaces(cls: type[TransferFunction], surfaces: Iterable[Any]) -> TransferFunction:
    """Return a function of surfaces alone: there is no medium between them.

    Its control points have the surfaces' colours and no extinction, for projections and first hits.

    Parameters
    ----------
    surfaces
        As for `with_surfaces`; at least one.

    Raises
    ------
    ValueRangeError
        When there is none, two have the same value, there are more than 1024, or one is not legal.

    Examples
    --------
    >>> import airlight as al
    >>> shells = al.TransferFunction.from_surfaces([(40, "gold", 0.3), (90, "red", 1.0)])
    >>> [surface.value for surface in shells.surfaces]
    [40.0, 90.0]
    """
    found = checked_surfaces(surfaces)
    if not found:
        raise ValueRangeError("transfer.surfaces", "is empty", "give at least one Surface")
    return cls([(surface.value, surface.colour, 0.0) for surface in found], surfaces=found)


def random_surfaces(
    cls: type[TransferFunction], seed: int, value_range: tuple[float, float], count: int = 64, opacity: float = 0.1
) -> TransferFunction:
    """Return surfaces at even distances in random colours: all iso-surfaces of a volume at once.

    They lie dense where values change quickly (Engel and Ertl 2002, section 8.2, figure 40).

    Parameters
    ----------
    seed
        The same seed gives the same function, everywhere.
    value_range
        Range of values, in data units, which the surfaces divide into ``count + 1`` equal parts.
    count
        How many surfaces, from 1 to 1024.
    opacity
        Of each, in [0, 1].

    Raises
    ------
    ValueRangeError
        When the range does not rise, or another parameter is out of range.
    """
    low, high = rising_range(value_range, "transfer.random_surfaces.value_range")
    count = whole(count, "transfer.random_surfaces.count", 1, MOST_SURFACES)
    seed = whole(seed, "transfer.random_surfaces.seed", 0)
    values = np.linspace(low, high, count + 2)[1:-1].tolist()
    colours = np.random.default_rng(seed).random((count, 3)).tolist()
    return from_surfaces(cls, [Surface(v, c, opacity) for v, c in zip(values, colours, strict=True)])


# -- what functions with surfaces are made of


def holds_medium(function: TransferFunction) -> bool:
    """Whether there is anything beside the surfaces."""
    return bool(function.extinctions.any() or (function.associated and function.colours.any()))


def cut_stretches(stretches: Iterable[tuple[float, float]], surfaces: tuple[Surface, ...]) -> tuple[tuple[float, float], ...]:
    """Return closed intervals of values cut at surfaces: each begins on a value, or ends just below it in 32 bits."""
    found = []
    for low, high in stretches:
        for surface in surfaces:
            if low < surface.value and np.float32(surface.value) <= np.float32(high):
                end = float(np.nextafter(np.float32(surface.value), np.float32(-np.inf)))
                if end >= low:
                    found.append((low, end))
                low = surface.value
        found.append((low, high))
    return tuple(found)
