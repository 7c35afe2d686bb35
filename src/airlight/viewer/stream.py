"""The stream of a session: what has changed is drawn, encoded and sent, the newest first; at rest the picture is refined."""

from __future__ import annotations

import io
import threading
import time
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import AirlightError
from ..scene_file.writing import plain_stage

if TYPE_CHECKING:
    from .session import Session

REST_S = 0.25
MOVING_SCALE, MOVING_STEP = 0.5, 2.0


class Stream:
    """Draws a session on a thread of its own."""

    MOST_PX = 4096

    def __init__(self, session: Session) -> None:
        self._session = session
        self._changed = threading.Condition()
        self._dirty = self._closed = False
        self._number = 0
        self._thread = threading.Thread(target=self._run, name="airlight-stream", daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """Something has changed."""
        with self._changed:
            self._dirty = True
            self._changed.notify_all()

    def again(self) -> None:
        """Somebody has come who has no picture."""
        self.wake()

    def acknowledged(self, frame: int) -> None:
        """A client has shown a picture."""

    def close(self) -> None:
        """Stop. Idempotent."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._session.viewer.renderer.close_view(self._session.key)

    def _run(self) -> None:
        final = True
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._dirty or self._closed, None if final else REST_S)
                if self._closed:
                    return
                moving, self._dirty = self._dirty, False
            final = not self._session.has_clients or self._draw(not moving)

    def _draw(self, final: bool) -> bool:
        session = self._session
        document, size_px, start = session.document, session.size_px, time.perf_counter()
        scale = 1.0 if final else MOVING_SCALE
        drawn_px = (max(1, round(size_px[0] * scale)), max(1, round(size_px[1] * scale)))
        options: dict[str, Any] = document.drawing
        options["step"] = document.step if final else max(document.step, MOVING_STEP)
        try:
            image = session.viewer.renderer.submit(document.scene, drawn_px, view=session.key, **options).result()
        except CancelledError:
            return False
        except AirlightError as error:
            from .session import told

            session.send({"type": "error"} | told(error))
            return True
        self._number += 1
        data, kind = _encoded(image.picture()[..., :3], final)
        frame = {"type": "frame", "frame": self._number, "size_px": list(size_px), "drawn_px": list(drawn_px), "kind": kind}
        frame |= {"step": options["step"], "final": final, "camera": plain_stage(document.camera)}
        frame |= {"ms": 1e3 * (time.perf_counter() - start), "refined": final}
        session.send(frame, [data])
        return final


def _encoded(pixels: np.ndarray[Any, Any], lossless: bool) -> tuple[bytes, str]:
    from PIL import Image as Pillow

    held = io.BytesIO()
    kind = "png" if lossless else "jpeg"
    Pillow.fromarray(np.ascontiguousarray(pixels)).save(held, kind, **({"compress_level": 1} if lossless else {"quality": 80}))
    return held.getvalue(), kind
