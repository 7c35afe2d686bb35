"""Shells: spheres round the eye, on which samples at equal distances lie in perspective.

Source: Engel and Ertl, "Interactive High-Quality Volume Rendering with Flexible Consumer Graphics Hardware", figure 19:
tessellated spheres, clipped to the frustum and to the box.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...volume import FloatArray
from .pieces import Pieces, pieces_between
from .polygons import Polygons
from .polyhedra import IntArray, Polyhedron, clipped

FULL_CIRCLE = -1.0  # cosine for directions of which nothing is known


@dataclass(frozen=True, eq=False)
class Shells:
    """Polygons of tessellated shells.

    Parameters
    ----------
    polygons
        The polygons (n of them), shell by shell, anticlockwise as seen from outside of the shell.
    shells
        Number (n,) of the shell that each is of.
    """

    polygons: Polygons
    shells: IntArray


def in_frustum(polyhedron: Polyhedron, eye: npt.ArrayLike, directions: npt.ArrayLike) -> Polyhedron:
    """Return the part that is seen between the directions (n, 3) of an image's corners, in order round it, from an eye (3,)."""
    point, ways = np.asarray(eye, dtype=float), np.asarray(directions, dtype=float)
    middle = ways.sum(axis=0)
    for here, there in zip(ways, np.roll(ways, -1, axis=0), strict=True):
        normal = np.cross(here, there)
        normal = normal * -np.sign(normal @ middle) / np.linalg.norm(normal)
        polyhedron = clipped(polyhedron, normal, float(normal @ point))
    return polyhedron


def shells_of(polyhedron: Polyhedron, eye: npt.ArrayLike, radii: npt.ArrayLike, tolerance: float) -> Shells:
    """Return the shells of radii (n,), rising and above 0, inside of a convex polyhedron: a box, or what the frustum leaves.

    Their corners lie on the spheres, and no point of them lies deeper inside than ``tolerance``, a length of the world.
    """
    point, lengths = np.asarray(eye, dtype=float), np.asarray(radii, dtype=float)
    directions = _towards(polyhedron, point, _sphere(_cells(lengths, tolerance)))
    normals, offsets = polyhedron.planes
    rise, reach = directions @ normals.T, offsets - normals @ point
    # Triangles that lie before a plane with all their corners need not be cut.
    meets = [np.flatnonzero((length * rise < reach).any(axis=1).all(axis=1)) for length in lengths]
    counts = np.array([len(numbers) for numbers in meets], dtype=np.int64)
    corners = [point + length * directions[numbers].reshape(-1, 3) for length, numbers in zip(lengths, meets, strict=True)]
    polygons = Polygons(np.concatenate([np.empty((0, 3)), *corners]), 3 * np.arange(counts.sum() + 1))
    for normal, offset in zip(normals, offsets, strict=True):
        polygons = polygons.cut(polygons.vertices @ normal - offset)
    filled = np.flatnonzero(polygons.counts)
    return Shells(polygons.taken(filled), np.repeat(np.arange(len(lengths)), counts)[filled])


def shell_pieces(polyhedron: Polyhedron, eye: npt.ArrayLike, radii: npt.ArrayLike) -> Pieces:
    """Return a convex cover of each part of a convex polyhedron between neighbouring radii (n + 1,), which rise.

    Each holds all that is at these distances from the eye, and more; neighbours overlap. It is cut by two planes across the
    mean direction of what is seen: behind, that which touches the far shell; in front, that through the circle on the near
    shell in the outermost direction. From within the polyhedron only the first cuts.
    """
    point, lengths = np.asarray(eye, dtype=float), np.asarray(radii, dtype=float)
    axis, least = _cone(polyhedron, point)
    height = float(axis @ point)
    nearest = lengths[:-1] if least >= 0 else lengths[1:]
    return pieces_between(polyhedron, axis, height + least * nearest, height + lengths[1:])


def _cone(polyhedron: Polyhedron, eye: FloatArray) -> tuple[FloatArray, float]:
    """Axis (3,) and least cosine of a cone from the eye round a polyhedron."""
    ways = polyhedron.vertices - eye
    lengths = np.linalg.norm(ways, axis=1)
    units = ways / np.where(lengths > 0, lengths, 1.0)[:, None]
    axis = units.sum(axis=0)
    length = float(np.linalg.norm(axis))
    if length <= 1e-6 * len(units):
        return np.array([0.0, 0.0, 1.0]), FULL_CIRCLE
    axis = axis / length
    # A cone of 90 degrees or more is not convex: points between its vertices may lie outside.
    least = float((units @ axis).min(initial=1.0))
    return axis, least if least > 0 else FULL_CIRCLE


def _cells(radii: FloatArray, tolerance: float) -> int:
    """Cells along the edge of each face of a cube whose directions make triangles that are nowhere deeper than the tolerance.

    A triangle on a sphere is deepest at the middle of the circle round it, here of half the diagonal of a cell; none is
    greater than in the middle of a face, where its sides span 90 degrees by their number.
    """
    depth = min(tolerance / float(radii.max(initial=tolerance)), 1.0)
    half_diagonal = math.sqrt(depth * (2 - depth))
    return max(2, math.ceil(math.sqrt(2) * math.pi / 4 / half_diagonal))


def _sphere(cells: int) -> FloatArray:
    """Triangles (t, 3, 3) of unit vectors, anticlockwise as seen from outside: a cube's faces, evenly divided by angles."""
    tangent = np.tan(np.linspace(-math.pi / 4, math.pi / 4, cells + 1))
    u, v = np.meshgrid(tangent, tangent, indexing="ij")
    face = np.stack([u, v, np.ones_like(u)], axis=-1)
    face /= np.linalg.norm(face, axis=-1, keepdims=True)
    a, b, c, d = (corner.reshape(-1, 1, 3) for corner in (face[:-1, :-1], face[1:, :-1], face[1:, 1:], face[:-1, 1:]))
    # By the shorter diagonal: towards the corners of the cube cells are rhombs.
    along = (a + c)[..., :1] * (a + c)[..., 1:2] >= 0
    halves = (np.where(along, (a, b, c), (a, b, d)), np.where(along, (a, c, d), (b, c, d)))
    one = np.concatenate([half[:, :, 0].swapaxes(0, 1) for half in halves])
    turns = [np.roll(one, turn, axis=2) for turn in range(3)]
    # Turned over along all axes the triangles look inwards, until two corners are exchanged.
    return np.concatenate([*turns, *(-turn[:, ::-1] for turn in turns)])


def _towards(polyhedron: Polyhedron, eye: FloatArray, triangles: FloatArray) -> FloatArray:
    """Those triangles of directions in which the polyhedron may be seen."""
    if polyhedron.empty:
        return triangles[:0]
    axis, least = _cone(polyhedron, eye)
    widest = float(np.linalg.norm(np.diff(triangles, axis=1, append=triangles[:, :1]), axis=2).max())
    angle = np.arccos((triangles @ axis).clip(-1, 1)).min(axis=1)
    return np.asarray(triangles[angle <= math.acos(least) + 2 * widest])
