"""The ladder: as good as there is time for, never below its floor but for heavy looks, and no up and down."""

from __future__ import annotations

import numpy as np
import pytest

from airlight.rendering.budget import Cost, scaled
from airlight.viewer.ladder import (
    FLOOR,
    HALF,
    QUICK_FRAMES,
    RUNGS,
    TARGET_MS,
    Pace,
    after_frame,
    after_trip,
    at_rest,
    learnt,
)

SIZE_PX = (512, 512)


def run(frame_ms, pixel_ms: float, samples_ms: float, frames: int, noise: float = 0.0, rng=None) -> list[Pace]:
    """Paces of a view whose pictures take so long."""
    true, cost, pace, paces = Cost(frame_ms, pixel_ms, samples_ms), None, Pace(), []
    for _ in range(frames):
        rung = pace.drawn(1.0)
        width, height = scaled(SIZE_PX, rung.scale)
        spent = true.of(width * height, rung.step) * (1 if rng is None else np.exp(noise * rng.standard_normal()))
        cost = learnt(cost, width * height, rung.step, spent)
        pace = after_frame(pace, cost, SIZE_PX, 1.0)
        paces.append(pace)
    return paces


def test_a_quick_device_climbs_to_the_full_picture_and_stays():
    paces = run(1.0, 1e-6, 1e-6, 60)
    assert paces[-1].rung == 0
    assert paces[-1].drawn(0.5).step == 0.5


def test_moving_pictures_keep_to_the_floor_until_a_look_is_heavy():
    slow = run(8.0, 4e-4, 4e-4, 100)  # 47 ms at the floor
    assert {pace.rung for pace in slow} == {FLOOR}
    assert slow[-1].drawn(1.0).scale == 0.5
    assert slow[-1].drawn(1.0).step == 2.0
    assert slow[-1].drawn(3.0).step == 3.0
    heavy = run(8.0, 1e-2, 1e-2, 100)  # 1 s
    assert heavy[2].rung == FLOOR
    assert heavy[-1].rung == len(RUNGS) - 1


@pytest.mark.parametrize("samples_ms", [4e-5, 1e-4, 2e-4])
def test_a_noisy_clock_makes_no_flicker(samples_ms, rng):
    paces = run(6.0, samples_ms, samples_ms, 600, 0.25, rng)
    rungs = np.array([pace.rung for pace in paces])
    assert np.count_nonzero(np.diff(rungs[100:])) <= 10


def test_what_is_reached_is_in_time():
    for each_ms in 10.0 ** np.linspace(-6, -3.6, 13):
        rung = run(5.0, each_ms, each_ms, 300)[-1].drawn(1.0)
        width, height = scaled(SIZE_PX, rung.scale)
        spent = Cost(5.0, each_ms, each_ms).of(width * height, rung.step)
        assert spent <= 1.3 * TARGET_MS or rung == Pace(FLOOR).drawn(1.0)


def test_slow_links_cost_quality_first_then_size_and_give_both_back():
    pace = Pace(rung=0)
    qualities = []
    for trip_ms in [200.0] * 8 + [10.0] * 60:
        pace = after_trip(pace, trip_ms)
        qualities.append(pace.quality)
    assert (qualities[0], qualities[7], qualities[-1]) == (80, 60, 80)
    assert Pace(rung=0, link=2).drawn(1.0).scale == RUNGS[HALF].scale == 0.5
    alternating = Pace()
    for trip_ms in [100.0, 60.0] * 50:
        alternating = after_trip(alternating, trip_ms)
    assert alternating.link == 0


def test_rest_makes_a_view_try_again_sooner():
    assert at_rest(Pace(rung=3, slow=1, quick=7, patience=64)) == Pace(rung=3, patience=QUICK_FRAMES)
