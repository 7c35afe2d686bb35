"""Values at points of the world."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import airlight as al
from airlight.errors import DataError, ValueRangeError

MATRIX = np.array([[0, 2, 0.5, 10], [-1, 0, 0, 20], [0, 0, 3, -5], [0, 0, 0, 1.0]])
Z, Y, X = np.indices((4, 5, 6))
PLANES = al.Volume(np.stack([2.0 * X - 3 * Y + 5 * Z, 100.0 - X]), world_from_index=MATRIX, channel_names=("up", "down"))


def world(p_index):
    return np.asarray(p_index) @ MATRIX[:3, :3].T + MATRIX[:3, 3]


@given(st.tuples(st.floats(0, 5), st.floats(0, 4), st.floats(0, 3)))
def test_linear_data_is_met_exactly(p):
    x, y, z = p
    assert PLANES.value_at(world(p)) == pytest.approx(2 * x - 3 * y + 5 * z, abs=1e-9)
    assert PLANES.value_at(tuple(world(p)), channel="down") == pytest.approx(100 - x, abs=1e-9)


@given(st.tuples(st.floats(-0.49, 5.49), st.floats(-0.49, 4.49), st.floats(-0.49, 3.49)))
def test_nearest_is_the_voxel_out_to_its_faces(p):
    x, y, z = (round(c) for c in p)
    if all(abs(c % 1 - 0.5) > 1e-6 for c in p):
        assert PLANES.value_at(world(p), field="nearest") == 2 * x - 3 * y + 5 * z


def test_points_in_arrays_and_outside():
    points = world([[[0, 0, 0], [5, 4, 3]], [[-0.01, 0, 0], [np.nan, 0, 0]]])
    assert PLANES.value_at(points) == pytest.approx(np.array([[0, 13], [np.nan, np.nan]]), nan_ok=True)
    assert np.isnan(PLANES.value_at(world([5.51, 0, 0]), field="nearest"))
    assert isinstance(PLANES.value_at((0, 0, 0)), float)
    assert PLANES.value_at(world([5.00005, 0, 0])) == 10  # what rounding of a depth may take off
    flat = al.Volume(np.arange(12, dtype=np.uint8).reshape(1, 3, 4))
    assert flat.value_at((1.5, 1, 0.4)) == 5.5  # axes of one voxel reach to its faces
    assert np.isnan(flat.value_at((1.5, 1, 0.6)))


def test_what_is_empty_counts_as_in_pictures():
    array = np.array([[[1.0, np.nan, -9.0, 4.0]]])
    volume = al.Volume(np.concatenate([array, array]), no_data=-9)
    assert [volume.value_at((x, 0, 0)) for x in (0, 0.25, 0.5, 2.6)] == [1, 1, 1, 4]
    assert np.isnan([volume.value_at((x, 0, 0)) for x in (0.75, 1, 1.5, 2, 2.4)]).all()
    big = al.Volume(np.full((2, 2, 2), 2**63 + 2**40, dtype=np.uint64), no_data=7)
    assert big.value_at((0.5, 0.5, 0.5)) == 2**63 + 2**40


def test_mistakes_are_told():
    with pytest.raises(ValueRangeError, match="field is 'cubic', must be one of linear, nearest"):
        PLANES.value_at((0, 0, 0), field="cubic")
    for given_point in (None, 3.0, (1, 2), "abc"):
        with pytest.raises(ValueRangeError, match=r"p_world is .* must be \(x, y, z\)"):
            PLANES.value_at(given_point)
    with pytest.raises(DataError, match="channel"):
        PLANES.value_at((0, 0, 0), channel=2)
