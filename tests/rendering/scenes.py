"""Small scenes that the tests of rendering share."""

from __future__ import annotations

from functools import cache

import numpy as np

import airlight as al

SIZE = (48, 40)


@cache
def blobs(dtype: str = "float32") -> al.Volume:
    """A smooth field without symmetry on an anisotropic grid that is turned in the world."""
    z, y, x = np.mgrid[-1:1:40j, -1:1:36j, -1:1:32j]
    field = np.exp(-2 * (x * x + 1.5 * y * y + z * z)) * 100 + 10 * np.sin(5 * x) * np.cos(4 * y) + 20
    turn = rotation((1, 2, 3), 0.4)
    matrix = np.eye(4)
    matrix[:3, :3] = turn * (1.0, 1.2, 0.9)
    matrix[:3, 3] = (5, -3, 2)
    return al.Volume(field.astype(dtype), world_from_index=matrix)


@cache
def function() -> al.TransferFunction:
    return al.TransferFunction(
        [(40, (1, 0.2, 0.1), 0), (60, (0.2, 1, 0.3), 0.3), (80, (0.2, 0.3, 1), 0.05), (110, (1, 1, 1), 1.5)]
    )


def rotation(axis, angle_rad: float) -> np.ndarray:
    """Rotation matrix by Rodrigues' formula."""
    a = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle_rad) * k + (1 - np.cos(angle_rad)) * (k @ k)


def cameras(volume: al.Volume) -> dict[str, al.Camera]:
    """Outside and inside, perspective and orthographic."""
    corners = volume.corners_world()
    middle = corners.mean(axis=0)
    reach = np.linalg.norm(corners - middle, axis=1).max()
    away = np.array([0.5, -0.7, 0.4]) * reach
    target = tuple(middle)
    return {
        "perspective": al.fit_camera("iso", corners, SIZE[0] / SIZE[1]),
        "orthographic": al.Camera.orthographic(eye=tuple(middle + 2 * away), target=target, height=1.6 * reach),
        "inside": al.Camera.perspective(eye=tuple(middle + 0.2 * away), target=target, fov_deg=80),
        "cut": al.Camera.orthographic(eye=tuple(middle + 0.1 * away), target=target, height=1.6 * reach),
    }


def lights() -> list[al.Light]:
    return [
        al.Light.head(intensity=0.6),
        al.Light.directional(to_light=(1, -1, 1), color=(1, 0.8, 0.6), intensity=0.5),
        al.Light.point(position=(50, -40, 60), radius=50),
    ]


def scene(volume: al.Volume | None = None, camera: str = "perspective", **look) -> al.Scene:
    volume = volume or blobs()
    return al.Scene(
        volume, transfer=function(), camera=cameras(volume)[camera], look=al.Look(**look), lights=lights(), background=None
    )
