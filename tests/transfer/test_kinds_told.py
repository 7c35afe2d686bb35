"""One kind of function in the place of another is told by name."""

from __future__ import annotations

import numpy as np
import pytest

import airlight as al
from airlight.errors import DataError, ValueRangeError
from airlight.scene_file import load_transfer

POINTS = [(0, "black", 0), (1, "red", 1)]
TF = al.TransferFunction(POINTS)
KINDS = {
    "TransferFunction": TF,
    "JointFunction": al.JointFunction([al.joint.Axis("value", 0, 1), al.joint.Axis(1, 0, 1)]),
    "Channels": al.Channels([al.Channel(0, TF)]),
}


@pytest.mark.parametrize("written", KINDS)
@pytest.mark.parametrize("reader", KINDS)
def test_load_names_the_class_that_reads_a_file(written, reader, tmp_path):
    path = tmp_path / "function.toml"
    KINDS[written].save(path)
    assert load_transfer(path) == KINDS[written]
    load = getattr(al, reader).load
    if reader == written:
        assert load(path) == KINDS[written]
        return
    with pytest.raises(ValueRangeError) as caught:
        load(path)
    assert str(caught.value) == f"{path} holds a {written}: read it with airlight.{written}.load"


def test_points_are_to_be_wrapped():
    with pytest.raises(DataError, match=r"layer.transfer is a list of points: wrap them: airlight.TransferFunction\(points\)"):
        al.Scene(np.zeros((2, 2, 2)), transfer=POINTS)


def test_axes_that_the_volume_does_not_have_are_told():
    volume = al.Volume(np.zeros((4, 4, 4)))
    with pytest.raises(DataError, match=r"transfer.axes\[1\] is channel 1; the volume has one channel, 0: use value"):
        al.Layer(volume, KINDS["JointFunction"]).channels  # noqa: B018
