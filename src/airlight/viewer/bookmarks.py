"""Bookmarks: standpoints with a name, and whole states where that is wanted."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import LimitError, ValueRangeError
from ..movies.keys import Keyframe, Keyframes, Stop, changes_of
from ..movies.saving import scene_beside
from ..scene import Scene
from ..scene_file.writing import plain_stage
from ..stages.camera import Camera
from .document import Document

MOST = 100
LONGEST_NAME = 80
SECONDS = 2.0
"""Between two bookmarks that are made keys of a movie."""


@dataclass(frozen=True)
class Bookmark:
    """A camera with a name, and the whole document where that was kept, too."""

    name: str
    camera: Camera
    document: Document | None = None


def added(marks: tuple[Bookmark, ...], document: Document, name: str = "", whole: bool = False) -> tuple[Bookmark, ...]:
    """Return bookmarks with one of what is seen; it takes the place of one of its name. Without a name it gets a number.

    Raises
    ------
    ValueRangeError
        For names that are too long.
    LimitError
        When there are too many.
    """
    known = {mark.name for mark in marks}
    name = name.strip() or next(found for n in range(1, MOST + 2) if (found := f"View {n}") not in known)
    _check_name(name)
    mark = Bookmark(name, document.camera, document if whole else None)
    if name in known:
        return tuple(mark if other.name == name else other for other in marks)
    if len(marks) >= MOST:
        raise LimitError("bookmarks", f"are {MOST} already", "remove some")
    return (*marks, mark)


def removed(marks: tuple[Bookmark, ...], name: str) -> tuple[Bookmark, ...]:
    """Return bookmarks without one."""
    gone = found(marks, name)
    return tuple(mark for mark in marks if mark is not gone)


def renamed(marks: tuple[Bookmark, ...], name: str, to: str) -> tuple[Bookmark, ...]:
    """Return bookmarks with one called otherwise.

    Raises
    ------
    ValueRangeError
        For a name that another has, or that is too long.
    """
    _check_name(to)
    changed = found(marks, name)
    if any(mark.name == to and mark is not changed for mark in marks):
        raise ValueRangeError("bookmark", f"{to!r} is there already", "take another name")
    return tuple(replace(mark, name=to) if mark is changed else mark for mark in marks)


def found(marks: tuple[Bookmark, ...], name: str) -> Bookmark:
    """Return the bookmark of a name.

    Raises
    ------
    ValueRangeError
        When there is none.
    """
    for mark in marks:
        if mark.name == name:
            return mark
    raise ValueRangeError("bookmark", f"is {name!r:.80}", f"known: {', '.join(mark.name for mark in marks) or 'none'}")


def beside(marks: tuple[Bookmark, ...], name: str, way: float) -> str:
    """Return the name of the bookmark behind one, or before it for a way below 0; of none, the first or the last.

    Raises
    ------
    ValueRangeError
        When there are none.
    """
    names = [mark.name for mark in marks]
    if not names:
        raise ValueRangeError("bookmark", "is not there", "keep a view first (B)")
    step = 1 if way >= 0 else -1
    at = names.index(name) if name in names else -1 if step > 0 else 0
    return names[(at + step) % len(names)]


def of_keyframes(path: str | os.PathLike[str], document: Document) -> tuple[Bookmark, ...]:
    """Return the keys of a movie that stand in a document's scene file, in their order; none where there are none.

    Raises
    ------
    AirlightError
        For keys that the scene cannot follow.
    """
    found, _ = scene_beside(path) if is_table(path) else (None, "")
    if found is None:
        return ()
    stops = found.of(document.scene, folder=Path(path).absolute().parent).stops

    def mark(n: int, stop: Stop) -> Bookmark:
        whole = any(not name.startswith("camera") for name in stop.key.changes)
        return Bookmark(f"Key {n}", stop.camera, replace(document, scene=stop.scene) if whole else None)

    return tuple(mark(n, stop) for n, stop in enumerate(stops[:MOST], start=1))


def is_table(path: str | os.PathLike[str]) -> bool:
    """Whether a path is that of a scene file."""
    return os.fspath(path).lower().endswith((".toml", ".json"))


def keyframes(marks: Iterable[Bookmark], scene: Scene, size_px: tuple[int, int] = (512, 512)) -> Keyframes | None:
    """Return the bookmarks as keys of a movie of a scene, in their order; None where there are none.

    Whole states of other volumes are left out.
    """
    volumes = [layer.volume for layer in scene.layers]
    keys: list[Keyframe] = []
    for mark in marks:
        changes = {}
        if mark.document is not None:
            others = [layer.volume for layer in mark.document.scene.layers]
            if len(others) != len(volumes) or any(a is not b for a, b in zip(others, volumes, strict=True)):
                continue
            changes = changes_of(mark.document.scene, scene, size_px)
        keys.append(Keyframe(len(keys) * SECONDS, {**changes, "camera": plain_stage(mark.camera)}))
    return Keyframes(tuple(keys)) if keys else None


def _check_name(name: str) -> None:
    if not 0 < len(name) <= LONGEST_NAME or not name.isprintable():
        raise ValueRangeError("bookmark.name", f"is {name!r:.90}", f"take 1 to {LONGEST_NAME} characters")
