"""Shifts of samples from pixel to pixel and from frame to frame, and how far neighbouring ones disagree."""

import itertools

import numpy as np
import pytest

import airlight as al
from airlight import reference
from airlight.rendering.disagreement import disagreement_of, disagreement_picture
from airlight.stages.offsets import blue_noise, fraction_of_frame

SIZE = (48, 48)
FLAT = {"transfer": "postclassified", "shade": "none"}
PEAK = al.TransferFunction([(2.0, "#204080", 0), (2.2, "#4080c0", 4), (2.4, "#204080", 0)])


def scene(transfer=PEAK, volume=None):
    volume = al.samples.load("vortex", size=12) if volume is None else volume
    look = al.Look(field="linear_exact", **FLAT)
    return al.Scene(volume, transfer=transfer, camera="iso", look=look, background=None)


def drawn(renderer, step, offsets, shift=0, shown=None):
    return renderer.render(shown or scene(), SIZE, step=step, driver=al.driver.March(offsets=offsets, shift=shift))


def test_blue_noise_has_each_number_once_and_little_of_the_coarse():
    tile = blue_noise()
    assert np.array_equal(np.sort(tile, axis=None), np.arange(4096) / 4096)
    power = np.abs(np.fft.fft2(tile - tile.mean())) ** 2
    waves = np.abs(np.fft.fftfreq(64, 1 / 64))
    radius = np.hypot(waves[:, None], waves)
    assert power[(radius > 0) & (radius < 8)].mean() < 1e-3 * power[radius > 24].mean()
    assert not np.array_equal(tile, blue_noise(seed=2))


def test_frames_lie_evenly():
    places = np.sort([fraction_of_frame(n) for n in range(34)])
    assert np.diff(places).max() < 1.7 / 34
    assert fraction_of_frame(1 << 24) < 1


@pytest.mark.parametrize("offsets", ["interleaved", "blue_noise"])
def test_samples_lie_where_the_driver_says(any_renderer, offsets):
    driver = al.driver.March(offsets=offsets, shift=3)
    image = any_renderer.render(scene(), SIZE, step=2, driver=driver)
    truth = reference.render(scene(), SIZE, step=2, offset_fraction=driver.offset_fraction)
    assert np.abs(image.rgba - truth.rgba).max() <= 2e-4
    plain = reference.render(scene(), SIZE, step=2)
    assert np.abs(plain.rgba - truth.rgba).max() > 0.01


@pytest.mark.parametrize("offsets", ["none", "interleaved", "blue_noise"])
def test_the_mean_of_frames_converges_to_that_of_all_places(renderer, offsets):
    # All samples of many frames together, and none of them near those of the others.
    every = np.mean([drawn(renderer, 2, "none", n).rgba for n in range(55)], axis=0)
    frames = [drawn(renderer, 2, offsets, n).rgba.astype(np.float64) for n in range(21)]
    errors = [np.sqrt(np.mean((np.mean(frames[:n], axis=0) - every) ** 2)) for n in (1, 5, 21)]
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[1] / 2


def test_no_shift_changes_what_skipping_leaves(renderer):
    driver = al.driver.March(offsets="blue_noise", shift=5)
    images = [renderer.render(scene(), SIZE, driver=driver, skip=skip).rgba for skip in ("auto", "none")]
    assert np.abs(images[0] - images[1]).max() < 1 / 255


def test_disagreement_falls_with_the_step(renderer):
    found = [drawn(renderer, step, "interleaved").stats["disagreement"]["rms"] for step in (2, 1, 0.5, 0.25)]
    assert found[0] > 0.01
    assert all(fine < 0.6 * coarse for coarse, fine in itertools.pairwise(found))


def test_disagreement_where_it_is_seen_is_what_offsets_cause(renderer):
    step, where = 2, np.s_[8:-8, 8:-8]
    image = drawn(renderer, step, "interleaved")
    caused = np.std([drawn(renderer, step, "none", n).rgba for n in range(13)], axis=0).max(axis=-1)
    assert image.disagreement.shape == SIZE
    assert image.disagreement.dtype == np.float32
    assert image.stats["disagreement"]["maximum"] == image.disagreement.max()
    assert np.corrcoef(image.disagreement[where].ravel(), caused[where].ravel())[0, 1] > 0.5


def test_nothing_disagrees_in_a_homogeneous_slab(renderer):
    volume = al.Volume(np.full((8, 8, 8), 3.0, dtype=np.float32))
    constant = al.TransferFunction([(2.0, (1, 0.5, 0.2), 0.1), (4.0, (1, 0.5, 0.2), 0.1)])
    image = drawn(renderer, 2, "interleaved", shown=scene(constant, volume))
    assert image.rgba[..., 3].max() > 0.5
    assert image.disagreement[4:-4, 4:-4].max() < 2e-3


def test_ramps_and_edges_do_not_disagree():
    y, x = np.indices((32, 32)) / 32
    for picture in (x, x * y, np.float64(x + y > 1), np.exp(-20 * ((x - 0.5) ** 2 + (y - 0.5) ** 2))):
        assert disagreement_of(np.repeat(picture[..., None], 4, axis=-1).astype(np.float32)).max() < 0.02
    noise = np.random.default_rng(1).normal(0, 0.1, (4, 4, 1)).astype(np.float32)
    pattern = np.tile(noise, (8, 8, 4))
    inside = disagreement_of(pattern)[4:-4, 4:-4]
    assert inside.min() > 0.7 * noise.std()
    assert inside.max() < 1.4 * noise.std()
    assert disagreement_of(np.ones((2, 3, 4), np.float32)).max() == 0


def test_disagreement_is_that_of_interleaved_offsets(renderer):
    for offsets in ("none", "blue_noise"):
        with pytest.raises(al.DataError, match="interleaved"):
            _ = drawn(renderer, 2, offsets).disagreement


def test_the_overlay_is_grey_where_nothing_disagrees():
    rgb = np.full((2, 2, 3), 0.5, dtype=np.float32)
    picture = disagreement_picture(rgb, np.array([[0, 0.05], [0.01, 1.0]], dtype=np.float32))
    assert len(set(picture[0, 0])) == 1
    assert np.array_equal(picture[0, 1], picture[1, 1])
    assert picture[0, 1, 0] == 255
    assert picture[1, 0, 0] > picture[1, 0, 2]


@pytest.mark.parametrize("shift", [-1, 1.5, 1 << 25])
def test_shifts_are_whole_numbers(shift):
    with pytest.raises(al.ValueRangeError, match="shift"):
        al.driver.March(shift=shift)
