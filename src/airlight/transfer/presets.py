"""Named transfer functions: CT in Hounsfield units, others by the data's own robust range."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ValueRangeError
from ..volume import Volume, statistics
from .function import TransferFunction

Points = tuple[tuple[float, str, float], ...]

MM_PER_UNIT = {"": 1.0, "mm": 1.0, "m": 1e3, "cm": 10.0, "dm": 100.0, "um": 1e-3, "µm": 1e-3, "nm": 1e-6, "inch": 25.4}
OTHER_UNIT_MM = 1.0
ROBUST_PERCENT = (1.0, 99.8)


@dataclass(frozen=True)
class Preset:
    """Points of a function, with the meaning of their values and extinctions.

    Attributes
    ----------
    summary
        What it shows, in a few words.
    points
        ``(value, sRGB colour, extinction)``.
    relative
        False: values in Hounsfield units, extinctions per millimetre. True: values as shares of the robust range, extinctions
        as optical depths of the whole object.
    colormap
        Colours come from this map over the robust range, and not from the points.
    """

    summary: str
    points: Points
    relative: bool = False
    colormap: str = ""


GLOW: Points = ((0.1, "black", 0.0), (0.3, "black", 2.5), (0.5, "black", 10.0), (0.75, "black", 30.0), (1.0, "white", 60.0))
"""Faint where values are low: what is bright is seen through what is dim."""


PRESETS: dict[str, Preset] = {
    "ct_bone": Preset(
        "bones alone",
        ((150, "#a3704f", 0.0), (260, "#d9b48c", 0.12), (450, "#efdfc0", 0.9), (900, "#f7efdf", 1.6), (1500, "#ffffff", 2.0)),
    ),
    "ct_soft_tissue": Preset(
        "muscles and organs with the bones behind them, fat left out",
        (
            (5, "#7a2a22", 0.0),
            (40, "#a84438", 0.06),
            (80, "#c96a55", 0.16),
            (120, "#dc8a66", 0.3),
            (160, "#eeb070", 0.5),
            (220, "#f2d2a0", 0.8),
            (350, "#f3e6cc", 1.4),
            (1200, "#ffffff", 2.0),
        ),
    ),
    "ct_skin": Preset(
        "the skin, opaque",
        ((-600, "#c08a6e", 0.0), (-400, "#d9a384", 0.5), (-150, "#e5b699", 1.2), (300, "#efcdb4", 1.5), (1200, "#fff4e8", 2.0)),
    ),
    "ct_lung": Preset(
        "lungs with their vessels, under a faint skin",
        (
            (-940, "#24407c", 0.0),
            (-870, "#4870b8", 0.012),
            (-720, "#88b0e8", 0.022),
            (-580, "#f0b0a0", 0.03),
            (-350, "#e8b8a4", 0.012),
            (-200, "#e8c8b8", 0.0),
        ),
    ),
    "ct_airways": Preset(
        "airways, sinuses and gas, as if of glass",
        (
            (-850, "#2c78a8", 0.0),
            (-700, "#58b0e0", 0.03),
            (-500, "#c0ecff", 0.045),
            (-350, "#ffffff", 0.02),
            (-250, "#ffffff", 0.0),
        ),
    ),
    "ct_vessels": Preset(
        "vessels with contrast medium, and bones",
        (
            (110, "#80180c", 0.0),
            (170, "#b02a1a", 0.06),
            (280, "#e04a30", 0.22),
            (380, "#e8906c", 0.3),
            (480, "#f0d8b0", 0.7),
            (800, "#f6ecd8", 1.4),
            (1500, "#ffffff", 2.0),
        ),
    ),
    "mri": Preset(
        "the head or body as a whole",
        (
            (0.16, "#a87458", 0.0),
            (0.26, "#d0a084", 60.0),
            (0.45, "#e2bda2", 120.0),
            (0.7, "#f0dccb", 160.0),
            (1.0, "#ffffff", 200.0),
        ),
        relative=True,
    ),
    "mri_brain": Preset(
        "a brain without its skull",
        (
            (0.25, "#7c3c38", 0.0),
            (0.4, "#b87468", 60.0),
            (0.6, "#d8a898", 160.0),
            (0.8, "#f0dcd0", 220.0),
            (1.0, "#ffffff", 260.0),
        ),
        relative=True,
    ),
    "microscopy": Preset(
        "bright structures before a dark background, glowing",
        (
            (0.15, "#1b0c41", 0.0),
            (0.3, "#781c6d", 2.5),
            (0.5, "#cf4446", 10.0),
            (0.75, "#f8a12c", 30.0),
            (1.0, "#fcffa4", 60.0),
        ),
        relative=True,
    ),
    "microscopy_green": Preset("one dye in green, as under the microscope", GLOW, relative=True, colormap="green"),
    "microscopy_magenta": Preset("one dye in magenta, to go with a green one", GLOW, relative=True, colormap="magenta"),
    "microscopy_ice": Preset("from deep blue to white", GLOW, relative=True, colormap="cmocean:ice"),
    "xray": Preset(
        "as an X-ray picture: all is seen through",
        ((0.05, "#ffffff", 0.0), (0.5, "#ffffff", 1.0), (1.0, "#ffffff", 4.0)),
        relative=True,
    ),
}


def names() -> tuple[str, ...]:
    """Names of the presets."""
    return tuple(PRESETS)


def describe(name: str) -> str:
    """What a preset shows, and what its values mean."""
    preset = _preset(name)
    return f"{preset.summary} ({'by the robust range of the data' if preset.relative else 'Hounsfield units'})"


def get(name: str, volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Transfer function of a preset for a volume, with extinctions per world unit of the volume.

    Parameters
    ----------
    name
        One of ``names()``; ``-`` may stand for ``_``.
    volume
        Its unit of length, its size and its range are looked at. Without a unit, one is a millimetre.
    channel, time
        What the function is for.

    Raises
    ------
    ValueRangeError
        For an unknown name; it lists the known ones.
    """
    preset = _preset(name)
    if not preset.relative:
        # Lengths without a fixed size, like "bohr", say nothing of millimetres.
        millimetres = MM_PER_UNIT.get(volume.units, OTHER_UNIT_MM)
        return TransferFunction([(value, colour, extinction * millimetres) for value, colour, extinction in preset.points])
    (low, high), extent = _robust_range(volume, channel, time), _extent(volume)
    points = [(low + share * (high - low), colour, depth / extent) for share, colour, depth in preset.points]
    if preset.colormap:
        return TransferFunction.from_colormap(preset.colormap, (low, high), [(value, tau) for value, _, tau in points])
    return TransferFunction(points)


def glowing(colormap: str, volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Transfer function with the colours of a named map over the robust range of a volume, faint where values are low.

    Parameters
    ----------
    colormap
        See ``TransferFunction.from_colormap``.
    volume
        Its size and its range are looked at.
    channel, time
        What the function is for.

    Raises
    ------
    ValueRangeError
        For an unknown map; it lists close ones.
    """
    (low, high), extent = _robust_range(volume, channel, time), _extent(volume)
    extinctions = [(low + share * (high - low), depth / extent) for share, _, depth in GLOW]
    return TransferFunction.from_colormap(colormap, (low, high), extinctions)


def _robust_range(volume: Volume, channel: int | str, time: int) -> tuple[float, float]:
    known = statistics(volume, channel, time)
    low, high = (known.percentile(p) for p in ROBUST_PERCENT)
    return (low, high) if high > low else (known.minimum, max(known.maximum, known.minimum + 1))


def _extent(volume: Volume) -> float:
    return max(n * s for n, s in zip(volume.size, volume.spacing, strict=True))


def _preset(name: str) -> Preset:
    preset = PRESETS.get(name.replace("-", "_"))
    if preset is None:
        raise ValueRangeError("preset", f"is {name!r}, must be one of {', '.join(PRESETS)}")
    return preset
