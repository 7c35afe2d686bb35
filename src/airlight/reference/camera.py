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


def stereo(camera: Any, size_px: tuple[int, int], x_px: FloatArray, y_px: FloatArray) -> Rays:
    """Rays from each eye through the one screen that both look at, at the distance of convergence."""
    right, up, forward = camera.basis()
    eye, away = np.array(camera.eye), camera.convergence or float(np.linalg.norm(np.subtract(camera.target, camera.eye)))
    apart = away / 30 if camera.interocular is None else camera.interocular
    width, height = size_px[0] / (2 if camera.view == "both" else 1), size_px[1]
    x, y = x_px + 0.5, y_px + 0.5
    is_right = np.full(len(x), camera.view == "right") if camera.view != "both" else x >= width
    x = np.where(is_right & (camera.view == "both"), x - width, x)
    # A pixel's place on the screen, which is as high as the angle of view is wide there.
    pixel_world = 2 * away * math.tan(math.radians(camera.fov_deg) / 2) / height
    on_screen = eye + away * forward + pixel_world * ((x - width / 2)[:, None] * right + (height / 2 - y)[:, None] * up)
    origin = eye + np.where(is_right, apart / 2, -apart / 2)[:, None] * right
    direction = on_screen - origin
    return origin, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def panorama(camera: Any, size_px: tuple[int, int], x_px: FloatArray, y_px: FloatArray) -> Rays:
    """Rays by azimuth from the middle column and elevation from the middle row."""
    azimuth = np.radians(camera.width_deg) * ((x_px + 0.5) / size_px[0] - 0.5)
    elevation = np.radians(camera.height_deg) * (0.5 - (y_px + 0.5) / size_px[1])
    parts = np.cos(elevation) * np.sin(azimuth), np.sin(elevation), np.cos(elevation) * np.cos(azimuth)
    direction = np.stack(parts, axis=1) @ np.array(camera.basis())
    return np.broadcast_to(np.array(camera.eye), direction.shape), direction


def dome(camera: Any, size_px: tuple[int, int], x_px: FloatArray, y_px: FloatArray) -> Rays:
    """Rays by polar coordinates round the image's middle; beside the disk their direction is zero."""
    x, y = x_px + 0.5 - size_px[0] / 2, size_px[1] / 2 - y_px - 0.5
    radius = np.hypot(x, y) / (min(size_px) / 2)
    from_axis, around = np.radians(camera.angle_deg) / 2 * radius, np.arctan2(y, x)
    parts = np.sin(from_axis) * np.cos(around), np.sin(from_axis) * np.sin(around), np.cos(from_axis)
    direction = np.where(radius[:, None] <= 1, np.stack(parts, axis=1) @ np.array(camera.basis()), 0.0)
    return np.broadcast_to(np.array(camera.eye), direction.shape), direction


def pixel_width(camera: Any, size_px: tuple[int, int], distance: FloatArray) -> FloatArray:
    """Width of a pixel in the middle of the image at distances (n,) from the eye."""
    (width, height), name = size_px, camera.name
    if name == "orthographic":
        return np.full(len(distance), camera.height / height)
    if name == "panorama":
        return np.asarray(distance * np.radians(max(camera.width_deg / width, camera.height_deg / height)))
    if name == "dome":
        return np.asarray(distance * np.radians(camera.angle_deg) / min(size_px))
    return np.asarray(distance * 2 * math.tan(math.radians(camera.fov_deg / 2)) / height)


CAMERAS: dict[str, Callable[..., Rays]] = {
    "perspective": perspective,
    "orthographic": orthographic,
    "stereo": stereo,
    "panorama": panorama,
    "dome": dome,
}
