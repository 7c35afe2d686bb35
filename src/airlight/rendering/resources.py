"""Device resources of a program: grids by the identity of their volume, tables and gradients by their values.

What is cached lives as long as the volume or table it was made of.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..gpu import compute, gradients, textures
from ..gpu.device import Device
from ..scene import Light
from ..shader.layout import class_struct, fill
from ..shader.program import FrameUniforms, LayerUniforms, LightRecord, LuminanceUniforms, Program
from ..stage import Context, GradientGrid, Grid, Resource, Stage, Table
from ..stages.field import Field
from ..volume import domain_index

LIGHT_KINDS = {"head": 0, "directional": 1, "point": 2}


@dataclass(frozen=True, eq=False)
class DrawnLayer:
    """A layer ready to be drawn: its stages, what they may look at, and its uniforms once the grid is on the device."""

    stages: Mapping[str, Stage]
    context: Context
    resources: Mapping[str, Mapping[str, Resource]]

    @property
    def field(self) -> Field:
        """Return the layer's field."""
        field = self.stages["field"]
        assert isinstance(field, Field)
        return field


def kept_for(device: Device, owner: Any, key: tuple[Any, ...], make: Callable[[], Any]) -> Any:
    """Value kept under a key until its owner is gone."""
    full = (*key, id(owner))
    if full not in device.kept:
        device.kept[full] = make()
        kept = weakref.ref(device)

        def forget() -> None:
            alive = kept()
            if alive is not None:
                alive.kept.pop(full, None)

        weakref.finalize(owner, forget).atexit = False
    return device.kept[full]


def grid_texture(device: Device, grid: Grid, progress: textures.Progress) -> textures.VolumeTexture:
    """Texture of a grid; not uploaded again for the same volume."""
    key = ("grid", grid.channel, grid.time, grid.filtered, grid.masked)
    found: textures.VolumeTexture = kept_for(device, grid.volume, key, lambda: textures.upload_grid(device, grid, progress))
    return found


def layer_uniforms(device: Device, layer: DrawnLayer, progress: textures.Progress) -> LayerUniforms:
    """Place of a layer's grid in the world and decoding of its texels."""
    volume = layer.context.volume
    low, high = domain_index(volume.size, layer.field.cells)
    size = tuple(float(n) for n in volume.size)
    scale, offset = 1.0, 0.0
    for resource in layer.resources["field"].values():
        if isinstance(resource, Grid):
            encoding = grid_texture(device, resource, progress).encoding
            scale, offset = encoding.scale, encoding.offset
    return LayerUniforms(
        index_from_world=volume.index_from_world,
        gradient_world_from_index=volume.index_from_world[:3, :3].T,
        size=size,  # type: ignore[arg-type]
        inverse_size=tuple(1.0 / n for n in size),  # type: ignore[arg-type]
        domain_low=tuple(low),
        domain_high=tuple(high),
        value_scale=scale,
        value_offset=offset,
        gradient_scale=gradients.gradient_scale(layer.context),
    )


def uniform_values(
    device: Device, scene_stages: Mapping[str, Stage], layers: tuple[DrawnLayer, ...], progress: textures.Progress
) -> dict[str, Any]:
    """Values of all members of the uniform struct but the frame's, by the names of ``build_program``."""
    values: dict[str, Any] = {"luminance": LuminanceUniforms()}
    for slot, stage in scene_stages.items():
        values[slot] = stage.uniforms(layers[0].context)
    for i, layer in enumerate(layers):
        values[f"layer_{i}"] = layer_uniforms(device, layer, progress)
        for slot, stage in layer.stages.items():
            values[f"{slot}_{i}"] = stage.uniforms(layer.context)
    return values


def pack_uniforms(program: Program, frame: FrameUniforms, values: Mapping[str, Any]) -> bytes:
    """Bytes of the whole uniform struct."""
    record = np.zeros((), dtype=program.uniforms.dtype)
    for member in program.uniforms.members:
        assert member.struct is not None
        fill(record[member.name], member.struct, frame if member.name == "frame" else values[member.name])
    return record.tobytes()


def pack_lights(lights: tuple[Light, ...]) -> bytes:
    """Bytes of the array of lights; one dark light where there is none, since arrays are not empty."""
    struct = class_struct(LightRecord, "LightRecord")
    records = np.zeros(max(1, len(lights)), dtype=struct.dtype)
    for record, light in zip(records, lights, strict=False):
        rgb = tuple(light.intensity * c for c in light.colour)
        fill(record, struct, LightRecord(LIGHT_KINDS[light.kind], rgb, light.vector, light.radius or 0.0))  # type: ignore[arg-type]
    return records.tobytes()


def bound_resources(
    device: Device,
    program: Program,
    layers: tuple[DrawnLayer, ...],
    scene: Mapping[str, Mapping[str, Resource]],
    progress: textures.Progress,
) -> dict[str, Any]:
    """Views and samplers of a program's textures and tables, by the names of its bindings."""
    found: dict[str, Any] = {}
    for binding in program.bindings:
        slot, index, name = binding.owner
        if binding.kind == "sampler":
            found[binding.name] = compute.linear_sampler(device)
        elif binding.kind in ("table", "grid", "loaded_grid", "gradients"):
            resource = (scene if index is None else layers[index].resources)[slot][name]
            found[binding.name] = _view(device, resource, layers[index or 0], progress)
    return found


def _view(device: Device, resource: Resource, layer: DrawnLayer, progress: textures.Progress) -> Any:
    match resource:
        case Grid():
            return grid_texture(device, resource, progress).texture.create_view()
        case Table():
            texture = kept_for(device, resource.texels, ("table",), lambda: textures.upload_table(device, resource.texels))
            return texture.create_view()
        case GradientGrid():
            return _gradient_texture(device, resource, layer, progress).create_view()


def _gradient_texture(device: Device, resource: GradientGrid, layer: DrawnLayer, progress: textures.Progress) -> Any:
    """Texture of gradients, made by the field and the gradient stage themselves at the voxels."""
    context = layer.context
    key = ("gradients", type(resource.method), type(layer.field), context.channel, context.time)
    return kept_for(
        device,
        context.volume,
        key,
        lambda: gradients.compute_gradients(
            device,
            layer.field,
            layer.resources["field"],
            resource.method,
            layer_uniforms(device, layer, progress),
            grid_texture(device, _grid_of(layer), progress),
            context.volume.size,
            progress,
        ),
    )


def _grid_of(layer: DrawnLayer) -> Grid:
    return next(r for r in layer.resources["field"].values() if isinstance(r, Grid))
