"""Drivers that go through the volume slice by slice: object order, where the march is image order.

A slice driver rasterises groups of slices; each fragment takes those slabs of a group that its ray meets, by the same stages as
the march: see ``docs/decisions/0046``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..stage import Context, register, static, value
from ..transfer.given import whole
from ..volume import FloatArray
from .camera import Camera
from .driver import Driver, OffsetUniforms

MOST_GROUP = 4096


@dataclass(frozen=True, eq=False)
class Planes:
    """Planes ``dot(normal, p) = first + k * spacing_world``, k whole, at which samples lie; ``normal`` (3,) has length one.

    Slabs that are not ``measured`` attenuate as if all rays passed them at right angles.
    """

    normal: FloatArray
    first: float
    spacing_world: float
    measured: bool = True

    def seen_from(self, anchor_world: FloatArray) -> Planes:
        """Return the same planes where the origin is another point (3,) of the world."""
        return replace(self, first=self.first - float(self.normal @ anchor_world))

    def numbered_from(self, p_world: FloatArray) -> Planes:
        """Return the same planes, with number 0 the last before all of some points (n, 3)."""
        ahead = float((p_world @ self.normal).min()) - self.first
        return replace(self, first=self.first + np.floor(ahead / self.spacing_world) * self.spacing_world)


@dataclass(frozen=True)
class SliceDriver(Driver):
    """A driver of slices. ``planes`` tells where they lie; None where they are shells round the eye."""

    wgsl: ClassVar[str] = "slices.wgsl"
    back_to_front: bool = static(False, help="draw from the farthest group of slices to the nearest")
    group: int = value(64, at_least=1, up_to=MOST_GROUP, help="slices drawn in one pass: 1 is slice by slice")

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        whole(self.group, f"driver.{self.name}.group", 1, MOST_GROUP)

    def planes(self, camera: Camera, context: Context) -> Planes | None:
        """Return the planes at which samples lie, in the world of the camera; the step is that of the context."""
        raise NotImplementedError


@register
@dataclass(frozen=True)
class Slices(SliceDriver):
    """Slices parallel to the image, at equal depths: view-aligned, through a 3-D texture.

    Depth and distance from the eye are the same for parallel rays, so that the image is that of the march there. In perspective
    slabs get longer to the side (Engel and Ertl, section 3).
    """

    name: ClassVar[str] = "slices"

    def planes(self, camera: Camera, context: Context) -> Planes:
        """Return planes at whole steps of depth."""
        forward = camera.basis()[2]
        return Planes(forward, float(forward @ np.asarray(camera.eye)), context.step_world)


@register
@dataclass(frozen=True)
class Shells(SliceDriver):
    """Concentric shells round the eye: slabs are as long everywhere in perspective. Samples lie where those of the march do."""

    name: ClassVar[str] = "shells"
    uniform_type: ClassVar[type] = OffsetUniforms

    def uniforms(self, context: Context) -> OffsetUniforms:
        """Return no shift."""
        return OffsetUniforms()

    def planes(self, camera: Camera, context: Context) -> None:
        """Return None: shells are no planes."""
