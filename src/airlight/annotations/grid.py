"""A grid at round numbers on the far faces of the box round all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..geometry import Lines
from ..stages.camera import Orthographic
from ..transfer.colour import Colour
from ..transfer.given import flag, positive, set_fields
from ..volume import FloatArray
from .base import Annotation, Drawn, Room, View, colour_or_none, number_text
from .marks import Mark, Text
from .scale_bar import unit_text

LINES = 5
"""Stretches between lines along the longest edge, about."""
MOST_LINES = 1000
FACE_ON = 1e-9


@dataclass(frozen=True)
class Grid(Annotation):
    """Lines at round numbers of the world on those faces of the box round all that lie behind it, with numbers along its rim.

    Seen from within, all faces have lines; numbers stand along edges then where the camera looks all round.

    Lines are geometry of the scene: they share their depth with all else. The box is that of the visible layers and of the
    meshes, along the axes of the world.

    Parameters
    ----------
    step
        From line to line in world units, the same along all axes; None takes a round one.
    labels
        Whether numbers stand along the rim, with names of the axes (``L``, ``P``, ``S`` for the directions of anatomical data)
        and the unit.
    color
        Of the lines. None: faint on the background.
    """

    kind: ClassVar[str] = "grid"
    rank: ClassVar[int] = 4
    margin: ClassVar[float] = 1.3
    step: float | None = None
    labels: bool = True
    color: Colour | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        step = None if self.step is None else positive(self.step, "grid.step")
        set_fields(self, step=step, labels=flag(self.labels, "grid.labels"))
        set_fields(self, color=colour_or_none(self.color, "grid.color"))

    def drawn(self, view: View, room: Room) -> Drawn:
        """Return the lines, and the numbers that find room."""
        view.check_places(self.kind)
        low, high = view.low, view.high
        step = _round_step(view.extent_world / LINES) if self.step is None else self.step
        if view.extent_world / step > MOST_LINES:
            found = f"is {step:g}, and the longest edge is {view.extent_world:g}"
            raise ValueRangeError("grid.step", found, f"at most {MOST_LINES} lines are drawn along it")
        values = [_multiples(low[axis], high[axis], step) for axis in range(3)]
        faces = [(axis, side) for axis, side in product(range(3), (0, 1)) if _is_far(view, axis, side)]
        told: dict[str, Any] = {"step": step, "unit": view.unit, "faces": len(faces)}
        segments = {segment for face in faces for segment in _on_face(face, values, low, high)}
        if not segments:
            return Drawn(told=told)
        points = np.array(sorted(segments)).reshape(-1, 2, 3)
        rgb = colour_or_none(self.color, "") or view.faint
        lines = Lines(points, color=rgb, width_px=max(1.0, view.size_px[1] / 512))
        marks = self._numbers(view, room, values, set(faces), told) if self.labels else ()
        return Drawn((lines,), marks, told)

    def _numbers(
        self, view: View, room: Room, values: list[FloatArray], faces: set[tuple[int, int]], told: dict[str, Any]
    ) -> tuple[Mark, ...]:
        """Numbers beside one edge of the rim along each axis; what would lie over something else is left out."""
        marks: list[Mark] = []
        left_out = 0
        middle = view.placed((view.low + view.high)[None] / 2)[0, :2]
        for axis in range(3):
            edge = _labelled_edge(view, axis, faces)
            if edge is None:
                continue
            ends = view.placed(edge)[:, :2]
            if np.linalg.norm(ends[1] - ends[0]) < 2 * view.text_px:
                continue
            along = np.repeat(edge[:1], 1 + len(values[axis]), axis=0)
            along[:, axis] = [edge[:, axis].mean(), *values[axis]]
            (name_at, *places), (away, *sides) = view.placed(along)[:, :2], _away(view, along, edge[1] - edge[0], middle)
            words = [number_text(float(value)) for value in values[axis]]
            numbers = [_beside(view, at, side, word) for at, side, word in zip(places, sides, words, strict=True)]
            farthest = max((abs(number.box[2] - number.box[0]) for number in numbers), default=0.0)
            name = f"{view.named_axes()[axis]} ({unit_text(view.unit)})" if view.unit else view.named_axes()[axis]
            reach = abs(away[0]) * farthest + abs(away[1]) * view.text_px + 0.5 * view.text_px
            for words_beside in (_beside(view, name_at + reach * away, away, name), *numbers):
                mark = view.within(words_beside)
                if mark is not None and room.has(mark.box, 0.3 * view.text_px):
                    marks.append(mark)
                    room.take([mark])
                else:
                    left_out += 1
        told |= {"labels": len(marks), "labels_left_out": left_out}
        return tuple(marks)


def _round_step(rough: float) -> float:
    ten = 10.0 ** math.floor(math.log10(rough))
    return min((ten * m for m in (1, 2, 5, 10)), key=lambda step: abs(math.log(step / rough)))


def _multiples(low: float, high: float, step: float) -> FloatArray:
    """Multiples of a step between two numbers, ends included but for rounding."""
    slack = 1e-9 * (high - low)
    first, last = math.ceil((low - slack) / step), math.floor((high + slack) / step)
    return np.array([n * step for n in range(first, last + 1)], dtype=np.float64)


def _is_far(view: View, axis: int, side: int) -> bool:
    """Whether a face of the box shows its inside."""
    out = 2 * side - 1
    if isinstance(view.camera, Orthographic):
        return out * float(view.camera.basis()[2][axis]) > FACE_ON
    place = (view.high if side else view.low)[axis]
    return out * float(place - view.camera.eye[axis]) > FACE_ON * view.extent_world


def _on_face(
    face: tuple[int, int], values: list[FloatArray], low: FloatArray, high: FloatArray
) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Ends of the lines on a face, and of its edges."""
    axis, side = face
    found = []
    for across in (n for n in range(3) if n != axis):
        along = 3 - axis - across
        for value in {float(low[across]), float(high[across]), *(float(v) for v in values[across])}:
            ends = np.array([low, high])
            ends[:, axis] = (low, high)[side][axis]
            ends[:, across] = value
            ends[:, along] = low[along], high[along]
            found.append((tuple(ends[0].tolist()), tuple(ends[1].tolist())))
    return found


