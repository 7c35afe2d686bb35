"""Transfer functions of regions: each one's share in a place is that of its labels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from ..errors import StageError
from ..stage import Context, Estimate, Mat4f, Vec4f, param
from ..transfer.cells import even_cells, value_axis
from ..transfer.regions import ByRegion
from .field_channels import by_group
from .transfer import END_EVEN, SLAB_EVEN, Transfer, ends_of, without_table
from .transfer_channels import OfSeveral, end_error, evenness_error


@dataclass(frozen=True, eq=False)
class RegionFunctionsUniforms:
    """Axes of the functions, four to a column, and the values at which none of them holds anything."""

    first_value: Mat4f = param(None, unit="data")
    last_value: Mat4f = param(None, unit="data")
    per_value: Mat4f = param(None, unit="1/data")
    even_cells: Mat4f = param(None)
    empty_low: Vec4f = param((3e38, 3e38, 3e38, 3e38), unit="data")
    empty_high: Vec4f = param((-3e38, -3e38, -3e38, -3e38), unit="data")


class OfRegions(OfSeveral):
    """Base of the stages for functions of regions: the media of the eight labels round a place, by their weights."""

    of_regions: ClassVar[bool] = True

    uniform_type: ClassVar[type | None] = RegionFunctionsUniforms

    def uniforms(self, context: Context) -> Any:
        """Return the axes of the functions."""
        functions = context.transfer.functions
        axes = [value_axis(function) for function in functions]
        low, high = ends_of(self.empty_values(context))
        return RegionFunctionsUniforms(
            first_value=by_group(dict(enumerate(first for first, _ in axes))),
            last_value=by_group(dict(enumerate(last for _, last in axes))),
            per_value=by_group(dict(enumerate(1.0 / (last - first) for first, last in axes))),
            even_cells=by_group(dict(enumerate(map(even_cells, functions)))),
            empty_low=low,
            empty_high=high,
        )


@dataclass(frozen=True)
class PostClassifiedRegions(OfRegions):
    """A slab is the mean of the media at its two ends, those of its middle's regions."""

    name: ClassVar[str] = "postclassified_regions"
    wgsl: ClassVar[str] = "transfer/postclassified_regions.wgsl"


@dataclass(frozen=True)
class PreIntegratedRegions(OfRegions):
    """Each function is integrated along the straight line between a slab's two values, and their mixture spread evenly.

    Opacity is exact for the regions in the slab's middle; what attenuation within the slab shifts is left out.
    """

    name: ClassVar[str] = "preintegrated_regions"
    wgsl: ClassVar[str] = "transfer/preintegrated_regions.wgsl"
    integrates: ClassVar[bool] = True

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what the even spread may cost a slab at worst, and either of its ends, where they are lit differently."""
        function, length = context.transfer, context.step_world
        return {
            SLAB_EVEN: partial(_worst, evenness_error, function, length),
            END_EVEN: partial(_worst, end_error, function, length),
        }


def _worst(error: Callable[[ByRegion, float], float], regions: ByRegion, length: float) -> float:
    return max(error(ByRegion((function,)), length) for function in regions.functions)


def stand_in(stage: Transfer, function: ByRegion) -> Transfer:
    """Return the stage that draws such a function in the way of another."""
    if stage.name == "postclassified":
        return PostClassifiedRegions()
    if stage.name in ("preintegrated", "preintegrated_fast"):
        without_table(stage, "functions of labels")
        return PreIntegratedRegions()
    raise StageError(
        f"look.transfer {stage.name!r}", "draws one function", "use preintegrated or postclassified for own ones of labels"
    )
