"""Shadows as the driver ``half_angle`` draws them: what comes through from each light to a place, by a ray of its own.

Light at a place is the product over the slabs on its way; colours of coloured media are let through as their transport says.
Scattered light of translucent media is here what the driver converges to where it spreads not at all, cone 0, or along media
that are the same to all sides: see ``translucent``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..environment import Environment
from ..errors import DataError
from ..scene import Light, Scene, fit_camera
from ..stages.camera import Camera
from ..stages.driver_half_angle import HalfAngle, HalfAngleSweep, half_angle_planes
from ..stages.driver_slices import Planes
from ..stages.lighting import Unlit
from ..stages.tone import Linear
from ..volume import FloatArray
from .integrate import INTEGRATES, Accumulated, Integrate
from .march import march
from .setup import BoolArray, IntArray, Setup, Slab
from .shade import VISIBILITIES
from .tone import TONES

FAINT = 1e-9


@dataclass(frozen=True)
class Shadowed:
    """What stands in the slot visibility of one sweep: how light gets through, and whether ambient light counts."""

    transport: Any
    ambient: bool
    step_world: float
    planes: Planes
    bias: float = 0.0
    name: str = "half_angle"


def shadowed(setup: Setup, light_index: int | None, p_world: FloatArray) -> FloatArray:
    """Share (n, 3) of a light that comes through to points; of ambient light all of it in one sweep, nothing in the others."""
    stage = setup.stages["visibility"]
    if light_index is None:
        return np.full_like(p_world, float(stage.ambient))
    lamp = setup.lights[light_index]
    # Look as many slices towards the light as is told.
    way = to_light(setup, lamp, p_world)
    nearer = p_world + (stage.bias * stage.planes.spacing_world / np.abs(way @ stage.planes.normal))[:, None] * way
    return thrown(lamp, p_world) * transmittance(setup, lamp, nearer, stage.transport, stage.step_world)


def transmittance(setup: Setup, lamp: Light, p_world: FloatArray, transport: Any, step_world: float) -> FloatArray:
    """Share (n, 3) of light that comes through from outside to points, by slabs of this length."""
    stages = {**setup.stages, "integrate": Way(transport), "lighting": Unlit()}
    return march(replace(setup, stages=stages), p_world, to_light(setup, lamp, p_world), step_world, curved=False).rgb


def to_light(setup: Setup, lamp: Light, p_world: FloatArray) -> FloatArray:
    """Directions (n, 3) from points to a light; a head light is where the eye is."""
    if lamp.kind == "directional":
        return np.broadcast_to(np.array(lamp.vector), p_world.shape)
    if lamp.kind == "head" and setup.camera.name == "orthographic":
        return np.broadcast_to(-setup.camera.basis()[2], p_world.shape)
    way = np.array(setup.camera.eye if lamp.kind == "head" else lamp.vector) - p_world
    return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True))


def thrown(lamp: Light, p_world: FloatArray) -> FloatArray:
    """Factors (n, 3) of a light by the picture that it throws; 1 where it throws none."""
    if lamp.beam is None:
        return np.ones_like(p_world)
    pixels, forward = lamp.beam.picture.pixels.astype(np.float64), np.subtract(lamp.beam.target, lamp.vector)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, lamp.beam.up)
    right /= np.linalg.norm(right)
    way, half = p_world - np.array(lamp.vector), np.tan(np.radians(lamp.beam.angle_deg) / 2)
    ahead = way @ forward
    depth = half * np.where(ahead > 0, ahead, 1.0)
    x, y = way @ right / (depth * lamp.beam.picture.aspect), -(way @ np.cross(right, forward)) / depth
    inside = (ahead > 0) & (np.abs(x) <= 1) & (np.abs(y) <= 1)
    height, width = pixels.shape[:2]
    column, row = (np.clip((c + 1) / 2 * n - 0.5, 0, n - 1) for c, n in ((x, width), (y, height)))
    left, top = (np.clip(np.floor(c).astype(np.int64), 0, max(n - 2, 0)) for c, n in ((column, width), (row, height)))
    u, v = (column - left)[:, None], (row - top)[:, None]
    next_x, next_y = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    upper = (1 - u) * pixels[top, left] + u * pixels[top, next_x]
    lower = (1 - u) * pixels[next_y, left] + u * pixels[next_y, next_x]
    return np.where(inside[:, None], (1 - v) * upper + v * lower, 0.0)


# -- transport: ``passes(stage, rgb (n, 3), alpha (n,)) -> (n, 3)``, what slabs of a colour and an opacity let through


def opaque(stage: Any, rgb: FloatArray, alpha: FloatArray) -> FloatArray:
    """As much of all colours as the eye gets."""
    return np.repeat((1 - alpha)[:, None], 3, axis=1)


def coloured(stage: Any, rgb: FloatArray, alpha: FloatArray) -> FloatArray:
    """More of the slab's own colour: extinction times ``1 - tint * colour``."""
    return by_colour(stage.tint, rgb, alpha)


