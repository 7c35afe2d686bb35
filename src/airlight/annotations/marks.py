"""What is written on a picture, as values: texts, bars and patches in pixels from its upper left corner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

Colour3 = tuple[float, float, float]
Box = tuple[float, float, float, float]

PLAIN = str.maketrans({"μ": "µ", "Å": "A", "å": "a", "²": "2", "³": "3", "–": "-", "−": "-", "×": "x"})
"""What stands for signs that Pillow's font has not."""
SMALL_PX = 16


@dataclass(frozen=True)
class Text:
    """Words of a height, whose anchor (as Pillow names it) lies at a point."""

    x_px: float
    y_px: float
    words: str
    size_px: int
    rgb: Colour3
    anchor: str = "mm"

    @property
    def box(self) -> Box:
        """Left, upper, right and lower border [px]."""
        left, top, right, bottom = font_of(self.size_px).getbbox(spelled(self.words, self.size_px), anchor=self.anchor)
        return self.x_px + left, self.y_px + top, self.x_px + right, self.y_px + bottom


@dataclass(frozen=True)
class Bar:
    """A rectangle; its borders may lie within pixels."""

    left: float
    top: float
    right: float
    bottom: float
    rgb: Colour3

    @property
    def box(self) -> Box:
        """Left, upper, right and lower border [px]."""
        return self.left, self.top, self.right, self.bottom


@dataclass(frozen=True, eq=False)
class Patch:
    """Pixels (h, w, 4), premultiplied linear light, whose upper left corner is a pixel."""

    left: int
    top: int
    rgba: npt.NDArray[np.float32]

    @property
    def box(self) -> Box:
        """Left, upper, right and lower border [px]."""
        height, width = self.rgba.shape[:2]
        return self.left, self.top, self.left + width, self.top + height


Mark = Text | Bar | Patch


@lru_cache(maxsize=16)
def font_of(size_px: int) -> Any:
    """The font that comes with Pillow, of a height."""
    from PIL import ImageFont

    return ImageFont.load_default(size_px)


def width_of(words: str, size_px: int) -> float:
    """Width of words [px]."""
    return float(font_of(size_px).getlength(spelled(words, size_px)))


def spelled(words: str, size_px: int) -> str:
    """Words in the signs of the font: it knows those of ASCII, and a few beside them; others become question marks.

    Small sizes have two spaces for one, of two or three pixels, which would not be seen.
    """
    plain = words.translate(PLAIN)
    plain = plain.replace(" ", "  ") if size_px <= SMALL_PX else plain
    return "".join(c if " " <= c <= "~" or c in "°±·" else "u" if c == "µ" else "?" for c in plain)
