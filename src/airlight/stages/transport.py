"""What becomes of a light on its way through the volume, plane by plane; the driver ``half_angle`` asks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..stage import F32, Stage, param, register, static
from .integrate import Integrate
from .shade import Shade

Light4 = tuple[float, float, float, float]


class Transport(Stage):
    """Base of the transport stages.

    ``is_grey``: all colours are dimmed alike, so that four numbers are the light at four planes in a row.
    ``begins`` is what a texel of the light's buffer holds where nothing has been passed; ``most_slices`` how many slices light
    passes at once: fewer where it goes aside, since its neighbours are looked at between groups of slices alone.
    """

    slot: ClassVar[str] = "transport"
    begins: ClassVar[Light4] = (1.0, 1.0, 1.0, 1.0)
    most_slices: ClassVar[int] = 4096
    is_grey: ClassVar[bool] = False


@register
@dataclass(frozen=True)
class Opaque(Transport):
    """Grey shadows: what a slab takes from the eye it takes from all colours of a light."""

    name: ClassVar[str] = "opaque"
    is_grey: ClassVar[bool] = True
    wgsl: ClassVar[str] = "transport/opaque.wgsl"


@register
@dataclass(frozen=True)
class Coloured(Transport):
    """Coloured shadows: a medium lets more light of its own colour through, as stained glass does.

    The extinction of each colour is that of the medium times ``1 - tint * colour`` (Kniss, Kindlmann and Hansen 2002: the
    colour of transport).
    """

    name: ClassVar[str] = "coloured"
    wgsl: ClassVar[str] = "transport/coloured.wgsl"
    tint: F32 = param(0.7, at_least=0, up_to=1, help="0: grey shadows; 1: a medium lets all light of its own colour through")


@register
@dataclass(frozen=True)
class Translucent(Transport):
    """Light that goes on after it was scattered: a share of what slabs take, in their colour, spread within a cone.

    After Kniss, Premoze, Hansen and Ebert 2002, but for one thing: their scattered light begins as strong as the light itself,
    here it is what the medium has taken from that, so that no place gets more light than there is.
    """

    name: ClassVar[str] = "translucent"
    wgsl: ClassVar[str] = "transport/translucent.wgsl"
    most_slices: ClassVar[int] = 4
    begins: ClassVar[Light4] = (0.0, 0.0, 0.0, 1.0)
    scatter: F32 = param(0.9, at_least=0, up_to=1, help="share of the light taken from a white slab that goes on, scattered")
    angle_deg: F32 = param(
        45.0, unit="degree", at_least=0, up_to=80, help="half the cone within which light spreads on the way of a voxel"
    )


# -- what stands in the slots of a sweep's two programs: nobody chooses it


@dataclass(frozen=True)
class Transmittance(Integrate):
    """What comes through along a light's ray, as its transport has it."""

    name: ClassVar[str] = "transmittance"
    wgsl: ClassVar[str] = "integrate/transmittance.wgsl"
    classifies: ClassVar[bool] = True
    uses_values: ClassVar[bool] = False
    skips_empty: ClassVar[bool] = True
    grey: bool = static(False, help="whether texels hold the light at planes in a row, of all colours alike")


@dataclass(frozen=True)
class Passed(Stage):
    """What of a light has come through to the slices that are drawn."""

    slot: ClassVar[str] = "visibility"
    name: ClassVar[str] = "half_angle"
    wgsl: ClassVar[str] = "visibility/half_angle.wgsl"
    grey: bool = static(False, help="as the light's rays have kept it")


@dataclass(frozen=True)
class Dark(Shade):
    """What glows by itself, where that has been drawn with another light."""

    name: ClassVar[str] = "dark"
    wgsl: ClassVar[str] = "shade/dark.wgsl"
    asks_lights: ClassVar[bool] = False
