"""How far neighbouring offsets disagree: whether samples lie densely enough, told from the finished image alone.

Where samples of neighbouring pixels are shifted against each other, in squares of 4 x 4 pixels, an image that depends on where
samples lie becomes uneven (Scharsach, section 5, which names that an indicator of undersampling).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..transfer.colour import linear_to_srgb
from ..volume import FloatArray

PERIOD_PX = 4  # of the pattern: pixels so far apart have the same offset
FULL = 0.05  # disagreement from which on the overlay is all colour
LOW_RGB, HIGH_RGB = np.array([1.0, 0.1, 0.0]), np.array([1.0, 0.95, 0.2])


def disagreement_of(rgba: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Standard deviation (h, w) that offsets seem to cause, of the channel in which it is greatest, in linear light.

    How far pixels are from the mean of their four neighbours, over squares of 4 x 4 pixels, beyond how far they are from that
    of the four pixels with the same offset: what the picture itself does there, at ramps, edges and textures, is taken off. So
    it is 0 rather than too much where the picture is as restless as its offsets.
    """
    image = rgba.astype(np.float64)
    other, same = (over_period((image - mean_at(image, distance)) ** 2) for distance in (1, PERIOD_PX))
    # The difference of a number from the mean of four others has 5/4 of its variance.
    caused = np.maximum(other - same, 0.0).max(axis=-1) / 1.25
    found: npt.NDArray[np.float32] = np.sqrt(caused).astype(np.float32)
    return found


def mean_at(image: FloatArray, distance: int) -> FloatArray:
    """Mean of the pixels at a distance to the left and right, above and below; mirrored at the border."""
    d, pads = distance, [(distance, distance)] * 2 + [(0, 0)]
    wide = np.pad(image, pads, "symmetric")
    return np.asarray((wide[2 * d :, d:-d] + wide[: -2 * d, d:-d] + wide[d:-d, 2 * d :] + wide[d:-d, : -2 * d]) / 4)


def over_period(values: FloatArray) -> FloatArray:
    """Means over squares of 4 x 4 pixels round each."""
    before = PERIOD_PX // 2
    wide = np.pad(values, [(before, PERIOD_PX - 1 - before)] * 2 + [(0, 0)], "symmetric")
    rows = np.mean([wide[k : k + len(values)] for k in range(PERIOD_PX)], axis=0)
    return np.asarray(np.mean([rows[:, k : k + values.shape[1]] for k in range(PERIOD_PX)], axis=0))


def disagreement_picture(rgb: npt.NDArray[np.float32], disagreement: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """Overlay (h, w, 3), uint8 sRGB: the picture in dim grey, and over it red to yellow where offsets disagree."""
    grey = 0.6 * linear_to_srgb(np.clip(rgb, 0, 1)).mean(axis=-1, keepdims=True)
    share = np.clip(disagreement[..., None] / FULL, 0, 1)
    colour = LOW_RGB + share * (HIGH_RGB - LOW_RGB)
    found: npt.NDArray[np.uint8] = (255 * (grey + np.sqrt(share) * (colour - grey)) + 0.5).astype(np.uint8)
    return found
