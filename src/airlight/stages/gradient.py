"""Gradients: how the derivative of the field is found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from ..errors import StageError
from ..stage import STAGES, Context, GradientEncoding, GradientGrid, Resource, Stage, register, static
from ..transfer.joint import JointFunction
from ..volume import statistics
from .field import Linear
from .field_channels import scalar_range

LONGEST = 0.2  # gradient of signed bytes, as a share of the data's range per smallest voxel spacing
MOST_EXACT, MOST_OF_HALF = 2048, 6e4  # whole numbers up to here are exact in half floats; about the greatest of all


class Gradient(Stage):
    """Base of the gradients.

    ``reach_voxels`` tells that a component is a mean of differences of the field over at least a voxel, of places that lie so
    far away at most; None where it is something else.
    """

    slot: ClassVar[str] = "gradient"
    reach_voxels: ClassVar[int | None] = None

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return a layer's stages by slot, with what this gradient asks of the others."""
        return dict(chosen)


@register
@dataclass(frozen=True)
class Zero(Gradient):
    """No gradient: for looks that are not lit."""

    name: ClassVar[str] = "zero"
    wgsl: ClassVar[str] = "gradient/zero.wgsl"


@register
@dataclass(frozen=True)
class Central(Gradient):
    """Central differences of the field over one voxel to each side; one-sided at the faces of the grid."""

    name: ClassVar[str] = "central"
    wgsl: ClassVar[str] = "gradient/central.wgsl"
    reach_voxels: ClassVar[int | None] = 1


@register
@dataclass(frozen=True)
class Sobel(Gradient):
    """Central differences smoothed across by the weights 1, 2, 1: 26 neighbours instead of six, less noise."""

    name: ClassVar[str] = "sobel"
    wgsl: ClassVar[str] = "gradient/sobel.wgsl"
    reach_voxels: ClassVar[int | None] = 1


@register
@dataclass(frozen=True)
class Analytic(Gradient):
    """The derivative of the reconstruction itself, of the fields that tell it: linear ones and all filters."""

    name: ClassVar[str] = "analytic"
    wgsl: ClassVar[str] = "gradient/analytic.wgsl"
    asks_derivative: ClassVar[bool] = True


@register
@dataclass(frozen=True)
class Precomputed(Gradient):
    """Gradients computed once at the voxels, kept in a texture and interpolated.

    ``float16`` takes 8 bytes a voxel and keeps eleven bits of each component. ``snorm8`` takes 4; gradients longer than a fifth
    of the data's range per smallest voxel spacing are cut to that length and keep their direction: light asks for directions,
    and modulation counts in full from half of it on. ``with_value`` has the texture hold the samples, too; the field is then
    linear, and what half floats or eight bits cost is in ``image.stats``.
    """

    name: ClassVar[str] = "precomputed"
    wgsl: ClassVar[str] = "gradient/precomputed.wgsl"
    uniform_type: ClassVar[type | None] = GradientEncoding
    method: str = static("central", choices=("central", "sobel", "analytic"), help="gradient that is computed at the voxels")
    format: str = static("float16", choices=("float16", "snorm8"), help="numbers in the texture")
    with_value: bool = static(False, help="keep the samples beside their gradients, in one texture")

    @property
    def asks_derivative(self) -> bool:
        """Whether the method does."""
        return self.method == "analytic"

    @property
    def reach_voxels(self) -> int | None:  # type: ignore[override]
        """That of the method; what lies between voxels is a mean of theirs."""
        return getattr(STAGES["gradient"][self.method], "reach_voxels", None)

    def uniforms(self, context: Context) -> GradientEncoding:
        """Return how gradients lie in texels."""
        return self.encoding(context)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the grid of gradients."""
        return {"gradients": self.grid(context)}

    def errors(self, context: Context) -> dict[str, float]:
        """Return what rounding costs: half a step of a component, and the length to which gradients are cut."""
        encoding = self.encoding(context)
        if self.format == "float16":
            return {"component [data/world]": encoding.scale * 2.0**-12}
        return {"component [data/world]": encoding.scale / 254, "cut to [data/world]": encoding.scale}

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return the stages with the field that reads values and gradients from one texture, where that is asked for.

        Raises
        ------
        StageError
            When the samples are not those of one channel, without empty ones, in a linear field.
        """
        if not self.with_value:
            return dict(chosen)
        if type(chosen["field"]) is not Linear:
            found = f"keeps values for the field linear, of one channel without empty samples, not for {chosen['field'].name}"
            raise StageError("look.gradient 'precomputed'", found, "use with_value=False, or the field linear")
        return {**chosen, "field": LinearWithGradient(self), "gradient": Fetched(self.method, self.format, True)}

    def grid(self, context: Context, reader: Stage | None = None) -> GradientGrid:
        """Return the grid of gradients, read by the layer's field or by another.

        Raises
        ------
        StageError
            When lengths are cut of which a function of several variables is.
        """
        function = context.transfer
        if self.format == "snorm8" and isinstance(function, JointFunction) and {"gradient", "second"} & {*function.variables}:
            what = "cuts long gradients, and the transfer function is one of their lengths"
            raise StageError("look.gradient.precomputed.format", what, "use float16")
        method = STAGES["gradient"][self.method]()
        return GradientGrid(method, self.format, self.encoding(context), reader)

    def encoding(self, context: Context) -> GradientEncoding:
        """Return how gradients, and values with them, lie in texels."""
        greatest = max(scalar_range(context, "minimum", "maximum") / min(context.volume.spacing), 1e-30)
        values = value_encoding(context, self.format) if self.with_value else (0.0, 0.0)
        if self.format == "float16":
            return GradientEncoding(greatest, MOST_OF_HALF, *values)
        return GradientEncoding(LONGEST * greatest, 1.0, *values)


