"""Fields: the continuous function that reconstruction makes of the samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ..errors import StageError
from ..stage import ClassifiedGrid, Context, Grid, Resource, Stage, register, static
from ..transfer.channels import Channels
from ..transfer.function import TransferFunction
from .transfer import FromField, PostClassified


class Field(Stage):
    """Base of the fields: how far they reach, how far they overshoot, and where they are defined.

    Attributes
    ----------
    cells
        Whether the domain is that of voxel cells, ``[-0.5, n - 0.5]``, instead of centres, ``[0, n - 1]``.
    smooth
        Whether the field has a curvature between samples that are a step apart, which drivers may put right.
    differentiable
        Whether the device half has ``field_derivative``, which the gradient stage ``analytic`` asks for.
    instead_if_empty
        What to do about empty samples where the field would spread them.
    masked
        Whether empty samples are marked and left out.
    looks_there_alone
        Whether a value is what the texture unit interpolates at its own place: in layers, on one of them, a single fetch.
    """

    slot: ClassVar[str] = "field"
    instead_if_empty: ClassVar[str] = "use linear, or fill them"
    cells: ClassVar[bool] = False
    smooth: ClassVar[bool] = True
    filtered: ClassVar[bool] = False
    differentiable: ClassVar[bool] = False
    masked: bool = False
    looks_there_alone: ClassVar[bool] = False

    @property
    def support_voxels(self) -> float:
        """Distance from a point beyond which nothing that the field's grid holds has influence."""
        return 1.0

    @property
    def overshoot(self) -> float:
        """By how much of the range of what its grid holds the field may leave it."""
        return 0.0

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the grid of the layer's channels and time step."""
        return {"grid": Grid(context.volume, context.channels, context.time, self.filtered, self.masked)}

    def groups(self, context: Context) -> int:
        """Return the number of vectors of four that a value has, 0 where it is a single number."""
        return 0 if len(context.channels) == 1 else len(needed_groups(context))

    def variant(self, context: Context) -> dict[str, bool]:
        """Return what voxels are read: several channels, marked samples; it decides which file fills ``slot::taps``."""
        return {"packed": self.groups(context) > 0, "masked": self.masked}

    def for_empty(self) -> Field:
        """Return the field that keeps empty samples (NaN, no-data) from spreading; taken for volumes that have any."""
        raise StageError(f"look.field {self.name!r}", "cannot keep empty samples (NaN, no-data) apart", self.instead_if_empty)

    def for_channels(self) -> Field:
        """Return the field that reconstructs several channels at once."""
        raise StageError(f"look.field {self.name!r}", "draws one channel at a time", "use linear or nearest")

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return a layer's stages by slot, with this field and what it asks of the others.

        Raises
        ------
        StageError
            When the derivative of a field is asked for that does not tell it.
        """
        if not self.differentiable and getattr(chosen["gradient"], "asks_derivative", False):
            where = f"look.gradient {chosen['gradient'].name!r}"
            raise StageError(where, f"asks for a derivative that the field {self.name} does not have", "use central")
        return {**chosen, "field": self}


def needed_groups(context: Context) -> tuple[int, ...]:
    """Groups of four, of the channels in the texture, that a value holds: those of which a channel is drawn."""
    if isinstance(context.transfer, Channels):
        return tuple(sorted({place // 4 for place in context.transfer.places(context.volume)}))
    return tuple(range(-(-len(context.channels) // 4)))


@register
@dataclass(frozen=True)
class Nearest(Field):
    """The value of the nearest voxel; the domain is that of cells."""

    name: ClassVar[str] = "nearest"
    wgsl: ClassVar[str] = "field/nearest.wgsl"
    cells: ClassVar[bool] = True
    smooth: ClassVar[bool] = False

    @property
    def support_voxels(self) -> float:
        """Half a voxel."""
        return 0.5

    def for_empty(self) -> Field:
        """Return the nearest field over marked samples."""
        return NearestMasked()

    def for_channels(self) -> Field:
        """Return the nearest field of several channels."""
        from .field_channels import NearestChannels

        return NearestChannels()


@register
@dataclass(frozen=True)
class Linear(Field):
    """Trilinear interpolation by the texture unit; GPUs filter with weights of eight bits."""

    name: ClassVar[str] = "linear"
    wgsl: ClassVar[str] = "field/linear.wgsl"
    looks_there_alone: ClassVar[bool] = True
    differentiable: ClassVar[bool] = True
    filtered: ClassVar[bool] = True

    def for_empty(self) -> Field:
        """Return the linear field over marked samples."""
        return LinearMasked()

    def for_channels(self) -> Field:
        """Return the linear field of several channels."""
        from .field_channels import LinearChannels

        return LinearChannels()

    def converging(self) -> Field:
        """Return the field whose weights are exact."""
        return LinearExact()


@register
@dataclass(frozen=True)
class LinearExact(Field):
    """Trilinear interpolation in the shader, in full precision."""

    name: ClassVar[str] = "linear_exact"
    wgsl: ClassVar[str] = "field/linear_exact.wgsl"
    differentiable: ClassVar[bool] = True

    def for_empty(self) -> Field:
        """Return the linear field over marked samples."""
        return LinearMasked()

    def for_channels(self) -> Field:
        """Return the linear field, in full precision, of several channels."""
        from .field_channels import LinearExactChannels

        return LinearExactChannels()


@dataclass(frozen=True)
class NearestMasked(Nearest):
    """The value of the nearest voxel, where empty voxels are transparent."""

    name: ClassVar[str] = "nearest_masked"
    masked = True


@dataclass(frozen=True)
class LinearMasked(LinearExact):
    """Trilinear interpolation of the samples that are there; empty where less than half of the weight is."""

    name: ClassVar[str] = "linear_masked"
    masked = True


@register
@dataclass(frozen=True)
class PreClassified(Field):
    """Classify the voxels, then interpolate extinction and associated colour; it takes the place of the transfer stage.

    Engel and Ertl, section 2.2 and figure 3. Features of the function that are narrower than what changes from voxel to voxel
    are lost or torn. Gradients are those of the samples. The media of all voxels lie in a table of 32-bit floats, 16 bytes a
    voxel, which is made anew for another function.
    """

    name: ClassVar[str] = "preclassified"
    wgsl: ClassVar[str] = "field/preclassified.wgsl"
    looks_there_alone: ClassVar[bool] = True
    filtered: ClassVar[bool] = True
    weighted: bool = static(True, help="interpolate colours times extinction; without, those of clear voxels bleed")

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the samples and their media.

        Raises
        ------
        StageError
            When the layer's function is not one of a single value, or has surfaces.
        """
        if not isinstance(context.transfer, TransferFunction):
            what = type(context.transfer).__name__
            raise StageError(f"look.field {self.name!r}", f"cannot classify voxels by a {what}", "use linear")
        if context.transfer.surfaces:
            raise StageError(f"look.field {self.name!r}", "draws no surfaces of equal value", "use linear")
        grid = Grid(context.volume, context.channels, context.time, self.filtered, self.masked)
        reader = MaskedVoxels() if self.masked else Voxels()
        return {"grid": grid, "classified": ClassifiedGrid(grid, context.transfer, self.weighted, reader, PostClassified())}

    def groups(self, context: Context) -> int:
        """Return 1: a value is a medium."""
        return 1

    def for_empty(self) -> Field:
        """Return the field over marked samples."""
        return PreClassifiedMasked(self.weighted)

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return a layer's stages with the transfer stage that takes media as they come.

        Raises
        ------
        StageError
            When another stage looks at values, which are no more.
        """
        for slot in ("integrate", "modulation"):
            if getattr(chosen[slot], "uses_values", True):
                where = f"look.{slot} {chosen[slot].name!r}"
                raise StageError(where, f"looks at values, and the field {self.name!r} has media", "use the field linear")
        return {**super().arranged(chosen), "transfer": FromField(self.weighted)}


@dataclass(frozen=True)
class PreClassifiedMasked(PreClassified):
    """Media of the voxels that are there, interpolated; empty where less than half of the weight is."""

    name: ClassVar[str] = "preclassified_masked"
    wgsl: ClassVar[str] = "field/preclassified_masked.wgsl"
    filtered: ClassVar[bool] = False
    looks_there_alone: ClassVar[bool] = False
    masked = True


@dataclass(frozen=True)
class Voxels(LinearExact):
    """Reader of single voxels from the texture that fields filter."""

    filtered: ClassVar[bool] = True


@dataclass(frozen=True)
class MaskedVoxels(LinearMasked):
    """Reader of single voxels where some are empty."""


# The other fields, under the one name that users know.
from .field_filters import BSpline as BSpline  # noqa: E402
from .field_filters import BSplineExact as BSplineExact  # noqa: E402
from .field_filters import CatmullRom as CatmullRom  # noqa: E402
from .field_filters import Mitchell as Mitchell  # noqa: E402
from .field_kernels import Kernel as Kernel  # noqa: E402
from .field_kernels import KernelBody as KernelBody  # noqa: E402
from .field_kernels import WindowedSinc as WindowedSinc  # noqa: E402
from .field_levels import Levels as Levels  # noqa: E402
from .field_stack import LinearStack as LinearStack  # noqa: E402
