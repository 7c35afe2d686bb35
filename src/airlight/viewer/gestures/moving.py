"""Moves: sideways, nearer and farther, through the volume, and to a point that was picked."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...stages.camera import Camera, Orthographic
from ...volume import FloatArray
from .turning import placed, shown_height

Place = tuple[float, float]
NEAREST, FARTHEST = 1e-4, 1e3
"""Distances of the eye from its target, in diagonals of what is shown."""
FLIGHT = 0.25
"""Part of the diagonal that one unit of flight covers."""


def pan(camera: Camera, dx: float, dy: float) -> Camera:
    """Move sideways, so that what lies under the pointer at the target's depth goes with it."""
    right, up, _ = camera.basis()
    by = (-dx * right + dy * up) * shown_height(camera)
    return placed(camera, camera.eye + by, camera.target + by)


def dolly(camera: Camera, dy: float, at: Place | None, span: float, fov_deg: float) -> Camera:
    """Go nearer (dragged up) or farther by equal factors for equal drags.

    Parameters
    ----------
    camera
        What is moved.
    dy
        The drag downwards, in parts of the view's height: the distance grows by ``exp(2 dy)``.
    at
        Place of the pointer from the middle of the view, to the right and down, in parts of its height: what lies there at the
        target's depth stays there. None: the middle.
    span
        Diagonal of what is shown, in world units, which bounds the distance.
    fov_deg
        Angle that cameras with parallel rays keep their eye's plane outside for: it does not cut what they show again.
    """
    right, up, _ = camera.basis()
    size, distance = shown_height(camera), math.dist(camera.eye, camera.target)
    least, most = (limit * span * size / distance for limit in (NEAREST, FARTHEST))
    factor = min(max(math.exp(2 * max(-2.0, min(2.0, dy))), min(1.0, least / size)), max(1.0, most / size))
    across, down = at or (0.0, 0.0)
    fixed = camera.target + size * (across * right - down * up)
    target = fixed + factor * (camera.target - fixed)
    if isinstance(camera, Orthographic):
        away = max(distance, distance_for(size * factor, fov_deg)) / distance
        return placed(camera, target + away * np.subtract(camera.eye, camera.target), target, height=size * factor)
    return placed(camera, target + factor * np.subtract(camera.eye, camera.target), target)


def fly(camera: Camera, dx: float, dy: float, dz: float, span: float) -> Camera:
    """Move eye and target to the right, down and forward, in quarters of the diagonal of what is shown."""
    right, up, forward = camera.basis()
    by = (dx * right - dy * up + dz * forward) * span * FLIGHT
    return placed(camera, camera.eye + by, camera.target + by)


def aimed(camera: Camera, p_world: Any) -> Camera:
    """Move sideways until a point is in the middle, and turn about it from now on: direction and distance to it stay."""
    _, _, forward = camera.basis()
    point: FloatArray = np.asarray(p_world, dtype=np.float64)
    depth = float((point - camera.eye) @ forward)
    depth = depth if depth > 0 else math.dist(camera.eye, camera.target)
    return placed(camera, point - depth * forward, point)


def distance_for(height: float, fov_deg: float) -> float:
    """Distance at which a view of an angle shows a height, in world units."""
    return height / (2 * math.tan(math.radians(fov_deg) / 2))