def value_encoding(context: Context, texel_format: str) -> tuple[float, float]:
    """Scale and offset of values, the middle of their range at zero; whole numbers stay whole where half floats hold them."""
    known = statistics(context.volume, context.channel, context.time)
    whole = context.volume.dtype.kind in "biu"
    middle = (known.minimum + known.maximum) / 2
    middle = float(round(middle)) if whole else middle
    reach = max(known.maximum - middle, middle - known.minimum)
    exact = texel_format == "float16" and whole and reach <= MOST_EXACT
    return (1.0 if exact else max(reach, 1e-30)), middle


@dataclass(frozen=True)
class LinearWithGradient(Linear):
    """Trilinear interpolation by the texture unit, of values that lie beside gradients: one fetch for both."""

    name: ClassVar[str] = "linear_with_gradient"
    wgsl: ClassVar[str] = "field/linear_with_gradient.wgsl"
    uniform_type: ClassVar[type | None] = GradientEncoding
    differentiable: ClassVar[bool] = False
    source: Precomputed = field(default_factory=Precomputed)

    @property
    def overshoot(self) -> float:
        """Rounding may leave the range of the samples."""
        return 1 / 250

    def uniforms(self, context: Context) -> GradientEncoding:
        """Return how values and gradients lie in texels."""
        return self.source.encoding(context)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples, and the grid that is made of them."""
        return {**super().resources(context), "gradients": self.source.grid(context, Linear())}

    def errors(self, context: Context) -> dict[str, float]:
        """Return what rounding costs, beside what it costs gradients."""
        scale, _ = value_encoding(context, self.source.format)
        step = 1 / 254 if self.source.format == "snorm8" else 0.0 if scale == 1.0 else 2.0**-12
        return {"value [data]": scale * step}


@dataclass(frozen=True)
class Fetched(Precomputed):
    """The gradient that the field has fetched with the value."""

    name: ClassVar[str] = "fetched"
    wgsl: ClassVar[str] = "gradient/fetched.wgsl"

    @property
    def asks_derivative(self) -> bool:
        """It was asked for when the grid was made."""
        return False

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return nothing: the grid is the field's."""
        return {}

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return the stages as they are."""
        return dict(chosen)


def at_voxels(stages: Mapping[str, Stage]) -> tuple[Stage, Stage]:
    """Return the field and the gradient by which a layer's gradients at the voxels are found, precomputed or not."""
    field, gradient = stages["field"], stages["gradient"]
    if isinstance(gradient, Precomputed):
        gradient = STAGES["gradient"][gradient.method]()
    return Linear() if isinstance(field, LinearWithGradient) else field, gradient
