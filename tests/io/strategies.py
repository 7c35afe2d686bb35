"""Hypothesis strategies: geometries and arrays of any kind that a volume may have."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

DTYPES = ["bool", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float16", "float32", "float64"]


def _rotation(angles: tuple[float, float, float]) -> np.ndarray:
    matrix = np.eye(3)
    for axis, angle in enumerate(angles):
        i, j = [n for n in range(3) if n != axis]
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = math.cos(angle)
        turn[i, j], turn[j, i] = -math.sin(angle), math.sin(angle)
        matrix = matrix @ turn
    return matrix


_angle = st.floats(-3.1, 3.1).map(lambda a: round(a, 4))
_spacing = st.floats(0.05, 20).map(lambda s: round(s, 4))
_place = st.floats(-500, 500).map(lambda p: round(p, 3))


@st.composite
def affines(draw: st.DrawFn, *, shear: bool) -> np.ndarray:
    """4x4 ``world_from_index``: rotated, flipped, its axes exchanged, sheared if asked for."""
    axes = _rotation(draw(st.tuples(_angle, _angle, _angle)) if draw(st.booleans()) else (0.0, 0.0, 0.0))
    axes = axes @ np.diag(draw(st.tuples(*[st.sampled_from([1.0, -1.0])] * 3)))
    axes = axes[:, draw(st.permutations(range(3)))]
    if shear:
        turn = np.eye(3)
        turn[0, 1], turn[1, 2] = draw(st.floats(-0.4, 0.4)), draw(st.floats(-0.4, 0.4))
        axes = axes @ turn
    matrix = np.eye(4)
    matrix[:3, :3] = axes * np.array(draw(st.tuples(_spacing, _spacing, _spacing)))
    matrix[:3, 3] = draw(st.tuples(_place, _place, _place))
    return matrix


@st.composite
def arrays(draw: st.DrawFn, least: int = 3, most: int = 5) -> np.ndarray:
    """Array of 3 to 5 axes, any dtype, small."""
    dtype = np.dtype(draw(st.sampled_from(DTYPES)))
    shape = tuple(draw(st.lists(st.integers(1, 5), min_size=least, max_size=most)))
    if len(shape) == 4 and shape[-1] in (3, 4):
        shape = (*shape[:-1], 2)  # would be taken for colours
    return draw(hnp.arrays(dtype, shape))
