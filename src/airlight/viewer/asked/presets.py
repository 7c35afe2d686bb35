"""Presets that suit the data, and what the scene looks like with each, small."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ...automatic import boundary_function
from ...errors import ValueRangeError
from ...first_picture import automatic_transfer
from ...first_picture.survey import is_ct
from ...rendering.image import Image
from ...scene import Camera, Layer, Scene
from ...transfer import TransferFunction, presets
from ...volume import statistics
from ..asking import answers
from ..encoding import jpeg, pixels_of
from ..layers import channel_in, with_function
from ..session import Session
from .probe import layer_numbered

SIZE_PX = 96
STEP = 2.0
QUALITY = 85
MOST_KEPT = 512
GLOWING = ("inferno", "viridis", "cividis", "turbo", "gray")
MADE = {"automatic": "the object, not the noise round it", "boundaries": "boundaries between materials, each in a colour"}


_Pictures = dict[tuple[Any, ...], tuple[Scene, Future[Image]]]

_SEEKER = ThreadPoolExecutor(1, thread_name_prefix="airlight-boundaries")
_KEPT: WeakKeyDictionary[Session, _Pictures] = WeakKeyDictionary()
"""Pictures of a session, made or in the making, each with the scene that it shows."""


@answers("presets", slow=True)
def listed(session: Session, layer: int = 0, part: int | None = None) -> dict[str, Any]:
    """Names and meanings of the functions that suit a layer's channel."""
    shown = layer_numbered(session, layer)
    is_hounsfield = is_ct(shown.volume, statistics(shown.volume, channel_in(shown, part), shown.time))
    found = dict(MADE)
    found |= {name: known.summary for name, known in presets.PRESETS.items() if is_hounsfield != known.relative}
    found |= {f"glow:{name}": f"the colour map {name}, faint where values are low" for name in GLOWING}
    told: list[dict[str, Any]] = [{"name": name, "summary": summary} for name, summary in found.items()]
    for entry in told:
        if entry["name"] != "boundaries":  # which takes a while, and is not always wanted
            entry["transfer"] = _function(shown, part, entry["name"]).to_dict()
    return {"presets": told}


@answers("presets.function", slow=True)
def function(session: Session, name: str, layer: int = 0, part: int | None = None) -> dict[str, Any]:
    """The function of a preset for a layer's channel."""
    return {"transfer": _function(layer_numbered(session, layer), part, name).to_dict()}


@answers("presets.picture", slow=True)
def picture(session: Session, name: str, layer: int = 0, part: int | None = None) -> tuple[dict[str, Any], list[bytes]]:
    """What the scene looks like with a preset, from the session's camera: JPEG, 96 px to a side.

    Nobody waits for it: without a buffer it is in the making, and is to be asked for again. Kept until something else of the
    scene changes, or the camera does.
    """
    scene, camera = session.document.scene, session.document.camera
    kept = _KEPT.setdefault(session, {})
    key = (layer, part, name, _seen_from(camera))
    before = kept.get(key)
    if name == "boundaries" and not _found(layer_numbered(session, layer), part).done():
        return {"kind": ""}, []
    wanted = with_function(scene, layer, part, _function(layer_numbered(session, layer), part, name))
    if before is None or before[1].cancelled() or before[0] != replace(wanted, camera=before[0].camera):
        if len(kept) >= MOST_KEPT:
            kept.clear()
        view = (session.key, "presets")
        made = session.viewer.renderer.submit(wanted, (SIZE_PX, SIZE_PX), step=STEP, view=view)
        kept[key] = before = (wanted, made)
    if not before[1].done() or before[1].cancelled():
        return {"kind": ""}, []
    return {"kind": "jpeg"}, [jpeg(pixels_of(before[1].result()), QUALITY)]


def _function(shown: Layer, part: int | None, name: str) -> TransferFunction:
    channel, time = channel_in(shown, part), shown.time
    if name == "automatic":
        return automatic_transfer(shown.volume, channel, time)
    if name == "boundaries":
        return _found(shown, part).result()
    if not isinstance(name, str):
        raise ValueRangeError("preset", f"is {name!r:.40}, must be a name")
    if name.startswith("glow:"):
        return presets.glowing(name.removeprefix("glow:"), shown.volume, channel, time)
    return presets.get(name, shown.volume, channel, time)


def _found(shown: Layer, part: int | None) -> Future[TransferFunction]:
    """The boundaries of a channel, looked for once, beside the session's other answers."""
    channel, time = channel_in(shown, part), shown.time
    cache: dict[tuple[int, int], Future[TransferFunction]] = shown.volume.__dict__.setdefault("_boundary_functions", {})
    if (channel, time) not in cache:
        cache[channel, time] = _SEEKER.submit(boundary_function, shown.volume, channel, time)
    return cache[channel, time]


def _seen_from(camera: Camera) -> tuple[float, ...]:
    """Where a camera is and looks, as exactly as a small picture shows it."""
    _, up, forward = camera.basis()
    eye = np.asarray(getattr(camera, "eye", (0, 0, 0)), dtype=np.float64)
    way = np.linalg.norm(eye - np.asarray(getattr(camera, "target", eye), dtype=np.float64)) or 1.0
    size = getattr(camera, "height", getattr(camera, "fov_deg", 0.0))
    return tuple(np.round([*forward, *up, *(eye / way), size], 2).tolist())
