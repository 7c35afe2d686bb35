"""Transfer stages: ``classify(setup, front, back, length (n,)) -> Sent`` of slabs.

The model is ``C = integral of source(x) exp(-tau(0..x)) dx`` over the slab's length d, ``alpha = 1 - exp(-tau(0..d))``. The
source is colour times extinction, or the colour alone of associated functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..transfer.joint import JointFunction
from ..volume import FloatArray
from .homogeneous import homogeneous, source_and_extinction
from .joint import joint, variables
from .region_functions import postclassified_regions, preintegrated_regions
from .setup import IntArray, Sample, Sent, Setup

# Up to this optical depth of a piece, take so many Gauss-Legendre nodes; what lies deeper than ``LAST_SEEN`` adds nothing.
RULES = tuple((most, *np.polynomial.legendre.leggauss(count)) for most, count in ((0.3, 6), (5.0, 12), (np.inf, 28)))
LAST_SEEN = 40.0


def medium(setup: Setup, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Colour (n, 3) and extinction (n,) [1/world] at values (n,)."""
    rgb, extinction = setup.function(value)
    return rgb, extinction


def colour(setup: Setup, sample: Sample) -> FloatArray:
    """Colour (n, 3) of the function at samples."""
    several = isinstance(setup.function, JointFunction)
    return np.asarray(setup.function(variables(setup, sample) if several else sample.value)[0])


