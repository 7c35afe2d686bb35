"""From the scene's radiance to what a display can show."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

from ..errors import DataError
from ..handed import NUMBER, Kind, Prepared
from ..stage import F32, Stage, param, register
from ..transfer.given import not_negative, positive, set_fields

RADIUS = 0.02  # of what is averaged round pixels, as a share of the longer side
EDGE_STOPS = 1.33  # 0.4 in decimal logarithms, as Durand and Dorsey


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


@dataclass(frozen=True)
class Metered(Stage):
    """What tones have in common that expose by the picture: its log-average luminance is mapped to ``key``.

    The average is taken over covered pixels, weighted by their coverage: it is that of what is seen, however much of the
    background lies round it. With ``adapted`` it is taken as known; the picture's own is measured all the same, for
    ``Adaptation``. No average is less than 1e-6.
    """

    slot: ClassVar[str] = "tone"
    keeps_black: ClassVar[bool] = True
    reads: ClassVar[Mapping[str, Kind]] = {"luminance": NUMBER}
    exposure: F32 = param(0.0, unit="stop", at_least=-32, up_to=32, help="doubles the light with each stop")
    key: F32 = param(0.18, above=0, up_to=1, help="what the average luminance becomes")
    adapted: F32 = param(0.0, unit="radiance", at_least=0, up_to=1e30, help="luminance taken for the average; 0 measures it")


@register
@dataclass(frozen=True)
class Reinhard(Metered):
    """Reinhard's global operator on luminance; the scene's log-average luminance is mapped to ``key``.

    Vollrath, Weiskopf and Ertl, sections 3.3 and 5.4, after Reinhard et al. 2002, "Photographic tone reproduction for digital
    images", equations 1 to 4.
    """

    name: ClassVar[str] = "reinhard"
    wgsl: ClassVar[str] = "tone/reinhard.wgsl"
    white: F32 = param(2.0, at_least=1e-3, help="least scaled luminance that is shown as white")


@register
@dataclass(frozen=True)
class ReinhardLocal(Metered):
    """Reinhard's local operator: the curve of ``reinhard`` by the luminance round a pixel, so that fine contrasts stay.

    Reinhard et al. 2002, equation 9. What lies round a pixel is averaged by the bilateral filter of Durand and Dorsey 2002,
    "Fast bilateral filtering for the display of high-dynamic-range images", which stops at edges and so leaves no halos; see
    ``wgsl/passes/surround.wgsl``.
    """

    name: ClassVar[str] = "reinhard_local"
    wgsl: ClassVar[str] = "tone/reinhard_local.wgsl"
    reads: ClassVar[Mapping[str, Kind]] = {"luminance": NUMBER, "surround": Prepared()}
    white: F32 = param(2.0, at_least=1e-3, help="least scaled luminance that is shown as white")
    radius: F32 = param(RADIUS, at_least=0.002, up_to=1, help="deviation of the average in space, by the longer side")
    edge: F32 = param(EDGE_STOPS, unit="stop", at_least=0.25, up_to=16, help="deviation of the average in luminance")


@register
@dataclass(frozen=True)
class Filmic(Metered):
    """A curve as of film: dark tones are darkened, bright ones run into white, and strong colours pale as they get there.

    Of each channel, with middle grey (0.18) and ``white`` as fixed points; a logistic curve in the logarithm of light.
    """

    name: ClassVar[str] = "filmic"
    wgsl: ClassVar[str] = "tone/filmic.wgsl"
    white: F32 = param(16.0, at_least=1.01, up_to=1e9, help="least scaled light that is shown as white")
    contrast: F32 = param(1.5, at_least=1, up_to=4, help="how steeply the curve passes middle grey, about")


class Told(Protocol):
    """An image that tells what was measured of it, as ``al.Image`` does."""

    @property
    def stats(self) -> Mapping[str, Any]:
        """What was done."""


@dataclass(frozen=True)
class Adaptation:
    """What eyes have adapted to, which follows the light with time: a value that is carried from frame to frame.

    ``adapted`` gives the next; its ``luminance`` is a parameter of tone stages of that name. Logarithms of luminance approach
    that of the last picture exponentially, as in Durand and Dorsey 2000, "Interactive tone mapping".

    Attributes
    ----------
    luminance
        Luminance [radiance]; 0 is that of the first picture, whatever it is.
    to_light_s, to_dark_s
        Time [s] after which 63 % are done, where it gets brighter and where it gets darker.

    Raises
    ------
    ValueRangeError
        For a luminance below zero, and times that are not positive.
    """

    luminance: float = 0.0
    to_light_s: float = 0.3
    to_dark_s: float = 0.9

    def __post_init__(self) -> None:
        """Check the numbers."""
        times = {name: positive(getattr(self, name), f"adaptation.{name}") for name in ("to_light_s", "to_dark_s")}
        set_fields(self, luminance=not_negative(self.luminance, "adaptation.luminance"), **times)

    def adapted(self, image: Told, seconds: float) -> Adaptation:
        """Return what eyes have adapted to after they have seen an image for some time [s].

        Raises
        ------
        ValueRangeError
            For a time below zero.
        DataError
            For an image whose luminance was not measured.
        """
        seconds = not_negative(seconds, "seconds")
        seen = image.stats.get("luminance", 0.0 if "reason" in image.stats else None)
        if seen is None:
            raise DataError("image.stats", "has no luminance, which linear tones do not measure", 'draw with tone="reinhard"')
        if not seen or not self.luminance:
            return replace(self, luminance=seen or self.luminance)
        way = math.log(seen / self.luminance)
        left = math.exp(-seconds / (self.to_light_s if way > 0 else self.to_dark_s))
        return replace(self, luminance=self.luminance * math.exp(way * (1 - left)))
