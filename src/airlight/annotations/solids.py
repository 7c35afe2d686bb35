"""Arrows as triangles."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from ..geometry import Mesh
from ..volume import FloatArray
from .marks import Colour3

ROUND = 20
"""Corners of an arrow's section."""
HEAD_LENGTH, HEAD_RADIUS = 8.0, 2.6
"""Of the shaft's radius."""


def arrow(start_world: FloatArray, way_world: FloatArray, radius_world: float) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """Vertices (n, 3) and faces (m, 3) of an arrow along a way (3,), whose shaft has a radius.

    Its parts share no vertices, so that normals are smooth round it and sharp along its edges.
    """
    length = float(np.linalg.norm(way_world))
    forward = way_world / length
    aside = np.cross(forward, np.eye(3)[int(np.argmin(np.abs(forward)))])
    aside /= np.linalg.norm(aside)
    above = np.cross(forward, aside)
    angle = 2 * np.pi * np.arange(ROUND) / ROUND
    circle = np.cos(angle)[:, None] * aside + np.sin(angle)[:, None] * above
    head = min(HEAD_LENGTH * radius_world, 0.6 * length)
    neck = length - head
    wide, point = HEAD_RADIUS * radius_world, 1e-6 * radius_world
    # From ring to ring, (distance, radius): end, shaft, back of the head, head.
    parts = (
        ((0.0, point), (0.0, radius_world)),
        ((0.0, radius_world), (neck, radius_world)),
        ((neck, radius_world), (neck, wide)),
        ((neck, wide), (length, point)),
    )
    vertices, faces = [], []
    first, following = np.arange(ROUND), (np.arange(ROUND) + 1) % ROUND
    for number, ((at, r), (to, s)) in enumerate(parts):
        vertices += [start_world + at * forward + r * circle, start_world + to * forward + s * circle]
        base = 2 * ROUND * number
        faces.append(base + np.stack([first, following, ROUND + first], axis=1))
        faces.append(base + np.stack([following, ROUND + following, ROUND + first], axis=1))
    return np.concatenate(vertices), np.concatenate(faces)


def joined(parts: Iterable[tuple[FloatArray, npt.NDArray[np.int64], Colour3]]) -> Mesh:
    """One mesh of several, each in a colour of its own."""
    vertices, faces, colours = [], [], []
    count = 0
    for corners, triangles, rgb in parts:
        vertices.append(corners)
        faces.append(triangles + count)
        colours.append(np.broadcast_to(rgb, corners.shape))
        count += len(corners)
    return Mesh(np.concatenate(vertices), np.concatenate(faces), colors=np.concatenate(colours))
