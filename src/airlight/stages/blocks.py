"""Blocks of voxels: what is asked of the device to pass over those in which nothing is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from ..labels import Labels, drawn_labels, label_numbers
from ..stage import (
    BlockBounds,
    BlockLeaps,
    BlockRanges,
    BlockShares,
    BlockSlopes,
    BlockVariable,
    Context,
    EvenBlocks,
    Grid,
    Stack,
    Stage,
    Within,
)
from ..transfer import TransferFunction
from .driver import gains_from_curvature
from .field import Field, needed_groups
from .field_labels import Occupancy
from .gradient import Gradient
from .integrate import Integrate
from .region import Labelled
from .transfer import widest

SAME_GRID = 1e-4  # voxels
ROUNDED = 1.001  # gradients in half floats


def block_leaps(stages: Mapping[str, Stage], integrate: Stage, context: Context, moves: bool = False) -> BlockLeaps | None:
    """Return what is asked of the device to pass over blocks that leave the result as it is; None where none is known to.

    ``moves`` tells that values are put right for curvature, and not held on stretches on which nothing is.

    Blocks share the values at their faces. So a way through blocks that one variable tells to be empty stays on one stretch of
    its values, and so does a slab from one of its places to another. Where several variables tell, each by itself, or labels
    do, blocks reach a step further: a slab that ends in one is empty for the same reason.
    """
    field, transfer = stages["field"], stages["transfer"]
    assert isinstance(field, Field)
    wanted = integrate.idle(transfer, context) if isinstance(integrate, Integrate) else None
    hidden = hidden_regions(stages, integrate, context)
    if wanted is None and hidden is None:
        return None
    wanted = ((),) if wanted is None else wanted
    told = {of for alternatives in wanted for of, *_ in alternatives if variable_of(of, stages, context)}
    several = any(len({of for of, *_ in alternatives} & told) > 1 for alternatives in wanted)
    further = step_voxels(context) if several or moves else 0
    known = {of: variable for of in told if (variable := variable_of(of, stages, context, further, moves))}
    empty = tuple(
        tuple(
            [Within(known[of], low, high) for of, low, high in alternatives if of in known]
            + ([Within(hidden, -math.inf, 0.0)] if hidden else [])
        )
        for alternatives in wanted
    )
    return BlockLeaps(empty, not several and hidden is None) if all(empty) else None


def even_blocks(stages: Mapping[str, Stage], integrate: Stage, context: Context, leaps: BlockLeaps | None) -> BlockLeaps | None:
    """Return what is asked of the device where slabs may go through even blocks, too; None where they may not.

    They may where a value tells its medium, by a function of one value of one channel: unlit, on a plateau of the function or
    where the field has one value; lit by directions alone, where it has one value as far as gradients reach.
    """
    field, transfer, gradient = stages["field"], stages["transfer"], stages["gradient"]
    is_plain = isinstance(context.transfer, TransferFunction) and not context.transfer.surfaces and context.labels is None
    composites = hasattr(integrate, "opaque_at") and stages["modulation"].name == "none"
    if not (is_plain and composites and getattr(transfer, "by_value", False)) or getattr(field, "masked", True):
        return None
    is_lit = stages["lighting"].name != "unlit"
    reach = getattr(gradient, "reach_voxels", None) if is_lit else 0
    by_direction = getattr(stages["shade"], "by_direction", False) and stages["visibility"].name == "none"
    by_direction &= not context.clips and all(light.kind in ("head", "directional") for light in context.lights)
    if reach is None or (is_lit and not by_direction):
        return None
    place = 4 * needed_groups(context)[0]
    values = variable_of(place, stages, context)
    # Values that are put right for curvature stay on a plateau where those a step further do, with a sixth of their range.
    moves = gains_from_curvature({**stages, "integrate": integrate})
    moved = variable_of(place, stages, context, step_voxels(context) if moves else 0, moves)
    if not isinstance(values, BlockRanges) or not isinstance(moved, BlockRanges):
        return None
    around = replace(values, reach=values.reach + reach)
    plateaus = () if is_lit else widest(context.transfer.plateaus)
    return replace(leaps or BlockLeaps(((),)), even=EvenBlocks(values, around, values if is_lit else moved, plateaus))


def block_bounds(stages: Mapping[str, Stage], integrate: Stage, context: Context) -> BlockBounds | None:
    """Return what is asked of the device where a value along the ray is looked for.

    None where no bounds are known, or samples may be missing.
    """
    extreme, field = getattr(integrate, "extreme", "none"), stages["field"]
    told = extreme != "none" and isinstance(field, Field) and not field.masked
    ranges = variable_of(4 * needed_groups(context)[0], stages, context) if told else None
    return BlockBounds(ranges, extreme == "least") if isinstance(ranges, BlockRanges) else None


def variable_of(
    of: int | str, stages: Mapping[str, Stage], context: Context, further: int = 0, moves: bool = False
) -> BlockVariable | None:
    """Return what is asked of the device for a variable of conditions; None where nothing is known of it.

    A block holds the samples at its faces, those beyond them by which the field reaches in, and so many ``further``. Values
    that curvature ``moves`` are a sixth of their distance from the line between their two neighbours on the ray further off it.
    """
    field, gradient = stages["field"], stages["gradient"]
    assert isinstance(field, Field)
    if isinstance(field, Occupancy) and context.labels is not None:
        return drawn_shares(context.labels, context, further) if of == 0 else None
    grid = field.resources(context).get("grid")
    grid = grid.solid if isinstance(grid, Stack) else grid
    if not isinstance(grid, Grid) or grid.levels:
        return None
    reach, overshoot = max(math.ceil(field.support_voxels) - 1, 0) + further, float(field.overshoot)
    if isinstance(of, int):
        return BlockRanges(grid, of, reach, overshoot + ((1 + 2 * overshoot) / 6 if moves else 0.0))
    if of != "gradient" or not isinstance(gradient, Gradient) or gradient.reach_voxels is None:
        return None
    # Each component is at most the range of what it is the difference of, since that is at least a voxel wide.
    matrix = context.volume.index_from_world[:3, :3]
    most = max(float(np.linalg.norm(matrix.T @ signs)) for signs in product((-1.0, 1.0), repeat=3))
    return BlockSlopes(BlockRanges(grid, 0, reach + gradient.reach_voxels), ROUNDED * (1 + 2 * overshoot) * most)


def step_voxels(context: Context) -> int:
    """Return how far a step goes along the axes of the grid at most, in whole voxels."""
    rates = np.linalg.norm(context.volume.index_from_world[:3, :3], axis=1)
    return math.ceil(context.step_world * float(rates.max()) - SAME_GRID)


def hidden_regions(stages: Mapping[str, Stage], integrate: Stage, context: Context) -> BlockShares | None:
    """Return what is asked for the regions beside an image of which nothing is drawn.

    None where there are none, where labels lie on another grid than the image, and where surfaces alone are looked for: a ray
    that comes out of a hidden region may begin inside of what is solid.
    """
    labels, region = context.labels, stages.get("region")
    if labels is None or not isinstance(region, Labelled) or not getattr(integrate, "skips_empty", False):
        return None
    volume = context.volume
    apart = labels.volume.index_from_world @ volume.world_from_index - np.eye(4)
    is_same = labels.volume.size == volume.size and np.abs(apart @ (*volume.size, 1.0)).max() < SAME_GRID
    if not is_same or isinstance(stages["field"], Occupancy):
        return None
    shares = drawn_shares(labels, context, step_voxels(context))
    return None if all(shares.drawn) else shares


def drawn_shares(labels: Labels, context: Context, reach: int) -> BlockShares:
    """Return what is asked for the regions that are drawn."""
    time = labels.time_of(context.time)
    return BlockShares(label_numbers(labels.volume, time, labels.background), drawn_labels(labels, time), reach)
