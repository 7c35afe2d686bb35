"""Turning about what is under the pointer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...transfer.given import finite_numbers
from ..asking import answers
from ..gestures import Gesture
from ..gesturing import take_one
from .probe import probe

if TYPE_CHECKING:
    from ..session import Session


@answers("aim")
def aim(session: Session, at: Any, seconds: float = 0.0) -> dict[str, Any]:
    """Make what the picture shows at a place the target of the camera, and move it to the middle.

    Parameters
    ----------
    session
        Whose picture.
    at
        The place from the middle of the view, in parts of its height.
    seconds
        How long the camera travels.

    Returns
    -------
    dict
        What ``probe`` tells of the place; where it hits nothing, the camera stays.
    """
    across, down = finite_numbers(at, "aim.at", 2)
    width, height = session.size_px
    told = probe(session, 0.5 + across * height / width, 0.5 + down)
    if told["hit"]:
        take_one(session, Gesture.of({"kind": "target", "p_world": told["p_world"], "seconds": seconds}))
    return told
