"""Arrows along the axes of the world, and letters of anatomical directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import DataError
from ..geometry.marks import AXES
from ..transfer.colour import linear_rgb
from ..transfer.given import finite_numbers, positive, set_fields
from .base import LETTERS, Annotation, Drawn, Room, View
from .marks import Mark, Text
from .solids import arrow, joined

SHARE = 0.25
"""Of the longest edge of the box: the length of axes."""
LEAST_PART = 0.26
"""Part of a direction along an axis, at least, that its letter tells: 15 degrees."""


@dataclass(frozen=True)
class Axes(Annotation):
    """Three arrows along the world's x, y and z, in red, green and blue, with their names: geometry of the scene.

    Anatomical data have ``L``, ``P`` and ``S`` there: to the patient's left, to posterior and to superior.

    Parameters
    ----------
    origin
        Point of the world from which they go; None is the least corner of the box round all.
    length
        In world units; None is a quarter of the longest edge of that box.
    """

    kind: ClassVar[str] = "axes"
    rank: ClassVar[int] = 3
    margin: ClassVar[float] = 1.1
    origin: tuple[float, float, float] | None = None
    length: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        origin = None if self.origin is None else finite_numbers(self.origin, "axes.origin", 3)
        set_fields(self, origin=origin, length=None if self.length is None else positive(self.length, "axes.length"))

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return the arrows and their names."""
        view.check_places(self.kind)
        origin = view.low if self.origin is None else np.array(self.origin)
        length = SHARE * view.extent_world if self.length is None else self.length
        colours = [linear_rgb(colour, "axes") for colour in AXES]
        arrows = joined([(*arrow(origin, length * way, 0.028 * length), c) for way, c in zip(np.eye(3), colours, strict=True)])
        tips = origin + length * np.eye(3)
        places, ways = view.placed(tips)[:, :2], view.moved(tips, length * np.eye(3))
        marks: list[Mark] = []
        for tip, way, name in zip(places, ways, view.named_axes(), strict=True):
            if np.isfinite([tip, way]).all():
                x, y = tip + way / max(float(np.linalg.norm(way)), 1.0) * 0.8 * view.text_px
                word = view.within(Text(float(x), float(y), name, view.text_px, view.ink))
                marks += [word] if word is not None and room.has(word.box) else []
        room.take(marks)
        return Drawn((arrows,), tuple(marks), {"origin": origin.tolist(), "length": length})


@dataclass(frozen=True)
class Orientation(Annotation):
    """Letters in the middle of the image's sides that tell where they look to, of anatomical data.

    L left and R right of the patient, P posterior and A anterior, S superior and I inferior; of a view askew several, that of
    the greatest part first.
    """

    kind: ClassVar[str] = "orientation"

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return the letters."""
        view.check_flat(self.kind)
        if not view.anatomical:
            raise DataError("orientation", "is that of anatomical data, and these are not", "leave it out, or use Axes")
        right, up, _ = view.camera.basis()
        (width, height), margin, text = view.size_px, view.margin_px, round(1.15 * view.text_px)
        to_left = Text(margin, height / 2, letters(-right), text, view.ink, "lm")
        to_right = Text(width - margin, height / 2, letters(right), text, view.ink, "rm")
        upward = Text(width / 2, margin, letters(up), text, view.ink, "mt")
        downward = Text(width / 2, height - margin, letters(-up), text, view.ink, "ms")
        marks = to_left, to_right, upward, downward
        room.left, room.right = to_left.box[2], width - to_right.box[0]
        room.take(marks)
        return Drawn(marks=marks, told={"right": letters(right), "up": letters(up)})


def letters(direction: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    """Letters of a direction (3,) of patient LPS, of length one."""
    order = [axis for axis in np.argsort(-np.abs(direction), kind="stable") if abs(direction[axis]) >= LEAST_PART]
    return "".join(LETTERS[axis][0 if direction[axis] > 0 else 1] for axis in order)
