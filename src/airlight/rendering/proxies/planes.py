"""Slices: sections of a convex polyhedron with parallel planes, and the planes of a grid's own slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...volume import FloatArray
from .coherence import Sweep
from .polygons import Polygons, starts_of
from .polyhedra import Polyhedron


@dataclass(frozen=True, eq=False)
class GridPlanes:
    """Planes ``dot(normal, p_world) = first + k * spacing`` on which the k-th samples of a grid along one axis lie.

    Parameters
    ----------
    normal
        Direction (3,) of the world, of length one, in which k rises.
    first
        Offset of the first plane, in world units.
    spacing
        Distance of neighbouring planes, in world units; with shear it is less than the step from sample to sample.
    count
        Number of planes.
    """

    normal: FloatArray
    first: float
    spacing: float
    count: int

    @property
    def offsets(self) -> FloatArray:
        """Offset (count,) of each plane."""
        return np.asarray(self.first + self.spacing * np.arange(self.count))


def grid_planes(world_from_index: npt.ArrayLike, size: Sequence[int], axis: int) -> GridPlanes:
    """Return the planes across an axis, 0 for x, of a grid of size (x, y, z) that an affine (4, 4) puts into the world."""
    matrix = np.asarray(world_from_index, dtype=float)
    # The index along the axis is dot(rise, p - origin).
    rise = np.linalg.inv(matrix[:3, :3])[axis]
    length = float(np.linalg.norm(rise))
    return GridPlanes(rise / length, float(rise @ matrix[:3, 3]) / length, 1 / length, int(size[axis]))


def slices_of(polyhedron: Polyhedron, normal: npt.ArrayLike, offsets: npt.ArrayLike) -> Polygons:
    """Return the sections with the planes ``dot(normal, p) = offset``, offsets (n,) rising, by scan-plane coherence.

    They run anticlockwise as seen from where the normal points. Planes that miss the polyhedron have no vertices; one that
    only touches it has a polygon without area, or the whole face.
    """
    sweep = Sweep(polyhedron, np.asarray(normal, dtype=float))
    heights = sweep.settled(offsets)
    counts, found = np.zeros(len(heights), dtype=np.int64), [np.empty((0, 3))]
    for span in sweep.spans:
        last = span is sweep.spans[-1]
        start, end = np.searchsorted(heights, span.low), np.searchsorted(heights, span.high, "right" if last else "left")
        counts[start:end] = len(span.starts)
        found.append(span.rings(heights[start:end]).reshape(-1, 3))
    return Polygons(np.concatenate(found), starts_of(counts))
