"""Transfer functions of several channels: media that lie in one place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError
from ..stage import Conditions, Context, Estimate, Mat4f, Resource, Stretches, Table, param
from ..transfer.cells import all_even, even_cells, has_stepped_ends, stacked_texels, value_axis
from ..transfer.channels import ENDLESS, Channels
from ..transfer.function import TransferFunction
from ..transfer.regions import ByRegion
from ..volume import FloatArray
from .field_channels import by_group, lanes_of
from .transfer import Transfer, is_empty_beyond, on_one_of, widest, without_table


@dataclass(frozen=True, eq=False)
class MixtureUniforms:
    """Axes of the functions that are drawn, where their channels lie in a value, and where they hold nothing.

    Matrices have a column for each four functions; those of empty stretches, a column for each group of four of a value.
    """

    lane: Mat4f = param(None)
    first_value: Mat4f = param(None, unit="data")
    last_value: Mat4f = param(None, unit="data")
    per_value: Mat4f = param(None, unit="1/data")
    even_cells: Mat4f = param(None)
    empty_low: Mat4f = param(None, unit="data")
    empty_high: Mat4f = param(None, unit="data")
    other_empty_low: Mat4f = param(None, unit="data")
    other_empty_high: Mat4f = param(None, unit="data")


class OfSeveral(Transfer):
    """Base of the stages for several functions, whose cells lie one behind the other."""

    def variant(self, context: Context) -> dict[str, bool]:
        """Return what colours mean, what lies at the ends of the functions, and whether all cells are equally wide."""
        functions = context.transfer.functions
        return {
            "associated": functions[0].associated,
            "open_ends": not all(is_empty_beyond(function) for function in functions),
            "stepped_ends": any(has_stepped_ends(function) for function in functions),
            "even": all_even(functions),
        }

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the cells of the functions, one behind the other."""
        return {"function": Table(stacked_texels(context.transfer.functions))}


class Mixture(OfSeveral):
    """Base of the stages for several channels: extinctions add, colours are weighted by extinction."""

    uniform_type: ClassVar[type] = MixtureUniforms

    def empty_values(self, context: Context) -> Stretches:
        """Return nothing: one value does not tell of several."""
        return ()

    def empty_where(self, context: Context) -> Conditions | None:
        """Return that each channel's values lie on one of the stretches on which its function holds nothing."""
        function: Channels = context.transfer
        found = tuple(
            alternatives
            for part, place in zip(function.functions, function.places(context.volume), strict=True)
            for alternatives in on_one_of(_widest_of(part), place) or ((),)
        )
        return found if all(found) else None

    def has_empty(self, context: Context) -> bool:
        """Whether there are values at which no function holds anything."""
        return all(function.empty_stretches for function in context.transfer.functions)

    def uniforms(self, context: Context) -> Any:
        """Return the axes of the functions."""
        functions = context.transfer.functions
        lanes = lanes_of(context)
        axes = [value_axis(function) for function in functions]
        ends = {lane: _two_widest(function) for lane, function in zip(lanes, functions, strict=True)}

        def end(number: int, of_others: float) -> FloatArray:
            """Ends of stretches; places of a value that are not drawn are always empty."""
            return by_group({lane: found[number] for lane, found in ends.items()}, of_others)

        return MixtureUniforms(
            lane=_listed(lanes),
            first_value=_listed(first for first, _ in axes),
            last_value=_listed(last for _, last in axes),
            per_value=_listed(1.0 / (last - first) for first, last in axes),
            even_cells=_listed(even_cells(function) for function in functions),
            empty_low=end(0, -ENDLESS),
            empty_high=end(1, ENDLESS),
            other_empty_low=end(2, ENDLESS),
            other_empty_high=end(3, -ENDLESS),
        )


@dataclass(frozen=True)
class PostClassifiedChannels(Mixture):
    """A slab is the mean of the media at its two ends."""

    name: ClassVar[str] = "postclassified_channels"
    wgsl: ClassVar[str] = "transfer/postclassified_channels.wgsl"


