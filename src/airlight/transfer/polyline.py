"""Piecewise linear functions of a value as arrays: what shapes, sums and conversions are made of.

A *track* is values (n,), not decreasing, and rows (n, k) at them; two rows at one value are a step, and the later one holds
at the value itself. Beyond its ends a track is constant.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from .function import Point, TransferFunction

FloatArray = npt.NDArray[np.float64]
Track = tuple[FloatArray, FloatArray]
Apart = Callable[[FloatArray, FloatArray], FloatArray]
"""How far rows (m, k) are from what they should be (m, k), as (m,): 1 is just close enough."""

SAME = 1e-12
"""Rows whose difference is a smaller share of their size are one: rounding makes no steps."""


def track(function: TransferFunction) -> Track:
    """Return red, green, blue and extinction (n, 4) of a function at its control points."""
    return function.values, np.column_stack([function.colours, function.extinctions])


def points(values: FloatArray, rows: FloatArray) -> list[Point]:
    """Return control points of rows (n, 4): red, green, blue, extinction."""
    return [(v, (r, g, b), e) for v, (r, g, b, e) in zip(values.tolist(), rows.tolist(), strict=True)]


def sides(values: FloatArray, rows: FloatArray, knots: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the rows (m, k) of a track just below each knot (m,), and at it; they differ at steps."""
    last = len(values) - 1
    above = np.searchsorted(values, knots, side="right")
    lower, upper = np.clip(above - 1, 0, last), np.clip(above, 0, last)
    width = values[upper] - values[lower]
    share = np.where(width > 0, (knots - values[lower]) / np.where(width > 0, width, 1.0), 0.0)[:, None]
    here = rows[lower] * (1 - share) + rows[upper] * share
    # The first of the rows at a value is where the track comes to from below.
    first = np.clip(np.searchsorted(values, knots, side="left"), 0, last)
    return np.where((values[first] == knots)[:, None], rows[first], here), here


def woven(knots: FloatArray, below: FloatArray, here: FloatArray) -> Track:
    """Return the track with these rows on both sides of its knots: one row at each, two where they differ."""
    size = np.maximum(np.abs(below), np.abs(here)).max(axis=1, initial=0.0)
    step = np.abs(below - here).max(axis=1, initial=0.0) > SAME * size
    places = np.repeat(np.arange(len(knots)), 1 + step)
    rows = here[places]
    first = np.searchsorted(places, np.flatnonzero(step))
    rows[first] = below[step]
    return knots[places], rows


def thinned(values: FloatArray, rows: FloatArray, apart: Apart, keep: npt.ArrayLike = ()) -> Track:
    """Leave out the rows of a dense track that straight lines between the others give closely enough.

    Ends, steps and the values of ``keep`` stay. From each row that stays the next is as far away as may be.
    """
    chosen = np.isin(values, np.asarray(keep, dtype=np.float64))
    chosen[[0, -1]] = True
    steps = np.flatnonzero(np.diff(values) == 0)
    chosen[steps] = chosen[steps + 1] = True

    def fits(low: int, high: int) -> bool:
        if high - low < 2:
            return True
        share = ((values[low + 1 : high] - values[low]) / (values[high] - values[low]))[:, None]
        return bool((apart(rows[low] * (1 - share) + rows[high] * share, rows[low + 1 : high]) <= 1).all())

    for start, end in pairwise(np.flatnonzero(chosen).tolist()):
        path = [start]
        while not fits(path[-1], end):
            near, far = path[-1] + 1, end
            while far - near > 1:
                middle = (near + far) // 2
                near, far = (middle, far) if fits(path[-1], middle) else (near, middle)
            path.append(near)
        # What is left over at the end shares with the piece before it: narrow pieces need large tables.
        if len(path) > 1 and fits(path[-2], middle := (path[-2] + end) // 2) and fits(middle, end):
            path[-1] = middle
        chosen[path] = True
    return values[chosen], rows[chosen]


def simplified(values: FloatArray, rows: FloatArray) -> Track:
    """Leave out rows that lie on the line between their neighbours, and all but the outer two at one value."""
    knots = np.unique(values)
    values, rows = woven(knots, *sides(values, rows, knots))
    size = 1e-9 * max(float(np.abs(rows).max()), 1e-300)
    return thinned(values, rows, lambda straight, right: np.abs(straight - right).max(axis=1) / size)


def densified(values: FloatArray, rows: FloatArray, shares: Callable[[FloatArray, FloatArray], npt.ArrayLike]) -> Track:
    """Put rows into a track, on its own straight lines, at the shares (m,) in (0, 1) of the way from one row to the next."""
    all_values, all_rows = [values[:1]], [rows[:1]]
    for k in range(len(values) - 1):
        width = values[k + 1] - values[k]
        share = np.unique(np.asarray(shares(rows[k], rows[k + 1]), dtype=np.float64)) if width > 0 else np.empty(0)
        between = values[k] + share * width
        inside = (between > values[k]) & (between < values[k + 1])
        share = share[inside][:, None]
        all_values += [between[inside], values[k + 1 : k + 2]]
        all_rows += [rows[k] * (1 - share) + rows[k + 1] * share, rows[k + 1 : k + 2]]
    return np.concatenate(all_values), np.concatenate(all_rows)


def crossed(colour: Track, extinction: Track) -> list[Point]:
    """Return control points with the colours (n, 3) of one track and the extinctions (m, 1) of another."""
    knots = np.union1d(colour[0], extinction[0])
    pairs = zip(sides(*colour, knots), sides(*extinction, knots), strict=True)
    below, here = (np.concatenate([rgb, tau], axis=1) for rgb, tau in pairs)
    return points(*woven(knots, below, here))


def stepped(rows: FloatArray, low: float, high: float) -> Track:
    """Return the track of a table whose rows (n, k) each hold for an equal part of a range, from its lower edge on."""
    edges = np.linspace(low, high, len(rows) + 1)
    return np.repeat(edges, 2)[1:-1], np.repeat(rows, 2, axis=0)


def even(rows: FloatArray, low: float, high: float) -> Track:
    """Return the track of a table whose rows (n, k) lie evenly over a range, ends included."""
    return (np.linspace(low, high, len(rows)), rows) if len(rows) > 1 else (np.array([low]), rows)


def union(*values: FloatArray) -> FloatArray:
    """Return all values once, in order."""
    return np.unique(np.concatenate(values))
