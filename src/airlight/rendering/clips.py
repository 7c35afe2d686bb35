"""Clips on their way to the device: those that cut nothing are left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..clips import CUTS, KINDS, Clip, Solid
from ..scene import Layer, Scene
from ..shader.layout import class_struct, fill
from ..shader.program import ClipRecord
from ..volume import FloatArray, Volume, domain_index

NUMBERS = {kind: number for number, kind in enumerate(KINDS)}
ALL, SOME, NOTHING = "all", "some", "nothing"
BEYOND = 1e30  # the distance [world] of a plane that keeps everything


def cutting_clips(scene: Scene, layers: Sequence[Layer]) -> tuple[tuple[Clip, ...], ...]:
    """Clips that do not keep all of what they cut: those of all layers, and where some cut one alone, those of each."""
    groups = clip_groups(scene, layers)
    shared = tuple(clip for clip in groups[0] if any(kept_of(clip, layer) != ALL for layer in layers))
    own = tuple(
        tuple(clip for clip in group if kept_of(clip, layer) != ALL) for group, layer in zip(groups[1:], layers, strict=True)
    )
    return (shared, *own) if any(own) else (shared,)


def clip_groups(scene: Scene, layers: Sequence[Layer]) -> tuple[tuple[Clip, ...], ...]:
    """Clips with which the lists of all layers begin, and then what is left of each list."""
    lists = [scene.clips_of(layer) for layer in layers]
    same = 0
    for those in zip(*lists, strict=False):
        if any(clip != those[0] for clip in those):
            break
        same += 1
    return (lists[0][:same], *(clips[same:] for clips in lists))


def nothing_left(scene: Scene) -> str:
    """Why clips leave nothing of any visible layer; empty where they may leave some."""
    reasons = [_removed(scene, layer) for layer in scene.visible_layers]
    return reasons[0] if reasons and all(reasons) else ""


def _removed(scene: Scene, layer: Layer) -> str:
    for number, clip in enumerate(scene.clips_of(layer)):
        if kept_of(clip, layer) == NOTHING:
            own = number - len(scene.clips)
            where = f"scene.clips[{number}]" if own < 0 else f"layer.clips[{own}]"
            return f"{where}, a {clip.kind}, leaves nothing of the volume"
    return ""


def kept_of(clip: Clip, layer: Layer) -> str:
    """Whether a clip keeps all of a layer's domain, some of it, or nothing.

    Sure of the first and the last: what passes by a corner may be called some.
    """
    cells = bool(getattr(layer.look.field, "cells", False))
    if isinstance(clip, Solid):
        return _kept_of_solid(clip, layer.volume, cells)
    if clip.cuts != "volume":
        return SOME
    u_world = layer.volume.corners_world(cells) @ clip.unit_from_world[:, :3].T + clip.unit_from_world[:, 3]
    if clip.kind == "plane":
        holds, misses = bool((u_world[:, 0] >= 0).all()), bool((u_world[:, 0] < 0).all())
    else:
        holds = bool((np.abs(u_world) <= 1).all() if clip.kind == "box" else (np.linalg.norm(u_world, axis=1) <= 1).all())
        misses = bool(((u_world > 1).all(axis=0) | (u_world < -1).all(axis=0)).any()) or _beyond(clip, layer.volume, cells)
    if clip.keep == "outside":
        holds, misses = misses, holds
    return ALL if holds else NOTHING if misses else SOME


def _kept_of_solid(clip: Solid, volume: Volume, cells: bool) -> str:
    """Whether a closed mesh meets the box of a volume's domain: told by the box round the mesh."""
    low, high = domain_index(volume.size, cells)
    inwards = volume.index_from_world
    corners = clip.closed.corners_world @ inwards[:3, :3].T + inwards[:3, 3]
    misses = bool(((corners.min(axis=0) > high) | (corners.max(axis=0) < low)).any())
    if not misses or clip.cuts != "volume":
        return SOME
    return NOTHING if clip.keep == "inside" else ALL


def _beyond(clip: Clip, volume: Volume, cells: bool) -> bool:
    """Whether a box or a sphere lies beyond one of the faces of a volume's domain."""
    low, high = domain_index(volume.size, cells)
    unit = clip.unit_from_world
    world_from_unit = np.linalg.inv(unit[:, :3])
    index_from_unit = volume.index_from_world[:3, :3] @ world_from_unit
    middle = volume.index_from_world[:3, 3] - index_from_unit @ unit[:, 3]
    reach = np.abs(index_from_unit).sum(axis=1) if clip.kind == "box" else np.linalg.norm(index_from_unit, axis=1)
    return bool(((middle - reach > high) | (middle + reach < low)).any())


def pack_clips(groups: Sequence[tuple[Clip, ...]], world_from_device: FloatArray, solids: tuple[Solid, ...] = ()) -> bytes:
    """Bytes of the array of clips, group by group, in coordinates that a matrix (4, 4) maps to the world.

    Meshes are there by their number among ``solids``: what they keep is found pixel by pixel. A group without a clip has one
    that keeps everything.
    """
    struct = class_struct(ClipRecord, "ClipRecord")
    firsts = first_clips(groups)
    records = np.zeros(firsts[-1], dtype=struct.dtype)
    for group, first, end in zip(groups, firsts, firsts[1:], strict=False):
        if not group:
            fill(records[first], struct, ClipRecord(x=(1.0, 0.0, 0.0, BEYOND), kind=NUMBERS["plane"], end=end))
        for record, clip in zip(records[first:end], group, strict=False):
            unit = np.eye(3, 4) if isinstance(clip, Solid) else clip.unit_from_world @ world_from_device
            x, y, z = (tuple(row) for row in unit)
            keeps, cuts = clip.keep == "inside", CUTS.index(clip.cuts)
            number = solids.index(clip) if clip in solids else 0
            fill(record, struct, ClipRecord(x, y, z, NUMBERS[clip.kind], keeps, clip.capped, cuts, number, end))
    return records.tobytes()


def first_clips(groups: Sequence[tuple[Clip, ...]]) -> list[int]:
    """Where groups begin in the array of clips, and where it ends."""
    return [sum(max(1, len(group)) for group in groups[:number]) for number in range(len(groups) + 1)]


def clip_statistics(scene: Scene, clips: tuple[Clip, ...], draws_caps: bool, is_nothing: bool) -> dict[str, Any]:
    """What ``image.stats`` says of clips: how many there are, cut something, and are drawn as solid faces.

    And why nothing is seen, where nothing was looked at.
    """
    given = sum(len(group) for group in clip_groups(scene, scene.visible_layers)) if scene.visible_layers else 0
    if not given:
        return {}
    told: dict[str, Any] = {"given": given, "cutting": len(clips), "capped": sum(clip.capped for clip in clips) * draws_caps}
    return {"clips": told} | ({"reason": "nothing is seen of what the clips leave"} if is_nothing and clips else {})
