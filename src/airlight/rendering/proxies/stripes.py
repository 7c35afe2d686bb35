"""Stripes: slices cut where they pass from one pair of neighbouring texture layers to the next.

Source: Engel and Ertl, "Interactive High-Quality Volume Rendering with Flexible Consumer Graphics Hardware", figures 16 and 17:
one stack of two-dimensional textures serves slices of any direction, if each polygon needs two layers only; how far a point is
from the first layer to the second is linear on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...volume import FloatArray
from .coherence import settled
from .planes import slices_of
from .polygons import Polygons, ragged
from .polyhedra import IntArray, Polyhedron


@dataclass(frozen=True, eq=False)
class Stripes:
    """Polygons between two neighbouring layers each.

    Parameters
    ----------
    polygons
        The stripes (n of them), slice by slice, with rising layers.
    slices
        Number (n,) of the slice that each is of.
    layers
        Numbers (n, 2) of the layers before and behind it; one layer twice where it lies beyond the first or the last.
    shares
        Share (m,) of the second layer at each vertex, in [0, 1].
    """

    polygons: Polygons
    slices: IntArray
    layers: IntArray
    shares: FloatArray

    def __len__(self) -> int:
        return len(self.polygons)


def stripes_of(
    polyhedron: Polyhedron, normal: npt.ArrayLike, offsets: npt.ArrayLike, across: npt.ArrayLike, layers: npt.ArrayLike
) -> Stripes:
    """Return the stripes of the slices ``dot(normal, p) = offset`` between layers ``dot(across, p) = layer``, both rising.

    There is at least one layer. Coherence again: the edges of slices are cut by all layers between their ends at once.
    """
    sections, heights = slices_of(polyhedron, normal, offsets), np.asarray(layers, dtype=float)
    direction = np.asarray(across, dtype=float)
    points, slice_of = sections.vertices, np.repeat(np.arange(len(sections)), sections.counts)
    height = settled(points @ direction, heights, polyhedron.rounding(direction))
    # Band b lies between layers b - 1 and b. What lies on a layer is of the band above, but never above its slice.
    top = np.full(len(sections), -np.inf)
    np.maximum.at(top, slice_of, height)
    band = np.minimum(np.searchsorted(heights, height, "right"), np.searchsorted(heights, top)[slice_of])

    # Along an edge: its first vertex, then each crossing twice, as the end of one stripe and the start of the next.
    follows = sections.follows
    rise = np.take(band, follows) - band
    counts = 1 + 2 * np.abs(rise)
    edge, place = np.repeat(np.arange(len(points)), counts), ragged(counts)
    way = np.sign(rise)[edge]
    key = slice_of[edge] * (len(heights) + 1) + band[edge] + way * (place // 2)
    order = np.argsort(key, kind="stable")
    stripe, first, sizes = np.unique(key[order], return_index=True, return_counts=True)
    slices, bands = np.divmod(stripe, len(heights) + 1)

    edge, place, way = edge[order], place[order], way[order]
    layer = band[edge] + np.where(way > 0, (place - 1) // 2, -1 - (place - 1) // 2)
    start, end = np.take(height, edge), np.take(height, follows[edge])
    cut = np.where(place > 0, np.take(heights, layer, mode="clip"), start)
    share = (cut - start) / np.where(place > 0, end - start, 1.0)
    vertices = np.empty((len(edge), 3))
    for axis, values in enumerate(points.T):
        vertices[:, axis] = np.take(values, edge) * (1 - share) + np.take(values[follows], edge) * share
    polygons = Polygons(vertices, np.append(first, len(edge)))
    return Stripes(polygons, slices, _pairs(bands, len(heights)), _shares(cut, np.repeat(bands, sizes), heights))


def object_stripes(
    low: npt.ArrayLike,
    high: npt.ArrayLike,
    world_from_index: npt.ArrayLike,
    axis: int,
    positions: npt.ArrayLike,
    stack_axis: int,
    layers: int,
) -> Stripes:
    """Return the stripes of object-aligned slices of a box: rectangles of a product grid, found without cutting anything.

    Parameters
    ----------
    low, high
        Corners (3,) of the box in index space, (x, y, z).
    world_from_index
        Affine (4, 4) that puts it into the world.
    axis, positions
        Axis, 0 for x, that the slices cross, and where they do so (n,), in index coordinates.
    stack_axis, layers
        Another axis, and the number of its layers, which lie on whole numbers from 0.
    """
    matrix, ends = np.asarray(world_from_index, dtype=float), np.array([low, high], dtype=float)
    whole = np.arange(layers, dtype=float)
    cuts = np.concatenate([ends[:1, stack_axis], whole, ends[1:, stack_axis]]).clip(*ends[:, stack_axis])
    bands = np.flatnonzero(np.diff(cuts) > 0)
    near, far = cuts[bands], cuts[bands + 1]
    heights = np.stack([near, far, far, near], axis=-1)
    other = 3 - axis - stack_axis
    columns, sides = matrix[:3, :3].T, ends[[0, 0, 1, 1], other]
    rectangles = matrix[:3, 3] + heights[..., None] * columns[stack_axis] + sides[:, None] * columns[other]
    vertices = (np.asarray(positions, dtype=float)[:, None] * columns[axis])[:, None] + rectangles.reshape(-1, 3)
    count = len(vertices)
    return Stripes(
        Polygons(vertices.reshape(-1, 3), np.arange(count * len(bands) + 1) * 4),
        np.repeat(np.arange(count), len(bands)),
        np.tile(_pairs(bands, layers), (count, 1)),
        np.tile(_shares(heights.ravel(), np.repeat(bands, 4), whole), count),
    )


def _pairs(bands: IntArray, layers: int) -> IntArray:
    """Layers (n, 2) before and behind each band."""
    return np.stack([bands - 1, bands], axis=1).clip(0, layers - 1)


def _shares(heights: FloatArray, bands: IntArray, layers: FloatArray) -> FloatArray:
    """Share (m,) of the layer behind at heights (m,) in bands (m,); none where there is one layer only."""
    widths = np.concatenate([[np.inf], np.diff(layers), [np.inf]])
    return np.asarray((heights - np.take(layers, bands - 1, mode="clip")) / np.take(widths, bands)).clip(0, 1)
