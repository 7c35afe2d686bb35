"""The field that is pre-filtered where pixels are wider than voxels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ..errors import StageError
from ..reconstruction.levels import level_sizes
from ..stage import F32, Context, Grid, Mat3f, Resource, Stage, Vec3f, param, register
from .camera import Camera
from .field import Field

FREE_GRADIENTS = ("zero", "central", "sobel", "analytic")
AT_VOXELS = (("lighting", "quantised"), ("visibility", "ambient_occlusion"), ("visibility", "shadow_volume"))


@dataclass(frozen=True, eq=False)
class LevelsUniforms:
    """How wide a pixel is, in smallest voxel spacings, at the eye and more with each world unit away from it."""

    eye_index: Vec3f = param((0.0, 0.0, 0.0), unit="voxel")
    world_from_index: Mat3f = param(None)
    width_at_eye: F32 = param(0.0, unit="voxel")
    width_per_world: F32 = param(0.0, unit="voxel/world")
    bias: F32 = param(0.0, unit="level")
    coarsest: F32 = param(0.0, unit="level")


@register
@dataclass(frozen=True)
class Levels(Field):
    """Trilinear interpolation on the level of detail that a pixel's width asks for, and straight between levels.

    Levels hold means over boxes of 2, 4, 8 ... voxels a side, so that a large volume in a small picture does not alias
    (Engel and Ertl, sections 2.1 and 7). Where a pixel is no wider than the smallest voxel spacing it is ``linear``. Takes
    a seventh more texture memory, and half or 32-bit floats for all but 8-bit data.

    Raises
    ------
    StageError
        With gradients that are computed at the voxels beforehand, which have no levels.
    """

    name: ClassVar[str] = "levels"
    wgsl: ClassVar[str] = "field/levels.wgsl"
    uniform_type: ClassVar[type | None] = LevelsUniforms
    filtered: ClassVar[bool] = True
    differentiable: ClassVar[bool] = True
    bias: F32 = param(0.0, unit="level", at_least=-4, up_to=8, help="how much coarser than pixels are wide; below zero finer")

    @property
    def support_voxels(self) -> float:
        """Whatever a level's box holds."""
        return float("inf")

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the grid with its levels."""
        return {"grid": Grid(context.volume, context.channels, context.time, self.filtered, levels=True)}

    def uniforms(self, context: Context) -> LevelsUniforms:
        """Return the width of pixels."""
        volume, camera = context.volume, context.camera
        if not isinstance(camera, Camera):
            raise StageError(f"look.field {self.name!r}", "needs a camera that tells how wide its pixels are", "use linear")
        at_eye, per_world = camera.pixel_width(context.size_px)
        spacing = min(volume.spacing)
        eye = volume.index_from_world[:3, :3] @ camera.eye + volume.index_from_world[:3, 3]
        return LevelsUniforms(
            eye_index=tuple(eye),
            world_from_index=volume.world_from_index[:3, :3],
            width_at_eye=at_eye / spacing,
            width_per_world=per_world / spacing,
            bias=self.bias,
            coarsest=len(level_sizes(volume.size)) - 1.0,
        )

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return a layer's stages by slot, with this field."""
        if chosen["gradient"].name not in FREE_GRADIENTS:
            where = f"look.gradient {chosen['gradient'].name!r}"
            raise StageError(where, "is computed at the voxels and has no levels", "use central or analytic")
        for slot, name in AT_VOXELS:
            if slot in chosen and chosen[slot].name == name:
                raise StageError(f"look.{slot} {name!r}", "is computed at the voxels and has no levels", "use the field linear")
        return super().arranged(chosen)
