"""Corners of lines and points for cameras that look all round: what faces the image faces the eye."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import FloatArray

PIECE_RAD = np.pi / 18  # of a line: its width, which grows with the distance, is straight in between


def round_bands(
    ends: FloatArray, half_width: Callable[[FloatArray], FloatArray]
) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], FloatArray]:
    """Bands of lines, half a width longer at each end, in pieces.

    Parameters
    ----------
    ends
        Ends (n, 2, 3) of lines, from the eye on.
    half_width
        Half of the width at distances from the eye.

    Returns
    -------
    rows, corners
        For each piece the number of its line, and four corners (m, 4, 3): those of its beginning, and those of its end.
    """
    towards = directions(ends)
    across = np.cross(towards[:, 0], towards[:, 1])
    sine = np.linalg.norm(across, axis=1)
    # A line that is seen end on, or passes the eye, has no side of its own.
    across = np.where(sine[:, None] > 1e-9, across / np.maximum(sine, 1e-30)[:, None], sideways(towards[:, 0]))
    angle = np.arctan2(sine, (towards[:, 0] * towards[:, 1]).sum(axis=1))
    pieces = np.maximum(1, np.ceil(angle / PIECE_RAD)).astype(np.int64)
    rows = np.repeat(np.arange(len(ends)), pieces)
    number = np.arange(len(rows)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    whole, across, away = ends[rows], across[rows], np.linalg.norm(ends, axis=2)[rows]
    corners = np.empty((len(rows), 4, 3))
    for end in (0, 1):
        part = (number + end) / pieces[rows]
        # Where the line is seen at this part of its angle.
        begun, left = away[:, 0] * np.sin(part * angle[rows]), away[:, 1] * np.sin((1 - part) * angle[rows])
        share = np.where(begun + left > 0, begun / np.maximum(begun + left, 1e-300), part)[:, None]
        middle = whole[:, 0] + share * (whole[:, 1] - whole[:, 0])
        half = half_width(np.linalg.norm(middle, axis=1))[:, None]
        is_last = (number + end == end * pieces[rows])[:, None]
        along = np.cross(across, directions(middle)) * (2 * end - 1) * is_last
        for side in (0, 1):
            corners[:, 2 * end + side] = middle + half * (along + (2 * side - 1) * across)
    return rows, corners


def round_disks(middles: FloatArray, half_width: Callable[[FloatArray], FloatArray], count: int) -> FloatArray:
    """Corners (n, count, 3) of regular polygons round middles (n, 3), from the eye on, which they face."""
    towards = directions(middles)
    right = sideways(towards)
    above = np.cross(towards, right)
    angle = 2 * np.pi * np.arange(count)[:, None] / count
    half = half_width(np.linalg.norm(middles, axis=1))[:, None, None]
    return np.asarray(middles[:, None] + half * (np.cos(angle) * right[:, None] + np.sin(angle) * above[:, None]))


def directions(ways: FloatArray) -> FloatArray:
    """Unit vectors (..., 3) of ways; none for what has no length."""
    return np.asarray(ways / np.maximum(np.linalg.norm(ways, axis=-1, keepdims=True), 1e-300))


def sideways(towards: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) at right angles to others: across the axis of the world that they are the least along."""
    axis = np.eye(3)[np.abs(towards).argmin(axis=1)]
    return directions(np.cross(towards, axis))
