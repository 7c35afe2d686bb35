"""Fields by filters that reach further than a cell, and the derivatives of fields: sums over voxels, weight by weight.

Beyond the faces of the grid voxels go on as the outer ones. A kernel is a function of distances (n,) in voxels; ``tap_weights``
makes the weights of the voxels round a place of it, whose sum is one.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from ..transfer.channels import Channels
from ..volume import FloatArray
from .field import FIELDS, Values, trilinear
from .setup import IntArray, Setup

Kernel = Callable[[FloatArray], FloatArray]
WIDTH = 1e-5  # of the differences that stand for the derivative of a kernel


def mitchell(b: float, c: float) -> Kernel:
    """Cubic kernels of Mitchell and Netravali, equation 8."""

    def kernel(distance: FloatArray) -> FloatArray:
        x = np.abs(distance)
        inner = (12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + (6 - 2 * b)
        outer = (-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + (8 * b + 24 * c)
        return np.asarray(np.where(x < 1, inner, np.where(x < 2, outer, 0.0)) / 6)

    return kernel


def sinc(window: str, radius: int) -> Kernel:
    """Sinc that a window fades out: ``lanczos``, or ``kaiser`` with beta 6."""

    def kernel(distance: FloatArray) -> FloatArray:
        x = np.clip(distance / radius, -1, 1)
        fade = np.sinc(x) if window == "lanczos" else np.i0(6 * np.sqrt(1 - x * x)) / np.i0(6.0)
        return np.asarray(np.where(np.abs(x) < 1, np.sinc(distance) * fade, 0.0))

    return kernel


def polyline(samples: tuple[float, ...], radius: int) -> Kernel:
    """Kernel that runs straight between samples from ``-radius`` to ``radius``."""
    spacing = 2 * radius / (len(samples) - 1)
    padded = np.concatenate([[0.0], samples, [0.0]])

    def kernel(distance: FloatArray) -> FloatArray:
        place = np.clip((distance + radius) / spacing, -1e-9, len(samples) - 1 + 1e-9)
        low = np.clip(np.floor(place).astype(np.int64), 0, len(samples) - 2)
        value = padded[low + 1] + (place - low) * (padded[low + 2] - padded[low + 1])
        return np.asarray(np.where(np.abs(distance) <= radius, value, 0.0))

    return kernel


def kernel_of(stage: Any) -> tuple[Kernel, int, float]:
    """Kernel of a separable filter, its radius, and the width of differences that stand for its derivative."""
    if stage.name in ("bspline", "bspline_exact"):
        return mitchell(1, 0), 2, WIDTH
    if stage.name == "catmull_rom":
        return mitchell(0, 0.5), 2, WIDTH
    if stage.name == "mitchell":
        return mitchell(stage.b, stage.c), 2, WIDTH
    if stage.name == "windowed_sinc":
        return sinc(stage.window, stage.radius), stage.radius, WIDTH
    return polyline(stage.samples, stage.radius), stage.radius, 2 * stage.radius / (len(stage.samples) - 1)


def tap_weights(kernel: Kernel, radius: int, width: float, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights (n, taps) along one axis at places (n,), and their derivatives; the first tap is ``floor(p) + 1 - radius``."""
    distance = (p - np.floor(p))[:, None] - np.arange(1 - radius, radius + 1)
    weight = kernel(distance)
    slope = (kernel(distance + width) - kernel(distance - width)) / (2 * width)
    total = weight.sum(axis=1)[:, None]
    return weight / total, (slope * total - weight * slope.sum(axis=1)[:, None]) / total**2


def taps_of(setup: Setup, p_index: FloatArray, radius: int) -> list[IntArray]:
    """Numbers (n, taps) of the voxels along x, y and z that have weight at places (n, 3)."""
    first = np.floor(p_index).astype(np.int64) + 1 - radius
    return [np.clip(first[:, a, None] + np.arange(2 * radius), 0, n - 1) for a, n in enumerate(setup.layer.volume.size)]


def samples_of(setup: Setup) -> FloatArray:
    """What is filtered: the samples, or the coefficients of the spline that goes through them."""
    if not getattr(setup.stages["field"], "prefilter", False):
        return setup.grid
    if "coefficients" not in setup.once:
        found = setup.grid
        for axis, n in enumerate(found.shape[:3]):
            # One equation a voxel; what lies beyond the faces equals the outer coefficients.
            matrix = np.zeros((n, n))
            for k, (step, weight) in product(range(n), ((-1, 1 / 6), (0, 4 / 6), (1, 1 / 6))):
                matrix[k, min(max(k + step, 0), n - 1)] += weight
            found = np.moveaxis(np.tensordot(np.linalg.inv(matrix), found, axes=(1, axis)), 0, axis)
        setup.once["coefficients"] = found
    return setup.once["coefficients"]


