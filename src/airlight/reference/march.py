"""The driver: walk along rays, slab by slab, and let the stages decide what a slab means."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..stages.driver import gains_from_curvature
from ..volume import FloatArray
from .blocks import next_stop
from .field import field_value
from .integrate import INTEGRATES, Accumulated, Integrate
from .refine import refined
from .setup import IntArray, Sample, Setup, dark, made_slab
from .shade import LIGHTINGS


@np.errstate(under="ignore")
def march(
    setup: Setup,
    origin: FloatArray,
    direction: FloatArray,
    step_world: float,
    fraction: FloatArray | float = 0.0,
    curved: bool = True,
    refine: str = "bisection",
    blocks: bool = True,
) -> Accumulated:
    """Integrate rays (n, 3), sampled at distances ``(k + fraction) * step_world``, k whole, and where they enter and leave.

    ``curved`` puts values right for the field's curvature where the stages gain from it. ``refine`` tells how the place of a
    surface between two samples is found; with ``blocks`` rays that look for surfaces are sampled in each block of voxels.
    """
    integrate = INTEGRATES[setup.stages["integrate"].name](setup)
    light_slab = LIGHTINGS[setup.stages["lighting"].name]
    acc = integrate.begin(len(origin))

    def sample(rays: IntArray, t_world: FloatArray) -> Sample:
        p_world = origin[rays] + t_world[:, None] * direction[rays]
        p_index = setup.index_of(p_world)
        return Sample(*field_value(setup, p_index), p_index, p_world, t_world)

    line = setup.index_of(origin), direction @ setup.layer.volume.index_from_world[:3, :3].T

    # Clip rays to the domain and sample them where they enter.
    t_enter, t_leave = span(setup, origin, direction)
    rays = np.nonzero(t_leave > t_enter)[0]
    front = sample(rays, t_enter[rays])
    shift = np.broadcast_to(np.asarray(fraction, dtype=np.float64), t_enter.shape)
    k = np.floor(t_enter / step_world - shift) + 1
    curved &= gains_from_curvature(setup.stages)
    before = front

    while rays.size:
        # Go to the next sample of the lattice, to the next block, or to where the ray leaves.
        t_lattice = t_next = (k[rays] + shift[rays]) * step_world
        if integrate.has_surface and blocks:
            t_next = np.minimum(t_lattice, next_stop(line[0][rays], line[1][rays], t_enter[rays], front.t_world))
        back = sample(rays, np.minimum(t_next, t_leave[rays]))
        k[rays] += t_next >= t_lattice
        going = back.t_world < t_leave[rays]

        # Move the sample away from the straight line between its neighbours.
        here = back
        if curved:
            back = bent(before, here, sample(rays, np.minimum((k[rays] + shift[rays]) * step_world, t_leave[rays])))

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
            a = b = _hit(setup, integrate, sample, (line[0][rays[taken]], line[1][rays[taken]]), rays[taken], a, b, cut, refine)
            length = np.zeros_like(cut)
        elif not taken.all():
            a, b, length = a[taken], b[taken], length[taken]

        # Classify the slab, light it, add it to its ray.
        some = rays[taken]
        slab = made_slab(dark(len(some)), a, b, length)
        if integrate.uses_slabs and some.size:
            sent = integrate.sheet(a, rises) if integrate.has_surface else integrate.classify(a, b, length)
            slab = made_slab(sent, a, b, length)
            slab = replace(slab, rgb=light_slab(setup, slab, -direction[some]))
        going[taken] &= ~integrate.take(acc, some, slab)

        # Keep the rays that go on; the back of this slab is the front of the next.
        rays, front, before = rays[going], back[going], here[going]
    return integrate.finish(acc)


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


def bent(before: Sample, here: Sample, after: Sample) -> Sample:
    """Return samples whose straight connections have the mean of a parabola through three neighbours: a sixth further out.

    Between two slabs of lengths L and M a parabola of second derivative c lies ``c L M / 2`` below the chord over both; its
    mean over a slab of length L lies ``c L^2 / 12`` below the mean of that slab's ends.
    """
    whole = after.t_world - before.t_world
    share = np.where(whole > 0, (here.t_world - before.t_world) / np.where(whole > 0, whole, 1.0), 1.0)
    share = share.reshape(-1, *[1] * (here.value.ndim - 1))
    straight = before.value + share * (after.value - before.value)
    # What is not there in one of the three stays as it is, channel by channel.
    there = np.logical_and.reduce([np.isfinite(s.value) & ~s.empty.reshape(share.shape) for s in (before, here, after)])
    return replace(here, value=np.where(there, here.value + (here.value - straight) / 6, here.value))


def span(setup: Setup, origin: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (n,) at which rays enter and leave the domain, not before the eye; leave <= enter is a miss."""
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
    return np.where(np.isfinite(enter), enter, 0.0), np.where(np.isfinite(enter), leave, 0.0)
