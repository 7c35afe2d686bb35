"""What a layer of a scene holds at points of the world, in float64: the reference's field, on the voxels round them alone."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import DataError, ValueRangeError
from .reference import prepare
from .reference.field import field_scalar, field_value
from .reference.gradient import field_gradient
from .reference.setup import Sample, Setup
from .scene import Layer, Scene
from .stage import Context, make_stage
from .stages.field_labels import are_alone
from .transfer.given import whole
from .volume import FloatArray, Volume

REACH_VOXELS = 24
"""Voxels round a point that its field asks for: more than that adds less than 1e-12, also by prefiltered splines."""
PIECE_VOXELS = 32


def layer_of(scene: Scene, number: int) -> Layer:
    """One of the visible layers of a scene, by its number from 0.

    Raises
    ------
    ValueRangeError
        When there is none of this number.
    DataError
        When no layer is visible at all.
    """
    visible = scene.visible_layers
    if not visible:
        remedy = "airlight.pick(image, scene, pixel) tells the point alone, of meshes too"
        raise DataError("scene", "shows no volume, whose values could be told", remedy)
    number = whole(number, "layer", 0)
    if number >= len(visible):
        raise ValueRangeError("layer", f"is {number}, and {len(visible)} layers are visible")
    return visible[number]


def setup_of(scene: Scene, layer: Layer, size_px: tuple[int, int]) -> Setup:
    """What the reference sees of a layer; gradients are those of the method, where they are kept in a texture for drawing."""
    setup = prepare(dataclasses.replace(scene, layers=(layer,)))
    stages: dict[str, Any] = layer.stages(keeps_gradient=True)
    stages["gradient"] = make_stage("gradient", getattr(stages["gradient"], "method", stages["gradient"]))
    if hasattr(stages["modulation"], "full_at"):
        spacing, camera = setup.spacing_world, scene.camera
        context = Context(layer.volume, layer.function, layer.channels, layer.time, spacing, size_px, layer.labels, camera)
        told = stages["modulation"].uniforms(context).full_at
        stages["modulation"] = dataclasses.replace(stages["modulation"], full_at=told)
    return dataclasses.replace(setup, stages=stages, camera=scene.camera, size_px=size_px)


def pieces(setup: Setup, p_world: FloatArray) -> Iterator[tuple[slice, Setup]]:
    """Runs of points (n, 3) along a line, each with the setup of the voxels round it; runs share the points where they meet."""
    p_index = setup.index_of(p_world)
    longest = np.abs(np.diff(p_index, axis=0)).max(initial=1e-9)
    count = max(1, int(PIECE_VOXELS / longest))
    for first in range(0, max(1, len(p_world) - 1), count):
        run = slice(first, first + count + 1)
        yield run, _cut(setup, p_index[run])


def _cut(setup: Setup, p_index: FloatArray) -> Setup:
    """The setup with the voxels alone that points ask for; all of them where a field reaches anywhere."""
    layer, volume = setup.layer, setup.layer.volume
    field = setup.stages["field"]
    if not np.isfinite(getattr(field, "support_voxels", np.inf)) or are_alone(layer.labels, volume):
        return setup
    low = np.clip(np.floor(p_index.min(axis=0)) - REACH_VOXELS, 0, np.array(volume.size) - 1).astype(int)
    high = np.clip(np.ceil(p_index.max(axis=0)) + REACH_VOXELS + 1, low + 1, volume.size).astype(int)
    x, y, z = (slice(a, b) for a, b in zip(low, high, strict=True))
    matrix = volume.world_from_index.copy()
    matrix[:3, 3] += matrix[:3, :3] @ low
    names, marked = volume.channel_names, volume.no_data
    part = Volume(volume.array[..., z, y, x], world_from_index=matrix, channel_names=names, no_data=marked)
    return dataclasses.replace(setup, layer=dataclasses.replace(layer, volume=part), once={})


def sample_at(setup: Setup, p_world: FloatArray, t_world: FloatArray) -> Sample:
    """Samples of the layer's field at points (n, 3)."""
    p_index = setup.index_of(p_world)
    return Sample(*field_value(setup, p_index), p_index, p_world, t_world)


def values_at(setup: Setup, p_world: FloatArray) -> FloatArray:
    """Values in data units at points (n, 3): (n,), or (n, c) of several channels; NaN where they are empty.

    Of a field that holds classified voxels those of the samples; of labels without an image the share that they take.
    """
    p_index = setup.index_of(p_world)
    value, empty = field_value(setup, p_index) if len(setup.channels) > 1 else field_scalar(setup, p_index)
    return np.where(empty.reshape(-1, *[1] * (value.ndim - 1)), np.nan, value)


def gradients_at(setup: Setup, p_world: FloatArray) -> FloatArray:
    """Gradients (n, 3) of the field in data units per world unit."""
    return np.asarray(field_gradient(setup, setup.index_of(p_world)))


def labels_at(layer: Layer, p_world: FloatArray) -> npt.NDArray[np.int64] | None:
    """Labels (n,) of the voxels that points (n, 3) lie in, the background outside; None without labels."""
    if layer.labels is None:
        return None
    volume = layer.labels.volume
    grid, inwards = volume.grid(0, layer.labels.time_of(layer.time)), volume.index_from_world
    voxel = np.floor(p_world @ inwards[:3, :3].T + inwards[:3, 3] + 0.5).astype(np.int64)
    inside = np.asarray(((voxel >= 0) & (voxel < volume.size)).all(axis=1))
    x, y, z = np.where(inside[:, None], voxel, 0).T
    return np.where(inside, grid[z, y, x].astype(np.int64), layer.labels.background)
