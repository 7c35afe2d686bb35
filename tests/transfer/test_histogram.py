"""Joint histograms, and the derivatives that they count, against closed forms on sheared and uneven grids."""

from __future__ import annotations

import itertools
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import airlight as al
from airlight import Volume
from airlight.errors import DataError, ValueRangeError
from airlight.reference.gradient import central
from airlight.reference.setup import Setup
from airlight.transfer import boundary, derivatives, histogram
from airlight.transfer.boundary import profile
from airlight.transfer.derivatives import pieces
from airlight.transfer.histogram import joint_histogram
from airlight.transfer.joint_axes import Axis

INSIDE = (slice(1, -1),) * 3


def both_derivatives(volume: Volume, channel: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Gradient magnitude and second derivative at all voxels."""
    gradient, second = np.full(volume.array.shape[-3:], np.nan), np.full(volume.array.shape[-3:], np.nan)
    for part in pieces(volume, channel):
        assert part.gradient is not None
        assert part.second is not None
        gradient[part.place], second[part.place] = part.gradient, part.second
    return gradient, second


def sheared(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    while True:
        matrix[:3, :3] = rng.uniform(-2, 2, (3, 3))
        matrix[:3, 3] = rng.uniform(-50, 50, 3)
        if np.linalg.cond(matrix[:3, :3]) < 8:
            return matrix


def world(shape: tuple[int, int, int], matrix: np.ndarray) -> np.ndarray:
    z, y, x = np.mgrid[: shape[0], : shape[1], : shape[2]]
    return np.stack([x, y, z], axis=-1) @ matrix[:3, :3].T + matrix[:3, 3]


@given(st.integers(0, 10_000), st.integers(4, 300))
def test_a_linear_field_has_one_gradient_and_no_second_derivative(seed, at_once):
    rng = np.random.default_rng(seed)
    matrix, slope = sheared(seed), rng.normal(size=3)
    volume = Volume(world((4, 5, 6), matrix) @ slope + 3, world_from_index=matrix)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(derivatives, "VOXELS_AT_ONCE", at_once)
        gradient, second = both_derivatives(volume)
    assert gradient == pytest.approx(np.full((4, 5, 6), np.linalg.norm(slope)), rel=1e-9, abs=1e-9)
    assert second == pytest.approx(np.zeros((4, 5, 6)), abs=1e-8)


@given(st.integers(0, 10_000))
def test_a_quadratic_field_has_its_hessian_along_the_gradient(seed):
    rng = np.random.default_rng(seed)
    matrix, slope, form = sheared(seed), rng.normal(size=3), rng.normal(size=(3, 3))
    form = form + form.T
    p = world((5, 6, 7), matrix)
    volume = Volume(np.einsum("...i,ij,...j", p, form, p) / 2 + p @ slope, world_from_index=matrix)
    gradient, second = both_derivatives(volume)
    true = (p @ form + slope)[INSIDE]
    squared = (true**2).sum(axis=-1)
    scale = float(squared.max()) ** 0.5
    assert gradient[INSIDE] == pytest.approx(np.sqrt(squared), rel=1e-6, abs=1e-8 * scale)
    steep = squared > 1e-6 * squared.max()
    assert second[INSIDE][steep] == pytest.approx(
        (np.einsum("...i,ij,...j", true, form, true) / squared)[steep], rel=1e-4, abs=1e-6
    )


def test_a_distance_field_has_gradient_one_and_is_straight_along_it():
    matrix = np.array([[0.5, 0.1, 0.0, -8], [0, 0.7, 0.2, -9], [0, 0, 0.4, -7], [0, 0, 0, 1.0]])
    r = np.linalg.norm(world((36, 26, 34), matrix) - [0.5, 0.5, 0.3], axis=-1)
    gradient, second = both_derivatives(Volume(r, world_from_index=matrix))
    far = r[INSIDE] > 4
    assert gradient[INSIDE][far] == pytest.approx(1.0, abs=0.02)
    assert np.abs(second[INSIDE][far]).max() < 0.02


@given(st.sampled_from([(1, 5, 6), (4, 1, 6), (4, 5, 1), (1, 1, 6), (1, 1, 1)]))
def test_nothing_changes_along_an_axis_of_one_voxel(shape):
    z, y, x = np.mgrid[: shape[0], : shape[1], : shape[2]]
    gradient, _ = both_derivatives(Volume(2.0 * x + 3 * y + 6 * z, spacing=(2, 3, 6)))
    assert gradient == pytest.approx(np.full(shape, np.sqrt(sum(n > 1 for n in shape))))


@given(arrays(np.bool_, (4, 5, 6), elements=st.booleans()), st.booleans())
def test_empty_samples_do_not_touch_the_derivatives_of_a_linear_field(empty, by_nan):
    """A linear field goes on straight beside holes: gradients along axes that still have a neighbour are right."""
    z, y, x = np.mgrid[:4, :5, :6].astype(float)
    for field, axis in ((x, 2), (y, 1), (z, 0)):
        volume = Volume(np.where(empty, np.nan if by_nan else -99.0, field), no_data=None if by_nan else -99)
        gradient, second = both_derivatives(volume)
        lone = ~empty
        for side in (1, -1):
            beside = np.roll(~empty, side, axis=axis)
            np.moveaxis(beside, axis, 0)[0 if side == 1 else -1] = False
            lone &= ~beside
        assert (gradient[~empty] == np.where(lone, 0.0, 1.0)[~empty]).all()
        assert not second.any()


def test_gradients_are_those_of_the_central_stage():
    rng = np.random.default_rng(5)
    values = rng.normal(size=(5, 6, 7))
    values[2, 3, 3] = values[0, 0, 4] = np.nan
    matrix = sheared(5)
    volume = Volume(values, world_from_index=matrix)
    layer = al.Layer(volume)
    setup = Setup(layer, al.TransferFunction([(0, "white", 1)]), {"field": layer.look.field})
    p = (
        np.stack(np.meshgrid(np.arange(5), np.arange(6), np.arange(7), indexing="ij")[::-1], axis=-1)
        .reshape(-1, 3)
        .astype(float)
    )
    expected = np.linalg.norm(central(setup, p), axis=1).reshape(5, 6, 7)
    there = np.isfinite(values)
    assert both_derivatives(volume)[0][there] == pytest.approx(expected[there])


# -- counts


variables = st.lists(st.sampled_from(["value", "gradient", "second", 1]), min_size=2, max_size=3, unique=True)
samples = st.one_of(
    arrays(np.float32, (2, 3, 4, 5), elements=st.floats(-10, 10, width=32) | st.just(np.nan)),
    arrays(np.uint8, (2, 3, 4, 5)),
    arrays(np.int16, (2, 3, 4, 5), elements=st.integers(-5, 5)),
    arrays(np.bool_, (2, 3, 4, 5)),
)


@given(samples, variables, st.integers(2, 9), st.sampled_from([0, 10, 40]), st.integers(4, 60))
@settings(max_examples=60)
def test_every_sample_is_counted_once(array, chosen, bins, percent, at_once):
    """Counts, those outside and the empty ones make up the volume, whatever the pieces; brute force counts the same."""
    volume = Volume(array, spacing=(1, 2, 0.5), no_data=3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(derivatives, "VOXELS_AT_ONCE", at_once)
        found = joint_histogram(volume, chosen, bins, percentiles=(percent, 100 - percent))
    assert found.counts.sum() + found.outside + found.empty == 60
    assert found.counts.shape == (bins,) * len(chosen)
    grids = {"value": array[0], 1: array[1]}
    grids["gradient"], grids["second"] = both_derivatives(volume)
    there = np.ones((3, 4, 5), dtype=bool)
    for v in [0, *([1] if 1 in chosen else [])]:
        there &= np.isfinite(array[v]) & (array[v] != 3 if array.dtype != bool else True)
    assert found.empty == (~there).sum()
    data = [np.asarray(grids[v], dtype=float)[there] for v in chosen]
    inside = np.logical_and.reduce([(d >= a.low) & (d <= a.high) for d, a in zip(data, found.axes, strict=True)])
    assert found.outside == (~inside).sum()
    if percent == 0:
        assert found.outside == 0


def test_counts_lie_in_the_bins_of_their_values():
    array = np.array([0, 1, 2, 3] * 6, dtype=float).reshape(2, 3, 4)
    other = np.repeat(np.arange(6.0), 4).reshape(2, 3, 4)
    found = joint_histogram(Volume(np.stack([array, other])), (Axis(0, 0, 4), Axis(1, 0, 6)), 2)
    assert found.counts.tolist() == [[6, 6], [6, 6]]
    found = joint_histogram(Volume(np.stack([array, other])), (Axis(0, 0, 2), Axis(1, 0, 6)), 4)
    assert found.counts.tolist() == [[2, 0, 2, 2], [1, 0, 1, 1], [2, 0, 2, 2], [1, 0, 1, 1]]
    assert found.outside == 6


def test_the_last_axis_is_the_first_variable_and_the_picture_has_it_to_the_right():
    found = joint_histogram(Volume(np.mgrid[:4, :4, :16][2].astype(float)), ("value", Axis("gradient", 0, 2)), 4)
    assert found.counts.tolist() == [[0] * 4, [0] * 4, [64] * 4, [0] * 4]
    image = found.image()
    assert image.dtype == np.uint8
    assert image.tolist() == [[0] * 4, [255] * 4, [0] * 4, [0] * 4]
    assert (found.image(1, 0) == image.T[::-1, ::-1]).all()


@pytest.mark.parametrize(("first", "second"), list(itertools.permutations(range(3), 2)))
def test_pictures_of_three_variables_sum_over_the_one_left_out(first, second, rng):
    volume = Volume(rng.normal(size=(3, 8, 8, 8)))
    axes = [Axis(c, -4, 4) for c in range(3)]
    image = joint_histogram(volume, axes, 5).image(first, second)
    assert (image == joint_histogram(volume, (axes[first], axes[second]), 5).image()).all()


def test_pictures_are_logarithmic():
    found = histogram.JointHistogram(np.array([[0, 1], [3, 1023]]), (Axis("value", 0, 1), Axis("gradient", 0, 1)), 0, 0)
    assert found.image().tolist() == [[51, 255], [0, 26]]


def test_axes_leave_outliers_out():
    rng = np.random.default_rng(0)
    values = rng.uniform(0, 1, (32, 32, 32))
    values[7, 7, 7] = 1e6
    plain = joint_histogram(Volume(values), percentiles=(0, 100))
    robust = joint_histogram(Volume(values), percentiles=(0.1, 99.9))
    assert plain.axes[0].high == 1e6
    assert plain.outside == 0
    assert robust.axes[0].high < 1000
    assert robust.axes[1].high < 2
    assert robust.axes[1].low == 0


@given(arrays(np.int16, (3, 4, 5), elements=st.integers(-700, 700)), st.integers(2, 64))
def test_bins_of_whole_values_hold_equally_many_of_them(array, bins):
    found = joint_histogram(Volume(array), bins=bins, percentiles=(0, 100))
    axis = found.axes[0]
    per_bin = axis.span / bins
    assert per_bin == pytest.approx(round(per_bin)) or per_bin <= 0.5
    assert (axis.low - 0.5) % 1 == 0


def test_second_derivatives_have_zero_in_the_middle():
    found = joint_histogram(Volume(np.random.default_rng(0).normal(size=(9, 9, 9))), ("value", "second"))
    assert found.axes[1].low == -found.axes[1].high


@pytest.mark.parametrize("array", [np.zeros((2, 2, 2)), np.full((2, 2, 2), 7, np.uint8), np.full((2, 2, 2), np.nan)])
def test_constant_and_empty_volumes_have_histograms_too(array):
    for chosen in (("value", "gradient"), ("value", "second")):
        found = joint_histogram(Volume(array), chosen)
        assert found.counts.sum() == (0 if np.isnan(array).any() else 8)
        assert found.image().max() == (0 if np.isnan(array).any() else 255)


def test_memory_does_not_grow_with_the_volume(monkeypatch):
    """Not even a float32 copy of the samples is made."""
    monkeypatch.setattr(histogram, "SAMPLES_FOR_AXES", 1 << 16)
    monkeypatch.setattr(boundary, "SAMPLES_FOR_NOISE", 1 << 14)
    monkeypatch.setattr(derivatives, "VOXELS_AT_ONCE", 1 << 14)
    volume = Volume(np.random.default_rng(0).integers(0, 255, (96, 128, 128), dtype=np.uint8))
    tracemalloc.start()
    try:
        joint_histogram(volume, ("value", "second"), bins=64)
        profile(volume)
        assert tracemalloc.get_traced_memory()[1] < 4 * volume.array.size
    finally:
        tracemalloc.stop()


def test_progress_is_told(monkeypatch):
    monkeypatch.setattr(derivatives, "VOXELS_AT_ONCE", 32)
    told = []
    joint_histogram(Volume(np.zeros((4, 4, 4))), progress=lambda *step: told.append(step))
    assert told == [("histogram", 1, 2), ("histogram", 2, 2)]


def test_time_steps_and_channels_by_name(rng):
    array = rng.normal(size=(2, 2, 4, 4, 4))
    volume = Volume(array, channel_names=("a", "b"))
    by_name = joint_histogram(volume, ("value", "a"), channel="b", time=1)
    by_number = joint_histogram(volume, (1, 0), channel=0, time=1)
    assert (by_name.counts == by_number.counts).all()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"variables": ()}, ValueRangeError, r"variables are \[\]: give one, two or three"),
        ({"variables": ("value", "secnd")}, DataError, r"variables\[1\] is 'secnd', .*use value, gradient, second"),
        ({"variables": ("value", "value")}, ValueRangeError, "two or three different"),
        ({"variables": ("value", 1.5)}, ValueRangeError, r"variables\[1\] is 1.5"),
        ({"variables": ("value", "dapi")}, DataError, "is 'dapi', which is no variable"),
        ({"variables": ("value", 3)}, DataError, "is channel 3; the volume has"),
        ({"bins": 1}, ValueRangeError, r"bins is 1, must lie in \[2, 4096\]"),
        ({"variables": ("value", "gradient", "second"), "bins": 1000}, ValueRangeError, r"must lie in \[2, 512\]"),
        ({"percentiles": (99, 1)}, ValueRangeError, "percentiles are"),
        ({"channel": 4}, DataError, "channel is 4"),
        ({"time": 4}, DataError, "time is 4"),
    ],
)
def test_mistakes_are_named(arguments, error, message):
    with pytest.raises(error, match=message):
        joint_histogram(Volume(np.zeros((3, 3, 3))), **arguments)


@pytest.mark.parametrize("slope", [1.0, 0.37, 1e-3, 2500.0])
def test_scaled_whole_values_leave_no_gaps(slope):
    """As files hold them: whole numbers times a slope, in 32-bit floats."""
    rng = np.random.default_rng(2)
    whole = np.clip(rng.normal(300, 60, size=(24, 24, 24)).round(), 0, 600)
    found = joint_histogram(Volume((whole * slope - 7 * slope).astype(np.float32)), ("value", "gradient"))
    counts = found.counts.sum(axis=0)
    plain = joint_histogram(Volume(whole.astype(np.int16)), ("value", "gradient")).counts.sum(axis=0)
    assert counts.tolist() == plain.tolist()
    # Samples of a continuous field keep the axis from the least to the greatest that is no outlier.
    continuous = joint_histogram(Volume(whole + rng.uniform(0, 1, whole.shape)), ("value", "gradient"))
    assert continuous.axes[0].high < 601
