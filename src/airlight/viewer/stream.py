"""The stream of a session: what has changed is drawn, encoded and sent, the newest first; at rest the picture is refined.

A view moves, and is drawn as well as there is time for (``ladder.py``); it rests, and is drawn in full; as it goes on resting,
programs that edits will need are compiled; and while nobody moves anything in any view, the picture is refined. Whatever comes
ends these. Pictures are drawn on the renderer's thread, and encoded on the stream's own while the next is drawn.
"""

from __future__ import annotations

import enum
import itertools
import logging
import threading
import time
from collections import deque
from collections.abc import Mapping
from concurrent.futures import CancelledError, Future, wait
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from ..errors import AirlightError, ValueRangeError
from ..rendering.budget import Cost, scaled
from ..rendering.frame import Request
from ..rendering.image import Image
from ..rendering.tolerance import check_tones
from ..rendering.warming import scenes_near
from ..scene import Layer, Scene
from ..scene_file.writing import plain_stage
from ..stages.integrate import EmissionAbsorption
from ..stages.lighting import Sampled
from ..stages.passes import checked_passes
from . import ladder
from .document import Document
from .encoding import jpeg, pixels_of, png
from .telling import told

if TYPE_CHECKING:
    from .session import Session

REST_S = 0.25
"""So long after the last change a view rests."""
CALM_S = 1.5
"""So long after the last change nobody minds work that may wait."""
SMALL_PX = (16, 16)
"""A picture whose refinement compiles all that large ones need: some of its pixels are finished sooner than others."""
SMALL_LEVELS = 3
Program = tuple[bool, int]
"""A program that may be needed: whether for pictures that move, and for which of the scenes near one that is shown."""
REFINING: Program = False, 0
"""Those of refinement."""
PATIENCE_S = 0.5
TOLD_S = 0.25
"""A picture that takes longer than the first is told of, as often as the second."""
SAID = {"render": "drawing", "upload": "uploading", "upload labels": "uploading labels", "levels": "averaging"}
"""How clients are told what the renderer calls otherwise."""
COMPILED_MS = 20.0
HURRIED_OPACITY = 0.7
FPS_S = 1.0


