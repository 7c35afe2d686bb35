"""Stripes tile their slices, and know their layers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from proxy_shapes import CUBE, VECTORS, areas, matrices, polyhedra

from airlight.rendering.proxies.planes import grid_planes, slices_of
from airlight.rendering.proxies.polyhedra import box
from airlight.rendering.proxies.stripes import Stripes, object_stripes, stripes_of


def check_layers(found: Stripes, across: np.ndarray, layers: np.ndarray) -> None:
    """Each vertex lies between the layers of its stripe, at its share of the way."""
    pairs = np.repeat(found.layers, found.polygons.counts, axis=0)
    heights = found.polygons.vertices @ across
    wanted = np.interp(heights, layers, np.arange(len(layers)))
    apart = pairs[:, 1] > pairs[:, 0]
    assert (np.diff(found.layers, axis=1) <= 1).all()
    np.testing.assert_allclose((pairs[:, 0] + found.shares)[apart], wanted[apart], atol=1e-9)
    alone = ~apart
    assert not found.shares[alone].any()
    beyond = np.where(pairs[alone, 0] == 0, layers[0] - heights[alone], heights[alone] - layers[-1])
    assert (beyond >= -1e-9).all()


@given(polyhedra(), VECTORS, VECTORS, st.integers(2, 9))
def test_stripes_tile_their_slice(polyhedron, normal, across, count):
    heights, depths = polyhedron.vertices @ across, polyhedron.vertices @ normal
    layers = np.linspace(heights.min(), heights.max(), count)[: max(2, count - 2)]
    offsets = np.sort(np.append(np.linspace(depths.min() - 0.1, depths.max() + 0.1, 7), depths))
    found, slices = stripes_of(polyhedron, normal, offsets, across, layers), slices_of(polyhedron, normal, offsets)
    tiled = np.bincount(found.slices, areas(found.polygons), len(slices))
    np.testing.assert_allclose(tiled, areas(slices), atol=1e-12)
    np.testing.assert_allclose(
        found.polygons.vertices @ normal, np.repeat(offsets[found.slices], found.polygons.counts), atol=1e-9
    )
    check_layers(found, across, layers)
    order = np.column_stack([found.slices, found.layers])
    assert [tuple(row) for row in order] == sorted(map(tuple, order))


def test_stripes_of_a_cube():
    """A diagonal slice of a cube between three layers: two oblongs, whose shares run from 0 to 1."""
    found = stripes_of(CUBE, (1, 0, 1), (1.0,), (0, 0, 1), (0.0, 0.5, 1.0))
    assert found.layers.tolist() == [[0, 1], [1, 2]]
    np.testing.assert_allclose(areas(found.polygons), np.sqrt(2) / 2)
    assert sorted(found.shares.tolist()) == [0] * 4 + [1] * 4
    within = stripes_of(CUBE, (0, 0, 1), (0.0, 0.25, 0.5, 1.0), (0, 0, 1), (0.0, 0.5, 1.0))
    assert within.layers.tolist() == [[0, 0], [0, 1], [0, 1], [1, 2]]
    np.testing.assert_allclose(within.shares.reshape(4, 4), np.repeat([[0], [0.5], [1], [1]], 4, axis=1))
    beyond = stripes_of(CUBE, (1, 0, 0), (0.5,), (0, 0, 1), (0.5,))
    assert beyond.layers.tolist() == [[0, 0], [0, 0]]
    assert areas(beyond.polygons).sum() == pytest.approx(1)


@given(matrices(), st.permutations(range(3)), st.sampled_from((0.0, 0.5)))
def test_object_stripes_are_stripes(matrix, axes, margin):
    size = (4, 3, 5)
    axis, stack_axis, _ = axes
    low, high = np.full(3, -margin), np.array(size) - 1 + margin
    at = np.array([0.25, 1.0, 1.5])
    found = object_stripes(low, high, matrix, axis, at, stack_axis, size[stack_axis])
    planes, stack = grid_planes(matrix, size, axis), grid_planes(matrix, size, stack_axis)
    offsets = planes.first + planes.spacing * at
    other = stripes_of(box(low, high, matrix), planes.normal, offsets, stack.normal, stack.offsets)
    np.testing.assert_array_equal(found.slices, other.slices)
    np.testing.assert_array_equal(found.layers, other.layers)
    np.testing.assert_allclose(areas(found.polygons), areas(other.polygons))
    check_layers(found, stack.normal, stack.offsets)
