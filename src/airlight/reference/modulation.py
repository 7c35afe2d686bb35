"""Modulations: ``modulation(setup, front, back, length (n,)) -> weight (n,)`` of a slab's extinction."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import FloatArray
from .gradient import field_gradient
from .setup import Sample, Setup


def weight(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> FloatArray:
    """Factor of the extinction of slabs between two samples."""
    return MODULATIONS[setup.stages["modulation"].name](setup, front, back, length)


def none(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> FloatArray:
    """Leave extinction as it is."""
    return np.ones(len(length))


def change(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> FloatArray:
    """Rise with the change of the value per world unit along the ray; it is the first channel's where there are several."""
    rise = np.abs(back.value - front.value).reshape(len(length), -1)[:, 0]
    return np.asarray(np.clip(rise / np.maximum(length * full_at(setup), 1e-300), 0.0, 1.0))


def gradient_magnitude(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> FloatArray:
    """Rise with the magnitude of the gradient in the middle of the slab."""
    steepness = np.linalg.norm(field_gradient(setup, (front.p_index + back.p_index) / 2), axis=1)
    return np.asarray(np.clip(steepness / full_at(setup), 0.0, 1.0))


def full_at(setup: Setup) -> float:
    """Change [data/world] that counts in full: the stage's, or a tenth of the range of the data a voxel."""
    told = setup.stages["modulation"].full_at
    if told is not None:
        return float(told)
    samples = setup.grid if setup.full is None else setup.grid[setup.full > 0]
    rise = float(samples.max() - samples.min()) if samples.size else 0.0
    return rise / 10 / setup.spacing_world or 1.0


MODULATIONS: dict[str, Callable[[Setup, Sample, Sample, FloatArray], FloatArray]] = {
    "none": none,
    "change": change,
    "gradient_magnitude": gradient_magnitude,
}
