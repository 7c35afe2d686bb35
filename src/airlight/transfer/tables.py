"""Tables of transfer functions, made in float64: the function itself, and its integrals over slabs.

A slab is a piece of a ray of length ``d`` along which the value runs straight from ``s_front`` to ``s_back`` (Engel and
Ertl, section 6). Its extinction integral is exact for any length from the mean extinction alone. Its colour is kept as the
attenuated mean source ``K`` [1/world],

    C = K * (1 - exp(-tau d)) / tau,        tau the mean extinction,

which has no division by a vanishing opacity, serves associated colours too, and varies so slowly with length that
a few layers from 0 to d give any shorter slab (first and last of a ray, beyond the function's ends, cut by a clip).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .function import FloatArray, TransferFunction

ENTRIES_PER_SEGMENT = 4
FUNCTION_ENTRIES = (1024, 4096)
SLAB_ENTRIES = (128, 512)
GAUSS_NODES = 4
LENGTHS = 4
MOST_DEPTH = 12.0
DIAGONALS_AT_ONCE = 16


@dataclass(frozen=True, eq=False)
class ValueTable:
    """Texels, float32, whose axes run over values from ``first_value`` to ``last_value``, both ends included."""

    texels: npt.NDArray[np.float32]
    first_value: float
    last_value: float

    @property
    def entries(self) -> int:
        """Number of entries along a value axis."""
        return int(self.texels.shape[-2])


def value_axis(function: TransferFunction) -> tuple[float, float]:
    """First and last value of the tables' axes; a function of one value gets a narrow axis round it."""
    first, last = function.domain
    if last > first:
        return first, last
    width = 1e-3 * abs(first) or 1e-6
    return first - width / 2, last + width / 2


def entries_needed(function: TransferFunction, least: int, most: int) -> int:
    """Number of entries that gives the narrowest segment ``ENTRIES_PER_SEGMENT``, within limits.

    Of all numbers up to twice as large, the one whose entries lie closest to the control points: interpolation between entries
    is exact where the function has no kink between them. A step has no width: it is drawn as wide as one entry.
    """
    first, last = value_axis(function)
    widths = np.diff(function.values)
    if widths.size == 0:
        return least
    narrowest = float(widths.min())
    wanted = ENTRIES_PER_SEGMENT * (last - first) / narrowest if narrowest > 0 else most
    enough = int(np.clip(wanted, least, most))
    segments = np.arange(enough - 1, min(2 * enough, most))
    places = (function.values - first) / (last - first) * segments[:, None]
    apart = np.abs(places - np.round(places)).max(axis=1)
    return int(segments[np.argmin(np.round(apart, 6))]) + 1


def _entry_values(first: float, last: float, n: int) -> FloatArray:
    """Values of the entries; the first holds what lies before a step there, as do all values beyond it."""
    values = np.linspace(first, last, n)
    values[0] = np.nextafter(first, -np.inf)
    return values


@lru_cache(maxsize=16)
def function_table(function: TransferFunction) -> ValueTable:
    """Colour and extinction at evenly spaced values: ``(1, 1, n, 4)`` of (r, g, b, extinction)."""
    first, last = value_axis(function)
    n = entries_needed(function, *FUNCTION_ENTRIES)
    rgb, extinction = function(_entry_values(first, last, n))
    texels = np.concatenate([rgb, extinction[:, None]], axis=1).astype(np.float32)[None, None]
    return ValueTable(texels, first, last)


