"""From values to colour and extinction, at a sample and over a slab."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..stage import F32, U32, Bool, Context, Resource, Stage, Table, Vec4f, param, register
from ..transfer import TransferFunction
from ..transfer.tables import LENGTHS, function_table, opacity_error, slab_table

Vec4 = tuple[float, float, float, float]


@dataclass(frozen=True)
class FunctionUniforms:
    """Where the axes of the tables lie, and at which slab length the table of slabs was made."""

    first_value: F32 = param(0.0, unit="data")
    last_value: F32 = param(1.0, unit="data")
    per_value: F32 = param(1.0, unit="1/data")
    function_entries: U32 = param(2)
    slab_entries: U32 = param(2)
    empty_low: Vec4f = param((3e38, 3e38, 3e38, 3e38), unit="data")
    empty_high: Vec4f = param((-3e38, -3e38, -3e38, -3e38), unit="data")
    first_medium: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="1/world")
    last_medium: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="1/world")
    slab_lengths: U32 = param(2)
    slab_length: F32 = param(1.0, unit="world")
    associated: Bool = param(False)


class Transfer(Stage):
    """Base of the transfer stages: the function itself as a table of (colour, extinction).

    ``carries_medium`` tells that the media at both ends are all that a slab depends on, so that a march looks up one a sample.
    """

    slot: ClassVar[str] = "transfer"
    carries_medium: ClassVar[bool] = False
    uniform_type: ClassVar[type] = FunctionUniforms

    def uniforms(self, context: Context) -> FunctionUniforms:
        """Return the axes of the tables."""
        tf = context.transfer
        function = function_table(tf)
        low, high = _widest(tf.empty_stretches)
        return FunctionUniforms(
            first_value=function.first_value,
            last_value=function.last_value,
            per_value=1.0 / (function.last_value - function.first_value),
            function_entries=function.entries,
            empty_low=low,
            empty_high=high,
            first_medium=_source_and_extinction(tf, tf.domain[0], before=True),
            last_medium=_source_and_extinction(tf, tf.domain[1]),
            associated=tf.associated,
        )

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the table of the function."""
        return {"function": Table(function_table(context.transfer).texels)}


def _widest(stretches: tuple[tuple[float, float], ...]) -> tuple[Vec4, Vec4]:
    """Low and high ends of the four widest stretches; what is left out is drawn like everything else."""
    widest = sorted(stretches, key=lambda s: s[0] - s[1])[:4]
    ends = [(max(low, -3e38), min(high, 3e38)) for low, high in widest] + [(3e38, -3e38)] * (4 - len(widest))
    (a, b, c, d), (e, f, g, h) = zip(*ends, strict=True)
    return (a, b, c, d), (e, f, g, h)


def _source_and_extinction(function: TransferFunction, value: float, before: bool = False) -> tuple[float, float, float, float]:
    """Medium beyond an end of the function."""
    here = np.nextafter(value, -np.inf) if before else value
    r, g, b = function.source(here)
    return float(r), float(g), float(b), float(function(here)[1])


@register
@dataclass(frozen=True)
class PostClassified(Transfer):
    """Interpolate values, then classify: a slab is the mean of the media at its two ends."""

    name: ClassVar[str] = "postclassified"
    carries_medium: ClassVar[bool] = True
    wgsl: ClassVar[str] = "transfer/postclassified.wgsl"


@register
@dataclass(frozen=True)
class PreIntegrated(Transfer):
    """The function integrated along the straight line between a slab's two values, from a table made in float64.

    Engel and Ertl, section 6; the table holds mean extinction and attenuated mean source, see ``docs/slots/transfer.md``.
    ``entries`` is the table's size along each value axis; 0 chooses it from the function.
    """

    name: ClassVar[str] = "preintegrated"
    wgsl: ClassVar[str] = "transfer/preintegrated.wgsl"
    entries: U32 = param(0, at_least=0, up_to=4096, help="size of the table along each axis; 0 chooses it from the function")

    def uniforms(self, context: Context) -> FunctionUniforms:
        """Return the axes of the tables."""
        base = super().uniforms(context)
        table = slab_table(context.transfer, context.step_world, self.entries)
        return replace(base, slab_entries=table.entries, slab_lengths=LENGTHS, slab_length=context.step_world)

    def errors(self, context: Context) -> dict[str, float]:
        """Return what interpolation between the entries of the table may cost a slab."""
        return {"opacity of a slab": opacity_error(context.transfer, context.step_world, self.entries)}

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the tables of the function and of slabs."""
        table = slab_table(context.transfer, context.step_world, self.entries)
        return {**super().resources(context), "slabs": Table(table.texels)}
