"""The scenes of a movie, one a frame, before any is drawn."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable
from typing import Any

from ..errors import DataError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..scene import Scene
from ..transfer.given import finite, positive, whole
from .keys import Keyframes, checked_keyframes
from .targets import MOST_FRAMES
from .turning import Turntable

SECONDS = 6.0
STEPS_A_SECOND = 10.0
OVER = ("time",)


@dataclasses.dataclass(frozen=True)
class Plan:
    """What is seen in the course of a movie.

    Attributes
    ----------
    turntable
        What turns, if anything does.
    keyframes
        What changes, if keys tell it.
    over
        ``"time"`` plays all time steps of the volumes.
    seconds, frames
        How long it is, by one of them at most.
    """

    turntable: Turntable | None = None
    keyframes: Keyframes | None = None
    over: str | None = None
    seconds: float | None = None
    frames: int | None = None

    def scenes(self, scene: Scene, size_px: tuple[int, int], fps: float, folder: str = ".") -> list[Scene]:
        """Return the scene of each frame; those that are the same are one object.

        Raises
        ------
        AirlightError
            For keys that do not fit the scene, and volumes without time steps.
        """
        if self.keyframes is not None:
            course = self.keyframes.of(scene, size_px, folder)
            count = _bounded(self.keyframes.duration_s * fps + 1e-9, math.floor) + 1
            return [course.at(number / fps) for number in range(count)]
        scene = resolve(scene, size_px)
        steps = 1 if self.over is None else time_steps(scene)
        count = self._count(steps, fps)
        if count < steps:
            what = f"has {count} frames, and there are {steps} time steps"
            raise ValueRangeError("movie", what, f"give at least {steps / fps:g} seconds, or more frames a second")
        played = [_at_time(scene, step) for step in range(steps)] if self.over is not None else [scene]
        of_frames = [played[number * steps // count] for number in range(count)]
        if self.turntable is None:
            return of_frames
        last = count if self.turntable.closes else max(count - 1, 1)
        return [self.turntable.turned(one, number / last, size_px) for number, one in enumerate(of_frames)]

    def _count(self, steps: int, fps: float) -> int:
        if self.frames is not None:
            return self.frames
        if self.seconds is None and self.over is not None:
            return _bounded(steps * max(round(fps / STEPS_A_SECOND), 1))
        return max(_bounded((SECONDS if self.seconds is None else self.seconds) * fps), 1)


def make_plan(
    turns: float | Turntable | None = None,
    keyframes: Keyframes | Iterable[Any] | None = None,
    over: str | None = None,
    seconds: float | None = None,
    frames: int | None = None,
) -> Plan:
    """Return what is seen of what was asked for; one turn where nothing was.

    Raises
    ------
    ValueRangeError
        For what does not go together, and values out of range.
    """
    if over is not None and over not in OVER:
        raise ValueRangeError("over", f"is {over!r}, must be {' or '.join(map(repr, OVER))}")
    if seconds is not None and frames is not None:
        raise ValueRangeError("seconds", "and frames exclude each other", "leave one of them out")
    asked = {"turns": turns, "over": over, "seconds": seconds, "frames": frames}
    if keyframes is not None:
        for name, value in asked.items():
            if value is not None:
                what = f"is given beside keyframes, which tell {'how long it is' if value in (seconds, frames) else 'all'}"
                raise ValueRangeError(name, what, "leave it out")
        return Plan(keyframes=checked_keyframes(keyframes))
    if turns is None and over is None:
        turns = 1.0
    turntable = turns
    if turns is not None and not isinstance(turns, Turntable):
        turntable = Turntable(degrees=360 * finite(turns, "turns"))
    seconds = None if seconds is None else positive(seconds, "seconds")
    frames = None if frames is None else whole(frames, "frames", 1, MOST_FRAMES)
    return Plan(turntable, None, over, seconds, frames)  # type: ignore[arg-type]


def time_steps(scene: Scene) -> int:
    """Return how many time steps the volumes of a scene have; those with one are the same all the time.

    Raises
    ------
    DataError
        When none has several, or they have different numbers.
    """
    counts = {layer.volume.time_count for layer in scene.layers} - {1}
    if not counts:
        raise DataError("over='time'", "needs a volume of several time steps", "make one of an array (t, c, z, y, x)")
    if len(counts) > 1:
        raise DataError("over='time'", f"finds {' and '.join(map(str, sorted(counts)))} time steps", "use keyframes")
    return counts.pop()


def _at_time(scene: Scene, step: int) -> Scene:
    layers = (layer if layer.volume.time_count == 1 else dataclasses.replace(layer, time=step) for layer in scene.layers)
    return dataclasses.replace(scene, layers=tuple(layers))


def _bounded(count: float, whole_of: Callable[[float], int] = round) -> int:
    if count >= MOST_FRAMES + 1:
        raise LimitError("movie", f"would have {count:,.0f} frames, at most {MOST_FRAMES:,} are allowed", "make it shorter")
    return whole_of(count)
