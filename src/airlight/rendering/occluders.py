"""What hides, by cells: optical depth, gathered on the device by the stages that classify a layer, and kept with its volume."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import LimitError
from ..gpu import compute, gradients, textures
from ..gpu.device import Device
from ..shader.program import FrameUniforms, OcclusionUniforms, ProgramKey, SliceUniforms, Switches, build_program, stage_key
from ..stage import LabelCells, OccluderGrid, Table
from ..volume import FloatArray, Volume
from .clips import pack_clips
from .resources import DrawnLayer, bound_resources, pack_uniforms, uniform_values

CLASSIFYING = ("field", "gradient", "transfer", "region")
VOXELS_AT_ONCE = 1 << 19
MOST_TURNS = 60_000
TURNS_PER_VOXEL = 4


@dataclass(frozen=True, eq=False)
class Hider:
    """A layer that hides light, and its cells."""

    layer: DrawnLayer
    grid: OccluderGrid


def occluder_texture(
    device: Device, grid: OccluderGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of optical depth by cells: gathered by the stages that classify the layer.

    Raises
    ------
    LimitError
        When the software device would not look through all voxels of a cell.
    """
    voxels = TURNS_PER_VOXEL * math.prod(grid.block)
    if device.info.kind == "software" and voxels > MOST_TURNS:
        what = f"has cells of {math.prod(grid.block)} voxels, too many here"
        raise LimitError("look.visibility", what, "take more cells")

    def make() -> Any:
        return _gathered(device, grid, layer, anchor_world, progress)

    return kept_of_layers(device, "occluders", None, (Hider(layer, grid),), make)


def _gathered(
    device: Device, grid: OccluderGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    context = layer.context
    used = {slot: layer.stages[slot] for slot in CLASSIFYING if slot in layer.stages}
    alone = DrawnLayer(used, context, {slot: stage.resources(context) for slot, stage in used.items()})
    keys = tuple((s, stage_key(stage, alone.resources[s], stage.variant(context))) for s, stage in used.items())
    key = ProgramKey(
        "passes/occluders.wgsl",
        (),
        (keys,),
        ("occluders_out", *(["clips"] if grid.clips else [])),
        ("slice", "occlusion"),
        Switches(has_empty=alone.field.masked),
        device.traits,
        alone.field.groups(context),
    )
    program = build_program(key)
    bound = bound_resources(device, program, (alone,), {}, anchor_world, progress)
    if grid.clips:
        packed = pack_clips((grid.clips,), context.volume.world_from_index)
        bound["clips"] = compute.write_storage(device, "clips of occluders", packed)
    values = uniform_values(device, {}, (alone,), anchor_world, progress)
    values["occlusion"] = OcclusionUniforms(**cell_values(grid, context.volume))

    def pack(first_z: int) -> bytes:
        return pack_uniforms(program, FrameUniforms(), values | {"slice": SliceUniforms(first_z)})

    at_once = VOXELS_AT_ONCE // math.prod(grid.block)
    return gradients.compute_voxels(
        device, program, "occluders_out", "rgba16float", pack, bound, grid.cells, progress, at_once=at_once
    )


def cell_values(grid: OccluderGrid, volume: Volume) -> dict[str, Any]:
    """Geometry of cells, for ``OcclusionUniforms``."""
    block = np.array(grid.block)
    return {
        "block": grid.block,
        "cells": grid.cells,
        "spacing": volume.spacing,
        "cells_from_world": volume.index_from_world[:3, :3] / block[:, None],
        "cell_world": grid.cell_world,
        "tint": grid.tint,
    }


def kept_of_layers(device: Device, name: str, resource: Any, seen: Sequence[Hider], make: Any) -> Any:
    """Texture that is made of what classifying stages make of volumes and labels, kept by the values of them."""
    made_of = tuple((one.grid, *_classified_by(one.layer)) for one in seen)
    owners = [one.layer.context.volume for one in seen] + [numbers for one in seen for numbers in _labels_of(one.layer)]
    return device.kept.get((name, resource, made_of), make, *owners)


def _classified_by(layer: DrawnLayer) -> tuple[Any, ...]:
    context = layer.context
    stages = tuple(layer.stages[slot] for slot in CLASSIFYING if slot in layer.stages)
    styles = [r.texels.tobytes() for r in layer.resources["region"].values() if isinstance(r, Table)]
    return context.transfer, context.channels, context.time, *styles, *stages


def _labels_of(layer: DrawnLayer) -> list[Any]:
    return [r.numbers for r in layer.resources["region"].values() if isinstance(r, LabelCells)]


def sampled(device: Device, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Views of textures by the names of bindings, with their samplers."""
    views = {name: texture.create_view() for name, texture in inputs.items()}
    return views | {f"{name}_sampler": compute.linear_sampler(device) for name in inputs}
