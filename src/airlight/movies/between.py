"""What lies between two keys: numbers are blended, cameras travel on spheres, words change at the later key."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from ..stage import stage_fields
from ..stages.camera import Camera, point_of
from ..volume import FloatArray

IN_LABELS = re.compile(r"^layers\[\d+\]\.labels\b")
HALF_TURN = 1e-6  # sine below which two poses are opposite, and the axis does not follow from it


def smooth(share: float) -> float:
    """Share of the way that begins and ends at rest: a cubic, 0 at 0, 1 at 1."""
    return share * share * (3 - 2 * share)


EASINGS: dict[str, Callable[[float], float]] = {"linear": float, "smooth": smooth}


def between(first: Any, second: Any, share: float, where: str = "") -> Any:
    """Blend plain data of one shape.

    Numbers lie on the line between both, whole numbers on the nearest whole one. Words, truth values, stages of different
    names, numbers of channels, lists of lights or clips of different lengths, and tables of labels with different entries are
    those of ``first``.

    Parameters
    ----------
    first, second
        Tables, lists, numbers and words.
    share
        How far from the first to the second, in [0, 1).
    where
        Path of both, for messages.

    Raises
    ------
    ValueRangeError
        For lists of numbers or points of different lengths, and tables of different entries.
    """
    if first == second or where.endswith(".channel") or _are_different_things(first, second):
        return first
    if isinstance(first, Mapping):
        if IN_LABELS.search(where) and set(first) != set(second):
            return first
        for key in sorted(set(first) ^ set(second)):
            raise ValueRangeError(_dotted(where, key), "is given at one key only", "give it at both")
        return {key: between(first[key], second[key], share, _dotted(where, key)) for key in first}
    if isinstance(first, list):
        if len(first) != len(second):
            what = f"has {len(first)} entries at one key and {len(second)} at the next"
            raise ValueRangeError(where, what, "give both the same number")
        parts = enumerate(zip(first, second, strict=True))
        return [between(one, other, share, f"{where}[{n}]") for n, (one, other) in parts]
    blended = first + share * (second - first)
    return math.floor(blended + 0.5) if isinstance(first, int) and isinstance(second, int) else blended


def _are_different_things(first: Any, second: Any) -> bool:
    """Whether two values have nothing between them."""
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        return any(first.get(key) != second.get(key) for key in ("name", "kind"))
    if isinstance(first, list) and isinstance(second, list):
        return len(first) != len(second) and any(isinstance(part, Mapping) for part in (*first, *second))
    return not (_is_number(first) and _is_number(second))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _dotted(where: str, key: str) -> str:
    return f"{where}.{key}".removeprefix(".")


# -- cameras


def camera_between(first: Camera, second: Camera, share: float) -> Camera:
    """Camera on the way between two of one kind; of different kinds, the first.

    The target goes straight, the eye on a sphere round it: one turn about one axis, while its distance changes by equal
    factors in equal parts of the way. So does the height of parallel views; all other numbers are blended.

    Parameters
    ----------
    first, second
        Both ends.
    share
        How far from the first to the second, in [0, 1].
    """
    if type(first) is not type(second) or first == second or share <= 0:
        return first
    if share >= 1:
        return second
    before, after = _pose(first), _pose(second)
    axis, angle_rad = turn_between(before, after)
    right_up_back = rotation(axis, share * angle_rad) @ before
    target = (1 - share) * np.array(first.target) + share * np.array(second.target)
    distance = _by_factors(math.dist(first.eye, first.target), math.dist(second.eye, second.target), share)
    changes: dict[str, Any] = {
        "eye": point_of(target + distance * right_up_back[:, 2]),
        "target": point_of(target),
        "up": point_of(right_up_back[:, 1]),
    }
    for field in stage_fields(type(first)):
        if field.name not in changes:
            ends = getattr(first, field.name), getattr(second, field.name)
            blend = _by_factors if field.name == "height" else between
            changes[field.name] = blend(*ends, share)
    blended: Camera = dataclasses.replace(first, **changes)  # type: ignore[type-var]
    return blended


def _pose(camera: Camera) -> FloatArray:
    """Matrix (3, 3) whose columns point to the right, up and back, in the world."""
    right, up, forward = camera.basis()
    return np.stack([right, up, -forward], axis=1)


def _by_factors(first: float, second: float, share: float) -> float:
    return float(first * (second / first) ** share)


def turn_between(before: FloatArray, after: FloatArray) -> tuple[FloatArray, float]:
    """Axis, of length one, and angle in [0, pi] of the turn that leads from one matrix (3, 3) of axes to another.

    Half turns have two axes: the one that is nearer to up of the first is taken.
    """
    turn = after @ before.T
    sines = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = float(np.linalg.norm(sines))
    angle_rad = math.atan2(sine, float(np.trace(turn)) - 1)
    if sine > HALF_TURN:
        return sines / sine, angle_rad
    if angle_rad < 1:
        return np.array([0.0, 0.0, 1.0]), 0.0
    # A half turn is 2 axis axis^T - 1.
    doubled = turn + np.eye(3)
    axis = doubled[:, int(np.argmax(np.diag(doubled)))]
    axis = axis / np.linalg.norm(axis)
    return (-axis if axis @ before[:, 1] < 0 else axis), math.pi


def rotation(axis: npt.ArrayLike, angle_rad: float) -> FloatArray:
    """Matrix (3, 3) that turns by an angle about an axis of length one, counterclockwise where it points to the eye."""
    x, y, z = np.asarray(axis, dtype=np.float64)
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])  # the cross product with the axis
    return np.asarray(np.eye(3) + math.sin(angle_rad) * across + (1 - math.cos(angle_rad)) * (across @ across))
