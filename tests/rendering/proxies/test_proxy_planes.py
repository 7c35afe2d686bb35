"""Slices by scan-plane coherence, against closed forms and plain clipping."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from proxy_shapes import CUBE, VECTORS, area_vectors, areas, matrices, polyhedra, rising

from airlight.rendering.proxies.planes import grid_planes, slices_of
from airlight.rendering.proxies.polygons import Polygons
from airlight.rendering.proxies.polyhedra import clipped


def sorted_rows(points) -> np.ndarray:
    return np.array(sorted(np.round(points, 12).tolist()))


def test_a_cube_across_its_diagonal():
    found = slices_of(CUBE, (1, 1, 1), (-0.5, 0.5, 0.75, 1.25, 1.5, 2.25, 2.5, 3.5))
    assert found.counts.tolist() == [0, 3, 3, 6, 6, 3, 3, 0]
    np.testing.assert_allclose(found[1][np.argmax(found[1], axis=0)], 0.5 * np.eye(3))
    hexagon = sorted(set(itertools.permutations((1.0, 0.5, 0.0))))
    np.testing.assert_allclose(sorted_rows(found[4]), hexagon)
    across = [0, 0.25, 0.5625, 1.5625 - 3 * 0.0625, 0.75 * 2, 0.5625, 0.25, 0]
    np.testing.assert_allclose(areas(found), np.sqrt(3) / 2 * np.array(across))
    triangles, polygon = found.fans()
    assert np.bincount(polygon).tolist() == [0, 1, 1, 4, 4, 1, 1]
    fan = Polygons(found.vertices[triangles].reshape(-1, 3), np.arange(len(triangles) + 1) * 3)
    np.testing.assert_allclose(np.bincount(polygon, areas(fan), 8), areas(found))


def test_a_cube_along_an_axis_and_an_edge():
    squares = slices_of(CUBE, (0, 0, 2), (-1e-15, 0.2, 1.0, 2.0, 2.1))
    assert squares.counts.tolist() == [4, 4, 4, 4, 0]
    np.testing.assert_allclose(areas(squares)[:4], 1)
    np.testing.assert_allclose(squares[2][:, 2], 0.5)
    oblongs = slices_of(CUBE, (1, 1, 0), (0.0, 0.5, 1.0, 1.75, 2.0))
    assert oblongs.counts.tolist() == [4] * 5
    np.testing.assert_allclose(areas(oblongs), np.sqrt(2) * np.array([0, 0.5, 1, 0.25, 0]))


@given(polyhedra(), VECTORS)
def test_slices_are_those_of_plain_clipping(polyhedron, normal):
    heights = polyhedron.vertices @ normal
    offsets = np.linspace(heights.min(), heights.max(), 14)[1:-1]
    found, areas_along = slices_of(polyhedron, normal, offsets), None
    areas_along = area_vectors(found) @ normal / np.linalg.norm(normal)
    for number, offset in enumerate(offsets):
        half = clipped(polyhedron, normal, offset)
        lid = half.vertices[list(half.faces[-1])]
        spans = np.linalg.norm(lid[:, None] - found[number], axis=2)
        assert spans.min(axis=0).max() < 1e-9
        assert spans.min(axis=1).max() < 1e-9
        plain = Polygons(lid, np.array([0, len(lid)]))
        assert areas_along[number] == pytest.approx(areas(plain)[0], abs=1e-12)


@given(polyhedra(), VECTORS)
def test_planes_through_vertices_meet_what_they_meet(polyhedron, normal):
    offsets = rising(polyhedron, normal, 5)
    heights = polyhedron.vertices @ normal
    found = slices_of(polyhedron, normal, offsets)
    inside = (offsets > heights.min()) & (offsets < heights.max())
    assert (found.counts[inside] >= 3).all()
    outside = (offsets < heights.min() - 1e-6) | (offsets > heights.max() + 1e-6)
    assert not found.counts[outside].any()
    assert len(found.vertices) == found.counts.sum()
    np.testing.assert_allclose(found.vertices @ normal, np.repeat(offsets, found.counts), atol=1e-9)


def test_normals_that_are_nearly_an_axis():
    for tilt in 10.0 ** np.arange(-18, -6):
        found = slices_of(CUBE, (tilt, -tilt, 1), (0.25, 0.5))
        np.testing.assert_allclose(areas(found), 1, atol=1e-5)


@given(matrices())
def test_planes_of_a_grid(matrix):
    size = (3, 4, 5)
    for axis in range(3):
        planes = grid_planes(matrix, size, axis)
        assert planes.count == size[axis]
        assert np.linalg.norm(planes.normal) == pytest.approx(1)
        p_index = np.random.default_rng(axis).uniform(0, 2, (size[axis], 3))
        p_index[:, axis] = np.arange(size[axis])
        p_world = p_index @ matrix[:3, :3].T + matrix[:3, 3]
        np.testing.assert_allclose(p_world @ planes.normal, planes.offsets, atol=1e-9)
