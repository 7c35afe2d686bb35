"""Device resources of a program: grids by the identity of their volume, tables and gradients by their values.

What is cached lives as long as the volume or table it was made of.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import StageError
from ..gpu import compute, gradients, slab_tables, textures
from ..gpu.device import Device
from ..gpu.labels import upload_labels
from ..scene import Light
from ..shader.layout import class_struct, fill
from ..shader.program import (
    ClassifyUniforms,
    FrameUniforms,
    LayerUniforms,
    LightRecord,
    LuminanceUniforms,
    Program,
    ProgramKey,
    SliceUniforms,
    Switches,
    build_program,
    stage_key,
)
from ..stage import ClassifiedGrid, Context, GradientGrid, Grid, LabelCells, Resource, SlabTable, Stage, Table
from ..stages.field import Field, needed_groups
from ..stages.field_channels import lines_of
from ..volume import FloatArray, domain_index

KEPT_TABLES = 4
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
        if not isinstance(field, Field):
            raise StageError(f"look.field {field.name!r}", "is no Field", "derive its class from airlight.field.Field")
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
    key = ("grid", grid.channels, grid.time, grid.filtered, grid.masked)
    found: textures.VolumeTexture = kept_for(device, grid.volume, key, lambda: textures.upload_grid(device, grid, progress))
    return found


def label_texture(device: Device, cells: LabelCells, progress: textures.Progress) -> textures.VolumeTexture:
    """Texture of labels; not uploaded again for the same volume, whatever their styles."""
    numbers = cells.numbers
    found: textures.VolumeTexture = kept_for(device, numbers, ("labels",), lambda: upload_labels(device, numbers, progress))
    return found


def layer_uniforms(device: Device, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress) -> LayerUniforms:
    """Place of a layer's grid in the device's world, whose origin is the anchor, and decoding of its texels."""
    volume = layer.context.volume
    low, high = domain_index(volume.size, layer.field.cells)
    size = tuple(float(n) for n in volume.size)
    scale, offset = 1.0, 0.0
    for resource in layer.resources["field"].values():
        if isinstance(resource, Grid):
            encoding = grid_texture(device, resource, progress).encoding
            scale, offset = encoding.scale, encoding.offset
    index_from_world = volume.index_from_world.copy()
    index_from_world[:3, 3] += index_from_world[:3, :3] @ anchor_world
    return LayerUniforms(
        index_from_world=index_from_world,
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
    device: Device,
    scene_stages: Mapping[str, Stage],
    layers: tuple[DrawnLayer, ...],
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> dict[str, Any]:
    """Values of all members of the uniform struct but the frame's, by the names of ``build_program``."""
    values: dict[str, Any] = {"luminance": LuminanceUniforms()}
    for slot, stage in scene_stages.items():
        values[slot] = stage.uniforms(layers[0].context)
    for i, layer in enumerate(layers):
        values[f"layer_{i}"] = layer_uniforms(device, layer, anchor_world, progress)
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
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> dict[str, Any]:
    """Views and samplers of a program's textures and tables, by the names of its bindings."""
    found: dict[str, Any] = {}
    for binding in program.bindings:
        slot, index, name = binding.owner
        if binding.kind == "sampler":
            found[binding.name] = compute.linear_sampler(device)
        elif binding.kind in ("table", "layers", "grid", "loaded_grid", "gradients", "labels"):
            resource = (scene if index is None else layers[index].resources)[slot][name]
            found[binding.name] = _view(device, resource, layers[index or 0], anchor_world, progress)
    return found


def _view(device: Device, resource: Resource, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress) -> Any:
    match resource:
        case Grid():
            return grid_texture(device, resource, progress).texture.create_view()
        case Table():
            texture = kept_for(device, resource.texels, ("table",), lambda: textures.upload_table(device, resource.texels))
            return texture.create_view()
        case SlabTable():
            return _slab_table(device, resource).create_view(dimension="2d-array")
        case LabelCells():
            return label_texture(device, resource, progress).texture.create_view()
        case GradientGrid():
            return _gradient_texture(device, resource, layer, anchor_world, progress).create_view()
        case ClassifiedGrid():
            return _classified_texture(device, resource, layer, anchor_world, progress).create_view()


def _slab_table(device: Device, table: SlabTable) -> Any:
    """Texture of a table; the last few are kept."""
    kept: dict[SlabTable, Any] = device.kept.setdefault(("slab tables",), {})
    if table in kept:
        kept[table] = kept.pop(table)  # the one that was asked for last goes last
    else:
        while len(kept) >= KEPT_TABLES:
            del kept[next(iter(kept))]
        kept[table] = slab_tables.make_slab_table(device, table)
    return kept[table]


def _gradient_texture(
    device: Device, resource: GradientGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of gradients, made at the voxels by the layer's own field and a gradient stage.

    Gradients of a mixture follow its functions: those of the last ones are kept.
    """
    context = layer.context
    used: dict[str, Stage] = {"field": layer.stages["field"], "gradient": resource.method}
    alone = DrawnLayer(used, context, {slot: stage.resources(context) for slot, stage in used.items()})
    place = ("gradients", *used.values(), context.channels, context.time)
    kept: dict[Any, Any] = kept_for(device, context.volume, place, dict)
    key = (needed_groups(context), *lines_of(context).items())
    if key not in kept:
        kept.clear()
        kept[key] = _voxel_texture(device, alone, "gradient_grid", "gradients_out", "rgba16float", {}, anchor_world, progress)
    return kept[key]


def _classified_texture(
    device: Device, resource: ClassifiedGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of media, made at the voxels; that of a volume's last function is kept."""
    context, grid = layer.context, resource.grid
    used: dict[str, Stage] = {"field": resource.field, "transfer": resource.transfer}
    alone = DrawnLayer(used, context, {slot: stage.resources(context) for slot, stage in used.items()})
    kept: dict[Any, Any] = kept_for(device, grid.volume, ("classified", grid.channels, grid.time), dict)
    key = (resource.function, resource.weighted, grid.filtered)
    if key not in kept:
        kept.clear()
        values = {"classify": ClassifyUniforms(resource.weighted and not resource.function.associated)}
        kept[key] = _voxel_texture(
            device, alone, "classified_grid", "classified_out", "rgba32float", values, anchor_world, progress
        )
    return kept[key]


def _voxel_texture(
    device: Device,
    alone: DrawnLayer,
    root: str,
    output: str,
    texel_format: str,
    extra: dict[str, Any],
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> Any:
    """Texture that a pass fills, voxel by voxel, by the stages of a layer that has no others."""
    key = ProgramKey(
        f"passes/{root}.wgsl",
        (),
        (tuple((s, stage_key(stage, alone.resources[s], stage.variant(alone.context))) for s, stage in alone.stages.items()),),
        (output,),
        ("slice", *extra),
        Switches(has_empty=alone.field.masked),
        device.traits,
        alone.field.groups(alone.context),
    )
    program = build_program(key)
    values = extra | uniform_values(device, {}, (alone,), anchor_world, progress)
    bound = bound_resources(device, program, (alone,), {}, anchor_world, progress)

    def pack(first_z: int) -> bytes:
        return pack_uniforms(program, FrameUniforms(), values | {"slice": SliceUniforms(first_z)})

    return gradients.compute_voxels(device, program, output, texel_format, pack, bound, alone.context.volume.size, progress)
