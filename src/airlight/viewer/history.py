"""Undo and redo: documents that were, and those that were taken back."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .document import Document

MOST_STEPS = 200
MOST_BYTES = 2 << 30
"""Most that volumes may take which are not shown any more and which undo brings back."""


@dataclass(frozen=True)
class History:
    """A document with those before and after it. A turn of the camera is no step: what is undone is seen from where one is."""

    document: Document
    past: tuple[Document, ...] = ()
    future: tuple[Document, ...] = ()
    merge: str = ""

    def edited(self, document: Document, merge: str = "") -> History:
        """Return the history after an edit; with the same ``merge`` as the edit before, both are one step."""
        if document.with_camera(self.document.camera) == self.document:
            return replace(self, document=document)
        joined = bool(merge) and merge == self.merge and bool(self.past)
        past = self.past if joined else (*self.past, self.document)[-MOST_STEPS:]
        return History(document, _affordable(past, document), (), merge)

    def undone(self) -> History:
        """Return the history before the last step; itself where there is none."""
        if not self.past:
            return self
        before = self.past[-1].with_camera(self.document.camera)
        return History(before, self.past[:-1], (self.document, *self.future))

    def redone(self) -> History:
        """Return the history with the last undone step done again; itself where there is none."""
        if not self.future:
            return self
        after = self.future[0].with_camera(self.document.camera)
        return History(after, (*self.past, self.document), self.future[1:])


def _affordable(past: tuple[Document, ...], document: Document) -> tuple[Document, ...]:
    """The last steps before a document, as far back as their volumes do not take too much."""
    sizes = {id(volume): 0 for volume in document.volumes}
    for count, step in enumerate(reversed(past)):
        for volume in step.volumes:
            sizes.setdefault(id(volume), volume.array.nbytes)
        if sum(sizes.values()) > MOST_BYTES:
            return past[len(past) - count :]
    return past