Total = Callable[[FloatArray], FloatArray]  # of samples (z, y, x) or (z, y, x, c): (n,) or (n, c) at the places asked for
Slopes = Callable[[FloatArray], FloatArray]  # its derivative along x, y and z: (n, 3) or (n, 3, c)


def known(setup: Setup, total: Total) -> Values:
    """Sum of weighted samples, of those that are there over their weight; empty where that is below half."""
    value = total(samples_of(setup))
    if setup.full is None:
        return value, np.zeros(len(value), dtype=bool)
    weight = total(setup.full)
    empty = weight < 0.5
    return np.where(empty, 0.0, value / np.where(empty, 1.0, weight)), empty


def known_derivative(setup: Setup, total: Total, slopes: Slopes) -> FloatArray:
    """Its derivative (n, 3), by the rule for quotients; none where it is empty. Of several channels that of their sum."""
    value, change = total(samples_of(setup)), slopes(samples_of(setup))
    if setup.full is not None:
        weight, shift = total(setup.full), slopes(setup.full)
        there = weight >= 0.5
        weight = np.where(there, weight, 1.0)
        value = value / weight
        change = (change - value[:, None] * shift) / weight[:, None] * there[:, None]
    return change if change.ndim == 2 else summed_slopes(setup, value, change)


def summed_slopes(setup: Setup, value: FloatArray, change: FloatArray) -> FloatArray:
    """Derivative (n, 3) of the number that gradients are taken of (``field_scalar``), from those (n, 3, c) of the channels."""
    if not isinstance(setup.function, Channels):
        return np.asarray(change[..., 0])
    total = np.zeros(change.shape[:2])
    for part, line in zip(setup.function.visible, setup.function.slopes, strict=True):
        place = setup.channels.index(setup.layer.volume.channel_index(part.channel))
        moves = (value[:, place] >= line.low) & (value[:, place] <= line.high)
        total += line.weight * change[..., place] * moves[:, None]
    return total


def _times(samples: FloatArray, weights: FloatArray) -> FloatArray:
    """Samples (n, ...) times weights (n,) or (n, taps)."""
    return np.asarray(samples * weights.reshape(*weights.shape, *[1] * (samples.ndim - weights.ndim)))


@np.errstate(under="ignore")
def separable(setup: Setup, p_index: FloatArray) -> Values:
    """Sum of the voxels round a place by the products of three weights."""
    return known(setup, lambda samples: separable_sum(setup, samples, p_index))


@np.errstate(under="ignore")
def separable_derivative(setup: Setup, p_index: FloatArray) -> FloatArray:
    """The same sums with the derivative of one weight each."""
    return known_derivative(
        setup,
        lambda samples: separable_sum(setup, samples, p_index),
        lambda samples: separable_slopes(setup, samples, p_index),
    )


def separable_sum(setup: Setup, samples: FloatArray, p_index: FloatArray) -> FloatArray:
    """Sum of samples round places."""
    kernel, radius, width = kernel_of(setup.stages["field"])
    (x, _), (y, _), (z, _) = (tap_weights(kernel, radius, width, p) for p in p_index.T)
    columns, rows, slices = taps_of(setup, p_index, radius)
    total = np.zeros((len(p_index), *samples.shape[3:]))
    for j, k in product(range(2 * radius), repeat=2):
        line = samples[slices[:, k, None], rows[:, j, None], columns]
        total += _times(_times(line, x).sum(axis=1), y[:, j] * z[:, k])
    return total


def separable_slopes(setup: Setup, samples: FloatArray, p_index: FloatArray) -> FloatArray:
    """Derivative of that sum."""
    kernel, radius, width = kernel_of(setup.stages["field"])
    (x, dx), (y, dy), (z, dz) = (tap_weights(kernel, radius, width, p) for p in p_index.T)
    columns, rows, slices = taps_of(setup, p_index, radius)
    total = np.zeros((len(p_index), 3, *samples.shape[3:]))
    for j, k in product(range(2 * radius), repeat=2):
        line = samples[slices[:, k, None], rows[:, j, None], columns]
        along = _times(line, x).sum(axis=1)
        total[:, 0] += _times(_times(line, dx).sum(axis=1), y[:, j] * z[:, k])
        total[:, 1] += _times(along, dy[:, j] * z[:, k])
        total[:, 2] += _times(along, y[:, j] * dz[:, k])
    return total


