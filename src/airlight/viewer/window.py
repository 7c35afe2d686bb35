"""A native window on a viewer: the gestures and keys of the page, its pictures, and no page."""

from __future__ import annotations

import io
import threading
import time
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..errors import DeviceError, MissingExtraError
from ..gpu.device import adapters
from .gestures import BINDINGS, bound
from .session import Viewer

TOOLKITS = ("glfw", "pyside6", "pyqt6")
SIZE = (1024, 768)
MOST_FPS = 60
TAP_S = 0.12
TRAVEL_S = 0.35
WHEEL = 0.0006
"""Heights of a drag for a unit of a wheel, of which a notch has about a hundred."""
BUTTONS = {1: "left", 2: "right", 3: "middle"}
STANDPOINTS = ("fit", "reset", "view", "recall")
SHIFTED = {"/": "?", "=": "+", "_": "-"}
EVENTS = ("pointer_down", "pointer_move", "pointer_up", "double_click", "wheel", "key_down", "key_up", "resize", "close")
AROUND_PX = 12
NO_WINDOW = "leave --window out: a page needs no display"

Picture = npt.NDArray[np.uint8]


class Loop(Protocol):
    """What a window needs of a loop of events."""

    def call_later(self, delay: float, callback: Callable[[], Any]) -> Any:
        """Call something on the loop's thread in some seconds."""

    def call_soon_threadsafe(self, callback: Callable[[], Any]) -> Any:
        """Call something on the loop's thread, from any thread."""


def show(viewer: Viewer) -> None:
    """Open a window on a viewer, and return once it is closed.

    Raises
    ------
    MissingExtraError
        Without rendercanvas, or a toolkit that opens windows.
    DeviceError
        Where there is no display.
    """
    canvas, loop = opened(viewer.name)
    window = Window(viewer, canvas, loop)
    try:
        loop.run()
    finally:
        window.close()


def opened(name: str) -> tuple[Any, Any]:
    """Return a window of the first toolkit that is there, and its loop.

    Raises
    ------
    MissingExtraError
        When there is none.
    DeviceError
        When it opens none.
    """
    for toolkit in TOOLKITS:
        try:
            module = import_module(f"rendercanvas.{toolkit}")
        except ImportError:
            continue
        if toolkit == "glfw" and not has_display():
            break
        adapters()  # the renderer's choice of them comes first
        try:
            canvas = module.RenderCanvas(size=SIZE, title=name or "airlight", max_fps=MOST_FPS, update_mode="ondemand")
        except RuntimeError as error:
            raise DeviceError("the window", f"cannot be opened ({str(error)[:200]})", NO_WINDOW) from error
        return canvas, module.loop
    else:
        raise MissingExtraError("the window", "needs rendercanvas and glfw", 'pip install "airlight[window]"')
    raise DeviceError("the window", "cannot be opened: there is no display", NO_WINDOW)


def has_display() -> bool:
    """Whether glfw finds a display; without one its windows end the process."""
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return bool(glfw.init())


