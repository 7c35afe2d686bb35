"""Device resources of a program: grids by the identity of their volume, tables and gradients by their values.

What is kept lives as long as the volume or table it was made of, unless others need the room; see ``gpu.cache``.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import LimitError, StageError
from ..gpu import blocks, compute, gradients, slab_tables, stacks, textures
from ..gpu.device import Device
from ..gpu.labels import upload_labels
from ..gpu.ranges import block_count
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
from ..stage import (
    BlockBounds,
    BlockLeaps,
    ClassifiedGrid,
    Context,
    DirectionGrid,
    GradientGrid,
    Grid,
    LabelCells,
    LitDirections,
    OpennessGrid,
    Resource,
    ShadowGrid,
    SlabTable,
    Stack,
    Stage,
    Table,
)
from ..stages.field import Field, needed_groups
from ..stages.field_channels import by_group, lines_of
from ..volume import FloatArray, domain_index

MOST_SLAB_TABLES = 12
TEXTURES = ("table", "layers", "grid", "loaded_grid", "stack", "loaded_stack", "gradients", "labels", "openness")
"""Kinds of bindings that resources of stages fill."""
FULL = 0.95  # of the blocks hold something
LIGHT_KINDS = {"head": 0, "directional": 1, "point": 2, "spot": 2}


@dataclass(frozen=True, eq=False)
class DrawnLayer:
    """A layer ready to be drawn: its stages, what they may look at, and its uniforms once the grid is on the device.

    ``is_full`` where something is to be seen almost everywhere; ``is_even`` where in many blocks one medium is.
    """

    stages: Mapping[str, Stage]
    context: Context
    resources: Mapping[str, Mapping[str, Resource]]
    is_full: bool = False
    is_even: bool = False

    @property
    def field(self) -> Field:
        """Return the layer's field."""
        field = self.stages["field"]
        if not isinstance(field, Field):
            raise StageError(f"look.field {field.name!r}", "is no Field", "derive its class from airlight.field.Field")
        return field


def grid_texture(device: Device, grid: Grid, progress: textures.Progress) -> textures.VolumeTexture:
    """Texture of a grid, or of the stack of one; not uploaded again for the same volume."""
    if isinstance(grid, Stack):
        return stack_texture(device, grid, progress)
    key = ("grid", grid.channels, grid.time, grid.filtered, grid.masked, grid.levels)
    found: textures.VolumeTexture = device.kept.get(key, lambda: textures.upload_grid(device, grid, progress), grid.volume)
    return found


def stack_texture(device: Device, stack: Stack, progress: textures.Progress) -> textures.VolumeTexture:
    """Texture of a stack; not uploaded again for the same volume and axis."""
    key = (*_stack_key(stack), stack.axis)
    made: textures.VolumeTexture = device.kept.get(key, lambda: stacks.upload_stack(device, stack, progress), stack.volume)
    return made


def _stack_key(stack: Stack) -> tuple[Hashable, ...]:
    return "stack", stack.channels, stack.time, stack.filtered, stack.masked, stack.levels


def held_axes(device: Device, stack: Stack) -> list[int]:
    """Axes along which stacks of the same samples are on the device, in the order of their use."""
    mine = _stack_key(stack)
    return [key[len(mine)] for key in device.kept if key[: len(mine)] == mine and key[-1] == id(stack.volume)]  # type: ignore[misc]


def label_texture(device: Device, cells: LabelCells, progress: textures.Progress) -> textures.VolumeTexture:
    """Texture of labels; not uploaded again for the same volume, whatever their styles."""
    numbers = cells.numbers
    found: textures.VolumeTexture = device.kept.get(("labels",), lambda: upload_labels(device, numbers, progress), numbers)
    return found


def layer_uniforms(device: Device, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress) -> LayerUniforms:
    """Place of a layer's grid in the device's world, whose origin is the anchor, and decoding of its texels."""
    volume = layer.context.volume
    low, high = domain_index(volume.size, layer.field.cells)
    size = tuple(float(n) for n in volume.size)
    scale, offset, axis = 1.0, 0.0, 2
    scales: dict[int, float] = {}
    offsets: dict[int, float] = {}
    for resource in layer.resources["field"].values():
        if isinstance(resource, Grid):
            encodings = grid_texture(device, resource, progress).encodings
            axis = resource.axis if isinstance(resource, Stack) else axis
            scale, offset = encodings[0].scale, encodings[0].offset
            groups = needed_groups(layer.context)
            lanes = {4 * g + lane: 4 * stack + lane for g, stack in enumerate(groups) for lane in range(4)}
            scales = {lane: encodings[place].scale for lane, place in lanes.items() if place < len(encodings)}
            offsets = {lane: encodings[place].offset for lane, place in lanes.items() if place < len(encodings)}
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
        channel_scale=by_group(scales, 1.0),
        channel_offset=by_group(offsets),
        stack_axis=axis,
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


