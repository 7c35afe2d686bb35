"""How much of a light reaches a point."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import LimitError, StageError, ValueRangeError
from ..stage import (
    F32,
    U32,
    Context,
    OccluderGrid,
    OpennessGrid,
    Resource,
    ShadowGrid,
    Stage,
    Vec3f,
    param,
    register,
    static,
)
from ..volume import Volume

SHARE_OF_DIAGONAL = 0.15
"""Radius that is looked at, as a share of the volume's diagonal, where none is told."""

MOST_LIGHTS = 32
"""Lights that shadows are told for: a bit each."""


@register
@dataclass(frozen=True)
class NoOcclusion(Stage):
    """All light reaches every point."""

    slot: ClassVar[str] = "visibility"
    name: ClassVar[str] = "none"
    wgsl: ClassVar[str] = "visibility/none.wgsl"


@dataclass(frozen=True)
class AmbientOcclusionUniforms:
    """From index coordinates, half a voxel further, to the place in the texture."""

    unit_per_voxel: Vec3f = param((1.0, 1.0, 1.0), unit="1/voxel")


@register
@dataclass(frozen=True)
class AmbientOcclusion(Stage):
    """Ambient light dimmed by what is drawn: the share that comes through all layers, of light from all directions.

    Transmittance from one cell away up to ``radius``, averaged over directions all round, on a coarse grid of cells that hold
    what the function makes of their voxels; interpolated between cells. Made once for volumes and functions. A flat opaque
    wall leaves half of the sky open: give the shade stage twice the ambient light, about 1, and less of the others.
    """

    slot: ClassVar[str] = "visibility"
    name: ClassVar[str] = "ambient_occlusion"
    wgsl: ClassVar[str] = "visibility/ambient_occlusion.wgsl"
    uniform_type: ClassVar[type] = AmbientOcclusionUniforms
    radius: F32 | None = param(
        None, unit="world", above=0, help="how far one looks for what hides; None: 0.15 of the diagonal, at least two cells"
    )
    directions: U32 = param(64, at_least=6, up_to=1024, help="number of directions, all round")
    cells: U32 = param(64, at_least=8, up_to=256, help="cells along the longest side")

    def grid(self, context: Context) -> OpennessGrid:
        """Return what is made on the device.

        Raises
        ------
        ValueRangeError
            When the radius does not reach beyond a cell.
        """
        occluders = occluders_of(context, self.cells)
        cell_world = occluders.cell_world
        sides = np.array(context.volume.size) * context.volume.spacing
        radius = max(SHARE_OF_DIAGONAL * float(np.linalg.norm(sides)), 2 * cell_world) if self.radius is None else self.radius
        if radius <= cell_world:
            what = f"is {radius:g}, and cells have {cell_world:g}"
            raise ValueRangeError("look.visibility.ambient_occlusion.radius", what, "look further, or take more cells")
        return OpennessGrid(occluders, radius, self.directions)

    def uniforms(self, context: Context) -> AmbientOcclusionUniforms:
        """Return the way to the texture."""
        grid = occluders_of(context, self.cells)
        x, y, z = (1.0 / (b * n) for b, n in zip(grid.block, grid.cells, strict=True))
        return AmbientOcclusionUniforms((x, y, z))

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the openness of the cells."""
        return {"openness": self.grid(context)}


@dataclass(frozen=True)
class ShadowVolumeUniforms:
    """From index coordinates to the place in the texture; the bits of ``casting`` are the lights that cast shadows."""

    cells_per_voxel: Vec3f = param((1.0, 1.0, 1.0), unit="cell/voxel")
    unit_per_cell: Vec3f = param((1.0, 1.0, 1.0), unit="1/cell")
    cells_z: F32 = param(1.0, unit="cell")
    casting: U32 = param(0)
    bias_world: F32 = param(0.0, unit="world")


@register
@dataclass(frozen=True)
class ShadowVolume(Stage):
    """Lights dimmed by what is drawn: the share of each that comes through all layers to a place, on a coarse grid of cells.

    Transmittance from each cell towards each directional and point light, interpolated between cells (Behrens and Ratering
    1998; Engel and Ertl, section 5.4). Made once for volumes, functions and the places of lights; a turned camera costs
    nothing. Head lights cast no shadows: they come from the eye, which sees no place that they do not reach.
    """

    slot: ClassVar[str] = "visibility"
    name: ClassVar[str] = "shadow_volume"
    wgsl: ClassVar[str] = "visibility/shadow_volume.wgsl"
    uniform_type: ClassVar[type] = ShadowVolumeUniforms
    of_lights: ClassVar[bool] = True
    cells: U32 = param(64, at_least=8, up_to=256, help="cells along the longest side")
    bias: F32 | None = param(
        None, unit="voxel", at_least=0, up_to=64, help="how far towards a light one looks for what arrives; None: a cell"
    )
    tint: F32 = param(0.0, at_least=0, up_to=1, help="0: grey shadows; 1: a medium lets all light of its own colour through")
    by: str = static(
        "sweep",
        choices=("sweep", "rays"),
        help="sweep: from slice to slice, away from the light; rays: a ray from each cell to the light",
    )

    def grid(self, context: Context) -> ShadowGrid:
        """Return what is made on the device.

        Raises
        ------
        StageError
            When no light casts a shadow, or a sweep cannot run away from one.
        LimitError
            For more lights than are told apart.
        """
        casting = [light for light in context.lights if light.kind != "head"]
        where = f"look.visibility.{self.name}"
        if not casting:
            there = "there are head lights alone" if context.lights else "there are no lights"
            remedy = "add lights=[al.Light.directional(to_light=(-1, -1, 1))], or use visibility='none'"
            raise StageError(where, f"makes shadows of directional and point lights, and {there}", remedy)
        if len(context.lights) > MOST_LIGHTS:
            raise LimitError("scene.lights", f"are {len(context.lights)}, and shadows know {MOST_LIGHTS}", "take fewer")
        occluders = occluders_of(context, self.cells, self.tint)
        for light in casting if self.by == "sweep" else ():
            if light.kind != "directional" and is_inside(context.volume, light.vector):
                place = ", ".join(f"{x:g}" for x in light.vector)
                raise StageError(
                    f"{where}.by", f"'sweep' runs away from a light, and one at ({place}) is inside", "use by='rays'"
                )
        return ShadowGrid(occluders, tuple((light.kind, light.vector) for light in casting), self.by)

    def uniforms(self, context: Context) -> ShadowVolumeUniforms:
        """Return the way to the texture."""
        grid = self.grid(context)
        x, y, z = grid.size
        per_voxel = tuple(1 / b for b in grid.occluders.block)
        casting = sum(1 << number for number, light in enumerate(context.lights) if light.kind != "head")
        bias_world = grid.occluders.cell_world if self.bias is None else self.bias * min(context.volume.spacing)
        cells_z = float(grid.occluders.cells[2] + 2)
        return ShadowVolumeUniforms(per_voxel, (1 / x, 1 / y, 1 / z), cells_z, casting, bias_world)  # type: ignore[arg-type]

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return what reaches the cells."""
        return {"shadows": self.grid(context)}


