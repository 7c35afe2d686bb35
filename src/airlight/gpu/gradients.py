"""Gradients at all voxels, computed on the device into a texture of half floats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import wgpu

from ..shader.layout import fill
from ..shader.program import (
    FrameUniforms,
    LayerUniforms,
    ProgramKey,
    SliceUniforms,
    Switches,
    build_program,
    stage_key,
)
from ..stage import Context, Resource, Stage
from ..stages.field import Field
from ..volume import statistics
from . import compute, textures
from .device import Device

VOXELS_PER_DISPATCH = 1 << 21


def gradient_scale(context: Context) -> float:
    """Factor between half floats and data units per world unit: no gradient of the data comes near their limit."""
    known = statistics(context.volume, context.channel, context.time)
    return max((known.maximum - known.minimum) / min(context.volume.spacing), 1e-30)


def compute_gradients(
    device: Device,
    field: Field,
    resources: Mapping[str, Resource],
    method: Stage,
    layer: LayerUniforms,
    grid: textures.VolumeTexture,
    size: tuple[int, int, int],
    progress: textures.Progress,
) -> Any:
    """Texture (rgba16float) of gradients by ``method`` over ``field``, divided by ``layer.gradient_scale``."""
    textures.check_size(device, size)
    layer_key = (("field", stage_key(field, resources)), ("gradient", stage_key(method)))
    key = ProgramKey(
        "passes/gradient_grid.wgsl",
        (),
        (layer_key,),
        ("gradients_out",),
        ("slice",),
        Switches(has_empty=field.masked),
        device.traits,
    )
    pipeline = compute.pipeline_of(device, build_program(key))
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.STORAGE_BINDING
    texture = device.gpu.create_texture(size=size, dimension="3d", format="rgba16float", usage=usage)
    rows = max(1, VOXELS_PER_DISPATCH // (size[0] * size[1]))
    for z in range(0, size[2], rows):
        record = np.zeros((), dtype=pipeline.program.uniforms.dtype)
        for member in pipeline.program.uniforms.members:
            assert member.struct is not None
            value: Any = {"frame": FrameUniforms(), "layer_0": layer, "slice": SliceUniforms(z)}[member.name]
            fill(record[member.name], member.struct, value)
        resources = {
            "uniforms": compute.write_uniforms(device, "gradient uniforms", record.tobytes()),
            "field_grid_0": grid.texture.create_view(),
            "field_grid_0_sampler": compute.linear_sampler(device),
            "gradients_out": texture.create_view(),
        }
        groups = compute.bind_groups(device, pipeline, resources)
        depth = min(rows, size[2] - z)
        compute.dispatch(device, pipeline, groups, (-(-size[0] // 16), -(-size[1] // 4), depth))
        device.wait()
        progress("gradients", z + depth, size[2])
    return texture
