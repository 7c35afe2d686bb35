"""Pieces between planes: closed, as large as plain clipping says, and covered exactly once."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from proxy_shapes import CUBE, EVERYTHING, VECTORS, closed, crossings, drawn, polyhedra, rising, triangles, volume

from airlight.rendering.proxies.pieces import pieces_between, pieces_of
from airlight.rendering.proxies.polyhedra import box, clipped


@given(polyhedra(), VECTORS)
def test_pieces_are_those_of_plain_clipping(polyhedron, normal):
    offsets = rising(polyhedron, normal, 6)
    found = pieces_of(polyhedron, normal, offsets)
    assert len(found) == len(offsets) - 1
    for number, (low, high) in enumerate(pairwise(offsets)):
        plain = clipped(clipped(polyhedron, normal, high), -normal, -low)
        assert volume(found[number]) == pytest.approx(volume(triangles(plain)), abs=1e-9)
        assert closed(found[number])
        assert not len(found[number]) or volume(found[number]) > 0


@given(polyhedra(), VECTORS, st.integers(0, 10**6))
def test_each_ray_enters_once_and_leaves_once(polyhedron, normal, seed):
    rng = np.random.default_rng(seed)
    middle, size = polyhedron.vertices.mean(axis=0), np.ptp(polyhedron.vertices, axis=0).max()
    normals, limits = polyhedron.planes
    heights = polyhedron.vertices @ normal
    offsets = np.linspace(heights.min() - 0.1, heights.max() + 0.1, 6)
    found = pieces_of(polyhedron, normal, offsets)
    starts = middle + rng.normal(0, size, (60, 3))
    ways = middle + rng.normal(0, 0.3 * size, (60, 3)) - starts
    ahead, reach = ways @ normals.T, limits - starts @ normals.T
    near, far = np.where(ahead < 0, reach / ahead, -np.inf).max(axis=1), np.where(ahead > 0, reach / ahead, np.inf).min(axis=1)
    for number in range(len(found)):
        cuts = np.sort((offsets[number : number + 2, None] - starts @ normal) / (ways @ normal), axis=0)
        length = np.minimum(far, cuts[1]) - np.maximum(near, cuts[0])
        entered, left = crossings(found[number], starts, ways)
        # Rays that only graze a piece are a matter of rounding.
        clear = np.abs(length) > 1e-6
        np.testing.assert_array_equal(entered[clear], length[clear] > 0)
        np.testing.assert_array_equal(left[clear], length[clear] > 0)


@given(polyhedra(), VECTORS, VECTORS, st.sampled_from((0.0, 0.3)))
@settings(max_examples=40)
def test_a_rasteriser_draws_each_pixel_once(polyhedron, normal, view, perspective):
    """Also where corners are rounded to float32, and to parts of a pixel."""
    view = view / np.linalg.norm(view)
    right = np.cross(view, np.roll(view, 1) + np.array([0.1, 0.2, 0.3]))
    right /= np.linalg.norm(right)
    local = polyhedron.vertices - polyhedron.vertices.mean(axis=0)
    scale, heights = np.linalg.norm(local, axis=1).max(), polyhedron.vertices @ normal
    found = pieces_of(polyhedron, normal, np.linspace(heights.min(), heights.max(), 5))
    seen = ((found.corners - polyhedron.vertices.mean(axis=0)) / scale) @ np.stack([right, np.cross(view, right), view], axis=1)
    flat = 16 + 14 * seen[..., :2] / (1 + perspective * seen[..., 2:])
    for number in range(len(found)):
        towards, away = drawn(flat[found.first[number] : found.first[number + 1]], 32)
        np.testing.assert_array_equal(towards, away)
        assert towards.max() <= 1


def test_pieces_of_a_cube():
    found = pieces_of(CUBE, (0, 0, 1), (-2, -1, 0.25, 0.5, 1, 2))
    assert np.diff(found.first).tolist() == [0, 12, 12, 12, 0]
    np.testing.assert_allclose([volume(found[piece]) for piece in range(5)], [0, 0.25, 0.25, 0.5, 0])
    whole = pieces_of(CUBE, (1, 1, 1), EVERYTHING)
    assert volume(whole.corners) == pytest.approx(1)
    assert closed(whole.corners)
    assert len(pieces_of(CUBE, (1, 0, 0), (0.5,))) == 0
    nothing = clipped(CUBE, (1, 0, 0), -1)
    assert pieces_of(nothing, (1, 0, 0), (0, 1, 2)).first.tolist() == [0, 0, 0]


def test_pieces_may_overlap():
    found = pieces_between(CUBE, (1, 0, 0), (0, 0.2, -1), (0.5, 0.9, 3))
    np.testing.assert_allclose([volume(found[piece]) for piece in range(3)], [0.5, 0.7, 1])


def test_offsets_a_rounding_away_make_no_slivers():
    far = box((1e6, 0, 0), (1e6 + 1, 1, 1), np.eye(4))
    found = pieces_of(far, (1, 0, 0), 1e6 + np.array([-1e-10, 1e-10, 0.5, 1 - 1e-10, 2]))
    assert np.diff(found.first).tolist() == [0, 12, 12, 0]
