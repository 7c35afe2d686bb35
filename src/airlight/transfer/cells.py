"""Transfer functions as cells that the device walks through: the function itself and its integral, exact at any value.

A cell is a stretch between neighbouring control points, or a part of one. Colour and extinction are linear in it, so that what
light a slab collects without attenuation, and its extinction, are differences of antiderivatives: no control point is lost,
steps have no width, and no table's resolution enters (Engel and Ertl, section 6.3: integral functions).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from .function import FloatArray, TransferFunction

GRID = 64  # cells of a function without control points: differences within a wide cell lose digits
BINS = 256  # a multiple of GRID, so that only control points lie inside a bin
MOST_EVEN = 2048
ROWS_PER_CELL = 5
ROW_WIDTH = 64
QUARTERS = np.array([[0.25], [0.75]])


def value_axis(function: TransferFunction) -> tuple[float, float]:
    """First and last value of the axis; a function of one value gets a narrow axis round it."""
    first, last = function.domain
    if last > first:
        return first, last
    width = 1e-3 * abs(first) or 1e-6
    return first - width / 2, last + width / 2


@dataclass(frozen=True, eq=False)
class Cells:
    """A function cut into cells of positive width.

    ``borders`` (k + 1,) values, float64; ``low`` and ``high`` (k, 4) colour and extinction just inside of each cell's ends;
    ``integral`` (k + 1, 4) source and extinction [1/world] integrated up to the borders, over the share of the axis.
    """

    borders: FloatArray
    low: FloatArray
    high: FloatArray
    integral: FloatArray
    associated: bool

    @property
    def axis(self) -> tuple[float, float]:
        """First and last value."""
        return float(self.borders[0]), float(self.borders[-1])


@lru_cache(maxsize=32)
def even_cells(function: TransferFunction) -> int:
    """Least number of equally wide cells that begin at all control points, 0 where there is none: such cells need no search.

    Functions with steps have none: which side a value at the very step belongs to is told by comparing it.
    """
    first, last = value_axis(function)
    if (np.diff(function.values) == 0).any():
        return 0
    shares = (function.values - first) / (last - first)
    counts = np.arange(max(GRID, len(shares) - 1), MOST_EVEN + 1)
    for some in (shares[:8], shares):  # few numbers pass the first points
        places = some * counts[:, None]
        counts = counts[(np.abs(places - np.round(places)) < 1e-4).all(axis=1)]
    return int(counts[0]) if len(counts) else 0


def has_stepped_ends(function: TransferFunction) -> bool:
    """Whether there is a step at the first or the last value, so that the medium beyond is another than that at the end."""
    points = function.points
    return len(points) > 1 and (points[0][0] == points[1][0] or points[-1][0] == points[-2][0])


@lru_cache(maxsize=32)
def cells_of(function: TransferFunction) -> Cells:
    """Cut a function at its control points, and at the grid where none is near."""
    first, last = value_axis(function)
    even = even_cells(function)
    if even:
        return cut_at(function, np.linspace(first, last, even + 1))
    grid = np.linspace(first, last, GRID + 1)
    known = np.unique(np.concatenate([[first], function.values, [last]]))
    above = np.clip(np.searchsorted(known, grid), 1, len(known) - 1)
    apart = np.minimum(np.abs(grid - known[above - 1]), np.abs(known[above] - grid))
    return cut_at(function, np.union1d(known, grid[apart > 1e-3 * (grid[1] - grid[0])]))


def cut_at(function: TransferFunction, borders: FloatArray) -> Cells:
    """Cut a function at increasing values, all control points among them."""
    # What holds just inside of a border is found a quarter into the cell, where no step is.
    near, far = np.concatenate(_medium(function, borders[:-1] + QUARTERS * np.diff(borders)), axis=-1)
    low, high = np.maximum(1.5 * near - 0.5 * far, 0.0), np.maximum(1.5 * far - 0.5 * near, 0.0)
    width = np.diff(borders) / (borders[-1] - borders[0])
    steps = np.concatenate([_mean_source(low, high, function.associated), (low[:, 3:] + high[:, 3:]) / 2], axis=1)
    integral = np.concatenate([np.zeros((1, 4)), np.cumsum(steps * width[:, None], axis=0)])
    return Cells(borders, low, high, integral, function.associated)


def _medium(function: TransferFunction, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    rgb, extinction = function(values)
    return rgb, extinction[..., None]


def _mean_source(low: FloatArray, high: FloatArray, associated: bool) -> FloatArray:
    """Mean over a cell of colour times extinction, both linear: a quadratic."""
    if associated:
        return (low[..., :3] + high[..., :3]) / 2
    rise_rgb, rise = high[..., :3] - low[..., :3], high[..., 3:] - low[..., 3:]
    return low[..., :3] * low[..., 3:] + (low[..., :3] * rise + rise_rgb * low[..., 3:]) / 2 + rise_rgb * rise / 3


def integral_to(function: TransferFunction, values: npt.ArrayLike) -> FloatArray:
    """Integral (..., 4) of source and extinction over the share of the axis, up to values (...) that are held within it."""
    cells = cells_of(function)
    held = np.clip(np.asarray(values, dtype=np.float64), *cells.axis)
    cell = np.clip(np.searchsorted(cells.borders, held, side="right") - 1, 0, len(cells.low) - 1)
    width = cells.borders[cell + 1] - cells.borders[cell]
    w = ((held - cells.borders[cell]) / width)[..., None]
    low, high = cells.low[cell], cells.high[cell]
    here = low + w * (high - low)
    part = w * (low + here) / 2
    part[..., :3] = w * _mean_source(low, here, cells.associated)
    return cells.integral[cell] + part * (width / (cells.axis[1] - cells.axis[0]))[..., None]


@lru_cache(maxsize=32)
def pieces_of(function: TransferFunction) -> Cells:
    """Cut a function at its control points alone."""
    first, last = value_axis(function)
    within = function.values[(function.values > first) & (function.values < last)]
    return cut_at(function, np.unique([first, *within, last]))


@lru_cache(maxsize=32)
def piece_texels(function: TransferFunction) -> npt.NDArray[np.float32]:
    """Rows as those of ``function_texels``, binned, of cells that end at control points alone."""
    return _binned(pieces_of(function))


@lru_cache(maxsize=32)
def function_texels(function: TransferFunction, binned: bool = False) -> npt.NDArray[np.float32]:
    """Rows of four numbers for ``wgsl/transfer/cells.wgsl``, 64 to a line of the texture: one row a bin, five a cell.

    The rows of a cell: (first value, last value, 1 / width, 0), (colour, extinction) at both ends, and the integral as a sum of
    two 32-bit numbers. The row of a bin: the row of the cell in which it begins, and that cell's first three numbers. Even
    cells have no bins and do without their first row, unless they are to be ``binned``.
    """
    cells = cells_of(function)
    if even_cells(function) and not binned:
        return _in_lines(_cell_rows(cells)[:, 1:].reshape(-1, 4))
    return _binned(cells)


def _cell_rows(cells: Cells) -> npt.NDArray[np.float32]:
    count = len(cells.low)
    cell_rows = np.zeros((count, ROWS_PER_CELL, 4), dtype=np.float32)
    cell_rows[:, 0, 0], cell_rows[:, 0, 1] = cells.borders[:-1], cells.borders[1:]
    cell_rows[:, 0, 2] = 1 / np.diff(cells.borders)
    cell_rows[:, 1], cell_rows[:, 2] = cells.low, cells.high
    cell_rows[:, 3], cell_rows[:, 4] = two_parts(cells.integral[:-1])
    return cell_rows


def _binned(cells: Cells) -> npt.NDArray[np.float32]:
    (first, last), count = cells.axis, len(cells.low)
    cell_rows = _cell_rows(cells)
    cell_rows[-1, 0, 1] = np.finfo(np.float32).max  # no value lies above the last cell
    # A bin's number is found in 32 bits: it may be one too large just below its edge.
    edges = first + (np.arange(BINS) - 1e-3) / BINS * (last - first)
    begins = np.clip(np.searchsorted(cells.borders, edges, side="right") - 1, 0, count - 1)
    bin_rows = np.zeros((BINS, 4), dtype=np.float32)
    bin_rows[:, 0] = BINS + ROWS_PER_CELL * begins
    bin_rows[:, 1:] = cell_rows[begins, 0, :3]
    return _in_lines(np.concatenate([bin_rows, cell_rows.reshape(-1, 4)]))


@lru_cache(maxsize=16)
def stacked_texels(functions: tuple[TransferFunction, ...]) -> npt.NDArray[np.float32]:
    """Rows of several functions, (n, lines, 64, 4). The last line of each begins with the media before and behind its ends."""
    even = all_even(functions)
    layers = [function_texels(function, not even)[0] for function in functions]
    texels = np.zeros((len(layers), 1 + max(len(layer) for layer in layers), ROW_WIDTH, 4), dtype=np.float32)
    for number, (function, layer) in enumerate(zip(functions, layers, strict=True)):
        texels[number, : len(layer)] = layer
        texels[number, -1, :2] = end_media(function)
    return texels


def all_even(functions: tuple[TransferFunction, ...]) -> bool:
    """Whether all functions have equally wide cells."""
    return all(even_cells(function) for function in functions)


def end_media(function: TransferFunction) -> FloatArray:
    """Colour and extinction (2, 4) before the first and behind the last value of a function."""
    first, last = function.domain
    return np.concatenate(_medium(function, np.array([np.nextafter(first, -np.inf), last])), axis=-1)


def _in_lines(rows: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Rows as lines of a texture, as many as a power of two: where that changes, software Vulkan compiles shaders anew."""
    lines = -(-len(rows) // ROW_WIDTH)
    texels = np.zeros((1, 1 << (lines - 1).bit_length(), ROW_WIDTH, 4), dtype=np.float32)
    texels.reshape(-1, 4)[: len(rows)] = rows
    return texels


def two_parts(numbers: FloatArray) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return numbers as sums of two 32-bit ones."""
    high = numbers.astype(np.float32)
    return high, (numbers - high).astype(np.float32)
