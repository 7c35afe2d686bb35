"""The device of a page: what any browser with WebGPU has. Programs are linked for it, and nothing is drawn with it here."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from ..gpu.device import CORE_LIMITS, DeviceInfo
from ..gpu.textures import Encoding, VolumeTexture
from ..shader.program import Traits


class _Kept:
    """What a cache of textures would hold: the grid alone, which the page makes of what it carries."""

    def __init__(self, encoding: Encoding) -> None:
        self._grid = VolumeTexture(None, (encoding,), 0)

    def get(self, key: tuple[Hashable, ...], make: Callable[[], Any], owner: Any = None) -> Any:
        return self._grid if key[0] == "grid" else make()


class PageDevice:
    """Stands in for ``gpu.Device`` while a frame is prepared: core limits, no optional feature, squares of 64 pixels."""

    info = DeviceInfo(0, "a browser with WebGPU", "other", "WebGPU", "")
    traits = Traits(filters_float32=False, workgroup=(8, 8))
    features: frozenset[str] = frozenset()
    limits = CORE_LIMITS
    strands = 1

    def __init__(self, encoding: Encoding) -> None:
        self.kept = _Kept(encoding)
