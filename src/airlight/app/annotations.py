"""``--scale-bar``, ``--color-bar``, ``--grid``, ``--axes``, ``--orientation`` and ``--pointer``, made into values."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..annotations import KINDS, Annotation, Grid, Pointer, from_dict
from ..errors import ValueRangeError
from ..first_picture import refitted_camera
from ..scene import Scene
from .parse import assignments, parse_numbers

POINTER = "--pointer"


def asked_annotations(options: Any) -> tuple[Annotation, ...]:
    """Annotations that options ask for: flags by the names of their kinds, and pointers."""
    flags = [KINDS[kind]() for kind in KINDS if kind != Pointer.kind and getattr(options, kind)]
    return (*flags, *(parse_pointer(text) for text in options.pointer))


def parse_pointer(text: str) -> Annotation:
    """Pointer of ``10,20,30`` or ``10,20,30:shape=arrow,size_voxels=8,label=here``."""
    place, colon, rest = text.partition(":")
    data = assignments(rest, POINTER) if colon else {}
    for name in ("kind", "p_world"):
        if name in data:
            raise ValueRangeError(f"{POINTER}.{name}", "is told already", "leave it out")
    if "label" in data:
        data["label"] = str(data["label"])  # also of a number
    try:
        return from_dict({**data, "kind": Pointer.kind, "p_world": parse_numbers(place, (3,), POINTER)})
    except ValueRangeError as error:
        where = error.where.removeprefix("pointer").removeprefix(POINTER)
        raise ValueRangeError(POINTER + where, error.what, error.remedy) from None


def with_annotations(scene: Scene, asked: Sequence[Annotation]) -> Scene:
    """Return the scene with these beside its own; one of a kind that it has takes that one's place, pointers are added."""
    kinds = {one.kind for one in asked} - {Pointer.kind}
    kept = tuple(one for one in scene.annotations if one.kind not in kinds)
    return dataclasses.replace(scene, annotations=(*kept, *asked))


def with_room(scene: Scene, size: tuple[int, int]) -> Scene:
    """Return a first picture's scene from so far that a grid and its numbers are seen whole."""
    if not any(isinstance(one, Grid) for one in scene.annotations):
        return scene
    corners = [layer.volume.corners_world() for layer in scene.visible_layers]
    corners += [shape.corners_world for shape in scene.meshes]
    return dataclasses.replace(scene, camera=refitted_camera(scene, np.concatenate(corners), size))
