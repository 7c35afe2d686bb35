"""Pre-filtered levels of a grid: each has half the samples along each axis, means over boxes that fill the grid."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt


def level_sizes(size: tuple[int, int, int]) -> tuple[tuple[int, int, int], ...]:
    """Sizes (x, y, z) of all levels, as textures have them: halves, rounded down, to a single sample."""
    x, y, z = size
    return tuple((max(1, x >> n), max(1, y >> n), max(1, z >> n)) for n in range(max(size).bit_length()))


def coarser(grid: npt.NDArray[np.generic]) -> Iterator[npt.NDArray[np.float32]]:
    """Levels 1, 2 ... of samples ``(z, y, x)``, each made of the one before."""
    level = np.asarray(grid)
    while max(level.shape) > 1:
        for axis in range(3):
            level = _halved(level, axis)
        yield level


def _halved(grid: npt.NDArray[np.generic], axis: int) -> npt.NDArray[np.float32]:
    """Means along an axis of n samples over n // 2 boxes of equal length, with the shares of samples at their borders."""
    lines = np.moveaxis(grid, axis, 0)
    n = len(lines)
    if n == 1:
        return grid.astype(np.float32)
    m = n // 2
    first, second = lines[: 2 * m : 2].astype(np.float32), lines[1 : 2 * m : 2].astype(np.float32)
    if n == 2 * m:
        means = (first + second) * np.float32(0.5)
    else:
        # Box i is n / m long: it begins a share i / m into sample 2 i, and ends a share (i + 1) / m into sample 2 i + 2.
        i = np.arange(m, dtype=np.float32).reshape(m, 1, 1)
        means = (first * (m - i) + second * np.float32(m) + lines[2::2].astype(np.float32) * (i + 1)) / np.float32(n)
    return np.moveaxis(means, 0, axis)


def averaged(
    grid: npt.NDArray[np.generic], shape: tuple[int, int, int], progress: Callable[[int, int], None] | None = None
) -> npt.NDArray[np.float32]:
    """Means of samples ``(z, y, x)`` over ``shape`` boxes of equal size that fill the grid; ``progress`` is told of slices."""
    depth, height, width = (_box_shares(n, m) for n, m in zip(grid.shape, shape, strict=True))
    summed = np.zeros(shape, dtype=np.float32)
    for z, shares in enumerate(depth.T):
        plane = height @ grid[z].astype(np.float32) @ width.T
        for box in np.flatnonzero(shares):
            summed[box] += shares[box] * plane
        if progress:
            progress(z + 1, grid.shape[0])
    return summed


def _box_shares(n: int, m: int) -> npt.NDArray[np.float32]:
    """What each of n samples adds to each of m boxes (m, n): the share of the box that it takes."""
    ends = np.arange(m + 1) * (n / m)
    low, high = np.maximum(ends[:-1, None], np.arange(n)), np.minimum(ends[1:, None], np.arange(n) + 1)
    return np.asarray(np.maximum(high - low, 0.0) * (m / n), dtype=np.float32)
