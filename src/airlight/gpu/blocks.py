"""Blocks of voxels: the ranges of their values, computed on the device, and how far rays may leap over them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from ..errors import LimitError
from ..shader.program import Program
from ..stage import BLOCK_VOXELS
from . import compute
from .device import Device

MOST_LEAP = 15  # blocks: those before the next one that counts
MOST_GROUPS = 4096
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


def occupied(ranges: Ranges, empty: Sequence[tuple[float, float]]) -> npt.NDArray[np.bool_]:
    """Whether there is something in each block (z, y, x): its values do not lie within one closed interval of ``empty``."""
    found = np.ones(ranges.shape[:3], dtype=bool)
    for first, last in empty:
        outside = np.zeros_like(found)
        if first > -np.inf:
            outside |= ranges[..., 0] < first
        if last < np.inf:
            outside |= ranges[..., 1] > last
        found &= outside
    return found


def leaps(near: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint8]:
    """How far each block (z, y, x) is from the next in which there is something, in blocks along the farthest axis.

    At most ``MOST_LEAP``; 0 where there is something in the block itself. What is near grows by a block all round, 64 blocks to
    a word, and the steps that a block waits for it are counted in binary, a bit of all blocks at a time.
    """
    words = _packed(near)
    bits = [np.zeros_like(words) for _ in range(MOST_LEAP.bit_length())]
    for _ in range(MOST_LEAP):
        carry = ~words
        for bit in bits:
            bit ^= carry
            carry &= ~bit
        words = _grown(words)
    places = (np.unpackbits(bit.view(np.uint8), axis=-1, count=near.shape[2], bitorder="little") for bit in bits)
    distance = np.zeros(near.shape, dtype=np.uint8)
    for power, place in enumerate(places):
        distance |= place << np.uint8(power)
    return distance


def _packed(flags: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint64]:
    """Flags (z, y, x) as words (z, y, ceil(x / 64)), the first in the lowest bit."""
    rest = -flags.shape[2] % 64
    octets = np.packbits(np.pad(flags, ((0, 0), (0, 0), (0, rest))), axis=-1, bitorder="little")
    return octets.view(np.uint64)


def _grown(words: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Words with each flag that has a neighbour, also across an edge or a corner."""
    one, most = np.uint64(1), np.uint64(63)
    grown: npt.NDArray[np.uint64] = words | words << one | words >> one
    grown[..., 1:] |= words[..., :-1] >> most
    grown[..., :-1] |= words[..., 1:] << most
    for axis in (0, 1):
        line, before = np.moveaxis(grown, axis, 0), np.moveaxis(grown.copy(), axis, 0)
        line[1:] |= before[:-1]
        line[:-1] |= before[1:]
    return grown


@dataclass(frozen=True, eq=False)
class Leaps:
    """Leaps as a texture; and groups of blocks in which there is something: each one's place (n, 3), x y z, and its side."""

    texture: Any
    groups: npt.NDArray[np.int64]
    group_voxels: int

    @property
    def bytes(self) -> int:
        """Bytes on the device and on the host."""
        return int(math.prod(self.texture.size)) + self.groups.nbytes


def make_leaps(device: Device, ranges: Ranges, empty: Sequence[tuple[float, float]]) -> Leaps:
    """Leaps over blocks, on the device, and where there is something."""
    near = occupied(ranges, empty)
    active, side = near, BLOCK_VOXELS
    while np.count_nonzero(active) > MOST_GROUPS:
        for axis in range(3):
            line = np.moveaxis(active, axis, 0)
            pairs = line[::2].copy()
            pairs[: len(line) // 2] |= line[1::2]
            active = np.moveaxis(pairs, 0, axis)
        side *= 2
    return Leaps(upload_leaps(device, leaps(near)), np.argwhere(active)[:, ::-1], side)


def upload_leaps(device: Device, texels: npt.NDArray[np.uint8]) -> Any:
    """Put leaps into a 3-D texture of whole numbers."""
    z, y, x = texels.shape
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.gpu.create_texture(size=(x, y, z), dimension="3d", format="r8uint", usage=usage)
    layout = {"bytes_per_row": x, "rows_per_image": y}
    device.queue.write_texture({"texture": texture}, np.ascontiguousarray(texels), layout, (x, y, z))
    return texture
