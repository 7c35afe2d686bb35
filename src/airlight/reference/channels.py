"""Several channels in one place: samples (n, c), of which those that are not there are NaN, and slabs between them.

Extinctions add, and so do sources: colours are weighted by extinction.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..transfer.function import TransferFunction
from ..volume import FloatArray
from .homogeneous import homogeneous, source_and_extinction
from .setup import BoolArray, Sample, Sent, Setup
from .transfer import TRANSFERS, pieces


def parts(setup: Setup) -> Iterator[tuple[int, TransferFunction]]:
    """Place of each visible channel in a value, and its function."""
    volume = setup.layer.volume
    for part, function in zip(setup.function.visible, setup.function.functions, strict=True):
        yield setup.channels.index(volume.channel_index(part.channel)), function


def media(setup: Setup, sample: Sample) -> tuple[FloatArray, FloatArray]:
    """Source (n, 3) and extinction (n,) [1/world] of all channels at samples."""
    source, extinction = np.zeros((len(sample.value), 3)), np.zeros(len(sample.value))
    for place, function in parts(setup):
        value, there = known(sample.value[:, place])
        sent, dims = source_and_extinction(function, value)
        source += sent * there[:, None]
        extinction += dims * there
    return source, extinction


@np.errstate(under="ignore")
def postclassified(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Classify a slab as a homogeneous medium, the mean of the media at its two ends."""
    (source_front, tau_front), (source_back, tau_back) = media(setup, front), media(setup, back)
    return homogeneous((source_front + source_back) / 2, (tau_front + tau_back) / 2, length)


@np.errstate(under="ignore")
def preintegrated(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Integrate each function along the straight line between its channel's two values, and attenuate the sum as one medium.

    Where one end of a channel is not there, half of the slab is, with the value of the other end.
    """
    source, extinction = np.zeros((len(length), 3)), np.zeros(len(length))
    for place, function in parts(setup):
        (a, a_there), (b, b_there) = known(front.value[:, place]), known(back.value[:, place])
        a, b = np.where(a_there, a, b), np.where(b_there, b, a)
        there = (a_there.astype(np.float64) + b_there) / 2
        for rows, begin, end in pieces(function.values, a, b):
            # Source is a quadratic on a piece and extinction linear: Gauss' rule with two nodes is exact.
            for node in (0.5 - 0.75**0.5 / 3, 0.5 + 0.75**0.5 / 3):
                value = a[rows] + (begin + (end - begin) * node) * (b - a)[rows]
                share = (end - begin) / 2 * there[rows]
                sent, dims = source_and_extinction(function, value)
                source[rows] += share[:, None] * sent
                extinction[rows] += share * dims
    return homogeneous(source, extinction, length)


def known(value: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Values with those that are not there replaced by 0, and which are there."""
    there = ~np.isnan(value)
    return np.where(there, value, 0.0), there


TRANSFERS["postclassified_channels"] = postclassified
TRANSFERS["preintegrated_channels"] = preintegrated
