"""Projections: sums along the ray without order, and maxima that tell what is near. Imported by ``integrate``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..stage import F32, Context, param, register, static
from ..transfer.attenuation import greatest_depth
from ..transfer.function import TransferFunction
from ..volume import FloatArray
from .camera import Camera, Orthographic
from .integrate import Integrate

THINNED = 2.0**-16
"""Share of extinction with which slabs are classified whose light and depth are only added up: they attenuate nothing."""
DEPTH_OF_ALL = 20.0
"""Optical depth of a volume's longest side at the end of the function, where none is told."""


class Sum(Integrate):
    """Base of the stages that add up what slabs hold, in any order and without attenuation."""

    classifies: ClassVar[bool] = True
    uses_values: ClassVar[bool] = False
    skips_empty: ClassVar[bool] = True
    thinned: ClassVar[float] = THINNED
    fills: ClassVar[bool] = True


@dataclass(frozen=True)
class WeightedSumUniforms:
    """What the sum of slabs that are thinned is multiplied by."""

    gain: F32 = param(1.0)


@register
@dataclass(frozen=True)
class WeightedSum(Sum):
    """The function's light along the ray, colour times extinction, added up as if nothing were attenuated. It has no depth.

    What a medium sends that is clear to its own light: fluorescence, emission tomography.
    """

    name: ClassVar[str] = "weighted_sum"
    wgsl: ClassVar[str] = "integrate/weighted_sum.wgsl"
    uniform_type: ClassVar[type] = WeightedSumUniforms
    full: F32 | None = param(None, above=0, help="integral of colour times extinction that is shown as 1; None: the data's")

    def uniforms(self, context: Context) -> WeightedSumUniforms:
        """Return the gain."""
        full = deepest(context, "weighted_sum.full", of_source=True) if self.full is None else self.full
        return WeightedSumUniforms(1.0 / (full * THINNED))


@dataclass(frozen=True)
class XRayUniforms:
    """Line from what is measured to what is shown, ``(measured - black) * gain``, and the density of the slabs."""

    black: F32 = param(0.0)
    gain: F32 = param(1.0)
    thinned: F32 = param(THINNED)


@register
@dataclass(frozen=True)
class XRay(Sum):
    """X-ray picture by the law of Beer and Lambert; extinction is the linear attenuation coefficient. It has no depth.

    ``attenuation`` is the optical depth ``-ln(I / I_0)``, bright where much is attenuated as in a radiograph, from black at
    ``low`` to white at ``high``. ``transmission`` is ``I / I_0``, from black at the depth ``high`` to white at ``low``.
    """

    name: ClassVar[str] = "xray"
    wgsl: ClassVar[str] = "integrate/xray.wgsl"
    uniform_type: ClassVar[type] = XRayUniforms
    show: str = static("attenuation", choices=("attenuation", "transmission"), help="what is shown along the ray")
    low: F32 = param(0.0, at_least=0, help="optical depth at one end of what is shown")
    high: F32 | None = param(None, above=0, help="optical depth at the other end; None: the data's, or no end of transmission")

    def uniforms(self, context: Context) -> XRayUniforms:
        """Return the window.

        Raises
        ------
        ValueRangeError
            When it does not rise, or is left to a function that has none.
        """
        transmits = self.show == "transmission"
        high = self.high
        if high is None:
            high = math.inf if transmits else self.low + deepest(context, "xray.high")
        if high <= self.low:
            raise ValueRangeError("look.integrate.xray.high", f"is {high:g}, must be above low, {self.low:g}")
        black, white = (math.exp(-high), math.exp(-self.low)) if transmits else (self.low, high)
        return XRayUniforms(black, 1.0 / (white - black))


def deepest(context: Context, what: str, *, of_source: bool = False) -> float:
    """Depth of the data as it is, told from a function that is thinned.

    Raises
    ------
    ValueRangeError
        When the function is not one of a single value.
    """
    if not isinstance(context.transfer, TransferFunction):
        found = f"is left to the data, which is told only for a TransferFunction, not a {type(context.transfer).__name__}"
        raise ValueRangeError(f"look.integrate.{what}", found, "give it, in optical depth, e.g. 3")
    whole = context.transfer.scaled(1 / THINNED)
    return greatest_depth(context.volume, whole, context.channel, context.time, of_source=of_source)


@dataclass(frozen=True)
class AttenuatedMipUniforms:
    """The function's domain as a line to [0, 1], and attenuation per world unit at 1."""

    first: F32 = param(0.0, unit="data")
    per_value: F32 = param(1.0, unit="1/data")
    attenuation: F32 = param(0.0, unit="1/world")


@register
@dataclass(frozen=True)
class AttenuatedMip(Integrate):
    """The greatest value of what reaches the eye, dimmed by the values before it: near structures hide far ones.

    A value's strength runs from 0 at the first to 1 at the last value of the function; strength times ``attenuation`` is what
    attenuates those behind. The sample whose strength is greatest at the eye is shown in the function's colour, as dimmed as
    it arrives. Depth is where it lies.
    """

    name: ClassVar[str] = "attenuated_mip"
    wgsl: ClassVar[str] = "integrate/attenuated_mip.wgsl"
    extreme: ClassVar[str] = "greatest"
    uniform_type: ClassVar[type] = AttenuatedMipUniforms
    attenuation: F32 | None = param(
        None, unit="1/world", at_least=0, help="extinction at the last value of the function; None: 20 over the longest side"
    )

    def uniforms(self, context: Context) -> AttenuatedMipUniforms:
        """Return the line and the attenuation."""
        first, last = domain_of(context, self.name)
        sides = (n * s for n, s in zip(context.volume.size, context.volume.spacing, strict=True))
        attenuation = DEPTH_OF_ALL / max(sides) if self.attenuation is None else self.attenuation
        return AttenuatedMipUniforms(first, 1.0 / (last - first), attenuation)


