"""Fields by filters whose weights come from tables: windowed sincs, and kernels that users give."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from ..reconstruction import kernels
from ..stage import U32, Context, Resource, Table, param, register, static
from ..volume import FloatArray
from .field import Field
from .field_filters import SHARES, Filter

GREATEST_RADIUS = 8  # 4096 voxels to a value
PLACES_PER_VOXEL = 32  # at which kernels are sampled that are given as functions
LEAST_SUM = 0.05
KEPT_TABLES = 8


@dataclass(frozen=True, eq=False)
class SeparableUniforms:
    """How many pairs of voxels of an axis have weight."""

    pairs: U32 = param(1)


class Separable(Filter):
    """Base of the filters whose weights along each axis come from a table by the share of the way through a cell."""

    wgsl: ClassVar[str] = "field/separable.wgsl"
    uniform_type: ClassVar[type | None] = SeparableUniforms
    radius: int

    def weights(self) -> tuple[FloatArray, FloatArray]:
        """Return weights and derivatives, (1025, 2 radius), at equal shares of the way through a cell."""
        raise NotImplementedError

    @property
    def support_voxels(self) -> float:
        """Return the radius."""
        return float(self.radius)

    @property
    def overshoot(self) -> float:
        """By the negative weights."""
        return kernels.overshoot_of(kernels.greatest_gain(self.weights()[0]))

    def uniforms(self, context: Context) -> Any:
        """Return the number of pairs of voxels along an axis, one on either side."""
        return SeparableUniforms(self.radius)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples, and the table: a row for two voxels, their weights and the derivatives of these."""

        def texels() -> FloatArray:
            return np.concatenate([part.reshape(len(SHARES), -1, 2) for part in self.weights()], axis=2).swapaxes(0, 1)[None]

        return {**super().resources(context), "weights": kept_table(self, texels)}


_TABLES: dict[Field, Table] = {}


def kept_table(stage: Field, make: Callable[[], npt.NDArray[np.floating[Any]]]) -> Table:
    """Table of a stage, the same one each time; the last few are kept."""
    if stage not in _TABLES:
        while len(_TABLES) >= KEPT_TABLES:
            del _TABLES[next(iter(_TABLES))]
        _TABLES[stage] = Table(make().astype(np.float32))
    return _TABLES[stage]


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


def _sampled(kernel: kernels.Function, radius: int, places_per_voxel: int = PLACES_PER_VOXEL) -> tuple[float, ...]:
    places = np.linspace(-radius, radius, 2 * radius * places_per_voxel + 1)
    return tuple(float(w) for w in np.asarray(kernel(places), dtype=np.float64))


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
        object.__setattr__(self, "samples", tuple(float(w) for w in self.samples))
        super().__post_init__()
        if not self.samples:
            object.__setattr__(self, "samples", _sampled(lambda x: _gaussian(2 * x / self.radius), self.radius))
        if len(self.samples) < 3:
            raise ValueRangeError("field.kernel.samples", f"are {len(self.samples)}", "give at least three")
        if kernels.least_sum(kernels.tabulated(self.samples, self.radius), self.radius) < LEAST_SUM:
            raise ValueRangeError(
                "field.kernel.samples", "sum up to almost nothing at some places", "a filter has weights whose sum is not zero"
            )

    def weights(self) -> tuple[FloatArray, FloatArray]:
        """Return weights and derivatives, (1025, 2 radius), at equal shares of the way through a cell."""
        kernel = kernels.tabulated(self.samples, self.radius)
        return kernels.tap_weights(kernel, self.radius, SHARES, 2 * self.radius / (len(self.samples) - 1))


@dataclass(frozen=True, eq=False)
class BodyUniforms:
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
        When the samples are no cube of at least three a side.
    """

    name: ClassVar[str] = "kernel_body"
    wgsl: ClassVar[str] = "field/kernel_body.wgsl"
    uniform_type: ClassVar[type | None] = BodyUniforms
    samples: tuple[float, ...] = param((), help="the kernel in a cube, x fastest; none: a cosine lobe of the distance")
    radius: U32 = param(2, unit="voxel", at_least=1, up_to=4, help="distance at which the kernel ends")

    @staticmethod
    def of(
        kernel: Callable[[FloatArray, FloatArray, FloatArray], npt.ArrayLike], radius: int, places_per_voxel: int = 8
    ) -> KernelBody:
        """Return the filter of a function, which is called with x, y and z, arrays of one shape, in voxels."""
        place = np.linspace(-radius, radius, 2 * radius * places_per_voxel + 1)
        z, y, x = np.meshgrid(place, place, place, indexing="ij")
        found = np.broadcast_to(np.asarray(kernel(x, y, z), dtype=np.float64), x.shape)
        return KernelBody(tuple(found.ravel().tolist()), radius)

    def __post_init__(self) -> None:
        """Check the samples; without any take those of a lobe that depends on the distance alone."""
        object.__setattr__(self, "samples", tuple(float(w) for w in self.samples))
        super().__post_init__()
        if not self.samples:
            object.__setattr__(self, "samples", KernelBody.of(_lobe, 2).samples)
        side = self.side
        if side < 3 or side**3 != len(self.samples):
            raise ValueRangeError("field.kernel_body.samples", f"are {len(self.samples)}", "give a cube of at least 3 a side")

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
    def overshoot(self) -> float:
        """By the negative weights."""
        distance = np.linspace(-self.radius, self.radius, self.side)
        phase = np.floor((distance + self.radius) * 16).astype(int) % 16
        sums = np.zeros((2, 16, 16, 16))
        places = np.ix_(phase, phase, phase)
        np.add.at(sums[0], places, np.abs(self.cube))
        np.add.at(sums[1], places, self.cube)
        known = sums[1] != 0
        return float((np.divide(sums[0], sums[1], where=known, out=np.ones_like(sums[0])).max() - 1) / 2)

    def uniforms(self, context: Context) -> Any:
        """Return the voxels along an axis, and the samples of the kernel."""
        return BodyUniforms(2 * self.radius, self.side)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples of the volume and those of the kernel, with its derivatives along x, y and z."""

        def texels() -> FloatArray:
            slopes = np.gradient(self.cube, 2 * self.radius / (self.side - 1))
            return np.stack([self.cube, *slopes[::-1]], axis=-1)

        return {**super().resources(context), "weights": kept_table(self, texels)}


def _lobe(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """One at the middle, zero at a distance of 1.6 voxels."""
    return np.asarray(np.cos(np.pi / 2 * np.minimum(np.sqrt(x * x + y * y + z * z) / 1.6, 1.0)) ** 2)
