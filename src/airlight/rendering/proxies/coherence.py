"""Scan-plane coherence: a plane that moves through a convex polyhedron, whose section slides along edges.

Source: Kreylos, "Interactive Volume Rendering Using 3D Texture-Mapping Hardware", how to generate stacks of oblique slices
efficiently. Between the heights of two vertices the section has the same corners, one on each edge that it crosses, in the same
order; so all sections between them are made at once, and nothing is clipped.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...volume import FloatArray
from .polyhedra import IntArray, Polyhedron


@dataclass(frozen=True, eq=False)
class Span:
    """Heights between which the section has the same corners.

    Parameters
    ----------
    low, high
        The heights.
    starts, ends
        Lower and upper points (m, 3) of the edges that it crosses, anticlockwise as seen from where the normal points.
    start_heights, end_heights
        Their heights (m,).
    """

    low: float
    high: float
    starts: FloatArray
    ends: FloatArray
    start_heights: FloatArray
    end_heights: FloatArray

    def rings(self, offsets: FloatArray) -> FloatArray:
        """Sections (k, m, 3) at heights (k,) within the span; at an edge's end they have that vertex itself."""
        share = ((offsets[:, None] - self.start_heights) / (self.end_heights - self.start_heights))[:, :, None]
        return self.starts * (1 - share) + self.ends * share


@dataclass(frozen=True, eq=False)
class Sweep:
    """The way of a plane ``dot(normal, p) = height`` through a convex polyhedron.

    Parameters
    ----------
    polyhedron
        What it moves through.
    normal
        Direction (3,) of its way, of any length.
    """

    polyhedron: Polyhedron
    normal: FloatArray

    @cached_property
    def rounding(self) -> float:
        """Heights that differ by no more are one."""
        return self.polyhedron.rounding(self.normal)

    @cached_property
    def level(self) -> tuple[IntArray, FloatArray]:
        """Number (n,) of each vertex's level, from the lowest, and the levels' heights (l,)."""
        heights = self.polyhedron.vertices @ self.normal
        order = np.argsort(heights)
        rising = heights[order]
        new = np.diff(rising, prepend=-np.inf) > self.rounding
        number = np.empty(len(heights), dtype=np.int64)
        number[order] = np.cumsum(new) - 1
        return number, rising[new]

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """Spans from level to level, upwards."""
        return tuple(self._span(below) for below in range(len(self.level[1]) - 1))

    def settled(self, offsets: npt.ArrayLike) -> FloatArray:
        """Heights (k,) with those that are a level's, but for rounding, put there."""
        return settled(np.asarray(offsets, dtype=float), self.level[1], self.rounding)

    def _span(self, below: int) -> Span:
        """Span above a level.

        A face that the plane crosses has one edge that runs down through it and one that runs up; the section goes from the
        first to the second, which runs down round the next face.
        """
        number, heights = self.level
        upper = (number > below).tolist()
        follows = dict[tuple[int, int], tuple[int, int]]()
        for ways in self.polyhedron.ways:
            crossing = [way for way in ways if upper[way[0]] != upper[way[1]]]
            if crossing:
                down, up = crossing if upper[crossing[0][0]] else crossing[::-1]
                follows[down] = up[::-1]
        ring = [next(iter(follows))]
        while (way := follows[ring[-1]]) != ring[0]:
            ring.append(way)
        ends, starts = np.array(ring, dtype=np.int64).T
        points, levels = self.polyhedron.vertices, heights[number]
        return Span(heights[below], heights[below + 1], points[starts], points[ends], levels[starts], levels[ends])


def settled(heights: FloatArray, levels: FloatArray, rounding: float) -> FloatArray:
    """Heights (k,) with those that are no farther than ``rounding`` from one of the levels (l,), which rise, put there."""
    if not len(levels):
        return heights
    above = np.searchsorted(levels, heights).clip(max=len(levels) - 1)
    for nearest in (levels[np.maximum(above - 1, 0)], levels[above]):
        heights = np.where(np.abs(heights - nearest) <= rounding, nearest, heights)
    return heights
