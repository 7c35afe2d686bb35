"""What annotations are, what they may look at, and what they make of it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError
from ..geometry import Lines, Mesh, Points
from ..stages.camera import Camera, Orthographic, Perspective
from ..transfer.colour import MOST_COLOUR, Colour, linear_rgb
from ..transfer.kinds import AnyFunction
from ..volume import FloatArray
from .drawing import luminance
from .marks import Box, Colour3, Mark, Text

LIGHT, GREY, DARK = (0.9, 0.9, 0.9), (0.2, 0.2, 0.2), (0.012, 0.012, 0.012)
LETTERS = (("L", "R"), ("P", "A"), ("S", "I"))
"""Letters of the directions +x and -x, +y and -y, +z and -z of patient LPS."""
SMALL = 1e-4
"""Part of a way along which it is told where it leads to in the image."""


@dataclass(frozen=True)
class Shown:
    """What annotations may know of a layer.

    Attributes
    ----------
    functions
        Its transfer functions, each with the name of its channel; none where their colours are not shown.
    value_unit
        Unit of the values, empty where unknown.
    is_projection
        Whether values are shown in their colours alone, without opacity.
    instead
        What is shown where there are no functions.
    """

    functions: tuple[tuple[str, AnyFunction], ...]
    value_unit: str = ""
    is_projection: bool = False
    instead: str = "labels"


@dataclass(frozen=True, eq=False)
class View:
    """What annotations may look at: what is seen, from where, and on what ground.

    Attributes
    ----------
    corners_world
        Points (n, 3) round all that is drawn.
    voxel_world
        Smallest spacing of a volume.
    unit
        Unit of length of the world, empty where unknown.
    """

    camera: Camera
    size_px: tuple[int, int]
    corners_world: FloatArray
    voxel_world: float
    unit: str
    anatomical: bool
    layers: tuple[Shown, ...]
    background: Colour3 | None = (0.0, 0.0, 0.0)

    @property
    def low(self) -> FloatArray:
        """Least corner (3,) of the box round all, along the axes of the world."""
        return np.asarray(self.corners_world.min(axis=0))

    @property
    def high(self) -> FloatArray:
        """Greatest corner (3,) of the box round all."""
        return np.asarray(self.corners_world.max(axis=0))

    @property
    def extent_world(self) -> float:
        """Longest edge of the box round all; a voxel where all is one point."""
        return float((self.high - self.low).max()) or self.voxel_world

    @property
    def text_px(self) -> int:
        """Height of text: it grows with the image, slower."""
        return max(9, round(7 + self.size_px[1] / 64))

    @property
    def margin_px(self) -> int:
        """What is left free along the border of the image."""
        return max(4, round(0.75 * self.text_px))

    @cached_property
    def ink(self) -> Colour3:
        """Colour that is seen on the background; pictures without one are mostly put on paper."""
        return LIGHT if self.background is not None and luminance(self.background) < 0.18 else DARK

    @cached_property
    def faint(self) -> Colour3:
        """Colour of lines that shall not be in the way."""
        if self.background is None:
            return GREY
        share, behind = 0.22, self.background
        r, g, b = (share * i + (1 - share) * b for i, b in zip(self.ink, behind, strict=True))
        return r, g, b

    def check_flat(self, kind: str) -> None:
        """Refuse cameras under which the image is no plane with one scale.

        Raises
        ------
        StageError
            For those that are neither perspective nor orthographic.
        """
        if not isinstance(self.camera, Perspective | Orthographic):
            what = f"does not go with the camera {self.camera.name}"
            why = ", whose pixels are angles: no length and no direction holds for its image" if self.camera.looks_round else ""
            raise StageError(f"annotation {kind!r}", what + why, "use perspective or orthographic, or leave it out")

    def check_places(self, kind: str) -> None:
        """Refuse cameras that do not show each point at one place.

        Raises
        ------
        StageError
            For those of two eyes, and those that do not tell.
        """
        if type(self.camera).placed is Camera.placed:
            what = f"does not go with the camera {self.camera.name}"
            raise StageError(f"annotation {kind!r}", what, "use perspective, orthographic, panorama or dome, or leave it out")

    def pixel_world(self, depth_world: float) -> float:
        """How wide a pixel is at a depth along the view, for cameras that look all round at a distance."""
        at_eye, more = self.camera.pixel_width(self.size_px)
        return at_eye + more * depth_world

    def placed(self, points_world: FloatArray) -> FloatArray:
        """Points (n, 3) as column, row [px] and depth along the view; no numbers for those at or behind the eye."""
        return self.camera.placed(np.atleast_2d(points_world), self.size_px)

    def moved(self, points_world: FloatArray, ways_world: FloatArray) -> FloatArray:
        """Pixels (n, 2), right and down, that points (n, 3) would move if they went on along ways (n, 3) as they begin."""
        apart = self.placed(points_world + SMALL * ways_world) - self.placed(points_world - SMALL * ways_world)
        return np.asarray(apart[:, :2] / (2 * SMALL))

    def within(self, mark: Text) -> Text | None:
        """A text, moved into the image where a part of it lies beside; None where all of it does."""
        left, top, right, bottom = mark.box
        width, height = self.size_px
        if right < 0 or bottom < 0 or left > width or top > height:
            return None
        gap = self.margin_px / 2
        x = max(gap - left, 0.0) + min(width - gap - right, 0.0)
        y = max(gap - top, 0.0) + min(height - gap - bottom, 0.0)
        return replace(mark, x_px=mark.x_px + x, y_px=mark.y_px + y)

    def holds(self, box: Box) -> bool:
        """Whether all of a box [px] lies in the image."""
        left, top, right, bottom = box
        return bool(left >= 0 and top >= 0 and right <= self.size_px[0] and bottom <= self.size_px[1])

    def named_axes(self) -> tuple[str, str, str]:
        """Names of the world's axes: where they point to, of anatomy."""
        return ("L", "P", "S") if self.anatomical else ("x", "y", "z")


