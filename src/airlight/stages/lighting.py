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


@register
@dataclass(frozen=True)
class Supersampled(Stage):
    """At two places of the slab, the nodes of Gauss' rule: smoother where normals turn within a slab, at twice the price.

    Lum, Wilson and Ma, section 2.1, after Roettger et al. 2003.
    """

    slot: ClassVar[str] = "lighting"
    name: ClassVar[str] = "supersampled"
    wgsl: ClassVar[str] = "lighting/supersampled.wgsl"