def translucent(stage: Any, rgb: FloatArray, alpha: FloatArray) -> FloatArray:
    """All light, direct and scattered, where as much goes aside as comes from there: only what is not scattered is lost."""
    return by_colour(stage.scatter, rgb, alpha)


@np.errstate(under="ignore")
def by_colour(share: float, rgb: FloatArray, alpha: FloatArray) -> FloatArray:
    """Transmittance to the power of ``1 - share * colour``."""
    colour = np.clip(rgb / np.maximum(alpha, 1e-12)[:, None], 0.0, 1.0)
    return np.asarray((1 - alpha)[:, None] ** (1 - share * colour))


TRANSPORTS: dict[str, Callable[[Any, FloatArray, FloatArray], FloatArray]] = {
    "opaque": opaque,
    "coloured": coloured,
    "translucent": translucent,
}


@dataclass(frozen=True)
class Way:
    """What stands in the slot integrate of rays towards a light."""

    transport: Any
    name: str = "way_to_light"


class WayToLight(Integrate):
    """The product of what slabs let through, by colour."""

    uses_slabs = True

    def begin(self, n: int) -> Accumulated:
        """Return light that has passed nothing."""
        return replace(super().begin(n), rgb=np.ones((n, 3)))

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Let light through the slab."""
        transport = self.stage.transport
        acc.rgb[rays] *= TRANSPORTS[transport.name](transport, slab.rgb, slab.alpha)
        return np.asarray((acc.rgb[rays] <= FAINT).all(axis=1))


VISIBILITIES["half_angle"] = shadowed
INTEGRATES["way_to_light"] = WayToLight


# -- sweeps


def render(
    scene: Scene,
    size: tuple[int, int],
    driver: HalfAngle,
    *,
    step: float = 1.0,
    light_step: float = 0.25,
    pixels: npt.ArrayLike | None = None,
) -> Any:
    """Render a scene of one layer with the shadows of its lights, one sweep a light.

    Parameters
    ----------
    scene, size, pixels
        As for ``reference.render``.
    driver
        Tells how light gets through.
    step
        Distance of samples along the view, in units of the smallest voxel spacing.
    light_step
        Length of the slabs on the way to a light, in the same unit.

    Returns
    -------
    ReferenceImage

    Raises
    ------
    DataError
        For several layers, and an environment behind them.
    """
    from . import ReferenceImage, _image, prepare

    if isinstance(scene.background, Environment):
        raise DataError("scene.background", "is an environment, and shadows are known without", "use a colour")
    setup = prepare(scene)
    camera, tone = camera_of(scene, setup, size), setup.stages["tone"]
    plain = replace(setup, stages={**setup.stages, "tone": Linear()})
    sweeps = []
    for number in range(len(scene.lights)):
        seen, planes = sweep_of(plain, camera, number, driver, step * setup.finest_world, light_step * setup.finest_world)
        sweep = HalfAngleSweep(given=planes, curved=driver.curved)
        sweeps.append(_image(replace(scene, camera=camera), (seen,), size, step, pixels, curved=driver.curved, driver=sweep))
    rgba = np.concatenate([sum(sweep.rgba[..., :3] for sweep in sweeps), sweeps[0].rgba[..., 3:]], axis=-1)
    return ReferenceImage(TONES[tone.name](tone, rgba), sweeps[0].depth)


def camera_of(scene: Scene, setup: Setup, size: tuple[int, int]) -> Camera:
    """Camera of a scene; a named view is fitted to the layer."""
    if not isinstance(scene.camera, str):
        return scene.camera
    return fit_camera(scene.camera, corners_of(setup), aspect=size[0] / size[1])


def corners_of(setup: Setup) -> FloatArray:
    """Corners (8, 3) of a layer's domain in the world."""
    return setup.layer.volume.corners_world(bool(getattr(setup.stages["field"], "cells", False)))


def sweep_of(
    setup: Setup, camera: Camera, number: int, driver: HalfAngle, step_world: float, light_step_world: float
) -> tuple[Setup, Planes]:
    """What one light's sweep sees, and the planes on which its samples lie."""
    middle, seen = corners_of(setup).mean(axis=0), replace(setup, camera=camera)
    eye, light = (to_light(seen, lamp, middle[None])[0] for lamp in (Light.head(), setup.lights[number]))
    planes, _ = half_angle_planes(light, eye, middle, step_world)
    stages = {**setup.stages, "visibility": Shadowed(driver.transport, number == 0, light_step_world, planes, driver.bias)}
    return replace(seen, lights=(setup.lights[number],), stages=stages), planes
