"""Transfer functions with surfaces of equal value: what stands in for the transfer stages that integrate along a slab."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, ClassVar

from ..errors import StageError
from ..stage import F32, U32, Context, Estimate, Resource, SlabTable, Stretches, Table, param
from ..transfer import TransferFunction
from ..transfer.crossings import (
    LAYERS_ALONE,
    LAYERS_IN_MEDIUM,
    ROWS_ALONE,
    ROWS_IN_MEDIUM,
    bin_count,
    crossing_error,
    lowered,
    packed_pairs,
    surface_texels,
)
from ..transfer.runs import iso_values, medium_of
from ..transfer.surfaces import holds_medium
from ..volume import statistics
from .transfer import ExactPreIntegrated, FastPreIntegrated, FunctionUniforms, PreIntegrated, Transfer

ROUNDING = 2.0**-21  # of the greatest value: what 32-bit samples are uncertain by, and a little more


@dataclass(frozen=True, eq=False)
class SurfaceUniforms(FunctionUniforms):
    """The axis of the function, and how its surfaces are found."""

    surface_first: F32 = param(0.0, unit="data")
    surface_per_value: F32 = param(0.0, unit="1/data")
    surface_bins: U32 = param(1)
    surface_count: U32 = param(1)
    surface_rows: U32 = param(1)
    surface_layers: U32 = param(3)
    surface_length: F32 = param(1.0, unit="world")


def settled(context: Context) -> Context:
    """Return the context with surfaces a rounding error lower: what lies on an iso-value is above it in 32 bits, too."""
    known = statistics(context.volume, context.channel, context.time)
    by = ROUNDING * float(max(abs(known.minimum), abs(known.maximum)))
    return replace(context, transfer=lowered(context.transfer, by))


class WithSurfaces(Transfer):
    """Base of the stages for functions with surfaces, before the stage that draws the medium.

    ``in_medium`` tells whether there is anything between the surfaces; ``sharp`` whether the driver looks for each of them, and
    no table tells what several send together.
    """

    uniform_type: ClassVar[type | None] = SurfaceUniforms
    has_surfaces: ClassVar[bool] = True
    in_medium: ClassVar[bool] = True
    sharp: ClassVar[bool] = False

    def empty_values(self, context: Context) -> Stretches:
        """Return the stretches of values between surfaces."""
        return super().empty_values(settled(context))

    def uniforms(self, context: Context) -> Any:
        """Return the axis of the function, and how surfaces are found by their values."""
        base = super().uniforms(context)
        context = settled(context)
        values = iso_values(context.transfer)
        return SurfaceUniforms(
            **{field.name: getattr(base, field.name) for field in fields(base)},
            surface_first=values[0],
            surface_per_value=1 / (values[-1] - values[0]) if len(values) > 1 else 0.0,
            surface_bins=bin_count(context.transfer),
            surface_count=len(values),
            surface_rows=ROWS_IN_MEDIUM if self.in_medium else ROWS_ALONE,
            surface_layers=LAYERS_IN_MEDIUM if self.in_medium else LAYERS_ALONE,
            surface_length=context.step_world,
        )

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the function, its surfaces, and what any run of them sends."""
        context = settled(context)
        found = {**super().resources(context), "surfaces": Table(surface_texels(context.transfer, self.in_medium))}
        if not self.sharp:
            found["pairs"] = Table(packed_pairs(context.transfer, context.step_world if self.in_medium else 0.0))
        return found

    def variant(self, context: Context) -> dict[str, bool]:
        """Return whether there is a medium, beside what all transfer stages return."""
        return super().variant(context) | {"in_medium": self.in_medium}

    def sharpened(self) -> Transfer:
        """Return the stage whose surfaces the driver looks for one by one."""
        return SHARP[type(self)](**{field.name: getattr(self, field.name) for field in fields(self)})  # type: ignore[arg-type]

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what the cubic over lengths may cost a slab with several surfaces, beside what the medium's stage says."""
        found = super().errors(context)
        if self.sharp or not self.in_medium:
            return found
        function, length = context.transfer, context.step_world
        return {
            **found,
            "colour of a slab with several surfaces": partial(crossing_error, function, length),
            "colour of a slab's end with several surfaces": partial(crossing_error, function, length, True),
        }


@dataclass(frozen=True)
class SurfacesAlone(WithSurfaces):
    """Surfaces with no medium: exact, from a table over the intervals of a slab's two ends."""

    name: ClassVar[str] = "surfaces"
    wgsl: ClassVar[str] = "transfer/surfaces_alone.wgsl"
    in_medium: ClassVar[bool] = False
    integrates: ClassVar[bool] = True


