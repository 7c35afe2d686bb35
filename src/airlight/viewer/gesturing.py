"""What gestures do to a session: cameras that jump or travel, windows of transfer functions, ways to turn, bookmarks."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..errors import AirlightError, LimitError, ValueRangeError
from ..movies.between import camera_between, smooth
from ..stages.camera import Camera, Orthographic
from . import bookmarks
from .gestures import CAMERAS, Gesture, applied
from .gestures.standing import other_projection
from .windowing import window_of, windowed

if TYPE_CHECKING:
    from .session import Session

MOST_AT_ONCE = 16
TICK_S = 1 / 60


def take(session: Session, message: Mapping[str, Any]) -> None:
    """Do what a message of one gesture, or of ``all`` of those of an animation frame, asks.

    Raises
    ------
    ValueRangeError
        For unknown kinds and wrong numbers.
    LimitError
        For too many at once.
    """
    several = message.get("all", (message,))
    if not isinstance(several, Sequence) or isinstance(several, str) or len(several) > MOST_AT_ONCE:
        raise LimitError("gesture.all", f"must be a list of at most {MOST_AT_ONCE}", "send fewer at once")
    for gesture in [Gesture.of(part) for part in several if isinstance(part, Mapping)]:
        take_one(session, gesture)


def take_one(session: Session, gesture: Gesture) -> None:
    """Do what one gesture asks; raises what ``take`` does."""
    OTHERS.get(gesture.kind, _camera)(session, gesture)


def _camera(session: Session, gesture: Gesture) -> None:
    """Change the camera, or let it travel to where the gesture leads."""
    if gesture.kind not in CAMERAS:
        raise ValueRangeError("gesture.kind", f"is {gesture.kind!r:.80}, must be one of {', '.join((*CAMERAS, *OTHERS))}")
    if gesture.seconds > 0:
        travel(session, applied(session.document, gesture, session.habits, session.size_px).camera, gesture.seconds)
        return
    session.travels += 1
    session.look(lambda document: applied(document, gesture, session.habits, session.size_px))


def travel(session: Session, camera: Camera, seconds: float) -> None:
    """Let the camera of a session travel to another; the next gesture ends it where it is."""
    session.travels += 1
    journey, start = session.travels, time.monotonic()
    first = session.camera
    _show(session, first, journey)  # a view that follows another is refused here, and not on the way
    if isinstance(first, Orthographic) != isinstance(camera, Orthographic):
        first = other_projection(first, session.habits.fov_deg)

    def go() -> None:
        share = 0.0
        while share < 1 and session.travels == journey:
            share = min((time.monotonic() - start) / seconds, 1.0)
            with contextlib.suppress(AirlightError):
                _show(session, camera_between(first, camera, smooth(share)), journey)
            time.sleep(TICK_S)

    threading.Thread(target=go, name="airlight-travel", daemon=True).start()


def _show(session: Session, camera: Camera, journey: int) -> None:
    """Show what a journey has come to, unless it is over."""
    session.look(lambda document: document.with_camera(camera) if session.travels == journey else document)


def _window(session: Session, gesture: Gesture) -> None:
    """Move and stretch a layer's transfer function: by equal factors to the right, by parts of its width upwards."""
    document = session.document
    layers = document.scene.layers
    if gesture.layer >= len(layers):
        raise ValueRangeError("gesture.layer", f"is {gesture.layer}", f"there are {len(layers)}")
    layer = layers[gesture.layer]
    assert layer.transfer is not None
    centre, width = window_of(layer.transfer)
    step = width if width > 0 else max(abs(centre), 1.0)
    function = windowed(layer.transfer, centre - gesture.dy * step, width * math.exp(2 * gesture.dx))
    changed = (*layers[: gesture.layer], replace(layer, transfer=function), *layers[gesture.layer + 1 :])
    session.change(replace(document, scene=replace(document.scene, layers=changed)), f"window {gesture.stroke}")


def _turning(session: Session, gesture: Gesture) -> None:
    session.keep(lambda habits: habits.turned_by(gesture.name))


def _bookmark(session: Session, gesture: Gesture) -> None:
    document = session.document
    session.keep(lambda habits: replace(habits, bookmarks=bookmarks.added(habits.bookmarks, document, gesture.name)))


def _recall(session: Session, gesture: Gesture) -> None:
    """Go to a bookmark, without a name to the next (``dx`` 1) or the one before; a whole document is a step of undo."""
    habits = session.habits
    mark = bookmarks.found(habits.bookmarks, gesture.name or bookmarks.beside(habits.bookmarks, habits.recalled, gesture.dx))
    session.keep(lambda habits: replace(habits, recalled=mark.name))
    if mark.document is not None:
        session.change(mark.document.with_camera(session.camera))
    if gesture.seconds > 0:
        travel(session, mark.camera, gesture.seconds)
    else:
        session.travels += 1
        session.look(lambda document: document.with_camera(mark.camera))


OTHERS = {"window": _window, "turning": _turning, "bookmark": _bookmark, "recall": _recall}
"""Kinds of gestures that change more than the camera."""
