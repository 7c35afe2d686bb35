"""Convex polyhedra: what slices, stripes, shells and pieces are cut from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ...volume import FloatArray

IntArray = npt.NDArray[np.int64]

ROUNDING = 1024 * float(np.finfo(float).eps)  # of the greatest coordinate: nearer heights are one
SPIKE = 16  # times the length that faces move out by: sharper corners are cut off

# Corners are numbered x + 2y + 4z; loops run anticlockwise as seen from outside.
_BOX_FACES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex polyhedron, or none of it where it has no faces.

    Parameters
    ----------
    vertices
        Points (n, 3) of the world.
    faces
        The vertices' numbers round each face, anticlockwise as seen from outside; each face is plane.
    """

    vertices: FloatArray
    faces: tuple[tuple[int, ...], ...]

    @cached_property
    def ways(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Edges of each face as pairs of vertices, in the order of its loop; the face beside has the same pair turned round."""
        return tuple(_ways(face) for face in self.faces)

    @cached_property
    def edges(self) -> IntArray:
        """Vertices (m, 2) at the ends of each edge, the lesser number first."""
        return np.array(sorted({(min(way), max(way)) for face in self.ways for way in face}), dtype=np.int64).reshape(-1, 2)

    @cached_property
    def planes(self) -> tuple[FloatArray, FloatArray]:
        """Planes that bound it: unit normals (f, 3), which look out, and offsets (f,); faces without area have none."""
        loops = [self.vertices[list(face)] for face in self.faces]
        across = np.array([_area_vector(loop) for loop in loops]).reshape(-1, 3)
        lengths = np.linalg.norm(across, axis=1)
        kept = np.flatnonzero(lengths > 0)
        normals = across[kept] / lengths[kept, None]
        offsets = np.array([(loops[face] @ normal).max() for face, normal in zip(kept, normals, strict=True)])
        return normals, offsets

    @property
    def empty(self) -> bool:
        """Whether nothing is there."""
        return not self.faces

    def rounding(self, normal: FloatArray) -> float:
        """Greatest difference of heights ``dot(normal, p)`` that means nothing."""
        return float(ROUNDING * np.abs(self.vertices).max(initial=0.0) * np.abs(normal).sum())


def box(low: npt.ArrayLike, high: npt.ArrayLike, world_from_index: npt.ArrayLike) -> Polyhedron:
    """Return the box between two corners (3,) of index space, (x, y, z), in the world where an affine (4, 4) puts it."""
    matrix, ends = np.asarray(world_from_index, dtype=float), np.array([low, high], dtype=float)
    corners = np.array([[ends[x, 0], ends[y, 1], ends[z, 2]] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    faces = tuple(face[::-1] for face in _BOX_FACES) if mirrored else _BOX_FACES
    return Polyhedron(corners @ matrix[:3, :3].T + matrix[:3, 3], faces)


def clipped(polyhedron: Polyhedron, normal: npt.ArrayLike, offset: float) -> Polyhedron:
    """Return the part with ``dot(normal, p) <= offset``, face by face: plain clipping.

    What touches the plane, within rounding, is not cut there; a part without volume is empty.
    """
    direction = np.asarray(normal, dtype=float)
    beyond = polyhedron.vertices @ direction - offset
    beyond[np.abs(beyond) <= polyhedron.rounding(direction)] = 0
    if not (beyond > 0).any():
        return polyhedron
    points, made = list(polyhedron.vertices), dict[tuple[int, int], int]()

    def crossing(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in made:
            share = beyond[key[0]] / (beyond[key[0]] - beyond[key[1]])
            made[key] = len(points)
            points.append(points[key[0]] * (1 - share) + points[key[1]] * share)
        return made[key]

    faces: list[tuple[int, ...]] = []
    for face, ways in zip(polyhedron.faces, polyhedron.ways, strict=True):
        if beyond[list(face)].min() >= 0:
            continue
        loop: list[int] = []
        for a, b in ways:
            loop += [a] if beyond[a] <= 0 else []
            loop += [crossing(a, b)] if beyond[a] * beyond[b] < 0 else []
        faces.append(tuple(loop))
    return _used(points, _closed(faces))


def inflated(polyhedron: Polyhedron, by: float) -> Polyhedron:
    """Return the polyhedron with all faces moved out by a length of the world, at least 0.

    It holds all points that are no farther away than that. Corners so sharp that they would move out by more than 16 times the
    length, along an axis, are cut off.
    """
    if polyhedron.empty:
        return polyhedron
    low, high = polyhedron.vertices.min(axis=0), polyhedron.vertices.max(axis=0)
    found = box(low - SPIKE * by, high + SPIKE * by, np.eye(4))
    for normal, offset in zip(*polyhedron.planes, strict=True):
        found = clipped(found, normal, offset + by)
    return found


def _ways(face: Sequence[int]) -> tuple[tuple[int, int], ...]:
    return tuple(pairwise((*face, face[0])))


def _area_vector(loop: FloatArray) -> FloatArray:
    """Twice the area of a plane loop (n, 3), as a vector (3,) along its normal."""
    spokes = loop[1:] - loop[0]
    return np.asarray(np.cross(spokes[:-1], spokes[1:]).sum(axis=0))


def _closed(faces: list[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Faces, and the lid that closes them: it runs back along the edges that have a face on one side only."""
    ways = {way for face in faces for way in _ways(face)}
    follows: Mapping[int, int] = {b: a for a, b in ways if (b, a) not in ways}
    if not follows:
        return faces
    lid = [min(follows)]
    while (vertex := follows[lid[-1]]) != lid[0]:
        lid.append(vertex)
    return [*faces, tuple(lid)]


def _used(points: list[FloatArray], faces: list[tuple[int, ...]]) -> Polyhedron:
    """Polyhedron of these faces, of those points that they name."""
    named = sorted({vertex for face in faces for vertex in face})
    number = {vertex: place for place, vertex in enumerate(named)}
    vertices = np.array([points[vertex] for vertex in named]).reshape(-1, 3)
    return Polyhedron(vertices, tuple(tuple(number[vertex] for vertex in face) for face in faces))
