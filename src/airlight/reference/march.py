"""The driver: walk along rays, slab by slab, and let the stages decide what a slab means."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..volume import FloatArray
from .field import field_value
from .integrate import INTEGRATES, Accumulated
from .setup import IntArray, Sample, Setup, Slab
from .shade import LIGHTINGS


@np.errstate(under="ignore")
def march(
    setup: Setup,
    origin: FloatArray,
    direction: FloatArray,
    step_world: float,
    fraction: FloatArray | float = 0.0,
    curved: bool = False,
) -> Accumulated:
    """Integrate rays (n, 3), sampled at distances ``(k + fraction) * step_world``, k whole, and where they enter and leave.

    ``curved`` puts values right for the field's curvature, for transfer stages that integrate along slabs.
    """
    integrate = INTEGRATES[setup.stages["integrate"].name](setup)
    light_slab = LIGHTINGS[setup.stages["lighting"].name]
    acc = integrate.begin(len(origin))

    def sample(rays: IntArray, t_world: FloatArray) -> Sample:
        p_world = origin[rays] + t_world[:, None] * direction[rays]
        p_index = setup.index_of(p_world)
        return Sample(*field_value(setup, p_index), p_index, p_world, t_world)

    # Clip rays to the domain and sample them where they enter.
    t_enter, t_leave = span(setup, origin, direction)
    rays = np.nonzero(t_leave > t_enter)[0]
    front = sample(rays, t_enter[rays])
    shift = np.broadcast_to(np.asarray(fraction, dtype=np.float64), t_enter.shape)
    k = np.floor(t_enter / step_world - shift) + 1
    curved &= integrate.uses_slabs and not integrate.has_surface and getattr(setup.stages["transfer"], "integrates", False)
    before = front

    while rays.size:
        # Go to the next sample of the lattice, or to where the ray leaves.
        back = sample(rays, np.minimum((k[rays] + shift[rays]) * step_world, t_leave[rays]))
        k[rays] += 1
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
            hit = sample(rays[taken], a.t_world + cut * (b.t_world - a.t_world))
            a = b = replace(hit, value=a.value + cut * (b.value - a.value))
            length = np.zeros_like(cut)
        elif not taken.all():
            a, b, length = a[taken], b[taken], length[taken]

        # Classify the slab, light it, add it to its ray.
        some = rays[taken]
        slab = Slab(a, b, length, np.zeros((len(some), 3)), np.zeros(len(some)))
        if integrate.uses_slabs and some.size:
            slab = Slab(a, b, length, *integrate.classify(a, b, length))
            slab = replace(slab, rgb=light_slab(setup, slab, -direction[some]))
        going[taken] &= ~integrate.take(acc, some, slab)

        # Keep the rays that go on; the back of this slab is the front of the next.
        rays, front, before = rays[going], back[going], here[going]
    return integrate.finish(acc)


def bent(before: Sample, here: Sample, after: Sample) -> Sample:
    """Return samples whose straight connections have the mean of a parabola through three neighbours: a sixth further out.

    Between two slabs of lengths L and M a parabola of second derivative c lies ``c L M / 2`` below the chord over both; its
    mean over a slab of length L lies ``c L^2 / 12`` below the mean of that slab's ends.
    """
    whole = after.t_world - before.t_world
    share = np.where(whole > 0, (here.t_world - before.t_world) / np.where(whole > 0, whole, 1.0), 1.0)
    share = share.reshape(-1, *[1] * (here.value.ndim - 1))
    straight = before.value + share * (after.value - before.value)
    values = (s.value.reshape(len(s.value), -1) for s in (before, here, after))
    gaps = np.logical_or.reduce([~np.isfinite(v).all(axis=1) for v in values])
    known = (~(before.empty | here.empty | after.empty | gaps)).reshape(share.shape)
    return replace(here, value=np.where(known, here.value + (here.value - straight) / 6, here.value))


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
