"""Fields: the continuous function that reconstruction makes of the samples.

``field(setup, p_index (n, 3)) -> (value (n,), empty (n,))``, media (n, 4) from ``preclassified``; points beyond the outer
voxel centres take the values there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..stages.field_stack import facing_layers
from ..transfer.channels import Channels
from ..volume import FloatArray
from .region import mixed_opacity, occupancy
from .setup import BoolArray, IntArray, Setup

Values = tuple[FloatArray, BoolArray]


def field_value(setup: Setup, p_index: FloatArray) -> Values:
    """Value of the layer's field, 0 where it is empty; of several channels NaN where they are."""
    value, empty = FIELDS[setup.stages["field"].name](setup, looked_at(setup, p_index))
    if empty.ndim == 1:
        return value, empty
    return np.where(empty, np.nan, value), np.asarray(empty.all(axis=1))


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


def looked_at(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Points (n, 3), for fields that do not interpolate between layers of 2-D textures moved to the nearest one."""
    if getattr(setup.stages["field"], "between", True):
        return p_index
    axis = setup.stages["field"].axis
    number = facing_layers(setup.layer.volume, setup.camera, setup.size_px)[0] if axis == "auto" else "xyz".index(axis)
    moved = p_index.copy()
    moved[:, number] = np.floor(p_index[:, number] + 0.5)
    return moved


def field_scalar(setup: Setup, p_index: FloatArray) -> Values:
    """Value (n,) of which gradients are taken: that of the samples where the field itself holds media.

    Of a mixture it is a weighted sum of its channels, each held where it is seen; of other functions the first channel.
    """
    if setup.stages["field"].name in ("preclassified", "preclassified_masked"):
        return linear(setup, looked_at(setup, p_index))
    if setup.stages["field"].name == "occupancy":
        return mixed_opacity(setup, p_index)
    value, empty = field_value(setup, p_index)
    if value.ndim == 1:
        return value, empty
    if not isinstance(setup.function, Channels):
        return np.where(np.isnan(value[:, 0]), 0.0, value[:, 0]), np.isnan(value[:, 0])
    total = np.zeros(len(value))
    for part, line in zip(setup.function.visible, setup.function.slopes, strict=True):
        here = value[:, setup.channels.index(setup.layer.volume.channel_index(part.channel))]
        total += line.weight * np.clip(np.where(np.isnan(here), line.nothing, here), line.low, line.high)
    return np.where(empty, 0.0, total), empty


def preclassified(setup: Setup, p_index: FloatArray) -> Values:
    """Source and extinction (n, 4) of the classified voxels, interpolated as ``linear`` does with values."""
    function, weighted = setup.function, setup.stages["field"].weighted or setup.function.associated
    if "classified" not in setup.once:
        rgb, extinction = function.source(setup.grid) if weighted else function(setup.grid)[0], function(setup.grid)[1]
        setup.once["classified"] = np.concatenate([rgb, extinction[..., None]], axis=-1)
    media = setup.once["classified"]
    empty = np.zeros(len(p_index), dtype=bool)
    if setup.full is None:
        value = trilinear(media, p_index)
    else:
        weight = trilinear(setup.full, p_index)
        empty = weight < 0.5
        value = trilinear(media * setup.full[..., None], p_index) / np.where(empty, 1.0, weight)[:, None]
    if not weighted:
        value[:, :3] *= value[:, 3:]
    return np.where(empty[:, None], 0.0, value), empty


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
    "occupancy": occupancy,
    "nearest_channels": nearest,
    "nearest_channels_masked": nearest,
    "linear_channels": linear,
    "linear_exact_channels": linear,
    "linear_channels_masked": linear,
    "stack": linear,
    "preclassified": preclassified,
    "preclassified_masked": preclassified,
}
