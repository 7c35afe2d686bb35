"""Meshes for the gallery: surfaces of equal value of a volume, by naive surface nets (Gibson 1998).

Each cell of eight samples that the surface passes gets a vertex, the mean of where it passes the cell's edges; each edge of the
grid that it passes joins the vertices of the four cells around.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

import airlight as al


def surface_mesh(samples: np.ndarray[Any, Any], value: float) -> al.Mesh:
    """Mesh, in index coordinates, of the surface on which samples (z, y, x) pass a value; it must not touch the grid."""
    rest = samples.astype(np.float64) - value
    above = rest > 0
    count = np.zeros([n - 1 for n in above.shape])
    total = np.zeros((*count.shape, 3))
    for axis, offsets in product(range(3), product((0, 1), repeat=2)):
        low = [slice(None, -1)] * 3
        for other, offset in zip([a for a in range(3) if a != axis], offsets, strict=True):
            low[other] = slice(offset, offset - 1 or None)
        high = list(low)
        high[axis] = slice(1, None)
        a, b = rest[tuple(low)], rest[tuple(high)]
        passes = (a > 0) != (b > 0)
        share = np.where(passes, a / np.where(passes, a - b, 1.0), 0.0)
        place = np.zeros(3)
        place[[other for other in range(3) if other != axis]] = offsets
        total += passes[..., None] * (place + share[..., None] * np.eye(3)[axis])
        count += passes
    cells = np.argwhere(count > 0)
    number = np.full(count.shape, -1)
    number[tuple(cells.T)] = np.arange(len(cells))
    middles = cells + (total / np.maximum(count, 1)[..., None])[tuple(cells.T)]
    quads = []
    for axis in range(3):
        along = [slice(1, -1)] * 3
        along[axis] = slice(None, -1)
        after = list(along)
        after[axis] = slice(1, None)
        edges = np.argwhere(above[tuple(along)] != above[tuple(after)]) + [0 if a == axis else 1 for a in range(3)]
        one, other = (np.eye(3, dtype=int)[(axis + k) % 3] for k in (1, 2))
        ring = np.stack([number[tuple((edges - way).T)] for way in (0, one, one + other, other)], axis=1)
        quads.append(np.where(above[tuple(edges.T)][:, None], ring, ring[:, ::-1]))  # all face the same side
    corners = np.concatenate(quads)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    return al.Mesh(middles[:, ::-1], faces)


def shift(way: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Affine (4, 4) that moves points."""
    matrix = np.eye(4)
    matrix[:3, 3] = way
    return matrix
