"""Several layers along the same rays: each classifies and lights its own slab, and those in one place are mixed evenly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np

from ..stage import make_stage
from ..stages.driver import gains_from_curvature
from ..volume import FloatArray
from .clips import NOWHERE, Faces, Piece, caps, lit_behind, lit_faces, pieces
from .covers import Covers, over, parts_of, put_before
from .field import field_value
from .integrate import INTEGRATES, Accumulated
from .march import bent, march, span
from .setup import BoolArray, IntArray, Sample, Sent, Setup, Slab, dark, made_slab
from .shade import LIGHTINGS

MOST_ALPHA = 1 - 1e-7
OPAQUE_DEPTH = 1e4
"""Depth of slabs that are all but opaque, from ``MOST_ALPHA`` on: that of a surface, beside which nothing shows."""


@np.errstate(under="ignore", divide="ignore")  # rays that miss a layer are held at the eye, where pixels have no width
def march_layers(
    setups: Sequence[Setup],
    origin: FloatArray,
    direction: FloatArray,
    step_world: FloatArray | float,
    fraction: FloatArray | float = 0.0,
    curved: bool = True,
    covers: Covers | None = None,
    refine: str = "bisection",
) -> Accumulated:
    """Integrate rays (n, 3) through layers that overlap in any way.

    Of surfaces that end rays the nearest is seen; projections of values are those of each layer, added.

    All are sampled at distances ``(k + fraction) * step_world``, and where one of them begins or ends, as clips keep it: there
    slabs are cut.
    """
    if INTEGRATES[setups[0].stages["integrate"].name].has_surface:
        found = [march(s, origin, direction, step_world, fraction, curved, refine, False, covers) for s in setups]
        return _nearest(found)
    if not INTEGRATES[setups[0].stages["integrate"].name].uses_slabs:
        added = _added([march(s, origin, direction, step_world, fraction, covers=covers, covered=False) for s in setups])
        return added if covers is None else over(covers, added, False)
    plain = {**setups[0].stages, "transfer": make_stage("transfer", "postclassified")}
    integrate = INTEGRATES[setups[0].stages["integrate"].name](replace(setups[0], stages=plain))
    acc = integrate.begin(len(origin))
    shift, step = (np.broadcast_to(np.asarray(of, dtype=np.float64), len(origin)) for of in (fraction, step_world))
    curved &= all(gains_from_curvature(setup.stages) for setup in setups)
    ended = np.zeros(len(origin), dtype=bool)
    ordered = covers is not None and getattr(setups[0].stages["integrate"], "takes_covers", False)
    taken_covers = np.zeros((0, 0) if covers is None else covers.t_world.shape, dtype=bool)
    spans = [span(setup, origin, direction) for setup in setups]
    spans = [(np.where(leave > enter, enter, 0.0), np.where(leave > enter, leave, 0.0)) for enter, leave in spans]
    kept = [list(pieces(setup.clips, origin, direction, *ends)) for setup, ends in zip(setups, spans, strict=True)]
    held = [_piece_at(cut, spans[0][0]) for cut in kept]

    def sample(number: int, rays: IntArray, t_world: FloatArray) -> Sample:
        """Samples of a layer, of which rays see a part."""
        part = held[number]
        t_held = np.clip(t_world, part.begin[rays], part.end[rays])
        p_world = origin[rays] + t_held[:, None] * direction[rays]
        p_index = setups[number].index_of(p_world)
        return Sample(*field_value(setups[number], p_index), p_index, p_world, t_held)

    def cap(rays: IntArray, t_world: FloatArray, end: str, by: str) -> None:
        """Take the solid faces of what is cut here: their mean, where several layers are solid."""
        rgb, count = np.zeros((len(origin), 3)), np.zeros(len(origin))
        for number, setup in enumerate(setups):
            here = sample(number, rays, t_world)
            is_here = (here.t_world == t_world) & (getattr(held[number], end)[rays] == t_world)
            rows, slab = caps(setup, here, np.where(is_here, getattr(held[number], by)[rays], NOWHERE), -direction[rays])
            rgb[rays[rows]] += slab.rgb
            count[rays[rows]] += 1
        rows = rays[count[rays] > 0]
        rgb = rgb[rows] / count[rows, None]
        at = replace(sample(0, rows, np.zeros(len(rows))), t_world=t_world[count[rays] > 0])
        ended[rows] |= integrate.take(
            acc, rows, Slab(rgb, np.ones(len(rows)), rgb / 2, np.ones(len(rows)) / 2, at, at, 0 * at.t_world)
        )

    # Go from the first layer to the last, from border to border of what is kept of them.
    met = [leave > enter for enter, leave in spans]
    t_enter = np.min([np.where(m, enter, np.inf) for m, (enter, _) in zip(met, spans, strict=True)], axis=0)
    t_enter = np.where(np.isfinite(t_enter), t_enter, 0.0)
    t_leave = np.max([leave for _, leave in spans], axis=0)
    if covers is not None:
        t_leave = np.minimum(t_leave, covers.opaque_at)
    nowhere = np.full(len(origin), NOWHERE)
    whole = Piece(t_enter, np.maximum(t_enter, t_leave), nowhere, nowhere)
    for _, part in parts_of(covers if ordered else None, [whole]):
        if covers is not None and ordered:
            put_before(covers, taken_covers, acc, part.begin, (part.end > part.begin) & ~ended)
        for begin, end in _between_borders(kept, part):
            held[:] = [_piece_at(cut, (begin + end) / 2) for cut in kept]
            rays = np.nonzero((end > begin) & ~ended)[0]
            cap(rays, begin[rays], "begin", "near")
            faces = _faces(setups, sample, held, direction)
            started = np.nonzero((end > begin) & ~ended)[0]
            rays = started
            t_front = begin[rays]
            fronts = befores = [sample(number, rays, t_front) for number in range(len(setups))]
            k = np.floor(begin / step - shift) + 1
            while rays.size:
                t_back = np.minimum((k[rays] + shift[rays]) * step[rays], end[rays])
                k[rays] += 1
                heres = backs = [sample(number, rays, t_back) for number in range(len(setups))]
                if curved:
                    t_ahead = np.minimum((k[rays] + shift[rays]) * step[rays], end[rays])
                    aheads = [sample(number, rays, t_ahead) for number in range(len(setups))]
                    backs = [bent(*four) for four in zip(setups, befores, heres, aheads, strict=True)]
                # Mix the slabs of all layers.
                source, depth = np.zeros((len(rays), 3)), np.zeros(len(rays))
                for setup, front, back, face in zip(setups, fronts, backs, faces, strict=True):
                    rows, slab = _lit_slab(setup, front, back, face[rays], -direction[rays])
                    per_alpha = _depth_per_alpha(slab.alpha)
                    source[rows] += slab.rgb * per_alpha[:, None]
                    depth[rows] += slab.alpha * per_alpha
                # Add what they send to their rays.
                mixed = _even(source, depth)
                ends = (replace(fronts[0], t_world=t_front), replace(backs[0], t_world=t_back))
                stopped = integrate.take(acc, rays, made_slab(mixed, *ends, t_back - t_front))
                ended[rays] |= stopped
                going = ~stopped & (t_back < end[rays])
                rays, t_front = rays[going], t_back[going]
                fronts, befores = [back[going] for back in backs], [here[going] for here in heres]
            rays = started[~ended[started]]
            cap(rays, end[rays], "end", "far")
    if covers is None or not ordered:
        return integrate.finish(acc) if covers is None else over(covers, integrate.finish(acc), False)
    put_before(covers, taken_covers, acc, np.full(len(origin), np.inf), np.ones(len(origin), dtype=bool))
    return integrate.finish(acc)


def _nearest(found: Sequence[Accumulated]) -> Accumulated:
    """What lies nearest to the eye of what was found in each layer."""
    first = np.argmin([acc.t_world for acc in found], axis=0)
    rays = np.arange(len(first))
    parts = {field.name: np.stack([getattr(acc, field.name) for acc in found])[first, rays] for field in fields(found[0])}
    return Accumulated(**parts)


def _added(found: Sequence[Accumulated]) -> Accumulated:
    """Light of all layers; depth is that of the one from which most comes, of equal ones of the nearest."""
    rgb, alpha, t_world = (np.stack([getattr(acc, name) for acc in found]) for name in ("rgb", "alpha", "t_world"))
    brightness = np.where(np.isfinite(t_world), rgb.sum(axis=-1), -1.0)
    depth = np.where(brightness == brightness.max(axis=0), t_world, np.inf).min(axis=0)
    return replace(found[0], rgb=rgb.sum(axis=0), alpha=1 - np.prod(1 - alpha, axis=0), t_world=depth)


def _between_borders(kept: list[list[Piece]], part: Piece) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Parts of rays between the distances (n,) at which pieces of layers begin and end; ``end <= begin`` is none."""
    low, high = part.begin, np.maximum(part.begin, part.end)
    borders = [t for cut in kept for piece in cut for t in (piece.begin, piece.end)]
    stops = np.sort([low, high, *(np.clip(t, low, high) for t in borders)], axis=0)
    yield from pairwise(stops)


