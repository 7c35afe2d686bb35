"""Gradients of the field. ``gradient(setup, p_index (n, 3)) -> (n, 3)`` in data units per world unit, in world space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..stage import make_stage
from ..volume import FloatArray
from .field import FIELDS, Values, field_scalar, linear, trilinear
from .filters import DERIVATIVES
from .setup import BoolArray, Setup

SOBEL = {(i, j): (2 - abs(i)) * (2 - abs(j)) for i in (-1, 0, 1) for j in (-1, 0, 1)}


@np.errstate(under="ignore")
def field_gradient(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Gradient of the layer's field."""
    return GRADIENTS[setup.stages["gradient"].name](setup, p_index)


def zero(setup: Setup, p_index: FloatArray) -> FloatArray:
    """No gradient."""
    return np.zeros_like(p_index)


def central(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Differences over one voxel to each side, one-sided at the faces of the domain."""
    slopes = np.stack([_slope(setup, p_index, axis)[0] for axis in range(3)], axis=1)
    return _world(setup, slopes)


def sobel(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Central differences, averaged across with the weights 1, 2, 1 each way."""
    low, high = setup.domain
    slopes = np.empty_like(p_index)
    for axis in range(3):
        total, weight = np.zeros(len(p_index)), np.zeros(len(p_index))
        for (i, j), w in SOBEL.items():
            # Step aside along the two other axes, not beyond the domain.
            p = p_index.copy()
            p[:, (axis + 1) % 3] += i
            p[:, (axis + 2) % 3] += j
            slope, known = _slope(setup, np.clip(p, low, high), axis)
            total += w * slope
            weight += w * known
        slopes[:, axis] = total / np.maximum(weight, 1)
    return _world(setup, slopes)


def analytic(setup: Setup, p_index: FloatArray) -> FloatArray:
    """The derivative of the reconstruction itself."""
    return _world(setup, DERIVATIVES[setup.stages["field"].name](setup, p_index))


def precomputed(setup: Setup, p_index: FloatArray) -> FloatArray:
    """Gradients at the voxels by the stage's ``method``, interpolated trilinearly whatever the field; bytes are rounded."""
    if "gradient" not in setup.once:
        stage = setup.stages["gradient"]
        setup.once["gradient"] = voxel_gradients(setup, stage.method)
        if stage.format == "snorm8":
            longest = 0.2 * float(setup.grid.max() - setup.grid.min()) / setup.spacing_world or 1.0
            setup.once["gradient"] = signed_bytes(setup.once["gradient"], longest)
    return trilinear(setup.once["gradient"], p_index)


def voxel_gradients(setup: Setup, method: str) -> FloatArray:
    """Gradients (z, y, x, 3) at all voxels by one of the functions of this page."""
    if setup.stages["field"].name == "linear_with_gradient":
        setup = replace(setup, stages={**setup.stages, "field": make_stage("field", "linear")})
    nz, ny, nx = setup.grid.shape[:3]
    z, y, x = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    voxels = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float64)
    parts = [GRADIENTS[method](setup, part) for part in np.array_split(voxels, 1 + len(voxels) // 65536)]
    return np.concatenate(parts).reshape(nz, ny, nx, 3)


def signed_bytes(vectors: FloatArray, longest: float) -> FloatArray:
    """Vectors (..., 3) cut to a length, their components rounded to 127 steps each way."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    cut = vectors / np.maximum(length, longest)
    return np.asarray(np.round(127 * cut) / 127 * longest)


def linear_with_gradient(setup: Setup, p_index: FloatArray) -> Values:
    """Linear interpolation of values that lie beside gradients; signed bytes are rounded."""
    if setup.stages["gradient"].format == "float16":
        return linear(setup, p_index)
    if "values" not in setup.once:
        low, high = float(setup.grid.min()), float(setup.grid.max())
        half = (high - low) / 2 or 1.0
        setup.once["values"] = (low + high) / 2 + half * np.round(127 * (setup.grid - (low + high) / 2) / half) / 127
    return trilinear(setup.once["values"], p_index), np.zeros(len(p_index), dtype=bool)


def _slope(setup: Setup, p_index: FloatArray, axis: int) -> tuple[FloatArray, BoolArray]:
    """Difference quotient along an index axis, and where it is known; 0 elsewhere.

    An empty end is replaced by the point itself; where the point is empty, or no two ends are left, nothing is known.
    """
    low, high = p_index.copy(), p_index.copy()
    low[:, axis] = np.maximum(p_index[:, axis] - 1, setup.domain[0][axis])
    high[:, axis] = np.minimum(p_index[:, axis] + 1, setup.domain[1][axis])
    (low_value, low_empty), (high_value, high_empty) = field_scalar(setup, low), field_scalar(setup, high)
    known = np.ones(len(p_index), dtype=bool)
    width = high[:, axis] - low[:, axis]
    if setup.full is not None:
        here, here_empty = field_scalar(setup, p_index)
        width = np.where(high_empty, p_index[:, axis], high[:, axis]) - np.where(low_empty, p_index[:, axis], low[:, axis])
        low_value, high_value = np.where(low_empty, here, low_value), np.where(high_empty, here, high_value)
        known = ~here_empty & (width > 0)
    return np.where(known, high_value - low_value, 0.0) / np.where(width > 0, width, 1.0), known


def _world(setup: Setup, slopes: FloatArray) -> FloatArray:
    """World gradient of slopes along the index axes: by the transposed inverse of ``world_from_index``."""
    return np.asarray(slopes @ setup.layer.volume.index_from_world[:3, :3])


GRADIENTS: dict[str, Callable[[Setup, FloatArray], FloatArray]] = {
    "zero": zero,
    "central": central,
    "sobel": sobel,
    "analytic": analytic,
    "precomputed": precomputed,
    "fetched": precomputed,
}
FIELDS["linear_with_gradient"] = linear_with_gradient
