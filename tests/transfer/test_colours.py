"""Colours that are plainly 8-bit numbers are refused where linear light is meant."""

from __future__ import annotations

import numpy as np
import pytest

import airlight as al
from airlight.errors import ValueRangeError
from airlight.joint import Axis, Box, Ramp
from airlight.transfer.colour import MOST_COLOUR

AXES = Axis("value", 0, 10), Axis("gradient", 0, 10)
ORANGE = (255, 100, 0)


@pytest.mark.parametrize(
    ("make", "where"),
    [
        (lambda: al.TransferFunction([(0, "black", 0), (1, ORANGE, 1)]), "transfer.points[1].colour"),
        (lambda: al.TransferFunction.gaussian(0, 1, ORANGE), "colour"),
        (lambda: al.TransferFunction([(0, "red", 0)], surfaces=[al.Surface(1, ORANGE)]), "transfer.surface.colour"),
        (lambda: al.Surface(1, "red", back_colour=ORANGE), "transfer.surface.back_colour"),
        (lambda: al.JointFunction(AXES, [Box((0, 0), (1, 1), colour=ORANGE)]), "transfer.shapes[0] (box).colour"),
        (
            lambda: al.JointFunction(AXES, [Box((0, 0), (1, 1), ramp=Ramp(0, ((0, "red"), (1, ORANGE))))]),
            "transfer.shapes[0] (box).ramp.points[1].colour",
        ),
        (lambda: al.LabelStyle(ORANGE), "label.colour"),
        (lambda: al.Scene(np.zeros((2, 2, 2)), background=ORANGE), "scene.background"),
    ],
)
def test_eight_bits_are_no_linear_light(make, where):
    with pytest.raises(ValueRangeError) as caught:
        make()
    told = str(caught.value)
    assert where in told
    assert 'is (255, 100, 0), must be linear light of at most 16: write "#ff6400", which is sRGB, or divide by 255' in told


def test_what_glows_stays():
    assert al.TransferFunction([(0, (MOST_COLOUR, 2.5, 0), 1)]).colours.max() == 16
    assert (al.TransferFunction([(0, (16, 0, 0), 1)]) + al.TransferFunction([(1, (16, 3, 0), 0.3)])).colours.max() <= 16.001
    with pytest.raises(ValueRangeError, match=r"is \(16.1, 0, 0\)"):
        al.TransferFunction([(0, (16.1, 0, 0), 1)])
    with pytest.raises(ValueRangeError, match=r"is \(900, 0, 0\).*: 1 is all of the light"):
        al.TransferFunction([(0, (900, 0, 0), 1)])


def test_associated_functions_emit_as_they_like():
    function = al.TransferFunction([(0, ORANGE, 0)], associated=True)
    assert function.scaled(1e3).colours.max() == 255e3
    joint = al.JointFunction(AXES, [Box((0, 0), (1, 1), colour=ORANGE)], associated=True)
    assert joint.scaled(10).source([0.5, 0.5])[0] == 2550
