"""Turntables: the object turns in front of the eye."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from ..errors import ValueRangeError
from ..first_picture import refitted_camera, resolved_camera
from ..first_picture.survey import survey
from ..first_picture.view import visible_points
from ..light import Light
from ..scene import Layer, Scene
from ..stages.camera import Camera, Orthographic, Perspective, point_of
from ..transfer import TransferFunction
from ..transfer.given import direction, finite, flag, set_fields
from ..volume import FloatArray
from .between import EASINGS, rotation

AXES = ("scene", "view")
Axis = str | tuple[float, float, float]


@dataclass(frozen=True)
class Turntable:
    """The object turns in front of the eye, round an axis through the camera's target.

    What moves is the camera: nothing that depends on the volume alone is computed again.

    Parameters
    ----------
    degrees
        By how much it turns; counterclockwise as seen from above, negative the other way.
    axis
        ``"scene"``: the world's z, superior in anatomy. ``"view"``: what is up in the picture. Or a direction, as x, y, z.
    easing
        ``"linear"``, or ``"smooth"`` to begin and to end at rest.
    lights_stay
        Whether lights stay with the eye, as in front of a real turntable; else they turn with the object.
    """

    degrees: float = 360.0
    axis: Axis = "scene"
    easing: str = "linear"
    lights_stay: bool = True

    def __post_init__(self) -> None:
        """Check the values."""
        set_fields(self, degrees=finite(self.degrees, "turntable.degrees"))
        if isinstance(self.axis, str):
            if self.axis not in AXES:
                raise ValueRangeError("turntable.axis", f"is {self.axis!r}", f"use {', '.join(AXES)} or a direction x, y, z")
        else:
            set_fields(self, axis=direction(self.axis, "turntable.axis"))
        check_easing(self.easing, "turntable.easing")
        set_fields(self, lights_stay=flag(self.lights_stay, "turntable.lights_stay"))

    @property
    def closes(self) -> bool:
        """Whether it ends where it began."""
        return self.degrees != 0 and math.remainder(self.degrees, 360) == 0

    def direction(self, camera: Camera) -> FloatArray:
        """Direction of the axis, of length one, in front of a camera."""
        if isinstance(self.axis, str):
            return camera.basis()[1] if self.axis == "view" else np.array([0.0, 0.0, 1.0])
        return np.array(self.axis)

    def turned(self, scene: Scene, share: float, size_px: tuple[int, int]) -> Scene:
        """Return the scene after a share of the turn, in [0, 1]; the size is that for which a named view is fitted."""
        angle_rad = -math.radians(self.degrees * EASINGS[self.easing](share))  # the eye goes the other way
        camera = resolved_camera(scene, size_px)
        if angle_rad == 0:
            return dataclasses.replace(scene, camera=camera)
        turn = rotation(self.direction(camera), angle_rad)
        middle = np.array(camera.target)
        eye, up = point_of(middle + turn @ (camera.eye - middle)), point_of(turn @ camera.up)
        turned: Camera = dataclasses.replace(camera, eye=eye, up=up)  # type: ignore[type-var]
        scene = dataclasses.replace(scene, camera=turned)
        if not self.lights_stay:
            return scene
        return dataclasses.replace(scene, lights=tuple(_turned_light(light, turn, middle) for light in scene.lights))


def _turned_light(light: Light, turn: FloatArray, middle: FloatArray) -> Light:
    if light.kind == "head":
        return light
    if light.kind == "directional":
        return dataclasses.replace(light, vector=point_of(turn @ light.vector))
    position, beam = point_of(middle + turn @ (light.vector - middle)), light.beam
    if beam is not None:
        target, up = point_of(middle + turn @ (beam.target - middle)), point_of(turn @ beam.up)
        beam = dataclasses.replace(beam, target=target, up=up)
    return dataclasses.replace(light, vector=position, beam=beam)


def check_easing(easing: str, where: str) -> None:
    """Refuse an easing that is none.

    Raises
    ------
    ValueRangeError
        Names those that there are.
    """
    if easing not in EASINGS:
        raise ValueRangeError(where, f"is {easing!r}, must be one of {', '.join(EASINGS)}")


# -- cameras that show all of a turn

DIRECTIONS, HEIGHTS = 24, 64
PARALLEL = 0.99


def with_room_to_turn(scene: Scene, turntable: Turntable, size_px: tuple[int, int]) -> Scene:
    """Return the scene with a camera that looks as its own does, from so far away that all of a whole turn is seen.

    What is seen of a layer with a transfer function of one value follows from the data; of all else, and where the camera is
    the name of a view, it is the box. Cameras of other kinds than perspective and orthographic ones stay.
    """
    camera = resolved_camera(scene, size_px)
    if not isinstance(camera, (Perspective, Orthographic)):
        return scene
    clouds = [_seen_of(layer, whole=isinstance(scene.camera, str)) for layer in scene.visible_layers or scene.layers]
    points = np.concatenate([*clouds, *(shape.corners_world for shape in scene.meshes)])
    axis = turntable.direction(camera)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    swept = _swept(points - middle, axis) + middle
    fitted = refitted_camera(dataclasses.replace(scene, camera=camera), swept, size_px)
    assert isinstance(fitted, Perspective)
    target = _on_axis(fitted, middle, axis)
    if isinstance(camera, Orthographic):
        height = 2 * math.dist(fitted.eye, fitted.target) * fitted.half_height
        turning: Camera = dataclasses.replace(camera, eye=fitted.eye, target=target, up=fitted.up, height=height)
    else:
        turning = dataclasses.replace(fitted, target=target)
    return dataclasses.replace(scene, camera=turning)


def _on_axis(camera: Camera, middle: FloatArray, axis: FloatArray) -> tuple[float, float, float]:
    """Where the line of view passes the axis through the middle, which is what the camera turns about; else its target."""
    forward = camera.basis()[2]
    if abs(forward @ axis) > PARALLEL:
        return camera.target
    along, _ = np.linalg.lstsq(np.stack([forward, -axis], axis=1), middle - camera.eye, rcond=None)[0]
    return point_of(camera.eye + along * forward) if along > 0 else camera.target


def _seen_of(layer: Layer, whole: bool) -> FloatArray:
    """World points (n, 3) round what is seen of a layer."""
    if whole or not isinstance(layer.transfer, TransferFunction) or layer.labels is not None:
        return layer.volume.corners_world(cells=getattr(layer.look.field, "cells", False))
    return visible_points(layer.volume, layer.transfer, survey(layer.volume, layer.channel, layer.time))


def _swept(points: FloatArray, axis: FloatArray) -> FloatArray:
    """Points (n, 3) round all that points pass as they turn about an axis through 0: rings, by height."""
    above = points @ axis
    away = np.linalg.norm(points - above[:, None] * axis, axis=1)
    edges = np.linspace(above.min(), above.max(), HEIGHTS + 1)
    bins = np.clip(np.searchsorted(edges, above, side="right") - 1, 0, HEIGHTS - 1)
    radii = np.zeros(HEIGHTS)
    np.maximum.at(radii, bins, away)
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    angles_rad = 2 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    circle = np.cos(angles_rad)[:, None] * across + np.sin(angles_rad)[:, None] * np.cross(axis, across)
    rings = [radii[:, None, None] * circle + edge[:, None, None] * axis for edge in (edges[:-1], edges[1:])]
    return np.concatenate(rings).reshape(-1, 3)
