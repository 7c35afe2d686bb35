"""Volumes: what is taken, what is refused with the remedy, and what is empty."""

from __future__ import annotations

import numpy as np
import pytest

import airlight as al
from airlight.volume import is_empty


def test_geometry():
    volume = al.Volume(np.zeros((3, 4, 5)), spacing=np.array([0.5, 1.0, 2.0]), origin=np.array([1, 2, 3]))
    assert volume.size == (5, 4, 3)
    assert volume.spacing == (0.5, 1.0, 2.0)
    assert volume.origin == (1.0, 2.0, 3.0)
    assert volume.corners_world().max(axis=0).tolist() == [3, 5, 7]
    assert volume.corners_world(cells=True).min(axis=0).tolist() == [0.75, 1.5, 2]
    assert not volume.array.flags.writeable


def test_axes_of_one_voxel_are_one_voxel_thick():
    assert al.Volume(np.zeros((1, 4, 5))).corners_world()[:, 2].tolist() == [-0.5] * 4 + [0.5] * 4


@pytest.mark.parametrize(
    ("array", "options", "message"),
    [
        (np.zeros((4, 4, 4), complex), {}, "pass abs"),
        (np.zeros((8, 8, 8, 3), np.uint8), {}, "np.moveaxis"),
        (np.zeros((8, 8, 8, 4), np.float32), {}, "np.moveaxis"),
        (np.zeros((4, 4)), {}, "has 2 dimensions"),
        (np.zeros((0, 4, 4)), {}, "no samples"),
        (np.zeros((4, 4, 4)), {"spacing": (1, 0, 1)}, "must be positive"),
        (np.zeros((4, 4, 4)), {"world_from_index": np.zeros((4, 4))}, "last row"),
        (np.zeros((4, 4, 4)), {"world_from_index": np.diag([1, 1, 0, 1])}, "singular"),
        (np.zeros((4, 4, 4)), {"spacing": (1, 1, 1), "world_from_index": np.eye(4)}, "both"),
        (np.zeros((2, 4, 4, 4)), {"channel_names": ["a"]}, "has 1 entries, the array has 2"),
        (np.array([["a"]]), {}, "dtype"),
    ],
)
def test_refusals_tell_the_remedy(array, options, message):
    with pytest.raises(al.DataError, match=message):
        al.Volume(array, **options)


def test_no_data_marks_what_the_type_can_hold():
    whole = np.array([[[55537, 241, 0]]], dtype=np.uint16)
    assert is_empty(whole, -9999) is None
    assert is_empty(whole, 0.5) is None
    assert is_empty(whole, 241).tolist() == [[[False, True, False]]]
    assert is_empty(np.array([[[np.nan, 1, -9999]]], np.float32), -9999).tolist() == [[[True, False, True]]]


def test_statistics_keep_bins_apart_and_take_large_integers():
    volume = al.Volume(np.arange(64, dtype=np.int64).reshape(4, 4, 4) + 2**60 + 200)
    assert al.statistics(volume).minimum == pytest.approx(2.0**60)
    plain = al.Volume(np.random.default_rng(0).random((8, 8, 8)))
    assert len(al.statistics(plain).histogram) == 1024
    assert len(al.statistics(plain, bins=16).histogram) == 16


def test_equal_when_contents_are():
    a, b = (al.Volume(np.arange(8).reshape(2, 2, 2), spacing=(1, 2, 3)) for _ in range(2))
    assert a == b
    assert hash(a) == hash(b)
    assert a != al.Volume(np.arange(8).reshape(2, 2, 2), spacing=(1, 2, 4))
