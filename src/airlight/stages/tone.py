"""From the scene's radiance to what a display can show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..stage import F32, Stage, param, register


def keeps_black(stage: Stage) -> bool:
    """Whether a stage says that it maps no light to none, so that pixels without any need not be drawn."""
    return bool(getattr(stage, "keeps_black", False))


@register
@dataclass(frozen=True)
class Linear(Stage):
    """The radiance times ``2^exposure``; untouched at 0."""

    slot: ClassVar[str] = "tone"
    name: ClassVar[str] = "linear"
    wgsl: ClassVar[str] = "tone/linear.wgsl"
    keeps_black: ClassVar[bool] = True
    exposure: F32 = param(0.0, unit="stop", at_least=-32, up_to=32, help="doubles the light with each stop")


@register
@dataclass(frozen=True)
class Reinhard(Stage):
    """Reinhard's global operator on luminance; the scene's log-average luminance is mapped to ``key``.

    Vollrath, Weiskopf and Ertl, section 4.2, after Reinhard et al. 2002, equations 1 to 4. The average is taken over covered
    pixels, weighted by their coverage.
    """

    slot: ClassVar[str] = "tone"
    name: ClassVar[str] = "reinhard"
    wgsl: ClassVar[str] = "tone/reinhard.wgsl"
    keeps_black: ClassVar[bool] = True
    reads: ClassVar[tuple[str, ...]] = ("luminance",)
    exposure: F32 = param(0.0, unit="stop", at_least=-32, up_to=32, help="doubles the light with each stop")
    key: F32 = param(0.18, above=0, up_to=1, help="what the average luminance becomes")
    white: F32 = param(2.0, above=0, help="least scaled luminance that is shown as white")
