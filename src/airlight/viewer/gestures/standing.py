"""Standpoints: views along axes, all of it, parallel rays or a point of sight, the angle of view."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...errors import ValueRangeError
from ...first_picture.view import MARGIN, fitted_camera
from ...scene import VIEWS
from ...stages.camera import Camera, Orthographic, Perspective
from ...volume import FloatArray
from .moving import distance_for
from .turning import placed, shown_height, unit

WIDEST_DEG, NARROWEST_DEG = 120.0, 2.0


def seen_from(camera: Camera, to_eye: Any, pole: Any) -> Camera:
    """Return the camera on the other side of its target: the same distance away in a direction, the pole up.

    Along the pole, up is what named views from the top and the bottom have there.
    """
    direction = unit(to_eye)
    _, above, forward = camera.basis()
    there = [up for way, up in VIEWS.values() if np.allclose(way, direction)]
    up = next(unit(up) for up in (pole, *there, -forward, above) if abs(direction @ unit(up)) < 1 - 1e-6)
    distance = math.dist(camera.eye, camera.target)
    return placed(camera, camera.target + distance * direction, camera.target, up)


def named(camera: Camera, name: str, pole: Any) -> Camera:
    """Return the camera of a named view, about the same target.

    Raises
    ------
    ValueRangeError
        For names that are none of ``VIEWS``.
    """
    if name not in VIEWS:
        raise ValueRangeError("gesture.name", f"is {name!r:.80}, must be one of {', '.join(VIEWS)}")
    return seen_from(camera, VIEWS[name][0], pole)


def fitted(camera: Camera, corners_world: FloatArray, aspect: float, fov_deg: float) -> Camera:
    """Return a camera that looks the same way and shows all corners (n, 3); its eye is outside."""
    right, up, forward = camera.basis()
    if isinstance(camera, Orthographic):
        middle = (corners_world.min(axis=0) + corners_world.max(axis=0)) / 2
        aside, above, deep = (float(np.abs((corners_world - middle) @ axis).max()) for axis in (right, up, forward))
        height = 2 * MARGIN * max(above, aside / aspect)
        return placed(camera, middle - max(2 * deep, distance_for(height, fov_deg)) * forward, middle, height=height)
    whole = fitted_camera(corners_world, -forward, up, aspect, fov_deg=getattr(camera, "fov_deg", fov_deg))
    return placed(camera, whole.eye, whole.target)


def stood_back(camera: Camera, corners_world: FloatArray, aspect: float, chosen_for: float) -> Camera:
    """Return a camera so far away that a narrower view shows as much from side to side; wider views show it as it was chosen.

    Parameters
    ----------
    camera
        What was chosen.
    corners_world
        Corners (n, 3) of all that is shown.
    aspect, chosen_for
        Width over height of the view, and of the one for which the camera was chosen.
    """
    if aspect >= chosen_for or not isinstance(camera, Perspective):
        return camera
    _, _, forward = camera.basis()
    # What lies behind the target gains least by a longer way.
    behind = max(0.0, float(((corners_world - camera.target) @ forward).max()))
    away = (math.dist(camera.eye, camera.target) + behind) * chosen_for / aspect - behind
    return placed(camera, camera.target - away * forward, camera.target)


def other_projection(camera: Camera, fov_deg: float) -> Camera:
    """Return parallel rays for a camera with a point of sight, and back: what is at the target keeps its size.

    Parameters
    ----------
    camera
        What is changed.
    fov_deg
        Angle of view of the camera with a point of sight that comes back.
    """
    frame = {"eye": camera.eye, "target": camera.target, "up": camera.up}
    if not isinstance(camera, Orthographic):
        return Orthographic(**frame, height=shown_height(camera))
    distance = distance_for(camera.height, fov_deg)
    _, _, forward = camera.basis()
    if math.isclose(distance, math.dist(camera.eye, camera.target), rel_tol=1e-9):
        return Perspective(**frame, fov_deg=fov_deg)
    return placed(Perspective(**frame, fov_deg=fov_deg), camera.target - distance * forward, camera.target)


def of_angle(camera: Camera, fov_deg: float) -> Camera:
    """Return the camera with another angle of view, as near as keeps the size of what is at the target.

    Raises
    ------
    ValueRangeError
        For cameras that have no such angle.
    """
    if not hasattr(camera, "fov_deg"):
        what = f"has no angle of view, and {'shows a height' if isinstance(camera, Orthographic) else 'looks all round'}"
        raise ValueRangeError(f"camera {camera.name!r}", what, "switch to a perspective camera first")
    fov_deg = min(max(fov_deg, NARROWEST_DEG), WIDEST_DEG)
    _, _, forward = camera.basis()
    away = distance_for(shown_height(camera), fov_deg)
    return placed(camera, camera.target - away * forward, camera.target, fov_deg=fov_deg)
