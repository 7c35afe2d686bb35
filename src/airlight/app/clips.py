"""``--clip`` and ``--crop``, made into values."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..clips import Clip, Solid
from ..errors import DataError, ValueRangeError
from ..geometry.saving import SOLID_ENTRIES
from ..scene import Layer, Scene
from .parse import assignments

OPTION = "--clip"
MIDDLES = {"plane": "point", "sphere": "center"}
"""Kinds of clips, with the name of the place that is the middle of the volume where it is left out."""
ALL = (0, 1 << 24)

Ranges = tuple[tuple[int, int], ...]


def parse_clips(texts: Sequence[str]) -> list[dict[str, Any]]:
    """Plain data of ``plane:normal=[0,-1,0]``, ``box:low=[0,0,0],high=[9,9,9]``, ``sphere:radius=5`` or ``mesh:file=a.stl``.

    They are checked; meshes are read.
    """
    found = []
    for text in texts:
        kind, colon, rest = text.partition(":")
        data = {**(assignments(rest, OPTION) if colon else {}), "kind": kind.strip()}
        clip = _clip(_placed(data, np.zeros(3)))
        if isinstance(clip, Solid):
            data = {name: value for name, value in data.items() if name not in SOLID_ENTRIES} | {"closed": clip.closed}
        found.append(data)
    return found


def check_cut(scene: Scene, clips: Sequence[Any], crop: Ranges | None) -> None:
    """Refuse clips where there is nothing to cut.

    Raises
    ------
    ValueRangeError
        For scenes of meshes alone.
    """
    if not scene.layers and (clips or crop):
        raise ValueRangeError(OPTION if clips else "--crop", "cuts volumes, and the scene has none", "leave it out")


def with_clips(scene: Scene, given: Sequence[Mapping[str, Any]]) -> Scene:
    """Return the scene with these clips in the place of its own."""
    if not given:
        return scene
    corners = np.concatenate([layer.volume.corners_world() for layer in scene.visible_layers or scene.layers])
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    return dataclasses.replace(scene, clips=tuple(_clip(_placed(data, middle)) for data in given))


def _placed(data: Mapping[str, Any], middle: Any) -> dict[str, Any]:
    name = MIDDLES.get(data["kind"])
    return {**({} if name is None else {name: [float(c) for c in middle]}), **data}


def _clip(data: Mapping[str, Any]) -> Clip:
    try:
        return Clip.from_dict(data)
    except (ValueRangeError, DataError) as error:
        raise type(error)(OPTION + error.where.removeprefix("clip"), error.what, error.remedy) from None


def parse_crop(text: str) -> Ranges:
    """First voxel and the one behind the last along x, y and z, of ``10:90,:,20:``."""
    ranges = []
    for word in text.split(","):
        match = re.fullmatch(r"\s*(\d{0,7})\s*:\s*(\d{0,7})\s*", word)
        first, last = (int(match[1] or ALL[0]), int(match[2] or ALL[1])) if match else (0, 0)
        ranges.append((first, last))
        if first >= last:
            raise ValueRangeError("--crop", f"has {word!r}, must be FIRST:LAST, rising", "e.g. --crop 10:90,:,20:")
    if len(ranges) != 3:
        raise ValueRangeError("--crop", f"is {text!r}, must have ranges along x, y and z", "e.g. --crop 10:90,:,20:")
    return tuple(ranges)


def cropped(layer: Layer, ranges: Ranges | None) -> Layer:
    """Return the layer with nothing drawn beyond the cells of these voxels."""
    if ranges is None:
        return layer
    low, high = (tuple(end - 0.5 for end in ends) for ends in zip(*ranges, strict=True))
    box = Clip.box(low=low, high=high, world_from_box=layer.volume.world_from_index)
    return dataclasses.replace(layer, clips=(*layer.clips, box))
