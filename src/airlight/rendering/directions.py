"""Quantised normals on the device: the number of its direction for each voxel, and how directions are lit in a frame."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from ..gpu import compute, gradients, textures
from ..gpu.device import Device
from ..shader.program import FrameUniforms, ProgramKey, SliceUniforms, SteepUniforms, Switches, build_program, stage_key
from ..stage import DirectionGrid, LitDirections
from ..stages.field import needed_groups
from ..stages.field_channels import lines_of
from ..stages.gradient import at_voxels
from ..stages.lighting import Quantised
from ..stages.shade import weakest_gradient
from ..volume import FloatArray
from .resources import DrawnLayer, bound_resources, light_count, pack_uniforms, uniform_values, write_lights

if TYPE_CHECKING:
    from .march import MarchFrame

TEXELS_AT_ONCE = 1 << 18


def number_texture(
    device: Device, resource: DirectionGrid, layer: DrawnLayer, anchor_world: FloatArray, progress: textures.Progress
) -> Any:
    """Texture of numbers of directions."""
    context = layer.context
    field, gradient = at_voxels(layer.stages)
    threshold = weakest_gradient(layer.stages["shade"], context)
    made_of = (resource, field, gradient, threshold, needed_groups(context), *lines_of(context).items())
    return device.kept.get(
        ("directions", context.channels, context.time, *made_of),
        lambda: _numbers(device, resource, layer, threshold, anchor_world, progress),
        context.volume,
    )


def _numbers(
    device: Device,
    resource: DirectionGrid,
    layer: DrawnLayer,
    threshold: float,
    anchor_world: FloatArray,
    progress: textures.Progress,
) -> Any:
    field, gradient = at_voxels(layer.stages)
    context, bits = layer.context, resource.bits
    resources = {"field": field.resources(context), "gradient": gradient.resources(context)}
    alone = DrawnLayer(
        {"field": field, "gradient": gradient, "lighting": layer.stages["lighting"]},
        context,
        {**resources, "lighting": {"normals": resource.normals}},
    )
    stages = tuple((s, stage_key(stage, alone.resources[s], stage.variant(context))) for s, stage in alone.stages.items())
    switches, groups = Switches(has_empty=alone.field.masked), alone.field.groups(context)
    output, extra = f"numbers{bits}_out", ("slice", "steep")
    key = ProgramKey(f"passes/direction_grid_{bits}.wgsl", (), (stages,), (output,), extra, switches, device.traits, groups)
    program = build_program(key)
    values = uniform_values(device, {}, (alone,), anchor_world, progress) | {"steep": SteepUniforms(threshold)}
    bound = bound_resources(device, program, (alone,), {}, anchor_world, progress)

    def pack(first_z: int) -> bytes:
        return pack_uniforms(program, FrameUniforms(), values | {"slice": SliceUniforms(first_z)})

    x, y, z = context.volume.size
    size, texel_format = (-(-x // 4), y, z), f"rgba{bits}uint"
    return gradients.compute_voxels(device, program, output, texel_format, pack, bound, size, progress, TEXELS_AT_ONCE)


def lit_texture(device: Device, resource: LitDirections, number: int) -> Any:
    """Texture of what directions of a layer send; it lives as long as their set, and each frame fills it anew."""

    size = (resource.normals.texels.shape[2] + 1, 2, 1)
    make = partial(gradients.written_texture, device, size, "rgba32float")
    return device.kept.get(("lit directions", number), make, resource.normals.texels)


def light_directions(frame: MarchFrame) -> None:
    """Light the directions of all layers that have some.

    Raises
    ------
    StageError
        When light or view depend on more than the direction of a normal; see ``Quantised.check``.
    """
    device = frame.device
    for number, layer in enumerate(frame.layers):
        lighting = layer.stages["lighting"]
        if not isinstance(lighting, Quantised):
            continue
        camera, visibility = frame.scene_stages["camera"], frame.stages_of(layer)["visibility"]
        lighting.check(camera, layer.stages["shade"], visibility, [light.kind for light in frame.scene.lights])
        lit = layer.resources["lighting"]["lit"]
        assert isinstance(lit, LitDirections)
        used = {"shade": layer.stages["shade"], "lighting": lighting}
        alone = DrawnLayer(used, layer.context, {"shade": layer.resources["shade"], "lighting": {"normals": lit.normals}})
        scene = {"camera": camera, "visibility": visibility}
        stages = tuple((s, stage_key(one, alone.resources[s], one.variant(layer.context))) for s, one in used.items())
        key = ProgramKey(
            "passes/lit_directions.wgsl",
            tuple((slot, stage_key(stage)) for slot, stage in scene.items()),
            (stages,),
            ("lit_directions_out",),
            (),
            Switches(),
            device.traits,
            layer.field.groups(layer.context),
            light_count(frame.scene.lights),
        )
        program = build_program(key)
        values = uniform_values(device, scene, (layer,), frame.anchor_world, frame.progress)
        packed = pack_uniforms(program, FrameUniforms(), values)
        resources = {
            **bound_resources(device, program, (alone,), {}, frame.anchor_world, frame.progress),
            "uniforms": compute.write_uniforms(device, "uniforms of directions", packed),
            "lights": write_lights(device, frame.scene.lights),
            "lit_directions_out": lit_texture(device, lit, number).create_view(),
        }
        pipeline = compute.pipeline_of(device, program)
        groups = compute.bind_groups(device, pipeline, resources)
        count = lit.normals.texels.shape[2] + 1
        compute.dispatch(device, pipeline, groups, (-(-count // 64), 1, 1))
