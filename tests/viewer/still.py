"""A renderer that draws nothing, at once, for tests of the viewer in which the picture is not the point."""

from __future__ import annotations

import time
from concurrent.futures import Future
from typing import Any

import numpy as np

import airlight as al


class StillRenderer:
    """Draws nothing, at once."""

    def submit(self, scene: al.Scene, size: tuple[int, int], **_: Any) -> Future[al.Image]:
        done: Future[al.Image] = Future()
        rgba = np.zeros((size[1], size[0], 4), np.float32)
        done.set_result(al.Image(rgba, rgba[..., 0], (0.0, 0.0, 0.0), {}, scene=scene))
        return done

    def refine(self, scene: al.Scene, size: tuple[int, int], **_: Any) -> Any:
        yield self.submit(scene, size).result()

    def warm_up(self, *_: Any, **__: Any) -> None: ...

    def close_view(self, view: Any) -> None: ...


def wait_for(condition: Any) -> None:
    until = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.005)
