"""The field on pre-filtered levels: which one a pixel asks for, what it holds, and the mix of two."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..volume import FloatArray
from .camera import pixel_width as camera_pixel_width
from .field import FIELDS, Values, trilinear
from .filters import DERIVATIVES, cell_slopes
from .setup import Setup


def pixel_width(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Width of a pixel at places (n, 3), in smallest voxel spacings; perspective: of one in the middle of the image."""
    matrix, camera = setup.layer.volume.world_from_index, setup.camera
    away = np.linalg.norm(p_index @ matrix[:3, :3].T + matrix[:3, 3] - np.array(camera.eye), axis=1)
    return np.asarray(camera_pixel_width(camera, setup.size_px, away) / setup.spacing_world)


def level_of(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Level (n,) at places (n, 3): the logarithm of a pixel's width."""
    coarsest = math.floor(math.log2(max(setup.layer.volume.size)))
    return np.asarray(np.clip(np.log2(pixel_width(setup, p_index)) + setup.stages["field"].bias, 0, coarsest))


def level_grid(setup: Setup, level: int) -> FloatArray:
    """Samples of a level: means over boxes that share the level before among half as many samples along each axis."""
    name = f"level {level}"
    if level == 0:
        return setup.grid
    if name not in setup.once:
        found = level_grid(setup, level - 1)
        for axis, n in enumerate(found.shape):
            m = max(1, n // 2)
            borders = np.arange(m + 1) * n / m
            samples = np.arange(n)
            # The share of box i that lies in sample k.
            share = np.clip(np.minimum(borders[1:, None], samples + 1) - np.maximum(borders[:-1, None], samples), 0, 1) * m / n
            found = np.moveaxis(np.tensordot(share, found, axes=(1, axis)), 0, axis)
        setup.once[name] = found
    return setup.once[name]


def by_level(setup: Setup, p_index: FloatArray, value: Callable[[FloatArray, FloatArray], FloatArray]) -> FloatArray:
    """Mix of ``value(samples, p)`` of the two levels round that of each place, with ``p`` in index coordinates of the level."""
    level = level_of(setup, p_index)
    low, size = np.floor(level).astype(np.int64), np.array(setup.layer.volume.size)
    parts = []
    for n in range(int(low.max(initial=0)) + 2):
        weight = np.clip(1 - np.abs(level - n), 0, 1)
        near = weight > 0
        samples = level_grid(setup, n) if near.any() else setup.grid
        ratio = np.array(samples.shape[::-1]) / size
        found = value(samples, (p_index[near] + 0.5) * ratio - 0.5)
        whole = np.zeros((len(p_index), *found.shape[1:]))
        whole[near] = (found.T * weight[near]).T * (ratio if found.ndim > 1 else 1.0)
        parts.append(whole)
    return np.asarray(np.sum(parts, axis=0))


def levels(setup: Setup, p_index: FloatArray) -> Values:
    """Trilinear interpolation on levels, and between them."""
    return by_level(setup, p_index, trilinear), np.zeros(len(p_index), dtype=bool)


def levels_derivative(setup: Setup, p_index: FloatArray) -> FloatArray:
    """The derivative at the level of each place, none beyond the outer samples of a level."""

    def value(samples: FloatArray, p: FloatArray) -> FloatArray:
        outside = (p < -1e-3) | (p > np.array(samples.shape[::-1]) - 1 + 1e-3)
        return np.asarray(np.where(outside, 0.0, cell_slopes(samples, p)))

    return by_level(setup, p_index, value)


FIELDS["levels"] = levels
DERIVATIVES["levels"] = levels_derivative
