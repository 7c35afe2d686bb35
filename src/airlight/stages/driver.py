"""Drivers: what walks through the volume and calls the slots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..stage import Stage, register, static


@register
@dataclass(frozen=True)
class March(Stage):
    """One ray a pixel, sampled at equal distances from the eye, slab by slab."""

    slot: ClassVar[str] = "driver"
    name: ClassVar[str] = "march"
    wgsl: ClassVar[str] = "march.wgsl"
    curved: bool = static(False, help="put values right for the field's curvature, for transfer stages that integrate slabs")
    offsets: str = static("none", choices=("none", "interleaved"), help="shift of the samples along each ray")
