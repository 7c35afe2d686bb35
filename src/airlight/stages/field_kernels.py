"""Fields by filters whose weights come from tables: windowed sincs, and kernels that users give."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from ..keeping import Kept
from ..reconstruction import kernels
from ..stage import U32, Context, Resource, Table, param, register, static
from ..transfer.given import listed
from ..volume import FloatArray
from .field import Field
from .field_channels import ChannelsUniforms, channels_values
from .field_filters import SHARES, Filter

GREATEST_RADIUS = 8  # 4096 voxels to a value
GREATEST_BODY_RADIUS = 4
PLACES_PER_VOXEL = 32  # at which kernels are sampled that are given as functions
LEAST_SUM = 0.05
KEPT_TABLES = 8


class Separable(Filter):
    """Base of the filters whose weights along each axis come from a table by the share of the way through a cell."""

    wgsl: ClassVar[str] = "field/separable.wgsl"
    radius: int

    def weights(self) -> tuple[FloatArray, FloatArray]:
        """Return weights and derivatives, (1025, 2 radius), at equal shares of the way through a cell."""
        raise NotImplementedError

    @property
    def support_voxels(self) -> float:
        """Return the radius."""
        return float(self.radius)

    @property
    def excess(self) -> float:
        """By the negative weights."""
        return kernels.overshoot_of(kernels.greatest_gain(self.weights()[0]))

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples, and the table: a row for two voxels, their weights and the derivatives of these."""

        def texels() -> FloatArray:
            return np.concatenate([part.reshape(len(SHARES), -1, 2) for part in self.weights()], axis=2).swapaxes(0, 1)[None]

        return {**super().resources(context), "weights": kept_table(self, texels)}


_TABLES: Kept[Field, Table] = Kept(KEPT_TABLES)


def kept_table(stage: Field, make: Callable[[], npt.NDArray[np.floating[Any]]]) -> Table:
    """Table of a stage, the same one each time; the last few are kept."""
    return _TABLES.get(stage, lambda: Table(make().astype(np.float32)))


@register
@dataclass(frozen=True)
class WindowedSinc(Separable):
    """The sinc, which is the ideal filter (Engel and Ertl, section 2.1), faded out by a window; it rings at edges."""

    name: ClassVar[str] = "windowed_sinc"
    window: str = static("lanczos", choices=("lanczos", "kaiser"), help="what the sinc is multiplied by")
    radius: U32 = param(3, unit="voxel", at_least=1, up_to=GREATEST_RADIUS, help="where the window ends")

    def weights(self) -> tuple[FloatArray, FloatArray]:
        """Return weights and derivatives, (1025, 2 radius), at equal shares of the way through a cell."""
        return kernels.tap_weights(kernels.windowed_sinc(self.window, self.radius), self.radius, SHARES, 1e-5)


def _places(radius: int, places_per_voxel: int, where: str, greatest_radius: int) -> FloatArray:
    """Distances at which a function is sampled, from ``-radius`` to ``radius``."""
    for name, value, most in (("radius", radius, greatest_radius), ("places_per_voxel", places_per_voxel, 1024)):
        if isinstance(value, bool) or not isinstance(value, Integral) or not 1 <= value <= most:
            raise ValueRangeError(f"{where}.{name}", f"is {value!r}, must be a whole number in [1, {most}]")
    return np.linspace(-radius, radius, 2 * int(radius) * int(places_per_voxel) + 1)


def _numbers(given: Any, where: str, shape: tuple[int, ...] | None = None) -> FloatArray:
    """Return what is given as an array: of a shape that it can be repeated to, or a list."""
    try:
        found = np.asarray(given if shape is not None else listed(given, where, "give numbers"), dtype=np.float64)
        found = found if shape is None else np.broadcast_to(found, shape)
    except (TypeError, ValueError) as error:
        if isinstance(error, ValueRangeError):
            raise
        raise ValueRangeError(where, f"are no numbers that fit ({error})", "give one number for each place") from error
    if shape is None and found.ndim != 1:
        raise ValueRangeError(where, f"are nested, of shape {found.shape}", "give a flat list of numbers")
    return found


