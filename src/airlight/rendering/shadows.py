"""Shadow volumes: what comes through to cells from each light, made on the device and kept while volume and lights stay."""

from __future__ import annotations

from collections.abc import Iterator
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
from ..volume import FloatArray, Volume, domain_index
from .occlusion import LOOKS_AT_ONCE, cell_values, kept_of_layer, occluder_texture, sampled
from .resources import DrawnLayer, pack_uniforms

AROUND = 1  # cells beyond each face of the volume
STATE_BYTES = 16

Counts = tuple[int, int, int]


def shadow_texture(
    device: Device, resource: ShadowGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of what comes through to cells from each light.

    Raises
    ------
    LimitError
        When the cells of all lights do not fit into a texture.
    """
    most, size, count = device.limits["max-texture-dimension-3d"], resource.size, len(resource.lights)
    if max(size) > most:
        what = f"needs a texture of {' x '.join(map(str, size))} for {count} lights; {device.info.name} takes {most} a side"
        raise LimitError("look.visibility.shadow_volume", what, "take fewer cells or lights")

    def make() -> Any:
        return _made(device, resource, layer, anchor_world, progress)

    return kept_of_layer(device, "shadows", resource, layer, make)


def _made(
    device: Device, resource: ShadowGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Gather what hides; then go from slice to slice away from each light, or from each cell to it."""
    grid, volume = resource.occluders, layer.context.volume
    hides = occluder_texture(device, grid, layer, anchor_world, progress)
    sweeps = resource.by == "sweep"
    names = ("occluders", *(["shadow_slices"] if sweeps else []), "shadows_out")
    root = f"passes/shadow_{resource.by}.wgsl"
    program = build_program(ProgramKey(root, (), (), names, ("occlusion", "shadow"), Switches(), device.traits))
    texture = gradients.written_texture(device, resource.size, "rgba16float")
    cells = np.array(grid.cells) + 2 * AROUND
    bound = sampled(device, {"occluders": hides}) | {"shadows_out": texture.create_view()}
    if sweeps:
        most = int(np.prod(np.sort(cells)[1:]))
        bound["shadow_slices"] = compute.storage_buffer(device, "slices of shadows", 2 * most * STATE_BYTES)
    values = {"occlusion": OcclusionUniforms(**cell_values(grid, volume))}
    for number, light in enumerate(resource.lights):
        told = light_uniforms(grid, volume, layer.field.cells, light) | {"stack_z": number * int(cells[2])}
        for part, counts in (_sweep if sweeps else _rays)(told, cells):
            _dispatch(device, program, bound, pack_uniforms(program, FrameUniforms(), values | {"shadow": part}), counts)
        device.wait()
        progress("shadows", number + 1, len(resource.lights))
    return texture


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
    low, high = ((edge + 0.5) / block for edge in domain_index(volume.size, to_faces))
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
        "low": tuple(low),
        "high": tuple(high),
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
