"""Drivers: what walks through the volume and calls the slots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ..stage import F32, Context, Resource, Stage, Table, param, register, static, value
from ..transfer import TransferFunction
from ..transfer.given import whole
from ..volume import FloatArray
from .offsets import INTERLEAVED, NONE, blue_noise, blue_noise_texels, fraction_of_frame

MOST_MESH_LAYERS = 32
MOST_CLIP_LAYERS = 64
MOST_SHIFT = 1 << 24
REFINES = ("none", "bisection", "secant", "exact")
REFINE_HELP = "how the place of a surface between two samples is sharpened"


@dataclass(frozen=True)
class OffsetUniforms:
    """Shift of the samples of all pixels, as a share of a step."""

    shift: F32 = param(0.0)


@dataclass(frozen=True)
class Driver(Stage):
    """What all drivers take that go along rays slab by slab."""

    slot: ClassVar[str] = "driver"
    curved: bool = static(True, help="put values right for the field's curvature where slabs of a smooth field are integrated")
    refine: str = static("bisection", choices=REFINES, help=REFINE_HELP)
    mesh_layers: int = value(
        4, at_least=1, up_to=MOST_MESH_LAYERS, help="most semi-transparent layers of meshes that a ray meets, the nearest ones"
    )
    clip_layers: int = value(
        16, at_least=2, up_to=MOST_CLIP_LAYERS, help="most surfaces of a closed mesh that clips which a ray may pass"
    )

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        whole(self.mesh_layers, f"driver.{self.name}.mesh_layers", 1, MOST_MESH_LAYERS)
        whole(self.clip_layers, f"driver.{self.name}.clip_layers", 2, MOST_CLIP_LAYERS)

    def field_for(self, field: Stage, on_layers: bool) -> Stage:
        """Return the field that is read in the place of a layer's own; ``on_layers``: at the driver's own samples alone."""
        return field


@register
@dataclass(frozen=True)
class March(Driver):
    """One ray a pixel, sampled at equal distances from the eye, slab by slab."""

    name: ClassVar[str] = "march"
    wgsl: ClassVar[str] = "march.wgsl"
    uniform_type: ClassVar[type] = OffsetUniforms
    refine: str = static(
        "bisection", choices=(*REFINES, "cells"), help=f"{REFINE_HELP}; cells: the first root of all cells, none is left out"
    )
    offsets: str = static(
        "none", choices=("none", "interleaved", "blue_noise"), help="shift of the samples along each ray, from pixel to pixel"
    )
    adaptive: bool = static(
        False, help="take slabs of up to 8 steps where little of them gets through to the eye; the image changes a little"
    )
    blocks: bool = static(True, help="sample each block of 4 voxels that may hold a surface, whatever the step")
    shift: int = value(
        0, at_least=0, up_to=MOST_SHIFT, help="number of a frame, each with samples at other places: their mean converges"
    )

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        whole(self.shift, "driver.march.shift", 0, MOST_SHIFT)

    def converging(self) -> March:
        """Return the march whose slabs are as long as told."""
        return replace(self, adaptive=False)

    def uniforms(self, context: Context) -> OffsetUniforms:
        """Return the shift of the frame."""
        return OffsetUniforms(fraction_of_frame(self.shift))

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the tile of blue noise, where it is asked for."""
        return {"noise": Table(blue_noise_texels())} if self.offsets == "blue_noise" else {}

    def offset_fraction(self, x_px: npt.ArrayLike, y_px: npt.ArrayLike) -> FloatArray:
        """Return by which share of a step the samples of pixels are shifted away from the eye.

        It is what ``airlight.reference.render`` asks for under this name.
        """
        tile = blue_noise() if self.offsets == "blue_noise" else INTERLEAVED if self.offsets == "interleaved" else NONE
        pattern = tile[np.asarray(y_px) % tile.shape[0], np.asarray(x_px) % tile.shape[1]]
        return np.asarray((pattern + fraction_of_frame(self.shift)) % 1.0)


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


def may_lengthen(stages: Mapping[str, Stage], function: object, labels: object) -> bool:
    """Whether slabs of a layer may be longer where little gets through: at any step its samples tell what is empty.

    They do for a function of one value without surfaces; regions reach by one step.
    """
    told = labels is None and isinstance(function, TransferFunction) and not getattr(stages["transfer"], "has_surfaces", False)
    return told and hasattr(stages["integrate"], "opaque_at")


from .driver_half_angle import HalfAngle  # noqa: E402
from .driver_slices import Shells, SliceDriver, Slices  # noqa: E402  (they are made of the above)
from .driver_stacks import InterpolatedSlices, ObjectSlices, Stripes  # noqa: E402

__all__ = ["Driver", "HalfAngle", "InterpolatedSlices", "March", "ObjectSlices", "Shells", "SliceDriver", "Slices", "Stripes"]
