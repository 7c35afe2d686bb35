"""Gestures to cameras: what a drag, a wheel, a key or a finger does to what is looked at.

Every host sends the same messages, in parts of the view's height, so that one table of bindings and one set of functions
serves the page, notebooks and windows.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import ValueRangeError
from ..stages.camera import Camera, Orthographic
from ..volume import FloatArray
from .document import Document

TURN_RAD = math.pi
"""Angle that a drag over the whole height turns."""

# What of the pointer makes which gesture: (buttons, modifier) -> kind.
BINDINGS: tuple[dict[str, str], ...] = (
    {"pointer": "left", "kind": "orbit", "help": "turn"},
    {"pointer": "left", "modifier": "Shift", "kind": "pan", "help": "move sideways"},
    {"pointer": "middle", "kind": "pan", "help": "move sideways"},
    {"pointer": "right", "kind": "dolly", "help": "nearer and farther"},
    {"pointer": "wheel", "kind": "dolly", "help": "nearer and farther"},
)


def applied(document: Document, gesture: Mapping[str, Any], size_px: tuple[int, int]) -> Document:
    """Return a document after a gesture.

    Parameters
    ----------
    document
        What is shown.
    gesture
        ``kind``, and ``dx``, ``dy`` to the right and down in parts of the view's height.
    size_px
        Width and height of the view.

    Raises
    ------
    ValueRangeError
        For unknown kinds.
    """
    kind = gesture.get("kind")
    if kind not in GESTURES:
        raise ValueRangeError("gesture.kind", f"is {kind!r:.80}, must be one of {', '.join(GESTURES)}")
    dx, dy = (float(gesture.get(name, 0.0)) for name in ("dx", "dy"))
    if not (math.isfinite(dx) and math.isfinite(dy)):
        raise ValueRangeError("gesture", "must be finite")
    return document.with_camera(GESTURES[kind](document.camera, dx, dy))


def orbit(camera: Camera, dx: float, dy: float) -> Camera:
    """Turn round the target: about what is up, and about what is to the right, short of the poles."""
    right, _, forward = camera.basis()
    up = np.asarray(camera.up, dtype=np.float64) / np.linalg.norm(camera.up)
    height = math.asin(max(-1.0, min(1.0, float(-forward @ up))))
    rise = max(-1.5, min(1.5, height + dy * TURN_RAD)) - height
    turn = rotation(up, -dx * TURN_RAD) @ rotation(right, -rise)
    return _placed(camera, np.asarray(camera.target) + turn @ np.subtract(camera.eye, camera.target), camera.target)


def pan(camera: Camera, dx: float, dy: float) -> Camera:
    """Move sideways by what lies under the pointer at the target's depth."""
    right, up, _ = camera.basis()
    height = shown_height(camera)
    by = (-dx * right + dy * up) * height
    return _placed(camera, np.asarray(camera.eye) + by, np.asarray(camera.target) + by)


def dolly(camera: Camera, dx: float, dy: float) -> Camera:
    """Go nearer (dragged up) or farther by a share of the distance; parallel rays show less or more."""
    factor = math.exp(2 * max(-2.0, min(2.0, dy)))
    if isinstance(camera, Orthographic):
        return dataclasses.replace(camera, height=camera.height * factor)
    eye = np.asarray(camera.target) + np.subtract(camera.eye, camera.target) * factor
    return _placed(camera, eye, camera.target)


GESTURES: dict[str, Callable[[Camera, float, float], Camera]] = {"orbit": orbit, "pan": pan, "dolly": dolly}


def shown_height(camera: Camera) -> float:
    """World units from bottom to top of the view at the target's depth."""
    if isinstance(camera, Orthographic):
        return camera.height
    distance = float(np.linalg.norm(np.subtract(camera.eye, camera.target)))
    return 2 * distance * math.tan(math.radians(getattr(camera, "fov_deg", 60.0)) / 2)


def rotation(axis: FloatArray, angle_rad: float) -> FloatArray:
    """Matrix (3, 3) that turns about a unit axis, by the right hand."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: FloatArray = np.eye(3) + math.sin(angle_rad) * cross + (1 - math.cos(angle_rad)) * (cross @ cross)
    return turned


def _placed(camera: Camera, eye: Any, target: Any) -> Camera:
    frame: Any = camera
    placed: Camera = dataclasses.replace(frame, eye=tuple(float(v) for v in eye), target=tuple(float(v) for v in target))
    return placed
