"""The page that ``airlight view`` serves: static files and one WebSocket a view."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .session import Viewer

WEB = Path(__file__).with_name("web")


def packed(message: dict[str, Any], buffers: Sequence[bytes]) -> bytes:
    """A message and its buffers as one frame: count, lengths of all parts (uint32), JSON, buffers."""
    text = json.dumps(message, allow_nan=False, separators=(",", ":")).encode()
    parts = [text, *buffers]
    return struct.pack(f"<{1 + len(parts)}I", len(parts), *(len(part) for part in parts)) + b"".join(parts)


def unpacked(frame: bytes) -> tuple[dict[str, Any], list[bytes]]:
    """The message and the buffers of a frame."""
    (count,) = struct.unpack_from("<I", frame)
    lengths = struct.unpack_from(f"<{count}I", frame, 4)
    at, parts = 4 + 4 * count, []
    for length in lengths:
        parts.append(frame[at : at + length])
        at += length
    return json.loads(parts[0]), parts[1:]


def application(viewer: Viewer) -> Any:
    """ASGI application of a viewer."""
    from starlette.applications import Starlette
    from starlette.responses import FileResponse
    from starlette.routing import Mount, Route, WebSocketRoute
    from starlette.staticfiles import StaticFiles
    from starlette.websockets import WebSocket, WebSocketDisconnect

    async def page(_: Any) -> FileResponse:
        return FileResponse(WEB / "index.html")

    async def socket(connection: WebSocket) -> None:
        await connection.accept()
        loop, outgoing = asyncio.get_running_loop(), asyncio.Queue[bytes]()

        def send(message: dict[str, Any], buffers: list[bytes]) -> None:
            loop.call_soon_threadsafe(outgoing.put_nowait, packed(message, buffers))

        async def pump() -> None:
            while True:
                await connection.send_bytes(await outgoing.get())

        session = viewer.session(connection.query_params.get("session"))
        detach = session.listen(send)
        sending = asyncio.create_task(pump())
        try:
            while True:
                message, buffers = unpacked(await connection.receive_bytes())
                await asyncio.to_thread(session.receive, message, buffers)
        except WebSocketDisconnect:
            pass
        finally:
            detach()
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await sending

    routes = [Route("/", page), WebSocketRoute("/socket", socket), Mount("/web", StaticFiles(directory=WEB))]
    return Starlette(routes=routes)
