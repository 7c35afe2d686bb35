"""Many plane polygons in two arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...volume import FloatArray
from .polyhedra import IntArray


@dataclass(frozen=True, eq=False)
class Polygons:
    """Convex polygons, one behind the other.

    Parameters
    ----------
    vertices
        Points (m, 3) in order round each polygon; neighbours may lie at one place.
    first
        Number (n + 1,) of the first vertex of each polygon, and of all; polygons may have none.
    """

    vertices: FloatArray
    first: IntArray

    def __len__(self) -> int:
        return len(self.first) - 1

    def __getitem__(self, polygon: int) -> FloatArray:
        """Vertices (k, 3) of a polygon."""
        return self.vertices[self.first[polygon] : self.first[polygon + 1]]

    @property
    def counts(self) -> IntArray:
        """Number (n,) of each polygon's vertices."""
        return np.diff(self.first)

    @property
    def follows(self) -> IntArray:
        """Number (m,) of the vertex that comes after each, round its polygon."""
        numbers = np.arange(1, len(self.vertices) + 1)
        filled = self.counts > 0
        numbers[self.first[1:][filled] - 1] = self.first[:-1][filled]
        return numbers

    def fans(self) -> tuple[IntArray, IntArray]:
        """Triangles (t, 3) of vertices' numbers, with the polygons' own turn, and the polygon (t,) that each is of."""
        counts = np.maximum(self.counts - 2, 0)
        polygon = np.repeat(np.arange(len(self)), counts)
        second = self.first[polygon] + 1 + ragged(counts)
        return np.stack([self.first[polygon], second, second + 1], axis=1), polygon

    def taken(self, numbers: IntArray) -> Polygons:
        """Polygons with these numbers (k,), in this order."""
        counts = self.counts[numbers]
        vertices = self.vertices[np.repeat(self.first[numbers], counts) + ragged(counts)]
        return Polygons(vertices, starts_of(counts))

    def cut(self, heights: FloatArray) -> Polygons:
        """Return the parts where heights, of which these (m,) are the vertices', are at most 0; nothing is left of some.

        Polygons that share an edge share what it is cut at, to the last bit.
        """
        follows, kept = self.follows, heights <= 0
        crossed = kept != kept[follows]
        counts = kept.astype(np.int64) + crossed
        start = np.repeat(np.arange(len(heights)), counts)
        end = np.where(kept[start] & (ragged(counts) == 0), start, follows[start])
        here, there = np.where(kept[start], (start, end), (end, start))
        below, above = heights[here], heights[there]
        share = np.where(here == there, 0.0, below / np.where(here == there, 1.0, below - above))
        vertices = np.take(self.vertices, here, axis=0)
        vertices += share[:, None] * (np.take(self.vertices, there, axis=0) - vertices)
        return Polygons(vertices, starts_of(counts)[self.first])


def starts_of(counts: IntArray) -> IntArray:
    """Where each of so many begins, and where all end (n + 1,)."""
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])


def ragged(counts: IntArray) -> IntArray:
    """``0, 1, ..., count - 1`` for each count, one behind the other."""
    starts = starts_of(counts)
    return np.arange(starts[-1]) - np.repeat(starts[:-1], counts)
