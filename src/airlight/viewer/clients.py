"""Those who look at a view: what each has been sent and has not shown yet."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

Send = Callable[[dict[str, Any], list[bytes]], None]
"""Gives a message and its buffers to a client; returns at once, from any thread."""

MOST_IN_FLIGHT = 2
LOST_S = 10.0
"""A picture that has not been shown for so long is taken for lost, so that one that could not be decoded ends nothing."""


class Client:
    """One who looks. Two pictures at most are on their way to it; of those drawn meanwhile, the newest waits."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._lock = threading.RLock()  # one who acknowledges in the midst of being sent something comes back here
        self._sent: dict[int, float] = {}
        self._waiting: tuple[int, dict[str, Any], list[bytes]] | None = None
        self.trip_ms: float | None = None

    def tell(self, message: dict[str, Any], buffers: Sequence[bytes] = ()) -> None:
        """Send a message; one who cannot be told any more is about to be detached."""
        try:
            self._send(message, list(buffers))
        except Exception:
            logging.getLogger(__name__).debug("a client cannot be told", exc_info=True)

    @property
    def has_room(self) -> bool:
        """Whether another picture would be sent at once; never waits."""
        now = time.monotonic()
        return sum(now - sent <= LOST_S for sent in list(self._sent.values())) < MOST_IN_FLIGHT

    def show(self, number: int, message: dict[str, Any], buffers: list[bytes]) -> None:
        """Send a picture, or have it wait in the place of an older one."""
        with self._lock:
            self._waiting = number, message, buffers
            self._next()

    def again(self, number: int, message: dict[str, Any], buffers: list[bytes]) -> None:
        """Send a picture to one who begins anew."""
        with self._lock:
            self._sent.clear()
        self.show(number, message, buffers)

    def acknowledged(self, number: int) -> bool:
        """Take note that a picture is shown; whether it was one of this client's."""
        with self._lock:
            sent = self._sent.pop(number, None)
            if sent is None:
                return False
            self.trip_ms = 1e3 * (time.monotonic() - sent)
            self._next()
            return True

    def _next(self) -> None:
        if self._waiting is not None and self.has_room:
            number, message, buffers = self._waiting
            now, self._waiting = time.monotonic(), None
            self._sent = {known: sent for known, sent in self._sent.items() if now - sent <= LOST_S} | {number: now}
            self.tell({**message, "frame": number}, buffers)
