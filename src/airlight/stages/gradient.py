"""Gradients of the field, in data units per world unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ..stage import STAGES, Context, GradientGrid, Resource, Stage, register, static


@register
@dataclass(frozen=True)
class Zero(Stage):
    """No gradient: for looks that are not lit."""

    slot: ClassVar[str] = "gradient"
    name: ClassVar[str] = "zero"
    wgsl: ClassVar[str] = "gradient/zero.wgsl"


@register
@dataclass(frozen=True)
class Central(Stage):
    """Central differences of the field over one voxel to each side; one-sided at the faces of the grid."""

    slot: ClassVar[str] = "gradient"
    name: ClassVar[str] = "central"
    wgsl: ClassVar[str] = "gradient/central.wgsl"


@register
@dataclass(frozen=True)
class Sobel(Stage):
    """Central differences smoothed across by the weights 1, 2, 1: 26 neighbours instead of six, less noise."""

    slot: ClassVar[str] = "gradient"
    name: ClassVar[str] = "sobel"
    wgsl: ClassVar[str] = "gradient/sobel.wgsl"


@register
@dataclass(frozen=True)
class Precomputed(Stage):
    """Gradients computed once at the voxels, kept in a texture and interpolated."""

    slot: ClassVar[str] = "gradient"
    name: ClassVar[str] = "precomputed"
    wgsl: ClassVar[str] = "gradient/precomputed.wgsl"
    method: str = static("central", choices=("central", "sobel"), help="gradient that is computed at the voxels")

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the grid of gradients."""
        return {"gradients": GradientGrid(STAGES["gradient"][self.method]())}
