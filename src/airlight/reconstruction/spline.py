"""Coefficients whose cubic B-spline goes through the samples (Unser, Aldroubi and Eden, 1991), and where they are kept.

Beyond the faces of the grid samples and coefficients go on as those of the outer voxels, as they do in textures.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..keeping import Kept
from ..volume import Volume

POLE = math.sqrt(3) - 2
REACH = 32  # samples after which the impulse response of a pole is below the rounding error of float64
CHUNK_BYTES = 8 << 20
KEPT_GRIDS = 4  # of a volume, each as large as the channels that are drawn


def coefficients(volume: Volume, channels: tuple[int, ...], time: int) -> Volume:
    """Volume of the coefficients of channels, float32, on the same grid; a volume keeps the last four."""

    def make() -> Volume:
        grids = np.stack([prefiltered(volume.grid(channel, time)) for channel in channels])
        return Volume(grids, world_from_index=volume.world_from_index, units=volume.units)

    kept: Kept[tuple[tuple[int, ...], int], Volume] = volume.__dict__.setdefault("_coefficients", Kept(KEPT_GRIDS))
    return kept.get((channels, time), make)


def prefiltered(grid: npt.NDArray[np.generic]) -> npt.NDArray[np.float32]:
    """Coefficients ``(z, y, x)`` of samples ``(z, y, x)``: a recursive filter forth and back along each axis."""
    result = grid.astype(np.float32)
    rows = max(1, CHUNK_BYTES // max(1, result[0].nbytes))
    for first in range(0, len(result), rows):
        part = result[first : first + rows]
        for axis in (1, 2):
            # A copy whose first axis is the filter's: each step then adds whole planes that lie together.
            part[...] = np.moveaxis(_filtered(np.ascontiguousarray(np.moveaxis(part, axis, 0))), 0, axis)
    flat = result.reshape(len(result), -1)
    columns = max(1, CHUNK_BYTES // max(1, 4 * len(result)))
    for first in range(0, flat.shape[1], columns):
        flat[:, first : first + columns] = _filtered(flat[:, first : first + columns].copy())
    return result


def _filtered(lines: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Filter along the first axis, in place."""
    n, pole = len(lines), np.float32(POLE)
    if n == 1:
        return lines
    lines *= np.float32(6)
    # What came before the first sample is the line mirrored, again and again.
    before = np.arange(REACH) % (2 * n)
    before = np.minimum(before, 2 * n - 1 - before)
    weights = (POLE ** np.arange(1, REACH + 1)).astype(np.float32)
    lines[0] += np.tensordot(weights, lines[before], axes=1)
    for k in range(1, n):
        lines[k] += pole * lines[k - 1]
    lines[-1] *= np.float32(POLE / (POLE - 1))
    for k in range(n - 2, -1, -1):
        lines[k] = pole * (lines[k + 1] - lines[k])
    return lines
