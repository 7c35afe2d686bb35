"""How much of a light reaches a point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..stage import Stage, register


@register
@dataclass(frozen=True)
class NoOcclusion(Stage):
    """All light reaches every point."""

    slot: ClassVar[str] = "visibility"
    name: ClassVar[str] = "none"
    wgsl: ClassVar[str] = "visibility/none.wgsl"
