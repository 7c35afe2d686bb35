"""Pictures of all directions: equirectangular ones, their resolution, and the octahedral ones that the device reads.

Directions are those of the world, up is +z. An equirectangular picture ``(h, w, 3)`` has the zenith in its first row and +y,
where the view ``front`` looks, in its middle column; +x lies a quarter to the right, as one sees it from inside. Pixels are
areas: the first column begins at -y.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import FloatArray

ROWS_AT_ONCE = 16  # of a picture: what is computed of them stays in a processor's cache


def pixel_directions(rows: int, columns: int) -> FloatArray:
    """Directions (rows, columns, 3) through the middles of the pixels of an equirectangular picture."""
    polar = np.pi * (np.arange(rows) + 0.5) / rows
    azimuth = 2 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5)
    around = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=-1)
    flat = np.sin(polar)[:, None, None] * around
    return np.concatenate([flat, np.broadcast_to(np.cos(polar)[:, None, None], (rows, columns, 1))], axis=-1)


def averaged(radiance: Callable[[FloatArray], FloatArray], rows: int, per_side: int = 2) -> FloatArray:
    """Picture (rows, 2 rows, c) of a function of directions: means over ``per_side`` x ``per_side`` in each pixel."""
    directions = pixel_directions(rows * per_side, 2 * rows * per_side)
    parts = []
    for first in range(0, len(directions), ROWS_AT_ONCE * per_side):
        fine = radiance(directions[first : first + ROWS_AT_ONCE * per_side])
        parts.append(fine.reshape(-1, per_side, 2 * rows, per_side, fine.shape[-1]).mean(axis=(1, 3)))
    return np.concatenate(parts)


def places(directions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Column and row of directions (..., 3) of any length, as shares [0, 1] of an equirectangular picture."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.arctan2(x, y) / (2 * np.pi) + 0.5, np.arctan2(np.hypot(x, y), z) / np.pi


def row_areas(rows: int, columns: int) -> FloatArray:
    """Solid angle (rows,) of a pixel of each row; those of all pixels make 4 pi."""
    return np.asarray(-np.diff(np.cos(np.pi * np.arange(rows + 1) / rows)) * 2 * np.pi / columns)


def mean_of(picture: FloatArray) -> FloatArray:
    """Mean (3,) of an equirectangular picture over the sphere."""
    weights = row_areas(*picture.shape[:2])
    return np.asarray((picture.mean(axis=1) * weights[:, None]).sum(axis=0) / weights.sum())


def resized(picture: FloatArray, rows: int, columns: int) -> FloatArray:
    """Picture of another size: the mean over each new pixel where there are fewer, interpolated where there are more."""
    height, width = picture.shape[:2]
    by_area = np.cos(np.pi * np.linspace(0, 1, height + 1))[::-1]
    if rows < height:
        picture = _means(picture[::-1], by_area, np.cos(np.pi * np.linspace(0, 1, rows + 1))[::-1])[::-1]
    if columns < width:
        even = np.linspace(0, 1, width + 1), np.linspace(0, 1, columns + 1)
        picture = np.moveaxis(_means(np.moveaxis(picture, 1, 0), *even), 0, 1)
    if picture.shape[:2] == (rows, columns):
        return picture
    return linear_at(picture, pixel_directions(rows, columns))


def _means(values: FloatArray, edges: FloatArray, new_edges: FloatArray) -> FloatArray:
    """Means over new intervals of what is constant between edges, along the first axis."""
    steps = np.diff(edges).reshape(-1, *[1] * (values.ndim - 1))
    sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values * steps, axis=0)])
    at = np.clip(np.searchsorted(edges, new_edges, side="right") - 1, 0, len(edges) - 2)
    share = ((new_edges - edges[at]) / np.diff(edges)[at]).reshape(-1, *[1] * (values.ndim - 1))
    found = sums[at] + share * (sums[at + 1] - sums[at])
    return np.asarray(np.diff(found, axis=0) / np.diff(new_edges).reshape(-1, *[1] * (values.ndim - 1)))


def linear_at(picture: FloatArray, directions: FloatArray) -> FloatArray:
    """Picture at directions (..., 3), bilinear between the middles of pixels; columns go round, rows end at the poles."""
    height, width = picture.shape[:2]
    u, v = places(directions)
    column, row = u * width - 0.5, np.clip(v * height - 0.5, 0, height - 1)
    left, top = np.floor(column).astype(np.int64), np.minimum(row.astype(np.int64), max(height - 2, 0))
    a, b = (column - left)[..., None], (row - top)[..., None]
    below, right = np.minimum(top + 1, height - 1), (left + 1) % width
    left %= width
    upper = picture[top, left] * (1 - a) + picture[top, right] * a
    lower = picture[below, left] * (1 - a) + picture[below, right] * a
    return np.asarray(upper * (1 - b) + lower * b)


def cubic_at(rings: FloatArray, directions: FloatArray) -> FloatArray:
    """What rings of directions from pole to pole ``(n + 1, w, 3)``, w even, have in between: Catmull-Rom in both angles."""
    n, width = rings.shape[0] - 1, rings.shape[1]
    u, v = places(directions)
    column, row = u * width - 0.5, v * n
    left, top = np.floor(column).astype(np.int64), np.clip(np.floor(row).astype(np.int64), 0, n - 1)
    # Beyond a pole the next ring is the same one, half a turn on.
    turned = np.roll(rings, width // 2, axis=1)
    beyond = np.concatenate([turned[1:2], rings, turned[n - 1 : n]]).reshape(-1, rings.shape[2])
    across = _catmull_rom(column - left)
    columns = [(left + i - 1) % width for i in range(4)]
    found = np.zeros((*directions.shape[:-1], rings.shape[2]))
    for j, down in enumerate(_catmull_rom(row - top)):
        line = np.zeros_like(found)
        for weight, at in zip(across, columns, strict=True):
            line += weight[..., None] * np.take(beyond, (top + j) * width + at, axis=0)
        found += down[..., None] * line
    return found


def _catmull_rom(t: FloatArray) -> tuple[FloatArray, ...]:
    """Weights of four neighbours, of which the second and third are at 0 and 1."""
    return (
        t * (t * (1 - 0.5 * t) - 0.5),
        1 + t * t * (1.5 * t - 2.5),
        t * (0.5 + t * (2 - 1.5 * t)),
        t * t * (0.5 * t - 0.5),
    )


def octahedral_directions(n: int) -> FloatArray:
    """Directions (n, n, 3) of the texels of an octahedral map, whose outermost ones lie on the edge of the square.

    The octahedron ``|x| + |y| + |z| = 1`` is unfolded round +z: the edge folds onto itself, so that the two texels of an edge
    that are one direction are equal, and interpolation has no seam (Engelhardt and Dachsbacher 2008, Octahedron environment
    maps).
    """
    q = np.linspace(-1, 1, n)
    x, y = np.meshgrid(q, q)
    z = 1 - np.abs(x) - np.abs(y)
    low = z < 0
    folded = np.where(low, np.copysign(1 - np.abs(y), x), x), np.where(low, np.copysign(1 - np.abs(x), y), y)
    directions = np.stack([*folded, z], axis=-1)
    return np.asarray(directions / np.linalg.norm(directions, axis=-1, keepdims=True))