def light_count(lights: tuple[Light, ...]) -> int:
    """How many records of lights a program has: one dark light where there is none, since arrays are not empty."""
    return max(1, len(lights))


def pack_lights(lights: tuple[Light, ...]) -> bytes:
    """Bytes of the records of lights."""
    struct = class_struct(LightRecord, "LightRecord")
    records = np.zeros(light_count(lights), dtype=struct.dtype)
    for record, light in zip(records, lights, strict=False):
        rgb = tuple(light.intensity * c for c in light.colour)
        fill(record, struct, LightRecord(LIGHT_KINDS[light.kind], rgb, light.vector, light.radius or 0.0))  # type: ignore[arg-type]
    return records.tobytes()


def write_lights(device: Device, lights: tuple[Light, ...]) -> Any:
    """Uniform buffer of the lights: software devices read storage buffers lane by lane.

    Raises
    ------
    LimitError
        When they do not fit into it.
    """
    packed, each = pack_lights(lights), class_struct(LightRecord, "LightRecord").dtype.itemsize
    most = device.limits["max-uniform-buffer-binding-size"] // each
    if len(packed) > most * each:
        raise LimitError("scene.lights", f"are {len(lights)}; {device.info.name} takes {most}")
    return compute.write_uniforms(device, "lights", packed)


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
        elif slot and binding.kind in TEXTURES:
            resource = (scene if index is None else layers[index].resources)[slot][name]
            found[binding.name] = _view(device, resource, layers, index or 0, anchor_world, progress)
    return found