@lru_cache(maxsize=8)
def slab_table(function: TransferFunction, length: float, entries: int = 0) -> ValueTable:
    """Integrals over slabs: ``(LENGTHS, n, n, 4)`` of (attenuated mean source, mean extinction), row back, column front.

    Parameters
    ----------
    function
        The transfer function.
    length
        Length of a whole slab in world units; the layers are for lengths from 0 to ``length``.
    entries
        Size along each value axis; 0 chooses it from the function.

    Raises
    ------
    ValueRangeError
        When ``entries`` lies outside of 2 to 4096, or ``length`` is not positive.
    """
    if entries and not 2 <= entries <= 4096:
        raise ValueRangeError("transfer.preintegrated.entries", f"is {entries}, must lie in [2, 4096] or be 0")
    if not length > 0:
        raise ValueRangeError("transfer.preintegrated", f"got slabs of length {length}, must be positive")
    first, last = value_axis(function)
    n = entries or entries_needed(function, *SLAB_ENTRIES)
    texels = np.empty((LENGTHS, n, n, 4), dtype=np.float32)
    segments = _Segments.of(function, first, last, n)
    _fill_means(texels, segments, function, _entry_values(first, last, n))
    _fill_attenuated(texels, segments, length * np.arange(1, LENGTHS) / (LENGTHS - 1))
    return ValueTable(texels, first, last)


@lru_cache(maxsize=32)
def opacity_error(function: TransferFunction, length: float, entries: int = 0) -> float:
    """Greatest error of opacity that interpolation between entries makes over slabs of a length; estimated.

    Slabs begin and end between entries, above all next to control points, where it is greatest. What is exact follows from
    the running integral of extinction, in float64.
    """
    table = slab_table(function, length, entries)
    n, first = table.entries, table.first_value
    step = (table.last_value - first) / (n - 1)
    control = function.values[:, None] + step * np.array([-1.5, -0.75, -0.25, 0.25, 0.75, 1.5])
    spread = first + step * (np.linspace(0, n - 2, 16).round() + 0.5)
    values = np.unique(np.clip(np.concatenate([control.ravel(), spread]), first, table.last_value))
    ends = np.concatenate([function.values, values])
    knots = np.unique(np.concatenate([ends, np.nextafter(function.values, -np.inf)]))
    _, extinction = function(knots)
    running = np.concatenate([[0.0], np.cumsum(np.diff(knots) * (extinction[1:] + extinction[:-1]) / 2)])
    front, back = np.meshgrid(values, values)
    apart = np.abs(back - front) > step / 4
    front, back = front[apart], back[apart]
    exact = (np.interp(back, knots, running) - np.interp(front, knots, running)) / (back - front)
    x, y = (front - first) / step, (back - first) / step
    i, j = (np.minimum(place.astype(np.int64), n - 2) for place in (x, y))
    u, v = x - i, y - j
    mean = table.texels[0, :, :, 3].astype(np.float64)
    drawn = (1 - v) * ((1 - u) * mean[j, i] + u * mean[j, i + 1]) + v * ((1 - u) * mean[j + 1, i] + u * mean[j + 1, i + 1])
    return float(np.abs(np.exp(-drawn * length) - np.exp(-exact * length)).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class _Segments:
    """The function between neighbouring entries, at Gauss nodes; no control point between entries is lost.

    ``source`` (n-1, q, 3), ``extinction`` (n-1, q, 1), quadrature ``weight`` (n-1, q); ``depth`` (n-1, q) is extinction
    integrated over values from the segment's lower end, ``total`` (n-1) over the whole segment. All per unit of value.
    """

    source: FloatArray
    extinction: FloatArray
    weight: FloatArray
    depth: FloatArray
    total: FloatArray
    step: float

    @classmethod
    def of(cls, function: TransferFunction, first: float, last: float, n: int) -> _Segments:
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_NODES)
        ends = np.linspace(first, last, n)
        step = (last - first) / (n - 1)
        # Break each segment at the control points inside it; pieces of no width weigh nothing.
        inside = [function.values[(function.values > a) & (function.values < b)] for a, b in itertools.pairwise(ends)]
        pieces = 1 + max(len(i) for i in inside)
        breaks = np.stack(
            [np.concatenate([[a], i, np.full(pieces - len(i), b)]) for a, b, i in zip(ends, ends[1:], inside, strict=False)]
        )
        width = np.diff(breaks, axis=1)[..., None]
        middle = (breaks[:, 1:] + breaks[:, :-1])[..., None] / 2
        values = middle + nodes * width / 2
        # Steps belong to the side that a piece lies on: nodes lie strictly inside, so evaluation picks it by itself.
        rgb_source = function.source(values)
        low = breaks[:, :-1, None]
        _, tau_low = function(np.nextafter(low, np.inf))
        _, tau_here = function(values)
        within = (values - low) * (tau_low + tau_here) / 2
        _, tau_high = function(np.nextafter(breaks[:, 1:, None], -np.inf))
        piece_total = np.where(width > 0, width * (tau_low + tau_high) / 2, 0.0)
        before = np.cumsum(piece_total, axis=1) - piece_total
        m = n - 1
        return cls(
            source=rgb_source.reshape(m, -1, 3),
            extinction=tau_here.reshape(m, -1, 1),
            weight=(weights / 2 * width).reshape(m, -1),
            depth=np.where(width > 0, before + within, 0.0).reshape(m, -1),
            total=piece_total.sum(axis=(1, 2)),
            step=step,
        )


