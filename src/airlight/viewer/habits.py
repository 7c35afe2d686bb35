"""Habits of a view: how it is turned, where it comes back to, which standpoints it keeps. They are no part of the document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..errors import ValueRangeError
from ..scene_file.writing import plain_stage
from ..stages.camera import Camera, Perspective
from .document import Document

if TYPE_CHECKING:
    from .bookmarks import Bookmark

TURNINGS = ("turntable", "trackball", "fly")
SHOWN = ("cube", "scale", "status")
FOV_DEG = 30.0


@dataclass(frozen=True)
class Habits:
    """How a view is turned.

    Parameters
    ----------
    home
        Camera that ``reset`` comes back to; its ``up`` is the axis of the turntable in views along it.
    turning
        What a drag does: ``"turntable"`` keeps upright what stands so, ``"trackball"`` rolls freely, ``"fly"`` looks round.
    before
        How it was turned before it flew.
    fov_deg
        Angle of view that comes back when parallel rays end.
    hidden
        Which of ``SHOWN`` are not drawn over the picture.
    bookmarks
        Standpoints by name.
    recalled
        Name of the last one that was gone to.
    """

    home: Camera
    turning: str = TURNINGS[0]
    before: str = TURNINGS[0]
    fov_deg: float = FOV_DEG
    hidden: tuple[str, ...] = ()
    bookmarks: tuple[Bookmark, ...] = ()
    recalled: str = ""

    @staticmethod
    def of(document: Document) -> Habits:
        """Return the habits of a view that begins with a document."""
        return Habits(document.camera).seen(document.camera)

    def turned_by(self, name: str) -> Habits:
        """Return them with another way to turn; the one that they have gives way to the one before.

        Raises
        ------
        ValueRangeError
            For ways that are none of ``TURNINGS``.
        """
        if name not in TURNINGS:
            raise ValueRangeError("turning", f"is {name!r:.80}, must be one of {', '.join(TURNINGS)}")
        if name == self.turning:
            name = self.before if name == "fly" else TURNINGS[0]
        return replace(self, turning=name, before=self.turning if name == "fly" else name)

    def changed(self, message: Mapping[str, Any]) -> Habits:
        """Return them after a message of a client: ``turning``, and ``hidden`` as a list.

        Raises
        ------
        ValueRangeError
            For names that are unknown.
        """
        hidden = message.get("hidden", self.hidden)
        if not isinstance(hidden, (list, tuple)) or not set(map(str, hidden)) <= set(SHOWN):
            raise ValueRangeError("habits.hidden", f"is {hidden!r:.80}", f"list some of {', '.join(SHOWN)}")
        turning = message.get("turning", self.turning)
        changed = self if turning == self.turning else self.turned_by(str(turning))
        return replace(changed, hidden=tuple(name for name in SHOWN if name in hidden))

    def seen(self, camera: Camera) -> Habits:
        """Return them knowing the angle of a camera that was looked through."""
        return replace(self, fov_deg=camera.fov_deg) if isinstance(camera, Perspective) else self

    def at_home(self, before: Document, after: Document) -> Habits:
        """Return them for a document that takes the place of another: where none of its volumes stays, home is there."""
        stay = {id(layer.volume) for layer in before.scene.layers} & {id(layer.volume) for layer in after.scene.layers}
        return self if stay else replace(self, home=after.camera).seen(after.camera)

    def plain(self) -> dict[str, Any]:
        """Return what clients see of them."""
        marks = [{"name": mark.name, "whole": mark.document is not None} for mark in self.bookmarks]
        told = {"turning": self.turning, "hidden": list(self.hidden), "bookmarks": marks}
        return told | {"home": plain_stage(self.home), "turnings": list(TURNINGS), "shown": list(SHOWN)}
