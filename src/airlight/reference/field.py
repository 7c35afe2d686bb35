"""Fields: the continuous function that reconstruction makes of the samples.

``field(setup, p_index (n, 3)) -> (value (n,), empty (n,))``; points beyond the outer voxel centres take the values there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import FloatArray
from .setup import BoolArray, IntArray, Setup

Values = tuple[FloatArray, BoolArray]


def field_value(setup: Setup, p_index: FloatArray) -> Values:
    """Value of the layer's field, 0 where it is empty."""
    return FIELDS[setup.stages["field"].name](setup, p_index)


def nearest(setup: Setup, p_index: FloatArray) -> Values:
    """Value of the nearest voxel; half way the one further up."""
    last = np.array(setup.layer.volume.size) - 1
    x, y, z = np.clip(np.floor(p_index + 0.5), 0, last).astype(np.int64).T
    empty = np.zeros(len(p_index), dtype=bool) if setup.full is None else setup.full[z, y, x] == 0
    return setup.grid[z, y, x], empty


def linear(setup: Setup, p_index: FloatArray) -> Values:
    """Trilinear interpolation; the mean of the voxels that are not empty, where these hold half of the weight."""
    if setup.full is None:
        return trilinear(setup.grid, p_index), np.zeros(len(p_index), dtype=bool)
    weight = trilinear(setup.full, p_index)
    empty = weight < 0.5
    value = trilinear(setup.grid, p_index) / np.where(empty, 1.0, weight)
    return np.where(empty, 0.0, value), empty


@np.errstate(under="ignore")
def trilinear(grid: FloatArray, p_index: FloatArray) -> FloatArray:
    """Interpolate ``(z, y, x)`` samples, or vectors ``(z, y, x, 3)``, at points (n, 3)."""
    nz, ny, nx = grid.shape[:3]
    samples = grid.reshape(nz * ny * nx, *grid.shape[3:])
    # Find the lower voxel and the share of the upper one along each axis.
    x, fx = _cell(p_index[:, 0], nx)
    y, fy = _cell(p_index[:, 1], ny)
    z, fz = _cell(p_index[:, 2], nz)
    if samples.ndim > 1:
        fx, fy, fz = fx[:, None], fy[:, None], fz[:, None]
    lower = (z * ny + y) * nx + x
    dx, dy, dz = int(nx > 1), nx * int(ny > 1), nx * ny * int(nz > 1)

    def along_x(first: IntArray) -> FloatArray:
        left = samples[first]
        return np.asarray(left + fx * (samples[first + dx] - left))

    def along_y(first: IntArray) -> FloatArray:
        front = along_x(first)
        return np.asarray(front + fy * (along_x(first + dy) - front))

    bottom = along_y(lower)
    return np.asarray(bottom + fz * (along_y(lower + dz) - bottom))


def _cell(p: FloatArray, n: int) -> tuple[IntArray, FloatArray]:
    inside = np.clip(p, 0.0, n - 1.0)
    lower = np.minimum(inside.astype(np.int64), max(n - 2, 0))
    return lower, inside - lower


FIELDS: dict[str, Callable[[Setup, FloatArray], Values]] = {
    "nearest": nearest,
    "nearest_masked": nearest,
    "linear": linear,
    "linear_exact": linear,
    "linear_masked": linear,
}
