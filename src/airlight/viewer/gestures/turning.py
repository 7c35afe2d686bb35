"""Turns: of the eye about its target, of the gaze about the eye, of the picture about its middle."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from ...movies.between import rotation
from ...stages.camera import Camera, Orthographic, point_of
from ...volume import FloatArray

TURN_RAD = math.pi
"""Angle by which a drag over the whole height of the view turns."""
STEEP_RAD = math.pi / 2 - 0.002
"""Elevation that turntables stop at: at the pole, what is up could not be told."""


def turntable(camera: Camera, dx: float, dy: float, pole: Any = None) -> Camera:
    """Turn about what is up, and the eye higher or lower, up to the poles: what stands upright stays so.

    Parameters
    ----------
    camera
        What is turned.
    dx, dy
        The drag, to the right and down, in parts of the view's height.
    pole
        Axis of the table for cameras that look along it, whose own ``up`` cannot be it; else that is the axis.
    """
    right, _, forward = camera.basis()
    up = unit(camera.up) if pole is None or abs(unit(pole) @ forward) < math.sin(STEEP_RAD) - 1e-9 else unit(pole)
    height = math.asin(max(-1.0, min(1.0, float(-forward @ up))))
    rise = max(-STEEP_RAD, min(STEEP_RAD, height + dy * TURN_RAD)) - height
    turn = rotation(up, -dx * TURN_RAD) @ rotation(right, -rise)
    return placed(camera, camera.target + turn @ np.subtract(camera.eye, camera.target), camera.target, up)


def trackball(camera: Camera, dx: float, dy: float) -> Camera:
    """Roll as a ball under the hand: about the axis in the picture's plane that is across the drag. Nothing stays upright."""
    length = math.hypot(dx, dy)
    if length == 0:
        return camera
    right, up, _ = camera.basis()
    turn = rotation(-(dx * up + dy * right) / length, length * TURN_RAD)
    return placed(camera, camera.target + turn @ np.subtract(camera.eye, camera.target), camera.target, turn @ up)


def look(camera: Camera, dx: float, dy: float) -> Camera:
    """Turn the gaze: what is seen goes with the pointer, and the eye stays where it is."""
    right, _, forward = camera.basis()
    up, angle = unit(camera.up), view_angle_rad(camera)
    height = math.asin(max(-1.0, min(1.0, float(forward @ up))))
    rise = max(-STEEP_RAD, min(STEEP_RAD, height + dy * angle)) - height
    turn = rotation(up, dx * angle) @ rotation(right, rise)
    return placed(camera, camera.eye, camera.eye + turn @ np.subtract(camera.target, camera.eye))


def roll(camera: Camera, dx: float, dy: float = 0.0) -> Camera:
    """Turn the picture about its middle, clockwise for a drag to the right."""
    _, _, forward = camera.basis()
    return placed(camera, camera.eye, camera.target, rotation(forward, -dx * TURN_RAD) @ np.asarray(camera.up))


def view_angle_rad(camera: Camera) -> float:
    """Angle from the bottom to the top of the view; one radian for parallel rays, which have none."""
    if isinstance(camera, Orthographic):
        return 1.0
    degrees = getattr(camera, "fov_deg", getattr(camera, "height_deg", getattr(camera, "angle_deg", 60.0)))
    return math.radians(min(degrees, 160.0))


def shown_height(camera: Camera) -> float:
    """World units from bottom to top of the view at the target's depth."""
    if isinstance(camera, Orthographic):
        return camera.height
    return 2 * math.dist(camera.eye, camera.target) * math.tan(view_angle_rad(camera) / 2)


def unit(vector: Any) -> FloatArray:
    """A vector of length one."""
    given = np.asarray(vector, dtype=np.float64)
    return np.asarray(given / np.linalg.norm(given))


def placed(camera: Camera, eye: Any, target: Any, up: Any = None, **others: float) -> Camera:
    """Return the camera at another place."""
    frame: Any = camera
    moved: Camera = dataclasses.replace(
        frame, eye=point_of(eye), target=point_of(target), up=point_of(camera.up if up is None else up), **others
    )
    return moved
