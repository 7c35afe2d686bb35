"""Openness of places towards all directions, made on the device and kept with the volume."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import LimitError
from ..gpu import compute, gradients, textures
from ..gpu.device import Device
from ..shader.program import FrameUniforms, OcclusionUniforms, ProgramKey, SliceUniforms, Switches, build_program, stage_key
from ..stage import LabelCells, OpennessGrid, Table
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
    context = layer.context
    stages = tuple(layer.stages[slot] for slot in CLASSIFYING if slot in layer.stages)
    region = layer.resources["region"].values()
    labels = [r.numbers for r in region if isinstance(r, LabelCells)]
    styles = [r.texels.tobytes() for r in region if isinstance(r, Table)]
    made_of = (resource, context.transfer, context.channels, context.time, *styles, *stages)
    return device.kept.get(
        ("openness", *made_of), lambda: _made(device, resource, layer, anchor_world, progress), context.volume, *labels
    )


def check_turns(device: Device, resource: OpennessGrid, volume: Volume) -> None:
    """Refuse what the software device, which ends all loops of a thread after so many turns, would cut short unsaid.

    Raises
    ------
    LimitError
        With the parameter that is too large.
    """
    if device.info.kind != "software":
        return
    looks = resource.directions * occlusion_uniforms(resource, volume).steps
    voxels = TURNS_PER_VOXEL * math.prod(resource.block)
    where = "look.visibility.ambient_occlusion"
    if looks > MOST_TURNS:
        raise LimitError(where, f"takes {looks} looks from a cell, at most {MOST_TURNS} here", "take fewer directions or cells")
    if voxels > MOST_TURNS:
        raise LimitError(where, f"has cells of {math.prod(resource.block)} voxels, too many here", "take more cells")


def occlusion_uniforms(resource: OpennessGrid, volume: Volume) -> OcclusionUniforms:
    """Geometry of the cells, and the steps of rays between them."""
    block, size = np.array(resource.block), np.array(volume.size)
    way = resource.radius_world - resource.cell_world
    steps = max(1, math.ceil(way / resource.cell_world))
    x, y, z = (float(n) for n in size / block)
    return OcclusionUniforms(
        block=resource.block,
        cells=resource.cells,
        last=(x, y, z),
        spacing=volume.spacing,
        cells_from_world=volume.index_from_world[:3, :3] / block[:, None],
        cell_world=resource.cell_world,
        step_world=way / steps,
        steps=steps,
        directions=resource.directions,
    )


def _made(
    device: Device, resource: OpennessGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Gather what hides, by the stages that classify the layer; then look round from each cell."""
    used = {slot: layer.stages[slot] for slot in CLASSIFYING if slot in layer.stages}
    context = layer.context
    alone = DrawnLayer(used, context, {slot: stage.resources(context) for slot, stage in used.items()})
    told = occlusion_uniforms(resource, context.volume)
    keys = tuple((s, stage_key(stage, alone.resources[s], stage.variant(context))) for s, stage in used.items())
    switches = Switches(has_empty=alone.field.masked)

    def run(root: str, layers: Any, inputs: dict[str, Any], values: dict[str, Any], bound: Any, at_once: int) -> Any:
        output = f"{root}_out"
        clips = resource.clips if layers else ()
        key = ProgramKey(
            f"passes/{root}.wgsl",
            (),
            layers,
            (*inputs, output, *(["clips"] if clips else [])),
            ("slice", "occlusion"),
            switches,
            device.traits,
            alone.field.groups(context) if layers else 0,
        )
        program = build_program(key)

        def pack(first_z: int) -> bytes:
            frame = FrameUniforms()
            return pack_uniforms(program, frame, values | {"occlusion": told, "slice": SliceUniforms(first_z)})

        resources = {**bound(program), **inputs, **{f"{name}_sampler": compute.linear_sampler(device) for name in inputs}}
        if clips:
            packed = pack_clips(clips, context.volume.world_from_index)
            resources["clips"] = compute.write_storage(device, "clips of occluders", packed)
        return gradients.compute_voxels(
            device, program, output, "rgba16float", pack, resources, resource.cells, progress, at_once=at_once
        )

    values = uniform_values(device, {}, (alone,), anchor_world, progress)
    hides = run(
        "occluders",
        (keys,),
        {},
        values,
        lambda program: bound_resources(device, program, (alone,), {}, anchor_world, progress),
        VOXELS_AT_ONCE // math.prod(resource.block),
    )
    looks = told.directions * told.steps
    return run("openness", (), {"occluders": hides.create_view()}, {}, lambda program: {}, LOOKS_AT_ONCE // looks)