class Window:
    """What joins a canvas of rendercanvas to a session of its own.

    Parameters
    ----------
    viewer
        What it looks at.
    canvas
        Any canvas of rendercanvas.
    loop
        The canvas's loop.
    """

    def __init__(self, viewer: Viewer, canvas: Any, loop: Loop) -> None:
        self.session, self._canvas, self._loop = viewer.session(), canvas, loop
        self._bitmaps = canvas.get_bitmap_context()
        self._lock = threading.Lock()
        self._picture: Picture | None = None
        self._status, self._helps, self._strokes = "", False, 0
        self._drag: tuple[str, float, float] | None = None
        self._held: dict[str, dict[str, Any]] = {}
        self._fast, self._ticked_at = False, 0.0
        canvas.add_event_handler(self._event, *EVENTS)
        canvas.request_draw(self._draw)
        self._detach = self.session.listen(self._take)
        self.session.receive({"type": "hello", "size_px": list(canvas.get_physical_size()), "ratio": canvas.get_pixel_ratio()})

    def close(self) -> None:
        """Look no more. Idempotent."""
        self._held.clear()
        self._detach()

    # -- from the session, on its threads

    def _take(self, message: Mapping[str, Any], buffers: list[bytes]) -> None:
        kind = message.get("type")
        if kind == "frame":
            picture = decoded(buffers[0], self._canvas.get_physical_size())
            width, height = message["drawn_px"]
            moving = "" if message["final"] else f", {message['fps']} fps"
            with self._lock:
                self._picture = picture
                self._status = f"{self.session.name or 'airlight'} - {width} x {height}{moving}, step {message['step']:.2g}"
            self._loop.call_soon_threadsafe(self._again)
            self.session.receive({"type": "ack", "frame": message["frame"]})
        elif kind == "error" or (kind == "answer" and "error" in message):
            error = message if kind == "error" else message["error"]
            words = " ".join(part for part in (error["where"], error["what"], error["remedy"]) if part)
            with self._lock:
                self._status = words
            self._loop.call_soon_threadsafe(self._again)

    def _again(self) -> None:
        if not self._canvas.get_closed():
            self._canvas.set_title(self._status)
            self._canvas.request_draw()

    def _draw(self) -> None:
        with self._lock:
            picture = self._picture
        if picture is None:
            width, height = self._canvas.get_physical_size()
            picture = np.zeros((max(height, 1), max(width, 1), 4), np.uint8)
        self._bitmaps.set_bitmap(with_help(picture, self._canvas.get_pixel_ratio()) if self._helps else picture)

    # -- from the canvas

    def _event(self, event: Mapping[str, Any]) -> None:
        handle = getattr(self, f"_{event['event_type']}")
        handle(event)

    def _resize(self, event: Mapping[str, Any]) -> None:
        self.session.receive({"type": "size", "size_px": [max(n, 1) for n in self._canvas.get_physical_size()]})

    def _close(self, event: Mapping[str, Any]) -> None:
        self.close()

    def _pointer_down(self, event: Mapping[str, Any]) -> None:
        entry = self._bound("pointer", BUTTONS.get(event["button"], ""), event)
        self._strokes += 1
        self._drag = (entry["kind"], event["x"], event["y"]) if entry else None

    def _pointer_move(self, event: Mapping[str, Any]) -> None:
        if self._drag is None:
            return
        kind, x, y = self._drag
        height = self._canvas.get_logical_size()[1]
        self._drag = kind, event["x"], event["y"]
        self._send(kind=kind, dx=(event["x"] - x) / height, dy=(event["y"] - y) / height, stroke=self._strokes)

    def _pointer_up(self, event: Mapping[str, Any]) -> None:
        self._drag = None

    def _wheel(self, event: Mapping[str, Any]) -> None:
        entry = self._bound("pointer", "wheel", event)
        if entry:
            self._send(kind=entry["kind"], dy=(event["dy"] or event["dx"]) * WHEEL, at=self._at(event))

    def _double_click(self, event: Mapping[str, Any]) -> None:
        arguments = {"at": self._at(event), "seconds": TRAVEL_S}
        self.session.receive({"type": "ask", "id": "aim", "what": "aim", "arguments": arguments})

    def _key_down(self, event: Mapping[str, Any]) -> None:
        name = key_name(event)
        self._fast = "Shift" in event["modifiers"]
        if self._helps:
            self._helps = False
            self._canvas.request_draw()
        entry = self._bound("key", name, event)
        if entry is None or (entry.get("modifier") != "Control" and {"Control", "Alt", "Meta"} & set(event["modifiers"])):
            return
        if entry.get("held"):
            self._send(**amounts(entry, TAP_S, self._fast))
            if not self._held:
                self._ticked_at = time.monotonic()
                self._loop.call_later(1 / MOST_FPS, self._tick)
            self._held[name] = entry
        elif "command" in entry:
            self._command(entry["command"])
        else:
            travel = {"seconds": TRAVEL_S} if entry["kind"] in STANDPOINTS else {}
            self._send(kind=entry["kind"], name=entry.get("name", ""), dx=entry.get("dx", 0.0), **travel)

    def _key_up(self, event: Mapping[str, Any]) -> None:
        self._fast = "Shift" in event["modifiers"]
        self._held.pop(key_name(event), None)

    def _tick(self) -> None:
        now = time.monotonic()
        seconds, self._ticked_at = min(now - self._ticked_at, 0.1), now
        for entry in self._held.values():
            self._send(**amounts(entry, seconds, self._fast))
        if self._held:
            self._loop.call_later(1 / MOST_FPS, self._tick)

    def _command(self, name: str) -> None:
        if name in ("undo", "redo"):
            self.session.receive({"type": name})
        elif name == "help":
            self._helps = True
            self._canvas.request_draw()

    def _send(self, **gesture: Any) -> None:
        self.session.receive({"type": "gesture", **gesture})

    def _at(self, event: Mapping[str, Any]) -> list[float]:
        """Place of the pointer from the middle, in parts of the window's height."""
        width, height = self._canvas.get_logical_size()
        return [(event["x"] - width / 2) / height, event["y"] / height - 0.5]

    def _bound(self, source: str, name: str, event: Mapping[str, Any]) -> dict[str, Any] | None:
        return bound(source, name, frozenset(event["modifiers"]), self.session.habits.turning)


