"""Where pages wait until there is something to look at, and who is there."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..session import Viewer

GONE = (1000, 1001)  # codes of a page that was closed; a cut connection has others


class Lobby:
    """A viewer that is there or on its way, and the pages that are open.

    Parameters
    ----------
    viewer
        The viewer, if it is there; else ``viewer.set_result`` brings it.
    """

    def __init__(self, viewer: Viewer | None = None) -> None:
        self.viewer: Future[Viewer] = Future()
        self.told: tuple[str, int, int] | None = None
        self._lock = threading.Lock()
        self._open = self._cut = 0
        self._left: float | None = None
        if viewer is not None:
            self.viewer.set_result(viewer)

    def progress(self, what: str, done: int, total: int) -> None:
        """Tell those who wait what is being done, how much of it, and how much there is (0 when unknown)."""
        self.told = (what, done, total)

    @property
    def sockets(self) -> int:
        """How many are open."""
        return self._open

    def entered(self) -> None:
        """A page has come; it may be one whose connection was cut."""
        with self._lock:
            self._open += 1
            self._cut = max(0, self._cut - 1)
            self._left = None

    def left(self, code: int) -> None:
        """A page has gone, or its connection was cut: then it will be back."""
        with self._lock:
            self._open -= 1
            self._cut += code not in GONE
            self._left = time.monotonic()

    def empty_s(self) -> float:
        """Seconds since the last page was closed; 0 while there is one, before the first, and for one that was cut off."""
        with self._lock:
            return 0.0 if self._open or self._cut or self._left is None else time.monotonic() - self._left
