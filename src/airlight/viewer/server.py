"""The page that ``airlight view`` serves: three texts and one WebSocket a view."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING, Any

from ..errors import AirlightError, ValueRangeError
from .front_end import WEB, script, styles
from .serving.framing import packed, unpacked
from .serving.limits import Limits, Outbox, Pace
from .serving.lobby import Lobby
from .telling import told

if TYPE_CHECKING:
    from .clients import Send
    from .session import Session, Viewer

WAIT_S = 0.1
CUT, NOT_UNDERSTOOD, TOO_LONG, AGAIN, TOO_BUSY = 1006, 1007, 1009, 1012, 1013


def application(viewer: Viewer | Lobby, limits: Limits | None = None) -> Any:
    """ASGI application of a viewer; it answers everybody, and ``serving.access.guarded`` lets in whom it may.

    Parameters
    ----------
    viewer
        The viewer, or a lobby in which pages wait for it.
    limits
        How much a client may send.
    """
    from starlette.applications import Starlette
    from starlette.responses import Response
    from starlette.routing import Route, WebSocketRoute

    lobby = viewer if isinstance(viewer, Lobby) else Lobby(viewer)
    bounds = limits or Limits()

    def told_as(kind: str, text: str) -> Any:
        async def answer(_: Any) -> Response:
            return Response(text, media_type=f"{kind}; charset=utf-8")

        return answer

    pages = {
        "/": told_as("text/html", (WEB / "index.html").read_text(encoding="utf-8")),
        "/web/page.js": told_as("text/javascript", script("page.js")),
        "/web/page.css": told_as("text/css", styles()),
    }

    async def socket(connection: Any) -> None:
        await connected(connection, lobby, bounds)

    # No request names a path of a file.
    app = Starlette(routes=[*(Route(path, page) for path, page in pages.items()), WebSocketRoute("/socket", socket)])
    app.router.redirect_slashes = False
    return app


async def connected(connection: Any, lobby: Lobby, limits: Limits) -> None:
    """Serve one socket: messages of its client go to its session, those of the session to it."""
    from anyio import create_task_group, move_on_after

    if lobby.sockets >= limits.sockets:
        await connection.close(TOO_BUSY)
        return
    lobby.entered()
    code = CUT
    try:
        await connection.accept()
        outbox = Outbox(limits.waiting_bytes)
        async with create_task_group() as both:

            async def pump() -> None:
                with contextlib.suppress(*_gone()):  # receiving tells with which code it went
                    while not both.cancel_scope.cancel_called:
                        data = await outbox.take()
                        with move_on_after(limits.stalled_s) as sending:
                            await connection.send_bytes(data)
                        if sending.cancelled_caught:
                            both.cancel_scope.cancel()

            async def watch() -> None:  # the pump itself waits for a client that does not read
                await outbox.overflowed.wait()
                both.cancel_scope.cancel()

            both.start_soon(pump)
            both.start_soon(watch)
            code = await _talk(connection, lobby, limits, outbox)
            both.cancel_scope.cancel()
    finally:
        lobby.left(code)


async def _talk(connection: Any, lobby: Lobby, limits: Limits, outbox: Outbox) -> int:
    """Bring a client to its session, and hand that its messages; returns the code with which it went, or had to."""
    from starlette.websockets import WebSocketDisconnect

    def send(message: dict[str, Any], buffers: list[bytes]) -> None:
        outbox.put(packed(message, buffers))

    try:
        viewer = await _arrived(lobby, send)
        session = viewer.session(connection.query_params.get("session"))
    except AirlightError as error:  # no viewer has come, or it takes no more
        send({"type": "error"} | told(error), [])
        await asyncio.sleep(WAIT_S)
        code = TOO_BUSY
    else:
        detach = session.listen(send)
        try:
            code = await _heard(connection, session, limits, send)
        except WebSocketDisconnect as gone:
            return gone.code
        finally:
            detach()
    with contextlib.suppress(*_gone()):
        await connection.close(code)
    return CUT


async def _heard(connection: Any, session: Session, limits: Limits, send: Send) -> int:
    """Hand messages of a client to its session; returns the code of why that cannot go on."""
    from starlette.websockets import WebSocketDisconnect

    pace = Pace(limits.messages_per_s, limits.burst)
    while True:
        # By the plain event: a page that was closed while it was being sent something has told its code all the same.
        event = await connection.receive()
        if event["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(event["code"])
        frame = event.get("bytes")
        if frame is None:  # text
            return NOT_UNDERSTOOD
        if len(frame) > limits.message_bytes:
            return TOO_LONG
        try:
            message, buffers = unpacked(frame)
        except ValueRangeError:
            return NOT_UNDERSTOOD
        if session.has_ended:
            return AGAIN  # whoever comes back finds another
        await asyncio.to_thread(session.receive, message, buffers, send)
        await asyncio.sleep(pace.pause_s())


def _gone() -> tuple[type[Exception], ...]:
    """Errors of writing to a client that is no more."""
    from starlette.websockets import WebSocketDisconnect

    return WebSocketDisconnect, RuntimeError, OSError


async def _arrived(lobby: Lobby, send: Send) -> Viewer:
    """Wait for the viewer, and tell what is being done for it."""
    coming, last = asyncio.wrap_future(lobby.viewer), None
    while not coming.done():
        if lobby.told is not None and lobby.told != last:
            last = lobby.told
            send({"type": "progress", "what": last[0], "done": last[1], "total": last[2]}, [])
        await asyncio.wait({coming}, timeout=WAIT_S)
    return coming.result()