def is_inside(volume: Volume, p_world: tuple[float, float, float]) -> bool:
    """Whether a point lies in the box of a volume's voxels."""
    p_index = volume.index_from_world[:3, :3] @ np.array(p_world) + volume.index_from_world[:3, 3]
    return bool(((p_index >= -0.5) & (p_index <= np.array(volume.size) - 0.5)).all())


def occluders_of(context: Context, cells: int, tint: float = 0.0) -> OccluderGrid:
    """What hides in a layer, by so many cells along its longest side."""
    block, cell_world = cells_of(context.volume, cells)
    x, y, z = (-(-n // b) for n, b in zip(context.volume.size, block, strict=True))
    return OccluderGrid((x, y, z), block, cell_world, context.clips, tint, cells)


def cells_of(volume: Volume, cells: int) -> tuple[tuple[int, int, int], float]:
    """Voxels of a cell along x, y and z, as even in the world as they can be, and its mean side [world]."""
    sides = [n * s for n, s in zip(volume.size, volume.spacing, strict=True)]
    x, y, z = (min(n, max(1, round(max(sides) / (cells * s)))) for n, s in zip(volume.size, volume.spacing, strict=True))
    return (x, y, z), math.prod(b * s for b, s in zip((x, y, z), volume.spacing, strict=True)) ** (1 / 3)
