"""A bar of a round length."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ..stages.camera import Orthographic
from ..transfer.colour import Colour
from ..transfer.given import positive, set_fields
from .base import Annotation, Drawn, Room, View, colour_or_none, number_text, round_below
from .marks import Bar, Text, width_of

SHARE = 0.28
"""Most of the image's width that the bar takes."""
UNITS = ("nm", "um", "mm", "m", "km")
"""Units, each a thousand of the one before, of which the one is chosen that makes numbers short."""


@dataclass(frozen=True)
class ScaleBar(Annotation):
    """How long a round length of the world is in the image, at its lower left.

    Of an orthographic camera it holds everywhere. Of a perspective one it holds in the plane through the camera's target, which
    is written beside it: what is nearer is larger. Panoramas and domes have none: their pixels are angles, and no length holds
    for all of the image.

    Parameters
    ----------
    length
        In world units; None takes a round one, at most 0.28 of the image's width.
    color
        None: light on dark backgrounds, dark on light ones.
    """

    kind: ClassVar[str] = "scale_bar"
    rank: ClassVar[int] = 2
    length: float | None = None
    color: Colour | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        length = None if self.length is None else positive(self.length, "scale_bar.length")
        set_fields(self, length=length, color=colour_or_none(self.color, "scale_bar.color"))

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return the bar with its length above it."""
        view.check_flat(self.kind)
        exact = isinstance(view.camera, Orthographic)
        pixel = view.pixel_world(0.0 if exact else math.dist(view.camera.eye, view.camera.target))
        length = round_below(SHARE * view.size_px[0] * pixel) if self.length is None else self.length
        rgb, size, margin = colour_or_none(self.color, "") or view.ink, view.text_px, view.margin_px
        words = f"{length_text(length, view.unit)}{'' if exact else ' at target'}"
        wide, words_wide = length / pixel, width_of(words, size)
        left = margin
        below = view.size_px[1] - margin
        bar = Bar(left, below - max(2, round(size / 6)), left + wide, below, rgb)
        middle = max(left + wide / 2, left + words_wide / 2)
        marks = bar, Text(middle, bar.top - round(0.35 * size), words, size, rgb, "ms")
        room.take(marks)
        told = {"length": length, "unit": view.unit, "pixels": wide, "holds": "everywhere" if exact else "at the target"}
        return Drawn(marks=marks, told=told)


def length_text(length: float, unit: str) -> str:
    """A length as it is written, in a unit that makes its number short."""
    if unit in UNITS:
        steps = min(max(math.floor(math.log10(length) / 3 + 1e-9), -UNITS.index(unit)), len(UNITS) - 1 - UNITS.index(unit))
        length, unit = length / 1000.0**steps, UNITS[UNITS.index(unit) + steps]
    return f"{number_text(length)} {unit_text(unit)}".strip()


def unit_text(unit: str) -> str:
    """A unit as it is written."""
    return "µm" if unit == "um" else unit
