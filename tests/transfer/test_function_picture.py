"""Pictures of functions of one value, and of counts of one variable."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

import airlight as al
from airlight.errors import ValueRangeError
from airlight.transfer.function_picture import GAP_PX, STRIP_PX, extinction_axis, value_axis
from airlight.transfer.histogram_picture import INK, LEFT_PX, PAPER, SIDE_PX, TOP_PX

STEP = al.TransferFunction([(0, "red", 0), (50, "red", 0), (50, "#0000ff", 2), (100, "#0000ff", 2)])


def plot(picture: np.ndarray) -> np.ndarray:
    return picture[TOP_PX : TOP_PX + SIDE_PX, LEFT_PX : LEFT_PX + SIDE_PX].astype(int)


def column(function: al.TransferFunction, value: float) -> int:
    axis = value_axis(function)
    return int((value - axis.low) / axis.span * SIDE_PX)


def test_extinction_and_colour_stand_where_the_axes_say():
    drawn = plot(STEP.picture())
    low, high = drawn[:, column(STEP, 20)], drawn[:, column(STEP, 80)]
    assert (high[-STRIP_PX:] == (0, 0, 255)).all()
    assert (low[-STRIP_PX:] == (255, 0, 0)).all()
    assert (low[:-STRIP_PX] == PAPER).all()
    # Extinction 2 reaches to 2 on the axis, and its line lies on top.
    top = SIDE_PX * (1 - 2 / extinction_axis(STEP).high)
    assert np.flatnonzero((high == (0, 0, 255)).all(axis=-1)).min() == pytest.approx(top, abs=2)
    assert np.flatnonzero((high == INK).all(axis=-1)).mean() == pytest.approx(top, abs=2)
    # The step is closed by an upright line.
    assert (
        (drawn[:, column(STEP, 50)] == INK).all(axis=-1) | (drawn[:, column(STEP, 50) - 1] == INK).all(axis=-1)
    ).mean() > 0.9


def test_surfaces_are_lines_as_high_as_they_are_opaque():
    function = al.TransferFunction.from_surfaces([al.Surface(10, "lime", 0.5), al.Surface(30, "#ff00ff")])
    drawn = plot(function.picture())
    for value, colour, opacity in ((10, (0, 255, 0), 0.5), (30, (255, 0, 255), 1.0)):
        height = (drawn[:, column(function, value)] == colour).all(axis=-1).mean()
        assert height == pytest.approx(opacity / 1.05, abs=(STRIP_PX + GAP_PX + 4) / SIDE_PX)


@pytest.mark.parametrize(
    "function",
    [
        al.TransferFunction([(3, "red", 0)]),
        al.TransferFunction([(0, (90, 0, 1), 0), (0, (0, 900, 1), 0)], associated=True),
        al.TransferFunction.gaussian(1e-9, 1e-12, "white", 1e30),
        al.TransferFunction([(-1e30, (9, 0, 0), 1e-30), (1e30, "white", 0)]),
    ],
)
def test_any_function_is_shown_in_notebooks(function):
    with Image.open(io.BytesIO(function._repr_png_())) as image:
        assert image.size[0] > SIDE_PX
        assert len(np.unique(np.asarray(image))) > 4


def test_counts_of_one_variable_are_bars():
    values = np.repeat(np.arange(8), [0, 1, 9, 99, 999, 99, 9, 1]).astype(np.uint8)
    volume = al.Volume(values[None, None], value_unit="HU")
    found = al.joint.histogram(volume, [al.joint.Axis("value", -0.5, 7.5)], bins=8)
    assert found.counts.tolist() == [0, 1, 9, 99, 999, 99, 9, 1]
    assert found.counts.sum() + found.outside + found.empty == values.size
    drawn = plot(found.picture())
    # log10(1 + count): each bar is one more than the one before.
    heights = [(drawn[:, int((n + 0.5) / 8 * SIDE_PX)] != PAPER).all(axis=-1).sum() for n in range(8)]
    assert heights[0] <= 1
    assert np.array(heights[2:]) / heights[4] == pytest.approx(np.array([1, 2, 3, 2, 1, np.log10(2)]) / 3, abs=0.02)
    over = plot(found.picture(al.TransferFunction([(0, "red", 0), (7, "red", 1)])))
    assert ((over[..., 0] > 180) & (over[..., 2] < 80)).mean() > 0.3


def test_what_does_not_go_together_is_told():
    volume = al.Volume(np.arange(27.0).reshape(3, 3, 3))
    with pytest.raises(ValueRangeError, match="function is a TransferFunction, the histogram has 2 variables"):
        al.joint.histogram(volume, bins=4).picture(STEP)
    with pytest.raises(ValueRangeError, match="image is of two variables, and the histogram has one"):
        al.joint.histogram(volume, ["value"], bins=4).image()
