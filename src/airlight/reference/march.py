"""The driver: walk along rays, slab by slab, and let the stages decide what a slab means."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from ..stages.driver import gains_from_curvature, may_lengthen
from ..transfer import Channels, TransferFunction
from ..transfer.regions import ByRegion
from ..volume import FloatArray
from .blocks import longest_piece, next_stop
from .channels import parts
from .clips import caps, lit_behind, lit_faces, pieces
from .covers import Covers, over, parts_of, put_before
from .cuts import cut_slabs, is_cut, sharpened
from .field import field_value
from .integrate import INTEGRATES, Accumulated, Integrate
from .refine import crossings, refined
from .setup import IntArray, Sample, Setup, Slab, dark, made_slab
from .shade import LIGHTINGS

SAME_STEP = 1e-6  # of a voxel


@np.errstate(under="ignore")
def march(
    setup: Setup,
    origin: FloatArray,
    direction: FloatArray,
    step_world: FloatArray | float,
    fraction: FloatArray | float = 0.0,
    curved: bool = True,
    refine: str = "bisection",
    blocks: bool = True,
    covers: Covers | None = None,
    adaptive: bool = False,
    covered: bool = True,
) -> Accumulated:
    """Integrate rays (n, 3), sampled at distances ``(k + fraction) * step_world``, k whole, and where they enter and leave.

    Step and fraction are numbers, or (n,) of each ray.

    ``curved`` puts values right for the field's curvature where the stages gain from it. ``refine`` tells how the place of a
    surface between two samples is found; with ``blocks`` rays that look for surfaces are sampled in each block of voxels, those
    that look for surfaces of the function where steps are longer than a voxel.
    ``covers`` are what rays meet of meshes; without ``covered`` those that are not taken in between only end rays.
    ``adaptive`` takes longer slabs where little of them gets through to the eye.
    """
    if refine != "none":
        setup = sharpened(setup)
    integrate = INTEGRATES[setup.stages["integrate"].name](setup)
    cuts = is_cut(setup) and integrate.uses_slabs and not integrate.has_surface
    light_slab = LIGHTINGS[setup.stages["lighting"].name]
    acc = integrate.begin(len(origin))

    def sample(rays: IntArray, t_world: FloatArray) -> Sample:
        p_world = origin[rays] + t_world[:, None] * direction[rays]
        p_index = setup.index_of(p_world)
        return Sample(*field_value(setup, p_index), p_index, p_world, t_world)

    line = setup.index_of(origin), direction @ setup.layer.volume.index_from_world[:3, :3].T

    shift, step = (np.broadcast_to(np.asarray(of, dtype=np.float64), len(origin)) for of in (fraction, step_world))
    by_blocks = blocks and (integrate.has_surface or (cuts and bool(step.min() > (1 + SAME_STEP) * setup.spacing_world)))
    curved &= gains_from_curvature(setup.stages) and not (by_blocks and cuts)
    adaptive &= may_lengthen(setup.stages, setup.function, setup.layer.labels)
    ended = np.zeros(len(origin), dtype=bool)
    # Composited slabs are put in order with meshes; what is one value of the whole ray stays whole.
    ordered = covers is not None and getattr(setup.stages["integrate"], "takes_covers", False)
    taken_covers = np.zeros((0, 0) if covers is None else covers.t_world.shape, dtype=bool)

    # Go through the domain, piece by piece as clips keep it, and take the face of the cut where a piece begins.
    t_domain, t_behind = span(setup, origin, direction)
    if covers is not None:
        t_behind = np.minimum(t_behind, covers.opaque_at)
    for piece, part in parts_of(covers if ordered else None, pieces(setup.clips, origin, direction, t_domain, t_behind)):
        t_enter, t_leave = part.begin, part.end
        if covers is not None and ordered:
            put_before(covers, taken_covers, acc, t_enter, (t_leave > t_enter) & ~ended)
        rays = np.nonzero((t_leave > t_enter) & ~ended)[0]
        rows, cap = caps(setup, sample(rays, t_enter[rays]), part.near[rays], -direction[rays])
        ended[rays[rows]] |= integrate.take(acc, rays[rows], cap)
        rays = rays[~ended[rays]]
        front = before = sample(rays, t_enter[rays])
        k = np.floor(t_enter / step - shift) + 1
        faces = lit_faces(setup, sample(np.arange(len(origin)), piece.begin), piece.near, -direction)

        while rays.size:
            # Go to the next sample of the lattice, of a block (or to the next cell), or to where it leaves.
            t_lattice = t_next = (k[rays] + shift[rays]) * step[rays]
            by_cells = integrate.has_surface and blocks and refine == "cells"
            if by_cells:
                t_next = next_stop(line[0][rays], line[1][rays], t_enter[rays], front.t_world, voxels=1)
            elif by_blocks:
                longest = longest_piece(line[1][rays], step[rays])
                t_next = next_stop(line[0][rays], line[1][rays], t_enter[rays], front.t_world, longest)
            back = sample(rays, np.minimum(t_next, t_leave[rays]))
            if by_cells:
                back = _next_side(integrate.level, sample, rays, line, front, back)
            pace = pace_at(1 - acc.alpha[rays]) if adaptive else np.ones(len(rays))
            k[rays] = np.where(t_next >= t_lattice, pace * (np.floor(k[rays] / pace) + 1), k[rays])
            going = back.t_world < t_leave[rays]

            # Move the sample away from the straight line between its neighbours.
            here = back
            if curved:
                back = bent(setup, before, here, sample(rays, np.minimum((k[rays] + shift[rays]) * step[rays], t_leave[rays])))

            # Give an empty end the other end's sample and the slab half its length; leave out slabs with two empty ends.
            length = (back.t_world - front.t_world) * np.where(front.empty | back.empty, 0.5, 1.0)
            a, b = front.where_empty_take(back), back.where_empty_take(front)
            taken = ~a.empty

            # Cut the slab at a surface: that alone is taken, with no length.
            if integrate.has_surface:
                cut = integrate.surface(a, b)
                taken &= cut <= 1
                a, b, cut = a[taken], b[taken], cut[taken]
                rises = np.where(cut > 0, np.sign(_scalar(b.value) - _scalar(a.value)), 0.0)
                a = b = _hit(
                    setup, integrate, sample, (line[0][rays[taken]], line[1][rays[taken]]), rays[taken], a, b, cut, refine
                )
                length = np.zeros_like(cut)
            elif not taken.all():
                a, b, length = a[taken], b[taken], length[taken]

            # Classify the slab, or cut it at surfaces of the function.
            some = rays[taken]
            parts: Iterable[tuple[IntArray, Slab]]
            if cuts and some.size:
                ends = before.where_empty_take(here)[taken], here.where_empty_take(before)[taken]

                def along(rows: IntArray, t_world: FloatArray, some: IntArray = some) -> Sample:
                    return sample(some[rows], t_world)

                parts = cut_slabs(setup, integrate, refine, along, (line[0][some], line[1][some]), (a, b, length), ends)
            else:
                sent = dark(len(some))
                if integrate.uses_slabs and some.size:
                    sent = integrate.sheet(a, rises) if integrate.has_surface else integrate.classify(a, b, length)
                parts = [(np.arange(len(some)), made_slab(sent, a, b, length))]

            # Light what there is and add it to its ray, until that needs no more.
            stopped = np.zeros(len(some), dtype=bool)
            for rows, slab in parts:
                left = ~stopped[rows]
                rows, slab = rows[left], slab[left]
                if integrate.uses_slabs and rows.size:
                    rgb = light_slab(setup, slab, -direction[some[rows]])
                    slab = replace(slab, rgb=lit_behind(setup, faces[some[rows]], slab, rgb))
                stopped[rows] |= integrate.take(acc, some[rows], slab)
            going[taken] &= ~stopped
            ended[some] |= stopped

            # Take the face of the cut where the piece ends.
            left = rays[~going & ~ended[rays]]
            rows, cap = caps(setup, sample(left, t_leave[left]), part.far[left], -direction[left])
            ended[left[rows]] |= integrate.take(acc, left[rows], cap)

            # Keep the rays that go on; the back of this slab is the front of the next.
            rays, front, before = rays[going], back[going], here[going]
    if covers is None or not ordered:
        done = integrate.finish(acc)
        return over(covers, done, integrate.has_surface) if covers is not None and covered else done
    put_before(covers, taken_covers, acc, np.full(len(origin), np.inf), np.ones(len(origin), dtype=bool))
    return integrate.finish(acc)


def _next_side(
    level: float,
    sample: Callable[[IntArray, FloatArray], Sample],
    rays: IntArray,
    line: tuple[FloatArray, FloatArray],
    front: Sample,
    back: Sample,
) -> Sample:
    """Backs of slabs: the first root where both ends are on one side of the level."""
    scalar = _scalar(front.value)
    below = scalar < level

    def field(rows: IntArray, t_world: FloatArray) -> FloatArray:
        here = sample(rays[rows], t_world)
        return np.where(here.empty, np.nan, _scalar(here.value))

    ends = np.stack([front.t_world, back.t_world], axis=1)
    found = crossings(field, (line[0][rays], line[1][rays]), ends, level, np.where(below, 1.0, -1.0))
    on_one_side = below == (_scalar(back.value) < level)
    turns = np.isfinite(found) & ~front.empty & (on_one_side | back.empty) & (found > front.t_world) & (found < back.t_world)
    if not turns.any():
        return back
    there = sample(rays, np.where(turns, found, back.t_world))
    value = there.value.copy()
    _scalar(value)[turns] = np.where(below, level, np.nextafter(level, -np.inf))[turns]
    return replace(there, value=value, empty=there.empty & ~turns)


def _hit(
    setup: Setup,
    integrate: Integrate,
    sample: Callable[[IntArray, FloatArray], Sample],
    line: tuple[FloatArray, FloatArray],
    rays: IntArray,
    front: Sample,
    back: Sample,
    cut: FloatArray,
    refine: str,
) -> Sample:
    """Samples at the surfaces inside slabs: at the fractions ``cut``, or sharpened where the slab's ends lie on either side."""
    t_world = front.t_world + cut * (back.t_world - front.t_world)
    value = front.towards(back, cut).value
    if refine == "none":
        return replace(sample(rays, t_world), value=value)
    crosses = (cut > 0) & (cut == integrate.crossing(front, back))
    scalars = [_scalar(end.value) for end in (front, back)]

    def field(rows: IntArray, t_world: FloatArray) -> FloatArray:
        here = sample(rays[crosses][rows], t_world)
        return np.where(here.empty, np.nan, _scalar(here.value))

    ends, values = (np.stack(pair, axis=1)[crosses] for pair in ([front.t_world, back.t_world], scalars))
    lines = line[0][crosses], line[1][crosses]
    t_world[crosses] = refined(setup, refine, field, lines, ends, values, integrate.level)
    hit = sample(rays, t_world)
    value = np.where(crosses.reshape(-1, *[1] * (value.ndim - 1)), hit.value, value)
    _scalar(value)[crosses] = integrate.level
    return replace(hit, value=value)