@dataclass(frozen=True)
class Wanted:
    """What a view is to show; with which revision of the state, and after how many messages that change it."""

    document: Document
    size_px: tuple[int, int]
    revision: int = field(default=0, compare=False)
    inputs: int = field(default=0, compare=False)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A picture that was drawn, and how."""

    wanted: Wanted
    image: Image
    rung: ladder.Rung
    ms: float
    final: bool = False
    refined: bool = False


class Turn(enum.Enum):
    """What a stream does next."""

    MOVE = enum.auto()
    REST = enum.auto()
    WARM = enum.auto()
    REFINE = enum.auto()
    END = enum.auto()


class Stream:
    """Draws a session on a thread of its own.

    Attributes
    ----------
    image
        What was sent last: what a probe asks.
    """

    MOST_PX = 4096

    def __init__(self, session: Session) -> None:
        self.image: Image | None = None
        self._session = session
        self._changed = threading.Condition()
        self._closed = False
        self._wanted: Wanted | None = None
        self._moved_at = 0.0
        # How far the picture of what is wanted has come; used by the stream's thread alone.
        self._begun: Wanted | None = None
        self._full: Wanted | None = None
        self._refined: Wanted | None = None
        self._last: Drawn | None = None
        self._warm: tuple[Any, deque[Program]] = (None, deque())
        self._is_warm = True
        self._cost: Cost | None = None
        self._pace = ladder.Pace()
        self._times: deque[float] = deque()
        self._failure = ""
        self._numbers = itertools.count(1)
        self._message: tuple[dict[str, Any], list[bytes]] | None = None
        self._told: tuple[str, int, int] = ("preparing", 0, 0)
        self._thread = threading.Thread(target=self._run, name="airlight-stream", daemon=True)
        self._thread.start()

    # -- from any thread

    def wake(self) -> None:
        """Something may have changed."""
        with self._changed:
            session, before = self._session, self._wanted
            self._wanted = Wanted(session.document, session.size_px, session.revision, session.inputs)
            if self._wanted != before:
                self._moved_at = session.viewer.moved_at = time.monotonic()
            self._changed.notify_all()

    def again(self) -> None:
        """Somebody has come who has no picture: there may be one, else it is drawn."""
        message = self._message
        if message is not None:
            for client in self._session.clients:
                client.again(next(self._numbers), *message)
        self.wake()

    def acknowledged(self, frame: int) -> None:
        """A client has shown a picture."""
        trips = [client.trip_ms for client in self._session.clients if client.acknowledged(frame)]
        with self._changed:
            # A slow client is no reason to simplify what a quick one is shown.
            quickest = min((client.trip_ms for client in self._session.clients if client.trip_ms is not None), default=None)
            if quickest is not None and trips == [quickest] and self._full is not self._wanted:
                self._pace = ladder.after_trip(self._pace, quickest)
            self._changed.notify_all()

    def close(self) -> None:
        """Stop. Idempotent."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for view in (self._session.key, self._warm_view):
            self._session.viewer.renderer.close_view(view)

    # -- what comes next

    def _run(self) -> None:
        drawn: Drawn | None = None
        while (turn := self._next(patient=drawn is None)) is not Turn.END:
            wanted, drawn, done = self._wanted, None, drawn
            try:
                drawn = self._take(turn, wanted, done)
            except Exception as error:  # one picture less: the view goes on with what is wanted next
                self._begun = self._full = self._refined = wanted
                self._fail(error)

    def _take(self, turn: Turn | None, wanted: Wanted | None, drawn: Drawn | None) -> Drawn | None:
        """Do what comes next; a moving picture is returned, to be shown while the next one is drawn."""
        if turn is Turn.MOVE:
            return self._moved(wanted, drawn)
        if drawn is not None:
            self._show(drawn)
        elif turn is Turn.REST:
            self._rested(wanted)
        elif turn is Turn.WARM:
            self._warmed(wanted)
        elif turn is Turn.REFINE:
            self._refine(wanted)
        return None

    def _next(self, patient: bool) -> Turn | None:
        """Return what is to be done, None where that may wait; a patient stream waits for it."""
        with self._changed:
            while True:
                turn, wait_s = self._due()
                if turn is not None or not patient:
                    break
                self._changed.wait(wait_s)
        if turn is Turn.END and not self._closed:
            self._session.viewer.end(self._session)
        return turn

    def _due(self) -> tuple[Turn | None, float | None]:
        """What is due now; or nothing, and when to ask again [s]."""
        session, now = self._session, time.monotonic()
        clients = session.clients
        if self._closed:
            return Turn.END, None
        if not clients:
            left_s = session.ends_in_s()
            return (Turn.END, None) if left_s <= 0 else (None, min(left_s, threading.TIMEOUT_MAX))
        if self._wanted is None:
            return None, None
        if not any(client.has_room for client in clients):
            return None, 1.0
        if self._wanted != self._begun:
            return Turn.MOVE, None
        rests_in_s = REST_S - (now - self._moved_at)
        if self._wanted != self._full:
            return (Turn.REST, None) if rests_in_s <= 0 else (None, rests_in_s)
        if self._is_warm and self._refined == self._wanted:
            return None, None
        # Programs are compiled once for all views: they do not wait until all of many rest, which they may never do at once.
        calm_in_s = CALM_S - (now - (session.viewer.moved_at if self._is_warm else self._moved_at))
        if calm_in_s > 0:
            return None, calm_in_s
        return (Turn.REFINE if self._is_warm else Turn.WARM), None

    def _is_late(self, wanted: Wanted) -> bool:
        """Whether a view is to show something else by now."""
        return self._closed or (self._wanted is not wanted and self._wanted != wanted)

    # -- drawing

    def _moved(self, wanted: Wanted | None, before: Drawn | None) -> Drawn | None:
        """Draw what moves; meanwhile encode and send what was drawn before."""
        assert wanted is not None
        self._begun = wanted
        rung = self._pace.drawn(wanted.document.step)
        start = time.monotonic()
        future = self._submit(wanted, rung)
        if before is not None:
            self._show(before)
        image = self._result(future)
        if image is None:
            return None
        ms = 1e3 * (time.monotonic() - start)
        self._learn(image, wanted, rung.step, ms)
        return Drawn(wanted, image, rung, ms)

    def _rested(self, wanted: Wanted | None) -> None:
        """Draw a view in full, as it is wanted now, until it changes."""
        assert wanted is not None
        last, full = self._last, ladder.Rung(1.0, wanted.document.step)
        self._pace = ladder.at_rest(self._pace)
        if last is not None and last.wanted == wanted and last.rung == full:
            image: Image | None = last.image
            ms = last.ms
        else:
            start = time.monotonic()
            image = self._result(self._submit(wanted, full, until_late=True))
            ms = 1e3 * (time.monotonic() - start)
        if self._is_late(wanted):
            return
        self._full = wanted
        if image is not None:
            self._begin_warming(wanted)
            self._refined = None if refines(wanted) else wanted
            self._show(Drawn(wanted, image, full, ms, final=True))

    def _submit(self, wanted: Wanted, rung: ladder.Rung, until_late: bool = False) -> Future[Image]:
        """Post a picture."""
        self._told = "preparing", 0, 0

        def progress(what: str, done: int, total: int) -> None:
            self._told = what, done, total
            if until_late:
                self._ends_late(wanted, what)

        document = wanted.document
        options: dict[str, Any] = document.drawing | {"step": rung.step, "view": self._session.key, "progress": progress}
        scene, size_px = document.scene, scaled(wanted.size_px, rung.scale)
        scene = hurried(scene) if rung.hurries else scene
        future: Future[Image] = Future()
        try:
            future = self._session.viewer.renderer.submit(scene, size_px, **options)
        except AirlightError as error:
            future.set_exception(error)
        return future

    def _ends_late(self, wanted: Wanted, what: str) -> None:
        """Raise between two tiles of a picture that is not wanted any more; uploads go on, as every picture needs them."""
        if what.startswith("render") and self._is_late(wanted):
            raise CancelledError

    def _result(self, future: Future[Image]) -> Image | None:
        """Wait for a picture, and tell clients what it waits for if that takes long; None where there is none."""
        is_told = False
        while not wait([future], TOLD_S if is_told else PATIENCE_S).done:
            if self._closed:
                return None
            self._tell_progress(*self._told)
            is_told = True
        if is_told:
            self._tell_progress(self._told[0], 1, 1)
        try:
            image = future.result()
        except CancelledError:
            return None
        except Exception as error:
            self._fail(error)
            return None
        self._failure = ""
        return image

    def _tell_progress(self, what: str, done: int, total: int) -> None:
        name, comma, rest = what.partition(",")
        self._session.tell_progress(SAID.get(name, name) + comma + rest, done, total)

    def _fail(self, error: Exception) -> None:
        """Tell of an error once; the last picture stays."""
        if not isinstance(error, AirlightError):
            logging.getLogger(__name__).error("a picture could not be drawn", exc_info=error)
            error = ValueRangeError("picture", f"could not be drawn ({error})"[:300])
        if str(error) != self._failure:
            self._failure = str(error)
            self._session.send({"type": "error"} | told(error))

    def _learn(self, image: Image, wanted: Wanted, step: float, ms: float) -> None:
        """Learn what pictures take, but for those that had to wait for a compiler or an upload."""
        spent = image.stats.get("milliseconds", {})
        own_ms = spent.get("total", ms) - spent.get("upload", 0.0)
        if spent.get("link and compile", 0.0) > COMPILED_MS:
            return
        width, height = image.size
        self._cost = ladder.learnt(self._cost, width * height, step, own_ms)
        with self._changed:
            self._pace = ladder.after_frame(self._pace, self._cost, wanted.size_px, wanted.document.step)

    # -- what is done while nobody moves anything

    @property
    def _warm_view(self) -> tuple[str, str]:
        return self._session.key, "warm"

    def _begin_warming(self, wanted: Wanted) -> None:
        """Have programs that edits and refinement will need compiled, once for each kind of picture."""
        document, layers = wanted.document, wanted.document.scene.visible_layers
        data = [(layer.look, layer.volume.dtype, layer.volume.channel_count) for layer in layers]
        kind = document.driver, document.passes, data
        if kind == self._warm[0]:
            return

        def programs() -> deque[Program]:
            near = range(1, sum(1 for _ in scenes_near(document.scene)))
            edited = itertools.product((True, False) if self._pace.drawn(document.step).hurries else (False,), near)
            return deque([*edited, REFINING] if refines(wanted) else edited)

        self._warm = self._session.viewer.warmed(kind, programs)
        self._is_warm = False

    def _warmed(self, wanted: Wanted | None) -> None:
        """Compile one of them: what comes meanwhile waits for one alone."""
        assert wanted is not None
        document, renderer, view = wanted.document, self._session.viewer.renderer, self._warm_view
        try:
            hurries, number = program = self._warm[1].popleft()
            scene = next(itertools.islice(scenes_near(document.scene), number, None), document.scene)
            if program != REFINING:
                wait([renderer.submit(hurried(scene) if hurries else scene, (1, 1), **document.drawing, view=view)])
            elif refines(wanted):
                images = renderer.refine(scene, SMALL_PX, view=view, **document.refining)
                deque(itertools.islice(images, SMALL_LEVELS), maxlen=0)
                renderer.close_view(view)
        except (IndexError, AirlightError):  # what cannot be drawn will be told of when it is to be shown
            self._is_warm = True

    def _refine(self, wanted: Wanted | None) -> None:
        """Refine a picture until it is within the tolerance, or anything moves."""
        assert wanted is not None
        document, viewer, start = wanted.document, self._session.viewer, time.monotonic()

        def progress(what: str, _done: int, _total: int) -> None:
            self._ends_late(wanted, what)
            if viewer.moved_at > start:
                raise CancelledError

        options = document.refining | {"progress": progress}
        try:
            for image in viewer.renderer.refine(document.scene, wanted.size_px, view=self._session.key, **options):
                ms, step = 1e3 * (time.monotonic() - start), image.stats.get("refined", {}).get("step", document.step)
                if self._is_late(wanted) or not self._session.clients:
                    return
                self._show(Drawn(wanted, image, ladder.Rung(1.0, step), ms, final=True, refined=True))
        except AirlightError as error:
            self._fail(error)
        if not self._is_late(wanted) and viewer.moved_at <= start:
            self._refined = wanted

    # -- showing

    def _show(self, drawn: Drawn) -> None:
        """Encode a picture and give it to all clients."""
        self._last, self.image = drawn, drawn.image
        start = time.perf_counter()
        pixels = pixels_of(drawn.image, drawn.rung.scale)
        quality = self._pace.quality
        data = png(pixels) if drawn.final else jpeg(pixels, quality)
        encode_ms = 1e3 * (time.perf_counter() - start)
        message = self._header(drawn) | {"ms": {"draw": round(drawn.ms, 2), "encode": round(encode_ms, 2)}}
        message |= {"kind": "png"} if drawn.final else {"kind": "jpeg", "quality": quality}
        self._message = message, [data]
        for client in self._session.clients:
            client.show(next(self._numbers), message, [data])

    def _header(self, drawn: Drawn) -> dict[str, Any]:
        """What clients are told of a picture."""
        wanted, stats, now = drawn.wanted, drawn.image.stats, time.monotonic()
        self._times.append(now)
        while now - self._times[0] > FPS_S:
            self._times.popleft()
        header: dict[str, Any] = {
            "type": "frame",
            "size_px": list(wanted.size_px),
            "drawn_px": list(scaled(wanted.size_px, drawn.rung.scale)),
            "scale": drawn.rung.scale,
            "step": drawn.rung.step,
            "final": drawn.final,
            "refined": drawn.refined,
            "rev": wanted.revision,
            "inputs": wanted.inputs,
            "camera": plain_stage(wanted.document.camera),
            "fps": len(self._times),
            "transparent": drawn.image.background is None,
        }
        if stats.get("reason"):
            header["reason"] = str(stats["reason"])
        if drawn.final:
            header["stats"] = plain_statistics(stats)
        if "tolerance" in stats:
            header["tolerance_reached"] = stats["tolerance"]["pixels_over"] == 0
        return header


