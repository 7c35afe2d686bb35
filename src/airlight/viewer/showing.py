"""``airlight.view``: a page in the browser, a widget in a notebook, or a window."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from ..errors import AirlightError, FileError, MissingExtraError
from ..io.formats import family_of
from ..scene import Scene
from ..stage import Stage, make_stage
from ..stages.passes import checked_passes
from .document import TOLERANCE, Document
from .opening import nothing
from .serving.lobby import Lobby
from .serving.running import Serving, has_display, is_remote, tunnel
from .shelf import MOST_UPLOAD_BYTES, Shelf

if TYPE_CHECKING:
    from .bookmarks import Bookmark
    from .session import Viewer

Looked = tuple[Document, str, Shelf, "tuple[Bookmark, ...]"]
CLOSED_S = 10.0
"""How long a script waits for a page to be opened again after the last one was closed."""

POLL_S = 0.1
START_S = 2.0
"""Longest wait for a start at the end: Ctrl-C within an import of the main thread may hold up those of others for ever."""


def view(
    what: Any = None,
    *,
    driver: str | Stage = "march",
    step: float = 1.0,
    skip: str = "auto",
    tolerance: float | None = TOLERANCE,
    passes: Iterable[str | Stage] = (),
    device: str | int | None = None,
    window: bool = False,
    browser: bool = True,
    block: bool | None = None,
    host: str = "127.0.0.1",
    port: int = 0,
    public_url: str = "",
    max_upload: int = MOST_UPLOAD_BYTES,
) -> Any:
    """Look at a volume, turn it, and change how it is drawn.

    In a notebook a widget appears. Elsewhere a page is served, of which the address is printed, and opened in the browser.

    Parameters
    ----------
    what
        A scene, a volume, an array, or a path, as for ``airlight.render``; a folder offers its volumes. None offers samples,
        and to open a file.
    driver, step, skip, passes, device
        As for ``airlight.render``.
    tolerance
        Bound of the error to which the picture is refined while nothing moves; None leaves it at ``step``.
    window
        Open a window of its own instead of a page.
    browser
        Open the page in the browser.
    block
        Return when all pages were closed for ten seconds, or at Ctrl-C; False returns at once. None: True in scripts, False
        where one types.
    host, port
        Where the page is served: this machine alone unless told, at a free port.
    public_url
        Address under which a proxy shows the page.
    max_upload
        Most bytes that a page may bring.

    Returns
    -------
    object
        In a notebook the widget; with ``block=False`` a ``Showing`` with ``url`` and ``close()``; else None.

    Raises
    ------
    AirlightError
        For what cannot be opened or drawn, a port that is taken, and packages that are missing.

    Examples
    --------
    >>> import airlight as al
    >>> al.view("head.nii.gz")                                        # doctest: +SKIP
    """
    drawing = {"driver": make_stage("driver", driver), "step": step, "skip": skip, "tolerance": tolerance}
    drawing |= {"passes": checked_passes(passes)}
    hosted = in_notebook() and not window
    if hosted or window:
        from ..rendering.renderer import shared
        from .session import Viewer

        document, name, shelf, marks = looked_at(what, drawing, max_upload)
        viewer = Viewer(document, name, shared(device))
        viewer.shelf, viewer.bookmarks = shelf, marks
        if hosted:
            from .notebook import widget

            return widget(viewer)
        return show_window(viewer)
    check_served()
    if isinstance(what, (str, os.PathLike)) and not os.path.lexists(Path(what).expanduser()):
        raise FileError(os.fspath(what), "does not exist", "check the path")
    showing = Showing(host, port, public_url, device)
    try:
        print(showing.words(), flush=True)  # noqa: T201 - the address is what the user waits for
        if browser:
            showing.open_browser()
        showing.show(*looked_at(what, drawing, max_upload))
        if block is False or (block is None and is_typed()):
            return showing
        showing.wait(until_closed=True)
    except KeyboardInterrupt:
        pass
    except AirlightError as error:
        showing.fail(error)
        raise
    except BaseException:
        showing.close()
        raise
    showing.close()
    return None


def looked_at(what: Any, drawing: dict[str, Any], max_upload: int = MOST_UPLOAD_BYTES) -> Looked:
    """Return the document of what a user names, what it is called, what else may be opened, and bookmarks of it."""
    from ..api import as_scene
    from ..first_picture import resolve
    from .bookmarks import of_keyframes
    from .session import FIRST_SIZE_PX

    if what is None:
        return nothing(), "", Shelf(None, max_upload), ()
    is_path = isinstance(what, (str, os.PathLike))
    if is_path and is_folder_of_volumes(Path(what)):
        return nothing(), "", Shelf(Path(what).expanduser(), max_upload), ()
    given = as_scene(what, FIRST_SIZE_PX)
    is_scene = isinstance(what, Scene) or (is_path and os.fspath(what).endswith(".toml"))
    chosen_for = None if is_scene and not isinstance(given.camera, str) else FIRST_SIZE_PX[0] / FIRST_SIZE_PX[1]
    document = Document(resolve(given, FIRST_SIZE_PX), chosen_for=chosen_for, **drawing)
    marks = of_keyframes(what, document) if is_path else ()
    return document, Path(what).name if is_path else "", Shelf(None, max_upload), marks


def is_folder_of_volumes(path: Path) -> bool:
    """Whether a path is a folder that is no volume itself."""
    place = path.expanduser()
    if not place.is_dir():
        return False
    try:
        family_of(place)
    except FileError:
        return True
    return False


class Showing:
    """A viewer that is served; pages may come before there is anything to see. A context manager.

    Parameters
    ----------
    host, port, public_url
        Where: see ``view``.
    device
        As for ``airlight.render``.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0, public_url: str = "", device: str | int | None = None) -> None:
        self.serving = Serving(host, port, public_url)
        self.lobby = Lobby()
        self._device = device
        self._has_ended = False
        # What answers takes time to be imported; meanwhile the file is read.
        self._starting = threading.Thread(target=self._start, name="airlight-start", daemon=True)
        self._starting.start()

    def _start(self) -> None:
        from .server import application

        if not self._has_ended:
            self.serving.start(application(self.lobby))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def url(self) -> str:
        """Address of the page, with its token."""
        return self.serving.url()

    @property
    def viewer(self) -> Viewer:
        """The viewer, once it is there."""
        return self.lobby.viewer.result()

    def words(self) -> str:
        """What a user is told: the address, and how to come to it from elsewhere."""
        lines = [f"airlight is at {self.url}"]
        if is_remote():
            lines += ["from your own machine, first:", f"    {tunnel(self.serving.port)}"]
        return "\n".join(lines)

    def open_browser(self) -> None:
        """Open the page in the user's browser, if the user sits at this machine."""
        if has_display() and not is_remote():
            self.serving.open_browser()

    def show(
        self, document: Document, name: str = "", shelf: Shelf | None = None, bookmarks: tuple[Bookmark, ...] = ()
    ) -> None:
        """Let pages look at a document."""
        from ..rendering.renderer import shared
        from .session import Viewer

        renderer = shared(self._device)
        # Its program is compiled before the first page asks for it.
        renderer.submit(document.scene, (16, 16), view=self, **document.drawing)
        viewer = Viewer(document, name, renderer)
        viewer.shelf, viewer.bookmarks = shelf or viewer.shelf, bookmarks
        self.lobby.viewer.set_result(viewer)

    def fail(self, error: AirlightError) -> None:
        """Tell pages that wait why nothing comes, and end."""
        if not self.lobby.viewer.done():
            self.lobby.viewer.set_exception(error)
            time.sleep(2 * POLL_S)
        self.close()

    def wait(self, until_closed: bool = False) -> None:
        """Wait for Ctrl-C, or until all pages were closed for a while."""
        while not (until_closed and self.lobby.empty_s() > CLOSED_S):
            time.sleep(POLL_S)

    def close(self) -> None:
        """End all views and free the port. Idempotent."""
        self._has_ended = True
        self._starting.join(START_S)
        self.serving.stop()
        if self.lobby.viewer.done() and self.lobby.viewer.exception() is None:
            self.viewer.close()

    def __repr__(self) -> str:
        return f"Showing({self.url})"


def show_window(viewer: Viewer) -> None:
    """Open a window on a viewer, and wait until it is closed."""
    from .window import show

    try:
        show(viewer)
    finally:
        viewer.close()


def check_served() -> None:
    """Refuse to serve without the packages for it.

    Raises
    ------
    MissingExtraError
        With the command that installs them.
    """
    if not all(find_spec(name) for name in ("starlette", "uvicorn", "websockets")):
        raise MissingExtraError("the viewer", "needs starlette, uvicorn and websockets", 'pip install "airlight[view]"')


def in_notebook() -> bool:
    """Whether a notebook shows what is returned."""
    if "marimo" in sys.modules:
        import marimo

        if marimo.running_in_notebook():
            return True
    return hasattr(_shell(), "kernel")


def is_typed() -> bool:
    """Whether somebody types at a prompt of Python."""
    return hasattr(sys, "ps1") or _shell() is not None


def _shell() -> Any:
    ipython = sys.modules.get("IPython")
    return None if ipython is None else ipython.get_ipython()
