"""Boundaries that share values, told apart by value and gradient: the arches of the joint histogram, each drawn into a point.

Along an ideal boundary (see ``airlight.transfer.boundary``) a sample of value v, gradient g and second derivative h lies
x = -sigma h / g sigmas from the middle, where gradient and value are

    g_0 = g exp(x^2 / 2),    v_0 = v - g_0 sigma (integral of exp(-t^2 / 2) from 0 to x).

With one sigma for the whole volume, which is what the blur of one scanner makes, every sample near to a middle so votes for
the top (v_0, g_0) of its arch, and tops are the maxima of the votes. This is the position in two variables of Kindlmann and
Durkin 1998 turned round; that the votes lie on points, not on arches, is like the LH histograms of Šereda et al. 2006.
"""

from __future__ import annotations

import math

import numpy as np

from ..errors import ValueRangeError
from ..volume import FloatArray, Volume
from .boundary import Boundary, Profile, boundaries
from .histogram import Progress, Samples

BINS = 96
NEAR = 0.8
"""Distance from the middle up to which samples vote, in sigmas."""
SMOOTHING = 2.0
APART = 8
LEAST_GRADIENT = 0.25
LEAST_VOTES = 0.02
ABOVE_NOISE = 2.5


def arches(
    volume: Volume,
    known: Profile,
    channel: int | str = 0,
    time: int = 0,
    *,
    sigma: float | None = None,
    progress: Progress | None = None,
) -> list[Boundary]:
    """Boundaries by value and gradient, by rising value.

    Those whose gradient is less than a quarter of the strongest one's, or than 2.5 times the profile's threshold, are taken
    for the inside of materials; those with less than a fiftieth of the most votes, for chance.

    Parameters
    ----------
    volume, channel, time
        Whose samples.
    known
        Their profile.
    sigma
        Deviation of the blur, world units; that of the sharpest of ``boundaries`` when left out.
    progress
        Called with ``("histogram", done, total)``.

    Raises
    ------
    ValueRangeError
        For a sigma that is not positive.
    """
    if sigma is not None and not (np.isfinite(sigma) and sigma > 0):
        raise ValueRangeError("sigma", f"is {sigma}, must be positive")
    if sigma is None:
        found = boundaries(known)
        if not found:
            return []
        sigma = max(found, key=lambda b: b.gradient).sigma
    samples = Samples(volume, ("value", "gradient", "second"), volume.channel_index(channel), time)
    most = samples.axis(1, BINS).high
    votes = _smoothed(_votes(samples, known, sigma, most, progress))
    tops = []
    for j, i in _maxima(votes):
        near = votes[max(0, j - 1) : j + 2, max(0, i - 1) : i + 2]
        rows, columns = np.mgrid[max(0, j - 1) : j + 2, max(0, i - 1) : i + 2][:, : near.shape[0], : near.shape[1]]
        row, column = float((rows * near).sum() / near.sum()), float((columns * near).sum() / near.sum())
        tops.append((known.axis.low + (column + 0.5) * known.axis.span / BINS, (row + 0.5) * most / BINS, float(votes[j, i])))
    steep = [t for t in tops if t[1] > ABOVE_NOISE * known.threshold]
    steep = [t for t in steep if t[1] >= LEAST_GRADIENT * max(gradient for _, gradient, _ in steep)]
    kept = [t for t in steep if t[2] >= LEAST_VOTES * max(count for *_, count in steep)]
    half = sigma * math.sqrt(math.pi / 2)
    return [Boundary(v, v - g * half, v + g * half, sigma, g, (v - g * half, v + g * half)) for v, g, _ in sorted(kept)]


def _votes(samples: Samples, known: Profile, sigma: float, most: float, progress: Progress | None) -> FloatArray:
    """Votes (n, n): rows by gradient, columns by value."""
    counts = np.zeros(BINS * BINS)
    for value, gradient, second in samples.batches(1, progress):
        x = -sigma * second / np.where(gradient > 0, gradient, 1.0)
        near = (gradient > 2 * known.threshold) & (gradient > 0.05 * most) & (np.abs(x) < NEAR)
        x = x[near]
        top = gradient[near] * np.exp(x * x / 2)
        # The series of the integral: beyond its fourth term there is less than 1e-4 of it.
        middle = value[near] - top * sigma * x * (1 - x**2 / 6 + x**4 / 40 - x**6 / 336)
        column, row = (middle - known.axis.low) * (BINS / known.axis.span), top * (BINS / most)
        inside = (column >= 0) & (column < BINS) & (row < BINS)
        cell = row[inside].astype(np.int64) * BINS + column[inside].astype(np.int64)
        counts += np.bincount(cell, minlength=len(counts))
    return counts.reshape(BINS, BINS)


def _smoothed(counts: FloatArray) -> FloatArray:
    kernel = np.exp(-0.5 * (np.arange(-8, 9) / SMOOTHING) ** 2)
    band = np.array([[kernel[j - i + 8] if abs(j - i) <= 8 else 0.0 for i in range(BINS)] for j in range(BINS)])
    return np.asarray(band @ counts @ band.T)


def _maxima(votes: FloatArray) -> list[tuple[int, int]]:
    """Places that nothing within ``APART`` bins exceeds."""
    padded = np.pad(votes, APART)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (2 * APART + 1, 2 * APART + 1))
    rows, columns = np.nonzero((votes == windows.max(axis=(2, 3))) & (votes > 0))
    return [(int(j), int(i)) for j, i in zip(rows, columns, strict=True)]
