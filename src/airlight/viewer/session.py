"""Sessions: what one view is, who listens to it, and what becomes of the messages it gets.

A session outlives its clients: whoever comes back with its id finds everything as it was. All of its state is one frozen
``History``; messages make another of it.
"""

from __future__ import annotations

import contextlib
import secrets
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

from ..errors import AirlightError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..rendering.renderer import Renderer
from ..volume import Volume, statistics
from . import gestures
from .asking import answer
from .document import Document
from .edits import applied
from .history import History
from .schema import schema
from .stream import Stream
from .wire import Held

Message = Mapping[str, Any]
Send = Callable[[dict[str, Any], list[bytes]], None]
"""Gives a message and its buffers to a client; returns at once, from any thread."""

MOST_QUESTIONS = 64
FIRST_SIZE_PX = (512, 512)


class Viewer:
    """The renderer and the sessions that share it.

    Parameters
    ----------
    document
        What a new session shows.
    name
        What it is called: the name of a file without its path.
    renderer
        Renderer to share; None makes one, which ``close`` releases.
    """

    def __init__(self, document: Document, name: str = "", renderer: Renderer | None = None) -> None:
        self.first, self.name = document, name
        self.renderer = renderer or Renderer()
        self._owns_renderer = renderer is None
        self.sessions: dict[str, Session] = {}
        self._lock = threading.Lock()

    def session(self, key: str | None = None) -> Session:
        """Return the session of a key that was given before, or a new one."""
        with self._lock:
            found = self.sessions.get(key or "")
            if found is None:
                found = Session(self, self.first)
                self.sessions[found.key] = found
            return found

    def end(self, session: Session) -> None:
        """End a session and what is drawn for it."""
        with self._lock:
            self.sessions.pop(session.key, None)
        session.close()

    def close(self) -> None:
        """End all sessions. Idempotent."""
        for session in list(self.sessions.values()):
            self.end(session)
        if self._owns_renderer:
            self.renderer.close()


