"""Tone curves, averages round pixels and adaptation against closed forms, and the grid against the filter it stands for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import airlight as al
from airlight.reference.tone import TONES, log_average, surround
from airlight.rendering.image import Image

EDGE, RADIUS = 1.33, 0.05
NORMAL = np.vectorize(lambda t: 0.5 * (1 + math.erf(t / math.sqrt(2))))


def grey(stops: np.ndarray, alpha: float | np.ndarray = 1.0) -> np.ndarray:
    """Image (h, w, 4) of greys whose luminance is a power of two."""
    rgba = np.ones((*stops.shape, 4))
    rgba[..., :3] = 2.0 ** stops[..., None]
    rgba[..., 3] = alpha
    return rgba


def step(height: float, at: int = 100, size: tuple[int, int] = (12, 200)) -> np.ndarray:
    return np.broadcast_to(np.where(np.arange(size[1]) < at, 0.0, height), size).copy()


# -- luminance round pixels


@pytest.mark.parametrize("height", [0.5, 1.0, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("level", [0.0, 0.37, -5.2])
def test_halos_are_those_of_the_filter(height, level):
    """Beside an edge: what the normal distribution has beyond it, times the weight of so many stops."""
    stops = step(height)
    found = np.log2(surround(grey(stops + level), RADIUS, EDGE)) - level
    distance = np.abs(np.arange(200) + 0.5 - 100) / (RADIUS * 200)
    beyond = math.exp(-(height**2) / (2 * EDGE**2)) * NORMAL(-distance)
    mixed = height * beyond / (beyond + NORMAL(distance))
    truth = np.where(stops[0] == 0, mixed, height - mixed)
    assert np.abs(found - truth).max() < 0.16
    assert np.abs(found - truth).max() < 0.35 * mixed.max() + 0.01


@given(st.floats(6, 9), st.floats(-3, 3), st.integers(90, 110))
@settings(max_examples=12)
def test_strong_edges_have_no_halos(height, level, at):
    """Beyond three steps of luminance (5.7 stops) nothing is mixed: each side is as the global operator shows it."""
    rgba = grey(step(height, at, (4, 200)) + level)
    assert surround(rgba, RADIUS, EDGE) == pytest.approx(rgba[..., 0], rel=1e-5)
    local, everywhere = al.tone.ReinhardLocal(radius=RADIUS, edge=EDGE, white=9), al.tone.Reinhard(white=9)
    assert TONES["reinhard_local"](local, rgba) == pytest.approx(TONES["reinhard"](everywhere, rgba), rel=1e-5)


def test_the_grid_is_the_bilateral_filter():
    """Against its definition, on a picture with slopes, an edge and noise that is covered to different degrees."""
    side, radius = 72, 0.04
    y, x = np.mgrid[:side, :side]
    stops = np.sin(x / 9) + 1.5 * np.cos(y / 13) + 4 * ((x - 40) ** 2 + (y - 30) ** 2 < 300)
    stops = stops + 0.3 * np.random.default_rng(1).standard_normal(stops.shape)
    alpha = np.where(x > 20, 1.0, 0.3)
    sums = np.zeros((2, side, side))
    reach = int(4 * radius * side)
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            inside = (y + dy >= 0) & (y + dy < side) & (x + dx >= 0) & (x + dx < side)
            there = np.clip(y + dy, 0, side - 1), np.clip(x + dx, 0, side - 1)
            far = (dx * dx + dy * dy) / (radius * side) ** 2 + ((stops[there] - stops) / EDGE) ** 2
            weight = inside * alpha[there] * np.exp(-np.minimum(far / 2, 100))
            sums += weight * np.stack([stops[there], np.ones_like(stops)])
    error = np.log2(surround(grey(stops, alpha), radius, EDGE)) - sums[0] / sums[1]
    assert np.sqrt(np.mean(error**2)) < 0.04
    assert np.abs(error).max() < 0.25
    assert np.abs(stops - sums[0] / sums[1]).max() > 0.9  # which is what there was to average


def test_what_covers_nothing_is_not_averaged():
    """The same luminance round pixels, whatever is behind the silhouette; and some where nothing counts."""
    rgba = grey(step(1.5))
    rgba[:, 150:] = 0
    found = surround(rgba, RADIUS, EDGE)[:, :150]
    other = rgba.copy()
    other[:, 150:, :3] = 2.0
    assert surround(other, RADIUS, EDGE)[:, :150] == pytest.approx(found, rel=1e-12)
    nothing = grey(step(3.0), 0.0)
    assert surround(nothing, RADIUS, EDGE) == pytest.approx(nothing[..., 0])


def test_fine_contrast_stays_and_bright_regions_are_compressed():
    """A ripple on a bright region: the global operator flattens it, the local one keeps its contrast."""
    ripple = 0.2 * (np.indices((40, 80)).sum(axis=0) % 2 * 2 - 1)
    rgba = grey(np.concatenate([ripple - 3, ripple + 4]))
    local, everywhere = al.tone.ReinhardLocal(radius=0.05, white=1e6), al.tone.Reinhard(white=1e6)
    contrast = {}
    for stage in (local, everywhere):
        bright = np.log2(TONES[stage.name](stage, rgba)[60, 20:60, 0])
        contrast[stage.name] = np.ptp(bright)
    assert contrast["reinhard_local"] == pytest.approx(0.4, abs=0.02)
    assert contrast["reinhard"] < 0.25


# -- curves


@given(st.floats(1.2, 100), st.floats(1.0, 4.0), st.floats(0.001, 1000))
def test_filmic_has_fixed_points_and_rises(white, contrast, average):
    """Middle grey stays, white becomes 1, the curve rises, and steeply as asked for where it passes grey."""
    stage = al.tone.Filmic(white=white, contrast=contrast, key=0.18, adapted=average)
    light = np.array([0, 0.18, 0.18001, white, *np.geomspace(1e-4, 1e4, 50)]) * average / 0.18
    shown = TONES["filmic"](stage, np.concatenate([np.repeat(light[:, None], 3, axis=1), np.ones((54, 1))], axis=1))[:, 0]
    assert shown[:2] == pytest.approx([0, 0.18], rel=1e-9)
    assert shown[3] == pytest.approx(1)
    assert (np.diff(shown[4:]) >= 0).all()
    slope = math.log(shown[2] / shown[1]) / math.log(0.18001 / 0.18)
    half = 0.82 / (0.18 - (0.18 / white) ** contrast) * 0.18**contrast
    assert slope == pytest.approx(contrast * half / (0.18**contrast + half), rel=1e-3)


@pytest.mark.parametrize("stage", [al.tone.Reinhard(), al.tone.ReinhardLocal(), al.tone.Filmic()])
def test_exposure_follows_the_light_unless_told(stage):
    """Twice the light gives the same picture; a stop more doubles the light; a known average is taken as it is."""
    rgba = grey(np.random.default_rng(2).uniform(-3, 3, (20, 30)))
    twice = rgba * (2, 2, 2, 1)
    tone = TONES[stage.name]
    assert tone(stage, twice) == pytest.approx(tone(stage, rgba), rel=1e-5)
    known = replace(stage, adapted=log_average(rgba))
    assert tone(known, rgba) == pytest.approx(tone(stage, rgba))
    assert tone(known, twice) == pytest.approx(tone(replace(stage, exposure=1), rgba), rel=1e-5)


# -- adaptation


def seen(luminance: float) -> Image:
    return Image(np.zeros((1, 1, 4), np.float32), np.zeros((1, 1), np.float32), stats={"luminance": luminance})


@given(st.floats(0.01, 100), st.floats(0.01, 100), st.floats(0, 3), st.floats(0, 3))
def test_adaptation_knows_time_and_not_frames(begin, luminance, first_s, second_s):
    """Two frames of the same picture do what one does that lasts as long; eyes never pass what they see."""
    eye = al.tone.Adaptation(begin)
    both = eye.adapted(seen(luminance), first_s).adapted(seen(luminance), second_s)
    assert both.luminance == pytest.approx(eye.adapted(seen(luminance), first_s + second_s).luminance, rel=1e-9)
    low, high = sorted((begin, luminance))
    assert low * (1 - 1e-9) <= both.luminance <= high * (1 + 1e-9)


def test_adaptation():
    eye = al.tone.Adaptation()
    assert eye.adapted(seen(3.0), 0.01).luminance == 3.0  # the first picture at once
    eye = replace(eye, luminance=1.0)
    assert eye.adapted(seen(math.e), eye.to_light_s).luminance == pytest.approx(math.exp(1 - math.exp(-1)))
    assert eye.adapted(seen(1 / math.e), eye.to_dark_s).luminance == pytest.approx(math.exp(math.exp(-1) - 1))
    assert eye.adapted(seen(0.0), 1.0) == eye  # nothing is seen
    with pytest.raises(al.DataError, match=r"has no luminance, which linear tones do not measure: draw with tone"):
        eye.adapted(Image(np.zeros((1, 1, 4), np.float32), np.zeros((1, 1), np.float32)), 1.0)
    with pytest.raises(al.AirlightError, match=r"seconds is -1, must be at least 0"):
        eye.adapted(seen(1.0), -1)
    with pytest.raises(al.AirlightError, match=r"adaptation\.to_dark_s is 0, must be above 0"):
        al.tone.Adaptation(to_dark_s=0)
    with pytest.raises(al.AirlightError, match=r"adaptation\.luminance is -1, must be at least 0"):
        al.tone.Adaptation(-1)
    with pytest.raises(al.AirlightError, match=r"adaptation\.luminance is 'bright', must be a finite number"):
        al.tone.Adaptation("bright")
