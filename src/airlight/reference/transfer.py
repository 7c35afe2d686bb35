"""Transfer stages: ``classify(setup, front, back, length (n,)) -> (rgb (n, 3), alpha (n,))`` of slabs.

The model is ``C = integral of source(x) exp(-tau(0..x)) dx`` over the slab's length d, ``alpha = 1 - exp(-tau(0..d))``. The
source is colour times extinction, or the colour alone of associated functions.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import FloatArray
from .setup import Sample, Setup

Classified = tuple[FloatArray, FloatArray]

# Up to this optical depth of a piece, take so many Gauss-Legendre nodes; what lies deeper than ``LAST_SEEN`` adds nothing.
NODES = ((0.3, 6), (5.0, 12), (np.inf, 28))
LAST_SEEN = 40.0


def medium(setup: Setup, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Colour (n, 3) and extinction (n,) [1/world] at values (n,)."""
    return setup.function(value)


@np.errstate(under="ignore")
def postclassified(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Classified:
    """Classify a slab as a homogeneous medium, the mean of the media at its two ends."""
    extinction = (medium(setup, front.value)[1] + medium(setup, back.value)[1]) / 2
    source = (setup.function.source(front.value) + setup.function.source(back.value)) / 2
    depth = extinction * length
    alpha = -np.expm1(-depth)
    # Length times the mean transmittance over the slab, which is 1 where nothing absorbs.
    absorbs = depth > 1e-30
    mean = np.where(absorbs, alpha / np.where(absorbs, depth, 1.0), 1.0)
    return source * (length * mean)[:, None], alpha


@np.errstate(under="ignore")
def riemann(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Classified:
    """Classify as the papers do: colour ``source * d``, without attenuation inside the slab. For comparison only."""
    value = (front.value + back.value) / 2
    alpha = -np.expm1(-medium(setup, value)[1] * length)
    return setup.function.source(value) * length[:, None], alpha


@np.errstate(under="ignore")
def preintegrated(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Classified:
    """Integrate the function along the straight line from the front to the back value, exactly."""
    function, n = setup.function, len(length)
    a, span = front.value, back.value - front.value
    # Count the control points strictly between the two values: they cut the slab into pieces.
    first = np.searchsorted(function.values, np.minimum(a, back.value), side="right")
    last = np.searchsorted(function.values, np.maximum(a, back.value), side="left")
    inside = np.maximum(last - first, 0)
    rgb, depth, begin = np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    for piece in range(int(inside.max(initial=0)) + 1):
        # End the piece at the next control point in the direction of the values, or at the back.
        cut = inside > piece
        next_point = np.where(cut, np.where(span > 0, first + piece, last - 1 - piece), 0)
        end = np.where(cut, (function.values[next_point] - a) / np.where(cut, span, 1.0), 1.0)
        rows = np.nonzero(end > begin)[0]
        share = (end - begin)[rows]
        # Find the linear function on the piece from two points inside, so that steps at its ends do no harm.
        rgb_1, tau_1 = medium(setup, a[rows] + (begin[rows] + 0.25 * share) * span[rows])
        rgb_3, tau_3 = medium(setup, a[rows] + (begin[rows] + 0.75 * share) * span[rows])
        tau_front, tau_back = np.maximum(1.5 * tau_1 - 0.5 * tau_3, 0), np.maximum(1.5 * tau_3 - 0.5 * tau_1, 0)
        rgb_front, rgb_back = 1.5 * rgb_1 - 0.5 * rgb_3, 1.5 * rgb_3 - 0.5 * rgb_1
        # Add what the piece emits, attenuated by the pieces in front.
        d = length[rows] * share
        level, slope = _attenuated_moments(d, tau_front, tau_back, function.associated)
        through = np.exp(-depth[rows])
        rgb[rows] += (through * level)[:, None] * rgb_front + (through * slope)[:, None] * (rgb_back - rgb_front)
        depth[rows] += d * (tau_front + tau_back) / 2
        begin = np.maximum(end, begin)
    return np.maximum(rgb, 0.0), -np.expm1(-depth)


def _attenuated_moments(length: FloatArray, tau_front: FloatArray, tau_back: FloatArray, associated: bool) -> Classified:
    """Integrals over x in 0..1 of ``w(x)`` and ``x w(x)``, ``w = length * tau(x) * exp(-tau(0..x))``, tau running linearly.

    Associated sources do without the factor tau in w.
    """
    level, slope = np.zeros_like(length), np.zeros_like(length)
    depth, least = length * (tau_front + tau_back) / 2, -1.0
    for most, count in NODES:
        rows = np.nonzero((depth > least) & (depth <= most))[0]
        least = most
        if rows.size == 0:
            continue
        nodes, weights = np.polynomial.legendre.leggauss(count)
        tau_0, rise, d = tau_front[rows, None], (tau_back - tau_front)[rows, None], length[rows, None]
        # Reach as far as can be seen: tau_0 x + rise x^2 / 2 = LAST_SEEN / d, or all the way.
        reach, deep = np.ones_like(d), (depth[rows] > LAST_SEEN)[:, None]
        seen = LAST_SEEN / d[deep]
        reach[deep] = 2 * seen / (tau_0[deep] + np.sqrt(tau_0[deep] ** 2 + 2 * rise[deep] * seen))
        x = reach * (1 + nodes) / 2
        w = reach * weights / 2 * d * np.exp(-d * x * (tau_0 + rise * x / 2))
        w = w if associated else w * (tau_0 + rise * x)
        level[rows], slope[rows] = w.sum(axis=1), (w * x).sum(axis=1)
    return level, slope


TRANSFERS: dict[str, Callable[[Setup, Sample, Sample, FloatArray], Classified]] = {
    "postclassified": postclassified,
    "preintegrated": preintegrated,
    "riemann": riemann,
}
