"""Surfaces of equal value: they cut a slab into pieces of medium and sheets without length, taken in the order of the ray.

What lies at or above an iso-value is inside. A slab whose front is outside and whose back is inside goes up through the surface
and sees its front; the other way round it sees its back. Nothing else crosses it, so a sample on the very value counts once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..volume import FloatArray
from .modulation import weight
from .setup import IntArray, Sample, Sent, Setup, Slab
from .transfer import TRANSFERS, preintegrated, preintegrated_fast

MEDIA = {
    "surfaces": preintegrated,
    "preintegrated_surfaces": preintegrated,
    "preintegrated_exact_surfaces": preintegrated,
    "preintegrated_fast_surfaces": preintegrated_fast,
}


@dataclass(frozen=True, eq=False)
class Piece:
    """One piece of some of the slabs, from a share of their length to another; of surfaces both are the same."""

    rows: IntArray
    begin: FloatArray
    end: FloatArray
    light: Sent

    @property
    def alpha(self) -> FloatArray:
        """Opacity of the piece."""
        return self.light.alpha


def has_surfaces(setup: Setup) -> bool:
    """Whether slabs are cut at surfaces."""
    return setup.stages["transfer"].name in MEDIA


def classify(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Colour and opacity of slabs, with the surfaces that they cross."""
    n = len(length)
    rgb, back_rgb, alpha, back_alpha = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    for piece in pieces(setup, front, back, length):
        rows, light, share = piece.rows, piece.light, piece.end - piece.begin
        through = 1 - alpha[rows]
        rgb[rows] += through[:, None] * light.rgb
        back_rgb[rows] += through[:, None] * (piece.begin[:, None] * light.rgb + share[:, None] * light.back_rgb)
        back_alpha[rows] += through * (piece.begin * light.alpha + share * light.back_alpha)
        alpha[rows] += through * light.alpha
    return Sent(rgb, alpha, back_rgb, back_alpha)


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
        light = medium(setup, *ends, (length * (end - begin))[rows])
        if medium is preintegrated_fast:
            # What lies between surfaces is attenuated on its way all the same.
            inner = (turn > 0) & crosses[rows]
            exact = preintegrated(setup, *ends, (length * (end - begin))[rows])
            light = Sent(
                np.where(inner[:, None], exact.rgb, light.rgb),
                light.alpha,
                np.where(inner[:, None], exact.back_rgb, light.back_rgb),
                np.where(inner, exact.back_alpha, light.back_alpha),
            )
        yield Piece(rows, begin[rows], end[rows], light)
        # Take the surface.
        rows = np.nonzero(crosses)[0]
        side = rgba[np.where(rises[rows], 0, 1), surface[rows]]
        alpha = 1 - (1 - side[:, 3]) ** thickness[rows]
        rgb = side[:, :3] * alpha[:, None]
        yield Piece(rows, end[rows], end[rows], Sent(rgb, alpha, rgb / 2, alpha / 2))
        begin, value = end, next_value


def opacity_share(setup: Setup, slab: Slab, rows: IntArray, wanted: FloatArray) -> FloatArray:
    """Share (n,) of some slabs at which their opacity reaches a wanted one: each piece of medium is homogeneous."""
    if not (has_surfaces(setup) and rows.size):
        return _homogeneous_share(slab.alpha[rows], wanted)
    share, alpha = np.full(len(rows), np.inf), np.zeros(len(rows))
    front, back, length = slab.front[rows], slab.back[rows], slab.length[rows]
    for piece in pieces(setup, front, back, length * weight(setup, front, back, length)):
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
