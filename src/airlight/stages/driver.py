"""Drivers: what walks through the volume and calls the slots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ..stage import Stage, register, static, value
from ..transfer.given import whole

MOST_MESH_LAYERS = 32


@register
@dataclass(frozen=True)
class March(Stage):
    """One ray a pixel, sampled at equal distances from the eye, slab by slab."""

    slot: ClassVar[str] = "driver"
    name: ClassVar[str] = "march"
    wgsl: ClassVar[str] = "march.wgsl"
    curved: bool = static(True, help="put values right for the field's curvature where slabs of a smooth field are integrated")
    offsets: str = static("none", choices=("none", "interleaved"), help="shift of the samples along each ray")
    refine: str = static(
        "bisection",
        choices=("none", "bisection", "secant", "exact"),
        help="how the place of a surface between two samples is sharpened",
    )
    blocks: bool = static(True, help="sample each block of 4 voxels that may hold the surface, whatever the step")
    mesh_layers: int = value(
        4, at_least=1, up_to=MOST_MESH_LAYERS, help="most semi-transparent layers of meshes that a ray meets, the nearest ones"
    )

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        whole(self.mesh_layers, "driver.march.mesh_layers", 1)


def sharpens_surfaces(driver: Stage) -> bool:
    """Whether a driver looks for the places of surfaces between samples."""
    return getattr(driver, "refine", "none") != "none"


def gains_from_curvature(stages: Mapping[str, Stage]) -> bool:
    """Whether a layer's stages, by slot, draw better with values put right for the field's curvature.

    They do where slabs are classified along straight lines between samples of a field that is smooth: see
    ``docs/decisions/0015``. The mean of a slab's two ends is better without, and a field that jumps has no curvature.
    """
    wanted = (("integrate", "classifies"), ("transfer", "integrates"), ("field", "smooth"))
    return all(getattr(stages[slot], what, False) for slot, what in wanted)
