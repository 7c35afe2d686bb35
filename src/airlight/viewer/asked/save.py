"""What is seen, as files: pictures, scene files, movies and pages to send. They come as buffers, and browsers save them."""

from __future__ import annotations

import io
import tempfile
import threading
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import AirlightError, LimitError, ValueRangeError
from ...rendering.image import Image, check_file_options
from ..asking import answers
from ..bookmarks import keyframes
from ..document import Document
from ..script import scene_text
from ..session import Session
from ..stream import Wanted, refines

MOST_SIDE_PX = 32768
MOST_PIXELS = 1 << 26
POLL_S = 0.1
KINDS = {"png": "image/png", "exr": "image/x-exr", "npy": "application/octet-stream"}
MOVIES = {"mp4": "video/mp4", "webm": "video/webm", "gif": "image/gif", "png": "image/png"}
WAYS = ("turntable", "bookmarks", "time")
PAGE_VOXELS = (64, 96, 128, 192, 256)

_works: weakref.WeakKeyDictionary[Session, threading.Event] = weakref.WeakKeyDictionary()


@answers("save.picture", slow=True)
def picture(
    session: Session,
    kind: str = "png",
    size_px: Any = None,
    transparent: bool = False,
    dither: bool = False,
    half: bool = False,
    depth: bool = False,
    refined: bool = False,
) -> tuple[dict[str, Any], list[bytes]]:
    """What is seen: sRGB in .png, or floats in .exr and .npy, of which the latter holds the depth if that is asked for.

    It is the picture at rest itself where that is as large; others are drawn at its step, or ``refined`` to its tolerance.
    """
    _one_of(kind, tuple(KINDS), "kind")
    size = checked_size(session, size_px)
    check_file_options(Path(f"-.{kind}"), bool(dither), bool(half))
    if depth and kind != "npy":
        raise ValueRangeError("depth", "is for .npy", "choose .npy, or .exr, which holds it beside the colours")
    with working(session) as check:
        image = seen(session, size, bool(transparent), bool(refined)) or drawn(
            session, session.document, size, bool(transparent), bool(refined), check
        )
    if kind == "npy":
        held = io.BytesIO()
        np.save(held, image.depth if depth else image.rgba, allow_pickle=False)
        data = held.getvalue()
    else:
        data = _file_of(kind, lambda path: image.save(path, dither=bool(dither), half=bool(half)))
    return _named("depth.npy" if depth else f"picture.{kind}", KINDS[kind]), [data]


@answers("save.scene")
def scene(session: Session) -> tuple[dict[str, Any], list[bytes]]:
    """The scene file of what is seen, with bookmarks as keyframes; it names volumes without their folders."""
    document, size = session.document, session.size_px
    marks = keyframes(session.habits.bookmarks, document.scene, size)
    return _named("scene.toml", "text/plain"), [scene_text(document, size, marks).encode()]


@answers("save.movie", slow=True)
def movie(
    session: Session,
    kind: str = "mp4",
    way: str = "turntable",
    size_px: Any = None,
    seconds: float | None = None,
    fps: float = 30.0,
) -> tuple[dict[str, Any], list[bytes]]:
    """A movie: a turn, the way from bookmark to bookmark, or the time steps."""
    from ...movies.course import make_plan
    from ...movies.making import write_movie
    from ...movies.targets import checked_target

    _one_of(kind, tuple(MOVIES), "kind")
    _one_of(way, WAYS, "way")
    size, document = checked_size(session, size_px), session.document
    keys = keyframes(session.habits.bookmarks, document.scene, size) if way == "bookmarks" else None
    if way == "bookmarks" and (keys is None or len(keys.keys) < 2):
        raise ValueRangeError("movie", "goes from bookmark to bookmark", "keep two views of these volumes at least")
    length = None if keys is not None else seconds
    plan = make_plan(1.0 if way == "turntable" else None, keys, "time" if way == "time" else None, length, None)
    with working(session) as check, tempfile.TemporaryDirectory(prefix="airlight-") as folder:
        target = checked_target(Path(folder) / f"movie.{kind}", float(fps))
        write_movie(document.scene, target, plan, size, session.viewer.renderer, document.drawing, check)
        return _named(f"movie.{kind}", MOVIES[kind]), [target.path.read_bytes()]