def _labelled_edge(view: View, axis: int, faces: set[tuple[int, int]]) -> FloatArray | None:
    """Ends (2, 3) of the edge along an axis with one far face beside it: the lowest in the image, or that most to the left.

    From within there is no such edge; cameras that look all round have any of them.
    """
    first, second = (n for n in range(3) if n != axis)
    found = []
    sees_all = view.camera.looks_round and len(faces) == 6
    for one, other in product((0, 1), repeat=2):
        if ((first, one) in faces) == ((second, other) in faces) and not sees_all:
            continue
        ends = np.array([view.low, view.high])
        ends[:, first] = (view.low, view.high)[one][first]
        ends[:, second] = (view.low, view.high)[other][second]
        seen = view.placed(ends)[:, :2]
        if np.isfinite(seen).all():
            found.append((seen, ends))
    if not found:
        return None
    ways = np.abs(sum(seen[1] - seen[0] for seen, _ in found))
    place = 1 if ways[0] >= ways[1] else 0
    sign = 1 if place == 1 else -1
    return max(found, key=lambda pair: sign * pair[0][:, place].mean())[1]


def _away(view: View, points_world: FloatArray, way_world: FloatArray, middle: FloatArray) -> FloatArray:
    """Unit vectors (n, 2) across an edge at its points (n, 3) in the image, from the middle of the box outwards."""
    ways = view.moved(points_world, np.broadcast_to(way_world, points_world.shape))
    across = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    across = np.where(length > 0, across / np.where(length > 0, length, 1.0), (0.0, 1.0))
    outwards = ((view.placed(points_world)[:, :2] - middle) * across).sum(axis=1) >= 0
    return np.where(outwards[:, None], across, -across)


def _beside(view: View, at: FloatArray, away: FloatArray, words: str) -> Text:
    """Words beside a point, as near as their box allows."""
    trial = Text(0.0, 0.0, words, view.text_px, view.ink)
    left, top, right, bottom = trial.box
    reach = 0.45 * view.text_px + abs(away[0]) * (right - left) / 2 + abs(away[1]) * (bottom - top) / 2
    x, y = at + reach * away
    return Text(float(x), float(y), words, view.text_px, view.ink)
