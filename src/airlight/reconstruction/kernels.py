"""Weights of separable filters, by the place within a cell: NumPy, float64.

A filter of radius r gives weight to the ``2 r`` voxels round a place, from ``r - 1`` below the lower voxel of its cell to ``r``
above it: tap ``i`` lies at ``i + 1 - r`` when the cell begins at 0. Weights sum to one at every place.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..volume import FloatArray

Function = Callable[[FloatArray], npt.ArrayLike]
KAISER_BETA = 6.0


def cubic_basis(b: float, c: float) -> FloatArray:
    """Weights of the cubic filters of Mitchell and Netravali (SIGGRAPH 1988, equation 8) as polynomials.

    Returns (4, 4): a row for each tap, in it the factors of the powers 0 to 3 of the share of the way through the cell.
    """
    rows = [
        (b, -3 * b - 6 * c, 3 * b + 12 * c, -b - 6 * c),
        (6 - 2 * b, 0, -18 + 12 * b + 6 * c, 12 - 9 * b - 6 * c),
        (b, 3 * b + 6 * c, 18 - 15 * b - 12 * c, -12 + 9 * b + 6 * c),
        (0, 0, -6 * c, b + 6 * c),
    ]
    return np.array(rows, dtype=np.float64) / 6


def cubic_weights(b: float, c: float, share: FloatArray) -> FloatArray:
    """Weights (n, 4) at shares (n,) of the way through a cell."""
    return np.asarray(share[:, None] ** np.arange(4) @ cubic_basis(b, c).T)


def windowed_sinc(window: str, radius: int) -> Function:
    """Sinc times a window that ends at ``radius``: ``lanczos``, the sinc's own main lobe, or ``kaiser``, beta 6."""

    def kernel(x: FloatArray) -> FloatArray:
        unit = np.clip(np.abs(x) / radius, 0.0, 1.0)
        fade = np.sinc(unit) if window == "lanczos" else np.i0(KAISER_BETA * np.sqrt(1 - unit**2)) / np.i0(KAISER_BETA)
        return np.asarray(np.where(unit < 1, np.sinc(x) * fade, 0.0))

    return kernel


def tabulated(weights: tuple[float, ...], radius: int) -> Function:
    """Kernel that runs straight between samples at equal distances from ``-radius`` to ``radius``, and is zero beyond."""
    places = np.linspace(-radius, radius, len(weights))
    return lambda x: np.interp(x, places, np.asarray(weights), left=0.0, right=0.0)


def slope(kernel: Function, x: FloatArray, width: float) -> FloatArray:
    """Difference of a kernel over ``width`` to each side."""
    ahead, behind = np.asarray(kernel(x + width)), np.asarray(kernel(x - width))
    return np.asarray((ahead - behind) / (2 * width))


def tap_weights(kernel: Function, radius: int, share: FloatArray, width: float) -> tuple[FloatArray, FloatArray]:
    """Weights and their derivatives by the place, both (n, 2 radius), at shares (n,) of the way through a cell.

    ``width`` is that of the differences which stand for the kernel's derivative.
    """
    distance = share[:, None] - (np.arange(2 * radius) + 1 - radius)
    weight, change = np.asarray(kernel(distance), dtype=np.float64), slope(kernel, distance, width)
    total, total_change = weight.sum(axis=1, keepdims=True), change.sum(axis=1, keepdims=True)
    return weight / total, (change - weight * total_change / total) / total


def least_sum(kernel: Function, radius: int) -> float:
    """Least magnitude of the sum of a kernel's weights over the places within a cell: zero where it cannot be made one."""
    distance = np.linspace(0, 1, 257)[:, None] - (np.arange(2 * radius) + 1 - radius)
    return float(np.abs(np.asarray(kernel(distance), dtype=np.float64).sum(axis=1)).min())


def greatest_gain(weights: FloatArray) -> float:
    """Greatest sum of magnitudes of the weights (n, taps) at one place."""
    return float(np.abs(weights).sum(axis=1).max())


def overshoot_of(gain: float) -> float:
    """By how much of the samples' range a field may leave it, whose weights along each axis have this sum of magnitudes."""
    return (gain**3 - 1) / 2


def response(weights: FloatArray, frequency: FloatArray) -> FloatArray:
    """Magnitude of a filter's Fourier transform at frequencies (m,) in cycles a voxel; 0.5 is that of the grid.

    ``weights`` (n, taps) are those at the middles of n equal parts of a cell.
    """
    n, taps = weights.shape
    share = (np.arange(n) + 0.5) / n
    distance = share[:, None] - (np.arange(taps) + 1 - taps // 2)
    wave = np.cos(2 * np.pi * frequency[:, None, None] * distance)
    return np.asarray(np.abs((wave * weights).sum(axis=(1, 2)) / n))
