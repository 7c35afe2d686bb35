"""Marks drawn over a picture: smooth, with a halo that keeps them readable on any ground."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from .marks import PLAIN, Bar, Colour3, Mark, Patch, Text, font_of, spelled

FloatImage = npt.NDArray[np.float32]

HALOS = {0.0: 0.85, 1.0: 0.5}
"""Opacities of black and of white halos: in linear light, white ones outshine what they lie on sooner."""
THICKER = 0.55
"""Power of the shares under dark ink: mixed in linear light, thin dark strokes would look thinner than light ones."""


def overlay(marks: Iterable[Mark], size_px: tuple[int, int]) -> FloatImage:
    """Pixels (h, w, 4) of marks on nothing, premultiplied linear light; later ones lie over earlier ones."""
    canvas = np.zeros((size_px[1], size_px[0], 4), dtype=np.float32)
    for mark in marks:
        if isinstance(mark, Patch):
            _put(canvas, mark.left, mark.top, mark.rgba)
            continue
        halo, ink, left, top = _written(mark) if isinstance(mark, Text) else _barred(mark)
        if luminance(mark.rgb) < 0.18:
            ink = ink**THICKER
        around = opposite(mark.rgb)
        for cover, rgb in ((HALOS[around[0]] * halo, around), (ink, mark.rgb)):
            _put(canvas, left, top, cover[..., None] * np.array([*rgb, 1.0], dtype=np.float32))
    return canvas


def over(front: FloatImage, behind: FloatImage) -> FloatImage:
    """Premultiplied pixels (h, w, 4) over others (h, w, 3 or 4).

    What is brighter than white behind them does not shine through their borders.
    """
    alpha = front[..., 3:]
    dimmed = np.where(alpha > 0, np.minimum(behind, 1.0), behind)
    return np.asarray(front[..., : behind.shape[-1]] + (1 - alpha) * dimmed, dtype=np.float32)


def opposite(rgb: Colour3) -> Colour3:
    """Black for light colours, white for dark ones."""
    return (0.0, 0.0, 0.0) if luminance(rgb) > 0.18 else (1.0, 1.0, 1.0)


def luminance(rgb: Colour3) -> float:
    """Luminance of a linear colour, Rec. 709."""
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]


def _put(canvas: FloatImage, left: int, top: int, rgba: FloatImage) -> None:
    """Lay pixels over a part of the canvas; what lies beside it is left out."""
    height, width = canvas.shape[:2]
    x, y = max(left, 0), max(top, 0)
    part = rgba[y - top : height - top, x - left : width - left] if left < width and top < height else rgba[:0]
    if part.size:
        behind = canvas[y : y + part.shape[0], x : x + part.shape[1]]
        behind[...] = part + (1 - part[..., 3:]) * behind


def _written(mark: Text) -> tuple[FloatImage, FloatImage, int, int]:
    """Shares of pixels (h, w) under the halo and under the ink of a text, and their upper left corner."""
    from PIL import Image, ImageDraw, ImageFilter

    reach = max(1, round(mark.size_px / 9))
    pad = 3 * reach + 1
    left, top, right, bottom = (math.floor(c) for c in mark.box)
    place = round(mark.x_px) - left + pad, round(mark.y_px) - top + pad
    image = Image.new("L", (right - left + 2 * pad + 1, bottom - top + 2 * pad + 1))
    ImageDraw.Draw(image).text(place, spelled(mark.words, mark.size_px), 255, font_of(mark.size_px), mark.anchor)
    inked = np.array(image)
    _add_tails(inked, mark, place)
    halo = Image.fromarray(inked).filter(ImageFilter.MaxFilter(2 * reach + 1)).filter(ImageFilter.GaussianBlur(0.7 * reach))
    shares = [(np.asarray(part) / 255).astype(np.float32) for part in (halo, inked)]
    return shares[0], shares[1], left - pad, top - pad


def _add_tails(inked: npt.NDArray[np.uint8], mark: Text, place: tuple[int, int]) -> None:
    """Draw the left strokes of micro signs on below the line: the font has none, and a u with such a stroke is one."""
    font, words = font_of(mark.size_px), mark.words.translate(PLAIN)
    first_x = place[0] + font.getbbox(spelled(words, mark.size_px), anchor=mark.anchor)[0]
    _, top, _, line = (int(c) for c in font.getbbox("u", anchor="l" + mark.anchor[1]))
    lowest = int(font.getbbox("p", anchor="l" + mark.anchor[1])[3])
    for number, sign in enumerate(words):
        if sign == "µ":
            x = first_x + round(font.getlength(spelled(words[:number], mark.size_px)))
            columns, row = slice(x, x + round(font.getlength("u") / 2)), place[1] + (top + line) // 2
            below = inked[row : place[1] + lowest, columns]
            np.maximum(below, inked[row, columns], out=below)


def _barred(mark: Bar) -> tuple[FloatImage, FloatImage, int, int]:
    """Shares of pixels (h, w) under the halo and under a bar, and their upper left corner."""
    rim = 1.0
    left, top = math.floor(mark.left - rim), math.floor(mark.top - rim)
    x = left + np.arange(math.ceil(mark.right + rim) - left, dtype=np.float32)
    y = top + np.arange(math.ceil(mark.bottom + rim) - top, dtype=np.float32)

    def share(wider: float) -> FloatImage:
        across = np.clip(np.minimum(mark.right + wider, x + 1) - np.maximum(mark.left - wider, x), 0, 1)
        down = np.clip(np.minimum(mark.bottom + wider, y + 1) - np.maximum(mark.top - wider, y), 0, 1)
        return np.asarray(down[:, None] * across, dtype=np.float32)

    return share(rim), share(0.0), left, top