def _sampled(kernel: kernels.Function, radius: int, places_per_voxel: int = PLACES_PER_VOXEL) -> tuple[float, ...]:
    places = _places(radius, places_per_voxel, "field.kernel", GREATEST_RADIUS)
    return tuple(_numbers(kernel(places), "field.kernel.samples", places.shape).tolist())


def _gaussian(x: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-2 * x**2) - math.exp(-8))


@register
@dataclass(frozen=True)
class Kernel(Separable):
    """Any separable filter: samples of its kernel, at equal distances from ``-radius`` to ``radius``, straight in between.

    It is divided by the sum of its weights at each place, so that constants stay what they are. The derivative is that of
    differences from sample to sample. ``Kernel.of`` makes one of a function.

    Raises
    ------
    ValueRangeError
        For less than three samples, or weights whose sum comes near zero somewhere.
    """

    name: ClassVar[str] = "kernel"
    samples: tuple[float, ...] = param(
        (), help="the kernel from -radius to radius; none: a Gaussian of a quarter of the radius"
    )
    radius: U32 = param(2, unit="voxel", at_least=1, up_to=GREATEST_RADIUS, help="distance at which the kernel ends")

    @staticmethod
    def of(kernel: kernels.Function, radius: int, places_per_voxel: int = PLACES_PER_VOXEL) -> Kernel:
        """Return the filter of a function, which is called with distances (n,) in voxels."""
        return Kernel(_sampled(kernel, radius, places_per_voxel), radius)

    def __post_init__(self) -> None:
        """Check the samples; without any take those of a Gaussian."""
        object.__setattr__(self, "samples", tuple(_numbers(self.samples, "field.kernel.samples").tolist()))
        super().__post_init__()
        if not self.samples:
            object.__setattr__(self, "samples", _sampled(lambda x: _gaussian(2 * x / self.radius), self.radius))
        if len(self.samples) < 3:
            raise ValueRangeError("field.kernel.samples", f"are {len(self.samples)}", "give at least three")
        if kernels.least_sum(kernels.tabulated(self.samples, self.radius), self.radius) < LEAST_SUM:
            raise _nothing("field.kernel.samples")

    def weights(self) -> tuple[FloatArray, FloatArray]:
        """Return weights and derivatives, (1025, 2 radius), at equal shares of the way through a cell."""
        kernel = kernels.tabulated(self.samples, self.radius)
        return kernels.tap_weights(kernel, self.radius, SHARES, 2 * self.radius / (len(self.samples) - 1))


def _nothing(where: str) -> ValueRangeError:
    return ValueRangeError(where, "sum up to almost nothing at some places", "a filter has weights whose sum is not zero")


@dataclass(frozen=True, eq=False)
class BodyUniforms(ChannelsUniforms):
    """How many voxels of an axis have weight, and the places of the table."""

    taps: U32 = param(2, unit="voxel")
    places: U32 = param(3)


