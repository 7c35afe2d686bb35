"""Tables of slabs: what attenuation inside a slab does to its light, over the values at its two ends and its length.

A slab is a piece of a ray of length ``d`` along which the value runs straight from ``s_front`` to ``s_back`` (Engel and
Ertl, section 6). Its mean source ``S`` and mean extinction ``tau`` [1/world] are exact differences of integrals (``cells.py``).
Its colour is ``C = (S + G) (1 - exp(-tau d)) / tau``, and the table holds the shift ``G``: nothing where the colour is constant
within the slab, next to the diagonal, and for slabs of no length, so that little is lost between entries.

The table itself is made on the device (``wgsl/passes/slab_table.wgsl``, ``wgsl/transfer/stretch.wgsl``); what is here feeds it,
chooses its size, and is the yardstick: the integral by quadrature in float64.

Kept is ``G / f(tau d)``, where ``f(x) = 1/2 - [1 - (1 + x) exp(-x)] / [x (1 - exp(-x))]`` is how far attenuation moves the
light of a homogeneous slab from its middle towards its front. So a table of one length serves shorter slabs: exactly where the
extinction is constant and the colour linear, and well elsewhere; a table of several lengths is nearer still.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .cells import cut_at, integral_to, pieces_of, two_parts, value_axis
from .function import FloatArray, TransferFunction

SIZES = (128, 256, 512, 1024)
MOST_ENTRIES = 4096
MOST_PIECES = 512  # of a slab that is cut at control points: a turn of a loop each
LEAST_MOVE = 1e-3
ACCURATE = 1 / 512
ROWS_PER_ENTRY = 3
ROWS_PER_PIECE = 3
MOST_AT_ONCE = 1 << 15
MOST_POINTS = 12
SHORTER = (0.75, 0.5, 0.25)
FAR = np.array([(0, 0.5), (0, 1), (0.5, 0), (0.5, 1), (1, 0), (1, 0.5)])
PART_DEPTH = 2.0
SEEN_PARTS = 20
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
RULE = ((NODES + 1) / 2, WEIGHTS / 2)


def check_table(length: float, entries: int, lengths: int = 1) -> None:
    """Refuse sizes that no table has.

    Raises
    ------
    ValueRangeError
        When ``entries`` lies outside of 2 to 4096, ``lengths`` of 1 to 64, or ``length`` is not positive.
    """
    if not 2 <= entries <= MOST_ENTRIES:
        raise ValueRangeError("transfer.preintegrated.entries", f"is {entries}, must lie in [2, {MOST_ENTRIES}] or be 0")
    if not 1 <= lengths <= 64:
        raise ValueRangeError("transfer.preintegrated.lengths", f"is {lengths}, must lie in [1, 64]")
    if not length > 0:
        raise ValueRangeError("transfer.preintegrated", f"got slabs of length {length}, must be positive")


@lru_cache(maxsize=16)
def segment_rows(function: TransferFunction, entries: int) -> npt.NDArray[np.float32]:
    """Rows (n, 4) for ``wgsl/transfer/stretch.wgsl``: three an entry, then three a piece.

    The rows of an entry: (number of its first piece, extinction, 0, 0), and the function's integral as a sum of two 32-bit
    numbers. The rows of a piece: (width in segments, entry at its low end, entry at its high end, depth for a length of one a
    segment), and (colour, extinction) at both ends. No control point between two entries is lost: it begins a piece.
    """
    ends, segment = _entry_values(function, entries)
    cells = cut_at(function, np.union1d(ends, pieces_of(function).borders))
    begins = np.searchsorted(cells.borders, ends)
    pieces = len(cells.low)
    rows = np.zeros((ROWS_PER_ENTRY * entries + ROWS_PER_PIECE * pieces, 4), dtype=np.float32)
    entry, piece = rows[: ROWS_PER_ENTRY * entries], rows[ROWS_PER_ENTRY * entries :]
    entry[0::3, 0], entry[0::3, 1] = begins, function(ends)[1]
    entry[1::3], entry[2::3] = two_parts(cells.integral[begins])
    numbers = np.full(pieces + 1, -1.0)
    numbers[begins] = np.arange(entries)
    width = np.diff(cells.borders) / segment
    piece[0::3, 0], piece[0::3, 1], piece[0::3, 2] = width, numbers[:-1], numbers[1:]
    piece[0::3, 3] = width * (cells.low[:, 3] + cells.high[:, 3]) / 2
    piece[1::3], piece[2::3] = cells.low, cells.high
    return rows


def _entry_values(function: TransferFunction, entries: int) -> tuple[FloatArray, float]:
    """Values of the entries, and how far they lie apart; entries next to control points lie on them."""
    first, last = value_axis(function)
    ends, segment = np.linspace(first, last, entries), (last - first) / (entries - 1)
    points = pieces_of(function).borders[1:-1]
    nearest = np.rint((points - first) / segment).astype(np.int64)
    close = np.abs(points - ends[nearest]) < 1e-6 * segment
    ends[nearest[close]] = points[close]
    return ends, segment


def slab_light(function: TransferFunction, front: FloatArray, back: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
    """Colour (n, 4) of slabs between values (n,) of the axis, white light in the fourth place, and its first moment (n, 4).

    Colour is associated; white is the light of a colour of one, which is opacity. The moment is weighted by where light comes
    from, 0 at the front and 1 at the back: it is the back's part. Gauss' rule over parts of a small optical depth.
    """
    light, moment = np.zeros((len(front), 4)), np.zeros((len(front), 4))
    at_once = max(1, MOST_AT_ONCE // len(pieces_of(function).low))
    for first in range(0, len(front), at_once):
        rows = slice(first, first + at_once)
        light[rows], moment[rows] = _slab_light(function, front[rows], back[rows], length)
    return light, moment


def _slab_light(
    function: TransferFunction, front: FloatArray, back: FloatArray, length: float
) -> tuple[FloatArray, FloatArray]:
    cells = pieces_of(function)
    apart = np.where(front == back, 1e-9 * (cells.axis[1] - cells.axis[0]), 0.0)
    back = np.where(back + apart > cells.axis[1], back - apart, back + apart)
    low, high = np.minimum(front, back), np.maximum(front, back)
    first = np.clip(np.searchsorted(cells.borders, low, side="right") - 1, 0, len(cells.low) - 1)
    last = np.clip(np.searchsorted(cells.borders, high) - 1, first, len(cells.low) - 1)
    count = last - first + 1
    begins = np.cumsum(count) - count
    slab = np.repeat(np.arange(len(front)), count)
    piece = np.arange(len(slab)) + (first - begins)[slab]
    a, b = np.maximum(cells.borders[piece], low[slab]), np.minimum(cells.borders[piece + 1], high[slab])
    up, way = (back > front)[slab], (high - low)[slab]
    width = np.diff(cells.borders)[piece]
    rise = cells.high[piece] - cells.low[piece]
    at_a, at_b = (cells.low[piece] + rise * ((s - cells.borders[piece]) / width)[:, None] for s in (a, b))
    depth = length * (b - a) / way * (at_a[:, 3] + at_b[:, 3]) / 2
    total = np.cumsum(depth)
    below, above = total - depth - (total - depth)[begins][slab], total[begins + count - 1][slab] - total
    parts = _Parts(
        slab=slab,
        near=np.where(up[:, None], at_a, at_b),
        far=np.where(up[:, None], at_b, at_a),
        at=np.where(up, a - low[slab], high[slab] - b) / way,
        share=(b - a) / way,
        before=np.where(up, below, above),
        depth=depth,
    ).cut()
    return parts.light(len(front), length, function.associated)


@dataclass(frozen=True, eq=False)
class _Parts:
    """Parts of slabs in which colour and extinction are linear: media at both ends, place and share of the slab, depths."""

    slab: npt.NDArray[np.int64]
    near: FloatArray
    far: FloatArray
    at: FloatArray
    share: FloatArray
    before: FloatArray
    depth: FloatArray

    def cut(self) -> _Parts:
        """Cut what is deep; the middle of what is too deep to be seen is left whole."""
        if (self.depth <= PART_DEPTH).all():
            return self
        count = np.clip(np.ceil(self.depth / PART_DEPTH), 1, 2 * SEEN_PARTS + 1).astype(np.int64)
        each = np.minimum(self.depth / count, PART_DEPTH)
        old = np.repeat(np.arange(len(count)), count)
        number = np.arange(len(old)) - np.repeat(np.cumsum(count) - count, count)
        slope = (self.far[:, 3] - self.near[:, 3]) / np.maximum(self.far[:, 3] + self.near[:, 3], 1e-300)

        def depth_to(number: npt.NDArray[np.int64]) -> FloatArray:
            from_end = self.depth[old] - (count[old] - number) * each[old]
            return np.where(number <= SEEN_PARTS, number * each[old], from_end)

        def place(depth: FloatArray) -> FloatArray:
            # Depth grows as (1 - slope) x + slope x^2.
            s, share = slope[old], np.clip(depth / np.maximum(self.depth[old], 1e-300), 0.0, 1.0)
            return 2 * share / np.maximum(1 - s + np.sqrt(np.maximum((1 - s) ** 2 + 4 * s * share, 0.0)), 1e-300)

        begin, end = depth_to(number), depth_to(number + 1)
        x, y = place(begin), np.where(number + 1 == count[old], 1.0, place(end))
        near, rise = self.near[old], (self.far - self.near)[old]
        return _Parts(
            slab=self.slab[old],
            near=near + rise * x[:, None],
            far=near + rise * y[:, None],
            at=self.at[old] + self.share[old] * x,
            share=self.share[old] * (y - x),
            before=self.before[old] + begin,
            depth=end - begin,
        )

    def light(self, slabs: int, length: float, associated: bool) -> tuple[FloatArray, FloatArray]:
        """Light of the slabs, and its first moment."""
        rise, run = self.far - self.near, length * self.share
        x, weight = (each[:, None] for each in RULE)
        seen = np.exp(-np.minimum(self.before + run * x * (self.near[:, 3] + rise[:, 3] * (x / 2)), 700.0))
        medium = self.near + rise * x[..., None]
        sent = medium * (weight * run * seen)[..., None]
        if not associated:
            sent[..., :3] *= medium[..., 3:]
        light, moment = sent.sum(axis=0), (sent * (self.at + self.share * x)[..., None]).sum(axis=0)
        rows = [np.bincount(self.slab, one, slabs).astype(np.float64) for one in (*light.T, *moment.T)]
        summed: FloatArray = np.stack(rows, axis=1)
        return summed[:, :4], summed[:, 4:]


@lru_cache(maxsize=64)
def colour_error(
    function: TransferFunction, length: float, entries: int, weighted: bool = False, parts: tuple[float, ...] = (1.0,)
) -> float:
    """Greatest error of a colour channel that interpolation between entries makes over slabs of a length; estimated.

    It is greatest for slabs that begin and end close to the same control point; those round the control points at which the
    function bends most are tried, and a few far apart. Of a ``weighted`` table it is that of a slab or of either of its ends,
    for white light, too: lights of one at one end and none at the other show no more. ``parts`` are shares of the length:
    slabs that are as much shorter, and read from the same table.
    """
    first, last = value_axis(function)
    step = (last - first) / (entries - 1)
    places = np.clip((_critical(function, length, step) - first) / step, 0.0, entries - 1.0)
    near = np.stack(np.broadcast_arrays(places[:, :, None], places[:, None, :]), axis=-1).reshape(-1, 2)
    pairs = np.concatenate([near, (FAR * (entries - 2)).round() + 0.5])
    if min(parts) < 1:  # worst where much changes along the slab
        across = np.stack(np.broadcast_arrays(places[:, None, 4], places[None, :, 2]), axis=-1).reshape(-1, 2)
        pairs = np.concatenate([pairs, across])
    pairs = pairs[np.abs(pairs[:, 1] - pairs[:, 0]) > 1e-3]
    # Make the texels round each place.
    low = np.minimum(pairs.astype(np.int64), entries - 2)
    corners = low[:, None] + np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
    kept, which = np.unique(corners[..., 0] * entries + corners[..., 1], return_inverse=True)
    ends = first + step * np.concatenate([np.stack(np.divmod(kept, entries)), pairs.T], axis=1)
    seen, count = _light_and_mean(function, ends[0], ends[1], length), len(kept)
    told = {1.0: tuple(each[count:] for each in seen)}
    told |= {p: _light_and_mean(function, ends[0, count:], ends[1, count:], p * length) for p in parts if p < 1}
    light, moment, mean = (each[:count] for each in seen)
    move = _move(mean, length)
    shift = (light[:, :3] / _weight(mean, length) - mean[:, :3]) / move
    shift[kept // entries == kept % entries] = 0.0
    back = np.where(light > 1e-30, np.clip(moment / np.maximum(light, 1e-30), 0.0, 1.0), 0.5 - move)
    # Interpolate them.
    w = pairs - low
    share = np.stack([(1 - w[:, 0]) * (1 - w[:, 1]), (1 - w[:, 0]) * w[:, 1], w[:, 0] * (1 - w[:, 1]), w[:, 0] * w[:, 1]])
    shift, back = (np.einsum("ck,kcr->kr", share, texels[which.reshape(-1, 4)]) for texels in (shift, back))
    return max(_read_error(length, part * length, told[part], shift, back, weighted) for part in parts)


def _read_error(
    length: float,
    read_length: float,
    told: tuple[FloatArray, ...],
    shift: FloatArray,
    back: FloatArray,
    weighted: bool,
) -> float:
    """Greatest error of slabs with this light, moment and mean, by what was read of them from the table of another length."""
    light, moment, mean = told
    move = _move(mean, read_length)
    drawn = np.clip((mean[:, :3] + shift * move) * _weight(mean, read_length), 0.0, mean[:, :3] * read_length)
    off = [drawn - light[:, :3]]
    if weighted:
        back = np.clip(back + _move(mean, length) - move, 0.0, 1.0)
        at_back = np.append(drawn, light[:, 3:], axis=1) * back - moment
        off += [at_back, off[0] - at_back[:, :3]]
    return max(float(np.abs(part).max(initial=0.0)) for part in off)


@lru_cache(maxsize=64)
def spread_error(function: TransferFunction, length: float, of_ends: bool = False) -> float:
    """Greatest error of a colour channel, or of an end's part of it, of slabs that are drawn as homogeneous ones; estimated.

    Slabs of a length are tried from next to each of the control points at which the function bends most to all others.
    """
    first, last = value_axis(function)
    values = np.unique(np.clip([first, *_critical(function, length, (last - first) / 32)[:, 1:-1].ravel(), last], first, last))
    front, back = (a.ravel() for a in np.meshgrid(values, values))
    light, moment, mean = _light_and_mean(function, front, back, length)
    drawn = np.append(mean[:, :3] * _weight(mean, length), light[:, 3:], axis=1)
    if not of_ends:
        return float(np.abs(drawn - light).max())
    at_back = drawn * (0.5 - _move(mean, length))
    return float(max(np.abs(at_back - moment).max(), np.abs(drawn - at_back - (light - moment)).max()))


def _critical(function: TransferFunction, length: float, step: float) -> FloatArray:
    """Values (n, 7) round the control points next to which colours of slabs bend most within a step."""
    points = np.unique(function.values)
    rgb, extinction = function(points[:, None] + step * np.array([-1.0, 0.0, 1.0]))
    opacity = -np.expm1(-extinction * length)
    seen = np.concatenate([rgb * (1.0 if function.associated else opacity[..., None]), opacity[..., None]], axis=-1)
    bend = np.abs(seen[:, 0] - 2 * seen[:, 1] + seen[:, 2]).max(axis=-1)
    chosen = np.sort(np.argsort(-bend, kind="stable")[:MOST_POINTS])
    gaps = np.diff(points, prepend=-np.inf, append=np.inf)
    below, above = (np.minimum(g[chosen] / 2, 0.15 * step) for g in (gaps[:-1], gaps[1:]))
    steps = np.full(len(chosen), step)
    offsets = np.stack([-1.2 * steps, -0.5 * steps, -below, 0 * steps, above, 0.5 * steps, 1.2 * steps], axis=-1)
    places: FloatArray = points[chosen, None] + offsets
    return places


def _weight(mean: FloatArray, length: float) -> FloatArray:
    """``(1 - exp(-tau d)) / tau``, column (n, 1)."""
    depth: FloatArray = np.maximum(mean[:, 3:] * length, 1e-12)
    weight: FloatArray = -np.expm1(-depth) * (length / depth)
    return weight


def _move(mean: FloatArray, length: float) -> FloatArray:
    """How far attenuation moves the light of a homogeneous slab towards its front, as a share of its length; column (n, 1)."""
    x = np.maximum(mean[:, 3:] * length, 1e-3)
    move: FloatArray = np.maximum(0.5 - (1 - (1 + x) * np.exp(-x)) / (x * -np.expm1(-x)), LEAST_MOVE)
    return move


def _light_and_mean(
    function: TransferFunction, front: FloatArray, back: FloatArray, length: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Colour and white light (n, 4) of slabs, their first moment (n, 4), and (n, 4) mean source and extinction."""
    first, last = value_axis(function)
    apart = np.where(front == back, 1e-9 * (last - first), 0.0)
    back = np.where(back + apart > last, back - apart, back + apart)
    light, moment = slab_light(function, front, back, length)
    source = integral_to(function, np.stack([front, back]))
    mean = (source[1] - source[0]) / ((back - front) / (last - first))[:, None]
    return light, moment, np.maximum(mean, 0.0)


@lru_cache(maxsize=64)
def entries_needed(function: TransferFunction, length: float, weighted: bool = False) -> int:
    """Least of the usual sizes whose interpolation stays below 1/512 over slabs of a length, or the greatest of them."""

    def is_accurate(entries: int) -> bool:
        return colour_error(function, length, entries, weighted) <= ACCURATE

    # The least size does for most functions, and none for most others.
    if is_accurate(SIZES[0]):
        return SIZES[0]
    return next(filter(is_accurate, SIZES)) if is_accurate(SIZES[-1]) else SIZES[-1]


def is_better_cut(function: TransferFunction, length: float, weighted: bool = False) -> bool:
    """Whether no usual size is accurate, and control points are few enough to go from one to the next within a slab."""
    if len(pieces_of(function).low) > MOST_PIECES:
        return False
    return colour_error(function, length, entries_needed(function, length, weighted), weighted) > ACCURATE
