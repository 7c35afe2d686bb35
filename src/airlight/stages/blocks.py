"""Blocks of voxels: the least and the greatest sample that a field can show within each."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from ..stage import BlockLeaps, BlockRanges, Context, Grid, Stage
from .field import Field, Nearest, NearestMasked
from .integrate import Integrate


@dataclass(frozen=True)
class Samples(Nearest):
    """Reader of single samples from the texture that fields filter."""

    filtered: ClassVar[bool] = True


def block_leaps(field: Field, integrate: Stage, transfer: Stage, context: Context) -> BlockLeaps | None:
    """Return what is asked of the device to pass over blocks whose values leave the result as it is.

    None where all values count, or one value does not tell of a field's samples.
    """
    empty = integrate.idle_values(transfer, context) if isinstance(integrate, Integrate) else ()
    ranges = block_ranges(field, context) if empty else None
    if ranges is not None and field.smooth and getattr(transfer, "has_surfaces", False):
        ranges = with_moved_values(ranges, math.ceil(context.step_world / min(context.volume.spacing)))
    return None if ranges is None else BlockLeaps(ranges, empty)


def with_moved_values(ranges: BlockRanges, step_voxels: int) -> BlockRanges:
    """Return ranges that also hold values put right for curvature, which surfaces are told by.

    A value is moved by a sixth of its distance from the line between its two neighbours on the ray.
    """
    moved = (1 + 2 * ranges.overshoot) / 6
    return replace(ranges, reach=ranges.reach + step_voxels, overshoot=ranges.overshoot + moved)


def block_ranges(field: Field, context: Context) -> BlockRanges | None:
    """Return what is asked of the device for the blocks of a field; None where one value does not tell of its samples.

    A block holds the samples at its faces, and those beyond them by which the field reaches in.
    """
    grid = field.resources(context).get("grid")
    if len(context.channels) > 1 or not isinstance(grid, Grid) or grid.levels:
        return None
    reader = NearestMasked() if field.masked else Samples() if field.filtered else Nearest()
    return BlockRanges(grid, reader, max(math.ceil(field.support_voxels) - 1, 0), float(field.overshoot))