def _view(
    device: Device,
    resource: Resource,
    layers: tuple[DrawnLayer, ...],
    number: int,
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> Any:
    layer = layers[number]
    match resource:
        case Stack():
            return stack_texture(device, resource, progress).texture.create_view(dimension="2d-array")
        case Grid():
            return grid_texture(device, resource, progress).texture.create_view()
        case Table():
            texels = resource.texels
            return device.kept.get(("table",), lambda: textures.upload_table(device, texels), texels).create_view()
        case SlabTable():
            slabs = device.kept.get(("slab table", resource), lambda: slab_tables.make_slab_table(device, resource))
            # Each place of a control point that is dragged has made some, and nobody comes back to them.
            device.kept.keep_newest("slab table", MOST_SLAB_TABLES)
            return slabs.create_view(dimension="2d-array")
        case LabelCells():
            return label_texture(device, resource, progress).texture.create_view()
        case GradientGrid():
            return _gradient_texture(device, resource, layer, anchor_world, progress).create_view()
        case ClassifiedGrid():
            texture = _classified_texture(device, resource, layer, anchor_world, progress)
            return texture.create_view(dimension="2d-array" if isinstance(resource.grid, Stack) else "3d")
        case BlockLeaps():
            return layer_leaps(device, layer).texture.create_view()
        case BlockBounds():
            return blocks.block_bounds(device, resource).create_view()
        case DirectionGrid():
            from .directions import number_texture

            return number_texture(device, resource, layer, anchor_world, progress).create_view()
        case LitDirections():
            from .directions import lit_texture

            return lit_texture(device, resource, number).create_view()
        case OpennessGrid():
            from .occlusion import openness_texture  # it is made of what stands here

            return openness_texture(device, resource, layers, number, anchor_world, progress).create_view()
        case ShadowGrid():
            from .shadows import shadow_texture

            return shadow_texture(device, resource, layers, number, anchor_world, progress).create_view()


def _gradient_texture(
    device: Device, resource: GradientGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of gradients, made at the voxels by the layer's own field and a gradient stage.

    Gradients of a mixture follow its functions.
    """
    context = layer.context
    used: dict[str, Stage] = {"field": resource.reader or layer.stages["field"], "gradient": resource.method}
    alone = DrawnLayer(used, context, {slot: stage.resources(context) for slot, stage in used.items()})
    place = ("gradients", *used.values(), resource.format, resource.encoding, context.channels, context.time)
    root, output = f"gradient_grid_{resource.format}", f"gradients_{resource.format}_out"
    values = {"encoding": resource.encoding}
    return device.kept.get(
        (*place, needed_groups(context), *lines_of(context).items()),
        lambda: _voxel_texture(device, alone, root, output, resource.texel_format, values, anchor_world, progress),
        context.volume,
    )


def _classified_texture(
    device: Device, resource: ClassifiedGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of media, made at the voxels."""
    context, grid = layer.context, resource.grid
    used: dict[str, Stage] = {"field": resource.field, "transfer": resource.transfer}
    alone = DrawnLayer(used, context, {slot: stage.resources(context) for slot, stage in used.items()})
    values = {"classify": ClassifyUniforms(resource.weighted and not resource.function.associated)}
    axis = grid.axis if isinstance(grid, Stack) else None
    root, output = ("classified_grid", "classified_out") if axis is None else ("classified_stack", "classified_stack_out")
    return device.kept.get(
        ("classified", axis, grid.channels, grid.time, resource.function, resource.weighted, grid.filtered),
        lambda: _voxel_texture(device, alone, root, output, "rgba32float", values, anchor_world, progress, axis),
        grid.volume,
    )


def told_leaps(layer: DrawnLayer) -> BlockLeaps | None:
    """Return what is asked for to pass over empty blocks, if anything is."""
    found = layer.resources["field"].get("leaps")
    return found if isinstance(found, BlockLeaps) and not layer.is_full else None


def layer_leaps(device: Device, layer: DrawnLayer) -> blocks.Leaps:
    """Leaps over a layer's blocks; ranges are made once for a volume, whatever values are empty."""
    asked, size = layer.resources["field"]["leaps"], layer.context.volume.size
    assert isinstance(asked, BlockLeaps)
    return blocks.block_leaps(device, asked, tuple(block_count(n) for n in reversed(size)))


def unless_full(device: Device, layer: DrawnLayer) -> DrawnLayer:
    """Return the layer without leaps where hardly a block is empty: to look for what is would cost more than it saves."""
    if "leaps" not in layer.resources["field"] or layer_leaps(device, layer).share < FULL:
        return layer
    if layer.is_even:
        return replace(layer, is_full=True)
    known = {name: resource for name, resource in layer.resources["field"].items() if name != "leaps"}
    return replace(layer, resources={**layer.resources, "field": known}, is_full=True)


def if_even(device: Device, layer: DrawnLayer, asked: BlockLeaps | None) -> DrawnLayer:
    """Return the layer with what is asked for slabs through even blocks, where there are many."""
    if asked is None:
        return layer
    told = replace(layer, resources={**layer.resources, "field": {**layer.resources["field"], "leaps": asked}})
    is_even, skips = layer_leaps(device, told).even > 0, "leaps" in layer.resources["field"]
    # Leaps that were made to look for even blocks are those of a layer without, too.
    return replace(told, is_even=is_even, is_full=not skips) if is_even or skips else layer


def _alone_key(device: Device, alone: DrawnLayer, root: str, output: str, extra: tuple[str, ...]) -> ProgramKey:
    """Key of a pass with the stages of a layer that has no others."""
    return ProgramKey(
        f"passes/{root}.wgsl",
        (),
        (tuple((s, stage_key(stage, alone.resources[s], stage.variant(alone.context))) for s, stage in alone.stages.items()),),
        (output,),
        extra,
        Switches(has_empty=alone.field.masked),
        device.traits,
        alone.field.groups(alone.context),
    )


def _voxel_texture(
    device: Device,
    alone: DrawnLayer,
    root: str,
    output: str,
    texel_format: str,
    extra: dict[str, Any],
    anchor_world: FloatArray,
    progress: textures.Progress,
    axis: int | None = None,
) -> Any:
    """Texture, in layers along an axis if any, that a pass fills voxel by voxel by the stages of a layer without others."""
    program = build_program(_alone_key(device, alone, root, output, ("slice", *extra)))
    values = extra | uniform_values(device, {}, (alone,), anchor_world, progress)
    bound = bound_resources(device, program, (alone,), {}, anchor_world, progress)

    def pack(first_z: int) -> bytes:
        return pack_uniforms(program, FrameUniforms(), values | {"slice": SliceUniforms(first_z)})

    size = alone.context.volume.size
    return gradients.compute_voxels(device, program, output, texel_format, pack, bound, size, progress, axis=axis)
