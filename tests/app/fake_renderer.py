"""A renderer that draws nothing but remembers what it was asked."""

from __future__ import annotations

from typing import Any

import numpy as np

from airlight.rendering.image import Image
from airlight.scene import Scene


class Drawn(list[tuple[Scene, tuple[int, int], dict[str, Any]]]):
    """Scenes, sizes and further arguments of the calls of ``render``."""

    def __call__(self, scene: Scene, size: tuple[int, int], **arguments: Any) -> Image:
        arguments.pop("progress")
        self.append((scene, size, arguments))
        stats = {"adapter": {"name": "none"}, "samples": np.int64(3), "milliseconds": {"total": 1.0}}
        return Image(
            np.full((size[1], size[0], 4), 0.5, np.float32), np.zeros((size[1], size[0]), np.float32), (0, 0, 0), stats
        )
