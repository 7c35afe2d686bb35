"""Cameras: the rays of pixels. ``camera(stage, size_px, x_px, y_px) -> (origin (n, 3), direction (n, 3))``."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..volume import FloatArray

Rays = tuple[FloatArray, FloatArray]


def perspective(camera: Any, size_px: tuple[int, int], x_px: FloatArray, y_px: FloatArray) -> Rays:
    """All rays begin at the eye; distance is measured along each."""
    forward, aside = _image_plane(camera, size_px, x_px, y_px, math.tan(math.radians(camera.fov_deg) / 2))
    direction = forward + aside
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return np.broadcast_to(np.array(camera.eye), direction.shape), direction


def orthographic(camera: Any, size_px: tuple[int, int], x_px: FloatArray, y_px: FloatArray) -> Rays:
    """All rays go forward, from the plane through the eye."""
    forward, aside = _image_plane(camera, size_px, x_px, y_px, camera.height / 2)
    return np.array(camera.eye) + aside, np.broadcast_to(forward, aside.shape)


def _image_plane(
    camera: Any, size_px: tuple[int, int], x_px: FloatArray, y_px: FloatArray, half_height: float
) -> tuple[FloatArray, FloatArray]:
    """Forward (3,), and the way (n, 3) from the middle of the image to each pixel's centre; first row on top."""
    right, up, forward = camera.basis()
    width, height = size_px
    ndc_x = 2 * (x_px + 0.5) / width - 1
    ndc_y = 1 - 2 * (y_px + 0.5) / height
    return forward, half_height * (ndc_x[:, None] * right * (width / height) + ndc_y[:, None] * up)


CAMERAS: dict[str, Callable[..., Rays]] = {"perspective": perspective, "orthographic": orthographic}
