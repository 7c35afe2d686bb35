"""Transfer functions chosen for what a survey found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..labels.style import distinct_colours
from ..transfer import TransferFunction
from ..volume import FloatArray, Volume
from .survey import Survey

Point = tuple[float, tuple[float, float, float] | str, float]

SOLID_PER_VOXEL = 3.0
"""Optical depth of a voxel of what is opaque: less lets the light of deeper samples through, and rings show."""
LABEL_PER_VOXEL = 1.0
"""Less, since the slab before a label's surface has the colour of the mean of two labels."""
NARROWEST = 1 / 30
"""Least width of a segment as a share of the function's domain: tables for light along slabs grow with narrow ones."""

FLESH = ("#b07c60", "#dcae90", "#edd6bc", "#f8f0e4")
STONE = ("#978f82", "#c6bca8", "#e4d9c2", "#f8f0dd")
GLOW = ("#30105c", "#8c2369", "#d84c3e", "#fba40a", "#fcf6a0")
SKIN, BONE = "#e0a584", "#f0e2c8"


def chosen_function(volume: Volume, found: Survey) -> TransferFunction:
    """Transfer function that shows what was found."""
    if found.dark:
        negated = chosen_function(volume, replace(found, samples=-found.samples, dark=False))
        return TransferFunction([(-value, colour, extinction) for value, colour, extinction in negated.points[::-1]])
    spacing = float(np.prod(volume.spacing) ** (1 / 3))
    solid = SOLID_PER_VOXEL / min(volume.spacing)
    if found.kind == "empty":
        return TransferFunction([(0.0, "white", 0.0)])
    if found.kind == "constant":
        return TransferFunction([(found.background, STONE[1], 2.0 / way_through(volume))])
    if found.kind == "mask":
        return _mask(found, solid)
    if found.kind == "labels":
        return _labels(found, LABEL_PER_VOXEL / min(volume.spacing))
    if found.kind == "ct":
        return _ct(found, spacing)
    if found.kind == "signed":
        return _signed(found, way_through(volume))
    if found.kind == "object":
        return _object(found, solid, FLESH if volume.anatomical else STONE)
    return _cloud(found, way_through(volume), min(volume.spacing))


def way_through(volume: Volume) -> float:
    """Way through the volume, about: the geometric mean of its sides."""
    return float(np.prod([n * s for n, s in zip(volume.size, volume.spacing, strict=True)]) ** (1 / 3))


def _mask(found: Survey, solid: float) -> TransferFunction:
    low, high = found.labels
    # The surface lies halfway between the two values; wide enough for a small table, narrow enough to be a surface.
    width = (high - low) * 0.1
    middle = (high + low) / 2
    return TransferFunction([(middle - width, STONE[1], 0.0), (middle + width, STONE[2], solid), (high, STONE[2], solid)])


def _labels(found: Survey, solid: float) -> TransferFunction:
    points: list[Point] = []
    for label, (r, g, b) in zip(found.labels, distinct_colours(found.labels).tolist(), strict=True):
        if label == found.labels[0]:
            points += [(label, (0.0, 0.0, 0.0), 0.0), (label + 0.5, (0.0, 0.0, 0.0), 0.0)]
            continue
        points += [(label - 0.5, (r, g, b), solid), (label + 0.5, (r, g, b), solid)]
    return TransferFunction(points)


def _ct(found: Survey, spacing: float) -> TransferFunction:
    if float((found.values > 250).mean()) < 5e-4:
        return _ct_without_bone(spacing)
    # Skin is crossed within a voxel or two whatever their size: its opacity is that of a voxel, not of a millimetre.
    skin = 0.15 / spacing
    solid = 0.8 * SOLID_PER_VOXEL / spacing
    return TransferFunction(
        [
            (-560, SKIN, 0.0),
            (-420, SKIN, skin),
            (-260, SKIN, skin),
            (-150, SKIN, 0.0),
            (130, "#c08a68", 0.0),
            (250, "#e3c39c", 0.25 * solid),
            (420, BONE, solid),
            (1400, "#ffffff", 1.5 * solid),
        ]
    )


def _ct_without_bone(spacing: float) -> TransferFunction:
    solid = 1.2 / spacing
    return TransferFunction(
        [(-60, "#8c4a3c", 0.0), (10, "#a8645a", 0.3 * solid), (50, "#d8a090", 0.7 * solid), (120, "#f4dcd0", solid)]
    )


def _signed(found: Survey, extent: float) -> TransferFunction:
    magnitude = np.abs(found.values)
    magnitude = magnitude[magnitude > 0]
    high = float(np.percentile(magnitude, 99.7))
    low = max(float(np.percentile(magnitude, 70)), 0.06 * high)
    at = levels(low, high, 3)
    depths = (0.0, 12.0, 40.0, 90.0)
    warm, cool = ("#6a2410", "#c8502a", "#f09a50", "#ffe2b0"), ("#102a6a", "#2a6ac0", "#58b4e8", "#c8f0ff")
    below: list[Point] = [(-v, c, d / extent) for v, c, d in zip(at, cool, depths, strict=True)]
    above: list[Point] = [(v, c, d / extent) for v, c, d in zip(at, warm, depths, strict=True)]
    return TransferFunction([*below[::-1], *above])


def _object(found: Survey, solid: float, colours: tuple[str, ...]) -> TransferFunction:
    values = found.values
    inside = values[values > found.begin]
    high = float(np.percentile(inside, 99)) if inside.size else found.begin + 1
    full = found.begin + 0.5 * (found.peaks[0] - found.begin)
    high = max(high, full + 0.3 * (full - found.begin))
    begin = min(found.begin - 0.25 * (full - found.begin), full - NARROWEST * (high - full))
    begin = max(begin, found.noise_top) if found.noise_top < full else begin
    full = max(full, begin + 1.2 * NARROWEST * (high - begin))
    middle = full + 0.45 * (high - full)
    return TransferFunction(
        [
            (begin, colours[0], 0.0),
            (full, colours[1], solid),
            (middle, colours[2], 1.1 * solid),
            (high, colours[3], 1.2 * solid),
        ]
    )


def _cloud(found: Survey, extent: float, spacing: float) -> TransferFunction:
    values = found.values
    above = values[values > found.begin]
    high = float(np.percentile(above, 98)) if above.size else found.begin
    if high <= found.begin:
        low, high = found.known.minimum, found.known.maximum
    else:
        low = found.begin
    at = levels(low, high, 4)
    depths = (0.0, 6.0, 20.0, 50.0, 90.0)
    return TransferFunction([(v, c, d / extent) for v, c, d in zip(at, GLOW, depths, strict=True)])


def levels(low: float, high: float, count: int) -> FloatArray:
    """Values from low to high, closer at the low end; no segment is narrower than a small table can hold."""
    return low + (high - low) * np.linspace(0, 1, count + 1) ** 1.4
