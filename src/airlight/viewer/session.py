"""Sessions: what one view is, who listens to it, and what becomes of the messages it gets.

A session outlives its clients: whoever comes back with its id finds everything as it was. All of its state is one frozen
``History``; messages make another of it.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

from ..errors import AirlightError, LimitError, ValueRangeError
from ..first_picture import resolve
from ..rendering.renderer import Renderer
from ..scene import Camera
from ..scene_file.held import FilesByToken, Held
from ..volume import Volume, statistics
from . import gesturing
from .asking import answer, is_slow
from .bookmarks import Bookmark
from .clients import Client, Send
from .document import Document
from .edits import applied
from .gestures import corners_of
from .gestures.standing import stood_back
from .habits import Habits
from .history import History
from .schema import schema
from .shelf import Shelf, name_of
from .stream import Stream
from .telling import told
from .wire import plain_document, read_document

Message = Mapping[str, Any]
MOST_QUESTIONS = 64
MOST_SESSIONS = 32
INPUTS = ("size", "edit", "undo", "redo", "gesture")
"""Messages that change the picture; pictures tell how many of them they show."""
IDLE_S = 30 * 60.0
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
    idle_s
        So long after its last client a session ends; inf for never.

    Attributes
    ----------
    bookmarks
        Those that a new session begins with.
    moved_at
        When anything was last changed in any view: work that may wait, waits for all of them.
    """

    def __init__(self, document: Document, name: str = "", renderer: Renderer | None = None, idle_s: float = IDLE_S) -> None:
        self.first, self.name, self.idle_s = document, name, idle_s
        self.moved_at = 0.0
        self.renderer = renderer or Renderer()
        self._owns_renderer = renderer is None
        self.sessions: dict[str, Session] = {}
        self.shelf = Shelf()
        self.bookmarks: tuple[Bookmark, ...] = ()
        self._lock = threading.Lock()
        self._warm: tuple[Any, deque[Any]] = (None, deque())
        self.following = threading.RLock()

    def session(self, key: str | None = None) -> Session:
        """Return the session of a key that was given before, or a new one.

        Of too many, that ends at which nobody has looked for longest.

        Raises
        ------
        LimitError
            When somebody looks at each of them.
        """
        with self._lock:
            found = self.sessions.get(key or "")
            if found is not None:
                return found
            alone = [session for session in self.sessions.values() if not session.has_clients]
            left = min(alone, key=Session.ends_in_s, default=None)
            if len(self.sessions) >= MOST_SESSIONS and left is None:
                raise LimitError("viewer", f"has {len(self.sessions)} views open", "close one of them")
            if len(self.sessions) >= MOST_SESSIONS and left is not None:
                self.sessions.pop(left.key).close()
            found = Session(self, self.first)
            self.sessions[found.key] = found
            return found

    def warmed(self, kind: Any, programs: Callable[[], deque[Any]]) -> tuple[Any, deque[Any]]:
        """Return a kind of pictures with the programs that are still to be compiled for it, which all views share."""
        with self._lock:
            if kind != self._warm[0]:
                self._warm = kind, programs()
            return self._warm

    def shared(self, key: str) -> Session:
        """Return the session that was shared by a key.

        Raises
        ------
        ValueRangeError
            When there is none, or no more.
        """
        found = next((session for session in list(self.sessions.values()) if key and session.share_key == key), None)
        if found is None:
            raise ValueRangeError("follow.key", "is that of no view that is shared", "ask for it again where it is shared")
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
        self.shelf.close()
        if self._owns_renderer:
            self.renderer.close()


