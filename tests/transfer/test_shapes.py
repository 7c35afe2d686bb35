"""Shapes, colour maps and random functions."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from airlight.errors import ValueRangeError
from airlight.transfer import TransferFunction, colormap_names, linear_rgb, linear_to_srgb

T = TransferFunction


@given(st.floats(-1e4, 1e4), st.floats(0.01, 1e3), st.floats(1e-6, 1e6))
def test_gaussian(centre, sigma, extinction):
    tf = T.gaussian(centre, sigma, "khaki", extinction)
    x = np.linspace(-6, 6, 4001)
    expected = np.exp(-(x**2) / 2)
    assert np.abs(tf(centre + sigma * x)[1] / extinction - expected).max() < 1e-3
    assert len(tf.points) < 50
    assert tf(centre)[1] == extinction
    assert set(tf.colours.ravel()) == set(linear_rgb("khaki"))


def test_gaussian_is_symmetric():
    tf = T.gaussian(0, 1)
    assert (tf.values == -tf.values[::-1]).all()
    assert (tf.extinctions == tf.extinctions[::-1]).all()
    assert tf.extinctions[0] == 0


def test_box_step_peak_and_ramp():
    below = np.nextafter([2.0, 5.0], -np.inf)
    assert T.box(2, 5, "red", 3)([below[0], 2, 3, below[1], 5])[1].tolist() == [0, 3, 3, 3, 0]
    assert T.step(2, "red", 3)([below[0], 2, 1e9])[1].tolist() == [0, 3, 3]
    assert T.peak(2, 4, "red", 3)([-1, 0, 1, 2, 3, 4, 5])[1].tolist() == [0, 0, 1.5, 3, 1.5, 0, 0]
    ramp = T.ramp(0, 4, "white", 2, low_colour="black")
    assert ramp([-1, 1, 9])[1].tolist() == [0, 0.5, 2]
    assert ramp([1])[0].tolist() == [[0.25] * 3]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: T.gaussian(0, 0), "transfer.gaussian.sigma is 0, must be above 0"),
        (lambda: T.gaussian(np.nan, 1), "transfer.gaussian.centre is nan, must be a finite number"),
        (lambda: T.gaussian(0, 1, extinction=-1), "transfer.gaussian.extinction is -1, must be at least 0"),
        (lambda: T.box(1, 1), "transfer.box runs from 1 to 1"),
        (lambda: T.peak(1, -1), "transfer.peak.width is -1"),
        (lambda: T.step(np.inf), "transfer.step.value is inf"),
        (lambda: T.ramp(0, 1, "blak"), "colour is 'blak'"),
        (lambda: T.random(1, (1, 0)), "transfer.random.value_range runs from 1 to 0"),
        (lambda: T.random(1, (0, 1), entries=1), "entries is 1, must be a whole number in"),
        (lambda: T.random(1, (0, 1), channels="gx"), "channels is 'gx', must be letters of rgba"),
        (lambda: T.random(1, (0, 1), base=T([(0, "red", 0)], associated=True)), "base is associated"),
        (lambda: T.from_colormap("viridis", (1, 0)), "transfer.colormap runs from 1 to 0"),
        (lambda: T.from_colormap("viridsi", (0, 1)), "'viridsi' is unknown: did you mean viridis"),
        (lambda: T.from_colormap("§§", (0, 1)), "is unknown: airlight presets --colormaps lists them"),
        (lambda: T.from_colormap("gray", (0, 1), (0, -1)), r"transfer.extinction\[1\] is \(1, -1\)"),
        (lambda: T.from_colormap("gray", (0, 1), (1, 2, 3)), r"has shape \(3,\)"),
        (lambda: T.from_colormap("gray", (0, 1), [(1, 0.1), (0, 0.2)]), r"transfer.extinction\[1\] is \(0, 0.2\)"),
    ],
)
def test_mistakes_are_told(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make()


# -- colour maps

LINEAR = ("viridis", "gray", "jet", "gnuplot", "cubehelix", "twilight", "turbo", "colorbrewer:blues", "cmocean:ice")


@pytest.mark.parametrize("name", LINEAR)
def test_colours_are_those_of_the_map(name):
    from cmap import Colormap

    entries = 5001
    encoded = np.clip(Colormap(name).lut(entries)[:, :3], 0, 1)
    for turned, right in ((False, encoded), (True, encoded[::-1])):
        tf = T.from_colormap(name, (-5, 15), reversed=turned)
        rgb, tau = tf(np.linspace(-5, 15, entries))
        assert np.abs(linear_to_srgb(rgb) - right).max() < 1 / 255
        assert set(tau) == {1.0}
        assert tf.domain == (-5, 15)


def test_maps_of_separate_colours_are_steps():
    from cmap import Colormap

    tf = T.from_colormap("tab10", (0, 10))
    right = Colormap("tab10").lut()[:, :3]
    at = np.concatenate([np.arange(10), np.arange(10) + 1 - 2e-9]) + 1e-9
    np.testing.assert_allclose(linear_to_srgb(tf(at)[0]), np.concatenate([right, right]), atol=1e-7)


def test_reversed_maps_by_name():
    assert T.from_colormap("magma_r", (0, 1)) == T.from_colormap("magma", (0, 1), reversed=True)
    assert T.from_colormap("magma_r", (0, 1), reversed=True)([0.3])[0] == pytest.approx(
        T.from_colormap("magma", (0, 1))([0.3])[0]
    )


def test_extinctions_of_maps():
    assert T.from_colormap("gray", (0, 4), (1, 3))([0, 1, 4])[1].tolist() == [1, 1.5, 3]
    tf = T.from_colormap("gray", (0, 4), [(-2, 0), (1, 2), (1, 5), (6, 5)])
    assert tf([-2, -0.5, np.nextafter(1, 0), 1, 9])[1].tolist() == pytest.approx([0, 1, 2, 5, 5])
    assert tf.domain == (-2, 6)
    assert (tf([-2, 0])[0] == 0).all()


def test_names_are_listed_and_the_package_is_not_loaded_before():
    names = colormap_names()
    assert "viridis" in names["sequential"]
    assert "tab10" in names["qualitative"]
    code = "import sys, airlight as al; al.TransferFunction([(0, 'red', 1)]); sys.exit('cmap' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# -- random functions


def test_random_entries():
    tf = T.random(7, (0, 255), channels="g")
    assert tf == T.random(7, (0, 255), channels="g")
    assert tf != T.random(8, (0, 255), channels="g")
    assert tf.values.tolist() == list(range(256))
    np.testing.assert_allclose(tf.colours[:, 0], np.arange(256) / 255)
    np.testing.assert_allclose(tf.extinctions, np.arange(256) / 255)
    assert 0.2 < tf.colours[:, 1].std() < 0.4
    # The same numbers, whatever the release of NumPy.
    assert tf.colours[:2, 1].tolist() == pytest.approx([0.8972138009695755, 0.8735534453962619])


def test_random_among_others_channels():
    base = T([(10, "black", 0.0), (33.3, "red", 0.5), (33.3, "blue", 1.5), (90, "white", 2.0)])
    tf = T.random(3, (0, 100), entries=11, channels="ga", base=base, extinction=4)
    at = np.linspace(-5, 105, 333)
    np.testing.assert_allclose(tf(at)[0][:, [0, 2]], base(at)[0][:, [0, 2]], atol=1e-12)
    knots = np.arange(0, 101, 10)
    others = T.random(3, (0, 100), entries=11, channels="ga", extinction=4)
    assert tf(knots)[1].tolist() == pytest.approx(others(knots)[1].tolist())
    assert 2 < tf.extinctions.max() <= 4
