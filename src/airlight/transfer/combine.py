"""Sums and maxima of transfer functions, and functions moved, clipped and recoloured."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import ValueRangeError
from .polyline import FloatArray, Track, crossed, points, sides, thinned, track, union, woven

if TYPE_CHECKING:
    from .function import Point, TransferFunction

TOLERANCE = 1e-3
"""Greatest deviation of a sum's colour, as a share of the brightest colour in it."""
SAMPLES = 129


def added(a: TransferFunction, b: TransferFunction) -> list[Point]:
    """Return control points of two media in one place: extinctions and sources add, so colours are weighted by extinction.

    Sums of extinctions, and of associated functions, are exact. Colour is a quotient between control points, and points are
    put in until it deviates by less than ``TOLERANCE``. What neither absorbs nor glows anywhere leaves the other as it is.
    """
    _check_alike(a, b, "+")
    if _is_nothing(b):
        return list(a.points)
    if _is_nothing(a):
        return list(b.points)
    knots = union(a.values, b.values)
    (a_below, a_here), (b_below, b_here) = sides(*track(a), knots), sides(*track(b), knots)
    if a.associated:
        return points(*woven(knots, a_below + b_below, a_here + b_here))
    # Pieces run from knot to knot; the first and the last, beyond the ends, are constant.
    pieces = [(knots[:1], _mixture(a_below[:1], b_below[:1]))]
    for k in range(len(knots) - 1):
        a_ends, b_ends = (np.stack([here[k], below[k + 1]]) for here, below in ((a_here, a_below), (b_here, b_below)))
        pieces.append(_mixed(knots[k : k + 2], a_ends, b_ends))
    pieces.append((knots[-1:], _mixture(a_here[-1:], b_here[-1:])))
    return points(*_joined(knots, pieces, associated=False))


def greater(a: TransferFunction, b: TransferFunction) -> list[Point]:
    """Return control points of the function with the greater extinction at each value; where both are equal, their mean.

    Where they cross there are two points: extinction goes on, colour changes.
    """
    _check_alike(a, b, "|")
    knots = _with_crossings(a, b)
    (a_below, a_here), (b_below, b_here) = sides(*track(a), knots), sides(*track(b), knots)
    # As in sums: piece k runs from knot k-1 to knot k.
    starts = [np.concatenate([below[:1], here]) for below, here in ((a_below, a_here), (b_below, b_here))]
    ends = [np.concatenate([below, here[-1:]]) for below, here in ((a_below, a_here), (b_below, b_here))]
    a_amount, b_amount = (start[:, 3] + end[:, 3] for start, end in zip(starts, ends, strict=True))
    lead = a_amount - b_amount
    lead[np.abs(lead) <= 1e-12 * (a_amount + b_amount)] = 0.0
    weight = (0.5 + 0.5 * np.sign(lead))[:, None]
    start, end = (weight * rows[0] + (1 - weight) * rows[1] for rows in (starts, ends))
    pieces = [(np.array([]), np.stack([p, q])) for p, q in zip(start, end, strict=True)]
    return points(*_joined(knots, pieces, a.associated))


def clipped(function: TransferFunction, low: float, high: float) -> list[Point]:
    """Return control points of what is left in ``[low, high)``: outside there is nothing, behind exact steps."""
    inside = (function.values > low) & (function.values < high)
    knots = union(np.array([low, high]), function.values[inside])
    below, here = sides(*track(function), knots)
    nothing = 0.0 if function.associated else np.array([1.0, 1.0, 1.0, 0.0])
    below[0], here[-1] = here[0] * nothing, below[-1] * nothing
    return points(*woven(knots, below, here))


def mirrored(function: TransferFunction) -> list[Point]:
    """Return control points with the colours in the opposite order over the function's domain; extinctions stay."""
    low, high = function.domain
    values, rows = track(function)
    turned = np.clip(low + high - values, low, high)
    turned[values == low], turned[values == high] = high, low
    return crossed((turned[::-1], rows[::-1, :3]), (values, rows[:, 3:]))


def _check_alike(a: TransferFunction, b: TransferFunction, sign: str) -> None:
    if a.associated != b.associated:
        raise ValueRangeError(
            f"transfer {sign} transfer",
            "joins an associated function with one that is not",
            "draw them as two layers, or give both in the same way",
        )


def _is_nothing(function: TransferFunction) -> bool:
    return not function.extinctions.any() and not (function.associated and function.colours.any())