def body_sums(setup: Setup, samples: FloatArray, p_index: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sums over the voxels round a place of a kernel and its derivatives: with the samples (n, 4) or (n, 4, c), and without."""
    stage = setup.stages["field"]
    if "kernel" not in setup.once:
        side = round(len(stage.samples) ** (1 / 3))
        cube = np.reshape(np.array(stage.samples), (side, side, side))
        spacing = 2 * stage.radius / (side - 1)
        slopes = [np.gradient(cube, spacing, axis=axis) for axis in (2, 1, 0)]
        setup.once["kernel"] = np.stack([cube, *slopes], axis=-1)
    table = setup.once["kernel"]
    per_voxel = (len(table) - 1) / (2 * stage.radius)
    columns, rows, slices = taps_of(setup, p_index, stage.radius)
    valued, plain = np.zeros((len(p_index), 4, *samples.shape[3:])), np.zeros((len(p_index), 4))
    for taps in product(range(2 * stage.radius), repeat=3):
        distance = p_index - np.floor(p_index) - (np.array(taps) + 1 - stage.radius)
        weight = trilinear(table, (distance + stage.radius) * per_voxel)
        plain += weight
        valued += _times(samples[slices[:, taps[2]], rows[:, taps[1]], columns[:, taps[0]]][:, None], weight)
    return valued, plain


def body_mean(setup: Setup, samples: FloatArray, p_index: FloatArray) -> FloatArray:
    """Mean of samples round places, weighted by a kernel in three dimensions."""
    valued, plain = body_sums(setup, samples, p_index)
    return _times(valued[:, 0], 1 / plain[:, 0])


def body_slopes(setup: Setup, samples: FloatArray, p_index: FloatArray) -> FloatArray:
    """Derivative of that mean, by the rule for quotients."""
    valued, plain = body_sums(setup, samples, p_index)
    mean = _times(valued[:, :1], 1 / plain[:, :1])
    return _times(valued[:, 1:] - _times(np.repeat(mean, 3, axis=1), plain[:, 1:]), 1 / plain[:, :1])


def body(setup: Setup, p_index: FloatArray) -> Values:
    """Mean of the voxels round a place, weighted by a kernel in three dimensions."""
    return known(setup, lambda samples: body_mean(setup, samples, p_index))


def body_derivative(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Its derivative."""
    return known_derivative(
        setup, lambda samples: body_mean(setup, samples, p_index), lambda samples: body_slopes(setup, samples, p_index)
    )


@np.errstate(under="ignore")
def linear_derivative(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Differences across the cell of a place, at its share along the others; of the cell below on upper faces."""
    return known_derivative(setup, lambda samples: trilinear(samples, p_index), lambda samples: cell_slopes(samples, p_index))


def cell_slopes(grid: FloatArray, p_index: FloatArray) -> FloatArray:
    """Those differences of samples ``(z, y, x)`` or ``(z, y, x, c)`` at places (n, 3)."""
    result = np.zeros((*p_index.shape, *grid.shape[3:]))
    last = np.array(grid.shape[2::-1]) - 1.0
    inside = np.clip(p_index, 0, last)
    low = np.minimum(np.floor(inside), np.maximum(last - 1, 0))
    for axis in range(3):
        if last[axis] > 0:
            below, above = inside.copy(), inside.copy()
            below[:, axis], above[:, axis] = low[:, axis], low[:, axis] + 1
            result[:, axis] = trilinear(grid, above) - trilinear(grid, below)
    return result


LINEAR = (
    *("linear", "linear_exact", "linear_masked", "linear_channels", "linear_exact_channels", "linear_channels_masked"),
    "stack",
)
SEPARABLE = ("bspline", "bspline_exact", "catmull_rom", "mitchell", "windowed_sinc", "kernel")

# Derivative of a field in data units per voxel, ``(setup, p_index (n, 3)) -> (n, 3)``.
DERIVATIVES: dict[str, Callable[[Setup, FloatArray], FloatArray]] = {
    **dict.fromkeys(LINEAR, linear_derivative),
    **dict.fromkeys(SEPARABLE, separable_derivative),
    "kernel_body": body_derivative,
}
FIELDS.update(dict.fromkeys(SEPARABLE, separable), kernel_body=body)
