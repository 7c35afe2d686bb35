"""From values to colour and extinction, at a sample and over a slab."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError
from ..stage import (
    F32,
    U32,
    Conditions,
    Context,
    Estimate,
    Mat4f,
    Resource,
    SlabTable,
    Stage,
    Stretches,
    Table,
    Vec4f,
    param,
    register,
    static,
)
from ..transfer import Channels, JointFunction, TransferFunction
from ..transfer.cells import (
    end_media,
    even_cells,
    function_texels,
    has_stepped_ends,
    integral_to,
    piece_texels,
    two_parts,
    value_axis,
)
from ..transfer.kinds import DrawnFunction
from ..transfer.regions import ByRegion
from ..transfer.runs import medium_of
from ..transfer.tables import SHORTER, check_table, colour_error, entries_needed, is_better_cut, spread_error
from ..volume import FloatArray

Vec4 = tuple[float, float, float, float]
CUT_ERROR = 2e-4  # of a colour
SLAB_EVEN = "colour of a slab, its medium spread evenly"
END_EVEN = "colour of a slab's end, its medium spread evenly"

STAND_INS: dict[type, str] = {
    TransferFunction: "surfaces",
    JointFunction: "transfer_joint",
    Channels: "transfer_channels",
    ByRegion: "transfer_regions",
}
"""For each kind of function but the plain one of one value: the module here whose ``stand_in(stage, function)`` gives the stage
that draws it in the way of another. They are imported when they are first needed."""


@dataclass(frozen=True, eq=False)
class FunctionUniforms:
    """Where the axis of the function lies, its media beyond the ends, and the size of the table of slabs."""

    first_value: F32 = param(0.0, unit="data")
    last_value: F32 = param(1.0, unit="data")
    per_value: F32 = param(1.0, unit="1/data")
    even_cells: U32 = param(0)
    empty_low: Vec4f = param((3e38, 3e38, 3e38, 3e38), unit="data")
    empty_high: Vec4f = param((-3e38, -3e38, -3e38, -3e38), unit="data")
    empty_integral_high: Mat4f = param(None, unit="1/world")
    empty_integral_low: Mat4f = param(None, unit="1/world")
    first_medium: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="rgb, 1/world")
    last_medium: Vec4f = param((0.0, 0.0, 0.0, 0.0), unit="rgb, 1/world")
    slab_entries: U32 = param(2)
    slab_lengths: U32 = param(1)
    slab_length: F32 = param(1.0, unit="world")


class Transfer(Stage):
    """Base of the transfer stages: the function itself, as the cells that it is linear in.

    ``integrates`` tells whether slabs run along the straight line between their two values, ``has_surfaces`` whether surfaces
    are met on it; ``by_value`` whether nothing of a sample counts but its value, so that slabs between equal values are of one
    medium, however long; ``piece`` names the file below ``transfer/`` that draws a piece of such a line, for WGSL that imports
    ``slot::piece::between``.
    """

    slot: ClassVar[str] = "transfer"
    uniform_type: ClassVar[type | None] = FunctionUniforms
    integrates: ClassVar[bool] = False
    has_surfaces: ClassVar[bool] = False
    by_value: ClassVar[bool] = False
    piece: ClassVar[str] = "unattenuated"

    def for_function(self, function: DrawnFunction) -> Transfer:
        """Return the stage that draws a function of this kind in this stage's way."""
        if isinstance(function, TransferFunction) and not function.surfaces:
            return self
        if type(function) not in STAND_INS:
            raise StageError(f"look.transfer {self.name!r}", f"cannot draw a {type(function).__name__}")
        stage: Transfer = import_module(f".{STAND_INS[type(function)]}", __package__).stand_in(self, function)
        return stage

    def uses_gradient(self, function: DrawnFunction) -> bool:
        """Whether classification asks the look's gradient stage, which is left out otherwise where nothing is lit."""
        return False

    def splitting(self) -> Transfer:
        """Return the stage that tells which part of a slab's light comes from each of its ends, if it is not this."""
        return self

    def for_context(self, context: Context) -> Transfer:
        """Return the stage that draws a function as exactly as this promises to, if it is not this."""
        return self

    def converging(self) -> Transfer:
        """Return the stage for pictures of a known error."""
        return self

    def sharpened(self) -> Transfer:
        """Return the stage that tells its surfaces one by one, for drivers that look for their places, if it is not this."""
        return self

    def empty_values(self, context: Context) -> Stretches:
        """Return the stretches of values, at most four, on each of which the function holds nothing."""
        return widest(context.transfer.empty_stretches)

    def empty_where(self, context: Context) -> Conditions | None:
        """Return the conditions under which the function holds nothing; None where no values tell."""
        return on_one_of(self.empty_values(context))

    def has_empty(self, context: Context) -> bool:
        """Whether there are values at which the function holds nothing, so that slabs can be skipped."""
        return bool(self.empty_values(context))

    def uniforms(self, context: Context) -> Any:
        """Return the axis of the function."""
        tf = context.transfer
        first, last = value_axis(tf)
        low, high = ends_of(self.empty_values(context))
        integral_high, integral_low = two_parts(integral_to(tf, np.maximum(low, first)))
        before, behind = end_media(tf)
        return FunctionUniforms(
            first_value=first,
            last_value=last,
            per_value=1.0 / (last - first),
            even_cells=even_cells(tf),
            empty_low=low,
            empty_high=high,
            empty_integral_high=integral_high.astype(np.float64).T,
            empty_integral_low=integral_low.astype(np.float64).T,
            first_medium=_vec4(before),
            last_medium=_vec4(behind),
        )

    def variant(self, context: Context) -> dict[str, bool]:
        """Return what colours mean, what lies at the ends of the function, and whether cells are equally wide."""
        tf = context.transfer
        return {
            "associated": tf.associated,
            "open_ends": not is_empty_beyond(tf),
            "stepped_ends": has_stepped_ends(tf),
            "even": even_cells(tf) > 0,
        }

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the cells of the function."""
        return {"function": Table(function_texels(context.transfer))}


def __getattr__(name: str) -> Any:
    """Names of the package of functions: ``import airlight.transfer.presets as p`` looks for them in ``al.transfer``."""
    if name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("...transfer", __name__), name)


def without_table(stage: Transfer, what: str) -> None:
    """Refuse a stage that asks for a certain table of slabs where there is none.

    Raises
    ------
    StageError
        Names what is asked for.
    """
    told = [
        f"{name}={getattr(stage, name)}"
        for name, usual in (("entries", 0), ("lengths", 1))
        if getattr(stage, name, usual) != usual
    ]
    if told:
        raise StageError(
            f"look.transfer {stage.name!r}", f"asks for {' and '.join(told)}, and {what} have no table of slabs", "leave it out"
        )


def is_empty_beyond(function: TransferFunction) -> bool:
    """Whether a function holds nothing beyond both its ends."""
    stretches = function.empty_stretches
    return bool(stretches) and stretches[0][0] == -np.inf and stretches[-1][1] == np.inf


def on_one_of(stretches: Stretches, place: int = 0) -> Conditions | None:
    """Return the condition that values of the channel at a place lie on one of some stretches; None where there are none."""
    return (tuple((place, low, high) for low, high in stretches),) if stretches else None


def widest(stretches: Stretches) -> Stretches:
    """Return the four widest stretches; what is left out is drawn like everything else."""
    return tuple(sorted(stretches, key=lambda s: s[0] - s[1])[:4])


def ends_of(stretches: Stretches) -> tuple[Vec4, Vec4]:
    """Low and high ends of at most four stretches."""
    ends = [(max(low, -3e38), min(high, 3e38)) for low, high in stretches] + [(3e38, -3e38)] * (4 - len(stretches))
    (a, b, c, d), (e, f, g, h) = zip(*ends, strict=True)
    return (a, b, c, d), (e, f, g, h)


def _vec4(numbers: FloatArray) -> Vec4:
    a, b, c, d = (float(n) for n in numbers)
    return a, b, c, d


@register
@dataclass(frozen=True)
class PostClassified(Transfer):
    """Interpolate values, then classify: a slab is the mean of the media at its two ends."""

    name: ClassVar[str] = "postclassified"
    by_value: ClassVar[bool] = True
    wgsl: ClassVar[str] = "transfer/postclassified.wgsl"

    def converging(self) -> Transfer:
        """Return the stage that misses nothing between the values of two samples."""
        return ExactPreIntegrated(weighted=True)


@register
@dataclass(frozen=True)
class FastPreIntegrated(Transfer):
    """The function integrated along the straight line between a slab's two values, without attenuation inside the slab.

    Engel and Ertl, section 6.3. Opacity is exact; where colours change within slabs that are far from transparent, what is
    behind shows too much. No table: quick to edit.
    """

    name: ClassVar[str] = "preintegrated_fast"
    by_value: ClassVar[bool] = True
    integrates: ClassVar[bool] = True
    wgsl: ClassVar[str] = "transfer/preintegrated.wgsl"

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what the even spread costs a slab, and either of its ends, which counts where they are lit differently."""
        medium = medium_of(context.transfer)
        return {what: partial(spread_error, medium, context.step_world, what == END_EVEN) for what in (SLAB_EVEN, END_EVEN)}


