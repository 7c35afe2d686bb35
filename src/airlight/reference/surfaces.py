"""Surfaces of equal value: they cut a slab into pieces of medium and sheets without length, taken in the order of the ray.

What lies at or above an iso-value is inside. A slab whose front is outside and whose back is inside goes up through the surface
and sees its front; the other way round it sees its back. Nothing else crosses it, so a sample on the very value counts once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..volume import FloatArray
from .setup import IntArray, Sample, Setup, Slab
from .transfer import TRANSFERS, Classified, preintegrated, preintegrated_fast

MEDIA = {
    "surfaces": preintegrated,
    "preintegrated_surfaces": preintegrated,
    "preintegrated_fast_surfaces": preintegrated_fast,
}


@dataclass(frozen=True, eq=False)
class Piece:
    """One piece of some of the slabs, from a share of their length to another; of surfaces both are the same."""

    rows: IntArray
    begin: FloatArray
    end: FloatArray
    rgb: FloatArray
    alpha: FloatArray


def has_surfaces(setup: Setup) -> bool:
    """Whether slabs are cut at surfaces."""
    return setup.stages["transfer"].name in MEDIA


def classify(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Classified:
    """Colour and opacity of slabs, with the surfaces that they cross."""
    rgb, alpha = np.zeros((len(length), 3)), np.zeros(len(length))
    for piece in pieces(setup, front, back, length):
        through = 1 - alpha[piece.rows]
        rgb[piece.rows] += through[:, None] * piece.rgb
        alpha[piece.rows] += through * piece.alpha
    return rgb, alpha


def pieces(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Iterator[Piece]:
    """Cut slabs at the surfaces that they cross.

    A slab whose length is told to be another than the way between its samples is thinned or thickened: so are its surfaces.
    """
    surfaces, medium = setup.function.surfaces, MEDIA[setup.stages["transfer"].name]
    values = np.array([surface.value for surface in surfaces])
    rgba = np.array(
        [[(*rgb, alpha) for rgb, alpha in sides] for sides in zip(*((s.front, s.back) for s in surfaces), strict=True)]
    )
    # Count the iso-values at or below both ends.
    number, goal = (np.searchsorted(values, end.value, side="right") for end in (front, back))
    rises, count = goal > number, np.abs(goal - number)
    span = np.where(count > 0, back.value - front.value, 1.0)
    way = back.t_world - front.t_world
    thickness = np.where(way > 0, length / np.where(way > 0, way, 1.0), 1.0)
    begin, value = np.zeros(len(length)), front.value
    for turn in range(int(count.max(initial=0)) + 1):
        # Take the medium up to the next surface, or to the back.
        crosses = count > turn
        surface = np.clip(np.where(rises, number + turn, number - turn - 1), 0, len(values) - 1)
        end = np.where(crosses, (values[surface] - front.value) / span, 1.0)
        next_value = np.where(crosses, values[surface], back.value)
        rows = np.nonzero(count >= turn)[0]
        ends = replace(front[rows], value=value[rows]), replace(back[rows], value=next_value[rows])
        rgb, alpha = medium(setup, *ends, (length * (end - begin))[rows])
        if medium is preintegrated_fast:
            # What lies between surfaces is attenuated on its way all the same.
            inner = (turn > 0) & crosses[rows]
            exact = preintegrated(setup, *ends, (length * (end - begin))[rows])
            rgb = np.where(inner[:, None], exact[0], rgb)
        yield Piece(rows, begin[rows], end[rows], rgb, alpha)
        # Take the surface.
        rows = np.nonzero(crosses)[0]
        side = rgba[np.where(rises[rows], 0, 1), surface[rows]]
        alpha = 1 - (1 - side[:, 3]) ** thickness[rows]
        yield Piece(rows, end[rows], end[rows], side[:, :3] * alpha[:, None], alpha)
        begin, value = end, next_value


def lit_share(setup: Setup, slab: Slab) -> FloatArray:
    """Share (n,) of slabs at which they are lit: the middle; with surfaces, the mean place of what opacity they have."""
    if not has_surfaces(setup):
        return np.full(len(slab.length), 0.5)
    alpha, moment = np.zeros(len(slab.length)), np.zeros(len(slab.length))
    for piece in pieces(setup, slab.front, slab.back, slab.length):
        seen = (1 - alpha[piece.rows]) * piece.alpha
        moment[piece.rows] += seen * (piece.begin + _centre(piece.alpha) * (piece.end - piece.begin))
        alpha[piece.rows] += seen
    return np.where(alpha > 0, moment / np.where(alpha > 0, alpha, 1.0), 0.5)


def _centre(alpha: FloatArray) -> FloatArray:
    """Mean place (n,) of the opacity of a homogeneous slab, from 0 at its front: ``1 / x - exp(-x) / (1 - exp(-x))``."""
    depth = -np.log1p(-np.minimum(alpha, 1 - 1e-15))
    deep = depth > 1e-4
    x = np.where(deep, depth, 1.0)
    return np.where(deep, 1 / x - np.exp(-x) / -np.expm1(-x), 0.5 - depth / 12)


def opacity_share(setup: Setup, slab: Slab, rows: IntArray, wanted: FloatArray) -> FloatArray:
    """Share (n,) of some slabs at which their opacity reaches a wanted one: each piece of medium is homogeneous."""
    if not has_surfaces(setup):
        return _homogeneous_share(slab.alpha[rows], wanted)
    share, alpha = np.full(len(rows), np.inf), np.zeros(len(rows))
    for piece in pieces(setup, slab.front[rows], slab.back[rows], slab.length[rows]):
        before = alpha[piece.rows]
        alpha[piece.rows] += (1 - before) * piece.alpha
        reached = np.nonzero(np.isinf(share[piece.rows]) & (alpha[piece.rows] >= wanted[piece.rows]))[0]
        of_piece = 1 - (1 - wanted[piece.rows[reached]]) / (1 - before[reached])
        within = _homogeneous_share(piece.alpha[reached], of_piece)
        share[piece.rows[reached]] = piece.begin[reached] + within * (piece.end - piece.begin)[reached]
    return np.where(np.isinf(share), 1.0, share)


def _homogeneous_share(alpha: FloatArray, wanted: FloatArray) -> FloatArray:
    """Opacity follows the exponential law."""
    depth = np.log1p(-np.minimum(alpha, 1 - 1e-15))
    return np.clip(np.log1p(-np.minimum(wanted, 1 - 1e-15)) / np.where(depth < 0, depth, -1.0), 0.0, 1.0)


TRANSFERS.update(dict.fromkeys(MEDIA, classify))