@dataclass(frozen=True)
class FastPreIntegratedSurfaces(WithSurfaces, FastPreIntegrated):
    """Surfaces in a medium that is integrated along straight lines, without attenuation inside the pieces of a slab."""

    name: ClassVar[str] = "preintegrated_fast_surfaces"
    wgsl: ClassVar[str] = "transfer/preintegrated_surfaces.wgsl"


@dataclass(frozen=True)
class ExactPreIntegratedSurfaces(WithSurfaces, ExactPreIntegrated):
    """Surfaces in a medium that is integrated along straight lines, from control point to control point."""

    name: ClassVar[str] = "preintegrated_exact_surfaces"
    wgsl: ClassVar[str] = "transfer/preintegrated_surfaces.wgsl"


@dataclass(frozen=True)
class PreIntegratedSurfaces(WithSurfaces, PreIntegrated):
    """Surfaces in a medium that is integrated along straight lines, with attenuation inside the pieces of a slab."""

    name: ClassVar[str] = "preintegrated_surfaces"
    wgsl: ClassVar[str] = "transfer/preintegrated_surfaces.wgsl"

    @property
    def exact(self) -> type[ExactPreIntegrated]:
        """The class that takes its place where no table is accurate."""
        return ExactPreIntegratedSurfaces

    def table(self, context: Context) -> SlabTable:
        """Return the table of slabs of the medium alone, which does not change with the surfaces."""
        return super().table(replace(context, transfer=medium_of(context.transfer)))


@dataclass(frozen=True)
class SharpSurfacesAlone(SurfacesAlone):
    """Surfaces with no medium, each where the field has its value."""

    name: ClassVar[str] = "sharp_surfaces"
    wgsl: ClassVar[str] = "transfer/sharp_surfaces.wgsl"
    sharp: ClassVar[bool] = True


@dataclass(frozen=True)
class FastPreIntegratedSharpSurfaces(FastPreIntegratedSurfaces):
    """Surfaces, each where the field has its value, in a medium that is drawn in the fast way."""

    name: ClassVar[str] = "preintegrated_fast_sharp_surfaces"
    wgsl: ClassVar[str] = "transfer/sharp_surfaces.wgsl"
    sharp: ClassVar[bool] = True


@dataclass(frozen=True)
class ExactPreIntegratedSharpSurfaces(ExactPreIntegratedSurfaces):
    """Surfaces, each where the field has its value, in a medium that is integrated from control point to control point."""

    name: ClassVar[str] = "preintegrated_exact_sharp_surfaces"
    wgsl: ClassVar[str] = "transfer/sharp_surfaces.wgsl"
    sharp: ClassVar[bool] = True


@dataclass(frozen=True)
class PreIntegratedSharpSurfaces(PreIntegratedSurfaces):
    """Surfaces, each where the field has its value, in a medium whose light is attenuated inside the pieces of a slab."""

    name: ClassVar[str] = "preintegrated_sharp_surfaces"
    wgsl: ClassVar[str] = "transfer/sharp_surfaces.wgsl"
    sharp: ClassVar[bool] = True


SHARP: dict[type[WithSurfaces], type[WithSurfaces]] = {
    SurfacesAlone: SharpSurfacesAlone,
    FastPreIntegratedSurfaces: FastPreIntegratedSharpSurfaces,
    ExactPreIntegratedSurfaces: ExactPreIntegratedSharpSurfaces,
    PreIntegratedSurfaces: PreIntegratedSharpSurfaces,
}


def stand_in(stage: Transfer, function: TransferFunction) -> Transfer:
    """Return the stage that draws a function with surfaces in the way of another.

    Raises
    ------
    StageError
        For stages that look at the ends of a slab alone: between two samples a sheet without width is missed.
    """
    in_medium = holds_medium(function)
    if type(stage) is PreIntegrated:
        values = {name: getattr(stage, name) for name in ("entries", "lengths", "weighted")}
        return PreIntegratedSurfaces(**values) if in_medium else SurfacesAlone()
    if type(stage) is FastPreIntegrated:
        return FastPreIntegratedSurfaces() if in_medium else SurfacesAlone()
    if type(stage) is ExactPreIntegrated:
        return ExactPreIntegratedSurfaces(weighted=stage.weighted) if in_medium else SurfacesAlone()
    raise StageError(
        f"look.transfer {stage.name!r}", "draws no surfaces of equal value", "use preintegrated or preintegrated_fast"
    )
