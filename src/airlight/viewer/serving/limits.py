"""How much a client may send and be sent."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Bounds of what sockets take.

    Parameters
    ----------
    message_bytes
        Longest message that a client may send.
    messages_per_s, burst
        How fast messages are read; who sends more waits, and nobody else does. So many at once are read without a pause.
    sockets
        Open at one time.
    waiting_bytes
        What may wait for a client that does not read: where more does, the connection is cut. One message may be longer.
    stalled_s
        So long [s] a client may take to read what is on its way, or to show that it is there at all.
    """

    message_bytes: int = 2 << 20
    messages_per_s: float = 500.0
    burst: int = 500
    sockets: int = 32
    waiting_bytes: int = 64 << 20
    stalled_s: float = 120.0


class Pace:
    """Lets so many messages a second pass."""

    def __init__(self, per_s: float, burst: int) -> None:
        self._per_s, self._burst = per_s, float(burst)
        self._left, self._seen = float(burst), time.monotonic()

    def pause_s(self, now: float | None = None) -> float:
        """Take a message; returns how long to wait before the next is read."""
        now = time.monotonic() if now is None else now
        self._left = min(self._burst, self._left + (now - self._seen) * self._per_s) - 1
        self._seen = now
        return max(0.0, -self._left / self._per_s)


class Outbox:
    """What waits to be sent to a client; it is put in from any thread."""

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._loop = asyncio.get_running_loop()
        self._waiting: deque[bytes] = deque()
        self._bytes = 0
        self._changed = asyncio.Event()
        self.overflowed = asyncio.Event()

    def put(self, data: bytes) -> None:
        """Add a message; returns at once."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._add, data)

    def _add(self, data: bytes) -> None:
        if self._bytes > self._most_bytes:
            self.overflowed.set()
        if not self.overflowed.is_set():
            self._waiting.append(data)
            self._bytes += len(data)
            self._changed.set()

    async def take(self) -> bytes:
        """Return the next message, once there is one."""
        while not self._waiting:
            self._changed.clear()
            await self._changed.wait()
        data = self._waiting.popleft()
        self._bytes -= len(data)
        return data
