"""Values that were made lately, kept so that they need not be made again."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


class Kept(Generic[Key, Value]):
    """The values that were last asked for, by key, each made once; several threads may ask.

    Copies and pickles of it are empty: what is kept can be made again.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self._values: dict[Key, Value] = {}
        self._lock = threading.RLock()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of a key, or make it; the one that was not asked for the longest gives way."""
        with self._lock:
            value = self._values.pop(key) if key in self._values else make()
            self._values[key] = value
            while len(self._values) > self.most:
                del self._values[next(iter(self._values))]
            return value

    def __len__(self) -> int:
        return len(self._values)

    def __reduce__(self) -> tuple[type[Kept[Key, Value]], tuple[int]]:
        return type(self), (self.most,)
