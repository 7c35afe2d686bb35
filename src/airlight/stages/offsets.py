"""Shifts of the lattice of samples from pixel to pixel, as shares of a step, and from frame to frame."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..volume import FloatArray

NONE = np.zeros((1, 1))
INTERLEAVED = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]]) / 16
TILE_PX = 64
SPREAD_PX = 1.5  # of the filter by which holes and clusters are told (Ulichney 1993, section 3)
GOLDEN_RATIO = (5**0.5 - 1) / 2


@lru_cache(maxsize=4)
def blue_noise(side: int = TILE_PX, seed: int = 1) -> FloatArray:
    """Tile (side, side) of the numbers k / side^2, each once, such that pixels with numbers below any bound lie evenly spread.

    Void and cluster: R. Ulichney, "The void-and-cluster method for dither array generation", 1993. It repeats in x and y.
    """
    places = np.minimum(np.arange(side), side - np.arange(side))
    bump = np.exp(-(places[:, None] ** 2 + places**2) / (2 * SPREAD_PX**2))
    bumps = np.tile(bump, (2, 2))
    crowd = np.zeros((side, side))
    taken = np.zeros((side, side), dtype=bool)

    def around(flat: int) -> FloatArray:
        y, x = divmod(flat, side)
        return bumps[side - y : 2 * side - y, side - x : 2 * side - x]

    def put(flat: int, there: bool) -> None:
        taken.flat[flat] = there
        crowd[...] += around(flat) if there else -around(flat)

    def tightest() -> int:
        return int(np.where(taken, crowd, -np.inf).argmax())

    def widest_hole() -> int:
        return int(np.where(taken, np.inf, crowd).argmin())

    # Spread a tenth of the pixels: move one from the tightest cluster into the widest hole, while that changes something.
    for flat in np.random.default_rng(seed).choice(side * side, side * side // 10, replace=False):
        put(int(flat), True)
    while True:
        moved = tightest()
        put(moved, False)
        hole = widest_hole()
        put(hole, True)
        if hole == moved:
            break

    # Number these from the last on, then fill the holes.
    ranks = np.zeros(side * side)
    first, sparse, spread = int(taken.sum()), taken.copy(), crowd.copy()
    for rank in reversed(range(first)):
        ranks[flat := tightest()] = rank
        put(flat, False)
    taken[...], crowd[...] = sparse, spread
    for rank in range(first, side * side):
        ranks[flat := widest_hole()] = rank
        put(flat, True)
    return ranks.reshape(side, side) / side**2


@lru_cache(maxsize=1)
def blue_noise_texels() -> npt.NDArray[np.float32]:
    """The tile as texels (1, side, side / 4, 4) of four pixels of a row each."""
    return blue_noise().astype(np.float32).reshape(1, TILE_PX, TILE_PX // 4, 4)


def fraction_of_frame(shift: int) -> float:
    """Shift of all pixels in a frame with this number: those of any frames in a row lie evenly between 0 and 1."""
    return float(shift * GOLDEN_RATIO % 1.0)
