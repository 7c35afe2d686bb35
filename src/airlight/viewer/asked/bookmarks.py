"""Bookmarks of a view: kept, removed, renamed. Gestures recall them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .. import bookmarks
from ..asking import answers

if TYPE_CHECKING:
    from ..session import Session

Marks = tuple[bookmarks.Bookmark, ...]


@answers("bookmarks.add")
def add(session: Session, name: str = "", whole: bool = False) -> dict[str, Any]:
    """Keep what is seen, and the whole state where that is wanted."""
    document = session.document
    return _kept(session, lambda marks: bookmarks.added(marks, document, str(name), bool(whole)))


@answers("bookmarks.remove")
def remove(session: Session, name: str) -> dict[str, Any]:
    """Forget one."""
    return _kept(session, lambda marks: bookmarks.removed(marks, str(name)))


@answers("bookmarks.rename")
def rename(session: Session, name: str, to: str) -> dict[str, Any]:
    """Call one otherwise."""
    return _kept(session, lambda marks: bookmarks.renamed(marks, str(name), str(to)))


def _kept(session: Session, change: Callable[[Marks], Marks]) -> dict[str, Any]:
    session.keep(lambda habits: replace(habits, bookmarks=change(habits.bookmarks)))
    return {"bookmarks": session.habits.plain()["bookmarks"]}
