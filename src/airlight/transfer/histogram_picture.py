"""Pictures of joint histograms, with labelled axes, and of the shapes of a function on them."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .colour import linear_to_srgb, srgb_to_linear
from .function import FloatArray
from .joint import JointFunction
from .joint_axes import Axis

if TYPE_CHECKING:
    from .histogram import JointHistogram

Picture = npt.NDArray[np.uint8]

SIDE_PX = 512
LEFT_PX, RIGHT_PX, TOP_PX, BOTTOM_PX = 76, 22, 18, 58
TEXT_PX, TICK_PX = 15, 6
TICKS = 6
LAYERS = 33
"""Places along a third axis at which shapes are looked for."""
PAPER, INK = (16, 18, 22), (212, 214, 218)
COUNTS = ("#101216", "#33468c", "#6b80cc", "#b4bfe8", "#ffffff")
"""sRGB colours of counts, from none to the most, on a logarithmic scale."""
WORDS = {"value": "value", "gradient": "gradient", "second": "second derivative"}


def picture(histogram: JointHistogram, function: JointFunction | None = None) -> Picture:
    """Picture (h, w, 3), sRGB, of a histogram by its first two variables; see ``JointHistogram.picture``."""
    across, upward = histogram.axes[:2]
    return framed(_plot(histogram, function), (across, upward), (label(histogram, 0), label(histogram, 1)))


def framed(plot: Picture, axes: tuple[Axis, Axis], labels: tuple[str, str]) -> Picture:
    """Picture (h, w, 3) of a plot (SIDE_PX, SIDE_PX, 3) with labelled axes, the first to the right, the second upward."""
    from PIL import Image, ImageDraw, ImageFont

    across, upward = axes
    size = LEFT_PX + SIDE_PX + RIGHT_PX, TOP_PX + SIDE_PX + BOTTOM_PX
    paper = Image.new("RGB", size, PAPER)
    paper.paste(Image.fromarray(plot), (LEFT_PX, TOP_PX))
    font = ImageFont.load_default(TEXT_PX)
    draw = ImageDraw.Draw(paper)
    below = TOP_PX + SIDE_PX
    draw.rectangle((LEFT_PX - 1, TOP_PX - 1, LEFT_PX + SIDE_PX, below), outline=INK)
    for value, text in ticks(across):
        x = LEFT_PX + round((value - across.low) / across.span * (SIDE_PX - 1))
        draw.line((x, below, x, below + TICK_PX), fill=INK)
        draw.text((x, below + TICK_PX + 3), text, fill=INK, font=font, anchor="mt")
    for value, text in ticks(upward):
        y = below - 1 - round((value - upward.low) / upward.span * (SIDE_PX - 1))
        draw.line((LEFT_PX - 1 - TICK_PX, y, LEFT_PX - 1, y), fill=INK)
        draw.text((LEFT_PX - TICK_PX - 5, y), text, fill=INK, font=font, anchor="rm")
    draw.text((LEFT_PX + SIDE_PX / 2, size[1] - 8), labels[0], fill=INK, font=font, anchor="mb")
    # Text that runs upward is drawn aside and turned.
    turned = Image.new("RGB", (SIDE_PX, TEXT_PX + 8), PAPER)
    ImageDraw.Draw(turned).text((SIDE_PX / 2, 4), labels[1], fill=INK, font=font, anchor="mt")
    paper.paste(turned.transpose(Image.Transpose.ROTATE_90), (2, TOP_PX))
    return np.asarray(paper)


def png(drawn: Picture) -> bytes:
    """A picture as a PNG file."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(drawn).save(out, "png")
    return out.getvalue()


def label(histogram: JointHistogram, number: int) -> str:
    """What stands beside an axis: the variable, and its unit where that is known."""
    variable = histogram.axes[number].variable
    words = f"channel {variable}" if isinstance(variable, int) else WORDS.get(variable, variable)
    unit = histogram.units[number] if histogram.units else ""
    return f"{words} ({unit})" if unit else words


def ticks(axis: Axis, count: int = TICKS) -> list[tuple[float, str]]:
    """Round values within an axis, about so many, as numbers and as they are written."""
    rough = axis.span / count
    ten = 10.0 ** math.floor(math.log10(rough))
    step = next(ten * m for m in (1, 2, 5, 10) if ten * m >= rough)
    places = range(math.ceil(axis.low / step), math.floor(axis.high / step) + 1)
    digits = max(0, -math.floor(math.log10(step)))
    plain = abs(math.log10(step)) < 5
    return [(n * step, f"{n * step:.{digits}f}" if plain else f"{n * step:.6g}") for n in places]


def _plot(histogram: JointHistogram, function: JointFunction | None) -> Picture:
    """Counts, with the shapes of a function over them, (SIDE_PX, SIDE_PX, 3)."""
    from PIL import Image

    counts = Image.fromarray(histogram.image())
    grown = counts.resize((SIDE_PX, SIDE_PX), Image.Resampling.BOX if histogram.bins > SIDE_PX else Image.Resampling.NEAREST)
    shade = np.asarray(grown, dtype=np.float64) / 255
    stops = np.linspace(0, 1, len(COUNTS))
    colours = np.array([[int(c[i : i + 2], 16) / 255 for i in (1, 3, 5)] for c in COUNTS])
    rgb = np.stack([np.interp(shade, stops, colours[:, i]) for i in range(3)], axis=-1)
    return np.rint(255 * (rgb if function is None else _with_shapes(rgb, histogram, function))).astype(np.uint8)


def _with_shapes(rgb: FloatArray, histogram: JointHistogram, function: JointFunction) -> FloatArray:
    """The plot under each shape of a function, faint where its weight is small, with a line around."""
    if function.variables != tuple(axis.variable for axis in histogram.axes):
        counted = ", ".join(str(axis.variable) for axis in histogram.axes)
        found = f"looks at {', '.join(str(v) for v in function.variables)}, the histogram at {counted}"
        raise ValueRangeError("function", found, "count the function's variables")
    lines = [axis.low + (np.arange(SIDE_PX) + 0.5) / SIDE_PX * axis.span for axis in histogram.axes[:2]]
    first, second = np.meshgrid(lines[0], lines[1][::-1])
    third = np.linspace(function.axes[2].low, function.axes[2].high, LAYERS) if len(function.axes) == 3 else [None]
    spans = np.array([axis.span for axis in function.axes])
    for shape in function.shapes:
        weight = np.zeros(first.shape)
        for place in third:
            c = np.stack([first, second] if place is None else [first, second, np.full_like(first, place)], axis=-1)
            weight = np.maximum(weight, shape.weight(c, spans))
        colours = linear_to_srgb(np.clip(np.broadcast_to(shape.colours(c), rgb.shape), 0, 1))
        inside = np.pad(weight > 0, 1)
        core = inside[1:-1, :-2] & inside[1:-1, 2:] & inside[:-2, 1:-1] & inside[2:, 1:-1]
        share = np.where(inside[1:-1, 1:-1] & ~core, 0.9, 0.55 * weight)[..., None]
        rgb = linear_to_srgb(srgb_to_linear(rgb) * (1 - share) + srgb_to_linear(colours) * share)
    return rgb
