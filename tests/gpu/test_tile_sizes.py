"""Tiles: how many pixels a dispatch draws."""

from __future__ import annotations

import pytest

from airlight.gpu.tiles import FIRST_TILE_PIXELS, TILE_SECONDS, Pace, tiles

SIDE = 256


def drawn(pace: Pace, rate: float) -> list[int]:
    """Pixels of the tiles of a frame that is drawn at a rate [pixels/s]."""
    pace.begin()
    found = []
    for tile in tiles(SIDE, 0, SIDE, pace):
        found.append(tile.width * tile.height)
        pace.learn(found[-1], found[-1] / rate)
    return found


def test_a_frame_begins_small_until_one_is_known():
    pace, rate = Pace(), 2.2 * FIRST_TILE_PIXELS / TILE_SECONDS
    first, second = drawn(pace, rate), drawn(pace, rate)
    assert sum(first) == sum(second) == SIDE * SIDE
    assert first[0] == FIRST_TILE_PIXELS < second[0] <= rate * TILE_SECONDS
    assert len(second) < len(first)


def test_what_was_quick_at_the_end_does_not_make_the_next_frame_begin_large():
    pace = Pace()
    pace.begin()
    for rate in (1e6, 1e8, 1e8):
        pace.learn(FIRST_TILE_PIXELS, FIRST_TILE_PIXELS / rate)
    pace.learn(64, 1.0)  # too few to tell
    pace.begin()
    assert pace.slowest == pytest.approx(1e6)
    assert next(tiles(SIDE, 0, SIDE, pace)).height * SIDE <= 1e6 * TILE_SECONDS
