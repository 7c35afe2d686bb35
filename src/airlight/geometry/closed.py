"""Meshes that enclose something: which are closed, and which way their faces look."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..volume import FloatArray

if TYPE_CHECKING:
    from .mesh import Mesh

PLACES = 1 << 19  # along the longest side of a mesh: nearer vertices are at one place


def open_edges(vertices: FloatArray, faces: npt.NDArray[np.uint32]) -> int:
    """How many edges of faces have no other that runs back along them; vertices at one place, but for rounding, count as one.

    None are left of surfaces that enclose something: they have no border, whatever the number of their parts.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    grid = np.round((vertices - low) * (PLACES / max(float((high - low).max()), 1e-300))).astype(np.int64)
    _, place = np.unique((grid[:, 0] * (2 * PLACES) + grid[:, 1]) * (2 * PLACES) + grid[:, 2], return_inverse=True)
    ends = place.reshape(-1)[faces.astype(np.int64)]
    start, end = ends.ravel(), ends[:, [1, 2, 0]].ravel()
    # Edges are counted by the sum of their ways: forth is one, back is minus one.
    first, last = np.minimum(start, end), np.maximum(start, end)
    _, edge = np.unique(first * len(vertices) + last, return_inverse=True)
    ways = np.bincount(edge.reshape(-1), np.sign(end - start))
    return int(np.abs(ways).sum())


def facing(mesh: Mesh) -> int:
    """Return 1 where the faces of a closed mesh look out in its own space, -1 where they look in.

    Raises
    ------
    DataError
        For meshes that are open, whose faces do not all look out or all in, or that enclose nothing.
    """
    count = open_edges(mesh.vertices, mesh.faces)
    if count:
        what = f"has {count:,} edges without a neighbour that runs back along them: it is open, or some faces are turned over"
        raise DataError("clip.mesh", what, "close it, e.g. with trimesh.repair, so that it has an inside")
    a, b, c = (mesh.vertices - mesh.vertices.mean(axis=0))[mesh.faces].swapaxes(0, 1)
    volume = float((a * np.cross(b, c)).sum())
    if abs(volume) <= 1e-12 * float(np.abs(a * np.cross(b, c)).sum()) or volume == 0:
        raise DataError("clip.mesh", "encloses nothing", "use a mesh that has an inside")
    return 1 if volume > 0 else -1
