"""Cameras: values that users make with ``airlight.Camera``, and the rays of their pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..errors import StageError, ValueRangeError
from ..stage import F32, Context, Stage, Vec3f, param, register
from ..volume import FloatArray


@dataclass(frozen=True)
class CameraFrame:
    """What the device needs of a camera; ``right`` and ``up`` span half the image at distance one, or in world units."""

    eye: Vec3f = param((0.0, 0.0, 0.0), unit="world")
    forward: Vec3f = param((0.0, 0.0, 1.0), unit="1")
    right: Vec3f = param((1.0, 0.0, 0.0), unit="world")
    up: Vec3f = param((0.0, 1.0, 0.0), unit="world")


class Camera(Stage):
    """A camera, as a value. Make one with ``Camera.perspective``, ``orthographic``, ``stereo``, ``panorama`` or ``dome``.

    ``eye``, ``target`` and ``up`` are world points and a direction, as x, y, z. Distances along rays are measured from the
    eye, for orthographic cameras from the plane through the eye.
    """

    slot: ClassVar[str] = "camera"
    uniform_type: ClassVar[type] = CameraFrame
    looks_round: ClassVar[bool] = False
    """Whether images are no planes: what faces them faces the eye, and depths are distances."""
    eye: Vec3f
    target: Vec3f
    up: Vec3f

    @staticmethod
    def perspective(*, eye: Vec3f, target: Vec3f, up: Vec3f = (0.0, 0.0, 1.0), fov_deg: float = 30.0) -> Perspective:
        """Camera with a vertical angle of view ``fov_deg`` in degrees."""
        return Perspective(eye=point_of(eye), target=point_of(target), up=point_of(up), fov_deg=float(fov_deg))

    @staticmethod
    def orthographic(*, eye: Vec3f, target: Vec3f, up: Vec3f = (0.0, 0.0, 1.0), height: float = 1.0) -> Orthographic:
        """Camera with parallel rays that shows ``height`` world units from bottom to top."""
        return Orthographic(eye=point_of(eye), target=point_of(target), up=point_of(up), height=float(height))

    @staticmethod
    def stereo(
        *,
        eye: Vec3f,
        target: Vec3f,
        up: Vec3f = (0.0, 0.0, 1.0),
        fov_deg: float = 30.0,
        interocular: float | None = None,
        convergence: float | None = None,
        view: str = "both",
    ) -> Stereo:
        """Camera of two eyes side by side; ``.eyes()`` are the two for images of their own.

        ``eye`` is the middle between them. ``interocular`` is their distance (None: 1/30 of the convergence), ``convergence``
        the distance without parallax (None: that of the target), both in world units.
        """
        frame = {"eye": point_of(eye), "target": point_of(target), "up": point_of(up)}
        return Stereo(**frame, fov_deg=float(fov_deg), interocular=interocular, convergence=convergence, view=view)

    @staticmethod
    def panorama(
        *, eye: Vec3f, target: Vec3f, up: Vec3f = (0.0, 0.0, 1.0), width_deg: float = 360.0, height_deg: float = 180.0
    ) -> Panorama:
        """Camera that looks all round, equirectangular: ``width_deg`` by ``height_deg`` degrees round the target."""
        frame = {"eye": point_of(eye), "target": point_of(target), "up": point_of(up)}
        return Panorama(**frame, width_deg=float(width_deg), height_deg=float(height_deg))

    @staticmethod
    def dome(*, eye: Vec3f, target: Vec3f, up: Vec3f = (0.0, 0.0, 1.0), angle_deg: float = 180.0) -> Dome:
        """Camera with an equidistant fisheye: a disk of ``angle_deg`` degrees across, up to 360."""
        return Dome(eye=point_of(eye), target=point_of(target), up=point_of(up), angle_deg=float(angle_deg))

    def __post_init__(self) -> None:
        """Check the parameters and that the three vectors span a frame."""
        super().__post_init__()
        self.basis()

    def basis(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return unit vectors to the right, up and forward, float64, not to be written."""
        return self._basis

    @cached_property
    def _basis(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        eye, target, up = (np.asarray(v, dtype=np.float64) for v in (self.eye, self.target, self.up))
        forward = target - eye
        right = _cross(forward, up)
        if np.linalg.norm(right) <= 1e-9 * float(np.linalg.norm(forward) * np.linalg.norm(up)):
            raise ValueRangeError(
                f"camera.{self.name}",
                f"looks from {self.eye} to {self.target} with up {self.up}",
                "eye and target must differ, and up must not be parallel to the view",
            )
        forward /= np.linalg.norm(forward)
        right /= np.linalg.norm(right)
        found = right, _cross(right, forward), forward
        for vector in found:
            vector.setflags(write=False)
        return found

    def ray(self, p_px: tuple[float, float], size_px: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where the ray of a point of the image begins, and its direction, both (3,) in the world.

        Points of the image are counted in pixels from its upper left corner. Distance along the ray is the image's depth.

        Raises
        ------
        StageError
            When only the device knows the camera's rays.
        """
        raise StageError(f"camera {self.name!r}", "does not tell its rays", "give its class a method ray(p_px, size_px)")

    def pixel_width(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Return how wide a pixel is in the middle of the image: at the eye [world], and more per world unit of distance.

        Raises
        ------
        StageError
            When only the device knows the camera's rays.
        """
        remedy = "give its class a method pixel_width(size_px), or use the field linear"
        raise StageError(f"camera {self.name!r}", "does not tell how wide its pixels are", remedy)

    def placed(self, points_world: FloatArray, size_px: tuple[int, int]) -> FloatArray:
        """Return where points (n, 3) are seen: column, row [px] and depth, (n, 3).

        Depth is that along the view, of cameras that look all round the distance. Points without a place have no numbers: those
        at the eye, those behind it that a plane does not show, those beside the disk of a dome.

        Raises
        ------
        StageError
            When the camera does not tell.
        """
        remedy = "give its class a method placed(points_world, size_px)"
        raise StageError(f"camera {self.name!r}", "does not tell where it shows points", remedy)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product of two vectors; NumPy's, for arrays of them, takes ten times as long."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _on_image(camera: Camera, half_height: float, p_px: tuple[float, float], size_px: tuple[int, int]) -> FloatArray:
    """Way (3,) from the middle of the image to one of its points, whose upper left corner is (0, 0)."""
    right, up, _ = camera.basis()
    aside, above = 2 * p_px[0] / size_px[0] - 1, 1 - 2 * p_px[1] / size_px[1]
    return np.asarray(half_height * (aside * size_px[0] / size_px[1] * right + above * up))


def _placed_on_plane(camera: Camera, points_world: FloatArray, size_px: tuple[int, int]) -> FloatArray:
    right, up, forward = camera.basis()
    way = points_world - np.array(camera.eye)
    depth = way @ forward
    at_eye, more = camera.pixel_width(size_px)
    wide = np.where(depth > 0, at_eye + more * depth, np.nan)
    width, height = size_px
    return np.stack([width / 2 + way @ right / wide, height / 2 - way @ up / wide, depth], axis=1)


def point_of(value: Vec3f | FloatArray) -> tuple[float, float, float]:
    """Three numbers as a tuple of floats."""
    if np.shape(value) != (3,):
        raise ValueRangeError("camera", f"got {value!r}", "give three numbers, x, y, z")
    x, y, z = value
    return float(x), float(y), float(z)


def _frame(camera: Camera, half_height: float, size_px: tuple[int, int]) -> CameraFrame:
    right, up, forward = camera.basis()
    half_width = half_height * size_px[0] / size_px[1]
    return CameraFrame(
        eye=camera.eye,
        forward=point_of(forward),
        right=point_of(right * half_width),
        up=point_of(up * half_height),
    )


@register
@dataclass(frozen=True)
class Perspective(Camera):
    """Rays from one point; distance is measured along the ray."""

    name: ClassVar[str] = "perspective"
    wgsl: ClassVar[str] = "camera/perspective.wgsl"
    eye: Vec3f = param((0.0, -4.0, 0.0), unit="world", help="position of the eye")
    target: Vec3f = param((0.0, 0.0, 0.0), unit="world", help="point in the middle of the image")
    up: Vec3f = param((0.0, 0.0, 1.0), unit="1", help="direction that is up in the image")
    fov_deg: F32 = param(30.0, unit="degree", above=0, below=180, help="vertical angle of view")

    def uniforms(self, context: Context) -> CameraFrame:
        """Return the frame for the image's size."""
        return _frame(self, self.half_height, context.size_px)

    def ray(self, p_px: tuple[float, float], size_px: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where the ray of a point of the image begins, and its direction, both (3,) in the world."""
        direction = self.basis()[2] + _on_image(self, self.half_height, p_px, size_px)
        return np.array(self.eye), direction / np.linalg.norm(direction)

    def pixel_width(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Return how wide a pixel is in the middle of the image: at the eye [world], and more per world unit of distance."""
        return 0.0, 2 * self.half_height / size_px[1]

    def placed(self, points_world: FloatArray, size_px: tuple[int, int]) -> FloatArray:
        """Return where points (n, 3) are seen: column, row [px] and depth along the view, (n, 3)."""
        return _placed_on_plane(self, points_world, size_px)

    @property
    def half_height(self) -> float:
        """Half of what the image shows from bottom to top, at a distance of one."""
        return math.tan(math.radians(self.fov_deg) / 2)


@register
@dataclass(frozen=True)
class Orthographic(Camera):
    """Parallel rays; distance is measured from the plane through the eye."""

    name: ClassVar[str] = "orthographic"
    wgsl: ClassVar[str] = "camera/orthographic.wgsl"
    eye: Vec3f = param((0.0, -4.0, 0.0), unit="world", help="point in the plane from which distance is measured")
    target: Vec3f = param((0.0, 0.0, 0.0), unit="world", help="point in the middle of the image")
    up: Vec3f = param((0.0, 0.0, 1.0), unit="1", help="direction that is up in the image")
    height: F32 = param(1.0, unit="world", above=0, help="what the image shows from bottom to top")

    def uniforms(self, context: Context) -> CameraFrame:
        """Return the frame for the image's size."""
        return _frame(self, self.half_height, context.size_px)

    def ray(self, p_px: tuple[float, float], size_px: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where the ray of a point of the image begins, and its direction, both (3,) in the world."""
        return self.eye + _on_image(self, self.half_height, p_px, size_px), self.basis()[2]

    def pixel_width(self, size_px: tuple[int, int]) -> tuple[float, float]:
        """Return how wide a pixel is in the middle of the image: at the eye [world], and more per world unit of distance."""
        return self.height / size_px[1], 0.0

    def placed(self, points_world: FloatArray, size_px: tuple[int, int]) -> FloatArray:
        """Return where points (n, 3) are seen: column, row [px] and depth along the view, (n, 3)."""
        return _placed_on_plane(self, points_world, size_px)

    @property
    def half_height(self) -> float:
        """Half of what the image shows from bottom to top."""
        return self.height / 2


# They are made of the above.
from .camera_round import Dome as Dome  # noqa: E402
from .camera_round import Panorama as Panorama  # noqa: E402
from .camera_stereo import Stereo as Stereo  # noqa: E402