def _fill_means(texels: npt.NDArray[np.float32], segments: _Segments, function: TransferFunction, values: FloatArray) -> None:
    """Mean source and mean extinction of all pairs: differences of antiderivatives over the difference of values."""
    n = len(values)
    mean_source = np.einsum("kq,kqc->kc", segments.weight, segments.source)
    antiderivative = np.zeros((n, 4))
    np.cumsum(np.concatenate([mean_source, segments.total[:, None]], axis=1), axis=0, out=antiderivative[1:])
    difference = antiderivative[:, None, :] - antiderivative[None, :, :]
    span = (np.arange(n)[:, None] - np.arange(n)[None, :]) * segments.step
    np.fill_diagonal(span, 1.0)
    means = difference / span[..., None]
    _, extinction = function(values)
    diagonal = np.arange(n)
    means[diagonal, diagonal, :3] = function.source(values)
    means[diagonal, diagonal, 3] = extinction
    np.maximum(means, 0.0, out=means)
    texels[0] = means
    texels[1:, ..., 3] = means[..., 3]
    texels[1:, diagonal, diagonal, :3] = means[diagonal, diagonal, :3]


def _fill_attenuated(texels: npt.NDArray[np.float32], segments: _Segments, lengths: FloatArray) -> None:
    """Attenuated mean source of all pairs off the diagonal; a slab over m segments takes d/m of its length in each.

    Longer slabs are differences of running sums, which lose digits where the whole function is opaque; those that would lose
    too many are put together segment by segment.
    """
    n = texels.shape[1]
    total = float(segments.total.sum())
    # Diagonals from this one on have the whole function within MOST_DEPTH.
    first = min(n, max(1, int(np.ceil(lengths.max() * total / segments.step / MOST_DEPTH))))
    for m in range(1, first):
        _fill_by_windows(texels, segments, lengths, m)
    for m in range(first, n, DIAGONALS_AT_ONCE):
        _fill_by_sums(texels, segments, lengths, np.arange(m, min(n, m + DIAGONALS_AT_ONCE)))


def _mean_source(colour: FloatArray, depth: FloatArray, length: FloatArray) -> FloatArray:
    """``K = C tau / (1 - exp(-tau d))``, and C / d in the limit; ``depth`` is tau d."""
    thick = depth > 1e-9
    return np.asarray(colour / length * np.where(thick, depth / np.where(thick, -np.expm1(-depth), 1.0), 1.0))


def _put_right(found: FloatArray, known: FloatArray, depth: FloatArray) -> FloatArray:
    """Factor for what Gauss nodes miss of a steep decay: the opacity of a segment is known."""
    steep = depth > 0.05
    return np.where(steep, known / np.where(steep, found, 1.0), 1.0)


