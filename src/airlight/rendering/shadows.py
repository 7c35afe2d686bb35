"""Shadow volumes: what comes through to cells from each light, made on the device and kept while volume and lights stay."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..errors import LimitError
from ..gpu import compute, gradients, textures
from ..gpu.device import Device
from ..shader.program import (
    FrameUniforms,
    OcclusionUniforms,
    Program,
    ProgramKey,
    ShadowUniforms,
    Switches,
    build_program,
)
from ..stage import OccluderGrid, ShadowGrid
from ..volume import FloatArray, Volume
from .hiding import HidingPass, cell_domain, hiders, hiding_pass
from .occluders import Hider, cell_values, kept_of_layers, occluder_texture, sampled
from .resources import DrawnLayer, pack_uniforms

LOOKS_AT_ONCE = 1 << 22
AROUND = 1  # cells beyond each face of the volume
STATE_BYTES = 16

Counts = tuple[int, int, int]
Dispatches = Callable[[dict[str, Any], FloatArray], Iterator[tuple[ShadowUniforms, Counts]]]


def shadow_texture(
    device: Device,
    resource: ShadowGrid,
    layers: tuple[DrawnLayer, ...],
    number: int,
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> Any:
    """Texture of what comes through all layers to cells of one, from each light.

    Raises
    ------
    LimitError
        When the cells of all lights do not fit into a texture.
    """
    most, size, count = device.limits["max-texture-dimension-3d"], resource.size, len(resource.lights)
    if max(size) > most:
        what = f"needs a texture of {' x '.join(map(str, size))} for {count} lights; {device.info.name} takes {most} a side"
        raise LimitError("look.visibility.shadow_volume", what, "take fewer cells or lights")

    seen = hiders(layers, number, resource.occluders)

    def make() -> Any:
        return _made(device, resource, seen, anchor_world, progress)

    return kept_of_layers(device, "shadows", resource, seen, make)


def _made(
    device: Device, resource: ShadowGrid, seen: Sequence[Hider], anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Go from each cell to each light; or from slice to slice away from it, and from each cell through other layers alone."""
    names: tuple[str, ...] = ("shadows_out",)
    extra = ("occlusion", "shadow")
    if resource.by == "rays":
        along = hiding_pass(device, "shadow_rays", seen, seen[0], names, extra, anchor_world, progress)
        return _filled(device, resource, seen[0], along, _rays, progress)
    swept = _filled(device, resource, seen[0], _sweep_pass(device, seen[0], anchor_world, progress), _sweep, progress)
    if len(seen) == 1:
        return swept
    names = ("shadows_before", *names)
    beside = hiding_pass(device, "shadow_beside", seen[1:], seen[0], names, extra, anchor_world, progress)
    beside.bound.update(sampled(device, {"shadows_before": swept}))
    return _filled(device, resource, seen[0], beside, _rays, progress)


def _sweep_pass(device: Device, own: Hider, anchor_world: FloatArray, progress: textures.Progress) -> HidingPass:
    names = ("occluders", "shadow_slices", "shadows_out")
    program = build_program(
        ProgramKey("passes/shadow_sweep.wgsl", (), (), names, ("occlusion", "shadow"), Switches(), device.traits)
    )
    most = int(np.prod(np.sort(_counts(own.grid))[1:]))
    bound = sampled(device, {"occluders": occluder_texture(device, own.grid, own.layer, anchor_world, progress)})
    bound["shadow_slices"] = compute.storage_buffer(device, "slices of shadows", 2 * most * STATE_BYTES)
    return HidingPass(program, bound, {})


def _filled(
    device: Device, resource: ShadowGrid, own: Hider, going: HidingPass, dispatches: Dispatches, progress: textures.Progress
) -> Any:
    """Texture that a pass fills light by light."""
    grid, volume, cells = own.grid, own.layer.context.volume, _counts(own.grid)
    texture = gradients.written_texture(device, resource.size, "rgba16float")
    bound = going.bound | {"shadows_out": texture.create_view()}
    values = going.values | {"occlusion": OcclusionUniforms(**cell_values(grid, volume))}
    for number, light in enumerate(resource.lights):
        told = light_uniforms(grid, volume, own.layer.field.cells, light) | {"stack_z": number * int(cells[2])}
        for part, counts in dispatches(told, cells):
            packed = pack_uniforms(going.program, FrameUniforms(), values | {"shadow": part})
            _dispatch(device, going.program, bound, packed, counts)
        device.wait()
        progress("shadows", number + 1, len(resource.lights))
    return texture


def _counts(grid: OccluderGrid) -> FloatArray:
    """Cells along x, y and z, with those around."""
    return np.array(grid.cells) + 2 * AROUND


def light_uniforms(
    grid: OccluderGrid, volume: Volume, to_faces: bool, light: tuple[str, tuple[float, float, float]]
) -> dict[str, Any]:
    """Place of a light among the cells, for ``ShadowUniforms``, the domain, and how a sweep goes away from the light.

    Along the axis on which a light is furthest away, in cells: from a slice to the next no way leads past a cell sideways for
    light from far away.
    """
    kind, vector = light
    block, size = np.array(grid.block), np.array(volume.size)
    linear = volume.index_from_world[:3, :3] / block[:, None]
    low, high = cell_domain(grid, volume, to_faces)
    place = linear @ np.array(vector)
    away = place
    if kind != "directional":
        place = place + (volume.index_from_world[:3, 3] + 0.5) / block
        away = np.maximum(place - size / block, 0.0) + np.minimum(place, 0.0)
    else:
        place = place / np.abs(place).max()  # whatever the unit of the world
    axis = int(np.round(np.abs(away) / max(np.abs(away).max(), 1e-30), 6).argmax())  # the first of those that are as far
    return {
        "light": (*place, float(kind != "directional")),
        "low": low,
        "high": high,
        "world_from_cells": volume.world_from_index[:3, :3] * block,
        "axis": axis,
        "towards": 1.0 if away[axis] > 0 else -1.0,
    }


def _sweep(told: dict[str, Any], cells: FloatArray) -> Iterator[tuple[ShadowUniforms, Counts]]:
    """Dispatches of a sweep, slice by slice."""
    axis = told["axis"]
    across = (int(cells[(axis + 1) % 3]), int(cells[(axis + 2) % 3]), 1)
    order = range(int(cells[axis]))
    for number, place in enumerate(reversed(order) if told["towards"] > 0 else order):
        yield ShadowUniforms(**told, slice=place, is_odd=bool(number % 2)), across


def _rays(told: dict[str, Any], cells: FloatArray) -> Iterator[tuple[ShadowUniforms, Counts]]:
    """Dispatches of rays, some slices at once."""
    x, y, z = (int(n) for n in cells)
    rows = max(1, LOOKS_AT_ONCE // (x * y * max(x, y, z)))
    for first in range(0, z, rows):
        yield ShadowUniforms(**told, slice=first), (x, y, min(rows, z - first))


def _dispatch(device: Device, program: Program, bound: dict[str, Any], packed: bytes, counts: Counts) -> None:
    pipeline = compute.pipeline_of(device, program)
    resources = {**bound, "uniforms": compute.write_uniforms(device, "uniforms of shadows", packed)}
    groups = compute.bind_groups(device, pipeline, resources)
    compute.dispatch(device, pipeline, groups, (-(-counts[0] // 16), -(-counts[1] // 4), counts[2]))
