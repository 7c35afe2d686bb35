"""Progress on standard error: only at a terminal, and only for what takes more than a second."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

DELAY_S = 1.0


class ProgressBar:
    """Called with what is done, how much of it is done, and how much there is (0 when unknown); a context manager."""

    def __init__(self, delay_s: float = DELAY_S) -> None:
        self._enabled = sys.stderr is not None and sys.stderr.isatty()
        self._delay_s = delay_s
        self._started: float | None = None
        self._bars: Progress | None = None
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, what: str, done: int, total: int) -> None:
        """Show the progress once the first report is older than the delay."""
        if not self._enabled:
            return
        now = time.monotonic()
        self._started = now if self._started is None else self._started
        if now - self._started < self._delay_s:
            return
        if self._bars is None:
            self._bars = _bars()
            self._bars.start()
        if what not in self._tasks:
            self._tasks[what] = self._bars.add_task(what, total=total or None)
        self._bars.update(self._tasks[what], completed=done, total=total or None)

    def __enter__(self) -> Self:
        self._started = time.monotonic()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bars is not None:
            self._bars.stop()
            self._bars = None


def _bars() -> Progress:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f}%"), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), transient=True)
