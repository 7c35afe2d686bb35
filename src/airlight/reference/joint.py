"""Functions of two and three variables: variables at samples, and slabs between them.

Source and extinction are the function's own, not those of a table; the variables run straight between the ends of a slab.
"""

from __future__ import annotations

import numpy as np

from ..volume import FloatArray
from .field import field_scalar
from .gradient import field_gradient
from .homogeneous import homogeneous, source_and_extinction
from .setup import BoolArray, Sample, Sent, Setup

PIECES = 32


@np.errstate(under="ignore")
def joint(setup: Setup, front: Sample, back: Sample, length: FloatArray) -> Sent:
    """Classify a slab: the mean of its ends where the stage takes no samples, else the composite of many pieces."""
    a, b = variables(setup, front), variables(setup, back)
    if setup.stages["transfer"].samples == 0:
        source, extinction = source_and_extinction(setup.function, np.stack([a, b]))
        return homogeneous(source.mean(axis=0), extinction.mean(axis=0), length)
    n = len(length)
    rgb, back_rgb, back_alpha, depth = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    for piece in range(PIECES):
        here = a + (b - a) * ((piece + 0.5) / PIECES)
        source, extinction = source_and_extinction(setup.function, here)
        light = homogeneous(source, extinction, length / PIECES)
        through = np.exp(-depth)
        rgb += through[:, None] * light.rgb
        back_rgb += through[:, None] * (piece * light.rgb + light.back_rgb) / PIECES
        back_alpha += through * (piece * light.alpha + light.back_alpha) / PIECES
        depth += extinction * length / PIECES
    return Sent(rgb, -np.expm1(-depth), back_rgb, back_alpha)


def variables(setup: Setup, sample: Sample) -> FloatArray:
    """Variables (n, k) of the function at samples."""
    layer, found = setup.layer, []
    by_channel = dict(zip(layer.channels, np.atleast_2d(sample.value.T), strict=True))
    for name in setup.function.variables:
        if name == "gradient":
            found.append(np.linalg.norm(field_gradient(setup, sample.p_index), axis=1))
        elif name == "second":
            found.append(second_along(setup, sample.p_index, field_gradient(setup, sample.p_index)))
        else:
            found.append(by_channel[layer.volume.channel_index(layer.channel if name == "value" else name)])
    return np.stack(found, axis=1)


def second_along(setup: Setup, p_index: FloatArray, gradient: FloatArray) -> FloatArray:
    """Second derivative along the gradient (n,), by differences over one voxel; straight on beyond faces and empty samples."""
    steepness = np.linalg.norm(gradient, axis=1)
    direction = gradient / np.where(steepness > 0, steepness, 1.0)[:, None]
    way = direction @ setup.layer.volume.index_from_world[:3, :3].T
    total = np.zeros(len(p_index))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        total += way[:, i] ** 2 * _bend(setup, p_index, i) + 2 * way[:, i] * way[:, j] * _twist(setup, p_index, i, j)
    return total


def _bend(setup: Setup, p_index: FloatArray, axis: int) -> FloatArray:
    """Second difference along an axis; towards a face it fades from that of one voxel inside to nothing."""
    low, high = (end[axis] for end in setup.domain)
    if high - low < 2:
        return np.zeros(len(p_index))
    to_face = np.minimum(p_index[:, axis] - low, high - p_index[:, axis])
    values, gone = [], np.zeros(len(p_index), dtype=bool)
    for step in (-1, 0, 1):
        p = p_index.copy()
        p[:, axis] = np.clip(p[:, axis], low + 1, high - 1) + step
        value, empty = field_scalar(setup, p)
        values.append(value)
        gone |= empty
    return np.asarray(np.where(gone, 0.0, values[0] - 2 * values[1] + values[2]) * np.clip(to_face, 0.0, 1.0))


def _twist(setup: Setup, p_index: FloatArray, i: int, j: int) -> FloatArray:
    """Mixed second difference along two axes, over what of one voxel to each side lies within the domain."""
    low, high = p_index.copy(), p_index.copy()
    for k in (i, j):
        low[:, k] = np.maximum(low[:, k] - 1, setup.domain[0][k])
        high[:, k] = np.minimum(high[:, k] + 1, setup.domain[1][k])
    corners = []
    empty: BoolArray = np.zeros(len(p_index), dtype=bool)
    for at_i in (low, high):
        for at_j in (low, high):
            p = p_index.copy()
            p[:, i], p[:, j] = at_i[:, i], at_j[:, j]
            value, gone = field_scalar(setup, p)
            corners.append(value)
            empty |= gone
    area = (high[:, i] - low[:, i]) * (high[:, j] - low[:, j])
    return np.where(empty, 0.0, corners[0] - corners[1] - corners[2] + corners[3]) / area
