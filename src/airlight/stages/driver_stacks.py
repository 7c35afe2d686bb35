"""Drivers of slices over stacks of 2-D textures: object-aligned, interpolated, and stripes.

Engel and Ertl, section 4. They are drawn as all slices are; what differs is where slices lie, and the field: see
``field_stack.py``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import StageError
from ..stage import Context, Stage, register, static
from .camera import Camera
from .driver_slices import Planes, SliceDriver, Slices
from .field import Field  # before what is made of it
from .field_stack import AXIS_CHOICES, AXIS_HELP, facing_layers, in_layers

ABOVE = 1e-3  # layers, by which slices lie above them: slopes, which differ on both sides, are those of one
LEAST_COSINE = 1e-3  # of the view to layers, for the distance of slices


@dataclass(frozen=True)
class OverStack(SliceDriver):
    """Base of the drivers over stacks of 2-D textures."""

    def field_for(self, field: Stage, on_layers: bool) -> Field:
        """Return the layer's own field, over layers of 2-D textures."""
        return self.read(field)

    def read(self, field: Stage, axis: str = "auto", between: bool = True) -> Field:
        """Return a field over layers along an axis.

        Raises
        ------
        StageError
            When it is no field.
        """
        if not isinstance(field, Field):
            raise StageError(f"look.field {field.name!r}", "is no Field", "derive its class from airlight.field.Field")
        return in_layers(field, axis, between)


@register
@dataclass(frozen=True)
class ObjectSlices(OverStack):
    """Slices that are layers of the grid, those that face the view most: object-aligned, over three stacks.

    Engel and Ertl, section 4 and figures 11 to 14. No slices lie between layers: steps are rounded to whole layers, and less
    than a voxel is refused. A sample takes one fetch from its layer, and what the nearest one has where a ray enters or leaves
    between two; where light or surfaces are looked for between samples, it takes two fetches. When the view turns to another
    axis all samples change their places at once: the picture pops. Each axis that the view has faced keeps a stack on the
    device, as large as the volume.
    """

    name: ClassVar[str] = "object_slices"
    least_step: ClassVar[float] = 1.0
    corrects: bool = static(
        True, help="slabs are as long as rays are in them; without, as layers are apart: opacity depends on the angle"
    )

    def field_for(self, field: Stage, on_layers: bool) -> Field:
        """Return the field of the layers, by one fetch where samples lie on them."""
        return self.read(field, between=not on_layers)

    def planes(self, camera: Camera, context: Context) -> Planes:
        """Return the planes of every layer, or of each n-th."""
        layers = facing_planes(camera, context)
        every = max(1, round(context.step_world / layers.spacing_world))
        return Planes(layers.normal, layers.first, every * layers.spacing_world, self.corrects)


@register
@dataclass(frozen=True)
class InterpolatedSlices(OverStack):
    """Slices parallel to the layers of the grid that face the view most, at any distance, also between layers.

    Engel and Ertl, section 4 and figure 15: two neighbouring layers are interpolated by two fetches. Slices lie closer where
    the view is oblique, so that along the ray in the middle of the image samples are a step apart at any angle.
    """

    name: ClassVar[str] = "interpolated_slices"

    def planes(self, camera: Camera, context: Context) -> Planes:
        """Return planes from the first layer on that are a step apart along the view."""
        return spaced_planes(camera, context)


@register
@dataclass(frozen=True)
class Stripes(OverStack):
    """Slices of any direction over a single stack of 2-D textures, cut into stripes where they pass from layer to layer.

    Engel and Ertl, section 4 and figures 16 and 17: what is kept is not tripled, nor does the picture pop. Each fragment finds
    its two layers, and the share of each, by itself.
    """

    name: ClassVar[str] = "stripes"
    aligned: str = static("view", choices=("view", "object"), help="slices parallel to the image, or to layers of the grid")
    axis: str = static("z", choices=AXIS_CHOICES, help=AXIS_HELP)

    def field_for(self, field: Stage, on_layers: bool) -> Field:
        """Return the field over the one stack."""
        return self.read(field, self.axis)

    def planes(self, camera: Camera, context: Context) -> Planes:
        """Return the planes of slices parallel to the image, or a step apart along the view and parallel to layers."""
        return Slices().planes(camera, context) if self.aligned == "view" else spaced_planes(camera, context)


def facing_planes(camera: Camera, context: Context) -> Planes:
    """Planes in the layers that are most perpendicular to the view, or just above them, away from the eye."""
    volume = context.volume
    axis, way = facing_layers(volume, camera, context.size_px)
    row = volume.index_from_world[axis]
    apart = 1.0 / float(np.linalg.norm(row[:3]))
    return Planes(way * apart * row[:3], way * apart * (ABOVE - float(row[3])), apart)


def spaced_planes(camera: Camera, context: Context) -> Planes:
    """Planes parallel to those layers, from the first one on, that are a step apart along the view."""
    layers = facing_planes(camera, context)
    cosine = float(layers.normal @ camera.basis()[2])
    return Planes(layers.normal, layers.first, context.step_world * max(cosine, LEAST_COSINE))
