"""Which colour and opacity stands for which value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import DataError, ValueRangeError
from ..transfer import TransferFunction
from ..transfer.colour import Colour
from ..transfer.function_picture import value_axis
from ..transfer.given import set_fields, whole
from ..transfer.histogram_picture import ticks
from ..transfer.joint_axes import Axis
from ..volume import FloatArray
from .base import Annotation, Drawn, Room, View, colour_or_none
from .marks import Bar, Colour3, Mark, Patch, Text, width_of
from .scale_bar import unit_text

SIDES = ("left", "right")
HEIGHT, WIDTH, OPACITIES = 0.5, 0.028, 0.042
"""Of the image's height: the bar's height and width, and the width of its opacities."""
THICKNESS = 0.01
"""Of the longest edge of the box: what opacities are those of."""
TICK_ROWS = 2.6
"""Height of text from tick to tick, at least."""


@dataclass(frozen=True)
class ColorBar(Annotation):
    """Colours of a layer's transfer function by value, and beside them its opacities; of a mixture one bar a channel.

    Colours are those of the function, before light and tone. Opacities are those of a thickness of a hundredth of the longest
    edge of the scene's box, the full width is one; projections, which show values by their colours alone, have none. Ticks are
    in data units; above stand the channel's name and the unit, where they are known.

    Parameters
    ----------
    layer
        Number of the visible layer.
    side
        ``"right"`` or ``"left"``.
    title
        What stands above; None takes name and unit from the volume.
    color
        Of words and ticks. None: light on dark backgrounds, dark on light ones.
    """

    kind: ClassVar[str] = "color_bar"
    rank: ClassVar[int] = 1
    layer: int = 0
    side: str = "right"
    title: str | None = None
    color: Colour | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        if self.side not in SIDES:
            raise ValueRangeError("color_bar.side", f"is {self.side!r}, must be one of {', '.join(SIDES)}")
        if self.title is not None and not isinstance(self.title, str):
            raise ValueRangeError("color_bar.title", f"is {self.title!r}, must be words")
        set_fields(self, layer=whole(self.layer, "color_bar.layer", 0), color=colour_or_none(self.color, "color_bar.color"))

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return the bars, from the border of the image inwards."""
        if self.layer >= len(view.layers):
            raise DataError("color_bar.layer", f"is {self.layer}, and {len(view.layers)} layers are visible", "choose another")
        shown = view.layers[self.layer]
        if not shown.functions:
            raise DataError("color_bar", f"shows values, and layer {self.layer} shows {shown.instead}", "leave it out")
        marks: list[Mark] = []
        told = []
        for name, function in shown.functions if self.side == "left" else reversed(shown.functions):
            if not isinstance(function, TransferFunction):
                what = f"shows functions of one value, and layer {self.layer} has a {type(function).__name__}"
                raise DataError("color_bar", what, "leave it out")
            axis, title = _axis(function), _title(name, shown.value_unit) if self.title is None else self.title
            marks += self._bar(view, room, function, axis, title, shown.is_projection)
            told.append({"channel": name, "range": [axis.low, axis.high]})
        room.take(marks)
        return Drawn(marks=tuple(marks), told={"layer": self.layer, "bars": told})

    def _bar(
        self, view: View, room: Room, function: TransferFunction, axis: Axis, title: str, is_projection: bool
    ) -> list[Mark]:
        rgb, text, margin, height_px = colour_or_none(self.color, "") or view.ink, view.text_px, view.margin_px, view.size_px[1]
        rows, wide = max(1, round(HEIGHT * height_px)), max(4, round(WIDTH * height_px))
        deep = 0 if is_projection else max(6, round(OPACITIES * height_px))
        found = ticks(axis, max(1, int(rows / (TICK_ROWS * text))))
        tick = max(2, round(text / 4))
        words_wide = max((width_of(words, text) for _, words in found), default=0.0)
        labels = tick + round(0.3 * text) + words_wide
        whole_wide = max(deep + wide + labels, width_of(title, text) if title else 0.0)
        taken = room.right if self.side == "right" else room.left
        left = round(view.size_px[0] - margin - taken - whole_wide if self.side == "right" else margin + taken) + deep
        top = round((height_px - rows) / 2 + (0.6 * text if title else 0))
        colours, opacities = _strip(function, axis, rows, view)
        marks: list[Mark] = [Bar(left - 1, top - 1, left + wide + 1, top + rows + 1, rgb)]
        marks.append(Patch(left, top, np.repeat(colours[:, None], wide, axis=1).astype(np.float32)))
        if deep:
            marks += _profile(colours, opacities, left - 1, top, deep, rgb)
        for value, words in found:
            y = top + (axis.high - value) / axis.span * rows
            thick = max(1.0, text / 14)
            marks.append(Bar(left + wide + 1, y - thick / 2, left + wide + 1 + tick, y + thick / 2, rgb))
            marks.append(Text(left + wide + 1 + tick + round(0.3 * text), y, words, text, rgb, "lm"))
        if title:
            marks.append(Text(left - deep, top - round(0.8 * text), title, text, rgb, "ls"))
        if self.side == "right":
            room.right += whole_wide + margin
        else:
            room.left += whole_wide + margin
        return marks


def _title(name: str, unit: str) -> str:
    return f"{name} ({unit_text(unit)})" if name and unit else name or unit_text(unit)


def _axis(function: TransferFunction) -> Axis:
    """Values of a function's points and surfaces, a little beyond where surfaces or a single point lie at the ends."""
    low, high = function.domain
    return value_axis(function) if function.surfaces or low == high else Axis("value", low, high)


def _strip(function: TransferFunction, axis: Axis, rows: int, view: View) -> tuple[FloatArray, FloatArray]:
    """Colours (rows, 4), opaque, and opacities (rows,), from the greatest value down."""
    values = axis.high - (np.arange(rows) + 0.5) / rows * axis.span
    rgb, extinctions = function(values)
    # Sources have no greatest brightness of their own.
    rgb = rgb / max(float(rgb.max()), 1.0) if function.associated else rgb
    opacities = -np.expm1(-extinctions * THICKNESS * view.extent_world)
    for surface in function.surfaces:
        here = np.abs(values - surface.value) <= max(0.5, view.text_px / 12) * axis.span / rows
        rgb[here], opacities[here] = surface.front
    colours = np.ones((rows, 4))
    colours[:, :3] = np.clip(rgb, 0, 1)
    return colours, opacities


def _profile(colours: FloatArray, opacities: FloatArray, right: int, top: int, deep: int, rgb: Colour3) -> list[Mark]:
    """Opacities as an area that grows to the left of a column, in their colours, with a line along it."""
    reach = opacities[:, None] * (deep - 1)
    from_right = deep - 1 - np.arange(deep)
    inside = np.clip(reach - from_right, 0, 1)
    # The line covers what lies within a pixel of the border, from each row's reach to that of the next one.
    following = np.append(reach[1:], reach[-1:], axis=0)
    low, high = np.minimum(reach, following), np.maximum(reach, following) + 1
    line = np.clip(np.minimum(high, from_right + 1) - np.maximum(low, from_right), 0, 1)
    line *= (np.maximum(reach, following) > 0).astype(float)
    ink = np.array([*rgb, 1.0])
    pixels = line[..., None] * ink + (1 - line[..., None]) * inside[..., None] * colours[:, None]
    return [Patch(right - deep, top, pixels.astype(np.float32))]
