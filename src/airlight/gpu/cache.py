"""What a device keeps from one frame to the next: one cache, bounded by bytes.

What was used least recently goes first; what the current frame uses never goes, however much it is. WebGPU frees a texture
when nobody refers to it any more. So does this: nothing else refers to what is kept.
"""

from __future__ import annotations

import math
import os
import re
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import wgpu

from ..errors import ValueRangeError

Key = tuple[Hashable, ...]

VARIABLE = "AIRLIGHT_KEEP"
SHARE_OF_MEMORY = 0.25
UNKNOWN_MEMORY = 8 << 30  # where the system does not tell how much it has
LEAST_BYTES = 1 << 12  # of anything: even what is small is bounded in number
UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}


@dataclass(eq=False)
class _Entry:
    value: Any
    bytes: int
    owners: tuple[weakref.ref[Any], ...]
    frame: int


class Cache:
    """Values by key, for the life of their owners; used by the render thread alone.

    Parameters
    ----------
    limit_bytes
        Most bytes that are kept beside what the current frame uses.

    Attributes
    ----------
    bytes
        Bytes that are kept now: of textures and buffers what they hold, of others what ``bytes_of`` takes them for.
    frame
        Number of the current frame.
    owner_released
        Called from any thread when an owner is gone, in the midst of anything: it may do no more than wake the render thread,
        which calls ``forget_released``.
    """

    def __init__(self, limit_bytes: int) -> None:
        self.limit_bytes = limit_bytes
        self.bytes = 0
        self.owner_released: Callable[[], None] = lambda: None
        self._entries: OrderedDict[Key, _Entry] = OrderedDict()
        self.frame = 0

    def __iter__(self) -> Iterator[Key]:
        """Keys, that of the least recent use first."""
        return iter(self._entries)

    def get(self, key: Key, make: Callable[[], Any], *owners: Any) -> Any:
        """Value of a key and of these owners themselves, not of equal ones; it is made when it is not there.

        A key must not hold its owners, which would live as long as the cache. Where the device has no room, what the frame does
        not use is given up before it is tried again.
        """
        full = (*key, *map(id, owners))
        value = self.find(key, *owners)
        if value is None:
            self.drop(full)  # another owner may have got the number of one that is gone
            try:
                value = make()
            except wgpu.GPUOutOfMemoryError:
                if not self.trim(0):
                    raise
                value = make()
            references = tuple(weakref.ref(owner, self._released) for owner in owners)
            self._entries[full] = entry = _Entry(value, LEAST_BYTES + bytes_of(value), references, self.frame)
            self.bytes += entry.bytes
            self.trim()
        return value

    def find(self, key: Key, *owners: Any) -> Any | None:
        """Value of a key and of these owners, None when it is not there."""
        full = (*key, *map(id, owners))
        entry = self._entries.get(full)
        if entry is None or any(known() is not owner for known, owner in zip(entry.owners, owners, strict=True)):
            return None
        entry.frame = self.frame
        self._entries.move_to_end(full)
        return entry.value

    def drop(self, key: Key) -> None:
        """Give up what is kept under a key, owners' numbers included."""
        entry = self._entries.pop(key, None)
        if entry is not None:
            self.bytes -= entry.bytes

    def begin_frame(self) -> None:
        """From now on another frame is the current one."""
        self.frame += 1
        self.forget_released()

    def trim(self, limit_bytes: int | None = None) -> bool:
        """Give up what the current frame has not used, the least recent first, down to a limit. Whether anything went."""
        limit, before = self.limit_bytes if limit_bytes is None else limit_bytes, self.bytes
        for key in [key for key, entry in self._entries.items() if entry.frame < self.frame]:
            if self.bytes <= limit:
                break
            self.drop(key)
        return self.bytes < before

    def keep_newest(self, kind: str, most: int) -> None:
        """Of what is kept under keys that begin with a kind, keep so many, and what the current frame uses."""
        keys = [key for key in self._entries if key[0] == kind]
        for key in keys[: max(0, len(keys) - most)]:
            if self._entries[key].frame < self.frame:
                self.drop(key)

    def forget_released(self) -> None:
        """Give up what belonged to owners that are gone."""
        for key in [key for key, entry in self._entries.items() if any(owner() is None for owner in entry.owners)]:
            self.drop(key)

    def clear(self) -> None:
        """Give up everything."""
        self._entries.clear()
        self.bytes = 0

    def _released(self, _: weakref.ref[Any]) -> None:
        self.owner_released()


def bytes_of(value: Any) -> int:
    """Bytes of a texture, a buffer, an array, or of what knows its own ``bytes``; 0 of all else."""
    if isinstance(value, wgpu.GPUTexture):
        channels, bits = re.match(r"([rgba]+)(\d+)", value.format).groups()  # type: ignore[union-attr]
        levels = [[max(1, n >> level) for n in value.size] for level in range(value.mip_level_count)]
        return sum(map(math.prod, levels)) * len(channels) * int(bits) // 8
    if isinstance(value, wgpu.GPUBuffer):
        return int(value.size)
    return int(getattr(value, "nbytes", None) or getattr(value, "bytes", None) or 0)


def default_limit(kind: str, adapter_limits: Mapping[str, int]) -> int:
    """Most bytes that are kept when nobody tells.

    A quarter of the system's memory where the device shares it. A discrete one does not say how much it has: there it is what
    its largest buffer may take, if that is less.

    Raises
    ------
    ValueRangeError
        When ``AIRLIGHT_KEEP`` is no size.
    """
    told = os.environ.get(VARIABLE, "").strip()
    if told:
        match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([kmgt]?)(?:i?b)?", told.lower())
        if not match:
            raise ValueRangeError(VARIABLE, f"is {told!r}, must be a size", "e.g. 4G or 500M")
        return int(float(match[1]) * UNITS[match[2]])
    share = int(SHARE_OF_MEMORY * system_memory())
    return share if kind in ("software", "integrated") else min(share, int(adapter_limits["max-buffer-size"]))


def system_memory() -> int:
    """Bytes of memory that the system has."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return UNKNOWN_MEMORY