def _scalar(value: FloatArray) -> FloatArray:
    """Numbers (n,) by which samples are compared: of several channels the first."""
    return value if value.ndim == 1 else value[:, 0]


def pace_at(through: FloatArray) -> FloatArray:
    """Length (n,) of slabs in steps where rays are adaptive: powers of two, up to 8.

    What a slab is off by grows as the square of its length: squares times what gets through are at most 1.
    """
    return np.asarray(2.0 ** sum(through <= 4.0**-n for n in (1, 2, 3)))


def bent(setup: Setup, before: Sample, here: Sample, after: Sample) -> Sample:
    """Return samples whose straight connections have the mean of a parabola through three neighbours: a sixth further out.

    Between two slabs of lengths L and M a parabola of second derivative c lies ``c L M / 2`` below the chord over both; its
    mean over a slab of length L lies ``c L^2 / 12`` below the mean of that slab's ends. Values at which there is nothing stay
    on the stretch that they lie on, as the field does.
    """
    whole = after.t_world - before.t_world
    share = np.where(whole > 0, (here.t_world - before.t_world) / np.where(whole > 0, whole, 1.0), 1.0)
    share = share.reshape(-1, *[1] * (here.value.ndim - 1))
    straight = before.value + share * (after.value - before.value)
    # What is not there in one of the three stays as it is, channel by channel.
    there = np.logical_and.reduce([np.isfinite(s.value) & ~s.empty.reshape(share.shape) for s in (before, here, after)])
    return replace(here, value=held(setup, here.value, np.where(there, here.value + (here.value - straight) / 6, here.value)))


