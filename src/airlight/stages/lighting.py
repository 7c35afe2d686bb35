"""Where within a slab light is evaluated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..stage import Stage, register


@register
@dataclass(frozen=True)
class Unlit(Stage):
    """Nowhere: the slab keeps its own colour."""

    slot: ClassVar[str] = "lighting"
    name: ClassVar[str] = "unlit"
    wgsl: ClassVar[str] = "lighting/unlit.wgsl"


@register
@dataclass(frozen=True)
class Sampled(Stage):
    """At one place of the slab, its middle; an end would shift all light by half a step."""

    slot: ClassVar[str] = "lighting"
    name: ClassVar[str] = "sampled"
    wgsl: ClassVar[str] = "lighting/sampled.wgsl"
