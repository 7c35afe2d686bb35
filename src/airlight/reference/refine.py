"""Where a ray meets a surface of equal value between two samples: by halving, by straight lines, or the root of a cell's cubic.

``field(rows, t_world) -> values (n,)`` gives the field along some of the rays, NaN where it is empty, which counts as what lies
before the surface.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..volume import FloatArray
from .setup import IntArray, Setup

Along = Callable[[IntArray, FloatArray], FloatArray]

HALVINGS = 6  # Scharsach, section 4: a bracket 64 times narrower
LINES = 2
# A voxel apart are the bends of the field, and faces of cells; what is within one cell needs no halving.
NARROW_VOXELS = {"bisection": 0.0, "secant": 0.05, "exact": 1.0, "cells": np.inf}
MOST_HALVINGS = 20
NODES = np.array([0, 1 / 3, 2 / 3, 1])


def refined(
    setup: Setup,
    method: str,
    field: Along,
    line: tuple[FloatArray, FloatArray],
    ends: FloatArray,
    values: FloatArray,
    level: float,
) -> FloatArray:
    """Distances (n,) at which values pass ``level``, between samples at ``ends`` (n, 2) with ``values`` (n, 2) on either side.

    ``line``: origins and directions (n, 3) of the rays in index coordinates. ``bisection`` halves six times and draws a
    straight line through what is left; ``secant`` halves down to a twentieth of a voxel and lays two more lines; ``exact``
    halves to a voxel, and takes the root in the first cell there at whose end the value is beyond the level; ``cells`` is that
    within one cell.
    """
    ends, values = ends.copy(), values.copy()
    beyond, nothing = values[:, 1] >= level, values[:, 0].copy()

    def narrow(rows: IntArray, t_world: FloatArray) -> None:
        value = field(rows, t_world)
        value = np.where(np.isnan(value), nothing[rows], value)
        side = np.where((value >= level) == beyond[rows], 1, 0)
        ends[rows, side], values[rows, side] = t_world, value

    narrowest = NARROW_VOXELS[method] / np.linalg.norm(line[1], axis=1)
    for _ in range(HALVINGS if method == "bisection" else MOST_HALVINGS):
        wide = np.nonzero(ends[:, 1] - ends[:, 0] > narrowest)[0]
        narrow(wide, ends[wide].mean(axis=1))
    if method in ("exact", "cells"):
        for t_world in np.sort(_faces(*line, ends), axis=1).T:
            within = np.nonzero((t_world > ends[:, 0]) & (t_world < ends[:, 1]))[0]
            narrow(within, t_world[within])
        roots = crossings(field, line, ends, level, np.where(beyond, 1.0, -1.0))
        return np.where(np.isfinite(roots), roots, ends[:, 1])
    for _ in range(LINES * (method == "secant")):
        narrow(np.arange(len(ends)), straight(ends, values, level))
    return straight(ends, values, level)


def straight(ends: FloatArray, values: FloatArray, level: float) -> FloatArray:
    """Place at which the straight line between two samples passes the level."""
    rise = values[:, 1] - values[:, 0]
    share = (level - values[:, 0]) / np.where(rise == 0, 1.0, rise)
    return np.asarray(ends[:, 0] + np.clip(share, 0, 1) * (ends[:, 1] - ends[:, 0]))


def crossings(
    field: Along, line: tuple[FloatArray, FloatArray], ends: FloatArray, level: float, side: FloatArray | None = None
) -> FloatArray:
    """First distances (n,) between ``ends`` (n, 2) at which a trilinear field passes a level; inf where it does not.

    With ``side`` the first passage upwards (1) or downwards (-1). Between the faces of voxel cells the field is a cubic along a
    ray, whose roots are the eigenvalues of its companion matrix.
    """
    origin, direction = line
    found = np.full(len(ends), np.inf)
    cuts = np.sort(np.concatenate([ends, _faces(origin, direction, ends)], axis=1), axis=1)
    for a, b in zip(cuts.T[:-1], cuts.T[1:], strict=True):
        rows = np.nonzero((b > a) & np.isinf(found))[0]
        if not rows.size:
            continue
        way = (b - a)[rows]
        values = np.stack([field(rows, a[rows] + node * way) for node in NODES], axis=1) - level
        values = np.where(np.isnan(values), values[:, :1], values)
        values[np.isnan(values).any(axis=1)] = -1.0
        cubic = np.asarray(np.linalg.solve(np.vander(NODES, increasing=True), values.T).T, dtype=np.float64)
        roots = _roots_in_unit(cubic)
        if side is not None:
            slope = cubic[:, 1:2] + roots * (2 * cubic[:, 2:3] + 3 * roots * cubic[:, 3:4])
            roots = np.where(np.nan_to_num(slope) * side[rows, None] >= 0, roots, np.nan)
        first = np.where(np.isnan(roots), np.inf, roots).min(axis=1)
        found[rows] = a[rows] + first * way
    return found


def _faces(origin: FloatArray, direction: FloatArray, ends: FloatArray) -> FloatArray:
    """Distances (n, m) at which rays pass faces of voxel cells between two distances; the first distance fills up."""
    low, high = (origin + t[:, None] * direction for t in ends.T)
    first, last = np.ceil(np.minimum(low, high)), np.floor(np.maximum(low, high))
    count = int((last - first).max(initial=-1)) + 1
    face = first[:, :, None] + np.arange(count)
    pace = np.where(direction == 0, 1.0, direction)[:, :, None]
    t = np.where((face <= last[:, :, None]) & (direction != 0)[:, :, None], (face - origin[:, :, None]) / pace, -np.inf)
    return np.clip(t.reshape(len(ends), 3 * count), ends[:, :1], ends[:, 1:])


def _roots_in_unit(cubic: FloatArray) -> FloatArray:
    """Real roots in [0, 1] of cubics (n, 4), constant term first: (n, 3), NaN where there is none."""
    size = np.abs(cubic).max(axis=1, keepdims=True)
    c = cubic / np.where(size > 0, size, 1.0)
    # A vanishing leading term has its roots at infinity: a tiny one in its place moves those in [0, 1] by a rounding error.
    lead = np.where(np.abs(c[:, 3]) < 1e-13, 1e-13, c[:, 3])
    companion = np.zeros((len(c), 3, 3))
    companion[:, 1, 0] = companion[:, 2, 1] = 1.0
    companion[:, :, 2] = -c[:, :3] / lead[:, None]
    roots = np.linalg.eigvals(companion)
    real, tiny = roots.real, 1e-9
    # Rounding of eigenvalues is of the size of the greatest: two steps of Newton's method settle the ones that count.
    near = (np.abs(roots.imag) < 1e-6 * (1 + np.abs(real))) & (real > -0.1) & (real < 1.1)
    x = np.where(near, real, 0.5)
    for _ in range(2):
        value = c[:, :1] + x * (c[:, 1:2] + x * (c[:, 2:3] + x * c[:, 3:4]))
        slope = c[:, 1:2] + x * (2 * c[:, 2:3] + 3 * x * c[:, 3:4])
        x = x - np.where(slope == 0, 0.0, value / np.where(slope == 0, 1.0, slope))
    return np.where(near & (x >= -tiny) & (x <= 1 + tiny), np.clip(x, 0, 1), np.nan)