def hurried(scene: Scene) -> Scene:
    """Return a scene that is drawn in three quarters of the time, and is not seen to be another as long as it moves.

    Rays end where opacity has come to ``HURRIED_OPACITY``, what lies behind is taken to look alike, and light falls on the
    middle of slabs.
    """

    def drawn(layer: Layer) -> Layer:
        integrate, lighting = layer.look.integrate, layer.look.lighting
        if isinstance(integrate, EmissionAbsorption) and integrate.opaque_at > HURRIED_OPACITY:
            integrate = replace(integrate, opaque_at=HURRIED_OPACITY, fills_rest=True)
        if isinstance(lighting, Sampled) and lighting.at == "light":
            lighting = replace(lighting, at="middle")
        return replace(layer, look=replace(layer.look, integrate=integrate, lighting=lighting))

    return replace(scene, layers=tuple(drawn(layer) for layer in scene.layers))


def refines(wanted: Wanted) -> bool:
    """Whether a view has a picture of a known error: drivers of whole images, and tones that depend on all of it, have none."""
    document = wanted.document
    if document.tolerance is None:
        return False
    try:
        passes = checked_passes(document.passes)
        Request(wanted.size_px, document.driver, skip=document.skip, tolerance=document.tolerance, passes=passes)
        check_tones(document.scene)
    except AirlightError:
        return False
    return True


def plain_statistics(value: Any) -> Any:
    """Statistics as plain data; what would have to be computed first is left out."""
    if isinstance(value, dict):
        return {str(key): plain_statistics(held) for key, held in value.items() if is_at_hand(held)}
    if isinstance(value, (list, tuple)):
        return [plain_statistics(held) for held in value]
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, float):
        return float(f"{value:.6g}") if abs(value) < float("inf") else None
    return value if isinstance(value, (bool, int, str, type(None))) else str(value)


def is_at_hand(value: Any) -> bool:
    """Whether a statistic is there, and is not computed when it is read."""
    return isinstance(value, dict) or not isinstance(value, Mapping)