@np.errstate(under="ignore")
def postclassified(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Classify a slab as a homogeneous medium, the mean of the media at its two ends."""
    source, extinction = source_and_extinction(setup.function, np.stack([front.value, back.value]))
    return homogeneous(source.mean(axis=0), extinction.mean(axis=0), length)


@np.errstate(under="ignore")
def from_field(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Classify a slab between two media as the homogeneous one that is their mean."""
    mean = (front.value + back.value) / 2
    return homogeneous(mean[:, :3], mean[:, 3], length)


@np.errstate(under="ignore")
def preintegrated_fast(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Integrate source and extinction along the straight line exactly, and attenuate as a homogeneous slab does.

    Engel and Ertl, section 6.3, but for the attenuation by the slab as a whole.
    """
    source, extinction = np.zeros((len(length), 3)), np.zeros(len(length))
    for rows, begin, end in pieces(setup.function.values, front.value, back.value):
        # Source is a quadratic on a piece and extinction linear: Gauss' rule with two nodes is exact.
        for node in (0.5 - 0.75**0.5 / 3, 0.5 + 0.75**0.5 / 3):
            at = begin + (end - begin) * node
            value = front.value[rows] + at * (back.value - front.value)[rows]
            share = (end - begin) / 2
            sent, dims = source_and_extinction(setup.function, value)
            source[rows] += share[:, None] * sent
            extinction[rows] += share * dims
    return homogeneous(source, extinction, length)


def pieces(points: FloatArray, front: FloatArray, back: FloatArray) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """Rows of slabs with a piece between two control points, and where it begins and ends, in the order of the rays."""
    span = back - front
    first = np.searchsorted(points, np.minimum(front, back), side="right")
    last = np.searchsorted(points, np.maximum(front, back), side="left")
    inside = np.maximum(last - first, 0)
    begin = np.zeros(len(front))
    for piece in range(int(inside.max(initial=0)) + 1):
        # End the piece at the next control point in the direction of the values, or at the back.
        cut = inside > piece
        next_point = np.where(cut, np.where(span > 0, first + piece, last - 1 - piece), 0)
        end = np.where(cut, (points[next_point] - front) / np.where(cut, span, 1.0), 1.0)
        rows = np.nonzero(end > begin)[0]
        yield rows, begin[rows], end[rows]
        begin = np.maximum(end, begin)


@np.errstate(under="ignore")
def riemann(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Classify as the papers do: colour ``source * d``, without attenuation inside the slab. For comparison only."""
    value = (front.value + back.value) / 2
    rgb, alpha = setup.function.source(value) * length[:, None], -np.expm1(-medium(setup, value)[1] * length)
    return Sent(rgb, alpha, rgb / 2, alpha / 2)


@np.errstate(under="ignore")
def preintegrated(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Integrate the function along the straight line from the front to the back value, exactly."""
    function, n = setup.function, len(length)
    a, span = front.value, back.value - front.value
    rgb, back_rgb, back_alpha, depth = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    for rows, begin, end in pieces(function.values, a, back.value):
        share = end - begin
        # Find the linear function on the piece from two points inside, so that steps at its ends do no harm.
        rgb_1, tau_1 = medium(setup, a[rows] + (begin + 0.25 * share) * span[rows])
        rgb_3, tau_3 = medium(setup, a[rows] + (begin + 0.75 * share) * span[rows])
        tau_front, tau_back = np.maximum(1.5 * tau_1 - 0.5 * tau_3, 0), np.maximum(1.5 * tau_3 - 0.5 * tau_1, 0)
        rgb_front, rgb_back = 1.5 * rgb_1 - 0.5 * rgb_3, 1.5 * rgb_3 - 0.5 * rgb_1
        # Add what the piece emits, attenuated by the pieces in front, and its mean place.
        d = length[rows] * share
        opacity = np.exp(-depth[rows]) * _attenuated_moments(d, tau_front, tau_back, False)
        light = np.exp(-depth[rows]) * _attenuated_moments(d, tau_front, tau_back, True) if function.associated else opacity
        level, slope, bend = light[:, :, None]
        rise = rgb_back - rgb_front
        sent = level * rgb_front + slope * rise
        rgb[rows] += sent
        back_rgb[rows] += begin[:, None] * sent + share[:, None] * (slope * rgb_front + bend * rise)
        back_alpha[rows] += begin * opacity[0] + share * opacity[1]
        depth[rows] += d * (tau_front + tau_back) / 2
    return Sent(np.maximum(rgb, 0.0), -np.expm1(-depth), np.maximum(back_rgb, 0.0), back_alpha)


def _attenuated_moments(length: FloatArray, tau_front: FloatArray, tau_back: FloatArray, associated: bool) -> FloatArray:
    """Integrals (3, n) over x in 0..1 of ``w``, ``x w`` and ``x^2 w``, ``w = length tau(x) exp(-tau(0..x))``, tau linear.

    Associated sources do without the factor tau in w.
    """
    moments = np.zeros((3, len(length)))
    depth, least = length * (tau_front + tau_back) / 2, -1.0
    for most, nodes, weights in RULES:
        rows = np.nonzero((depth > least) & (depth <= most))[0]
        least = most
        if rows.size == 0:
            continue
        tau_0, rise, d = tau_front[rows, None], (tau_back - tau_front)[rows, None], length[rows, None]
        # Reach as far as can be seen: tau_0 x + rise x^2 / 2 = LAST_SEEN / d, or all the way.
        reach, deep = np.ones_like(d), (depth[rows] > LAST_SEEN)[:, None]
        seen = LAST_SEEN / d[deep]
        reach[deep] = 2 * seen / (tau_0[deep] + np.sqrt(tau_0[deep] ** 2 + 2 * rise[deep] * seen))
        x = reach * (1 + nodes) / 2
        w = reach * weights / 2 * d * np.exp(-d * x * (tau_0 + rise * x / 2))
        w = w if associated else w * (tau_0 + rise * x)
        moments[:, rows] = w.sum(axis=1), (w * x).sum(axis=1), (w * x * x).sum(axis=1)
    return moments


TRANSFERS: dict[str, Callable[[Setup, Sample, Sample, FloatArray], Sent]] = {
    "from_field": from_field,
    "joint": joint,
    "postclassified": postclassified,
    "preintegrated": preintegrated,
    "preintegrated_exact": preintegrated,
    "preintegrated_fast": preintegrated_fast,
    "riemann": riemann,
    "postclassified_regions": postclassified_regions,
    "preintegrated_regions": preintegrated_regions,
}
