"""Fields over layers of 2-D textures along one axis of the grid: what drivers of object-aligned slices read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from itertools import product
from typing import Any, ClassVar

import numpy as np

from ..stage import ClassifiedGrid, Context, Grid, Resource, Stack, Stage, register, static, value
from ..volume import Volume, domain_index
from .camera import Camera, point_of
from .field import Field, Linear
from .view_rays import bounding_rays

AXES = ("x", "y", "z")
AXIS_CHOICES = ("auto", *AXES)
AXIS_HELP = "axis of the grid along which layers lie; auto: the one that the view runs along most"
BETWEEN_HELP = "interpolate between layers, by a second fetch"


@dataclass(frozen=True, kw_only=True)
class InLayers(Field):
    """What makes a field one over layers: it has the stack of the frame's axis alone on the device, in the place of its grid.

    ``in_layers`` adds it to any field whose device half reads the grid through ``slot::voxels``. Without ``between`` what the
    texture unit interpolates is that of the nearest layer.
    """

    axis: str = value("auto", help=AXIS_HELP)
    between: bool = value(True, help=BETWEEN_HELP)

    def chosen_axis(self, context: Context) -> int:
        """Return the number of the axis along which layers lie in this frame."""
        if self.axis != "auto":
            return AXES.index(self.axis)
        return 2 if context.camera is None else facing_layers(context.volume, context.camera, context.size_px)[0]

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return those of the field, with the stack in the place of the grid, also where tables are made of its voxels."""
        found = dict(super().resources(context))
        grid = found.get("grid")
        if isinstance(grid, Grid):
            axis = self.chosen_axis(context)
            stack = Stack(**{one.name: getattr(grid, one.name) for one in fields(Grid)}, axis=axis)
            found["grid"] = stack
            for name, made in found.items():
                if isinstance(made, ClassifiedGrid) and made.grid == grid and isinstance(made.field, Field):
                    found[name] = replace(made, grid=stack, field=in_layers(made.field, AXES[axis]))
        return found

    def variant(self, context: Context) -> dict[str, bool]:
        """Return how voxels are read."""
        return {**super().variant(context), "between": self.between}

    def for_empty(self) -> Field:
        """Return the field over marked samples, in layers."""
        return in_layers(super().for_empty(), self.axis, self.between)

    def for_channels(self) -> Field:
        """Return the field of several channels, in layers."""
        return in_layers(super().for_channels(), self.axis, self.between)

    def converging(self) -> Field:
        """Return the field for pictures of a known error, in layers."""
        found: Stage = super().converging()
        assert isinstance(found, Field)
        return in_layers(found, self.axis, self.between)


@register
@dataclass(frozen=True)
class LinearStack(InLayers, Linear):
    """Linear interpolation in layers of 2-D textures: bilinear in a layer by the texture unit, and between two of them.

    Engel and Ertl, section 4 and figure 15. It gives what ``linear`` gives; drivers of object-aligned slices read every field
    in layers by themselves, and there is little reason to choose it. Without ``between`` a place has the value that the
    nearest layer has there, by one fetch. For each axis that has been needed a stack is on the device, as large as the volume.
    """

    name: ClassVar[str] = "stack"
    axis: str = static("auto", choices=AXIS_CHOICES, help=AXIS_HELP)
    between: bool = static(True, help=BETWEEN_HELP)


def in_layers(field: Field, axis: str = "auto", between: bool = True) -> Field:
    """Return a field over layers in the place of one over a grid: the same one, of the same name.

    Parameters
    ----------
    field
        Any field; one that reads layers already comes back as it is.
    axis
        Along which layers lie; ``auto``: the one that the view runs along most.
    between
        False where samples lie on layers: fields that look there alone take one fetch.
    """
    if isinstance(field, InLayers):
        return field
    kind: Any = type(field)
    given = {one.name: getattr(field, one.name) for one in fields(kind) if one.init}
    made: Field = _over_layers(kind)(**given, axis=axis, between=between or not field.looks_there_alone)
    return made


@lru_cache(maxsize=256)
def _over_layers(kind: type[Field]) -> Any:
    """Class of the fields of a kind over layers."""
    told = {"__doc__": kind.__doc__, "__module__": kind.__module__}
    return dataclass(frozen=True)(type(kind.__name__, (InLayers, kind), told))


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
