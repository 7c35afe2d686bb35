"""The camera of two eyes."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..stage import F32, Context, Vec3f, param, register, static
from ..volume import FloatArray
from .camera import Camera, CameraFrame, point_of

INTEROCULAR = 1 / 30
"""Distance of the eyes, as a share of that of convergence, unless told: what is comfortable to look at."""


@dataclass(frozen=True)
class StereoFrame(CameraFrame):
    """What the device needs: ``right`` and ``up`` span half of one eye's image at distance one."""

    to_right_eye: Vec3f = param((0.0, 0.0, 0.0), unit="world")
    convergence: F32 = param(1.0, unit="world")
    views: F32 = param(2.0)
    first_side: F32 = param(-1.0)


@register
@dataclass(frozen=True)
class Stereo(Camera):
    """Two eyes side by side, or one of them: frusta that coincide at the distance of convergence.

    The left eye's image is the left half, the right eye's the right one, each with square pixels. What lies at the distance of
    convergence has no parallax; nearer things stand out of the screen. Distance is measured along the ray from its own eye.
    ``eye`` lies in the middle between both.
    """

    name: ClassVar[str] = "stereo"
    wgsl: ClassVar[str] = "camera/stereo.wgsl"
    uniform_type: ClassVar[type] = StereoFrame
    eye: Vec3f = param((0.0, -4.0, 0.0), unit="world", help="middle between the eyes")
    target: Vec3f = param((0.0, 0.0, 0.0), unit="world", help="point in the middle of each image, where they converge on it")
    up: Vec3f = param((0.0, 0.0, 1.0), unit="1", help="direction that is up in the image")
    fov_deg: F32 = param(30.0, unit="degree", above=0, below=180, help="vertical angle of view")
    interocular: F32 | None = param(None, unit="world", at_least=0, help="distance of the eyes; none: 1/30 of the convergence")
    convergence: F32 | None = param(None, unit="world", above=0, help="distance without parallax; none: that of the target")
    view: str = static("both", choices=("both", "left", "right"), help="both eyes side by side, or the whole image for one")

    def eyes(self) -> tuple[Stereo, Stereo]:
        """Return the cameras of the left and of the right eye, each for a whole image."""
        return dataclasses.replace(self, view="left"), dataclasses.replace(self, view="right")

    def uniforms(self, context: Context) -> StereoFrame:
        """Return the frame for the image's size."""
        right, up, forward = self.basis()
        views, half_height = self.views, self._half_height
        half_width = half_height * context.size_px[0] / views / context.size_px[1]
        return StereoFrame(
            eye=self.eye,
            forward=point_of(forward),
            right=point_of(right * half_width),
            up=point_of(up * half_height),
            to_right_eye=point_of(right * self._half_apart),
            convergence=self._convergence,
            views=float(views),
            first_side=1.0 if self.view == "right" else -1.0,
        )

    def ray(self, p_px: tuple[float, float], size_px: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where the ray of a point of the image begins, and its direction, both (3,) in the world."""
        right, up, forward = self.basis()
        width_px = size_px[0] / self.views
        of_right_eye = self.view == "right" or (self.view == "both" and p_px[0] >= width_px)
        x_px = p_px[0] - width_px if self.view == "both" and of_right_eye else p_px[0]
        to_eye = right * (self._half_apart if of_right_eye else -self._half_apart)
        aside, above = (2 * x_px - width_px) / size_px[1], 1 - 2 * p_px[1] / size_px[1]
        direction = forward + self._half_height * (aside * right + above * up) - to_eye / self._convergence
        return self.eye + to_eye, direction / np.linalg.norm(direction)

    def pixel_width(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Return how wide a pixel is in the middle of the image: at the eye [world], and more per world unit of distance."""
        return 0.0, 2 * self._half_height / size_px[1]

    @property
    def views(self) -> int:
        """How many eyes see parts of the image, side by side."""
        return 2 if self.view == "both" else 1

    @property
    def _half_height(self) -> float:
        return math.tan(math.radians(self.fov_deg) / 2)

    @property
    def _convergence(self) -> float:
        return math.dist(self.eye, self.target) if self.convergence is None else self.convergence

    @property
    def _half_apart(self) -> float:
        return (INTEROCULAR * self._convergence if self.interocular is None else self.interocular) / 2
