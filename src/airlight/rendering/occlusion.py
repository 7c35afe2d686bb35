"""Openness of places towards all directions, made on the device and kept with the volumes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..errors import LimitError
from ..gpu import gradients, textures
from ..gpu.device import Device
from ..shader.program import FrameUniforms, OcclusionUniforms, SliceUniforms
from ..stage import OpennessGrid
from ..volume import FloatArray
from .hiding import hiders, hiding_pass, steps_through
from .occluders import MOST_TURNS, Hider, cell_values, kept_of_layers
from .resources import DrawnLayer, pack_uniforms

LOOKS_AT_ONCE = 1 << 22


def openness_texture(
    device: Device,
    resource: OpennessGrid,
    layers: tuple[DrawnLayer, ...],
    number: int,
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> Any:
    """Texture of openness by cells of a layer, towards all that hides in any."""
    seen = hiders(layers, number, resource.occluders)
    check_turns(device, resource, seen)

    def make() -> Any:
        return _made(device, resource, seen, anchor_world, progress)

    return kept_of_layers(device, "openness", resource, seen, make)


def check_turns(device: Device, resource: OpennessGrid, seen: Sequence[Hider]) -> None:
    """Refuse what the software device, which ends all loops of a thread after so many turns, would cut short unsaid.

    Raises
    ------
    LimitError
        With the parameter that is too large.
    """
    if device.info.kind != "software":
        return
    looks = looks_from_cell(resource, seen)
    where = "look.visibility.ambient_occlusion"
    if looks > MOST_TURNS:
        raise LimitError(where, f"takes {looks} looks from a cell, at most {MOST_TURNS} here", "take fewer directions or cells")


def length_seen(resource: OpennessGrid) -> float:
    """Length [world] of the ways from a cell, which begin a cell away."""
    return resource.radius_world - resource.occluders.cell_world


def looks_from_cell(resource: OpennessGrid, seen: Sequence[Hider]) -> int:
    """Looks at cells of all layers."""
    return resource.directions * sum(steps_through(one.grid, resource.occluders, length_seen(resource)) for one in seen)


def _made(
    device: Device, resource: OpennessGrid, seen: Sequence[Hider], anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Gather what hides; then look round from each cell."""
    own, names = seen[0], ("slice", "occlusion")
    length = length_seen(resource)
    looking = hiding_pass(device, "openness", seen, own, ("openness_out",), names, anchor_world, progress, length)
    told = OcclusionUniforms(**cell_values(own.grid, own.layer.context.volume), directions=resource.directions)

    def pack(first_z: int) -> bytes:
        values = looking.values | {"occlusion": told, "slice": SliceUniforms(first_z)}
        return pack_uniforms(looking.program, FrameUniforms(), values)

    at_once, size = LOOKS_AT_ONCE // looks_from_cell(resource, seen), own.grid.cells
    return gradients.compute_voxels(
        device, looking.program, "openness_out", "rgba16float", pack, looking.bound, size, progress, at_once=at_once
    )
