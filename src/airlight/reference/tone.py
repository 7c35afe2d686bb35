"""Tone: from the scene's radiance to what a display can show. ``tone(stage, rgba (..., 4)) -> (..., 4)``, premultiplied."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..volume import FloatArray

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear Rec. 709
GREY = 0.18
LEAST_AVERAGE = 1e-6  # luminance
STEPS = 24  # of luminance in which it is averaged round pixels


def linear(stage: Any, rgba: FloatArray) -> FloatArray:
    """Double the light with each stop of exposure."""
    return np.concatenate([rgba[..., :3] * 2.0**stage.exposure, rgba[..., 3:]], axis=-1)


def log_average(rgba: FloatArray) -> float:
    """Log-average luminance of what covers pixels, weighted by how much it covers them; 0 where nothing does."""
    alpha = rgba[..., 3]
    covered = alpha > 0
    if not covered.any():
        return 0.0
    of_cover = (rgba[..., :3] @ LUMINANCE)[covered] / alpha[covered]
    return float(np.exp((alpha[covered] * np.log(LEAST_AVERAGE + of_cover)).sum() / alpha.sum()))


def scale_of(stage: Any, rgba: FloatArray) -> float:
    """By what light is multiplied so that its average becomes ``key``; 0 where that is not known."""
    average = stage.adapted or log_average(rgba)
    return float(2.0**stage.exposure * stage.key / max(average, LEAST_AVERAGE)) if average else 0.0


def reinhard(stage: Any, rgba: FloatArray) -> FloatArray:
    """Map the log-average luminance of what is covered to ``key``, and ``white`` to 1 (Reinhard et al. 2002, eq. 1 to 4)."""
    return _compressed(stage, rgba, rgba[..., :3] @ LUMINANCE)


def reinhard_local(stage: Any, rgba: FloatArray) -> FloatArray:
    """Compress by the luminance round each pixel, instead of its own (Reinhard et al. 2002, eq. 9)."""
    return _compressed(stage, rgba, surround(rgba, stage.radius, stage.edge))


def _compressed(stage: Any, rgba: FloatArray, luminance: FloatArray) -> FloatArray:
    scale = scale_of(stage, rgba)
    if not scale:
        return rgba
    scaled = scale * luminance
    factor = scale * (1 + scaled / stage.white**2) / (1 + scaled)
    return np.concatenate([rgba[..., :3] * factor[..., None], rgba[..., 3:]], axis=-1)


def surround(rgba: FloatArray, radius: float, edge: float) -> FloatArray:
    """Luminance round each pixel of an image (h, w, 4): a bilateral filter of its logarithm, on a grid.

    Durand and Dorsey 2002; on a grid of cells and steps of luminance after Paris and Durand 2006, "A fast approximation of the
    bilateral filter using a signal processing approach". ``radius`` is the deviation in space, as a share of the longer side,
    ``edge`` that in luminance [stops]. Pixels count as much as they are covered.
    """
    height, width = rgba.shape[:2]
    # A cell's width, a binomial over three, and linear interpolation have variances of 1/12, 1/2 and, in the mean, 1/6.
    cell_px = max(1, round(radius * max(width, height) / np.sqrt(1 / 12 + 1 / 2 + 1 / 6)))
    step_stops = edge / np.sqrt(1 / 3 + 1 / 6)
    luminance = rgba[..., :3] @ LUMINANCE
    stops = np.log2(np.maximum(luminance, 1e-30) / max(log_average(rgba), 1e-30))
    # Spread each pixel over the four nearest steps of its cell.
    row, column = np.indices((height, width))
    places = np.clip(STEPS / 2 + stops / step_stops, 2, STEPS - 2) - 0.5
    first = np.floor(places).astype(int) - 1
    sums = np.zeros((-(-height // cell_px), -(-width // cell_px), STEPS, 2))
    for step in range(4):
        weight = rgba[..., 3] * _cubic_bspline(first + step - places) / cell_px**2
        terms = weight[..., None] * np.stack([stops, np.ones_like(stops)], axis=-1)
        np.add.at(sums, (row // cell_px, column // cell_px, first + step), terms)
    # Spread cells over their neighbours.
    for axis in (0, 1):
        padded = np.pad(sums, [(1, 1) if n == axis else (0, 0) for n in range(4)])
        low, middle, high = (padded.take(range(n, n + sums.shape[axis]), axis) for n in range(3))
        sums = (low + 2 * middle + high) / 4
    # Interpolate between cells and steps.
    found = np.zeros((height, width, 2))
    at = [(row + 0.5) / cell_px - 0.5, (column + 0.5) / cell_px - 0.5, places]
    for corner in np.ndindex(2, 2, 2):
        index = [np.floor(p).astype(int) + c for p, c in zip(at, corner, strict=True)]
        weight = np.prod([1 - np.abs(i - p) for i, p in zip(index, at, strict=True)], axis=0)
        inside = tuple(np.clip(i, 0, n - 1) for i, n in zip(index, sums.shape, strict=False))
        found += weight[..., None] * sums[inside]
    least = 1e-6  # of less the pixel's own luminance is taken
    mean = (found[..., 0] + least * stops) / (found[..., 1] + least)
    return np.asarray(2**mean * max(log_average(rgba), 1e-30))


def _cubic_bspline(t: FloatArray) -> FloatArray:
    """Weights at distances; they are of one at whole distances in sum."""
    t = np.abs(t)
    return np.where(t < 1, (4 - 6 * t**2 + 3 * t**3) / 6, np.where(t < 2, (2 - t) ** 3 / 6, 0.0))


def filmic(stage: Any, rgba: FloatArray) -> FloatArray:
    """Map each channel by ``peak x^c / (x^c + half)``, which leaves middle grey where it is and makes ``white`` 1."""
    scale = scale_of(stage, rgba)
    if not scale:
        return rgba
    grey, white = GREY**stage.contrast, stage.white**stage.contrast
    # From peak * grey / (grey + half) = GREY and peak * white / (white + half) = 1.
    half = (1 - GREY) * grey * white / (GREY * white - grey)
    light = np.maximum(scale * rgba[..., :3], 0) ** stage.contrast
    return np.concatenate([(1 + half / white) * light / (light + half), rgba[..., 3:]], axis=-1)


TONES: dict[str, Callable[[Any, FloatArray], FloatArray]] = {
    "linear": linear,
    "reinhard": reinhard,
    "reinhard_local": reinhard_local,
    "filmic": filmic,
}
