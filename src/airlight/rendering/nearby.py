"""The device's world: moved so that the volume is near its origin and the eye near the volume.

32-bit floats hold seven digits. A survey in metres from the equator, or parallel rays from far away, would lose the samples
along a ray in them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import ValueRangeError
from ..scene import Light
from ..stages.camera import Camera, Orthographic
from ..volume import FloatArray, Volume, domain_index
from .resources import DrawnLayer

FAR_AWAY = 100.0  # times the reach of a volume
MOST_STEPS_AWAY = 1 << 18


def chosen_anchor(layer: DrawnLayer) -> FloatArray:
    """Origin of the device's world: that of the user's, or the middle of a volume that lies far from it."""
    corners = layer.context.volume.corners_world()
    middle = corners.mean(axis=0)
    reach = float(np.linalg.norm(corners - middle, axis=1).max()) + layer.context.step_world
    far = float(np.linalg.norm(middle)) > FAR_AWAY * reach
    return middle if far else np.zeros(3)


def near_camera(
    camera: Camera, anchor_world: FloatArray, layer: DrawnLayer, step_world: float, others: Sequence[FloatArray] = ()
) -> tuple[Camera, float]:
    """Camera in the device's world, and the distance by which its rays begin later than at the eye.

    Parallel rays begin a whole number of steps later, in front of the volume and the ``others``, points (n, 3), so that samples
    stay where they are.

    Raises
    ------
    ValueRangeError
        When the eye of rays that are not parallel is so far away that samples cannot be told apart in 32 bits.
    """
    volume, cells = layer.context.volume, layer.field.cells
    _, _, forward = camera.basis()
    eye, target = np.asarray(camera.eye), np.asarray(camera.target)
    if isinstance(camera, Orthographic):
        corners = np.concatenate([volume.corners_world(cells), *others])
        nearest = float(((corners - eye) @ forward).min())
    else:
        nearest = float(np.linalg.norm(_nearest_point(volume, eye, cells) - eye))
    steps = int(nearest / step_world) - 1
    if steps > MOST_STEPS_AWAY and not isinstance(camera, Orthographic):
        raise ValueRangeError(
            "camera",
            f"is {steps:,} steps away from the volume, at most {MOST_STEPS_AWAY:,} are told apart",
            "use Camera.orthographic",
        )
    t_offset_world = steps * step_world if isinstance(camera, Orthographic) and steps > 0 else 0.0
    moved: Camera = replace(
        camera,  # type: ignore[type-var]
        eye=shifted(eye + t_offset_world * forward, anchor_world),
        target=shifted(target + t_offset_world * forward, anchor_world),
    )
    return moved, t_offset_world


def _nearest_point(volume: Volume, p_world: FloatArray, cells: bool) -> FloatArray:
    """Point of a volume's domain that is nearest to a point, in its index coordinates."""
    low, high = domain_index(volume.size, cells)
    inwards, outwards = volume.index_from_world, volume.world_from_index
    p_index = np.clip(inwards[:3, :3] @ p_world + inwards[:3, 3], low, high)
    return np.asarray(outwards[:3, :3] @ p_index + outwards[:3, 3])


def shifted(point: Any, anchor_world: FloatArray) -> tuple[float, float, float]:
    """Point in the device's world."""
    x, y, z = np.asarray(point, dtype=np.float64) - anchor_world
    return float(x), float(y), float(z)


def shifted_lights(lights: tuple[Light, ...], anchor_world: FloatArray) -> tuple[Light, ...]:
    """Lights in the device's world; only point and spot lights have a place."""
    return tuple(_shifted_light(light, anchor_world) for light in lights)


def _shifted_light(light: Light, anchor_world: FloatArray) -> Light:
    if light.kind not in ("point", "spot"):
        return light
    beam = None if light.beam is None else replace(light.beam, target=shifted(light.beam.target, anchor_world))
    return replace(light, vector=shifted(light.vector, anchor_world), beam=beam)
