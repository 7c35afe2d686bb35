"""Pictures of functions of one value, alone and over the counts of one variable."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .colour import linear_to_srgb
from .histogram_picture import COUNTS, INK, PAPER, SIDE_PX, WORDS, Picture, framed, label
from .joint_axes import Axis

if TYPE_CHECKING:
    from .function import FloatArray, TransferFunction
    from .histogram import JointHistogram

MARGIN = 0.05
"""Share of the domain that is shown beyond both of its ends."""
STRIP_PX, GAP_PX, LINE_PX = 20, 4, 2
COUNT_PX = np.array([int(COUNTS[2][i : i + 2], 16) for i in (1, 3, 5)], dtype=np.float64)


def function_picture(function: TransferFunction) -> Picture:
    """Picture (h, w, 3), sRGB: extinction by value in the function's colours, over a strip of the colours alone.

    Surfaces are lines, as high as they are opaque.
    """
    across, upward = value_axis(function), extinction_axis(function)
    plot = _plot(function, across, upward)
    values = across.low + (np.arange(SIDE_PX) + 0.5) / SIDE_PX * across.span
    plot[-STRIP_PX - GAP_PX :] = PAPER
    plot[-STRIP_PX:] = np.rint(_encoded(function, values))
    return framed(plot, (across, upward), (WORDS["value"], "extinction per world unit"))


def count_picture(histogram: JointHistogram, function: TransferFunction | None = None) -> Picture:
    """Picture (h, w, 3), sRGB, of the counts of one variable, whose logarithm goes upward, with a function over it."""
    (across,) = histogram.axes
    tens = np.log10(histogram.counts + 1.0)
    upward = Axis("count", 0.0, max(float(tens.max()), 1.0) * (1 + MARGIN))
    bins = np.minimum((np.arange(SIDE_PX) + 0.5) / SIDE_PX * histogram.bins, histogram.bins - 1).astype(int)
    plot = np.broadcast_to(np.array(PAPER, dtype=np.float64), (SIDE_PX, SIDE_PX, 3)).copy()
    plot[_below(tens[bins] / upward.span)] = COUNT_PX
    words = "log10 of count + 1"
    if function is not None:
        over = _plot(function, across, extinction_axis(function)).astype(np.float64)
        drawn = (over != PAPER).any(axis=-1)
        plot[drawn] = over[drawn] * 0.75 + plot[drawn] * 0.25
        words += ", and extinction of the function, to its greatest"
    return framed(np.rint(plot).astype(np.uint8), (across, upward), (label(histogram, 0), words))


def value_axis(function: TransferFunction) -> Axis:
    """Values that are shown of a function: all its points and surfaces, and a little beyond."""
    places = [*function.domain, *(surface.value for surface in function.surfaces)]
    low, high = min(places), max(places)
    margin = MARGIN * (high - low) or max(abs(low), 1.0) * MARGIN
    return Axis("value", low - margin, high + margin)


def extinction_axis(function: TransferFunction) -> Axis:
    """Extinctions that are shown of a function: from 0 to a little above the greatest."""
    return Axis("extinction", 0.0, (float(function.extinctions.max()) or 1.0) * (1 + MARGIN))


def _plot(function: TransferFunction, across: Axis, upward: Axis) -> Picture:
    """Area under the extinctions in their colours, and surfaces, (SIDE_PX, SIDE_PX, 3)."""
    values = across.low + (np.arange(SIDE_PX) + 0.5) / SIDE_PX * across.span
    plot = np.broadcast_to(np.array(PAPER, dtype=np.float64), (SIDE_PX, SIDE_PX, 3)).copy()
    heights = function(values)[1] / upward.span
    inside = _below(heights)
    plot[inside] = np.broadcast_to(_encoded(function, values), plot.shape)[inside]
    plot[_outline(heights)] = INK
    for surface in function.surfaces:
        x = round((surface.value - across.low) / across.span * SIDE_PX)
        if 0 <= x < SIDE_PX:
            columns = slice(max(0, x - LINE_PX), x + LINE_PX)
            colour, opacity = surface.front
            part = _below(np.full(SIDE_PX, opacity / (1 + MARGIN)))[:, columns]
            plot[:, columns][part] = 255 * linear_to_srgb(np.array(colour))
    return np.rint(plot).astype(np.uint8)


def _encoded(function: TransferFunction, values: FloatArray) -> FloatArray:
    """Colours (n, 3) at values, sRGB, 0 to 255."""
    rgb, _ = function(values)
    # Sources have no greatest brightness of their own.
    bright = max(float(rgb.max()), 1.0) if function.associated else 1.0
    return 255 * linear_to_srgb(rgb / bright)


def _below(heights: FloatArray) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Pixels (SIDE_PX, SIDE_PX) below heights (SIDE_PX,), which are shares of the plot."""
    up = (SIDE_PX - np.arange(SIDE_PX) - 0.5) / SIDE_PX
    return np.asarray(up[:, None] < heights)


def _outline(heights: FloatArray) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Pixels of a line along heights: from each column's to that of its neighbour, so that steps are closed."""
    neighbour = np.append(heights[1:], heights[-1])
    width = LINE_PX / SIDE_PX
    return _below(np.maximum(heights, neighbour) + width / 2) & ~_below(np.minimum(heights, neighbour) - width / 2)
