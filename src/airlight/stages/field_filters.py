"""Fields by cubic filters, which take the 64 voxels round a place; those of other filters are in ``field_kernels.py``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError
from ..reconstruction import kernels, spline
from ..stage import F32, Context, Grid, Mat4f, Resource, param, register, static
from .field import Field
from .field_channels import ChannelsUniforms, channels_values

SHARES = np.linspace(0.0, 1.0, 1025)  # of the way through a cell, at which weights are looked at


@dataclass(frozen=True)
class Filter(Field):
    """Base of the fields that take more voxels than the eight round a place.

    Empty samples are left out: sums over the others are divided by the sum of their weights, and where that is below half there
    is nothing (normalised convolution, Knutsson and Westin 1993). Channels have the same weights.
    """

    uniform_type: ClassVar[type | None] = ChannelsUniforms
    differentiable: ClassVar[bool] = True
    masked: bool = field(default=False, kw_only=True, repr=False)

    @property
    def excess(self) -> float:
        """By how much of its samples' range the field may leave it where all samples are there."""
        return 0.0

    @property
    def overshoot(self) -> float:
        """By the negative weights; twice as much where the others may weigh no more than half."""
        return (2 if self.masked else 1) * self.excess

    def uniforms(self, context: Context) -> Any:
        """Return the places of several channels."""
        return ChannelsUniforms(**channels_values(context))

    def for_empty(self) -> Field:
        """Return the same filter over marked samples."""
        return replace(self, masked=True)

    def for_channels(self) -> Field:
        """Return the filter itself."""
        return self


@dataclass(frozen=True, eq=False)
class CubicUniforms(ChannelsUniforms):
    """Weights of the four voxels of an axis: a column for each power of the share of the way through a cell."""

    basis: Mat4f = param(None)


class Cubic(Filter):
    """Base of the filters of Mitchell and Netravali's family: 64 voxels, weights in full precision."""

    wgsl: ClassVar[str] = "field/cubic.wgsl"
    uniform_type: ClassVar[type | None] = CubicUniforms

    @property
    def family(self) -> tuple[float, float]:
        """The parameters B and C."""
        raise NotImplementedError

    @property
    def support_voxels(self) -> float:
        """Two voxels."""
        return 2.0

    @property
    def excess(self) -> float:
        """By the negative weights."""
        return kernels.overshoot_of(kernels.greatest_gain(kernels.cubic_weights(*self.family, SHARES)))

    def uniforms(self, context: Context) -> Any:
        """Return the weights as polynomials."""
        return CubicUniforms(**channels_values(context), basis=kernels.cubic_basis(*self.family))


class Spline(Filter):
    """What cubic B-splines share: with ``prefilter`` they run through the samples, without they smooth them."""

    prefilter: bool

    @property
    def support_voxels(self) -> float:
        """Two voxels."""
        return 2.0

    @property
    def excess(self) -> float:
        """None: weights are positive, those of coefficients, too."""
        return 0.0

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples, or the coefficients that stand for them."""
        if not self.prefilter:
            return super().resources(context)
        volume = spline.coefficients(context.volume, context.channels, context.time)
        return {"grid": Grid(volume, tuple(range(volume.channel_count)), 0, self.filtered)}

    def for_empty(self) -> Field:
        """Return the exact spline over marked samples.

        Raises
        ------
        StageError
            When it is to go through the samples, which asks for all of them.
        """
        if self.prefilter:
            what = "goes through the samples, and some are empty (NaN, no-data)"
            raise StageError(f"look.field.{self.name}.prefilter", what, "use prefilter=false or catmull_rom, or fill them")
        return BSplineExact(masked=True)


@register
@dataclass(frozen=True)
class BSpline(Spline):
    """Cubic B-spline by eight fetches of the texture unit, whose weights have eight bits on most GPUs.

    Sigg and Hadwiger, GPU Gems 2, chapter 20; Engel and Ertl, section 7. Smooth to the second derivative. Texture units that
    weigh in full precision make it equal to ``bspline_exact``.
    """

    name: ClassVar[str] = "bspline"
    wgsl: ClassVar[str] = "field/bspline.wgsl"
    filtered: ClassVar[bool] = True
    prefilter: bool = static(False, help="go through the samples: coefficients in their place, computed once")

    def for_channels(self) -> Field:
        """Return the exact spline."""
        return self.converging()

    def converging(self) -> Field:
        """Return the exact spline."""
        return BSplineExact(self.prefilter)


@register
@dataclass(frozen=True)
class BSplineExact(Spline, Cubic):
    """Cubic B-spline as the sum over 64 voxels, in full precision."""

    name: ClassVar[str] = "bspline_exact"
    prefilter: bool = static(False, help="go through the samples: coefficients in their place, computed once")

    @property
    def family(self) -> tuple[float, float]:
        """The parameters B and C."""
        return 1.0, 0.0


@register
@dataclass(frozen=True)
class CatmullRom(Cubic):
    """Cubic filter that goes through the samples and keeps quadratics; sharper than linear, and it overshoots."""

    name: ClassVar[str] = "catmull_rom"

    @property
    def family(self) -> tuple[float, float]:
        """The parameters B and C."""
        return 0.0, 0.5


@register
@dataclass(frozen=True)
class Mitchell(Cubic):
    """Cubic filter between smoothing and ringing (Mitchell and Netravali, SIGGRAPH 1988); any B and C."""

    name: ClassVar[str] = "mitchell"
    b: F32 = param(1 / 3, at_least=0, up_to=2, help="share of the B-spline; 1 with c 0 is it")
    c: F32 = param(1 / 3, at_least=0, up_to=2, help="sharpness; 0.5 with b 0 is Catmull-Rom")

    @property
    def family(self) -> tuple[float, float]:
        """The parameters B and C."""
        return self.b, self.c
