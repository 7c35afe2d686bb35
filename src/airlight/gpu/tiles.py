"""Tiles: dispatches of about 25 ms, so that frames can be cancelled and weak GPUs are not reset."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from .device import Device

TILE_SECONDS = 0.025
FIRST_TILE_PIXELS = 1 << 14


@dataclass(frozen=True)
class Tile:
    """A rectangle of pixels, x and y of its first pixel and its size."""

    x: int
    y: int
    width: int
    height: int


@dataclass
class Pace:
    """Pixels a second of one kind of work, measured as it goes; ``first`` of them are drawn to begin with.

    ``slowest`` is the least rate of the frame before: with what that can do the next one may begin.
    """

    first: int = FIRST_TILE_PIXELS
    pixels_per_second: float = 0.0
    slowest: float = 0.0
    _least: float = math.inf

    def begin(self) -> None:
        """A frame begins."""
        self.slowest = self._least if self._least < math.inf else self.slowest
        self._least = math.inf

    def pixels(self) -> int:
        """Pixels that take about ``TILE_SECONDS``."""
        return max(64, int(self.pixels_per_second * TILE_SECONDS)) if self.pixels_per_second else self.first

    def learn(self, pixels: int, seconds: float) -> None:
        """Take a measurement in; rays differ, so it is averaged."""
        rate = pixels / max(seconds, 1e-5)
        if pixels >= FIRST_TILE_PIXELS // 2:  # smaller ones tell of what each tile costs
            self._least = min(self._least, rate)
        self.pixels_per_second = rate if not self.pixels_per_second else 0.5 * (self.pixels_per_second + rate)


def tiles(width: int, first_row: int, rows: int, pace: Pace, least_rows: int = 1) -> Iterator[Tile]:
    """Cover rows of an image with tiles of the pace's size: whole rows, or parts of the least number of them."""
    y = first_row
    # Begin small, unless the last frame is known, and at most double: what is drawn first may be the background.
    most = max(FIRST_TILE_PIXELS, int(pace.slowest * TILE_SECONDS))
    while y < first_row + rows:
        pixels = min(pace.pixels(), most)
        most = 2 * pixels
        if pixels >= width * least_rows:
            height = min(pixels // width, first_row + rows - y)
            yield Tile(0, y, width, height)
            y += height
            continue
        x, height = 0, min(least_rows, first_row + rows - y)
        while x < width:
            part = min(max(pace.pixels() // height, 64), FIRST_TILE_PIXELS, width - x)
            yield Tile(x, y, part, height)
            x += part
        y += height


def run_tiles(
    device: Device,
    parts: Iterator[Tile],
    submit: Callable[[Tile], None],
    pace: Pace,
    check: Callable[[], None],
    progress: Callable[[int], None],
) -> None:
    """Submit tile by tile and wait for each; ``check`` may raise between them, ``progress`` gets the pixels done."""
    done = 0
    pace.begin()
    for tile in parts:
        check()
        start = time.perf_counter()
        submit(tile)
        device.wait()
        pixels = tile.width * tile.height
        pace.learn(pixels, time.perf_counter() - start)
        done += pixels
        progress(done)
