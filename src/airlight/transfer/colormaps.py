"""Colour maps by name, out of the package ``cmap``; it is imported when the first one is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..errors import ValueRangeError
from .colour import linear_to_srgb, srgb_to_linear
from .given import rising_range
from .polyline import FloatArray, Track, crossed, densified, stepped, thinned

if TYPE_CHECKING:
    from .function import TransferFunction

Extinction = float | tuple[float, float] | Sequence[tuple[float, float]]

TOLERANCE = 0.5 / 255
"""Greatest deviation of a colour from the map, sRGB-encoded."""
SAMPLES = 8193
"""Enough for maps that begin like a square root."""
FEW_STOPS = 16
"""Maps of no more colours keep them as points."""
Category = Literal["sequential", "diverging", "cyclic", "miscellaneous", "qualitative"]
CATEGORIES: tuple[Category, ...] = ("sequential", "diverging", "cyclic", "miscellaneous", "qualitative")


def from_colormap(
    cls: type[TransferFunction],
    name: str,
    value_range: tuple[float, float],
    extinction: Extinction = 1.0,
    reversed: bool = False,
) -> TransferFunction:
    """Return a function with the colours of a named map over a range of values.

    Maps are drawn in sRGB, also between their colours; they are decoded to linear light, and there are as many points as keep
    every colour within half of 1/255, encoded. Maps of separate colours (``tab10``) become exact steps.

    Parameters
    ----------
    name
        A map of the package ``cmap``: ``viridis``, ``inferno``, ``gray``, ``colorbrewer:blues``, ...; ``airlight presets
        --colormaps`` lists them. ``_r`` at the end reverses it.
    value_range
        Values, in data units, of the map's first and last colour.
    extinction
        Per world unit: a number; a pair, at the first and at the last value with a straight line between; or points ``(value,
        extinction)``.
    reversed
        Begin with the map's last colour.

    Raises
    ------
    ValueRangeError
        For an unknown name, with those that are close; for a range that does not rise, and extinctions out of range.

    Examples
    --------
    >>> tf = TransferFunction.from_colormap("viridis", (0, 255), extinction=(0, 0.5))
    >>> tf.domain
    (0.0, 255.0)
    """
    low, high = rising_range(value_range, "transfer.colormap")
    shares, rgb = _mirrored(colours_of(name)) if reversed else colours_of(name)
    values = low + shares * (high - low)
    values[shares == 1] = high
    return cls(crossed((values, rgb), _extinctions(extinction, low, high)))


def colormap_names() -> dict[str, tuple[str, ...]]:
    """Return the names of all colour maps, by category."""
    from cmap import Colormap

    catalog = Colormap.catalog()
    return {category: tuple(sorted(catalog.unique_keys(categories=(category,)), key=str.lower)) for category in CATEGORIES}


@lru_cache(maxsize=32)
def colours_of(name: str) -> Track:
    """Return a map's linear colours (n, 3) at shares (n,) of its range."""
    from cmap import Colormap

    catalog = Colormap.catalog()
    try:
        full_name = catalog.resolve(name)
    except KeyError:
        if name.endswith("_r"):
            return _mirrored(colours_of(name.removesuffix("_r")))
        close = get_close_matches(name.lower(), list(catalog), n=4, cutoff=0.5)
        remedy = f"did you mean {', '.join(close)}?" if close else "airlight presets --colormaps lists them"
        raise ValueRangeError("colormap", f"{name!r} is unknown", remedy) from None
    found = Colormap(full_name)
    if found.interpolation == "nearest":
        return stepped(srgb_to_linear(found.lut()[:, :3]), 0.0, 1.0)
    if found.info is not None and callable(found.info.data):
        shares, encoded, keep = np.linspace(0, 1, SAMPLES), np.clip(found.lut(SAMPLES)[:, :3], 0, 1), np.empty(0)
    else:
        stops = np.asarray(found.color_stops, dtype=np.float64)
        between = np.linspace(0, 1, max(5, SAMPLES // len(stops)))
        shares, encoded = densified(stops[:, 0], np.clip(stops[:, 1:4], 0, 1), lambda start, end: between)
        keep = stops[:, 0] if len(stops) <= FEW_STOPS else np.empty(0)
    return thinned(shares, srgb_to_linear(encoded), _apart, keep)


def _mirrored(track: Track) -> Track:
    return 1.0 - track[0][::-1], track[1][::-1]


def _apart(straight: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(np.abs(linear_to_srgb(straight) - linear_to_srgb(right)).max(axis=1) / TOLERANCE)


def _extinctions(extinction: Extinction, low: float, high: float) -> Track:
    """Return what was given as a track (n, 1)."""
    given = np.asarray(extinction, dtype=np.float64)
    if given.ndim < 2:
        given = np.column_stack([[low, high], np.broadcast_to(given, (2,))]) if given.size in (1, 2) else given
    if given.ndim != 2 or given.shape[1] != 2 or len(given) == 0:
        raise ValueRangeError(
            "transfer.extinction", f"has shape {given.shape}", "give a number, a pair, or points (value, extinction)"
        )
    for number, (value, tau) in enumerate(given.tolist()):
        if not np.isfinite([value, tau]).all() or tau < 0 or (number and value < given[number - 1, 0]):
            raise ValueRangeError(
                f"transfer.extinction[{number}]", f"is ({value:g}, {tau:g})", "values must rise, extinctions be at least 0"
            )
    return given[:, 0], given[:, 1:]
