"""Cameras that look all round: panoramas and domes, for the inside of things."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..stage import F32, Context, Vec2f, Vec3f, param, register
from ..volume import FloatArray
from .camera import Camera, CameraFrame, point_of


@dataclass(frozen=True)
class RoundFrame(CameraFrame):
    """What the device needs: unit vectors, and the angles from the middle of the image to its edges."""

    half_angles: Vec2f = param((math.pi, math.pi / 2), unit="rad")


def _frame(camera: Camera, half_angles: tuple[float, float]) -> RoundFrame:
    right, up, forward = (point_of(axis) for axis in camera.basis())
    return RoundFrame(camera.eye, forward, right, up, half_angles)


def _from_eye(camera: Camera, points_world: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """How far points (n, 3) lie to the right, up and forward of the eye, and away from it; no numbers for the eye itself."""
    aside, above, ahead = np.stack(camera.basis()) @ (points_world - np.array(camera.eye)).T
    distance = np.sqrt(aside**2 + above**2 + ahead**2)
    return aside, above, ahead, np.where(distance > 0, distance, np.nan)


def _placed_by_angles(
    angles: FloatArray, distance: FloatArray, half_angles: tuple[float, float], size_px: tuple[int, int]
) -> FloatArray:
    """Places (n, 3) of angles (n, 2) to the right of the image's middle and down from it."""
    places = (angles / half_angles + 1) * np.array(size_px) / 2
    return np.column_stack([np.where(np.isfinite(distance)[:, None], places, np.nan), distance])


@register
@dataclass(frozen=True)
class Panorama(Camera):
    """All round the eye, equirectangular: columns are degrees of azimuth, rows degrees of elevation.

    The target is in the middle; pixels are square where width and height of the image are as the angles. Distance is measured
    along the ray.
    """

    name: ClassVar[str] = "panorama"
    wgsl: ClassVar[str] = "camera/panorama.wgsl"
    uniform_type: ClassVar[type] = RoundFrame
    looks_round: ClassVar[bool] = True
    eye: Vec3f = param((0.0, -4.0, 0.0), unit="world", help="position of the eye")
    target: Vec3f = param((0.0, 0.0, 0.0), unit="world", help="point in the middle of the image")
    up: Vec3f = param((0.0, 0.0, 1.0), unit="1", help="direction that is up in the image")
    width_deg: F32 = param(360.0, unit="degree", above=0, up_to=360, help="angle from the left to the right edge")
    height_deg: F32 = param(180.0, unit="degree", above=0, up_to=180, help="angle from the bottom to the top")

    def uniforms(self, context: Context) -> RoundFrame:
        """Return the frame, which no image's size changes."""
        return _frame(self, self._half_angles)

    def ray(self, p_px: tuple[float, float], size_px: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where the ray of a point of the image begins, and its direction, both (3,) in the world."""
        right, up, forward = self.basis()
        azimuth = (2 * p_px[0] / size_px[0] - 1) * self._half_angles[0]
        elevation = (1 - 2 * p_px[1] / size_px[1]) * self._half_angles[1]
        level = math.cos(azimuth) * forward + math.sin(azimuth) * right
        return np.array(self.eye), math.cos(elevation) * level + math.sin(elevation) * up

    def pixel_width(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Return how wide a pixel is in the middle of the image: at the eye [world], and more per world unit of distance."""
        return 0.0, 2 * max(angle / n for angle, n in zip(self._half_angles, size_px, strict=True))

    def placed(self, points_world: FloatArray, size_px: tuple[int, int]) -> FloatArray:
        """Return where points (n, 3) are seen: column, row [px] and distance, (n, 3)."""
        aside, above, ahead, distance = _from_eye(self, points_world)
        angles = np.stack([np.arctan2(aside, ahead), -np.arctan2(above, np.hypot(aside, ahead))], axis=1)
        return _placed_by_angles(angles, distance, self._half_angles, size_px)

    @property
    def _half_angles(self) -> tuple[float, float]:
        return math.radians(self.width_deg) / 2, math.radians(self.height_deg) / 2


@register
@dataclass(frozen=True)
class Dome(Camera):
    """A fisheye's disk in the middle of the image, equidistant: degrees from the view's axis are ways from the middle.

    180 degrees are the half of all directions before the eye, as a dome shows them, 360 degrees all. Beside the disk there are
    no rays, and nothing is drawn. Distance is measured along the ray.
    """

    name: ClassVar[str] = "dome"
    wgsl: ClassVar[str] = "camera/dome.wgsl"
    uniform_type: ClassVar[type] = RoundFrame
    looks_round: ClassVar[bool] = True
    eye: Vec3f = param((0.0, -4.0, 0.0), unit="world", help="position of the eye")
    target: Vec3f = param((0.0, 0.0, 0.0), unit="world", help="point in the middle of the image")
    up: Vec3f = param((0.0, 0.0, 1.0), unit="1", help="direction that is up in the image")
    angle_deg: F32 = param(180.0, unit="degree", above=0, up_to=360, help="angle across the disk")

    def uniforms(self, context: Context) -> RoundFrame:
        """Return the frame for the image's size."""
        return _frame(self, self._half_angles(context.size_px))

    def ray(self, p_px: tuple[float, float], size_px: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where the ray of a point of the image begins, and its direction, both (3,) in the world.

        Beside the disk the direction is zero.
        """
        right, up, forward = self.basis()
        x, y = ((2 * p / n - 1) * angle for p, n, angle in zip(p_px, size_px, self._half_angles(size_px), strict=True))
        from_axis = math.hypot(x, y)
        if from_axis > math.radians(self.angle_deg) / 2:
            return np.array(self.eye), np.zeros(3)
        share = math.sin(from_axis) / from_axis if from_axis > 0 else 1.0
        return np.array(self.eye), math.cos(from_axis) * forward + share * (x * right - y * up)

    def pixel_width(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Return how wide a pixel is in the middle of the image: at the eye [world], and more per world unit of distance."""
        return 0.0, math.radians(self.angle_deg) / min(size_px)

    def placed(self, points_world: FloatArray, size_px: tuple[int, int]) -> FloatArray:
        """Return where points (n, 3) are seen: column, row [px] and distance, (n, 3); beside the disk they have no place."""
        aside, above, ahead, distance = _from_eye(self, points_world)
        off_axis = np.hypot(aside, above)
        from_axis = np.arctan2(off_axis, ahead)
        way = np.stack([aside, -above], axis=1) / np.maximum(off_axis, 1e-300)[:, None]
        angles = np.where(from_axis <= math.radians(self.angle_deg) / 2, from_axis, np.nan)[:, None] * way
        return _placed_by_angles(angles, distance, self._half_angles(size_px), size_px)

    def _half_angles(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Angles that the middles of the image's edges would have."""
        half = math.radians(self.angle_deg) / 2
        return half * size_px[0] / min(size_px), half * size_px[1] / min(size_px)