@answers("save.page", slow=True)
def page(session: Session, voxels: int = 128, title: str = "") -> tuple[dict[str, Any], list[bytes]]:
    """A page to send: one file that draws what is seen in any browser with WebGPU."""
    from ...pages import export

    if voxels not in PAGE_VOXELS:
        raise ValueRangeError("voxels", f"is {voxels!r:.40}, must be one of {', '.join(map(str, PAGE_VOXELS))}")
    document = session.document
    with working(session) as check:
        given: dict[str, Any] = {"driver": document.driver, "step": document.step, "progress": check}
        data = _file_of("html", lambda path: export(document.scene, path, voxels=voxels, title=str(title), **given))
    return _named("view.html", "text/html"), [data]


@answers("save.cancel")
def cancel(session: Session) -> dict[str, Any]:
    """End what is being saved."""
    if session in _works:
        _works[session].set()
    return {}


# -- work that tells how far it is, and can be ended


class CancelledSavingError(AirlightError):
    """The user has ended it."""


@contextmanager
def working(session: Session) -> Iterator[Callable[[str, int, int], None]]:
    """Be what is saved in a session; gives the function that tells how far it is, and ends it where that was asked for.

    Raises
    ------
    LimitError
        When something is being saved already.
    """
    stop = threading.Event()
    if _works.setdefault(session, stop) is not stop:
        raise LimitError("save", "is at work", "wait for it, or cancel it")

    def check(what: str, done: int, total: int) -> None:
        if stop.is_set() or session.has_ended:
            raise CancelledSavingError("save", "was cancelled")
        session.tell_progress(f"saving: {what}", done, total)

    try:
        yield check
    finally:
        _works.pop(session, None)
        session.tell_progress("saving", 1, 1)


def seen(session: Session, size_px: tuple[int, int], transparent: bool, refined: bool) -> Image | None:
    """Return the picture that is at rest, if it is what is asked for; one that is refined further is better yet."""
    document, image = session.document, session.stream.image
    same = image is not None and image.scene == document.scene and image.size == size_px == session.size_px
    if not same or image is None or refined or image.stats.get("refined", {}).get("scale") != 1:
        return None
    return replace(image, background=None) if transparent else image


def drawn(
    session: Session,
    document: Document,
    size_px: tuple[int, int],
    transparent: bool,
    refined: bool,
    check: Callable[[str, int, int], None],
) -> Image:
    """Draw a document at its step, or refined to its tolerance; other views are drawn in between."""
    scene = replace(document.scene, background=None) if transparent else document.scene
    options: dict[str, Any] = document.drawing
    if refined and refines(Wanted(document, size_px)):
        options["tolerance"] = document.tolerance
    told: list[Any] = ["drawing", 0, 0]

    def progress(what: str, done: int, total: int) -> None:
        told[:] = what, done, total

    view, renderer = object(), session.viewer.renderer
    future = renderer.submit(scene, size_px, view=view, progress=progress, **options)
    try:
        while True:
            try:
                return future.result(timeout=POLL_S)
            except TimeoutError:
                if future.done():
                    raise
            except CancelledError:
                raise CancelledSavingError("save", "was cancelled") from None
            check(*told)
    finally:
        renderer.close_view(view)


def checked_size(session: Session, size_px: Any) -> tuple[int, int]:
    """Return the size of a picture: the view's own, or one that is asked for.

    Raises
    ------
    ValueRangeError
        For what is no size, or too large.
    """
    if size_px is None:
        return session.size_px
    is_pair = isinstance(size_px, list) and len(size_px) == 2
    if not is_pair or not all(isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= MOST_SIDE_PX for n in size_px):
        raise ValueRangeError("size", f"is {size_px!r:.60}, must be two whole numbers from 1 to {MOST_SIDE_PX:,}")
    if size_px[0] * size_px[1] > MOST_PIXELS:
        raise LimitError(
            "size", f"has {size_px[0] * size_px[1]:,} pixels, and {MOST_PIXELS:,} may be saved", "take a smaller one"
        )
    return size_px[0], size_px[1]


def _file_of(ending: str, write: Callable[[Path], object]) -> bytes:
    with tempfile.TemporaryDirectory(prefix="airlight-") as folder:
        path = Path(folder) / f"file.{ending}"
        write(path)
        return path.read_bytes()


def _named(name: str, kind: str) -> dict[str, Any]:
    return {"name": name, "kind": kind}


def _one_of(value: Any, known: tuple[str, ...], where: str) -> None:
    if value not in known:
        raise ValueRangeError(where, f"is {value!r:.40}, must be one of {', '.join(known)}")
