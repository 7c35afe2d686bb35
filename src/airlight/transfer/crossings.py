"""Tables of the surfaces that a slab crosses, by the numbers of the intervals in which its two ends lie.

The number of a value is how many iso-values lie at or below it. A slab from number ``i`` to ``j`` crosses the surfaces between
them in order, and what they send to the eye together depends on the two numbers alone: ``(m + 1)**2`` entries are exact for any
field, and looked up without interpolation (Engel and Ertl 2002, section 8.3, whose table is over values).

Where a medium lies between the surfaces its light depends on the length of the way from the first to the last of them, too: the
table holds it for four lengths, and a cubic runs through them. A slab that crosses one surface needs none of it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..errors import LimitError
from .cells import integral_to, two_parts
from .function import FloatArray, TransferFunction
from .runs import iso_values, mean_extinction, medium_of, runs, runs_in_medium, way_of

MOST_IN_MEDIUM = 256
LENGTHS = np.array([0.0, 1 / 3, 2 / 3, 1.0])
BINS = (1, 64, 256, 1024, 4096)
PER_BIN = 3
MARGIN = 1e-3
ROW_WIDTH = 64
PAIR_LINE = 1024
ROWS_ALONE, ROWS_IN_MEDIUM = 3, 7
LAYERS_ALONE, LAYERS_IN_MEDIUM = 3, 9
IntArray = npt.NDArray[np.int64]
Texels = npt.NDArray[np.float32]


@lru_cache(maxsize=32)
def lowered(function: TransferFunction, by: float) -> TransferFunction:
    """Return the function with its surfaces at values lower by a little."""
    return replace(function, surfaces=tuple(replace(s, value=s.value - by) for s in function.surfaces))


# -- which surfaces lie below a value


@lru_cache(maxsize=16)
def bin_count(function: TransferFunction) -> int:
    """Least of the usual numbers of bins with at most three iso-values in each, or the greatest of them."""
    return next((n for n in BINS if _in_bins(function, n)[1].max() <= PER_BIN), BINS[-1])


def _in_bins(function: TransferFunction, bins: int) -> tuple[IntArray, IntArray]:
    """Number (bins,) of the first surface of each bin, and how many it holds; a little more than it, for 32 bits find bins."""
    values = iso_values(function).astype(np.float32).astype(np.float64)
    width = (values[-1] - values[0]) / bins
    edges = values[0] + width * np.arange(bins + 1)
    first = np.searchsorted(values, edges[:-1] - MARGIN * width, side="left")
    return first, np.searchsorted(values, edges[1:] + MARGIN * width, side="right") - first


@lru_cache(maxsize=16)
def surface_texels(function: TransferFunction, in_medium: bool) -> Texels:
    """Rows of four numbers for ``wgsl/transfer/surfaces.wgsl``, 64 to a line of the texture.

    The row of a bin: the number of its first surface, and its (at most three) next iso-values. The rows of a surface: its
    value, and zeros; colour and opacity of its front, and of its back; in a medium four rows more: the function's integral as a
    sum of two 32-bit numbers, and source and extinction just below and at the value.
    """
    bins = bin_count(function)
    values = iso_values(function)
    first, held = _in_bins(function, bins)
    count = ROWS_IN_MEDIUM if in_medium else ROWS_ALONE
    rows = np.zeros((bins + count * len(values), 4), dtype=np.float32)
    rows[:bins, 0] = first
    rows[:bins, 1:] = np.finfo(np.float32).max
    for place in range(PER_BIN):
        there = held > place
        rows[:bins, 1 + place][there] = values[first[there] + place]
    surface = rows[bins:].reshape(-1, count, 4)
    surface[:, 0, 0] = values
    for row, sides in ((1, [s.front for s in function.surfaces]), (2, [s.back for s in function.surfaces])):
        surface[:, row] = [(*colour, opacity) for colour, opacity in sides]
    if in_medium:
        medium = medium_of(function)
        surface[:, 3], surface[:, 4] = two_parts(integral_to(medium, values))
        for row, at in ((5, np.nextafter(values, -np.inf)), (6, values)):
            surface[:, row, :3], surface[:, row, 3] = medium.source(at), medium(at)[1]
    texels = np.zeros((1, -(-len(rows) // ROW_WIDTH), ROW_WIDTH, 4), dtype=np.float32)
    texels.reshape(-1, 4)[: len(rows)] = rows
    return texels


# -- what the surfaces between two numbers send


@lru_cache(maxsize=8)
def pair_texels(function: TransferFunction, length: float) -> Texels:
    """Entries (layers, m + 1, m + 1, 4) over the numbers at the front (row) and at the back (column) of a slab.

    Layer 0: (value of the front-most surface, of the hindmost, mean extinction between them, 0). Then, for each length of the
    way between them: associated colour and opacity, and both weighted by where they lie, from 0 at the front-most surface to 1.
    The lengths are ``LENGTHS`` times ``length``; 0 alone where ``length`` is 0, since there is no medium.

    Raises
    ------
    LimitError
        When more than 256 surfaces lie in a medium.
    """
    m = len(function.surfaces)
    lengths = length * LENGTHS if length > 0 else LENGTHS[:1]
    if length > 0 and m > MOST_IN_MEDIUM:
        remedy = "use fewer, or surfaces alone (TransferFunction.from_surfaces)"
        raise LimitError("transfer.surfaces", f"are {m} in a medium, where at most {MOST_IN_MEDIUM} fit", remedy)
    texels = np.zeros((1 + 2 * len(lengths), m + 1, m + 1, 4), dtype=np.float32)
    first, last = np.triu_indices(m)
    for rises in (True, False):
        way = way_of(function, rises)
        # From places in the order of the ray to the numbers in front of the first surface and behind the last one.
        front, back = (first, last + 1) if rises else (m - first, m - 1 - last)
        texels[0, front, back, 0], texels[0, front, back, 1] = way.values[first], way.values[last]
        texels[0, front, back, 2] = mean_extinction(way, first, last)
        light, moment = runs(way)
        texels[1, front, back], texels[2, front, back] = light[first, last], moment[first, last]
        if len(lengths) > 1:
            light, moment = runs_in_medium(way, first, last, lengths[1:])
            texels[3::2, front, back], texels[4::2, front, back] = light.swapaxes(0, 1), moment.swapaxes(0, 1)
    return texels


@lru_cache(maxsize=8)
def packed_pairs(function: TransferFunction, length: float) -> Texels:
    """Entries of `pair_texels`, row by row with the layers of each side by side, in lines of 1024 and slices of 1024 lines."""
    entries = pair_texels(function, length).transpose(1, 2, 0, 3).reshape(-1, 4)
    lines = -(-len(entries) // PAIR_LINE)
    texels = np.zeros((-(-lines // PAIR_LINE), min(lines, PAIR_LINE), PAIR_LINE, 4), dtype=np.float32)
    texels.reshape(-1, 4)[: len(entries)] = entries
    return texels


def cubic(place: npt.ArrayLike) -> FloatArray:
    """Weights (..., 4) of the values at ``LENGTHS`` in the cubic through them, at places (...)."""
    x = np.asarray(place, dtype=np.float64)[..., None]
    weights = np.ones((*x.shape[:-1], 4))
    for i, own in enumerate(LENGTHS):
        for other in np.delete(LENGTHS, i):
            weights[..., i] *= (x[..., 0] - other) / (own - other)
    return weights


@lru_cache(maxsize=32)
def crossing_error(function: TransferFunction, length: float, of_ends: bool = False) -> float:
    """Greatest error of a colour channel that the cubic makes of slabs that cross several surfaces in a medium; estimated.

    ``of_ends`` asks for what either end of the run of surfaces gets instead, white light included, whose sum is exact.
    """
    m = len(function.surfaces)
    if m < 2:
        return 0.0
    gaps = np.unique(np.geomspace(1, m - 1, 6).round().astype(np.int64))
    first = np.concatenate([np.arange(m - gap) for gap in gaps])
    last = np.concatenate([np.arange(gap, m) for gap in gaps])
    between = (LENGTHS[1:] + LENGTHS[:-1]) / 2
    worst = 0.0
    for rises in (True, False):
        sent = runs_in_medium(way_of(function, rises), first, last, length * np.concatenate([LENGTHS, between]))
        light, moment = (np.einsum("qn,rnc->rqc", cubic(between), known[:, :4]) - known[:, 4:] for known in sent)
        light[..., 3] = 0.0
        worst = max(worst, *(float(np.abs(part).max()) for part in ((moment, light - moment) if of_ends else (light,))))
    return worst