def _fill_by_sums(
    texels: npt.NDArray[np.float32], segments: _Segments, lengths: FloatArray, diagonals: npt.NDArray[np.int64]
) -> None:
    """Fill diagonals together: light of a slab is a difference of running sums over the whole function.

    With T the running integral of extinction, light from [s_i, s_j] towards s_i is exp(r T_i) (G_j - G_i) where G sums source
    times exp(-r T), and r is path length per unit of value; towards s_j it is the same the other way round.
    """
    n = texels.shape[1]
    running = np.concatenate([[0.0], np.cumsum(segments.total)])
    at_nodes = running[:-1, None] + segments.depth
    rate = lengths / (diagonals[:, None] * segments.step)  # (b, l)
    which = np.repeat(np.arange(len(diagonals)), n - diagonals)
    low = np.concatenate([np.arange(n - m) for m in diagonals])
    high = low + diagonals[which]
    depth = rate[which] * (running[high] - running[low])[:, None]
    opacity = -np.expm1(-rate[:, :, None] * segments.total)
    for layer_rows, layer_columns, start, towards in ((high, low, 0.0, -1.0), (low, high, running[-1], 1.0)):
        through = np.exp(towards * rate[:, :, None, None] * (at_nodes - start))
        weights = rate[:, :, None, None] * segments.weight * through
        found = np.einsum("blkq,kq->blk", weights, segments.extinction[..., 0])
        edge = running[:-1] if towards < 0 else running[1:]
        known = np.exp(towards * rate[:, :, None] * (edge - start)) * opacity
        light = np.einsum("blkq,kqc->blkc", weights, segments.source)
        light *= _put_right(found, known, rate[:, :, None] * segments.total)[..., None]
        sums = np.zeros((*rate.shape, n, 3))
        np.cumsum(light, axis=2, out=sums[:, :, 1:])
        here = low if towards < 0 else high
        back = np.exp(-towards * rate[which] * (running[here] - start)[:, None])
        colour = back[..., None] * (sums[which, :, high] - sums[which, :, low])
        source = _mean_source(colour, depth[..., None], lengths[:, None])
        texels[1:, layer_rows, layer_columns, :3] = source.transpose(1, 0, 2)


def _fill_by_windows(texels: npt.NDArray[np.float32], segments: _Segments, lengths: FloatArray, m: int) -> None:
    """Fill one diagonal (Lum, Wilson and Ma, section 4.2): segments are composited over all windows of m neighbours.

    Windows are put together of windows whose sizes are powers of two; both directions and all lengths run side by side.
    """
    n = texels.shape[1]
    rate = lengths / (m * segments.step)
    depth = rate[:, None, None] * segments.depth
    total = rate[:, None] * segments.total
    upward = rate[:, None, None] * segments.weight * np.exp(-depth)
    downward = rate[:, None, None] * segments.weight * np.exp(depth - total[..., None])
    weights = np.stack([upward, downward])
    found = np.einsum("dlkq,kq->dlk", weights, segments.extinction[..., 0])
    light = np.einsum("dlkq,kqc->dlkc", weights, segments.source)
    light *= _put_right(found, -np.expm1(-total), total)[..., None]
    colour = _windows(light, np.exp(-total)[..., None], m)
    running = np.concatenate([[0.0], np.cumsum(segments.total)])
    slab_depth = (rate[:, None] * (running[m:] - running[:-m]))[..., None]
    source = _mean_source(colour, slab_depth, lengths[:, None, None])
    low, high = np.arange(n - m), np.arange(m, n)
    texels[1:, high, low, :3] = source[0]
    texels[1:, low, high, :3] = source[1]


def _windows(colour: FloatArray, transmittance: FloatArray, size: int) -> FloatArray:
    """Composite ``size`` neighbouring segments at all starts.

    ``colour`` (2, l, k, 3) for light that leaves at the low and at the high end, ``transmittance`` (l, k, 1).
    """
    power, width = (colour, transmittance), 1
    done, covered = power, 1 if size & 1 else 0
    while 2 * width <= size:
        power, width = _join(power, width, power), 2 * width
        if size & width:
            done = power if covered == 0 else _join(done, covered, power)
            covered += width
    return done[0]


def _join(low: tuple[FloatArray, FloatArray], width: int, high: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Windows of ``width`` segments, each followed by the window that begins where it ends."""
    count = high[1].shape[1] - width
    low_colour, low_through = low[0][:, :, :count], low[1][:, :count]
    high_colour, high_through = high[0][:, :, width:], high[1][:, width:]
    joined = np.stack([low_colour[0] + low_through * high_colour[0], high_colour[1] + high_through * low_colour[1]])
    return joined, low_through * high_through