@dataclass(frozen=True)
class PreIntegratedChannels(Mixture):
    """Each function is integrated along the straight line between a slab's two values, and their sum attenuated as one medium.

    Opacity is exact. Where within the slab a channel lies is lost: it is drawn as a homogeneous one.
    """

    name: ClassVar[str] = "preintegrated_channels"
    wgsl: ClassVar[str] = "transfer/preintegrated_channels.wgsl"
    integrates: ClassVar[bool] = True

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what the even spread may cost a slab at worst: all channels at their densest, one before the other.

        What it may cost either of its ends counts where they are lit differently.
        """
        function, length = context.transfer, context.step_world
        return {
            "colour of a slab, its channels spread evenly": partial(evenness_error, function, length),
            "colour of a slab's end, its channels spread evenly": partial(end_error, function, length),
        }


def evenness_error(mixture: Channels | ByRegion, length: float) -> float:
    """Greatest error of a colour component that slabs of a length make when they are drawn as homogeneous ones.

    Spread evenly, a greatest source ``s`` at an optical depth ``x`` sends ``s d (1 - exp(-x)) / x``. When a share ``f`` of the
    medium, which alone glows with colour ``c``, lies in front, it sends ``c (1 - exp(-f x))`` instead of ``c f (1 - exp(-x))``;
    the difference is greatest for ``exp(-f x) = (1 - exp(-x)) / x``. Sources that are associated may all lie at either end.
    """
    depth, brightest = _depth_and_brightest(mixture, length)
    if depth == 0:
        return 0.0
    mean = -math.expm1(-depth) / depth
    if mixture.functions[0].associated:
        return brightest * max(1 - mean, mean - math.exp(-depth))
    return brightest * (1 - mean + math.log(mean) * mean)


def end_error(mixture: Channels | ByRegion, length: float) -> float:
    """Greatest error of what either end of a slab of a length gets of a colour component when it is drawn as a homogeneous one.

    A share ``f`` of the medium, which alone glows, may lie at the back with nothing in front: that end gets ``1 - exp(-f x)``,
    and is drawn with ``f h (1 - exp(-x))``, where ``h`` is the back's share of a homogeneous slab, less than the front's. White
    light is that of all of the medium. Sources that are associated may be seen whole.
    """
    depth, brightest = _depth_and_brightest(mixture, length)
    x = max(depth, 1e-9)
    back = -math.expm1(-x) / x - math.exp(-x) if x > 1e-4 else x / 2  # h (1 - exp(-x))
    share = min(1.0, -math.log(back / x) / x)
    apart = -math.expm1(-share * x) - share * back
    if mixture.functions[0].associated:
        return max(brightest * (1 - back / x), apart)
    return max(brightest, 1.0) * apart


def _depth_and_brightest(mixture: Channels | ByRegion, length: float) -> tuple[float, float]:
    """Greatest optical depth of slabs of a length, and their brightest colour; of associated ones all that they may send."""
    functions = mixture.functions
    depth = length * sum(float(function.extinctions.max()) for function in functions)
    if functions[0].associated:
        return depth, length * float(np.sum([function.colours.max(axis=0) for function in functions], axis=0).max())
    return depth, max(float(function.colours.max()) for function in functions)


def _listed(numbers: Any) -> FloatArray:
    """Matrix of one number for each function, four to a column."""
    return by_group(dict(enumerate(numbers)))


def _widest_of(function: TransferFunction) -> Stretches:
    return widest(function.empty_stretches)[:2]


def _two_widest(function: TransferFunction) -> tuple[float, float, float, float]:
    """Ends of the two widest stretches on which a function holds nothing; none is one that begins behind its end."""
    ends = [(max(low, -ENDLESS), min(high, ENDLESS)) for low, high in _widest_of(function)]
    (a, b), (c, d) = ([*ends, (ENDLESS, -ENDLESS), (ENDLESS, -ENDLESS)])[:2]
    return a, b, c, d


def stand_in(stage: Transfer, function: Channels) -> Transfer:
    """Return the stage that draws such a function in the way of another."""
    if stage.name == "postclassified":
        return PostClassifiedChannels()
    if stage.name in ("preintegrated", "preintegrated_fast"):
        without_table(stage, "several channels")
        return PreIntegratedChannels()
    raise StageError(f"look.transfer {stage.name!r}", "draws one channel at a time", "use preintegrated or postclassified")
