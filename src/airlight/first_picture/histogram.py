"""What histograms tell: a threshold, the reach of the noise, and the materials."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..volume import FloatArray

NEXT_TO_BACKGROUND = 0.12


def noise_above(low_faces: FloatArray, background: float, most: float) -> float:
    """Value above which the noise of the background does not reach, from samples of it; ``most`` at the most."""
    spread = 1.4826 * float(np.median(np.abs(low_faces - background)))
    return min(background + max(4 * spread, float(np.percentile(low_faces, 90)) - background), most)


def otsu_threshold(counts: npt.NDArray[np.int64], middle: FloatArray) -> float:
    """Threshold that parts a histogram into the two classes of least variance."""
    # By number of bin: squares of values may be too large.
    place = np.arange(len(counts))
    weight = np.cumsum(counts) / counts.sum()
    mean = np.cumsum(counts * place) / counts.sum()
    inside = (weight > 0) & (weight < 1)
    between = np.zeros(len(counts))
    between[inside] = (mean[-1] * weight[inside] - mean[inside]) ** 2 / (weight[inside] * (1 - weight[inside]))
    best = np.flatnonzero(between >= between.max() * (1 - 1e-9))
    return float(np.interp(best.mean(), place, middle))


def materials(
    counts: npt.NDArray[np.int64], middle: FloatArray, background_bin: int, noise_top: float
) -> tuple[tuple[float, ...], float]:
    """Peaks of the histogram above the background that stand out from the valley before them, and the first valley."""
    smooth = counts.astype(np.float64)
    for _ in range(3):
        smooth = np.convolve(np.pad(smooth, 2, mode="edge"), (1 / 9, 2 / 9, 3 / 9, 2 / 9, 1 / 9), mode="valid")
    above = counts[middle > noise_top].sum()
    # An empty bin at the end lets the last peak end, too.
    smooth = np.append(smooth, 0.0)
    found: list[tuple[float, float]] = []
    valley, top, rising = background_bin, background_bin, False
    for i in range(background_bin + 1, len(smooth)):
        if not rising:
            valley = i if smooth[i] < smooth[valley] else valley
            stands_out = smooth[i] > 1.25 * smooth[valley] + 4 * np.sqrt(smooth[valley])
            rising, top = bool(stands_out and middle[i] > noise_top), i
            continue
        top = i if smooth[i] > smooth[top] else top
        if smooth[i] < 0.8 * smooth[top]:
            if counts[valley : i + 1].sum() > 0.03 * above:
                found.append((float(middle[top]), float(middle[valley])))
            rising, valley = False, i
    # A peak just above the background is its noise, where the surroundings were partly set to one value.
    background = float(middle[background_bin])
    while len(found) > 1 and found[0][0] - background < NEXT_TO_BACKGROUND * (found[-1][0] - background):
        del found[0]
    return tuple(peak for peak, _ in found), found[0][1] if found else 0.0
