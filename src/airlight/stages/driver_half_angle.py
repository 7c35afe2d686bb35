"""Half-angle slicing: a driver whose slices suit the eye and a light alike, so that light passes through the volume with them.

Kniss, Kindlmann and Hansen 2002; Engel and Ertl, section 5.4. See ``docs/decisions/0042``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..stage import Context, make_stage, register, value
from ..transfer.given import not_negative, set_fields, whole
from ..volume import FloatArray
from .camera import Camera, Orthographic
from .driver import Driver
from .driver_slices import MOST_GROUP, Planes, SliceDriver
from .transport import Opaque, Transport

LEAST_LIGHT, MOST_LIGHT = 16, 2048
MOST_BIAS = 8.0
MOST_TEXELS = 1 << 24  # in which light is kept, of 8 bytes each
LEAST_COSINE = 0.1  # between a ray that meets the volume and the axis of the slices


@register
@dataclass(frozen=True)
class HalfAngle(Driver):
    """Slices halfway between the eye and each light, which dims from slice to slice: shadows in one sweep a light.

    The lights of the scene cast shadows by colour, each with a sweep of its own. Slices are a step apart along the view.
    """

    name: ClassVar[str] = "half_angle"
    wgsl: ClassVar[str] = "slices.wgsl"
    throws_pictures: ClassVar[bool] = True
    adds_lights: ClassVar[bool] = True
    light_size: int = value(320, at_least=LEAST_LIGHT, up_to=MOST_LIGHT, help="texels of a side of a light's buffer")
    group: int = value(
        512, at_least=1, up_to=MOST_GROUP, help="slices that are drawn in one pass, behind one of the light, as memory allows"
    )
    bias: float = value(
        1.0,
        at_least=0,
        up_to=MOST_BIAS,
        help="slices towards a light at which one looks for what arrives: surfaces do not hide themselves",
    )
    transport: Transport = value(Opaque(), help="what becomes of light on its way: a stage of the slot transport, or its name")

    def __post_init__(self) -> None:
        """Check the parameters; a name becomes its stage."""
        super().__post_init__()
        whole(self.light_size, "driver.half_angle.light_size", LEAST_LIGHT, MOST_LIGHT)
        whole(self.group, "driver.half_angle.group", 1, MOST_GROUP)
        bias = not_negative(self.bias, "driver.half_angle.bias")
        if bias > MOST_BIAS:
            raise ValueRangeError("driver.half_angle.bias", f"is {bias:g}, must lie in [0, {MOST_BIAS:g}] slices")
        set_fields(self, bias=bias, transport=make_stage("transport", self.transport, "driver.half_angle.transport"))

    @property
    def slices_at_once(self) -> int:
        """Slices of a group, as many as the transport and the memory for light allow."""
        texels = MOST_TEXELS // self.light_size**2
        room = 3 * texels if getattr(self.transport, "is_grey", False) else texels - 1
        return min(self.group, room, getattr(self.transport, "most_slices", self.group))


@dataclass(frozen=True)
class HalfAngleSweep(SliceDriver):
    """The sweep of one light: slices at planes that are told."""

    name: ClassVar[str] = "half_angle"
    adds_lights: ClassVar[bool] = True
    given: Planes | None = value(None, help="where the slices lie")

    def planes(self, camera: Camera, context: Context) -> Planes | None:
        """Return the planes."""
        return self.given


def half_angle(to_light: FloatArray, to_eye: FloatArray) -> tuple[FloatArray, bool]:
    """Axis (3,) of slices that rays of the eye pass in this direction, and whether light passes them in the other one.

    Light runs away from where it comes from. Where the angle between the two ways is a right one or less, so does the eye;
    beyond that slices are drawn from the farthest to the nearest.
    """
    is_opposite = bool(to_light @ to_eye < 0)
    axis = to_light - to_eye if is_opposite else -(to_light + to_eye)
    return axis / np.linalg.norm(axis), is_opposite


def half_angle_planes(
    to_light: FloatArray, to_eye: FloatArray, middle_world: FloatArray, step_world: float
) -> tuple[Planes, bool]:
    """Planes through the middle of a volume that are a step apart along the view, and whether light passes them backwards."""
    normal, is_opposite = half_angle(to_light, to_eye)
    return Planes(normal, float(normal @ middle_world), step_world * abs(float(normal @ to_eye))), is_opposite


def ways_from(place: Camera | FloatArray, points_world: FloatArray) -> FloatArray:
    """Directions (n, 3) of rays through points: of a camera, from a point (3,), or along a direction (1, 3)."""
    if isinstance(place, Camera):
        place = place.basis()[2][None] if isinstance(place, Orthographic) else np.asarray(place.eye)
    if place.ndim == 2:
        return np.broadcast_to(place, points_world.shape)
    ways = points_world - place
    return np.asarray(ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-300))


def near_light(number: int) -> ValueRangeError:
    """Return the error of a light that is in the volume or beside it."""
    what = "lies in the volume, or so near to it that its rays run along the slices of the driver 'half_angle'"
    return ValueRangeError(f"scene.lights[{number}]", what, 'move it away, or use driver="march"')


def check_ways(planes: Planes, eye_cosine: float, light_cosine: float, number: int) -> None:
    """Refuse rays that do not all pass planes in one direction, by the least cosine between them and the normal.

    Light has the planes' direction here.

    Raises
    ------
    ValueRangeError
        For an eye among the slices, and for a light that is in the volume or too near to it.
    """
    if light_cosine < LEAST_COSINE:
        raise near_light(number)
    if eye_cosine < LEAST_COSINE:
        what = f"is among the slices of the driver 'half_angle' for scene.lights[{number}]"
        raise ValueRangeError("camera", what, 'move the eye away, take a smaller angle of view, or use driver="march"')
