"""The viewer in notebooks: the same front-end over the kernel's comm, through anywidget; never a second port."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..errors import MissingExtraError
from ..first_picture import resolve
from ..scene import Scene, check_scene
from .front_end import script, styles

if TYPE_CHECKING:
    from .session import Session, Viewer

HEIGHT_PX = 520


def widget(viewer: Viewer, height_px: int = HEIGHT_PX) -> Any:
    """Return a widget that shows a new session of a viewer.

    Parameters
    ----------
    viewer
        The viewer; its renderer is shared.
    height_px
        Height of the widget in CSS pixels.

    Returns
    -------
    anywidget.AnyWidget
        Its ``scene`` is what is seen now, and may be set; ``close()`` ends it.

    Raises
    ------
    MissingExtraError
        Without anywidget.
    """
    try:
        import anywidget
        import traitlets
    except ImportError as error:
        raise MissingExtraError("viewer", "needs anywidget in notebooks", "pip install 'airlight[notebook]'") from error

    class View(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """A view on a volume."""

        _esm = script("app.js")
        _css = styles()
        height_px = traitlets.Int(HEIGHT_PX).tag(sync=True)
        session: Session

        @property
        def scene(self) -> Scene:
            """What is seen now; set it to show another."""
            return self.session.document.scene

        @scene.setter
        def scene(self, scene: Scene) -> None:
            check_scene(scene)
            resolved = resolve(scene, self.session.size_px)
            self.session.change(replace(self.session.document, scene=resolved))

    view = View(height_px=height_px)
    view.session = session = viewer.session()
    session.listen(_sender(view))
    view.on_msg(lambda _, message, buffers: session.receive(message, [bytes(buffer) for buffer in buffers]))
    # A comm is closed here, by close(), or by the front-end that deletes the widget.
    view.observe(lambda _: viewer.end(session), "comm")
    view.comm.on_close(lambda _: view.close())
    return view


def _sender(view: Any) -> Callable[[dict[str, Any], list[bytes]], None]:
    """Send messages on the kernel's own thread: comms are not to be used from others."""
    loop = None
    with contextlib.suppress(RuntimeError):
        loop = asyncio.get_running_loop()

    def send(message: dict[str, Any], buffers: list[bytes]) -> None:
        if loop is None or loop.is_closed():
            view.send(message, buffers)
        else:
            loop.call_soon_threadsafe(view.send, message, buffers)

    return send
