"""Convex polyhedra: boxes, clipping, faces moved out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from proxy_shapes import CUBE, VECTORS, matrices, polyhedra, triangles, volume

from airlight.rendering.proxies.polyhedra import Polyhedron, box, clipped, inflated


def is_sound(polyhedron: Polyhedron) -> bool:
    """Whether Euler's formula holds, each edge has two faces, and all lies behind the faces' planes."""
    ways = [way for face in polyhedron.ways for way in face]
    normals, offsets = polyhedron.planes
    return (
        len(polyhedron.vertices) - len(polyhedron.edges) + len(polyhedron.faces) == 2
        and len(set(ways)) == len(ways) == 2 * len(polyhedron.edges)
        and bool((polyhedron.vertices @ normals.T <= offsets + 1e-9).all())
    )


@given(matrices())
def test_sheared_boxes_look_outwards(matrix):
    found = box((-0.5, 0, 1), (2, 3, 4), matrix)
    assert is_sound(found)
    assert len(found.edges) == 12
    assert volume(triangles(found)) == pytest.approx(2.5 * 3 * 3 * abs(np.linalg.det(matrix)))


@given(polyhedra(), VECTORS, st.floats(-0.1, 1.1))
def test_two_halves_are_the_whole(polyhedron, normal, share):
    assert is_sound(polyhedron)
    heights = polyhedron.vertices @ normal
    offset = heights.min() + share * np.ptp(heights)
    halves = clipped(polyhedron, normal, offset), clipped(polyhedron, -normal, -offset)
    assert sum(volume(triangles(half)) for half in halves) == pytest.approx(volume(triangles(polyhedron)))
    for half, sign in zip(halves, (1, -1), strict=True):
        assert half.empty or is_sound(half)
        assert (sign * (half.vertices @ normal - offset) <= 1e-9).all()


def test_what_a_plane_touches_is_not_cut():
    assert clipped(CUBE, (0, 0, 1), 1.0) is CUBE
    assert clipped(CUBE, (1, 1, 1), 3 + 1e-15) is CUBE
    assert clipped(CUBE, (0, 0, 1), 0.0).empty
    assert clipped(CUBE, (1, 1, 0), -2.0).empty
    assert clipped(clipped(CUBE, (0, 0, 1), -1), (1, 0, 0), 0.5).empty
    diagonal = clipped(CUBE, (1, 1, 0), 1.0)
    assert len(diagonal.vertices) == 6
    assert is_sound(diagonal)


def test_faces_move_out():
    grown = inflated(CUBE, 0.25)
    assert len(grown.vertices) == 8
    np.testing.assert_allclose(grown.vertices.min(axis=0), -0.25)
    np.testing.assert_allclose(grown.vertices.max(axis=0), 1.25)
    assert inflated(clipped(CUBE, (0, 0, 1), -1), 0.1).empty


@given(polyhedra(), st.sampled_from((1e-6, 0.01, 0.5)))
def test_grown_polyhedra_hold_all_that_is_near(polyhedron, by):
    grown = inflated(polyhedron, by)
    assert is_sound(grown)
    normals, offsets = polyhedron.planes
    grown_normals, grown_offsets = grown.planes
    assert (grown.vertices @ normals.T <= offsets + by + 1e-9).all()
    farthest = (polyhedron.vertices @ grown_normals.T).max(axis=0) + by
    assert (farthest <= grown_offsets + 1e-9).all()
