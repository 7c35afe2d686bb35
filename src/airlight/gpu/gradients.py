"""Textures with a texel for each voxel, computed on the device: gradients, media, numbers of directions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import wgpu

from ..shader.program import Program
from . import compute, stacks, textures
from .device import Device

VOXELS_PER_DISPATCH = 1 << 21


def compute_voxels(
    device: Device,
    program: Program,
    output: str,
    texel_format: str,
    pack: Callable[[int], bytes],
    bound: Mapping[str, Any],
    size: tuple[int, int, int],
    progress: textures.Progress,
    at_once: int = VOXELS_PER_DISPATCH,
    axis: int | None = None,
) -> Any:
    """Texture that a program fills as its ``output``.

    ``pack`` gives the uniforms for the slices from a number on, ``bound`` the views and samplers by the names of bindings. With
    an ``axis`` the texture is one of layers along it.
    """
    if axis is None:
        textures.check_size(device, size)
    pipeline = compute.pipeline_of(device, program)
    texture = written_texture(device, size if axis is None else stacks.turned(size, axis), texel_format, axis is not None)
    view = texture.create_view(dimension="3d" if axis is None else "2d-array")
    rows = max(1, at_once // (size[0] * size[1]))
    for z in range(0, size[2], rows):
        uniforms = compute.write_uniforms(device, f"uniforms of {output}", pack(z))
        resources = {**bound, "uniforms": uniforms, output: view}
        depth = min(rows, size[2] - z)
        groups = compute.bind_groups(device, pipeline, resources)
        compute.dispatch(device, pipeline, groups, (-(-size[0] // 16), -(-size[1] // 4), depth))
        device.wait()
        progress(output.removesuffix("_out"), z + depth, size[2])
    return texture


def written_texture(device: Device, size: tuple[int, int, int], texel_format: str, layered: bool = False) -> Any:
    """3-D texture, or one of layers, that one program writes and another reads."""
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.STORAGE_BINDING
    return device.gpu.create_texture(size=size, dimension="2d" if layered else "3d", format=texel_format, usage=usage)
