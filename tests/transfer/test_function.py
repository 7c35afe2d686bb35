"""Transfer functions: evaluation, steps, colours, plain data, and errors that name the point."""

from __future__ import annotations

import numpy as np
import pytest

from airlight.errors import ValueRangeError
from airlight.transfer import TransferFunction, linear_rgb, linear_to_srgb, srgb_to_linear


def test_piecewise_linear_and_constant_beyond():
    tf = TransferFunction([(0, (0, 0, 0), 0), (10, (1, 0.5, 0), 2)])
    rgb, extinction = tf([-5, 2.5, 10, 99])
    assert extinction.tolist() == [0, 0.5, 2, 2]
    assert rgb[1].tolist() == [0.25, 0.125, 0]


def test_two_points_at_one_value_are_a_step():
    tf = TransferFunction([(0, "black", 0), (1, "black", 0), (1, "white", 3), (2, "white", 3)])
    assert tf([np.nextafter(1, 0), 1.0])[1].tolist() == pytest.approx([0, 3])


def test_words_are_srgb_and_tuples_linear():
    assert linear_rgb("#808080") == pytest.approx((0.2158605,) * 3)
    assert linear_rgb((0.5, 0.5, 0.5)) == (0.5, 0.5, 0.5)
    levels = np.arange(256) / 255
    assert linear_to_srgb(srgb_to_linear(levels)) == pytest.approx(levels, abs=1e-7)


def test_round_trip_as_plain_data():
    tf = TransferFunction([(0, "red", 0.1), (3.5, (0.1, 0.2, 0.3), 7)], associated=True)
    assert TransferFunction.from_dict(tf.to_dict()) == tf
    assert hash(TransferFunction.from_dict(tf.to_dict())) == hash(tf)


def test_kept_arrays_are_read_only():
    tf = TransferFunction([(0, "red", 0.1), (1, "red", 1)])
    for array in (tf.values, tf.colours, tf.extinctions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: TransferFunction([(0, "red", 1)]).with_surfaces(3), "transfer.surfaces is 3, must be a list: give a Surface"),
        (lambda: TransferFunction.from_surfaces(300), "transfer.surfaces is 300, must be a list"),
        (lambda: TransferFunction.from_colormap("viridis", 255), r"is 255, must be a list: give \(first, last\)"),
        (lambda: TransferFunction.from_colormap("viridis", (0, 1, 2)), r"is \(0, 1, 2\): give \(first, last\)"),
        (lambda: TransferFunction.gaussian("a", 1), "gaussian.centre is 'a', must be a finite number"),
        (lambda: TransferFunction([(0, "red", 1)]).scaled("2"), "density is '2', must be a finite number"),
        (lambda: TransferFunction.random_surfaces(1, (0, 1), 2.5), "count is 2.5, must be a whole number in"),
        (lambda: TransferFunction.random(-1, (0, 1)), "seed is -1, must be a whole number of at least 0"),
        (lambda: TransferFunction([(0, "red", 1)], "false"), "associated is 'false', must be true or false"),
        (lambda: TransferFunction(5), "transfer.points is 5, must be a list"),
    ],
)
def test_what_is_of_a_wrong_type_is_told(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], r"transfer.points is empty"),
        ([(0, "black", 0), (1, "black", -1)], r"points\[1\].extinction is -1, must be at least 0"),
        ([(0, "black", 0), (np.nan, "black", 1)], r"points\[1\].value is nan, must be a finite number"),
        ([(5, "black", 0), (1, "black", 1)], r"points\[1\] has value 1, below the 5 before it: sort the points"),
        ([(0, "blak", 0)], r"points\[0\].colour is 'blak'"),
        ([(0, (1, 2), 0)], r"points\[0\].colour is \(1, 2\)"),
        ([(0, "black")], r"points\[0\] is \(0, 'black'\)"),
    ],
)
def test_mistakes_name_the_point(points, message):
    with pytest.raises(ValueRangeError, match=message):
        TransferFunction(points)