@register
@dataclass(frozen=True)
class KernelBody(Filter):
    """Any filter, also one that is no product of three: a cube of samples of its kernel, interpolated. Slow.

    Samples run from ``-radius`` to ``radius`` along x, then y, then z. They are divided by the sum of their weights at each
    place. ``KernelBody.of`` makes one of a function of x, y and z.

    Raises
    ------
    ValueRangeError
        When the samples are no cube of at least three a side, or their weights' sum comes near zero somewhere.
    """

    name: ClassVar[str] = "kernel_body"
    wgsl: ClassVar[str] = "field/kernel_body.wgsl"
    uniform_type: ClassVar[type | None] = BodyUniforms
    samples: tuple[float, ...] = param((), help="the kernel in a cube, x fastest; none: a cosine lobe of the distance")
    radius: U32 = param(2, unit="voxel", at_least=1, up_to=GREATEST_BODY_RADIUS, help="distance at which the kernel ends")

    @staticmethod
    def of(
        kernel: Callable[[FloatArray, FloatArray, FloatArray], npt.ArrayLike], radius: int, places_per_voxel: int = 8
    ) -> KernelBody:
        """Return the filter of a function, which is called with x, y and z, arrays of one shape, in voxels."""
        place = _places(radius, places_per_voxel, "field.kernel_body", GREATEST_BODY_RADIUS)
        z, y, x = np.meshgrid(place, place, place, indexing="ij")
        found = _numbers(kernel(x, y, z), "field.kernel_body.samples", x.shape)
        return KernelBody(tuple(found.ravel().tolist()), radius)

    def __post_init__(self) -> None:
        """Check the samples; without any take those of a lobe that depends on the distance alone."""
        object.__setattr__(self, "samples", tuple(_numbers(self.samples, "field.kernel_body.samples").tolist()))
        super().__post_init__()
        if not self.samples:
            object.__setattr__(self, "samples", KernelBody.of(_lobe, 2).samples)
        side = self.side
        if side < 3 or side**3 != len(self.samples):
            raise ValueRangeError("field.kernel_body.samples", f"are {len(self.samples)}", "give a cube of at least 3 a side")
        if self._sums[0] < LEAST_SUM:
            raise _nothing("field.kernel_body.samples")

    @property
    def side(self) -> int:
        """Samples along an axis."""
        return round(float(np.cbrt(len(self.samples))))

    @property
    def cube(self) -> FloatArray:
        """The samples ``(z, y, x)``."""
        return np.reshape(np.array(self.samples), (self.side,) * 3)

    @property
    def support_voxels(self) -> float:
        """Return the radius."""
        return float(self.radius)

    @property
    def excess(self) -> float:
        """By the negative weights."""
        return (self._sums[1] - 1) / 2

    @cached_property
    def _sums(self) -> tuple[float, float]:
        """Least sum of the weights at a place of a cell, zero where it changes its sign, and greatest gain.

        Weights are straight along each axis between the places where a voxel meets a sample of the kernel: both are found
        at the corners of these.
        """
        side, taps = self.side, 2 * self.radius
        corners = sorted({k * taps % (side - 1) for k in range(side)} | {side - 1})  # over side - 1
        place = (np.array(corners) / (side - 1))[:, None] + (taps - 1 - np.arange(taps))
        place *= (side - 1) / taps
        low = np.minimum(place.astype(int), side - 2)
        share = place - low

        def along(values: FloatArray, axis: int, at: Any) -> FloatArray:
            below, above = np.take(values, low[at], axis), np.take(values, low[at] + 1, axis)
            weight = np.reshape(share[at], (*share[at].shape, *(1,) * (values.ndim - 1 - axis)))
            return np.asarray(below * (1 - weight) + above * weight)

        least, greatest, sign = math.inf, 1.0, 0.0
        for corner in range(len(corners)):
            weights = along(along(along(self.cube, 0, corner), 1, slice(None)), 3, slice(None))
            total, size = (part.sum(axis=(0, 2, 4)) for part in (weights, np.abs(weights)))
            sign = sign or float(np.sign(total.flat[0]))
            least = min(least, float((sign * total).min()))
            if least < LEAST_SUM:
                return max(least, 0.0), math.inf
            greatest = max(greatest, float((size / np.abs(total)).max()))
        return least, greatest

    def uniforms(self, context: Context) -> Any:
        """Return the voxels along an axis, and the samples of the kernel."""
        return BodyUniforms(**channels_values(context), taps=2 * self.radius, places=self.side)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples of the volume and those of the kernel, with its derivatives along x, y and z."""

        def texels() -> FloatArray:
            slopes = np.gradient(self.cube, 2 * self.radius / (self.side - 1))
            return np.stack([self.cube, *slopes[::-1]], axis=-1)

        return {**super().resources(context), "weights": kept_table(self, texels)}


def _lobe(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """One at the middle, zero at a distance of 1.6 voxels."""
    return np.asarray(np.cos(np.pi / 2 * np.minimum(np.sqrt(x * x + y * y + z * z) / 1.6, 1.0)) ** 2)