def _piece_at(kept: list[Piece], t_world: FloatArray) -> Piece:
    """The piece of each ray that holds a distance (n,); one at the eye, without length, where none does."""
    begin, end = np.zeros_like(t_world), np.zeros_like(t_world)
    near, far = np.full(len(t_world), NOWHERE), np.full(len(t_world), NOWHERE)
    for piece in kept:
        holds = (piece.begin < t_world) & (t_world < piece.end)
        begin, end = np.where(holds, piece.begin, begin), np.where(holds, piece.end, end)
        near, far = np.where(holds, piece.near, near), np.where(holds, piece.far, far)
    return Piece(begin, end, near, far)


def _faces(setups: Sequence[Setup], sample: object, held: Sequence[Piece], direction: FloatArray) -> list[Faces]:
    """How the cut at which its part begins is lit in each layer."""
    rays = np.arange(len(direction))
    found = []
    for number, (setup, part) in enumerate(zip(setups, held, strict=True)):
        cut = sample(number, rays, part.begin)  # type: ignore[operator]
        found.append(replace(lit_faces(setup, cut, part.near, -direction), t_world=part.begin))
    return found


def _lit_slab(setup: Setup, front: Sample, back: Sample, faces: Faces, to_eye: FloatArray) -> tuple[IntArray, Slab]:
    """Slabs of one layer, lit by itself, where they have a length and hold something, and the numbers of their rays."""
    length = (back.t_world - front.t_world) * np.where(front.empty | back.empty, 0.5, 1.0)
    a, b = front.where_empty_take(back), back.where_empty_take(front)
    taken: BoolArray = ~a.empty & (length > 0)
    rows = np.nonzero(taken)[0]
    a, b, length = a[taken], b[taken], length[taken]
    sent = INTEGRATES["emission_absorption"](setup).classify(a, b, length) if rows.size else dark(0)
    slab = made_slab(sent, a, b, length)
    if rows.size:
        rgb = LIGHTINGS[setup.stages["lighting"].name](setup, slab, to_eye[rows])
        slab = replace(slab, rgb=lit_behind(setup, faces[rows], slab, rgb))
    return rows, slab


def _depth_per_alpha(alpha: FloatArray) -> FloatArray:
    """By how much the depths (n,) of slabs exceed their opacities."""
    thin, opaque = alpha <= 0, alpha >= MOST_ALPHA
    inner = np.where(thin | opaque, 0.5, alpha)
    return np.where(opaque, OPAQUE_DEPTH, np.where(thin, 1.0, -np.log1p(-inner) / inner))


def _even(source: FloatArray, depth: FloatArray) -> Sent:
    """What slabs send whose light, as if nothing were attenuated, is spread as evenly as their depth."""
    some = depth > 0
    alpha = -np.expm1(-depth)
    rgb = source * np.where(some, alpha / np.where(some, depth, 1.0), 1.0)[:, None]
    return Sent(rgb, alpha, rgb / 2, alpha / 2)
