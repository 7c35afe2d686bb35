"""Textures with a texel for each voxel, computed on the device: gradients in half floats, media in floats."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import wgpu

from ..shader.program import Program
from ..stage import Context
from ..stages.field_channels import scalar_range
from . import compute, textures
from .device import Device

VOXELS_PER_DISPATCH = 1 << 21


def gradient_scale(context: Context) -> float:
    """Factor between half floats and data units per world unit: no gradient of the data comes near their limit."""
    return max(scalar_range(context, "minimum", "maximum") / min(context.volume.spacing), 1e-30)


def compute_voxels(
    device: Device,
    program: Program,
    output: str,
    texel_format: str,
    pack: Callable[[int], bytes],
    bound: Mapping[str, Any],
    size: tuple[int, int, int],
    progress: textures.Progress,
) -> Any:
    """Texture that a program fills as its ``output``; gradients are divided by ``gradient_scale``.

    ``pack`` gives the uniforms for the slices from a number on, ``bound`` the views and samplers by the names of bindings.
    """
    textures.check_size(device, size)
    pipeline = compute.pipeline_of(device, program)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.STORAGE_BINDING
    texture = device.gpu.create_texture(size=size, dimension="3d", format=texel_format, usage=usage)
    rows = max(1, VOXELS_PER_DISPATCH // (size[0] * size[1]))
    for z in range(0, size[2], rows):
        uniforms = compute.write_uniforms(device, f"uniforms of {output}", pack(z))
        resources = {**bound, "uniforms": uniforms, output: texture.create_view()}
        depth = min(rows, size[2] - z)
        groups = compute.bind_groups(device, pipeline, resources)
        compute.dispatch(device, pipeline, groups, (-(-size[0] // 16), -(-size[1] // 4), depth))
        device.wait()
        progress(output.removesuffix("_out"), z + depth, size[2])
    return texture