@dataclass
class Room:
    """What of the image is taken: pixels along its sides, and boxes within."""

    left: float = 0.0
    right: float = 0.0
    boxes: list[Box] = field(default_factory=list)

    def take(self, marks: Sequence[Mark]) -> None:
        """Take the boxes of marks."""
        self.boxes += [mark.box for mark in marks]

    def has(self, box: Box, gap: float = 0.0) -> bool:
        """Whether nothing of a box is taken."""
        left, top, right, bottom = box[0] - gap, box[1] - gap, box[2] + gap, box[3] + gap
        return all(left >= taken[2] or taken[0] >= right or top >= taken[3] or taken[1] >= bottom for taken in self.boxes)


@dataclass(frozen=True)
class Drawn:
    """What an annotation makes: geometry that shares its depth with the scene, marks on the picture, and what is told of it."""

    shapes: tuple[Mesh | Lines | Points, ...] = ()
    marks: tuple[Mark, ...] = ()
    told: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Annotation:
    """Something beside the data that helps to read a picture.

    Attributes
    ----------
    kind
        Its name in scene files.
    rank
        What comes first takes the room that it needs; others go round it.
    margin
        Factor by which the image of a named view is larger, so that there is room round what it shows.
    """

    kind: ClassVar[str] = "none"
    rank: ClassVar[int] = 0
    margin: ClassVar[float] = 1.0

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return what is drawn; ``room`` is told what of the image is taken.

        Raises
        ------
        StageError
            For cameras that it does not go with.
        DataError
            When the scene has nothing for it to show.
        """
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for scene files: the kind, and the parameters."""
        values = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        plain = {name: list(v) if isinstance(v, tuple) else v for name, v in values.items() if v is not None}
        return {"kind": self.kind} | plain


def colour_or_none(given: Colour | None, where: str) -> Colour3 | None:
    """Linear colour, if one is given."""
    return None if given is None else linear_rgb(given, where, MOST_COLOUR)


def round_below(most: float) -> float:
    """The greatest of 1, 2 and 5 times a power of ten that is not above a number, which must be above zero."""
    ten = 10.0 ** math.floor(math.log10(most))
    while ten * 10 <= most:
        ten *= 10
    return next((ten * m for m in (5, 2, 1) if ten * m <= most), ten / 2)


def number_text(number: float) -> str:
    """A round number as it is written."""
    return f"{number:.12g}" if 1e-4 <= abs(number) < 1e6 or number == 0 else f"{number:.6g}"
