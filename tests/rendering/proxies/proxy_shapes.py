"""Convex polyhedra, directions and measures for tests of proxy geometry."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from airlight.rendering.proxies.polygons import Polygons
from airlight.rendering.proxies.polyhedra import Polyhedron, box, clipped

WHOLE = st.integers(-3, 3)
VECTORS = st.tuples(WHOLE, WHOLE, WHOLE).filter(any).map(np.array) | st.builds(
    lambda seed: np.random.default_rng(seed).normal(size=3), st.integers(0, 10**6)
)
CUBE = box((0, 0, 0), (1, 1, 1), np.eye(4))
EVERYTHING = (-np.inf, np.inf)


@st.composite
def matrices(draw) -> np.ndarray:
    """Affines with shear, some of them mirrored; some leave axes where they are."""
    matrix = np.eye(4)
    if draw(st.booleans()):
        rng = np.random.default_rng(draw(st.integers(0, 10**6)))
        u, _, v = np.linalg.svd(rng.normal(size=(3, 3)))
        matrix[:3, :3] = u @ np.diag(rng.uniform(0.3, 3, 3)) @ v
        matrix[:3, 3] = rng.normal(0, 5, 3)
    return matrix


@st.composite
def polyhedra(draw) -> Polyhedron:
    """Sheared boxes of which planes cut corners off, some through vertices."""
    found = box((0, 0, 0), (2, 3, 4), draw(matrices()))
    for normal in draw(st.lists(VECTORS, max_size=4)):
        heights = found.vertices @ normal
        share = draw(st.sampled_from((0.4, 0.7, 0.9)))
        through = float(heights[len(heights) // 2]) if draw(st.booleans()) else -np.inf
        found = clipped(found, normal, max(through, heights.min() + share * np.ptp(heights)))
    return found


def rising(polyhedron: Polyhedron, normal: np.ndarray, count: int) -> np.ndarray:
    """Offsets of planes from before a polyhedron to behind it, its vertices' among them."""
    heights = polyhedron.vertices @ normal
    return np.sort(np.concatenate([np.linspace(heights.min() - 0.3, heights.max() + 0.3, count), heights]))


def area_vectors(polygons: Polygons) -> np.ndarray:
    """Areas (n, 3) as vectors along the normals."""
    points = [polygons[number] for number in range(len(polygons))]
    return np.array([np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0) / 2 for loop in points]).reshape(-1, 3)


def areas(polygons: Polygons) -> np.ndarray:
    return np.linalg.norm(area_vectors(polygons), axis=1)


def triangles(polyhedron: Polyhedron) -> np.ndarray:
    """Its surface (t, 3, 3)."""
    fans = [(face[0], *pair) for face in polyhedron.faces for pair in pairwise(face[1:])]
    return polyhedron.vertices[np.array(fans, dtype=int).reshape(-1, 3)]


def volume(corners: np.ndarray) -> float:
    """What a closed surface of triangles (t, 3, 3) encloses."""
    a, b, c = (corners - (corners[0, 0] if len(corners) else 0)).swapaxes(0, 1)
    return float((a * np.cross(b, c)).sum()) / 6


def crossings(corners: np.ndarray, starts: np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How many triangles (t, 3, 3) each line (n,) enters by, and leaves by."""
    # Signs of the three volumes that a line spans with a triangle's edges.
    local = corners[None] - starts[:, None, None]
    sides = np.cross(local, np.roll(local, -1, axis=2)) @ ways[:, None, :, None]
    return (sides[..., 0] < 0).all(axis=2).sum(axis=1), (sides[..., 0] > 0).all(axis=2).sum(axis=1)


def drawn(corners_px: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """How often a rasteriser draws each pixel (size, size) by triangles (t, 3, 2) of either turn.

    As rasterisers do: corners in 256ths of a pixel, and pixels on an edge given to one of its sides.
    """
    fixed = np.round(corners_px.astype(np.float32) * np.float32(256)).astype(np.int64)
    centre = np.stack(np.meshgrid(np.arange(size), np.arange(size)), axis=-1).reshape(-1, 2) * 256 + 128
    u, v, w = fixed.swapaxes(0, 1)
    turn = (v[:, 0] - u[:, 0]) * (w[:, 1] - u[:, 1]) - (v[:, 1] - u[:, 1]) * (w[:, 0] - u[:, 0])
    found = []
    for side, loop in ((turn > 0, (u, v, w)), (turn < 0, (u, w, v))):
        inside = np.broadcast_to(side[:, None], (len(side), len(centre))).copy()
        for a, b in pairwise((*loop, loop[0])):
            (dx, dy), (x, y) = (b - a).T[..., None], (centre - a[:, None]).transpose(2, 0, 1)
            over = dx * y - dy * x
            inside &= (over > 0) | ((over == 0) & ((dy < 0) | ((dy == 0) & (dx > 0))))
        found.append(inside.sum(axis=0))
    return found[0], found[1]


def closed(corners: np.ndarray) -> bool:
    """Whether each edge of triangles has one, to the last bit, that runs back along it."""
    ways = [(tuple(a), tuple(b)) for triangle in corners for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)]
    return len(set(ways)) == len(ways) and {(b, a) for a, b in ways} == set(ways)
