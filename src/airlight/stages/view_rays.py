"""How rays of an image meet planes: which of them may meet a volume, and how askew they are at most."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..volume import FloatArray
from .camera import Camera, Perspective


def least_cosine(normal: FloatArray, camera: Camera, size_px: tuple[int, int], corners_world: FloatArray) -> float:
    """Least cosine between a unit normal (3,) and the rays of an image that may meet what lies between corners (n, 3).

    Such rays lie between those through the corners of the image, and between those through the corners of what they meet:
    whichever tells more. Not above 0 where rays may run along planes, or pass them in both directions.
    """
    return max(float((ways @ normal).min()) for ways in bounding_rays(camera, size_px, corners_world))


def bounding_rays(camera: Camera, size_px: tuple[int, int], corners_world: FloatArray) -> list[FloatArray]:
    """Sets of directions (n, 3) between which all rays of an image lie that may meet what lies between corners (n, 3)."""
    if not isinstance(camera, Perspective):
        return [camera.basis()[2][None]]
    away = corners_world - np.asarray(camera.eye)
    far = np.linalg.norm(away, axis=1, keepdims=True)
    of_image = np.array([camera.ray(corner, size_px)[1] for corner in product((0.0, size_px[0]), (0.0, size_px[1]))])
    return [of_image, away / far] if far.all() else [of_image]
