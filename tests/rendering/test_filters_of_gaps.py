"""Filters where samples are empty and where they have several channels: against float64 sums, laws, frames, what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from points import in_reference, inside, on_device, scene_of
from test_filters import FILTERS, name_of, sheared

import airlight as al
from airlight import reference
from airlight.reference.field import field_scalar
from airlight.reference.filters import samples_of, separable_sum

SOME = [stage for stage in FILTERS if not getattr(stage, "prefilter", False)]
SMOOTHING = [stage for stage in SOME if stage.overshoot == 0]
EMPTY = -1e38
MIXTURE = [
    al.TransferFunction([(-40, "red", 0.0), (60, "red", 0.4)]),
    al.TransferFunction([(-20, "lime", 0.0), (30, "lime", 0.2)]),
    al.TransferFunction([(-60, "blue", 0.3), (40, "blue", 0.0)]),
    al.TransferFunction([(-60, "white", 0.1), (60, "white", 0.4)]),
    al.TransferFunction([(-30, "gold", 0.0), (-10, "gold", 0.4), (60, "gold", 0.2)]),
]


def holed(shape, seed=3) -> np.ndarray:
    """Noise with single gaps, a large one, and one at a corner."""
    rng = np.random.default_rng(seed)
    samples = rng.uniform(-40, 60, shape)
    samples[rng.random(shape) < 0.08] = np.nan
    samples[..., 2:6, 3:8, 5:9] = np.nan
    samples[..., -2:, -3:, -2:] = np.nan
    return samples


def away_from_the_rim(drawn: al.Scene, p: np.ndarray) -> np.ndarray:
    """Places where rounding decides neither whether there is a sample, nor of what a channel's line is held."""
    setup = reference.prepare(drawn)
    near = 1e-4
    steps = np.concatenate([np.zeros((1, 3)), near * np.eye(3), -near * np.eye(3)])
    gaps = np.array([field_scalar(setup, p + step)[1] for step in steps])
    return p[(gaps == gaps[0]).all(axis=0)]


@pytest.mark.parametrize("stage", SOME, ids=name_of)
@pytest.mark.parametrize("kind", ["full", "core"])
def test_empty_samples(device, core_device, stage, kind, rng):
    drawn = scene_of(sheared(holed((9, 12, 14))), stage, "analytic")
    p = away_from_the_rim(drawn, inside(drawn.layers[0].volume, 3000, rng))
    value, gradient = on_device({"full": device, "core": core_device}[kind], drawn, p)
    true_value, true_gradient = in_reference(drawn, p)
    gaps = field_scalar(reference.prepare(drawn), p)[1]
    assert 0.02 < gaps.mean() < 0.6
    assert np.array_equal(value < EMPTY, gaps)
    assert np.abs(value - true_value)[~gaps].max() <= 2e-4 * 100
    assert not gradient[gaps].any()
    longest = np.linalg.norm(true_gradient, axis=1).max()
    assert np.linalg.norm(gradient - true_gradient, axis=1).max() <= 1e-3 * longest


@pytest.mark.parametrize("stage", SOME, ids=name_of)
@pytest.mark.parametrize("gaps", [False, True], ids=["full", "gaps"])
def test_mixtures(device, stage, gaps, rng):
    """Five channels take two groups of four: what gradients are taken of, and its derivative."""
    samples = holed((5, 9, 12, 14)) if gaps else rng.uniform(-40, 60, (5, 9, 12, 14))
    drawn = scene_of(sheared(samples), stage, "analytic", transfer=MIXTURE)
    p = away_from_the_rim(drawn, inside(drawn.layers[0].volume, 1500, rng))
    value, gradient = on_device(device, drawn, p)
    true_value, true_gradient = in_reference(drawn, p)
    there = value > EMPTY
    assert there.mean() > 0.5
    assert np.abs(value - true_value)[there].max() <= 2e-4 * (true_value.max() - true_value.min())
    off = np.linalg.norm(gradient - true_gradient, axis=1)
    # Where a channel is held at the end of its line its derivative jumps.
    assert np.quantile(off, 0.995) <= 1e-3 * np.linalg.norm(true_gradient, axis=1).max()


def test_derivative_is_that_of_the_normalised_field(rng):
    """The reference's rule for quotients against differences of its own field."""
    for stage in (al.field.CatmullRom(), al.field.WindowedSinc(), al.field.LinearExact()):
        drawn = scene_of(sheared(holed((9, 12, 14))), stage, "analytic")
        setup = reference.prepare(drawn)
        p = inside(drawn.layers[0].volume, 400, rng)[100:]
        h = 1e-4
        values, gaps = zip(*[field_scalar(setup, p + sign * h * e) for e in np.eye(3) for sign in (1, -1)], strict=True)
        smooth = ~np.any(gaps, axis=0) & (np.abs(p - np.round(p)).min(axis=1) > 2 * h)
        along = np.stack([(values[2 * a] - values[2 * a + 1]) / (2 * h) for a in range(3)], axis=1)
        found = in_reference(drawn, p)[1] @ drawn.layers[0].volume.world_from_index[:3, :3]
        assert smooth.sum() > 100
        assert np.abs(found - along)[smooth].max() <= 1e-3 * np.abs(along[smooth]).max()


@pytest.mark.parametrize("stage", SOME, ids=name_of)
def test_gaps_neither_spread_nor_make_values(device, stage, rng):
    """A constant with holes is that constant wherever there is anything."""
    constant = np.where(np.isnan(holed((9, 12, 14))), np.nan, 7.25)
    drawn = scene_of(sheared(constant), stage, "analytic")
    p = away_from_the_rim(drawn, inside(drawn.layers[0].volume, 1000, rng))
    value, gradient = on_device(device, drawn, p)
    assert np.abs(value[value > EMPTY] - 7.25).max() < 1e-4
    assert np.abs(gradient).max() < 1e-3


