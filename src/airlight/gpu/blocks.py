"""Blocks of voxels: the ranges of their values, computed on the device, and how far rays may leap over them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from ..errors import LimitError
from ..shader.program import Program
from . import compute
from .device import Device

MOST_LEAP = 15  # blocks: those before the next one that counts
Ranges = npt.NDArray[np.float32]


def compute_ranges(
    device: Device, program: Program, packed: bytes, bound: Mapping[str, Any], size: tuple[int, int, int]
) -> Ranges:
    """Least and greatest value of each block, (z, y, x, 2), by a program that writes ``ranges_out``.

    Raises
    ------
    LimitError
        When they do not fit into one binding of the device.
    """
    x, y, z = size
    count = x * y * z * 8
    most = device.limits["max-storage-buffer-binding-size"]
    if count > most:
        raise LimitError("volume", f"has {x * y * z} blocks of voxels; {device.info.name} takes {most // 8}", 'use skip="none"')
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    target = device.gpu.create_buffer(size=count, usage=usage)
    uniforms = compute.write_uniforms(device, "uniforms of ranges", packed)
    pipeline = compute.pipeline_of(device, program)
    groups = compute.bind_groups(device, pipeline, {**bound, "uniforms": uniforms, "ranges_out": target})
    compute.dispatch(device, pipeline, groups, (-(-x // 16), -(-y // 4), z))
    return np.frombuffer(device.queue.read_buffer(target), dtype=np.float32).reshape(z, y, x, 2)


def leaps(ranges: Ranges, wanted: Sequence[tuple[float, float]]) -> npt.NDArray[np.uint8]:
    """How far each block (z, y, x) is from the next that holds one of the wanted values, in blocks along the farthest axis.

    At most ``MOST_LEAP``; 0 where a block itself meets one of the closed intervals ``wanted``.
    """
    low, high = ranges[..., 0], ranges[..., 1]
    near = np.zeros(low.shape, dtype=np.uint8)
    for first, last in wanted:
        near |= ((low <= last) & (high >= first) & (low <= high)).view(np.uint8)
    distance = np.zeros(low.shape, dtype=np.uint8)
    for _ in range(MOST_LEAP):
        distance += 1 - near
        for axis in range(3):
            line = np.moveaxis(near, axis, 0)
            grown = line.copy()
            grown[1:] |= line[:-1]
            grown[:-1] |= line[1:]
            near = np.moveaxis(grown, 0, axis)
    return distance


def upload_leaps(device: Device, texels: npt.NDArray[np.uint8]) -> Any:
    """Put leaps into a 3-D texture of whole numbers."""
    z, y, x = texels.shape
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.gpu.create_texture(size=(x, y, z), dimension="3d", format="r8uint", usage=usage)
    layout = {"bytes_per_row": x, "rows_per_image": y}
    device.queue.write_texture({"texture": texture}, np.ascontiguousarray(texels), layout, (x, y, z))
    return texture
