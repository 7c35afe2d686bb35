"""Helpers of the tests in a browser: a small volume, what a page shows, and waiting."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import airlight as al


def small_volume() -> al.Volume:
    """Two balls, of values up to 100 and 60, in millimetres of a patient."""
    z, y, x = np.mgrid[0:20, 0:20, 0:20].astype(np.float64)
    balls = 100 * np.exp(-((x - 6) ** 2 + (y - 10) ** 2 + (z - 10) ** 2) / 12)
    balls += 60 * np.exp(-((x - 14) ** 2 + (y - 10) ** 2 + (z - 12) ** 2) / 8)
    return al.Volume(balls.astype(np.float32), spacing=(2, 2, 2), units="mm", anatomical=True)


def picture_of(page: Any) -> np.ndarray[Any, Any]:
    """Bytes of the picture as the page shows it."""
    found = page.locator("canvas.picture").evaluate(
        "c => Array.from(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.filter((_, n) => n % 16 < 3))"
    )
    return np.array(found, dtype=np.uint8)


def until(done: Callable[[], Any], seconds: float = 60.0) -> Any:
    """Wait until something is neither None nor False, and return it."""
    end = time.monotonic() + seconds
    while (found := done()) is None or found is False:
        if time.monotonic() > end:
            pytest.fail(f"did not happen within {seconds} s")
        time.sleep(0.05)
    return found


def session_of(showing: Any) -> Any:
    """The session that was opened last."""
    return next(reversed(showing.viewer.sessions.values()))


def rested(session: Any, seconds: float = 0.5) -> Any:
    """The session, once its page has sent nothing more for a while."""
    seen, since = -1, time.monotonic()
    while time.monotonic() - since < seconds:
        if session.inputs != seen:
            seen, since = session.inputs, time.monotonic()
        time.sleep(0.05)
    return session


def pixel_within(image: al.Image, margin_px: int = 6) -> tuple[int, int]:
    """Column and row of a pixel that shows something, as all around it do: finer pictures of the scene show it there, too."""
    width_px = 2 * margin_px + 1
    around = np.lib.stride_tricks.sliding_window_view(np.isfinite(image.depth), (width_px, width_px))
    found = np.argwhere(around.all(axis=(2, 3))) + margin_px
    row, column = found[len(found) // 2].tolist()
    return column, row
