"""Annotations of a scene, made into geometry that is drawn with it and marks on the picture."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..annotations.base import Room, Shown, View
from ..annotations.marks import Mark
from ..scene import Camera, Layer, Scene
from ..stages.field_labels import are_alone
from ..transfer import Channels, TransferFunction
from ..transfer.kinds import AnyFunction
from .background import plain_background
from .image import Image


@dataclass(frozen=True)
class Notes:
    """What is written on a picture, and what ``image.stats`` tells of it."""

    marks: tuple[Mark, ...] = ()
    told: dict[str, Any] = field(default_factory=dict)


def annotated(scene: Scene, size_px: tuple[int, int]) -> tuple[Scene, Notes]:
    """Return a resolved scene with the geometry of its annotations among its meshes, and what they write on the picture."""
    if not scene.annotations:
        return scene, Notes()
    view, room = _view(scene, size_px), Room()
    drawn = [(one, one.drawn(view, room)) for one in sorted(scene.annotations, key=lambda one: one.rank)]
    shapes = tuple(shape for _, parts in drawn for shape in parts.shapes)
    marks = tuple(mark for _, parts in drawn for mark in parts.marks)
    told = [{"kind": one.kind} | parts.told for one, parts in drawn]
    return replace(scene, meshes=scene.meshes + shapes, annotations=()), Notes(marks, {"annotations": told})


def noted(image: Image, scene: Scene, notes: Notes) -> Image:
    """Return an image of a scene with what its annotations write on it, and tell."""
    return replace(image, scene=scene, marks=notes.marks, stats=image.stats | notes.told)


def _view(scene: Scene, size_px: tuple[int, int]) -> View:
    layers = scene.visible_layers
    boxes = [layer.volume.corners_world(bool(getattr(layer.look.field, "cells", False))) for layer in layers or scene.layers]
    assert isinstance(scene.camera, Camera)
    return View(
        camera=scene.camera,
        size_px=size_px,
        corners_world=np.concatenate([*boxes, *(shape.corners_world for shape in scene.meshes)]),
        voxel_world=min((min(layer.volume.spacing) for layer in layers), default=1.0),
        unit=next((layer.volume.units for layer in layers if layer.volume.units), ""),
        anatomical=bool(layers) and all(layer.volume.anatomical for layer in layers),
        layers=tuple(_shown(layer) for layer in layers),
        background=plain_background(scene),
    )


def _shown(layer: Layer) -> Shown:
    volume, function = layer.volume, layer.transfer
    unit, is_projection = volume.value_unit, not getattr(layer.look.integrate, "classifies", True)
    coloured_by = getattr(layer.look.integrate, "colour_by", "function")
    if coloured_by != "function":
        return Shown((), unit, is_projection, coloured_by.replace("_", " "))
    if function is None or are_alone(layer.labels, volume):
        return Shown((), unit, is_projection)
    names = volume.channel_names
    functions: tuple[tuple[str, AnyFunction], ...]
    if isinstance(function, Channels):
        titles = [names[volume.channel_index(part.channel)] if names else str(part.channel) for part in function.visible]
        functions = tuple((title, _scaled(one, layer)) for title, one in zip(titles, function.functions, strict=True))
    else:
        title = names[volume.channel_index(layer.channel)] if names else ""
        functions = ((title, _scaled(function, layer) if isinstance(function, TransferFunction) else function),)
    return Shown(functions, unit, is_projection)


def _scaled(function: TransferFunction, layer: Layer) -> TransferFunction:
    return function if layer.density == 1 else function.scaled(layer.density)
