"""Blocks of voxels, in which rays that look for surfaces are sampled more densely: thin sheets are not stepped over.

Samples in blocks that hold no surface change nothing, so all blocks are taken here.
"""

from __future__ import annotations

import numpy as np

from ..volume import FloatArray

BLOCK_VOXELS = 4
LONGEST_VOXELS = 1.4  # of a piece of a ray's way through a block
ROUNDING = 1e-9  # of a block or a piece: where a ray is, it need not go
LONGER = 1e-3  # of a piece: so much longer than allowed is taken for rounding


def longest_piece(direction_index: FloatArray, step_world: FloatArray) -> FloatArray:
    """Length [world] that pieces of the ways of rays (n, 3) through blocks of voxels have at most."""
    return np.asarray(np.minimum(step_world, LONGEST_VOXELS / np.linalg.norm(direction_index, axis=1)))


def next_stop(
    origin_index: FloatArray,
    direction_index: FloatArray,
    t_enter: FloatArray,
    t_world: FloatArray,
    step_world: FloatArray | float = np.inf,
    voxels: int = BLOCK_VOXELS,
) -> FloatArray:
    """Next distances (n,) beyond ``t_world`` at which rays that look for surfaces are sampled.

    These cut the way through each block into the fewest equal pieces that are not longer than ``step_world``; that through the
    first block begins at ``t_enter``.
    """
    place = (origin_index + t_world[:, None] * direction_index) / voxels
    forward, along = direction_index > 0, direction_index != 0
    block = np.where(forward, np.floor(place + ROUNDING), np.ceil(place - ROUNDING) - 1)
    pace = np.where(along, direction_index, 1.0)
    far, near = ((block + ahead) * voxels - origin_index for ahead in (forward, ~forward))
    end = np.where(along, far / pace, np.inf).min(axis=1)
    begin = np.maximum(np.where(along, near / pace, -np.inf).max(axis=1), t_enter)
    length = np.maximum(end - begin, 1e-30)
    pieces = np.maximum(np.ceil(length / step_world - LONGER), 1.0)
    piece = np.floor((t_world - begin) / length * pieces + ROUNDING) + 1
    return np.asarray(np.where(piece < pieces, begin + length * piece / pieces, end))
