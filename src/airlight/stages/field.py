"""Fields: the continuous function that reconstruction makes of the samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ..errors import StageError
from ..stage import Context, Grid, Resource, Stage, register


class Field(Stage):
    """Base of the fields: how far they reach, how far they overshoot, and where they are defined.

    Attributes
    ----------
    support_voxels
        Distance from a point beyond which no sample has influence.
    overshoot
        By how much of the samples' range the field may leave it.
    cells
        Whether the domain is that of voxel cells, ``[-0.5, n - 0.5]``, instead of centres, ``[0, n - 1]``.
    """

    slot: ClassVar[str] = "field"
    support_voxels: ClassVar[float] = 1.0
    overshoot: ClassVar[float] = 0.0
    cells: ClassVar[bool] = False
    filtered: ClassVar[bool] = False
    masked: ClassVar[bool] = False

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the grid of the layer's channel and time step."""
        return {"grid": Grid(context.volume, context.channel, context.time, self.filtered, self.masked)}

    def for_empty(self) -> Field:
        """Return the field that keeps empty samples (NaN, no-data) from spreading; taken for volumes that have any."""
        raise StageError(f"look.field {self.name!r}", "cannot draw a volume with empty samples (NaN, no-data)", "fill them")


@register
@dataclass(frozen=True)
class Nearest(Field):
    """The value of the nearest voxel; the domain is that of cells."""

    name: ClassVar[str] = "nearest"
    wgsl: ClassVar[str] = "field/nearest.wgsl"
    support_voxels: ClassVar[float] = 0.5
    cells: ClassVar[bool] = True

    def for_empty(self) -> Field:
        """Return the nearest field over marked samples."""
        return NearestMasked()


@register
@dataclass(frozen=True)
class Linear(Field):
    """Trilinear interpolation by the texture unit; GPUs filter with weights of eight bits."""

    name: ClassVar[str] = "linear"
    wgsl: ClassVar[str] = "field/linear.wgsl"
    filtered: ClassVar[bool] = True

    def for_empty(self) -> Field:
        """Return the linear field over marked samples."""
        return LinearMasked()


@register
@dataclass(frozen=True)
class LinearExact(Field):
    """Trilinear interpolation in the shader, in full precision."""

    name: ClassVar[str] = "linear_exact"
    wgsl: ClassVar[str] = "field/linear_exact.wgsl"

    def for_empty(self) -> Field:
        """Return the linear field over marked samples."""
        return LinearMasked()


@dataclass(frozen=True)
class NearestMasked(Nearest):
    """The value of the nearest voxel, where empty voxels are transparent."""

    name: ClassVar[str] = "nearest_masked"
    wgsl: ClassVar[str] = "field/nearest_masked.wgsl"
    masked: ClassVar[bool] = True


@dataclass(frozen=True)
class LinearMasked(LinearExact):
    """Trilinear interpolation of the samples that are there; empty where less than half of the weight is."""

    name: ClassVar[str] = "linear_masked"
    wgsl: ClassVar[str] = "field/linear_masked.wgsl"
    masked: ClassVar[bool] = True