@dataclass(frozen=True)
class DepthShadedMipUniforms:
    """The function's domain as a line to [0, 1], and where brightness begins and ends to fall."""

    first: F32 = param(0.0, unit="data")
    per_value: F32 = param(1.0, unit="1/data")
    near: F32 = param(0.0, unit="world")
    per_world: F32 = param(0.0, unit="1/world")
    darkest: F32 = param(0.0)


@register
@dataclass(frozen=True)
class DepthShadedMip(Integrate):
    """The greatest value along the ray when near ones count more: brightness falls with distance from the eye.

    A value's strength runs from 0 at the first to 1 at the last value of the function; it is multiplied by a brightness that
    falls straight from 1 at ``near`` to ``darkest`` at ``far``. The sample whose product is greatest is shown in the function's
    colour times that brightness. Depth is where it lies.
    """

    name: ClassVar[str] = "depth_shaded_mip"
    wgsl: ClassVar[str] = "integrate/depth_shaded_mip.wgsl"
    extreme: ClassVar[str] = "greatest"
    uniform_type: ClassVar[type] = DepthShadedMipUniforms
    darkest: F32 = param(0.2, at_least=0, up_to=1, help="brightness at the far end")
    near: F32 | None = param(None, unit="world", help="distance from the eye at which brightness falls; None: the near end")
    far: F32 | None = param(None, unit="world", help="distance from which on it is darkest; None: the volume's far end")

    def uniforms(self, context: Context) -> DepthShadedMipUniforms:
        """Return the lines; ends that are left to the volume are those of the sphere round it.

        Raises
        ------
        ValueRangeError
            When the range of distances does not rise.
        """
        first, last = domain_of(context, self.name)
        corners = context.volume.corners_world()
        middle = corners.mean(axis=0)
        away, reach = distance_from(context.camera, middle), float(np.linalg.norm(corners - middle, axis=1).max())
        near = max(away - reach, 0.0) if self.near is None else self.near
        far = away + reach if self.far is None else self.far
        if far <= near:
            where = "look.integrate.depth_shaded_mip.far"
            raise ValueRangeError(where, f"is {far:g}, must be above near, {near:g}", "give both, in world units from the eye")
        return DepthShadedMipUniforms(first, 1.0 / (last - first), near, 1.0 / (far - near), self.darkest)


def distance_from(camera: Camera, p_world: FloatArray) -> float:
    """Distance of a point from the eye, for parallel rays from the plane through it."""
    way = p_world - np.asarray(camera.eye)
    return float(way @ camera.basis()[2] if isinstance(camera, Orthographic) else np.linalg.norm(way))


def domain_of(context: Context, name: str) -> tuple[float, float]:
    """First and last value of a function of one variable.

    Raises
    ------
    ValueRangeError
        When it is another kind of function, or has one value alone.
    """
    function = context.transfer
    if not isinstance(function, TransferFunction):
        what = f"weighs values by the domain of a TransferFunction, and here is a {type(function).__name__}"
        raise ValueRangeError(f"look.integrate {name!r}", what, "use mip")
    first, last = function.domain
    if last <= first:
        what = f"weighs values by the domain of the function, which has the one value {first:g}"
        raise ValueRangeError(f"look.integrate {name!r}", what, "give it two points")
    return first, last


@dataclass(frozen=True)
class LocalMipUniforms:
    """Local maximum with the threshold resolved."""

    threshold: F32 = param(0.0, unit="data")
    drop: F32 = param(0.0, unit="data")


@register
@dataclass(frozen=True)
class LocalMip(Integrate):
    """The first local maximum that reaches the threshold, in the function's colour; the greatest value where none does.

    Sato et al. 1998: near vessels are seen in front of brighter ones that lie behind. Depth is where it lies.
    """

    name: ClassVar[str] = "local_mip"
    wgsl: ClassVar[str] = "integrate/local_mip.wgsl"
    extreme: ClassVar[str] = "greatest"
    uniform_type: ClassVar[type] = LocalMipUniforms
    threshold: F32 | None = param(None, unit="data", help="value to be reached; None: where extinction is half of its maximum")
    drop: F32 = param(0.0, unit="data", at_least=0, help="how far values must fall behind a maximum; against noise")

    def uniforms(self, context: Context) -> LocalMipUniforms:
        """Return the threshold.

        Raises
        ------
        ValueRangeError
            When it is left to a function of several variables, which has none.
        """
        if self.threshold is None and not isinstance(context.transfer, TransferFunction):
            what = "is left to the function, which is not one of a single value"
            raise ValueRangeError("look.integrate.local_mip.threshold", what, "give it: LocalMip(threshold=...)")
        return LocalMipUniforms(context.transfer.half_extinction_value if self.threshold is None else self.threshold, self.drop)