def _with_crossings(a: TransferFunction, b: TransferFunction) -> FloatArray:
    """Return the control values of both, and the values between them at which their extinctions are equal."""
    knots = union(a.values, b.values)
    (a_below, a_here), (b_below, b_here) = sides(*track(a), knots), sides(*track(b), knots)
    start, end = (a_here - b_here)[:-1, 3], (a_below - b_below)[1:, 3]
    crosses = (start > 0) & (end < 0) | (start < 0) & (end > 0)
    share = start[crosses] / (start[crosses] - end[crosses])
    return union(knots, knots[:-1][crosses] + share * np.diff(knots)[crosses])


def _mixed(ends: FloatArray, a_ends: FloatArray, b_ends: FloatArray) -> Track:
    """Return the track of the mixture of two media that run straight between two values, from row to row (2, 4)."""
    share = _dense_shares(float(a_ends[0, 3] + b_ends[0, 3]), float(a_ends[1, 3] + b_ends[1, 3]))
    a, b = (rows[0] * (1 - share) + rows[1] * share for rows in (a_ends, b_ends))
    a_weight, b_weight = a[:, 3].copy(), b[:, 3].copy()
    for end in (0, -1):
        if a_weight[end] + b_weight[end] == 0:  # the colour that the mixture comes from as both vanish
            a_weight[end], b_weight[end] = a_ends[1 + end, 3], b_ends[1 + end, 3]
    rows = _mixture(a, b, (a_weight, b_weight))
    values = ends[0] + share[:, 0] * (ends[1] - ends[0])
    values[-1] = ends[1]
    inside = (values > ends[0]) & (values < ends[1])
    inside[[0, -1]] = True
    brightest = max(float(rows[:, :3].max()), 1e-300)
    return thinned(
        values[inside],
        rows[inside],
        lambda straight, right: np.abs(straight - right)[:, :3].max(axis=1) / (TOLERANCE * brightest),
    )


def _mixture(a: FloatArray, b: FloatArray, weights: tuple[FloatArray, FloatArray] | None = None) -> FloatArray:
    """Return rows (m, 4) of two media in one place; colours by extinction, or other weights (m,); the mean where all are 0."""
    a_weight, b_weight = (a[:, 3], b[:, 3]) if weights is None else weights
    total = a_weight + b_weight
    part = np.where(total > 0, a_weight / np.where(total > 0, total, 1.0), 0.5)[:, None]
    return np.concatenate([part * a[:, :3] + (1 - part) * b[:, :3], (a[:, 3] + b[:, 3])[:, None]], axis=1)


def _dense_shares(start: float, end: float) -> FloatArray:
    """Return shares (m, 1) of the way between two extinctions at which a mixture is looked at.

    Its colour bends like 1 / extinction, so even steps of ``extinction**-0.5`` bend equally.
    """
    if min(start, end) <= 0:
        return np.array([[0.0], [1.0]])
    if abs(start - end) < 1e-3 * max(start, end):
        return np.linspace(0, 1, SAMPLES)[:, None]
    tau = np.linspace(start**-0.5, end**-0.5, SAMPLES) ** -2.0
    share = (tau - start) / (end - start)
    share[[0, -1]] = 0.0, 1.0
    return np.clip(share, 0, 1)[:, None]


def _joined(knots: FloatArray, pieces: list[Track], associated: bool) -> Track:
    """Return the track of pieces between knots; the first and the last piece hold beyond them.

    Where a piece is empty its colour is not seen: it takes its neighbour's, so that there is no step but where one is seen.
    """
    below, here = (np.array([rows[end] for _, rows in some]) for some, end in ((pieces[:-1], -1), (pieces[1:], 0)))
    seen = np.array([bool(rows[:, 3].any() or (associated and rows[:, :3].any())) for _, rows in pieces])[:, None]
    before, after, mean = seen[:-1], seen[1:], (below + here)[:, :3] / 2
    below[:, :3], here[:, :3] = (
        np.where(before, below[:, :3], np.where(after, here[:, :3], mean)),
        np.where(after, here[:, :3], np.where(before, below[:, :3], mean)),
    )
    values, rows = woven(knots, below, here)
    inner = [piece for piece in pieces[1:-1] if len(piece[0]) > 2]
    if not inner:
        return values, rows
    values = np.concatenate([values, *(v[1:-1] for v, _ in inner)])
    rows = np.concatenate([rows, *(r[1:-1] for _, r in inner)])
    order = np.argsort(values, kind="stable")
    return values[order], rows[order]
