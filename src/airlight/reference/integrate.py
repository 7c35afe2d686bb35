"""What becomes of the slabs along a ray: one class a stage, with the functions ``begin``, ``take`` and ``finish``.

Arrays of ``Accumulated`` hold all rays; ``take`` gets the numbers of those whose slabs come, and tells which of them stop.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..transfer.joint import JointFunction
from ..volume import FloatArray
from .hit_colours import hit_colour
from .modulation import weight
from .region import part_at
from .setup import BoolArray, IntArray, Sample, Sent, Setup, Slab
from .surfaces import opacity_share
from .transfer import TRANSFERS, colour

LEAST_SHARE = 1e-7  # of a slab, to a surface that is passed: at 0 are those in which rays begin


@dataclass(eq=False)
class Accumulated:
    """State of n rays: associated ``rgb`` (n, 3); ``alpha``, depth ``t_world``, a ``value``, a ``length`` (n,)."""

    rgb: FloatArray
    alpha: FloatArray
    t_world: FloatArray
    value: FloatArray
    length: FloatArray


class Integrate:
    """Base: nothing seen yet, slabs made by the transfer stage, and the result as it was accumulated."""

    uses_slabs: ClassVar[bool] = False
    has_surface: ClassVar[bool] = False

    def __init__(self, setup: Setup) -> None:
        self.setup, self.stage = setup, setup.stages["integrate"]

    def begin(self, n: int) -> Accumulated:
        """Return the state of rays that have seen nothing."""
        return Accumulated(np.zeros((n, 3)), np.zeros(n), np.full(n, np.inf), np.zeros(n), np.zeros(n))

    @property
    def level(self) -> float:
        """Value of the surface."""
        raise NotImplementedError

    def crossing(self, front: Sample, back: Sample) -> FloatArray:
        """Fraction of each slab at which the field has a surface, 2 where it has none."""
        raise NotImplementedError

    def surface(self, front: Sample, back: Sample) -> FloatArray:
        """Fraction of each slab at which a surface is drawn, 2 where there is none."""
        raise NotImplementedError

    def thinning(self, front: Sample, back: Sample, length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Factors of slabs' colours (n, 3) and extinctions (n,): of the region in their middle, and of modulation."""
        tint, opacity = part_at(self.setup, (front.p_index + back.p_index) / 2)
        return tint, opacity * weight(self.setup, front, back, length)

    def classify(
        self, front: Sample, back: Sample, length: FloatArray, by: tuple[FloatArray, FloatArray] | None = None
    ) -> Sent:
        """What slabs send, before they are lit; ``by`` is their ``thinning``, where it is that of longer ones."""
        tint, thinning = by or self.thinning(front, back, length)
        sent = TRANSFERS[self.setup.stages["transfer"].name](self.setup, front, back, length * thinning)
        return replace(sent, rgb=sent.rgb * tint, back_rgb=sent.back_rgb * tint)

    def sheet(self, hit: Sample, rises: FloatArray) -> Sent:
        """What surfaces send, met on the way up (1) or down (-1), or where a ray begins (0)."""
        raise NotImplementedError

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Add the next slab of each of the rays; return which of them need no more."""
        raise NotImplementedError

    def finish(self, acc: Accumulated) -> Accumulated:
        """Return the result."""
        return acc


class EmissionAbsorption(Integrate):
    """Composite front to back until the ray is opaque; depth is where opacity passes one half."""

    uses_slabs = True

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Add the slab behind all others."""
        before = acc.alpha[rays]
        acc.rgb[rays] += (1 - before)[:, None] * slab.rgb
        after = before + (1 - before) * slab.alpha
        acc.alpha[rays] = after
        # Find the depth inside the slab.
        passes = np.nonzero((before < 0.5) & (after >= 0.5))[0]
        share = opacity_share(self.setup, slab, passes, 1 - 0.5 / (1 - before[passes]))
        acc.t_world[rays[passes]] = slab.front.t_world[passes] + share * slab.length[passes]
        ends = np.asarray(after >= self.stage.opaque_at)
        if self.stage.fills_rest:
            acc.rgb[rays[ends]] /= after[ends, None]
            acc.alpha[rays[ends]] = 1.0
        return ends


