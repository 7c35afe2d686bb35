"""The render thread: it alone uses the device; others post work to it and get futures.

The queue is fair: views take turns, and of each view only the newest frame is kept. Work of no view is done in order.
Between jobs it tidies up when it is woken, which finalizers may do at any time.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

from ..errors import DeviceError

T = TypeVar("T")


class Cancelled(CancelledError):  # noqa: N818 - it ends work, it is no error
    """Raised inside work that is not wanted any more."""


@dataclass(eq=False)
class Job(Generic[T]):
    """Work with its future; ``cancelled`` is set when a newer frame of its view arrives or the view is closed."""

    work: Callable[[Job[T]], T]
    future: Future[T] = field(default_factory=Future)
    cancelled: threading.Event = field(default_factory=threading.Event)

    def check(self) -> None:
        """Raise ``Cancelled`` when the work is not wanted any more; called between tiles."""
        if self.cancelled.is_set():
            raise Cancelled

    def cancel(self) -> None:
        """Give the work up, whether it has begun or not."""
        self.cancelled.set()
        self.future.cancel()


def _settle(job: Job[Any]) -> None:
    try:
        result = job.work(job)
    except BaseException as error:
        # Its traceback leads to the job: no ring, which would keep scenes until garbage is collected.
        future, job.future = job.future, Future()
        future.set_exception(error)
        del future
    else:
        job.future.set_result(result)


class RenderThread:
    """One daemon thread with a fair queue; it calls ``idle`` whenever it has been woken from waiting."""

    def __init__(self, name: str = "airlight-render", idle: Callable[[], None] = lambda: None) -> None:
        self._views: OrderedDict[Hashable, list[Job[Any]]] = OrderedDict()
        self._running: tuple[Hashable, Job[Any]] | None = None
        self._lock = threading.RLock()
        # Unlike a condition, a SimpleQueue may be told something in the midst of anything, by a finalizer, too.
        self._bell: SimpleQueue[None] = SimpleQueue()
        self._idle = idle
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, work: Callable[[Job[T]], T], view: Hashable = None) -> Future[T]:
        """Post work; of one ``view``, older frames that wait or run are given up."""
        job: Job[T] = Job(work)
        with self._lock:
            if self._closed:
                raise DeviceError("renderer", "is closed", "make a new one")
            if view is not None:
                self._give_up(view)
            self._views.setdefault(view, []).append(job)
        self.wake()
        return job.future

    def wake(self) -> None:
        """Have the thread look for work and tidy up; allowed anywhere."""
        self._bell.put(None)

    def close_view(self, view: Hashable) -> None:
        """Give up the frames of one view and of no other."""
        with self._lock:
            self._give_up(view)
            self._views.pop(view, None)

    def close(self, last: Callable[[], None] | None = None, wait: bool = True) -> None:
        """Give up what waits, run ``last`` on the thread and end it. Idempotent."""
        with self._lock:
            if not self._closed:
                for view in list(self._views):
                    self._give_up(view)
                self._views.clear()
                self._last = last
            self._closed = True
        self.wake()
        if wait and threading.current_thread() is not self._thread:
            self._thread.join(timeout=60)

    def _give_up(self, view: Hashable) -> None:
        for job in self._views.get(view, ()):
            job.cancel()
        self._views[view] = []
        if self._running is not None and self._running[0] == view:
            self._running[1].cancel()

    def _next(self) -> tuple[Hashable, Job[Any]] | None:
        while True:
            with self._lock:
                for view, jobs in self._views.items():
                    if jobs:
                        # The view goes to the end of the line.
                        self._views.move_to_end(view)
                        self._running = view, jobs.pop(0)
                        return self._running
                if self._closed:
                    return None
            self._bell.get()
            if self._bell.empty():
                self._idle()

    def _run(self) -> None:
        while (turn := self._next()) is not None:
            _, job = turn
            try:
                if not job.cancelled.is_set() and job.future.set_running_or_notify_cancel():
                    _settle(job)
            finally:
                with self._lock:
                    self._running = None
                # The thread keeps no scene and no image while it waits.
                del job, turn
        if self._last is not None:
            self._last()

    _last: Callable[[], None] | None = None
