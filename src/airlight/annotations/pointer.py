"""A cross or an arrow at a point of the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..geometry import Lines, Mesh
from ..transfer.colour import Colour
from ..transfer.given import finite_numbers, positive, set_fields
from ..volume import FloatArray
from .base import Annotation, Drawn, Room, View, colour_or_none
from .marks import Text
from .solids import arrow, joined

SHAPES = ("cross", "arrow")
SHARE = 0.08
"""Of the image's height: the size, unless told."""
FROM = (-0.6, 0.6, -0.5)
"""Where arrows come from: to the right, up and forward as the camera sees it."""
SIDES = {"lm": (1, 0), "rm": (-1, 0), "mb": (0, -1), "mt": (0, 1)}
"""Which side of a place words with an anchor stand on, right and down."""


@dataclass(frozen=True)
class Pointer(Annotation):
    """A point of the world: a cross along its axes, or an arrow that ends there; geometry of the scene.

    What lies before the point hides it, as it hides all geometry.

    Parameters
    ----------
    p_world
        The point, x, y, z, e.g. what ``image.pick`` found.
    shape
        ``"cross"``, or ``"arrow"``, which comes from the upper left, on the eye's side.
    size_px, size_voxels
        Length of the cross's lines or of the arrow, in pixels at the point's distance, or in voxels (smallest spacing of the
        scene); 0.08 of the image's height unless told.
    color
        Its colour.
    label
        Words beside it.

    Raises
    ------
    ValueRangeError
        For points and sizes that are none.
    """

    kind: ClassVar[str] = "pointer"
    rank: ClassVar[int] = 3
    p_world: tuple[float, float, float]
    shape: str = "cross"
    size_px: float | None = None
    size_voxels: float | None = None
    color: Colour = "#ffd23f"
    label: str = ""

    def __post_init__(self) -> None:
        """Check the values."""
        if self.shape not in SHAPES:
            raise ValueRangeError("pointer.shape", f"is {self.shape!r}, must be one of {', '.join(SHAPES)}")
        if self.size_px is not None and self.size_voxels is not None:
            raise ValueRangeError("pointer.size_px", "and size_voxels exclude each other", "leave one of them out")
        if not isinstance(self.label, str):
            raise ValueRangeError("pointer.label", f"is {self.label!r}, must be words")
        set_fields(
            self,
            p_world=finite_numbers(self.p_world, "pointer.p_world", 3),
            size_px=None if self.size_px is None else positive(self.size_px, "pointer.size_px"),
            size_voxels=None if self.size_voxels is None else positive(self.size_voxels, "pointer.size_voxels"),
            color=colour_or_none(self.color, "pointer.color"),
        )

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return the cross or the arrow, and its words; nothing of a point that the camera has no place for."""
        view.check_places(self.kind)
        p_world = np.array(self.p_world)
        x, y, depth = view.placed(p_world)[0].tolist()
        if not np.isfinite(x):
            reason = "lies beside the image" if view.camera.looks_round else "lies behind the eye"
            return Drawn(told={"shown": False, "reason": reason})
        pixel = view.pixel_world(depth)
        size_px = SHARE * view.size_px[1] if self.size_px is None else self.size_px
        size = size_px * pixel if self.size_voxels is None else self.size_voxels * view.voxel_world
        told = {"shown": True, "size_world": size, "pixel": [x, y]}
        shape: Lines | Mesh
        if self.shape == "cross":
            # As far as its lines reach: where images are no planes, angles are wider in some places.
            seen = np.abs(view.moved(np.tile(p_world, (3, 1)), size / 2 * np.eye(3))).max(axis=0)
            reach = np.maximum(0.5 * size / pixel, np.nan_to_num(seen))
            shape, words = self._cross(p_world, size, view), self._words(view, room, (x, y), reach, "lm rm mb mt")
        else:
            way = -np.array(FROM) @ _axes_at(view, p_world)
            way *= size / np.linalg.norm(way)
            x, y, _ = view.placed(p_world - way)[0].tolist()
            shape, words = self._arrow(p_world, way, view), self._words(view, room, (x, y), np.zeros(2), "mb rm lm mt")
        room.take(words)
        return Drawn((shape,), words, told)

    def _words(self, view: View, room: Room, at_px: tuple[float, float], reach: FloatArray, anchors: str) -> tuple[Text, ...]:
        """The label beside a place, where there is room for it: as far away as its mark reaches (2,) to the sides [px]."""
        if not self.label or not np.isfinite(at_px).all():
            return ()
        right, down = (reach + 0.4 * view.text_px).tolist()
        found = [
            Text(at_px[0] + SIDES[a][0] * right, at_px[1] + SIDES[a][1] * down, self.label, view.text_px, view.ink, a)
            for a in anchors.split()
        ]
        return (next((text for text in found if room.has(text.box) and view.holds(text.box)), found[0]),)

    def _cross(self, p_world: FloatArray, size: float, view: View) -> Lines:
        ways = size / 2 * np.eye(3)
        ends = np.stack([p_world - ways, p_world + ways], axis=1)
        return Lines(ends, color=self.color, width_px=max(1.5, view.size_px[1] / 256))

    def _arrow(self, p_world: FloatArray, way: FloatArray, view: View) -> Mesh:
        thick = 0.05 * float(np.linalg.norm(way))
        return joined([(*arrow(p_world - way, way, thick), colour_or_none(self.color, "") or view.ink)])


def _axes_at(view: View, p_world: FloatArray) -> FloatArray:
    """Unit vectors (3, 3) to the right, up and forward as a point is seen; of a plane they are the same everywhere."""
    camera = view.camera
    if not camera.looks_round:
        return np.stack(camera.basis())
    towards = p_world - np.array(camera.eye)
    moves = view.moved(np.tile(p_world, (3, 1)), float(np.linalg.norm(towards)) * np.eye(3)).T
    ways = np.stack([moves[0], -moves[1], towards])
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))
