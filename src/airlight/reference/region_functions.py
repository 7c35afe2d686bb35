"""Transfer functions of regions: in a slab each has the share of its labels in the slab's middle, and their media add."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..transfer import TransferFunction
from ..volume import FloatArray
from .homogeneous import homogeneous, source_and_extinction
from .region import corners
from .setup import Sample, Sent, Setup

Medium = Callable[[FloatArray], FloatArray]
"""Source and extinction (n, 4) at values (n,)."""
Mean = Callable[[Medium, FloatArray, FloatArray], FloatArray]
"""Mean medium (n, 4) of slabs between two values (n,)."""


@np.errstate(under="ignore")
def postclassified_regions(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Mix the means of the media at a slab's two ends."""

    def mean(medium: Medium, one: FloatArray, other: FloatArray) -> FloatArray:
        return np.asarray((medium(one) + medium(other)) / 2)

    return _mixed(setup, front, back, length, mean)


@np.errstate(under="ignore")
def preintegrated_regions(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Mix the means of the media along the straight line between a slab's two values."""

    def mean(medium: Medium, one: FloatArray, other: FloatArray) -> FloatArray:
        points = np.unique(np.concatenate([f.values for f in setup.function.functions]))
        way = np.where(one == other, 1.0, other - one)
        cuts = np.sort(np.clip((points - one[:, None]) / way[:, None], 0.0, 1.0), axis=1)
        cuts = np.concatenate([np.zeros((len(one), 1)), cuts, np.ones((len(one), 1))], axis=1)
        total: FloatArray = np.zeros((len(one), 4))
        # Source is quadratic between two cuts: Gauss' rule of two nodes is exact.
        for begin, end in zip(cuts.T[:-1], cuts.T[1:], strict=True):
            for node in (0.5 - 0.75**0.5 / 3, 0.5 + 0.75**0.5 / 3):
                total += ((end - begin) / 2)[:, None] * medium(one + (begin + node * (end - begin)) * (other - one))
        return total

    return _mixed(setup, front, back, length, mean)


def _mixed(setup: Setup, front: Sample, back: Sample, length: FloatArray, mean: Mean) -> Sent:
    labels = setup.layer.labels
    assert labels is not None
    # Sum the shares of the functions in the middle: those of the eight labels round it, tinted and thinned.
    shares = np.zeros((len(setup.function.functions), len(length), 4))
    for share, ids in corners(setup, (front.p_index + back.p_index) / 2):
        for label in np.unique(ids).tolist():
            own = labels.style_of(label).transfer
            number = 0 if own is None else 1 + labels.functions.index(own)
            factor = np.array([*labels.tint_of(label), 1.0]) * labels.opacity_of(label)
            shares[number] += np.where(ids == label, share, 0.0)[:, None] * factor
    # Mix the functions' means over the slab by their shares.
    medium = np.zeros((len(length), 4))
    for function, part in zip(setup.function.functions, shares, strict=True):
        medium += part * mean(_medium(function), front.value, back.value)
    return homogeneous(medium[:, :3], medium[:, 3], length)


def _medium(function: TransferFunction) -> Medium:
    return lambda value: np.column_stack(source_and_extinction(function, value))
