"""Slabs cut at surfaces of the transfer function, each where the field itself passes its value.

Which surfaces a slab crosses, and in which order, is told by its two samples as in ``surfaces.py``. Each is then looked for
between the one in front of it and the back of the slab. What lies between them is a slab like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace

import numpy as np

from ..stages.transfer import Transfer
from ..volume import FloatArray
from .integrate import Integrate
from .refine import refined
from .setup import IntArray, Sample, Sent, Setup, Slab, made_slab
from .surfaces import MEDIA
from .transfer import TRANSFERS

Field = Callable[[IntArray, FloatArray], Sample]


def sharpened(setup: Setup) -> Setup:
    """Return a setup whose transfer stage leaves surfaces to the driver, if it draws any."""
    transfer = setup.stages["transfer"]
    if not isinstance(transfer, Transfer):
        return setup
    return replace(setup, stages={**setup.stages, "transfer": transfer.sharpened()})


def is_cut(setup: Setup) -> bool:
    """Whether slabs are cut at surfaces by the driver."""
    return setup.stages["transfer"].name in CUT


def cut_slabs(
    setup: Setup,
    integrate: Integrate,
    refine: str,
    along: Field,
    line: tuple[FloatArray, FloatArray],
    slabs: tuple[Sample, Sample, FloatArray],
    ends: tuple[Sample, Sample],
) -> Iterator[tuple[IntArray, Slab]]:
    """Pieces of slabs and the surfaces between them, in the order of the rays, with the numbers of their slabs.

    ``along(rows, t_world)`` samples the rays of some of the slabs, ``line`` is their origins and directions (n, 3) in index
    coordinates. ``slabs`` are samples at both ends, and lengths; ``ends`` the same samples with the field's own values.
    """
    front, back, length = slabs
    tint, thinning = integrate.thinning(front, back, length)
    surfaces = setup.function.surfaces
    values = np.array([surface.value for surface in surfaces])
    sides = np.array([[(*rgb, alpha) for rgb, alpha in (s.front, s.back)] for s in surfaces])
    turn = _turn(values, along, slabs, ends)
    for near, far in ((ends[0], turn), (turn, ends[1])):
        number, goal = (np.searchsorted(values, end.value, side="right") for end in (near, far))
        rises, count = goal > number, np.abs(goal - number)
        for passed in range(int(count.max(initial=0))):
            # Find the next surface of each slab that has one more.
            rows = np.nonzero(count > passed)[0]
            surface = np.where(rises, number + passed, number - passed - 1)[rows]
            t_world = np.empty(len(rows))
            for s in np.unique(surface):
                t_world[surface == s] = _place(setup, refine, along, line, rows[surface == s], near, far, float(values[s]))
            hit = replace(along(rows, t_world), value=values[surface], empty=np.zeros(len(rows), dtype=bool))
            # Take the medium before it, then the surface.
            way, by = t_world - front.t_world[rows], (tint[rows], thinning[rows])
            yield rows, made_slab(integrate.classify(front[rows], hit, way, by), front[rows], hit, way)
            side = sides[surface, np.where(rises[rows], 0, 1)]
            alpha = 1 - (1 - side[:, 3]) ** thinning[rows]
            rgb = side[:, :3] * tint[rows] * alpha[:, None]
            yield rows, made_slab(Sent(rgb, alpha, rgb / 2, alpha / 2), hit, hit, np.zeros(len(rows)))
            front, near = _with(front, rows, hit), _with(near, rows, hit)
            length = np.where(count > passed, back.t_world - front.t_world, length)
    # Take what is left.
    yield np.arange(len(length)), made_slab(integrate.classify(front, back, length, (tint, thinning)), front, back, length)


def _turn(levels: FloatArray, along: Field, slabs: tuple[Sample, Sample, FloatArray], ends: tuple[Sample, Sample]) -> Sample:
    """Samples where the field turns within slabs, by the parabola that curvature tells of; their backs where it does not.

    Curvature has moved both ends by a sixth of their distance from the lines between their neighbours. Only slabs count of
    which it has moved an end past a surface.
    """
    (front, back, _), (near, far) = slabs, ends
    numbers = [np.searchsorted(levels, sample.value, side="right") for sample in (front, near, back, far)]
    bend = 6 * (front.value - near.value + back.value - far.value)
    looked_at = ((numbers[0] != numbers[1]) | (numbers[2] != numbers[3])) & ~near.empty & ~far.empty & (bend != 0)
    share = 0.5 + (far.value - near.value) / np.where(looked_at, bend, 1.0)
    rows = np.nonzero(looked_at & (share > 0) & (share < 1))[0]
    t_world = near.t_world[rows] + share[rows] * (far.t_world - near.t_world)[rows]
    return _with(far, rows, along(rows, t_world)) if rows.size else far


def _place(
    setup: Setup,
    refine: str,
    along: Field,
    line: tuple[FloatArray, FloatArray],
    rows: IntArray,
    near: Sample,
    far: Sample,
    level: float,
) -> FloatArray:
    """Distances (n,) at which the field passes a level in some of the slabs."""

    def values(some: IntArray, t_world: FloatArray) -> FloatArray:
        here = along(rows[some], t_world)
        return np.where(here.empty, np.nan, here.value)

    t_ends, s_ends = (np.stack([getattr(end, name)[rows] for end in (near, far)], axis=1) for name in ("t_world", "value"))
    return refined(setup, refine, values, (line[0][rows], line[1][rows]), t_ends, s_ends, level)


def _with(samples: Sample, rows: IntArray, others: Sample) -> Sample:
    """Samples with those of some rows replaced."""
    parts = {field.name: getattr(samples, field.name).copy() for field in fields(samples)}
    for name, part in parts.items():
        part[rows] = getattr(others, name)
    return Sample(**parts)


CUT = {f"{name.removesuffix('surfaces')}sharp_surfaces": classify for name, classify in MEDIA.items()}
TRANSFERS.update(CUT)
