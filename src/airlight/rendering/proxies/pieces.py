"""Pieces of a convex polyhedron between parallel planes, as closed surfaces: proxies of whole slabs.

A ray that meets a piece crosses its surface once from outside and once from inside. So a rasteriser that draws only the
triangles that face the eye, or only those that face away, draws each pixel of a piece exactly once, also where no slice is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...volume import FloatArray
from .coherence import Span, Sweep
from .polyhedra import IntArray, Polyhedron


@dataclass(frozen=True, eq=False)
class Pieces:
    """Closed surfaces of convex pieces.

    Parameters
    ----------
    corners
        Corners (t, 3, 3) of triangles: of each triangle, of each corner, x, y and z; anticlockwise as seen from outside.
    first
        Number (n + 1,) of the first triangle of each piece, and of all; pieces may have none.
    """

    corners: FloatArray
    first: IntArray

    def __len__(self) -> int:
        return len(self.first) - 1

    def __getitem__(self, piece: int) -> FloatArray:
        """Triangles (m, 3, 3) of a piece."""
        return self.corners[self.first[piece] : self.first[piece + 1]]


def pieces_of(polyhedron: Polyhedron, normal: npt.ArrayLike, offsets: npt.ArrayLike) -> Pieces:
    """Return the pieces between neighbouring planes ``dot(normal, p) = offset``, offsets (n + 1,) rising.

    What lies before the first plane and behind the last belongs to no piece; infinite offsets leave nothing out.
    """
    planes = np.asarray(offsets, dtype=float)
    return pieces_between(polyhedron, normal, planes[:-1], planes[1:])


def pieces_between(polyhedron: Polyhedron, normal: npt.ArrayLike, low: npt.ArrayLike, high: npt.ArrayLike) -> Pieces:
    """Return the pieces with ``low <= dot(normal, p) <= high`` (n,) each; they may overlap.

    Neighbouring triangles share their corners to the last bit: no pixel is left out between them, and none is drawn twice.
    """
    sweep = Sweep(polyhedron, np.asarray(normal, dtype=float))
    lows, highs = sweep.settled(low), sweep.settled(high)
    if sweep.spans:
        ends = sweep.spans[0].low, sweep.spans[-1].high
        lows, highs = lows.clip(*ends), highs.clip(*ends)
    found = [_in_span(span, lows, highs) for span in sweep.spans]
    piece = np.concatenate([numbers for numbers, _ in found] or [np.empty(0, dtype=np.int64)])
    corners = np.concatenate([triangles for _, triangles in found] or [np.empty((0, 3, 3))])
    counts = np.bincount(piece, minlength=len(lows))
    return Pieces(corners[np.argsort(piece, kind="stable")], np.concatenate([[0], np.cumsum(counts)]))


def _in_span(span: Span, low: FloatArray, high: FloatArray) -> tuple[IntArray, FloatArray]:
    """Triangles of all pieces in a span: each one's piece (t,), and corners (t, 3, 3)."""
    bottom, top = np.maximum(low, span.low), np.minimum(high, span.high)
    pieces = np.flatnonzero(bottom < top)
    bottom, top = bottom[pieces], top[pieces]
    points = np.concatenate([span.rings(bottom), span.rings(top)], axis=1)
    sides, lids = _triangles(len(span.starts))
    corners = points[:, np.concatenate([sides, *lids])]
    first, second, third = corners.transpose(2, 0, 1, 3)
    kept = (first != second).any(axis=2) & (second != third).any(axis=2) & (third != first).any(axis=2)
    # Where a piece goes on in the next span it is open.
    lid = len(lids[0])
    kept[:, len(sides) : len(sides) + lid] &= (bottom == low[pieces])[:, None]
    kept[:, len(sides) + lid :] &= (top == high[pieces])[:, None]
    return np.broadcast_to(pieces[:, None], kept.shape)[kept], corners[kept]


def _triangles(corners: int) -> tuple[IntArray, tuple[IntArray, IntArray]]:
    """Corners' numbers of the sides (2m, 3) between two rings of m corners, and of the lids (m - 2, 3) below and above."""
    here = np.arange(corners)
    there = np.roll(here, -1)
    above, beside = here + corners, there + corners
    sides = np.concatenate([np.stack([here, there, beside], axis=1), np.stack([here, beside, above], axis=1)])
    zero = np.zeros(corners - 2, dtype=np.int64)
    below = np.stack([zero, here[2:], here[1:-1]], axis=1)
    return sides, (below, np.stack([zero, here[1:-1], here[2:]], axis=1) + corners)
