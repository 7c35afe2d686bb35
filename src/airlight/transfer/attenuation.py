"""Functions that say how X-rays are attenuated, and how deep a volume is to them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import ValueRangeError
from ..volume import FloatArray, Volume, is_empty
from .colour import Colour
from .given import finite

if TYPE_CHECKING:
    from .function import TransferFunction

WATER_PER_MM = 0.0206
"""Linear attenuation coefficient of water [1/mm] for photons of 60 keV (NIST, 0.2059 cm^2/g), about the mean of a CT's."""
GREATEST_HU = 3071.0
MOST_SAMPLES = 64
KEPT = 4
DEEPEST_PERCENT = 99.5


def from_hounsfield(
    cls: type[TransferFunction],
    water: float = WATER_PER_MM,
    *,
    greatest: float = GREATEST_HU,
    colour: Colour = "white",
) -> TransferFunction:
    """Return the linear attenuation coefficient ``water * (1 + HU / 1000)``, none below -1000 HU.

    Parameters
    ----------
    water
        That of water, per world unit: 0.0206 for 60 keV and a world in millimetres; the default.
    greatest
        Value [HU] beyond which it stays the same.
    colour
        Colour of all of it.

    Raises
    ------
    ValueRangeError
        When ``water`` or ``greatest`` is out of range.
    """
    if finite(water, "transfer.from_hounsfield.water") <= 0:
        raise ValueRangeError("transfer.from_hounsfield.water", f"is {water}, must be above 0")
    if finite(greatest, "transfer.from_hounsfield.greatest") <= -1000:
        raise ValueRangeError("transfer.from_hounsfield.greatest", f"is {greatest}, must be above -1000 HU")
    return cls([(-1000.0, colour, 0.0), (float(greatest), colour, water * (1 + greatest / 1000))])


def greatest_depth(volume: Volume, function: TransferFunction, channel: int, time: int, *, of_source: bool = False) -> float:
    """Optical depth of the deepest ways straight through a volume along its axes; 1 where there is none.

    The 99.5th percentile of the ways along each axis, of at most 64 samples each way; the greatest of the three. ``of_source``
    asks for the brightest channel of the source instead. Kept with the volume for the last few functions.
    """
    kept: dict[tuple[TransferFunction, int, int, bool], float] = volume.__dict__.setdefault("_greatest_depths", {})
    key = (function, channel, time, of_source)
    if key not in kept:
        while len(kept) >= KEPT:
            del kept[next(iter(kept))]
        kept[key] = _deepest(volume, function, channel, time, of_source)
    return kept[key]


def _deepest(volume: Volume, function: TransferFunction, channel: int, time: int, of_source: bool) -> float:
    grid = volume.grid(channel, time)
    strides = tuple(max(1, n // MOST_SAMPLES) for n in grid.shape)
    part = grid[tuple(slice(stride // 2, None, stride) for stride in strides)]
    empty = is_empty(part, volume.no_data)
    values = part.astype(np.float64) if empty is None else np.where(empty, 0.0, part).astype(np.float64)
    density: FloatArray = function.source(values).max(axis=-1) if of_source else function(values)[1]
    if empty is not None:
        density = np.where(empty, 0.0, density)
    ways = (n * s for n, s in zip(grid.shape, volume.spacing[::-1], strict=True))
    depths = [float(np.percentile(density.mean(axis=axis) * way, DEEPEST_PERCENT)) for axis, way in enumerate(ways)]
    return max(depths) or 1.0