@pytest.mark.parametrize("stage", SMOOTHING, ids=name_of)
def test_without_negative_weights_nothing_leaves_the_range_of_what_is_there(device, stage, rng):
    drawn = scene_of(sheared(holed((9, 12, 14))), stage, "zero")
    p = inside(drawn.layers[0].volume, 4000, rng)
    value = on_device(device, drawn, p)[0]
    samples = drawn.layers[0].volume.array
    assert value[value > EMPTY].min() >= np.nanmin(samples) - 1e-3
    assert value.max() <= np.nanmax(samples) + 1e-3


def test_overshoot_is_bounded_where_some_weights_are_missing(rng):
    """Any gaps, any samples in [0, 1]: the field stays within twice the overshoot of the whole filter."""
    stage = replace(al.field.CatmullRom(), masked=True)
    worst = 0.0
    for seed in range(30):
        samples = np.random.default_rng(seed).integers(0, 2, (8, 8, 8)).astype(float)
        samples[np.random.default_rng(seed + 99).random((8, 8, 8)) < 0.45] = np.nan
        drawn = scene_of(sheared(samples), stage, "zero")
        value, gaps = field_scalar(reference.prepare(drawn), inside(drawn.layers[0].volume, 500, rng))
        worst = max(worst, float((value[~gaps] - 1).max()), float(-value[~gaps].min()))
    assert 0.5 * al.field.CatmullRom().overshoot < worst <= stage.overshoot


def test_a_channel_alone_is_what_it_is_in_a_mixture(renderer):
    """Nothing leaks from channel to channel, nor over the border of two groups."""
    samples = np.random.default_rng(1).uniform(-40, 60, (5, 10, 10, 10))
    for number in (0, 3, 4):
        parts = [al.Channel(c, MIXTURE[c], visible=c == number) for c in range(5)]
        for stage in (al.field.BSplineExact(), al.field.WindowedSinc()):
            look = al.Look(field=stage, shade="none")
            mixed = al.Scene(sheared(samples), transfer=al.Channels(parts), camera="iso", look=look)
            alone = al.Scene(sheared(samples[number]), transfer=MIXTURE[number], camera="iso", look=look)
            images = [renderer.render(drawn, (24, 24)).rgba for drawn in (mixed, alone)]
            assert np.abs(images[0] - images[1]).max() < 5e-3
            assert images[0][..., 3].max() > 0.1


def blurred(shape, seed) -> np.ndarray:
    grid = np.random.default_rng(seed).uniform(-60, 80, shape)
    for axis in (-1, -2, -3):
        grid = (np.roll(grid, 1, axis) + 2 * grid + np.roll(grid, -1, axis)) / 4
    return grid


@pytest.mark.parametrize("stage", [al.field.BSpline(), al.field.CatmullRom(), al.field.WindowedSinc(radius=2)], ids=name_of)
@pytest.mark.parametrize("case", ["gaps", "channels", "channels with gaps"])
def test_frames(either_renderer, stage, case):
    """Lit frames against the reference."""
    channels, gaps = "channels" in case, "gaps" in case
    shape = (3, 12, 13, 14) if channels else (12, 13, 14)
    samples = blurred(shape, 5)
    if gaps:
        samples[..., 3:7, 4:9, 4:9] = np.nan
    transfer = MIXTURE[:3] if channels else al.TransferFunction([(-20, "navy", 0.0), (30, "gold", 0.3), (60, "white", 0.5)])
    look = al.Look(field=stage, gradient="analytic", transfer="postclassified")
    drawn = al.Scene(sheared(samples), transfer=transfer, camera="iso", look=look, background=None)
    image = either_renderer.render(drawn, (32, 24))
    truth = reference.render(drawn, (32, 24))
    off = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert truth.rgba[..., 3].max() > 0.5
    assert np.quantile(off, 0.98) < 1.5 / 255  # rays that graze a gap may meet one sample more or less
    assert off.mean() < 0.3 / 255


@pytest.mark.parametrize("name", ["bspline", "bspline_exact"])
def test_splines_through_samples_need_them_all(renderer, name):
    drawn = scene_of(
        sheared(holed((9, 12, 14))), {"bspline": al.field.BSpline, "bspline_exact": al.field.BSplineExact}[name](True), "zero"
    )
    with pytest.raises(al.StageError, match=r"some are empty.*use prefilter=false or catmull_rom"):
        renderer.render(drawn, (8, 8))


def test_splines_through_samples_of_several_channels(device):
    samples = np.random.default_rng(2).uniform(-40, 60, (3, 6, 7, 8))
    drawn = scene_of(sheared(samples), al.field.BSplineExact(True), "zero", transfer=MIXTURE[:3])
    z, y, x = (axis.ravel() for axis in np.indices(samples.shape[1:]))
    p = np.stack([x, y, z], axis=1).astype(np.float64)
    through = in_reference(scene_of(sheared(samples), "linear", "zero", transfer=MIXTURE[:3]), p)[0]
    assert np.abs(on_device(device, drawn, p)[0] - through).max() <= 1e-4 * (through.max() - through.min())


def test_the_field_that_drew_is_named(renderer):
    drawn = scene_of(sheared(holed((9, 12, 14))), "bspline", "analytic")
    assert renderer.render(drawn, (8, 8)).stats["layers"][0]["stages"]["field"] == "bspline_exact"
    samples = samples_of(reference.prepare(drawn))
    assert separable_sum(reference.prepare(drawn), samples, np.full((1, 3), 3.0)).shape == (1,)
