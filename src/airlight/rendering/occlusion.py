"""Openness of places towards all directions, made on the device and kept with the volume; and what hides, by cells."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import LimitError
from ..gpu import compute, gradients, textures
from ..gpu.device import Device
from ..shader.program import FrameUniforms, OcclusionUniforms, ProgramKey, SliceUniforms, Switches, build_program, stage_key
from ..stage import LabelCells, OccluderGrid, OpennessGrid, Table
from ..volume import FloatArray, Volume
from .clips import pack_clips
from .resources import DrawnLayer, bound_resources, pack_uniforms, uniform_values

CLASSIFYING = ("field", "gradient", "transfer", "region")
VOXELS_AT_ONCE = 1 << 19
LOOKS_AT_ONCE = 1 << 22
MOST_TURNS = 60_000
TURNS_PER_VOXEL = 4


def openness_texture(
    device: Device, resource: OpennessGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of openness by cells."""
    check_turns(device, resource, layer.context.volume)

    def make() -> Any:
        return _made(device, resource, layer, anchor_world, progress)

    return kept_of_layer(device, "openness", resource, layer, make)


def kept_of_layer(device: Device, name: str, resource: Any, layer: DrawnLayer, make: Any) -> Any:
    """Texture that is made of what a layer's classifying stages make of its volume and labels, kept by the values of them."""
    context = layer.context
    stages = tuple(layer.stages[slot] for slot in CLASSIFYING if slot in layer.stages)
    region = layer.resources["region"].values()
    labels = [r.numbers for r in region if isinstance(r, LabelCells)]
    styles = [r.texels.tobytes() for r in region if isinstance(r, Table)]
    made_of = (resource, context.transfer, context.channels, context.time, *styles, *stages)
    return device.kept.get((name, *made_of), make, context.volume, *labels)


def check_turns(device: Device, resource: OpennessGrid, volume: Volume) -> None:
    """Refuse what the software device, which ends all loops of a thread after so many turns, would cut short unsaid.

    Raises
    ------
    LimitError
        With the parameter that is too large.
    """
    if device.info.kind != "software":
        return
    looks = resource.directions * openness_uniforms(resource, volume).steps
    where = "look.visibility.ambient_occlusion"
    if looks > MOST_TURNS:
        raise LimitError(where, f"takes {looks} looks from a cell, at most {MOST_TURNS} here", "take fewer directions or cells")


def cell_values(grid: OccluderGrid, volume: Volume) -> dict[str, Any]:
    """Geometry of cells, for ``OcclusionUniforms``."""
    block = np.array(grid.block)
    x, y, z = (float(n) for n in np.array(volume.size) / block)
    return {
        "block": grid.block,
        "cells": grid.cells,
        "last": (x, y, z),
        "spacing": volume.spacing,
        "cells_from_world": volume.index_from_world[:3, :3] / block[:, None],
        "cell_world": grid.cell_world,
        "tint": grid.tint,
    }


def openness_uniforms(resource: OpennessGrid, volume: Volume) -> OcclusionUniforms:
    """Geometry of the cells, and the steps of rays between them."""
    cell_world = resource.occluders.cell_world
    way = resource.radius_world - cell_world
    steps = max(1, math.ceil(way / cell_world))
    return OcclusionUniforms(
        **cell_values(resource.occluders, volume), step_world=way / steps, steps=steps, directions=resource.directions
    )


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

    return kept_of_layer(device, "occluders", grid, layer, make)


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


def _made(
    device: Device, resource: OpennessGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Gather what hides; then look round from each cell."""
    hides = occluder_texture(device, resource.occluders, layer, anchor_world, progress)
    told = openness_uniforms(resource, layer.context.volume)
    names, extra = ("occluders", "openness_out"), ("slice", "occlusion")
    program = build_program(ProgramKey("passes/openness.wgsl", (), (), names, extra, Switches(), device.traits))

    def pack(first_z: int) -> bytes:
        return pack_uniforms(program, FrameUniforms(), {"occlusion": told, "slice": SliceUniforms(first_z)})

    at_once = LOOKS_AT_ONCE // (told.directions * told.steps)
    size = resource.occluders.cells
    bound = sampled(device, {"occluders": hides})
    return gradients.compute_voxels(
        device, program, "openness_out", "rgba16float", pack, bound, size, progress, at_once=at_once
    )


def sampled(device: Device, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Views of textures by the names of bindings, with their samplers."""
    views = {name: texture.create_view() for name, texture in inputs.items()}
    return views | {f"{name}_sampler": compute.linear_sampler(device) for name in inputs}
