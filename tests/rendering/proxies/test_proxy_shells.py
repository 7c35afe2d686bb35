"""Tessellated shells round the eye, and covers of what lies between them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from proxy_shapes import CUBE, areas, closed, crossings, polyhedra

from airlight.rendering.proxies.polygons import Polygons
from airlight.rendering.proxies.polyhedra import box, clipped
from airlight.rendering.proxies.shells import Shells, in_frustum, shell_pieces, shells_of

ORIGIN = np.zeros(3)
ROOM = box((-4, -4, -4), (4, 4, 4), np.eye(4))
PYRAMID = np.array([(-1, -0.5, 2), (1, -0.5, 2), (1, 0.5, 2), (-1, 0.5, 2)])


def solid_angles(polygons: Polygons, eye: np.ndarray) -> np.ndarray:
    """What each polygon (n,) covers as seen from the eye (Van Oosterom and Strackee)."""
    triangles, polygon = polygons.fans()
    a, b, c = (polygons.vertices[triangles] - eye).swapaxes(0, 1)
    x, y, z = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    below = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
    return np.bincount(polygon, 2 * np.arctan2((a * np.cross(b, c)).sum(1), below), len(polygons))


def by_shell(found: Shells, measures: np.ndarray, count: int) -> np.ndarray:
    return np.bincount(found.shells, measures, count)


def test_whole_spheres():
    radii = np.array([0.5, 2.0, 3.5])
    for tolerance in (0.4, 0.05):
        found = shells_of(ROOM, ORIGIN, radii, tolerance)
        radius = radii[np.repeat(found.shells, found.polygons.counts)]
        np.testing.assert_allclose(np.linalg.norm(found.polygons.vertices, axis=1), radius, rtol=1e-12)
        np.testing.assert_allclose(by_shell(found, solid_angles(found.polygons, ORIGIN), 3), 4 * np.pi)
        assert (by_shell(found, areas(found.polygons), 3) / (4 * np.pi * radii**2) > (1 - tolerance / 3.5) ** 2).all()
        normals = np.array(
            [np.cross(loop[1] - loop[0], loop[2] - loop[0]) for loop in map(found.polygons.__getitem__, range(50))]
        )
        depths = (normals * found.polygons.vertices[found.polygons.first[:50]]).sum(1) / np.linalg.norm(normals, axis=1)
        assert (depths > 0).all()


@pytest.mark.parametrize(("radius", "tolerance"), [(1.5, 0.9), (3.0, 0.1), (3.5, 0.06)])
def test_no_point_is_deeper_than_the_tolerance(radius, tolerance, rng):
    found = shells_of(clipped(ROOM, (1, 2, 3), 0.0), ORIGIN, (radius,), tolerance).polygons
    triangles, _ = found.fans()
    points = np.einsum("twk,tkx->twx", rng.dirichlet((0.5, 0.5, 0.5), (len(triangles), 4)), found.vertices[triangles])
    far = np.linalg.norm(points, axis=2)
    assert far.max() <= radius * (1 + 1e-12)
    assert far.min() >= radius - tolerance - 1e-12


def test_a_frustum_cuts_shells():
    """A pyramid of rectangular section covers the solid angle 4 arcsin(sin a sin b), at all distances."""
    seen = in_frustum(ROOM, ORIGIN, PYRAMID)
    radii = np.array([0.5, 1.0, 3.0])
    found = shells_of(seen, ORIGIN, radii, 0.02)
    a, b = np.arctan([1 / 2, 0.5 / 2])
    wanted = 4 * np.arcsin(np.sin(a) * np.sin(b))
    np.testing.assert_allclose(by_shell(found, solid_angles(found.polygons, ORIGIN), 3), wanted)


def test_a_plane_cuts_caps():
    """What a plane cuts off a sphere: 2 pi r (r - d), within what the tolerance leaves open."""
    cut = clipped(ROOM, (0, 0, -1), -1.0)
    found = shells_of(cut, ORIGIN, (0.9, 1.5, 3.0), 0.02)
    assert found.polygons.vertices[:, 2].min() >= 1 - 1e-12
    np.testing.assert_allclose(
        by_shell(found, areas(found.polygons), 3), [0, 2 * np.pi * 1.5 * 0.5, 2 * np.pi * 3 * 2], rtol=0.02
    )
    np.testing.assert_array_equal(found.shells, np.sort(found.shells))


@given(polyhedra(), st.integers(0, 10**6), st.booleans())
@settings(max_examples=40)
def test_covers_hold_what_lies_between_radii(polyhedron, seed, inside):
    rng = np.random.default_rng(seed)
    middle, size = polyhedron.vertices.mean(axis=0), np.ptp(polyhedron.vertices, axis=0).max()
    eye = middle + (0 if inside else rng.uniform(0.3, 3) * size * rng.normal(size=3))
    weights = rng.dirichlet(np.full(len(polyhedron.vertices), 0.3), 80)
    points = weights @ (middle + (polyhedron.vertices - middle) * (1 - 1e-9))
    distances = np.linalg.norm(points - eye, axis=1)
    radii = np.linspace(0, distances.max() * 1.01, 7)
    found = shell_pieces(polyhedron, eye, radii)
    ways = points - eye + rng.normal(0, 1e-9 * size, (80, 3))
    for number in range(6):
        part = found[number]
        assert closed(part)
        own = (distances > radii[number]) & (distances < radii[number + 1])
        if own.any():
            normals = np.cross(part[:, 1] - part[:, 0], part[:, 2] - part[:, 0])
            assert ((points[own, None] - part[:, 0]) * normals).sum(axis=2).max() < 1e-9 * size**3
        entered, left = crossings(part, np.broadcast_to(eye, ways.shape), ways)
        np.testing.assert_array_equal(entered, left)
        assert entered.max() <= 1
        assert (left[own] == 1).all()


def test_covers_of_a_cube_seen_from_afar_are_nearly_slices():
    found = shell_pieces(CUBE, (0.5, 0.5, -1000.0), np.array([999.0, 1000.0, 1000.5, 1001.0, 1002.0]))
    depths = [(found[piece][..., 2].min(), found[piece][..., 2].max()) for piece in (1, 2)]
    np.testing.assert_allclose(depths, [(0, 0.5), (0.5, 1)], atol=1e-3)
    assert not len(found[3]) or found[3][..., 2].min() > 0.999
