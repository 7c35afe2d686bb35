"""Values of a volume at points of the world."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from .errors import ValueRangeError
from .volume import FloatArray, Volume, domain_index, is_empty

WAYS = ("linear", "nearest")
ALLOWANCE = 1e-4
"""Part of a voxel by which points may lie outside: hits on the border, of a float32 depth, still have a value."""


def value_at(volume: Volume, p_world: npt.ArrayLike, channel: int | str, time: int, field: str) -> FloatArray:
    """Values (...) at points (..., 3) of the world, NaN outside of the domain and where it is empty."""
    if field not in WAYS:
        raise ValueRangeError("field", f"is {field!r}, must be one of {', '.join(WAYS)}")
    try:
        points = np.asarray(p_world, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.shape[-1:] != (3,):
        raise ValueRangeError("p_world", f"is {p_world!r}, must be (x, y, z), or points (..., 3)")
    matrix = volume.index_from_world
    p_index = points @ matrix[:3, :3].T + matrix[:3, 3]
    low, high = domain_index(volume.size, cells=field == "nearest")
    # NaN is not inside, and moved to where there are voxels.
    inside = np.asarray(((p_index >= low - ALLOWANCE) & (p_index <= high + ALLOWANCE)).all(axis=-1))
    last = np.array(volume.size) - 1
    p_index = np.clip(np.where(inside[..., None], p_index, 0.0), 0, last)
    grid = volume.grid(channel, time)
    low_index = np.rint(p_index).astype(int) if field == "nearest" else np.minimum(p_index.astype(int), np.maximum(last - 1, 0))
    share = p_index - low_index if field == "linear" else np.zeros_like(p_index)
    total, weight = np.zeros(inside.shape), np.zeros(inside.shape)
    for corner in itertools.product((0, 1), repeat=3):
        here = np.minimum(low_index + corner, last)
        part = np.where(corner, share, 1 - share).prod(axis=-1)
        values = np.asarray(grid[here[..., 2], here[..., 1], here[..., 0]])
        empty = is_empty(values, volume.no_data)
        part = part if empty is None else np.where(empty, 0.0, part)
        total += part * np.where(part > 0, values, 0).astype(np.float64)
        weight += part
    # As in pictures: the mean of the voxels that hold something, where these have half of the weight.
    known = inside & (weight >= 0.5)
    return np.where(known, total / np.where(known, weight, 1.0), np.nan)
