"""Transfer functions of simple shapes; each is a constructor of `TransferFunction`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import ValueRangeError
from .colour import Colour, linear_rgb
from .given import finite, not_negative, positive, rising_range, whole
from .polyline import points, sides, thinned, track, union, woven

if TYPE_CHECKING:
    from .function import TransferFunction

TOLERANCE = 1e-3
REACH = float(np.sqrt(2 * np.log(2 / TOLERANCE)))
"""Standard deviations at which a Gaussian is cut off: it is half of the tolerance there."""
CHANNELS = "rgba"


def gaussian(
    cls: type[TransferFunction], centre: float, sigma: float, colour: Colour = "white", extinction: float = 1.0
) -> TransferFunction:
    """Return ``extinction * exp(-(value - centre)**2 / (2 sigma**2))`` in one colour.

    Straight lines between some forty points; nowhere is it further off than 1/1000 of ``extinction``. It is zero from 3.9
    ``sigma`` on.

    Parameters
    ----------
    centre, sigma
        Value of the peak, and standard deviation, in data units.
    colour
        Linear ``(r, g, b)``, or an sRGB word.
    extinction
        At the peak, per world unit.

    Raises
    ------
    ValueRangeError
        When ``sigma`` is not above 0, or another parameter is out of range.

    Examples
    --------
    >>> fat = TransferFunction.gaussian(-100, 20, "khaki", 0.2)
    >>> float(fat([-100])[1][0])
    0.2
    """
    centre, sigma = finite(centre, "transfer.gaussian.centre"), positive(sigma, "transfer.gaussian.sigma")
    extinction = not_negative(extinction, "transfer.gaussian.extinction")
    x = np.linspace(0, REACH, 1024)
    height = np.exp(-(x**2) / 2)[:, None]
    height[-1] = 0.0
    x, height = thinned(x, height, lambda straight, right: np.abs(straight - right)[:, 0] / (0.95 * TOLERANCE))
    # One half, mirrored: symmetric to the last digit.
    x, height = np.concatenate([-x[:0:-1], x]), np.concatenate([height[:0:-1], height])
    rgb = linear_rgb(colour, "transfer.gaussian.colour")
    return cls([(centre + sigma * v, rgb, extinction * h) for v, h in zip(x.tolist(), height[:, 0].tolist(), strict=True)])


def box(
    cls: type[TransferFunction], low: float, high: float, colour: Colour = "white", extinction: float = 1.0
) -> TransferFunction:
    """Return one medium for values from ``low`` up to, but not including, ``high``; nothing elsewhere. Its steps are exact.

    Parameters
    ----------
    low, high
        Range of values, in data units.
    colour
        Linear ``(r, g, b)``, or an sRGB word.
    extinction
        Per world unit.

    Raises
    ------
    ValueRangeError
        When ``high`` is not above ``low``, or another parameter is out of range.
    """
    (low, high), extinction = rising_range((low, high), "transfer.box"), not_negative(extinction, "transfer.box.extinction")
    return cls([(low, colour, 0.0), (low, colour, extinction), (high, colour, extinction), (high, colour, 0.0)])


def peak(
    cls: type[TransferFunction], value: float, width: float, colour: Colour = "white", extinction: float = 1.0
) -> TransferFunction:
    """Return a triangle: ``extinction`` at ``value``, nothing from half of ``width`` to either side on.

    Narrow peaks draw surfaces of equal value, as thick as the data are smooth there.

    Parameters
    ----------
    value, width
        Where the peak is, and its whole width at the foot, in data units.
    colour
        Linear ``(r, g, b)``, or an sRGB word.
    extinction
        At the peak, per world unit.

    Raises
    ------
    ValueRangeError
        When ``width`` is not above 0, or another parameter is out of range.
    """
    value, half = finite(value, "transfer.peak.value"), positive(width, "transfer.peak.width") / 2
    extinction = not_negative(extinction, "transfer.peak.extinction")
    return cls([(value - half, colour, 0.0), (value, colour, extinction), (value + half, colour, 0.0)])


def step(cls: type[TransferFunction], value: float, colour: Colour = "white", extinction: float = 1.0) -> TransferFunction:
    """Return nothing below ``value``, and one medium from it on. The step is exact.

    Parameters
    ----------
    value
        Where the medium begins, in data units.
    colour
        Linear ``(r, g, b)``, or an sRGB word.
    extinction
        Per world unit.

    Raises
    ------
    ValueRangeError
        When a parameter is out of range.
    """
    value, extinction = finite(value, "transfer.step.value"), not_negative(extinction, "transfer.step.extinction")
    return cls([(value, colour, 0.0), (value, colour, extinction)])


def ramp(
    cls: type[TransferFunction],
    low: float,
    high: float,
    colour: Colour = "white",
    extinction: float = 1.0,
    low_colour: Colour | None = None,
) -> TransferFunction:
    """Return nothing up to ``low``, then ever more up to ``high``, and the same from there on.

    Parameters
    ----------
    low, high
        Range of values, in data units.
    colour
        At ``high``: linear ``(r, g, b)``, or an sRGB word.
    extinction
        At ``high``, per world unit.
    low_colour
        Colour at ``low``; the same as ``colour`` unless told.

    Raises
    ------
    ValueRangeError
        When ``high`` is not above ``low``, or another parameter is out of range.
    """
    (low, high), extinction = rising_range((low, high), "transfer.ramp"), not_negative(extinction, "transfer.ramp.extinction")
    return cls([(low, colour if low_colour is None else low_colour, 0.0), (high, colour, extinction)])


def random(
    cls: type[TransferFunction],
    seed: int,
    value_range: tuple[float, float],
    entries: int = 256,
    channels: str = "rgb",
    base: TransferFunction | None = None,
    extinction: float = 1.0,
) -> TransferFunction:
    """Return a function of random entries: each of its many peaks draws one surface of equal value.

    Such functions show all iso-surfaces at once, dense where values change quickly, and they are the hardest test of
    classification (Engel and Ertl 2002, section 8.2, figures 3 and 39). Their comparison has one random channel and
    piecewise linear others: ``channels="g"``.

    Parameters
    ----------
    seed
        The same seed gives the same function, everywhere.
    value_range
        First and last value, in data units; random numbers are spread evenly between them, ends included.
    entries
        How many random numbers a channel gets.
    channels
        Which are random: letters of ``rgb``, uniform in [0, 1] of linear light, and ``a``, extinction, uniform in [0,
        ``extinction``].
    base
        The other channels are those of this function; black without extinction to white unless told.
    extinction
        Greatest extinction of the default base, and of random ones, per world unit.

    Raises
    ------
    ValueRangeError
        When a parameter is out of range, or ``base`` is an associated function.
    """
    low, high = rising_range(value_range, "transfer.random.value_range")
    extinction = not_negative(extinction, "transfer.random.extinction")
    seed, entries = whole(seed, "transfer.random.seed", 0), whole(entries, "transfer.random.entries", 2, 65536)
    if not channels or set(channels) - set(CHANNELS):
        raise ValueRangeError("transfer.random.channels", f"is {channels!r}, must be letters of {CHANNELS}")
    if base is not None and base.associated:
        raise ValueRangeError("transfer.random.base", "is associated", "give a function whose colours are not")
    base = cls.ramp(low, high, "white", extinction, low_colour="black") if base is None else base
    drawn = np.random.default_rng(seed).random((entries, len(CHANNELS))) * [1, 1, 1, extinction]
    steady = track(base)
    values = np.linspace(low, high, entries)
    knots = union(values, steady[0])
    chosen = [letter in channels for letter in CHANNELS]
    below, here = (np.where(chosen, sides(values, drawn, knots)[1], rows) for rows in sides(*steady, knots))
    return cls(points(*woven(knots, below, here)))
