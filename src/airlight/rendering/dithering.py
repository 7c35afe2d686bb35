"""Pictures in steps of 8 bits: rounded, or dithered so that slow ramps show no bands."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..stages.offsets import blue_noise

EXACT = 1 / 1024  # of a step: what is so close to one keeps it, so that plain colours stay plain


def bytes_of(unit: npt.NDArray[Any], dither: bool = False) -> npt.NDArray[np.uint8]:
    """uint8 of numbers (height, width, ...) in [0, 1].

    Dithered numbers are rounded up in as many pixels as they lie above a step, which blue noise chooses: the mean stays, and
    what is wrong is too fine to be seen. All channels are rounded by the same noise, so that grey stays grey.
    """
    steps = unit * 255.0
    if not dither:
        return (steps + 0.5).astype(np.uint8)
    return (steps + _noise(unit.shape[:2]).reshape(*unit.shape[:2], *[1] * (unit.ndim - 2))).astype(np.uint8)


def _noise(shape: tuple[int, int]) -> npt.NDArray[np.float32]:
    """Noise between 0 and 1, evenly spread, as far from both as steps are exact."""
    tile = blue_noise()
    side = len(tile)
    even = EXACT + (1 - 2 * EXACT) * (tile + 0.5 / side**2)
    return np.tile(even, [-(-n // side) for n in shape])[: shape[0], : shape[1]].astype(np.float32)
