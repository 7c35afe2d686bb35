"""A studio: three soft boxes in a grey room, placed for the view ``front``.

The key light stands high on the viewer's left, a large fill light on the right, and a narrow rim light behind, above the
picture. A white surface that faces the key light is about white.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..volume import FloatArray
from .sphere import averaged

EDGE = 0.08  # of a box, over which it fades, as a tangent
FLOOR, HORIZON, CEILING = 0.05, 0.16, 0.10  # radiance of the room


@dataclass(frozen=True)
class SoftBox:
    """A shining rectangle: direction of its middle, half its width and height as tangents, radiance."""

    to_box: tuple[float, float, float]
    half_size: tuple[float, float]
    radiance: float

    def __call__(self, directions: FloatArray) -> FloatArray:
        """Radiance (...) at directions (..., 3)."""
        forward = np.array(self.to_box) / np.linalg.norm(self.to_box)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        depth = directions @ forward
        inside = np.where(depth > 0, self.radiance, 0.0)
        for axis, half in zip((right, up), self.half_size, strict=True):
            aside = np.abs(directions @ axis) / np.maximum(depth, 1e-6)
            inside = inside * np.clip((half + EDGE / 2 - aside) / EDGE, 0.0, 1.0)
        return np.asarray(inside)


KEY = SoftBox((-0.75, -0.75, 0.75), (0.55, 0.55), 3.0)
FILL = SoftBox((0.95, -0.5, 0.1), (0.6, 0.8), 0.45)
RIM = SoftBox((0.55, 0.6, 0.75), (0.7, 0.2), 4.0)


def picture(key: float, fill: float, rim: float, room: float, rows: int) -> npt.NDArray[np.float32]:
    """Radiance, float32 (rows, 2 rows, 3); the numbers are factors of the lights and of the room's own grey."""

    def radiance(directions: FloatArray) -> FloatArray:
        z = directions[..., 2]
        grey = HORIZON + np.where(z > 0, z * (CEILING - HORIZON), -z * (FLOOR - HORIZON))
        bright = room * grey + key * KEY(directions) + fill * FILL(directions) + rim * RIM(directions)
        return np.asarray(bright)[..., None]

    return np.repeat(averaged(radiance, rows).astype(np.float32), 3, axis=-1)
