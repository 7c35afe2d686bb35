"""Lights as cameras: where their rays pass a buffer, and where the pictures lie that they throw. NumPy alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..light import Beam, Light
from ..stages.camera import Camera, Orthographic, point_of
from ..stages.driver_half_angle import near_light
from ..volume import FloatArray

MARGIN_TEXELS = 2  # beside what a volume covers of a light's buffer
LEAST_AHEAD = 0.17  # cosine of the widest angle between the middle of a light's view and a corner: 80 degrees


def light_camera(light: Light, eye: Camera, points_world: FloatArray, size: int, number: int = 0) -> Camera:
    """Camera at a light whose square image of ``size`` texels holds all points (n, 3); a head light is at the eye.

    Its up follows that of the eye's camera: a light, a volume and a camera that are turned together see the same texels.

    Raises
    ------
    ValueRangeError
        When the light is among the points, or so near that they lie all round it.
    """
    middle, wider = (points_world.min(axis=0) + points_world.max(axis=0)) / 2, 1 + 2 * MARGIN_TEXELS / size
    way = way_of(light, eye, middle)
    up = point_of(across(way, eye))
    if is_parallel(light, eye):
        beside = Camera.orthographic(eye=point_of(middle), target=point_of(middle + way), up=up)
        right, above, _ = beside.basis()
        axes = np.stack([right, above])
        aside = (points_world - middle) @ axes.T
        low, high = aside.min(axis=0), aside.max(axis=0)
        middle = middle + (low + high) / 2 @ axes
        reach = float(np.linalg.norm(points_world - middle, axis=1).max())
        half = float((high - low).max()) / 2
        return Camera.orthographic(
            eye=point_of(middle - 2 * reach * way), target=point_of(middle), up=up, height=2 * half * wider
        )
    place = np.asarray(eye.eye if light.kind == "head" else light.vector, dtype=np.float64)
    seen = Camera.perspective(eye=point_of(place), target=point_of(place + way), up=up)
    right, above, forward = seen.basis()
    aside = points_world - place
    ahead = aside @ forward
    if float((ahead / np.maximum(np.linalg.norm(aside, axis=1), 1e-300)).min()) < LEAST_AHEAD:
        raise near_light(number)
    half = float((np.maximum(np.abs(aside @ right), np.abs(aside @ above)) / ahead).max()) * wider
    fov = math.degrees(2 * math.atan(half))
    return Camera.perspective(eye=point_of(place), target=point_of(place + way), up=up, fov_deg=fov)


def is_parallel(light: Light, eye: Camera) -> bool:
    """Whether the rays of a light run in one direction."""
    return light.kind == "directional" or (light.kind == "head" and isinstance(eye, Orthographic))


def way_of(light: Light, eye: Camera, middle_world: FloatArray) -> FloatArray:
    """Direction (3,) in which a light runs through the middle of a volume."""
    if light.kind == "directional":
        return -np.asarray(light.vector)
    if is_parallel(light, eye):
        return eye.basis()[2]
    way = middle_world - np.asarray(eye.eye if light.kind == "head" else light.vector)
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-300))


def across(way: FloatArray, eye: Camera) -> FloatArray:
    """What of the eye's up, or of what lies in front of it, is most at a right angle to a direction (3,)."""
    _, up, forward = eye.basis()
    chosen = up if abs(float(up @ way)) <= abs(float(forward @ way)) else forward
    return np.asarray(chosen - (chosen @ way) * way)


def clip_from_world(camera: Camera) -> FloatArray:
    """Matrix (4, 4) from the world to a square image: x and y from -1 to 1, up and to the right, once divided by w."""
    half: Any = camera.half_height  # type: ignore[attr-defined]
    right, up, forward = camera.basis()
    rows = np.zeros((4, 4))
    rows[0, :3], rows[1, :3] = right / half, up / half
    if isinstance(camera, Orthographic):
        rows[3, 3] = 1.0
    else:
        rows[3, :3] = forward
    rows[:, 3] -= rows[:, :3] @ np.asarray(camera.eye)
    return rows


def picture_from_world(position: FloatArray, beam: Beam) -> FloatArray:
    """Matrix (4, 4) from the world to the picture that a spot light throws, from -1 to 1 once divided by w."""
    camera = Camera.perspective(eye=point_of(position), target=beam.target, up=beam.up, fov_deg=beam.angle_deg)
    rows = clip_from_world(camera)
    rows[0] /= beam.picture.aspect
    return rows
