"""How much of a light reaches a point."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..stage import F32, U32, Context, OpennessGrid, Resource, Stage, Vec3f, param, register
from ..volume import Volume

SHARE_OF_DIAGONAL = 0.15
"""Radius that is looked at, as a share of the volume's diagonal, where none is told."""


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
    """Ambient light dimmed by the volume itself: the share that comes through, of light from all directions.

    Transmittance from one cell away up to ``radius``, averaged over directions all round, on a coarse grid of cells that hold
    what the function makes of their voxels; interpolated between cells. Made once for a volume and a function. A flat opaque
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
        block, cell_world = cells_of(context.volume, self.cells)
        sides = np.array(context.volume.size) * context.volume.spacing
        radius = max(SHARE_OF_DIAGONAL * float(np.linalg.norm(sides)), 2 * cell_world) if self.radius is None else self.radius
        if radius <= cell_world:
            what = f"is {radius:g}, and cells have {cell_world:g}"
            raise ValueRangeError("look.visibility.ambient_occlusion.radius", what, "look further, or take more cells")
        x, y, z = (-(-n // b) for n, b in zip(context.volume.size, block, strict=True))
        return OpennessGrid((x, y, z), block, cell_world, radius, self.directions, context.clips)

    def uniforms(self, context: Context) -> AmbientOcclusionUniforms:
        """Return the way to the texture."""
        grid = self.grid(context)
        x, y, z = (1.0 / (b * n) for b, n in zip(grid.block, grid.cells, strict=True))
        return AmbientOcclusionUniforms((x, y, z))

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the openness of the cells."""
        return {"openness": self.grid(context)}


def cells_of(volume: Volume, cells: int) -> tuple[tuple[int, int, int], float]:
    """Voxels of a cell along x, y and z, as even in the world as they can be, and its mean side [world]."""
    sides = [n * s for n, s in zip(volume.size, volume.spacing, strict=True)]
    x, y, z = (min(n, max(1, round(max(sides) / (cells * s)))) for n, s in zip(volume.size, volume.spacing, strict=True))
    return (x, y, z), math.prod(b * s for b, s in zip((x, y, z), volume.spacing, strict=True)) ** (1 / 3)
