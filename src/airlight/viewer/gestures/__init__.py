"""Gestures to cameras: what a drag, a wheel, a key or a finger does to what is looked at.

Every host sends the same messages, in parts of the view's height, so that one table of bindings and one set of functions
serves the page, notebooks and windows. Distances on the screen are to the right and down; places are counted from the middle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import ValueRangeError
from ...scene import Scene
from ...stages.camera import Camera
from ...transfer.given import finite, finite_numbers, whole
from ...volume import FloatArray
from ..document import Document
from ..habits import Habits
from . import moving, standing, turning
from .bindings import BINDINGS as BINDINGS
from .bindings import bound as bound

Vec3 = tuple[float, float, float]
MOST = 4.0
"""Longest drag of one gesture, in heights of the view: more comes from no hand."""
LONGEST_S = 2.0
LONGEST_NAME = 200


@dataclass(frozen=True)
class Gesture:
    """One gesture, as it comes from a host.

    Parameters
    ----------
    kind
        One of ``CAMERAS``, or of what hosts of a session know beside (``gesturing``).
    dx, dy, dz
        To the right, down and forward, in parts of the view's height.
    at
        Where the pointer is, from the middle of the view, in parts of its height.
    name
        Of a view, a way to turn, or a bookmark.
    direction
        From the target to the eye, for ``view``.
    p_world
        Point, for ``target``.
    seconds
        How long the camera travels; 0 jumps.
    stroke
        Number of the drag: what belongs to one is one step of undo.
    layer
        What ``window`` changes.
    """

    kind: str
    dx: float = 0.0
    dy: float = 0.0
    dz: float = 0.0
    at: tuple[float, float] | None = None
    name: str = ""
    direction: Vec3 | None = None
    p_world: Vec3 | None = None
    seconds: float = 0.0
    stroke: int = 0
    layer: int = 0

    @staticmethod
    def of(message: Mapping[str, Any]) -> Gesture:
        """Return the gesture of a message; numbers beyond what hands do are bounded.

        Raises
        ------
        ValueRangeError
            For entries that are not what they must be.
        """
        given: dict[str, Any] = {"kind": str(message.get("kind"))[:LONGEST_NAME]}
        for name in ("dx", "dy", "dz"):
            given[name] = min(max(finite(message.get(name, 0.0), f"gesture.{name}"), -MOST), MOST)
        for name, count in (("at", 2), ("direction", 3), ("p_world", 3)):
            if message.get(name) is not None:
                given[name] = finite_numbers(message[name], f"gesture.{name}", count)
        if "at" in given:
            given["at"] = tuple(min(max(x, -MOST), MOST) for x in given["at"])
        given["seconds"] = min(max(finite(message.get("seconds", 0.0), "gesture.seconds"), 0.0), LONGEST_S)
        for name in ("stroke", "layer"):
            given[name] = whole(message.get(name, 0), f"gesture.{name}", 0)
        return Gesture(name=str(message.get("name", ""))[:LONGEST_NAME], **given)


@dataclass(frozen=True, eq=False)
class Around:
    """What gestures look at beside the camera: corners (n, 3) of what is shown, width over height of the view, habits."""

    corners_world: FloatArray
    aspect: float
    habits: Habits

    @property
    def span(self) -> float:
        """Diagonal of what is shown, in world units."""
        return float(np.linalg.norm(self.corners_world.max(axis=0) - self.corners_world.min(axis=0))) or 1.0


def applied(document: Document, gesture: Gesture, habits: Habits, size_px: tuple[int, int]) -> Document:
    """Return a document after a gesture that changes its camera.

    Parameters
    ----------
    document
        What is shown.
    gesture
        What was done.
    habits
        How the view is turned.
    size_px
        Width and height of the view.

    Raises
    ------
    ValueRangeError
        For unknown kinds, and what the gesture lacks.
    """
    if gesture.kind not in CAMERAS:
        raise ValueRangeError("gesture.kind", f"is {gesture.kind!r:.80}, must be one of {', '.join(CAMERAS)}")
    around = Around(corners_of(document.scene), size_px[0] / size_px[1], habits)
    return document.with_camera(CAMERAS[gesture.kind](document.camera, gesture, around))


def corners_of(scene: Scene) -> FloatArray:
    """Corners (n, 3) of all that a scene shows, in the world."""
    boxes = [
        layer.volume.corners_world(cells=getattr(layer.look.field, "cells", False))
        for layer in scene.visible_layers or scene.layers
    ]
    return np.concatenate([*boxes, *(np.asarray(shape.corners_world) for shape in scene.meshes)])


def _orbit(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    how = {"turntable": _turntable, "trackball": _trackball, "fly": _look}[around.habits.turning]
    return how(camera, gesture, around)


def _turntable(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    return turning.turntable(camera, gesture.dx, gesture.dy, around.habits.home.up)


def _trackball(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    return turning.trackball(camera, gesture.dx, gesture.dy)


def _look(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    return turning.look(camera, gesture.dx, gesture.dy)


def _dolly(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    if around.habits.turning == "fly":
        return moving.fly(camera, 0, 0, -gesture.dy / moving.FLIGHT / 2, around.span)
    return moving.dolly(camera, gesture.dy, gesture.at, around.span, around.habits.fov_deg)


def _view(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    pole = around.habits.home.up
    if gesture.direction is None:
        return standing.named(camera, gesture.name, pole)
    if not 0 < math.hypot(*gesture.direction) < math.inf:
        raise ValueRangeError("gesture.direction", f"is {gesture.direction}, must have a length")
    return standing.seen_from(camera, gesture.direction, pole)


def _fov(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    return standing.of_angle(camera, getattr(camera, "fov_deg", 0.0) * math.exp(2 * gesture.dy))


def _target(camera: Camera, gesture: Gesture, around: Around) -> Camera:
    if gesture.p_world is None:
        raise ValueRangeError("gesture.p_world", "is missing", "give the point, x, y, z")
    return moving.aimed(camera, gesture.p_world)


CAMERAS: dict[str, Callable[[Camera, Gesture, Around], Camera]] = {
    "orbit": _orbit,
    "turntable": _turntable,
    "trackball": _trackball,
    "look": _look,
    "pan": lambda camera, gesture, around: moving.pan(camera, gesture.dx, gesture.dy),
    "dolly": _dolly,
    "roll": lambda camera, gesture, around: turning.roll(camera, gesture.dx),
    "fly": lambda camera, gesture, around: moving.fly(camera, gesture.dx, gesture.dy, gesture.dz, around.span),
    "view": _view,
    "fit": lambda camera, gesture, around: standing.fitted(camera, around.corners_world, around.aspect, around.habits.fov_deg),
    "reset": lambda camera, gesture, around: around.habits.home,
    "orthographic": lambda camera, gesture, around: standing.other_projection(camera, around.habits.fov_deg),
    "fov": _fov,
    "target": _target,
}
"""What each kind of gesture does to a camera."""
