"""Fields over layers of 2-D textures along one axis of the grid: what drivers of object-aligned slices read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError
from ..stage import U32, ClassifiedGrid, Context, Resource, Stack, Stage, param, register, static
from ..volume import Volume, domain_index
from .camera import Camera, point_of
from .field import Field, Linear, LinearExact, PreClassified
from .field_channels import ChannelsUniforms, OfChannels, channels_values
from .view_rays import bounding_rays

AXES = ("x", "y", "z")
AXIS_CHOICES = ("auto", *AXES)
AXIS_HELP = "axis of the grid along which layers lie; auto: the one that the view runs along most"


@dataclass(frozen=True)
class StackUniforms:
    """The axis along which layers lie."""

    axis: U32 = param(2)


@dataclass(frozen=True, eq=False)
class StackChannelsUniforms(ChannelsUniforms):
    """The same beside what fields of several channels have."""

    axis: U32 = param(2)


class OfStack(Field):
    """Base of the fields over layers: it has the stack of the frame's axis alone on the device."""

    uniform_type: ClassVar[type | None] = StackUniforms
    axis: str

    def chosen_axis(self, context: Context) -> int:
        """Return the number of the axis along which layers lie in this frame."""
        if self.axis != "auto":
            return AXES.index(self.axis)
        return 2 if context.camera is None else facing_layers(context.volume, context.camera, context.size_px)[0]

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the stack of the layer's channels and time step."""
        axis = self.chosen_axis(context)
        return {"grid": Stack(context.volume, context.channels, context.time, self.filtered, self.masked, axis=axis)}

    def uniforms(self, context: Context) -> Any:
        """Return the axis."""
        return StackUniforms(self.chosen_axis(context))

    def for_empty(self) -> Field:
        """Return the field over marked samples."""
        return StackMasked(axis=self.axis)

    def for_channels(self) -> Field:
        """Return the field of several channels."""
        return StackChannels(axis=self.axis)


@register
@dataclass(frozen=True)
class LinearStack(OfStack, Linear):
    """Linear interpolation in layers of 2-D textures: bilinear in a layer by the texture unit, and between two of them.

    Engel and Ertl, section 4 and figure 15. It gives what ``linear`` gives; drivers of object-aligned slices put it in the
    place of that, and there is little reason to choose it by oneself. Without ``between`` a place has the value that the
    nearest layer has there, by one fetch. For each axis that has been needed a stack is on the device, as large as the volume.
    """

    name: ClassVar[str] = "stack"
    wgsl: ClassVar[str] = "field/stack.wgsl"
    axis: str = static("auto", choices=AXIS_CHOICES, help=AXIS_HELP)
    between: bool = static(True, help="interpolate between layers, by a second fetch")

    def converging(self) -> Field:
        """Return the field whose weights are exact."""
        return StackExact(axis=self.axis)


@dataclass(frozen=True)
class StackExact(OfStack, LinearExact):
    """Linear interpolation in layers in the shader, in full precision."""

    name: ClassVar[str] = "stack_exact"
    axis: str = static("auto", choices=AXIS_CHOICES, help=AXIS_HELP)


@dataclass(frozen=True)
class StackMasked(StackExact):
    """The same of the samples that are there; empty where less than half of the weight is."""

    name: ClassVar[str] = "stack_masked"
    masked = True


@dataclass(frozen=True)
class StackChannels(OfStack, OfChannels, LinearExact):
    """Linear interpolation in layers of several channels."""

    name: ClassVar[str] = "stack_channels"
    uniform_type: ClassVar[type] = StackChannelsUniforms
    axis: str = static("auto", choices=AXIS_CHOICES, help=AXIS_HELP)

    def uniforms(self, context: Context) -> Any:
        """Return the places of the groups, the lines of their channels, and the axis."""
        return StackChannelsUniforms(**channels_values(context), axis=self.chosen_axis(context))

    def for_empty(self) -> Field:
        """Return the field over marked samples."""
        return StackChannelsMasked(axis=self.axis)


@dataclass(frozen=True)
class StackChannelsMasked(StackChannels):
    """The same of the samples that are there, channel by channel."""

    name: ClassVar[str] = "stack_channels_masked"
    masked = True


@dataclass(frozen=True)
class PreClassifiedStack(OfStack, PreClassified):
    """Media of the voxels, interpolated in layers."""

    name: ClassVar[str] = "preclassified_stack"
    wgsl: ClassVar[str] = "field/preclassified_stack.wgsl"
    axis: str = static("auto", choices=AXIS_CHOICES, help=AXIS_HELP)
    between: bool = static(True, help="interpolate between layers, by a second fetch")

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples and their media, in layers.

        Raises
        ------
        StageError
            When the layer's function is not one of a single value, or has surfaces.
        """
        classified = PreClassified.resources(self, context)["classified"]
        stack = OfStack.resources(self, context)["grid"]
        assert isinstance(classified, ClassifiedGrid)
        assert isinstance(stack, Stack)
        return {"grid": stack, "classified": replace(classified, grid=stack, field=StackVoxels(axis=self.axis))}

    def for_empty(self) -> Field:
        """Refuse marked samples."""
        return Field.for_empty(self)

    def for_channels(self) -> Field:
        """Refuse several channels."""
        return Field.for_channels(self)


@dataclass(frozen=True)
class StackVoxels(StackExact):
    """Reader of single voxels from the layers that fields filter."""

    name: ClassVar[str] = "stack_voxels"
    filtered: ClassVar[bool] = True


def stacked(field: Stage, driver: str, axis: str = "auto", between: bool = True) -> Field:
    """Return the field over layers in the place of a field over a grid.

    Raises
    ------
    StageError
        For a field that is not trilinear interpolation of the samples.
    """
    if isinstance(field, OfStack):
        return field
    if type(field) is Linear:
        return LinearStack(axis=axis, between=between)
    if type(field) is LinearExact:
        return StackExact(axis=axis)
    if type(field) is PreClassified:
        return PreClassifiedStack(field.weighted, axis=axis, between=between)
    what = f"reads layers of 2-D textures, between which it interpolates, and the field is {field.name}"
    raise StageError(f"driver {driver!r}", what, "use the field linear, linear_exact or preclassified, or the driver slices")


def facing_layers(volume: Volume, camera: Camera, size_px: tuple[int, int]) -> tuple[int, float]:
    """Axis whose layers are most perpendicular to the view, and 1 or -1: whether rays pass them as they are counted.

    It is the one to whose layers the most oblique ray of the image that may meet the volume is least oblique (Engel and Ertl,
    figure 12).
    """
    place = {name: point_of(getattr(camera, name)) for name in ("eye", "target", "up")}
    hashable: Camera = replace(camera, **place)  # type: ignore[type-var]
    return _facing_layers(volume.world_from_index.tobytes(), volume.size, hashable, size_px)


@lru_cache(maxsize=64)
def _facing_layers(
    world_from_index: bytes, size: tuple[int, int, int], camera: Camera, size_px: tuple[int, int]
) -> tuple[int, float]:
    matrix = np.frombuffer(world_from_index).reshape(4, 4)
    low, high = domain_index(size, cells=True)
    corners = np.array(list(product(*zip(low, high, strict=True)))) @ matrix[:3, :3].T + matrix[:3, 3]
    rows = np.linalg.inv(matrix)[:3, :3]
    normals = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    ways = bounding_rays(camera, size_px, corners)
    cosines = [max(float((rays @ (way * normal)).min()) for rays in ways) for way in (1, -1) for normal in normals]
    best = int(np.argmax(cosines))
    return best % 3, 1.0 if best < 3 else -1.0
