"""A renderer that takes as long as it is told, and clients that keep what they get."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from airlight.rendering.image import Image
from airlight.scene import Scene
from airlight.viewer.session import Session
from airlight.viewer.stream import SMALL_PX


def eventually(condition: Callable[[], Any], timeout_s: float = 10.0) -> Any:
    """Wait until something holds, and return it."""
    end = time.monotonic() + timeout_s
    while not (found := condition()):
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.002)
    return found


class Drawing:
    """Stands for a renderer: draws nothing, one picture after the other.

    ``warmed`` are the functions of scenes of which programs alone are wanted, and the size of a picture whose refinement is.
    """

    LEVELS = 3

    def __init__(self) -> None:
        self.drawn: list[tuple[tuple[int, int], dict[str, Any]]] = []
        self.refined: list[str] = []
        self.warmed: list[Any] = []
        self.takes_s = 0.0
        self.level_s = 0.0
        self.error: Exception | None = None
        self._thread = ThreadPoolExecutor(1)
        self._lock = threading.Lock()

    def submit(self, scene: Scene, size: tuple[int, int], **options: Any) -> Future[Image]:
        if size == (1, 1):
            self.warmed.append((scene.layers[0].transfer, scene.layers[0].look))
        else:
            self.drawn.append((size, options))
        return self._thread.submit(self._draw, scene, size, self.takes_s, options.get("progress"))

    def refine(self, scene: Scene, size: tuple[int, int], **options: Any) -> Iterator[Image]:
        if size == SMALL_PX:
            self.warmed.append(size)
            return
        for level in range(1, 1 + self.LEVELS):
            try:
                image = self._thread.submit(self._draw, scene, size, self.level_s, options["progress"]).result()
            except CancelledError:
                self.refined.append("ended")
                return
            left = self.LEVELS - level
            image.stats.update({"refined": {"scale": 1.0, "step": 0.5**level}, "tolerance": {"pixels_over": left}})
            yield image
        self.refined.append("done")

    def _draw(self, scene: Scene, size: tuple[int, int], takes_s: float, progress: Any) -> Image:
        if self.error is not None:
            raise self.error
        end = time.monotonic() + takes_s
        while time.monotonic() < end:
            time.sleep(0.005)
            if progress is not None:
                progress("render, step 1", 1, 10)
        rgba = np.zeros((size[1], size[0], 4), np.float32)
        stats = {"milliseconds": {"total": 1e3 * takes_s}, "samples": np.int64(7)}
        return Image(rgba, rgba[..., 0], (0.0, 0.0, 0.0), stats, scene=scene)

    def close_view(self, view: Any) -> None: ...


class Watching:
    """A client of a session: ``acks`` tells whether it shows what it gets."""

    def __init__(self, session: Session, acks: bool = True, size_px: tuple[int, int] = (32, 24)) -> None:
        self.session, self.acks = session, acks
        self.messages: list[dict[str, Any]] = []
        self.buffers: list[bytes] = []
        self.detach = session.listen(self._take)
        session.receive({"type": "hello", "size_px": list(size_px)})

    def _take(self, message: dict[str, Any], buffers: list[bytes]) -> None:
        self.messages.append(message)
        self.buffers += buffers
        if self.acks and message["type"] == "frame":
            self.session.receive({"type": "ack", "frame": message["frame"]})

    def of(self, kind: str) -> list[dict[str, Any]]:
        """Messages of a kind."""
        return [message for message in list(self.messages) if message["type"] == kind]

    @property
    def last(self) -> dict[str, Any]:
        """The newest picture; one that shows nothing before the first."""
        return (self.of("frame") or [{"final": False, "refined": False, "inputs": -1, "rev": -1, "camera": {}}])[-1]

    def turn(self, by: float = 0.01) -> None:
        self.session.receive({"type": "gesture", "kind": "orbit", "dx": by, "dy": 0.0})

    def show_all(self) -> None:
        """Acknowledge all pictures."""
        for message in self.of("frame"):
            self.session.receive({"type": "ack", "frame": message["frame"]})
