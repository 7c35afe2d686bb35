"""Regions of labels: ``part_at(setup, p_index (n, 3)) -> (tint (n, 3), opacity (n,))``, factors of colour and extinction."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import AnyArray, FloatArray
from .setup import BoolArray, Setup

Part = tuple[FloatArray, FloatArray]


def part_at(setup: Setup, p_index: FloatArray) -> Part:
    """What is drawn of the layer at points, and in which tint."""
    return REGIONS[setup.stages["region"].name](setup, p_index)


def whole(setup: Setup, p_index: FloatArray) -> Part:
    """All of it, as it is."""
    return np.ones((len(p_index), 3)), np.ones(len(p_index))


@np.errstate(under="ignore")
def labelled(setup: Setup, p_index: FloatArray) -> Part:
    """Mix the styles of the eight labels round a point by their trilinear weights, tints by weight times opacity.

    Where regions have transfer functions of their own these do it by themselves, see ``region_functions.py``.
    """
    labels = setup.layer.labels
    assert labels is not None
    if labels.functions:
        return whole(setup, p_index)
    tint, opacity = np.zeros((len(p_index), 3)), np.zeros(len(p_index))
    for share, ids in corners(setup, p_index):
        known, which = np.unique(ids, return_inverse=True)
        shown = np.array([labels.opacity_of(int(label)) for label in known])[which] * share
        tints = np.array([labels.tint_of(int(label)) for label in known])[which]
        opacity += shown
        tint += shown[:, None] * tints
    seen = opacity > 0
    tint = np.where(seen[:, None], tint / np.where(seen, opacity, 1.0)[:, None], 0.0)
    if setup.stages["field"].name == "occupancy":
        # The field itself says what regions take: of what is there this is the mean.
        opacity = np.where(seen, opacity / np.where(seen, occupancy(setup, p_index)[0], 1.0), 0.0)
    return tint, opacity


@np.errstate(under="ignore")
def occupancy(setup: Setup, p_index: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Share of a place that regions take which are drawn: the field of labels without an image, nowhere empty."""
    return _weighted(setup, p_index, lambda opacity: float(opacity > 0)), np.zeros(len(p_index), dtype=bool)


@np.errstate(under="ignore")
def mixed_opacity(setup: Setup, p_index: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Opacity of a place: what gradients are taken of."""
    return _weighted(setup, p_index, float), np.zeros(len(p_index), dtype=bool)


def _weighted(setup: Setup, p_index: FloatArray, of_opacity: Callable[[float], float]) -> FloatArray:
    labels = setup.layer.labels
    assert labels is not None
    total = np.zeros(len(p_index))
    for share, ids in corners(setup, p_index):
        known, which = np.unique(ids, return_inverse=True)
        total += share * np.array([of_opacity(labels.opacity_of(int(label))) for label in known])[which]
    return total


def corners(setup: Setup, p_index: FloatArray) -> list[tuple[FloatArray, AnyArray]]:
    """Trilinear weight (n,) and label (n,) of each of the eight voxels round points; outside of the grid lies background."""
    labels = setup.layer.labels
    assert labels is not None
    grid = labels.volume.grid(0, labels.time_of(setup.layer.time))
    p_world = p_index @ setup.layer.volume.world_from_index[:3, :3].T + setup.layer.volume.world_from_index[:3, 3]
    p = p_world @ labels.volume.index_from_world[:3, :3].T + labels.volume.index_from_world[:3, 3]
    low = np.floor(p)
    found = []
    for offset in np.ndindex(2, 2, 2):
        share = np.prod(np.where(offset, p - low, 1 - (p - low)), axis=1)
        voxel = (low + offset).astype(np.int64)
        inside = np.asarray(((voxel >= 0) & (voxel < labels.volume.size)).all(axis=1))
        x, y, z = np.where(inside[:, None], voxel, 0).T
        found.append((share, np.where(inside, grid[z, y, x], grid.dtype.type(labels.background))))
    return found


REGIONS: dict[str, Callable[[Setup, FloatArray], Part]] = {"whole": whole, "labelled": labelled}