class Extreme(Integrate):
    """Keep the greatest value times ``sign`` of all samples, and where it comes first; alpha tells whether there is one."""

    sign: ClassVar[int]

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Compare both ends of the slab."""
        for end in (slab.front, slab.back):
            better = (acc.alpha[rays] == 0) | (self.sign * end.value > self.sign * acc.value[rays])
            chosen = rays[better]
            acc.value[chosen], acc.t_world[chosen], acc.alpha[chosen] = end.value[better], end.t_world[better], 1.0
            if isinstance(self.setup.function, JointFunction):
                acc.rgb[chosen] = colour(self.setup, end[better])
        return np.zeros(len(rays), dtype=bool)

    def finish(self, acc: Accumulated) -> Accumulated:
        """Colour the value, where that alone has a colour."""
        if not isinstance(self.setup.function, JointFunction):
            acc.rgb = self.setup.function(acc.value)[0] * acc.alpha[:, None]
        return acc


class Mip(Extreme):
    """The greatest value."""

    sign = 1


class MinIp(Extreme):
    """The least value."""

    sign = -1


class Mean(Extreme):
    """The mean value by the trapezoid rule, over the way that is not empty; it has no depth."""

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Add the slab's mean value, weighted by its length."""
        acc.value[rays] += (slab.front.value + slab.back.value) / 2 * slab.length
        acc.length[rays] += slab.length
        return np.zeros(len(rays), dtype=bool)

    def finish(self, acc: Accumulated) -> Accumulated:
        """Divide by the length and colour the value."""
        seen = acc.length > 0
        acc.value = acc.value / np.where(seen, acc.length, 1.0)
        acc.alpha = seen.astype(np.float64)
        return super().finish(acc)


class FirstHit(Integrate):
    """The front surface at the iso-value: opaque, lit, in the function's colour; or the cut face of what lies above it."""

    uses_slabs = True
    has_surface = True

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.iso = setup.function.half_extinction_value if self.stage.iso is None else float(self.stage.iso)

    @property
    def level(self) -> float:
        """The iso-value."""
        return self.iso

    def crossing(self, front: Sample, back: Sample) -> FloatArray:
        """Pass the iso-value inside the slab, or begin in what is solid."""
        above, goes_above = self._is_above(front.value), self._is_above(back.value)
        crossing = above != goes_above
        rise = np.where(crossing, back.value - front.value, 1.0)
        cut = np.where(crossing, np.maximum((self.iso - front.value) / np.where(rise == 0, 1.0, rise), LEAST_SHARE), 2.0)
        solid = np.zeros_like(above) if self.stage.side == "both" else above == (self.stage.side == "above")
        return np.where(solid, 0.0, cut)

    def _is_above(self, value: FloatArray) -> BoolArray:
        """What lies on the very value is solid."""
        return np.asarray(value > self.iso if self.stage.side == "below" else value >= self.iso)

    def surface(self, front: Sample, back: Sample) -> FloatArray:
        """Take crossings where at least half of the region is drawn."""
        cut = self.crossing(front, back)
        # Opacity runs straight from end to end: a surface may be hidden, or appear where the hidden part ends.
        one, other = part_at(self.setup, front.p_index)[1], part_at(self.setup, back.p_index)[1]
        shown = (1 - cut) * one + cut * other >= 0.5
        appears = ~shown & (cut <= 1) & (other >= 0.5)
        begin = np.where(appears, (0.5 - one) / np.where(appears, other - one, 1.0), 2.0)
        value = (1 - begin) * front.value + begin * back.value
        inside = appears & (self._is_above(value) == (self.stage.side == "above")) & (self.stage.side != "both")
        return np.where(shown | (cut > 1), cut, np.where(inside, begin, 2.0))

    def sheet(self, hit: Sample, rises: FloatArray) -> Sent:
        """Return the opaque surface, met on the way up (1) or down (-1), or where a ray begins (0)."""
        if self.stage.side == "above":
            hit = replace(hit, value=np.maximum(hit.value, self.iso))
        rgb = colour(self.setup, hit)
        for surface in getattr(self.setup.function, "surfaces", ()):
            if surface.value == self.iso:
                rgb = np.where((rises > 0)[:, None], surface.front[0], np.where((rises < 0)[:, None], surface.back[0], rgb))
        if self.stage.colour_by != "function":
            rgb = np.where((rises != 0)[:, None], hit_colour(self.setup, hit), rgb)
        rgb, alpha = rgb * part_at(self.setup, hit.p_index)[0], np.ones(len(rises))
        return Sent(rgb, alpha, rgb / 2, alpha / 2)

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Keep the surface and stop."""
        acc.rgb[rays], acc.alpha[rays], acc.t_world[rays] = slab.rgb, slab.alpha, slab.front.t_world
        return np.ones(len(rays), dtype=bool)


INTEGRATES: dict[str, type[Integrate]] = {
    "emission_absorption": EmissionAbsorption,
    "mip": Mip,
    "minip": MinIp,
    "mean": Mean,
    "first_hit": FirstHit,
}
