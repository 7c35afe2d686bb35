"""Fields by cubic filters, which take the 64 voxels round a place; those of other filters are in ``field_kernels.py``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..reconstruction import kernels, spline
from ..stage import F32, Context, Grid, Mat4f, Resource, param, register, static
from .field import Field

SHARES = np.linspace(0.0, 1.0, 1025)  # of the way through a cell, at which weights are looked at


class Filter(Field):
    """Base of the fields that take more voxels than the eight round a place."""

    differentiable: ClassVar[bool] = True

    instead_if_empty: ClassVar[str] = "use linear or nearest, or fill them"


@dataclass(frozen=True, eq=False)
class CubicUniforms:
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
    def overshoot(self) -> float:
        """By the negative weights."""
        return kernels.overshoot_of(kernels.greatest_gain(kernels.cubic_weights(*self.family, SHARES)))

    def uniforms(self, context: Context) -> Any:
        """Return the weights as polynomials."""
        return CubicUniforms(kernels.cubic_basis(*self.family))


class Spline(Filter):
    """What cubic B-splines share: with ``prefilter`` they run through the samples, without they smooth them."""

    prefilter: bool

    @property
    def support_voxels(self) -> float:
        """Two voxels."""
        return 2.0

    @property
    def overshoot(self) -> float:
        """None: weights are positive, those of coefficients, too."""
        return 0.0

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples, or the coefficients that stand for them."""
        if not self.prefilter:
            return super().resources(context)
        volume = spline.coefficients(context.volume, context.channel, context.time)
        return {"grid": Grid(volume, (0,), 0, self.filtered)}


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