class Session:
    """One view of a document: its history, its picture, and the clients that look at it."""

    def __init__(self, viewer: Viewer, document: Document) -> None:
        self.key = secrets.token_urlsafe(16)
        self.viewer = viewer
        self.held = Held()
        self.size_px = FIRST_SIZE_PX
        self.revision = 0
        self._history = History(replace(document, scene=resolve(document.scene, self.size_px)))
        self._lock = threading.RLock()
        self._clients: list[Send] = []
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="airlight-answers")
        self._waiting = 0
        self.stream = Stream(self)

    # -- clients

    def listen(self, send: Send) -> Callable[[], None]:
        """Attach a client; returns what detaches it."""
        with self._lock:
            self._clients.append(send)

        def detach() -> None:
            with self._lock, contextlib.suppress(ValueError):
                self._clients.remove(send)
            self.stream.wake()

        return detach

    @property
    def has_clients(self) -> bool:
        """Whether anybody looks."""
        return bool(self._clients)

    def send(self, message: dict[str, Any], buffers: Sequence[bytes] = ()) -> None:
        """Send a message to all clients."""
        for client in list(self._clients):
            client(message, list(buffers))

    def close(self) -> None:
        """Stop drawing and answering. Idempotent."""
        self.stream.close()
        self._worker.shutdown(wait=False, cancel_futures=True)
        self._clients.clear()

    # -- state

    @property
    def document(self) -> Document:
        """What is shown now."""
        return self._history.document

    def plain(self) -> dict[str, Any]:
        """Return the document as clients see it."""
        return self.held.plain(self.document)

    def change(self, document: Document, merge: str = "") -> None:
        """Show another document, as a step of undo."""
        with self._lock:
            self._take(self._history.edited(document, merge))

    def look(self, change: Callable[[Document], Document]) -> None:
        """Change the camera: no step of undo, and clients learn of it with the next picture."""
        with self._lock:
            document = change(self.document)
            self._history = replace(self._history, document=document)
        self.stream.wake()

    def _take(self, history: History) -> None:
        self._history = history
        self.revision += 1
        self.send_state()
        self.stream.wake()

    def send_state(self) -> None:
        """Tell all clients the state."""
        history = self._history
        state = {"type": "state", "rev": self.revision, "document": self.plain(), "name": self.viewer.name}
        state |= {"can_undo": bool(history.past), "can_redo": bool(history.future)}
        self.send(state | {"volumes": {key: _told(volume) for key, volume in self.held.volumes.items()}})

    # -- messages

    def receive(self, message: Any, buffers: Sequence[bytes] = ()) -> None:
        """Take a message; what is wrong with it is told to the clients."""
        try:
            kind = message.get("type") if isinstance(message, Mapping) else None
            handle = _MESSAGES.get(kind) if isinstance(kind, str) else None
            if handle is None:
                raise ValueRangeError("message.type", f"is {kind!r:.80}, must be one of {', '.join(_MESSAGES)}")
            handle(self, message)
        except AirlightError as error:
            self.send({"type": "error"} | told(error))
        except (TypeError, ValueError, KeyError, OverflowError) as error:
            self.send({"type": "error"} | told(ValueRangeError("message", f"is not understood ({error})"[:300])))

    def _hello(self, message: Message) -> None:
        self._size(message)
        self.send({"type": "welcome", "session": self.key, "schema": schema()})
        self.send_state()
        self.stream.again()

    def _size(self, message: Message) -> None:
        width, height = (min(max(int(n), 1), self.stream.MOST_PX) for n in message["size_px"])
        self.size_px = (width, height)
        self.stream.wake()

    def _edit(self, message: Message) -> None:
        with self._lock:
            document = self.held.document(applied(self.plain(), message.get("ops")))
            document = replace(document, scene=resolve(document.scene, self.size_px))
            self.change(document, str(message.get("merge") or ""))

    def _undo(self, message: Message) -> None:
        with self._lock:
            self._take(self._history.undone())

    def _redo(self, message: Message) -> None:
        with self._lock:
            self._take(self._history.redone())

    def _gesture(self, message: Message) -> None:
        self.look(lambda document: gestures.applied(document, message, self.size_px))

    def _ack(self, message: Message) -> None:
        self.stream.acknowledged(int(message["frame"]))

    def _ask(self, message: Message) -> None:
        number = message.get("id")
        if self._waiting >= MOST_QUESTIONS:
            raise LimitError("ask", f"has {self._waiting} questions waiting", "wait for answers")
        self._waiting += 1

        def work() -> None:
            try:
                value, buffers = answer(self, message.get("what"), message.get("arguments"))
                self.send({"type": "answer", "id": number, "value": value}, buffers)
            except AirlightError as error:
                self.send({"type": "answer", "id": number, "error": told(error)})
            except Exception as error:  # a question must not end the worker: its asker waits for an answer
                self.send({"type": "answer", "id": number, "error": told(ValueRangeError("ask", f"failed ({error})"[:300]))})
                raise
            finally:
                self._waiting -= 1

        self._worker.submit(work)


_MESSAGES: dict[str, Callable[[Session, Message], None]] = {
    "hello": Session._hello,
    "size": Session._size,
    "edit": Session._edit,
    "undo": Session._undo,
    "redo": Session._redo,
    "gesture": Session._gesture,
    "ack": Session._ack,
    "ask": Session._ask,
}


def told(error: AirlightError) -> dict[str, str]:
    """An error as plain data."""
    return {"where": error.where, "what": error.what, "remedy": error.remedy}


def _told(volume: Volume) -> dict[str, Any]:
    """What clients know of a volume."""
    known = statistics(volume)
    corners = volume.corners_world(cells=False)
    return {
        "size": list(volume.size),
        "spacing": list(volume.spacing),
        "units": volume.units,
        "value_unit": volume.value_unit,
        "anatomical": volume.anatomical,
        "channels": volume.channel_count,
        "times": volume.time_count,
        "range": [float(known.minimum), float(known.maximum)],
        "robust_range": [float(known.percentile(0.5)), float(known.percentile(99.5))],
        "low_world": corners.min(axis=0).tolist(),
        "high_world": corners.max(axis=0).tolist(),
        "corners_world": corners.tolist(),
        "world_from_index": volume.world_from_index.tolist(),
    }