class Session:
    """One view of a document: its history, its picture, and the clients that look at it."""

    def __init__(self, viewer: Viewer, document: Document) -> None:
        self.key = secrets.token_urlsafe(16)
        self.viewer = viewer
        self.held = Held(FilesByToken())
        self.size_px = FIRST_SIZE_PX
        self.revision = 0
        self._history = History(replace(document, scene=resolve(document.scene, self.size_px)))
        self.habits = replace(Habits.of(self.document), bookmarks=viewer.bookmarks)
        self._chosen = self._stood = self.document.camera
        self._chosen_for = document.chosen_for
        self.travels = 0
        self._lock = threading.RLock()
        self.clients: tuple[Client, ...] = ()
        self.has_ended = False
        self._left_at = time.monotonic()
        self.inputs = 0
        self.share_key = ""
        self.leader: Session | None = None
        self._followers: tuple[Session, ...] = ()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="airlight-answers")
        self._slow = ThreadPoolExecutor(2, thread_name_prefix="airlight-slow-answers")
        self._waiting = 0
        self.stream = Stream(self)

    # -- clients

    def listen(self, send: Send) -> Callable[[], None]:
        """Attach a client; returns what detaches it."""
        client = Client(send)
        with self._lock:
            self.clients = (*self.clients, client)

        def detach() -> None:
            with self._lock:
                self.clients = tuple(other for other in self.clients if other is not client)
                self._left_at = time.monotonic()
            self.stream.wake()

        return detach

    @property
    def has_clients(self) -> bool:
        """Whether anybody looks."""
        return bool(self.clients)

    def ends_in_s(self) -> float:
        """Seconds until a session without clients ends."""
        return self._left_at + self.viewer.idle_s - time.monotonic()

    def send(self, message: dict[str, Any], buffers: Sequence[bytes] = ()) -> None:
        """Send a message to all clients."""
        for client in self.clients:
            client.tell(message, buffers)

    def tell_progress(self, what: str, done: int, total: int) -> None:
        """Tell all clients what is being done, how much of it is done, and how much there is (0 when unknown)."""
        self.send({"type": "progress", "what": what, "done": done, "total": total})

    def close(self) -> None:
        """Stop drawing and answering. Idempotent."""
        self.has_ended = True
        self.stream.close()
        self._worker.shutdown(wait=False, cancel_futures=True)
        self._slow.shutdown(wait=False, cancel_futures=True)
        self.viewer.shelf.forget(self.key)
        for other in self._followers:
            other.follow(None)
        self.follow(None)
        self.clients = ()

    # -- state

    @property
    def document(self) -> Document:
        """What is shown now."""
        return self._history.document

    def plain(self) -> dict[str, Any]:
        """Return the document as clients see it."""
        return plain_document(self.document, self.held)

    @property
    def name(self) -> str:
        """What is shown, by the name of its file."""
        layers = self.document.scene.layers
        return (name_of(layers[0].volume) if layers else "") or self.viewer.name

    def change(self, document: Document, merge: str = "", answers: str = "") -> None:
        """Show another document, as a step of undo; the state that clients are told names the edit that it ``answers``."""
        with self._lock:
            self._check_own()
            self.habits = self.habits.at_home(self.document, document)
            self._take(self._history.edited(document, merge), answers)

    def look(self, change: Callable[[Document], Document]) -> None:
        """Change the camera: no step of undo, and clients learn of it with the next picture."""
        with self._lock:
            self._check_own()
            document = change(self.document)
            self._history = replace(self._history, document=document)
            self.habits = self.habits.seen(document.camera)
        self._changed()

    def chose(self) -> None:
        """Take the camera as one that was chosen from the data for the view as it is now: narrower views stand back."""
        with self._lock:
            self._chosen = self._stood = self.camera
            self._chosen_for = self.size_px[0] / self.size_px[1]

    @property
    def camera(self) -> Camera:
        """What is looked through."""
        return self.document.camera

    def keep(self, change: Callable[[Habits], Habits]) -> None:
        """Change the habits, which is no step of undo, and tell them."""
        with self._lock:
            self.habits = change(self.habits)
        self.send_state()

    def _take(self, history: History, answers: str = "") -> None:
        self._history = history
        self.revision += 1
        self._let_go()
        self.send_state(answers)
        self._changed()

    def _let_go(self) -> None:
        """Keep no volume that neither a step of undo nor a bookmark brings back."""
        history = self._history
        marks = [mark.document for mark in self.habits.bookmarks if mark.document is not None]
        documents = (history.document, *history.past, *history.future, *marks)
        self.held.keep_only(volume for document in documents for volume in document.volumes)

    def _changed(self) -> None:
        self.stream.wake()
        for other in self._followers:
            other.mirror()

    # -- following

    def follow(self, leader: Session | None) -> None:
        """Show what another session shows, as long as it lasts; None: go on alone from there.

        Raises
        ------
        ValueRangeError
            For itself, and for a session that follows, too.
        """
        with self.viewer.following:  # two that begin to follow each other at once would do so for ever
            if leader is self or (leader is not None and leader.leader is not None):
                raise ValueRangeError("follow.key", "is that of this view, or of one that follows", "share the view that leads")
            before, self.leader = self.leader, leader
            if before is not None:
                before._followers = tuple(other for other in before._followers if other is not self)
            if leader is not None:
                leader._followers = (*leader._followers, self)
        if leader is not None:
            self.travels += 1
            with self._lock:
                self._take(self._history.edited(leader.document))
        elif before is not None:
            self.send_state()

    def mirror(self) -> None:
        """Show what the session that is followed shows now."""
        leader = self.leader
        if leader is None:
            return
        with self._lock:
            before, document = self.document, leader.document
            self._history = replace(self._history, document=document)
            if document.with_camera(before.camera) != before:
                self.revision += 1
                self._let_go()
                self.send_state()
        self._changed()

    def _check_own(self) -> None:
        if self.leader is not None:
            raise ValueRangeError("view", "follows another and cannot be changed", "stop following")

    def send_state(self, answers: str = "") -> None:
        """Tell all clients the state, and the id of the edit that it answers."""
        history = self._history
        state = {"type": "state", "rev": self.revision, "document": self.plain(), "name": self.name, "answers": answers}
        state |= {"can_undo": bool(history.past), "can_redo": bool(history.future), "habits": self.habits.plain()}
        state |= {"following": self.leader is not None, "followers": len(self._followers)}
        self.send(state | {"volumes": {key: _told(volume) for key, volume in self.held.volumes.items()}})

    # -- messages

    def receive(self, message: Any, buffers: Sequence[bytes] = (), reply: Send | None = None) -> None:
        """Take a message; answers, and what is wrong with it, go to who sent it: to ``reply``, or to all clients."""
        send = reply or self.send
        answers = _id_of(message)
        try:
            kind = message.get("type") if isinstance(message, Mapping) else None
            handle = _MESSAGES.get(kind) if isinstance(kind, str) else None
            if handle is None:
                raise ValueRangeError("message.type", f"is {kind!r:.80}, must be one of {', '.join(_MESSAGES)}")
            if handle is Session._ask:
                self._ask(message, buffers, send)
            else:
                self.inputs += kind in INPUTS
                handle(self, message)
        except AirlightError as error:
            send({"type": "error", "answers": answers} | told(error), [])
        except (TypeError, ValueError, KeyError, IndexError, OverflowError, RecursionError, ArithmeticError) as error:
            wrong = ValueRangeError("message", f"is not understood ({error})"[:300])
            send({"type": "error", "answers": answers} | told(wrong), [])

    def _hello(self, message: Message) -> None:
        self.size_px = self._given_size(message)
        self._stand()
        self.send({"type": "welcome", "session": self.key, "schema": schema()})
        self.send_state()
        self.stream.again()

    def _size(self, message: Message) -> None:
        self.size_px = self._given_size(message)
        self._stand()
        self._changed()

    def _stand(self) -> None:
        """Let a camera that was chosen from the data show all in a view of this shape, while nobody has moved it."""
        with self._lock:
            if self._chosen_for is None or self.leader is not None or self.camera != self._stood:
                return
            corners, aspect = corners_of(self.document.scene), self.size_px[0] / self.size_px[1]
            self._stood = stood_back(self._chosen, corners, aspect, self._chosen_for)
            self._history = replace(self._history, document=self.document.with_camera(self._stood))
            self.habits = replace(self.habits, home=self._stood)

    def _given_size(self, message: Message) -> tuple[int, int]:
        width, height = (min(max(int(n), 1), self.stream.MOST_PX) for n in message["size_px"])
        return width, height

    def _edit(self, message: Message) -> None:
        with self._lock:
            plain = self.plain()
            document = read_document(applied(plain, message.get("ops")), self.held, plain, self.document)
            document = replace(document, scene=resolve(document.scene, self.size_px))
            self.change(document, str(message.get("merge") or ""), _id_of(message))

    def _undo(self, message: Message) -> None:
        with self._lock:
            self._check_own()
            self._take(self._history.undone())

    def _redo(self, message: Message) -> None:
        with self._lock:
            self._check_own()
            self._take(self._history.redone())

    def _gesture(self, message: Message) -> None:
        gesturing.take(self, message)

    def _share(self, message: Message) -> None:
        self.share_key = self.share_key or secrets.token_urlsafe(16)
        self.send({"type": "shared", "key": self.share_key})

    def _follow(self, message: Message) -> None:
        key = message.get("key")
        self.follow(self.viewer.shared(str(key)) if key else None)

    def _habits(self, message: Message) -> None:
        self.keep(lambda habits: habits.changed(message))

    def _ack(self, message: Message) -> None:
        self.stream.acknowledged(int(message["frame"]))

    def _ask(self, message: Message, buffers: Sequence[bytes] = (), reply: Send | None = None) -> None:
        send = reply or self.send
        number = message.get("id")
        if self._waiting >= MOST_QUESTIONS:
            many = LimitError("ask", f"has {self._waiting} questions waiting", "wait for answers")
            send({"type": "answer", "id": number, "error": told(many)}, [])
            return
        self._waiting += 1

        def work(may_wait: bool = False) -> None:
            what, posted = message.get("what"), False
            try:
                if may_wait and is_slow(what):
                    posted = bool(self._slow.submit(work))
                    return
                value, found = answer(self, what, message.get("arguments"), buffers)
                send({"type": "answer", "id": number, "value": value}, found)
            except AirlightError as error:
                send({"type": "answer", "id": number, "error": told(error)}, [])
            except Exception as error:  # a question must not end the worker: its asker waits for an answer
                send({"type": "answer", "id": number, "error": told(ValueRangeError("ask", f"failed ({error})"[:300]))}, [])
                raise
            finally:
                self._waiting -= not posted

        try:
            self._worker.submit(work, True)
        except RuntimeError:  # the session has ended
            ended = ValueRangeError("view", "has ended", "load the page again")
            send({"type": "answer", "id": number, "error": told(ended)}, [])


_MESSAGES: dict[str, Callable[[Session, Message], None]] = {
    "hello": Session._hello,
    "size": Session._size,
    "edit": Session._edit,
    "undo": Session._undo,
    "redo": Session._redo,
    "gesture": Session._gesture,
    "habits": Session._habits,
    "share": Session._share,
    "follow": Session._follow,
    "ack": Session._ack,
    "ask": Session._ask,
}


def _id_of(message: Any) -> str:
    """The id by which a client knows its edit again."""
    return str(message.get("id") or "")[:64] if isinstance(message, Mapping) else ""


def _told(volume: Volume) -> dict[str, Any]:
    """What clients know of a volume."""
    known = statistics(volume)
    corners = volume.corners_world(cells=False)
    return {
        "name": name_of(volume),
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