def held(setup: Setup, found: FloatArray, moved: FloatArray) -> FloatArray:
    """Values ``moved``; those ``found`` on a stretch where nothing is stay on it: the four widest, of channels two."""
    function = setup.function
    if isinstance(function, Channels):
        moved = moved.copy()
        for place, part in parts(setup):
            moved[:, place] = _on_stretches(found[:, place], moved[:, place], part.empty_stretches, 2)
        return moved
    if isinstance(function, TransferFunction | ByRegion) and found.ndim == 1:
        return _on_stretches(found, moved, function.empty_stretches, 4)
    return moved


def _on_stretches(found: FloatArray, moved: FloatArray, stretches: Iterable[tuple[float, float]], most: int) -> FloatArray:
    for low, high in sorted(stretches, key=lambda ends: ends[0] - ends[1])[:most]:
        moved = np.where((found >= low) & (found <= high), np.clip(moved, low, high), moved)
    return moved


def span(setup: Setup, origin: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (n,) at which rays enter and leave the domain, not before the eye; leave <= enter is a miss.

    A ray without a direction meets nothing.
    """
    low, high = setup.domain
    o = setup.index_of(origin)
    d = direction @ setup.layer.volume.index_from_world[:3, :3].T
    # Take the two distances at which each pair of faces is crossed; a ray along the faces is between them or not.
    along = np.abs(d) <= 1e-14 * np.abs(d).max(axis=1, keepdims=True)
    pace = np.where(along, 1.0, d)
    t_low, t_high = (low - o) / pace, (high - o) / pace
    between = (low <= o) & (o <= high)
    t_near = np.where(along, np.where(between, -np.inf, np.inf), np.minimum(t_low, t_high))
    t_far = np.where(along, np.where(between, np.inf, -np.inf), np.maximum(t_low, t_high))
    enter, leave = np.maximum(t_near.max(axis=1), 0.0), t_far.min(axis=1)
    meets = np.isfinite(enter) & d.any(axis=1)
    return np.where(meets, enter, 0.0), np.where(meets, leave, 0.0)
