"""What becomes of the slabs along a ray."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..stage import F32, Bool, Context, Stage, Vec3f, param, register, static
from ..transfer.joint import JointFunction


class Integrate(Stage):
    """Base of the integrate stages.

    ``uses_slabs`` tells whether colour is lit at all; ``classifies`` whether ``take`` looks at colour and opacity of slabs;
    ``uses_values`` whether it looks at values; ``skips_empty`` whether empty slabs leave the result as it is, ``surfaces_only``
    whether all slabs without a surface do; ``colours_samples`` whether ``medium`` is asked about samples of the field, not
    about numbers made of several, which lie nowhere; ``thinned`` by what all extinctions are multiplied before slabs are
    classified.
    """

    slot: ClassVar[str] = "integrate"
    uses_slabs: ClassVar[bool] = False
    classifies: ClassVar[bool] = False
    uses_values: ClassVar[bool] = True
    skips_empty: ClassVar[bool] = False
    surfaces_only: ClassVar[bool] = False
    colours_samples: ClassVar[bool] = True
    thinned: ClassVar[float] = 1.0

    def wanted(self, context: Context) -> tuple[tuple[float, float], ...] | None:
        """Return closed intervals of values; where the field has none of them the result stays as it is. None is all values."""
        return None


@register
@dataclass(frozen=True)
class EmissionAbsorption(Integrate):
    """Front-to-back compositing of emitted and scattered light under absorption.

    Depth is where opacity passes one half.
    """

    name: ClassVar[str] = "emission_absorption"
    wgsl: ClassVar[str] = "integrate/emission_absorption.wgsl"
    uses_slabs: ClassVar[bool] = True
    classifies: ClassVar[bool] = True
    uses_values: ClassVar[bool] = False
    skips_empty: ClassVar[bool] = True
    opaque_at: F32 = param(0.99995, above=0, up_to=1, help="opacity at which a ray ends")


@register
@dataclass(frozen=True)
class Mip(Integrate):
    """Maximum intensity projection: the greatest value along the ray, in the function's colour. Depth is where it lies."""

    name: ClassVar[str] = "mip"
    wgsl: ClassVar[str] = "integrate/mip.wgsl"


@register
@dataclass(frozen=True)
class MinIp(Integrate):
    """Minimum intensity projection: the least value along the ray, in the function's colour. Depth is where it lies."""

    name: ClassVar[str] = "minip"
    wgsl: ClassVar[str] = "integrate/minip.wgsl"


@register
@dataclass(frozen=True)
class Mean(Integrate):
    """The mean value along the ray's way through the domain, in the function's colour. It has no depth."""

    name: ClassVar[str] = "mean"
    wgsl: ClassVar[str] = "integrate/mean.wgsl"
    colours_samples: ClassVar[bool] = False


@dataclass(frozen=True)
class FirstHitUniforms:
    """First hit with the iso-value resolved, and the colours of the function's surface there."""

    iso: F32 = param(0.0, unit="data")
    coloured: Bool = param(False)
    front_rgb: Vec3f = param((1.0, 1.0, 1.0))
    back_rgb: Vec3f = param((1.0, 1.0, 1.0))


@register
@dataclass(frozen=True)
class FirstHit(Integrate):
    """The front surface at the value ``iso``: opaque, lit, in the function's colour there. Depth is the hit.

    Without ``iso`` it is the value at which the transfer function reaches half of its greatest extinction. ``side`` tells what
    is solid (the alpha tests of Westermann and Ertl 1998): values of at least ``iso``, of at most ``iso``, or neither: a thin
    sheet that is met from both sides. Where the function has a ``Surface`` at this very value, the sheet has its colours.
    """

    name: ClassVar[str] = "first_hit"
    wgsl: ClassVar[str] = "integrate/first_hit.wgsl"
    surfaces_only: ClassVar[bool] = True
    uniform_type: ClassVar[type] = FirstHitUniforms
    uses_slabs: ClassVar[bool] = True
    iso: F32 | None = param(None, unit="data", help="value of the surface")
    side: str = static("above", choices=("above", "below", "both"), help="which values are solid; both: a sheet with two sides")

    def uniforms(self, context: Context) -> FirstHitUniforms:
        """Return the iso-value.

        Raises
        ------
        ValueRangeError
            When it is left to a function of several variables, or of surfaces alone, which has none.
        """
        if self.iso is None and isinstance(context.transfer, JointFunction):
            what = "is left to the function, which is one of several variables"
            raise ValueRangeError("look.integrate.first_hit.iso", what, "give it: FirstHit(iso=...)")
        if self.iso is None and context.transfer.surfaces and not context.transfer.extinctions.any():
            value = context.transfer.surfaces[0].value
            what = "is left to the function, which has surfaces alone"
            raise ValueRangeError("look.integrate.first_hit.iso", what, f"give it: FirstHit(iso={value:g})")
        iso = context.transfer.half_extinction_value if self.iso is None else self.iso
        sheet = next((s for s in getattr(context.transfer, "surfaces", ()) if s.value == iso), None)
        if self.side == "below":
            iso = float(np.nextafter(np.float32(iso), np.float32(np.inf)))  # a sample on the very value is solid here, too
        if sheet is None:
            return FirstHitUniforms(iso)
        return FirstHitUniforms(iso, True, sheet.front[0], sheet.back[0])

    def wanted(self, context: Context) -> tuple[tuple[float, float], ...]:
        """Return what lies on the surface or is solid."""
        iso = self.uniforms(context).iso
        return ((-math.inf if self.side == "below" else iso, math.inf if self.side == "above" else iso),)


from .projections import AttenuatedMip, DepthShadedMip, LocalMip, WeightedSum, XRay  # noqa: E402  (they are made of the above)

__all__ = [
    "AttenuatedMip",
    "DepthShadedMip",
    "EmissionAbsorption",
    "FirstHit",
    "Integrate",
    "LocalMip",
    "Mean",
    "MinIp",
    "Mip",
    "WeightedSum",
    "XRay",
]