def key_name(event: Mapping[str, Any]) -> str:
    """Name of a key in the table of bindings; toolkits tell what is on the key, not what Shift makes of it."""
    key = str(event["key"])
    if "Shift" in event["modifiers"] and key in SHIFTED:
        return SHIFTED[key]
    return "+" if key == "=" else key.lower() if len(key) == 1 else key


def amounts(entry: Mapping[str, Any], seconds: float, fast: bool) -> dict[str, Any]:
    """Gesture of a key that is held for some seconds."""
    factor = seconds * (entry.get("fast", 1.0) if fast else 1.0)
    return {"kind": entry["kind"], **{name: entry[name] * factor for name in ("dx", "dy", "dz") if name in entry}}


def decoded(data: bytes, size_px: tuple[int, int]) -> Picture:
    """Picture (height, width, 4) of a frame, as it is shown: of the window's size, on black."""
    from PIL import Image

    with Image.open(io.BytesIO(data)) as image:
        shown = image.convert("RGBA")
    width, height = size_px
    if shown.size != (width, height) and min(width, height) > 0:
        shown = shown.resize((width, height), Image.Resampling.BILINEAR)
    ground = Image.new("RGBA", shown.size, (0, 0, 0, 255))
    return np.asarray(Image.alpha_composite(ground, shown))


def with_help(picture: Picture, ratio: float) -> Picture:
    """Picture with the table of gestures and keys written over it."""
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(picture // 4 + np.array([0, 0, 0, 192], np.uint8))
    font = ImageFont.load_default(13 * ratio)
    ImageDraw.Draw(image).multiline_text(
        (AROUND_PX * ratio, AROUND_PX * ratio), help_text(), (255, 255, 255), font, spacing=4 * ratio
    )
    return np.asarray(image)


def help_text() -> str:
    """What a window knows of the table of bindings, one meaning a line."""
    lines: dict[str, list[str]] = {}
    for entry in BINDINGS:
        if entry.get("pointer") in ("pinch", "two", "twist") or entry.get("command") not in (None, "undo", "redo", "help"):
            continue
        made = "+".join(filter(None, (entry.get("modifier"), entry.get("key") or f"{entry['pointer']} button")))
        made = made.replace("Arrow", "").replace("wheel button", "wheel").replace("double button", "double click")
        meaning = f"{entry['help']}, flying" if "turning" in entry else entry["help"]
        lines.setdefault(meaning, []).append(made)
    return "\n".join(f"{', '.join(made)}:  {meaning}" for meaning, made in lines.items())