@register
@dataclass(frozen=True)
class ExactPreIntegrated(Transfer):
    """The function integrated along the straight line between a slab's two values, from control point to control point.

    Between these colour and extinction are linear, and eight nodes tell what light leaves: exact at any depth and length,
    without a table. Slabs take time by the control points whose values they cross.
    """

    name: ClassVar[str] = "preintegrated_exact"
    by_value: ClassVar[bool] = True
    integrates: ClassVar[bool] = True
    piece: ClassVar[str] = "cut"
    wgsl: ClassVar[str] = "transfer/preintegrated.wgsl"
    weighted: bool = static(False, help="tell which share of a slab's light lies towards its back")

    def splitting(self) -> Transfer:
        """Return the stage that tells both ends apart."""
        return replace(self, weighted=True)

    def variant(self, context: Context) -> dict[str, bool]:
        """Return what all transfer stages return; pieces between control points are not equally wide."""
        return super().variant(context) | {"even": False}

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what eight nodes, what is too deep to be seen, and rounding next to control points cost a slab."""
        return {"colour of a slab": CUT_ERROR * float(context.transfer.colours.max())}

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the pieces of the function."""
        return {"function": Table(piece_texels(context.transfer))}


@register
@dataclass(frozen=True)
class PreIntegrated(Transfer):
    """The function integrated along the straight line between a slab's two values, with attenuation inside the slab.

    Engel and Ertl, section 6; Lum, Wilson and Ma, section 4. Opacity and mean source are exact, what attenuation shifts comes
    from a table, see ``docs/slots/transfer.md``. Where no table is accurate ``preintegrated_exact`` takes its place.
    """

    name: ClassVar[str] = "preintegrated"
    by_value: ClassVar[bool] = True
    integrates: ClassVar[bool] = True
    piece: ClassVar[str] = "attenuated"
    wgsl: ClassVar[str] = "transfer/preintegrated.wgsl"
    entries: U32 = param(
        0, at_least=0, up_to=4096, help="size of the table along each axis; 0 chooses it, or none, from the function"
    )
    lengths: U32 = param(1, at_least=1, up_to=64, help="lengths of slabs in the table; one serves shorter slabs well")
    weighted: bool = static(False, help="keep which share of a slab's light lies towards its back")

    @property
    def exact(self) -> type[ExactPreIntegrated]:
        """The class that takes its place where no table is accurate."""
        return ExactPreIntegrated

    def table(self, context: Context) -> SlabTable:
        """Return the table of slabs."""
        entries = self.entries or entries_needed(context.transfer, context.step_world, self.weighted)
        check_table(context.step_world, entries, self.lengths)
        return SlabTable(context.transfer, context.step_world, entries, self.lengths, self.weighted)

    def for_context(self, context: Context) -> Transfer:
        """Return the stage that cuts slabs at control points, where the choice is free and no table is accurate."""
        table = self.table(context)
        if self.entries or not is_better_cut(table.function, table.length, table.weighted):
            return self
        return self.exact(weighted=self.weighted)

    def uniforms(self, context: Context) -> Any:
        """Return the axis of the function and the size of the table."""
        table = self.table(context)
        base = super().uniforms(context)
        return replace(base, slab_entries=table.entries, slab_lengths=table.lengths, slab_length=table.length)

    def converging(self) -> Transfer:
        """Return the stage that needs no table."""
        return self.exact(weighted=self.weighted)

    def splitting(self) -> Transfer:
        """Return the stage whose table is weighted."""
        return replace(self, weighted=True)

    def variant(self, context: Context) -> dict[str, bool]:
        """Return whether the table has several lengths, beside what all transfer stages return."""
        return super().variant(context) | {"layered": self.lengths > 1}

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what interpolation between the entries of the table may cost a slab, or either of its ends."""
        table = self.table(context)
        least = table.length / table.lengths
        return {
            "colour of a slab": partial(colour_error, table.function, table.length, table.entries, table.weighted),
            "colour of a shorter slab": partial(colour_error, table.function, least, table.entries, table.weighted, SHORTER),
        }

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the function and the table of slabs."""
        return {**super().resources(context), "slabs": self.table(context)}


@dataclass(frozen=True)
class FromField(Transfer):
    """The medium is the value; a slab is the mean of the media at its two ends."""

    name: ClassVar[str] = "from_field"
    wgsl: ClassVar[str] = "transfer/from_field.wgsl"
    uniform_type: ClassVar[type | None] = None
    weighted: bool = static(True)

    def uniforms(self, context: Context) -> FromField:
        """Return itself: there is nothing to pack."""
        return self

    def variant(self, context: Context) -> dict[str, bool]:
        """Return what colours mean."""
        return {"associated": context.transfer.associated}

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return nothing: the field holds all."""
        return {}
