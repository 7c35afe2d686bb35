"""Blocks of voxels: the least and the greatest sample that a field can show within each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ..stage import BlockLeaps, BlockRanges, Context, Grid, Stage
from .field import Field, Nearest, NearestMasked
from .integrate import Integrate


@dataclass(frozen=True)
class Samples(Nearest):
    """Reader of single samples from the texture that fields filter."""

    filtered: ClassVar[bool] = True


def block_leaps(field: Field, integrate: Stage, context: Context) -> BlockLeaps | None:
    """Return what is asked of the device to pass over blocks without a value that the integrate stage looks for.

    None where it looks for all, or one value does not tell of a field's samples.
    """
    wanted = integrate.wanted(context) if isinstance(integrate, Integrate) else None
    ranges = block_ranges(field, context)
    return None if wanted is None or ranges is None else BlockLeaps(ranges, wanted)


def block_ranges(field: Field, context: Context) -> BlockRanges | None:
    """Return what is asked of the device for the blocks of a field; None where one value does not tell of its samples.

    A block holds the samples at its faces, and those beyond them by which the field reaches in.
    """
    grid = field.resources(context).get("grid")
    if len(context.channels) > 1 or not isinstance(grid, Grid) or grid.levels:
        return None
    reader = NearestMasked() if field.masked else Samples() if field.filtered else Nearest()
    return BlockRanges(grid, reader, max(math.ceil(field.support_voxels) - 1, 0), float(field.overshoot))
