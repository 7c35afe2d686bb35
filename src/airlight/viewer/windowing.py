"""Window and level: the centre and the width of a transfer function, and the function moved to others."""

from __future__ import annotations

from dataclasses import replace

from ..errors import ValueRangeError
from ..transfer import Channels, TransferFunction
from ..transfer.given import finite, not_negative
from ..transfer.kinds import AnyFunction

NARROWEST = 1e-9
"""Least width as a share of the width before, so that a function that was squeezed can be stretched again."""


def window_of(function: AnyFunction) -> tuple[float, float]:
    """Return the centre and the width, in data units, of the values between a function's first and last point.

    Of a mixture of channels: of all its parts together.

    Raises
    ------
    ValueRangeError
        For functions of several variables, which have no such thing.
    """
    ends = [part.domain for part in _parts(function)]
    low, high = min(low for low, _ in ends), max(high for _, high in ends)
    return low + (high - low) / 2, high - low


def windowed(function: AnyFunction, centre: float, width: float) -> AnyFunction:
    """Return a function moved and stretched as a whole to another centre and width, in data units; extinctions stay.

    A function of one value alone has no width: it is moved. Channels of a mixture keep their places to each other.

    Raises
    ------
    ValueRangeError
        For a centre that is not finite, a width below 0, and functions of several variables.
    """
    centre, width = finite(centre, "window.centre"), not_negative(width, "window.width")
    before, was = window_of(function)
    if was == 0:
        return _each(function, lambda part: part.shifted(centre - before))
    width = max(width, was * NARROWEST)
    stretch = width / was

    def moved(part: TransferFunction) -> TransferFunction:
        low, high = (centre + (end - before) * stretch for end in part.domain)
        return part.rescaled((low, high)) if high > low else part.shifted(low - part.domain[0])

    return _each(function, moved)


def _parts(function: AnyFunction) -> list[TransferFunction]:
    if isinstance(function, TransferFunction):
        return [function]
    if isinstance(function, Channels):
        return [part.transfer for part in function.parts]
    raise ValueRangeError("transfer", f"is a {type(function).__name__}, which has no window", "use a function of one value")


def _each(function: AnyFunction, change: object) -> AnyFunction:
    assert callable(change)
    if isinstance(function, Channels):
        return Channels([replace(part, transfer=change(part.transfer)) for part in function.parts])
    changed: AnyFunction = change(function)
    return changed
