"""Opacity and extinction.

An *opacity* ``a`` is for a distance ``u``: light that goes as far is weakened by ``1 - a``, so over a length ``d`` the opacity
is ``1 - (1 - a)**(d / u)``. Extinction weakens it by ``exp(-extinction d)``, hence

    extinction = -ln(1 - a) / u,        a = 1 - exp(-extinction u).

Straight lines of the one are curves of the other: points are put in until opacities over every length up to ``LENGTHS`` unit
distances differ by less than ``TOLERANCE``. An opacity of 1 is opaque at any length; it becomes ``OPAQUE / u``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .polyline import FloatArray, Track, densified, thinned

OPAQUE = 1e6
"""Extinction times unit distance of what is opaque at any length; float32 holds it."""
TOLERANCE = 1e-3
LENGTHS = 100.0
DEEP = float(12 * np.log(2))
"""Depth of an opacity of 1 - 1/4096: what lies between deeper points is not followed, since the way to 1 has no end."""
PER_OPACITY, PER_DEPTH = 256, 24
"""How many places are looked at on the way from an opacity of 0 to 1, and for each unit of depth."""


def extinction_from_opacity(opacity: npt.ArrayLike, length: float = 1.0) -> FloatArray:
    """Return the extinction (...), per world unit, of media with opacities (...) in [0, 1] over a length.

    ``-ln(1 - opacity) / length``; an opacity of 1 gives ``1e6 / length``, which is opaque at any length.

    Raises
    ------
    ValueRangeError
        When an opacity lies outside of [0, 1], or the length is not above 0.
    """
    check_distance(length, "length")
    a = np.asarray(opacity, dtype=np.float64)
    if not ((a >= 0) & (a <= 1)).all():
        raise ValueRangeError("opacity", f"runs from {a.min():g} to {a.max():g}", "give numbers in [0, 1]")
    return np.asarray(np.where(a < 1, -np.log1p(-np.where(a < 1, a, 0.0)), OPAQUE) / length)


def opacity_from_extinction(extinction: npt.ArrayLike, length: float = 1.0) -> FloatArray:
    """Return the opacity (...) over a length of media with extinctions (...) per world unit: ``1 - exp(-extinction length)``.

    Raises
    ------
    ValueRangeError
        When the length is not above 0.
    """
    check_distance(length, "length")
    depth = np.asarray(extinction, dtype=np.float64) * length
    return np.asarray(-np.expm1(-np.minimum(depth, 700.0)))  # exp of less is no float64


def extinctions_of(opacity: Track, unit: float, keep: npt.ArrayLike = ()) -> Track:
    """Return the extinctions of opacities (n, 1) that run straight from row to row; points stay at the values of ``keep``."""
    values, alpha = densified(*opacity, _where_opacity_bends)
    keep = np.concatenate([np.asarray(keep, dtype=np.float64), values[alpha[:, 0] == 1]])
    values, depth = thinned(values, extinction_from_opacity(alpha), _depths_apart, keep)
    return values, depth / unit


def opacities_of(extinction: Track, unit: float) -> Track:
    """Return the opacities over a unit distance of extinctions (n, 1) that run straight from row to row."""
    values, depth = densified(extinction[0], extinction[1] * unit, _where_depth_bends)

    def apart(straight: FloatArray, right: FloatArray) -> FloatArray:
        return _depths_apart(_depth(straight), _depth(right))

    return thinned(values, opacity_from_extinction(depth), apart, extinction[0])


def check_distance(distance: float, where: str) -> None:
    """Refuse what is no distance.

    Raises
    ------
    ValueRangeError
        When it is not finite or not above 0.
    """
    if not (np.isfinite(distance) and distance > 0):
        raise ValueRangeError(where, f"is {distance:g}, must be finite and above 0")


def _depth(alpha: FloatArray) -> FloatArray:
    """Extinction times unit distance, at most DEEP."""
    return np.asarray(np.minimum(extinction_from_opacity(np.clip(alpha, 0, 1)), DEEP))


def _depths_apart(a: FloatArray, b: FloatArray) -> FloatArray:
    """Greatest difference of opacity, over all lengths up to ``LENGTHS`` units, of media with depths (m, 1) a unit.

    ``exp(-a d) - exp(-b d)`` is no more than ``|a - b| d``, nor than ``|a - b| / (e min(a, b))`` for any d.
    """
    a, b = np.minimum(a[:, 0], DEEP), np.minimum(b[:, 0], DEEP)
    bound = 1 / np.maximum(np.e * np.minimum(a, b), 1 / LENGTHS)
    return np.asarray(np.abs(a - b) * bound / TOLERANCE)


def _where_opacity_bends(start: FloatArray, end: FloatArray) -> FloatArray:
    """Shares of the way between two opacities (1,): even in opacity, and even in depth."""
    if start == end:
        return np.empty(0)
    low, high = float(_depth(start)[0]), float(_depth(end)[0])
    at_depths = (opacity_from_extinction(low + _even(PER_DEPTH * (high - low)) * (high - low)) - start) / (end - start)
    return np.concatenate([_even(PER_OPACITY * float(end[0] - start[0])), at_depths])


def _where_depth_bends(start: FloatArray, end: FloatArray) -> FloatArray:
    """Shares of the way between two depths (1,): even in depth, and even in opacity."""
    if start == end:
        return np.empty(0)
    low, high = (float(a[0]) for a in (opacity_from_extinction(start), opacity_from_extinction(end)))
    at_opacities = (_depth(low + _even(PER_OPACITY * (high - low)) * (high - low)) - start) / (end - start)
    return np.concatenate([_even(PER_DEPTH * min(float(end[0] - start[0]), DEEP)), at_opacities])


def _even(count: float) -> FloatArray:
    return np.linspace(0, 1, 4 + int(abs(count)))
