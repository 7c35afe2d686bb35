"""Boundaries between materials, found by what derivatives the samples of each value have.

After G. Kindlmann and J. W. Durkin, "Semi-automatic generation of transfer functions for direct volume rendering", 1998.
Between two materials with values v0 and v1 the value is taken to run as an error function: a step blurred by a Gaussian of
deviation sigma. Samples of value v then have the mean gradient g(v) and the mean second derivative along it h(v), which tell
how far from the middle of the boundary they lie:

    p(v) = -sigma^2 h(v) / max(g(v) - g_threshold, 0).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..errors import ValueRangeError
from ..volume import FloatArray, Volume
from .histogram import Progress, Samples
from .joint_axes import Axis

BINS = 256
SMOOTHING = 1.5
PROMINENCE = 0.1
ABOVE_NOISE = 2.5
FEWEST_SAMPLES = 8
SAMPLES_FOR_NOISE = 1 << 20
MIDDLE = 0.6
"""Share of the greatest gradient that an ideal boundary keeps up to one sigma from its middle."""


@dataclass(frozen=True, eq=False)
class Profile:
    """What derivatives the samples of each value have, on average.

    Attributes
    ----------
    axis
        Stretch of values that was looked at.
    values
        Middles (n,) of its bins, data units.
    weights
        How much (n,) is known of each: the sum of squared gradients.
    first
        Mean gradient magnitude (n,) g(v), data units per world unit; 0 where there are next to no samples.
    second
        Mean second derivative along the gradient (n,) h(v), data units per world unit squared.
    threshold
        Gradient that noise alone makes, g_threshold.
    """

    axis: Axis
    values: FloatArray
    weights: FloatArray
    first: FloatArray
    second: FloatArray
    threshold: float

    def position(self, sigma: float) -> FloatArray:
        """Signed distance (n,) from the middle of the boundary in world units; infinite where gradients are only noise."""
        steep = self.first - self.threshold
        way = -(sigma**2) * self.second / np.where(steep > 0, steep, 1.0)
        return np.where(steep > 0, way, np.copysign(np.inf, -self.second))


@dataclass(frozen=True)
class Boundary:
    """A boundary between two materials.

    Attributes
    ----------
    value
        Value in its middle, data units.
    low, high
        Values of the materials, if the boundary is ideal.
    sigma
        Deviation of its blur, world units: two thirds of the change lie within one sigma of the middle.
    gradient
        Gradient magnitude in its middle, data units per world unit.
    stretch
        Values around it that it has for itself, up to its neighbours'.
    """

    value: float
    low: float
    high: float
    sigma: float
    gradient: float
    stretch: tuple[float, float]


def profile(
    volume: Volume,
    channel: int | str = 0,
    time: int = 0,
    *,
    threshold: float | None = None,
    progress: Progress | None = None,
) -> Profile:
    """Mean derivatives by value, g(v) and h(v).

    Samples count by their squared gradient, so that what is homogeneous and has the value of a boundary by chance or by noise
    does not hide it; where all samples of a value have one gradient this is the plain mean of the paper. The sums are
    smoothed by a Gaussian of 1.5 of at most 256 bins.

    Parameters
    ----------
    volume, channel, time
        Whose samples; empty ones stay out.
    threshold
        Gradient that is taken for noise; when left out, the lower quartile of all gradients: noise, where a quarter of the
        volume or more is homogeneous.
    progress
        Called with ``("histogram", done, total)``.

    Raises
    ------
    ValueRangeError
        For thresholds below 0.
    """
    if threshold is not None and not (np.isfinite(threshold) and threshold >= 0):
        raise ValueRangeError("threshold", f"is {threshold}, must be at least 0")
    c = volume.channel_index(channel)
    samples = Samples(volume, ("value", "gradient", "second"), c, time)
    axis = samples.axis(0, BINS)
    # No more bins than there are whole values.
    n = int(np.clip(round(axis.span), 2, BINS)) if volume.dtype.kind in "iub" else BINS
    sums, counts = np.zeros((3, n)), np.zeros(n)
    kept: list[FloatArray] = [np.zeros(1)]
    for value, gradient, second in samples.batches(1, progress):
        place = np.floor((value - axis.low) * (n / axis.span))
        inside = (place >= 0) & (place < n)
        place = place[inside].astype(np.int64)
        g, h = gradient[inside], second[inside]
        for row, weight in enumerate((g * g, g * g * g, g * g * h)):
            sums[row] += np.bincount(place, weight, minlength=n)
        counts += np.bincount(place, minlength=n)
        # A copy, since a view would keep the whole batch.
        kept.append(gradient[:: max(1, int(np.prod(volume.size)) // SAMPLES_FOR_NOISE)].copy())
    kernel = np.exp(-0.5 * (np.arange(-5, 6) / SMOOTHING) ** 2)
    weights, first, second = (np.convolve(row, kernel / kernel.sum(), mode="full")[5:-5] for row in sums)
    enough = (np.convolve(counts, kernel, mode="full")[5:-5] >= FEWEST_SAMPLES) & (weights > 0)
    first, second = (np.where(enough, row / np.where(enough, weights, 1.0), 0.0) for row in (first, second))
    values = axis.low + (np.arange(n) + 0.5) * axis.span / n
    noise = float(np.percentile(np.concatenate(kept), 25)) if threshold is None else float(threshold)
    return Profile(axis, values, weights, first, second, noise)


def boundaries(
    volume: Volume | Profile,
    channel: int | str = 0,
    time: int = 0,
    *,
    threshold: float | None = None,
    progress: Progress | None = None,
) -> list[Boundary]:
    """Boundaries between materials, by rising value.

    Each is a hump of g(v) that stands out by a tenth of the highest one and reaches 2.5 times the threshold. Along an
    ideal boundary -h / g is x / sigma^2, and x is the integral of dv / g; so the middle and sigma follow from a straight line
    through the hump's upper part. (The paper has the same from the extremes of g and h alone, which noise shifts more.)
    Boundaries that share values, like that of the first and the third material with that of the first and the second, are
    told apart by their humps only.

    Parameters
    ----------
    volume, channel, time, threshold, progress
        As for ``profile``; or a profile that is there already.
    """
    known = volume if isinstance(volume, Profile) else profile(volume, channel, time, threshold=threshold, progress=progress)
    g = known.first
    found = []
    for top, (begin, end) in _humps(g, PROMINENCE * float(g.max())):
        if g[top] < ABOVE_NOISE * known.threshold:
            continue
        steep = np.flatnonzero(g[begin:end] < MIDDLE * g[top]) + begin
        first = int(steep[steep < top].max(initial=begin - 1)) + 1
        last = int(steep[steep > top].min(initial=end))
        if last - first < 3:
            continue
        here = slice(first, last)
        step = known.axis.span / len(g)
        along = np.cumsum(step / g[here])
        lean = -known.second[here] / g[here]
        weight = known.weights[here] / known.weights[here].sum()
        centre = float((weight * along).sum())
        slope = float((weight * (along - centre) * lean).sum() / (weight * (along - centre) ** 2).sum())
        middle = centre - float((weight * lean).sum()) / slope if slope > 0 else math.inf
        if not along[0] < middle < along[-1]:
            continue
        value = float(np.interp(middle, along, known.values[here]))
        sigma = 1 / math.sqrt(slope)
        gradient = float(np.interp(value, known.values, g))
        half = gradient * sigma * math.sqrt(math.pi / 2)
        stretch = float(known.values[begin]), float(known.values[end - 1])
        found.append(Boundary(value, value - half, value + half, sigma, gradient, stretch))
    return found


def values_at(known: Profile, boundary: Boundary, positions: FloatArray) -> FloatArray:
    """Values (m,) at distances (m,) from the middle of a boundary: p(v) turned round, within the boundary's own stretch."""
    low, high = boundary.stretch
    mine = (known.values >= low) & (known.values <= high)
    values, p = known.values[mine], known.position(boundary.sigma)[mine]
    most = 2 * float(np.abs(positions).max())
    p = np.clip(p, -most, most)
    # The fit saw the whole upper part of the hump, and knows the middle better than a single mean of h.
    p = np.clip(p - float(np.interp(boundary.value, values, p)), -most, most)
    # Outward from the middle p only grows; where noise says otherwise, the values nearer to the middle hold.
    middle = int(np.searchsorted(values, boundary.value))
    above = np.maximum.accumulate(np.maximum(p[middle:], 0.0))
    below = np.minimum.accumulate(np.minimum(p[:middle], 0.0)[::-1])[::-1]
    distances = np.concatenate([below, [0.0], above])
    return np.maximum.accumulate(np.interp(positions, distances, np.insert(values, middle, boundary.value)))


def _humps(curve: FloatArray, least: float) -> list[tuple[int, tuple[int, int]]]:
    """Maxima that stand out by ``least`` from the valleys to both sides, with the stretch between these valleys."""
    tops = []
    for i in range(1, len(curve) - 1):
        if not (curve[i] > curve[i - 1] and curve[i] >= curve[i + 1]):
            continue
        higher = np.flatnonzero(curve > curve[i])
        left, right = int(higher[higher < i].max(initial=-1)) + 1, int(higher[higher > i].min(initial=len(curve)))
        if curve[i] - max(curve[left:i].min(), curve[i + 1 : right].min(initial=curve[i])) >= least > 0:
            tops.append(i)
    ends = [0, *(a + int(np.argmin(curve[a:b])) for a, b in itertools.pairwise(tops)), len(curve)]
    return [(top, (ends[i], ends[i + 1])) for i, top in enumerate(tops)]
