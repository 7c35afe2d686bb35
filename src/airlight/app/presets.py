"""Transfer functions made ready, by name. Values are Hounsfield units for CT; extinctions are per millimetre."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ValueRangeError
from ..transfer import TransferFunction
from ..volume import Volume, statistics

MILLIMETRES = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "nm": 1e-6, "cm": 10.0, "m": 1000.0}
Point = tuple[float, str, float]


@dataclass(frozen=True)
class Preset:
    """Points of a function; ``relative`` ones have values in percent of the data's robust range (percentiles 0.5 to 99.5)."""

    points: tuple[Point, ...]
    relative: bool = False


PRESETS: dict[str, Preset] = {
    "ct-bone": Preset(((150, "#8c5a3c", 0.0), (280, "#d8b48c", 0.05), (600, "#f4e8d0", 0.6), (1600, "#ffffff", 1.6))),
    "ct-skin": Preset(((-400, "#b9785a", 0.0), (-150, "#e2ac8b", 0.25), (100, "#f0c8ac", 0.4), (1200, "#fff4e8", 0.6))),
    "ct-muscle": Preset(
        (
            (-50, "#7a2418", 0.0),
            (40, "#a83c2c", 0.04),
            (120, "#c8543c", 0.06),
            (260, "#e0b890", 0.1),
            (600, "#f4e8d0", 0.6),
            (1600, "#ffffff", 1.2),
        )
    ),
    "ct-lung": Preset(
        (
            (-1000, "black", 0.0),
            (-900, "#304878", 0.0),
            (-700, "#6c94c8", 0.012),
            (-500, "#c8a090", 0.03),
            (-350, "#d8b0a0", 0.0),
        )
    ),
    "xray": Preset(((-500, "white", 0.0), (0, "white", 0.002), (400, "white", 0.008), (2000, "white", 0.04))),
    "grey": Preset(((0, "black", 0.0), (100, "white", 0.2)), relative=True),
    "warm": Preset(
        ((5, "#200800", 0.0), (25, "#802808", 0.01), (50, "#e07020", 0.05), (75, "#f8d070", 0.15), (100, "#ffffff", 0.4)),
        relative=True,
    ),
}


def preset_function(name: str, volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Return the preset's function, with extinctions per world unit of the volume and relative values resolved."""
    if name not in PRESETS:
        raise ValueRangeError("--preset", f"is {name!r}, must be one of {', '.join(PRESETS)}")
    preset = PRESETS[name]
    scale = MILLIMETRES.get(volume.units, 1.0)
    low, span = 0.0, 1.0
    if preset.relative:
        known = statistics(volume, channel, time)
        low = known.percentile(0.5)
        span = (known.percentile(99.5) - low or 1.0) / 100
        # What these describe is seen through as a whole: opacity goes by the size of the object, not by millimetres.
        extent = max(n * s for n, s in zip(volume.size, volume.spacing, strict=True))
        scale = 200.0 / extent
    return TransferFunction([(low + value * span, colour, extinction * scale) for value, colour, extinction in preset.points])


def projection_function(volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Black to white over the robust range: what projections of values are shown with."""
    known = statistics(volume, channel, time)
    low, high = known.percentile(0.5), known.maximum
    return TransferFunction([(low, "black", 0.0), (max(high, low), "white", 1.0)])
