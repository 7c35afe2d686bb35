"""Stacks: the samples of a grid as layers of 2-D textures along one of its axes, in the formats that grids have."""

from __future__ import annotations

import numpy as np
import wgpu

from ..errors import LimitError
from ..reconstruction.levels import coarser
from ..stage import Stack
from ..volume import AnyArray
from .device import Device
from .textures import CHUNK_BYTES, Progress, VolumeTexture, encodings_of, texel_width, texels_of, write_level

AXES = "xyz"


def upload_stack(device: Device, stack: Stack, progress: Progress) -> VolumeTexture:
    """Put channels at one time step into an array of 2-D textures, in chunks of whole layers.

    Raises
    ------
    LimitError
        When the device has not so many layers, or not such large ones.
    """
    width, height, layers = turned(stack.volume.size, stack.axis)
    groups = [stack.channels[first : first + 4] for first in range(0, len(stack.channels), 4)]
    check_layers(device, stack, len(groups))
    encodings, wide = encodings_of(device, stack), texel_width(stack)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    size = (width, height, layers * len(groups))
    levels = max(width, height).bit_length() if stack.levels else 1
    texture = device.gpu.create_texture(
        size=size, dimension="2d", format=encodings[0].format, usage=usage, mip_level_count=levels
    )
    row = width * wide * np.dtype(encodings[0].dtype).itemsize
    at_once = max(1, CHUNK_BYTES // max(1, row * height))
    for group, channels in enumerate(groups):
        samples = [layered(stack.volume.grid(channel, stack.time), stack.axis) for channel in channels]
        for first in range(0, layers, at_once):
            chunk = [np.ascontiguousarray(one[first : first + at_once]) for one in samples]
            part = texels_of(chunk, stack, encodings[4 * group : 4 * group + 4], wide)
            begin = group * layers + first
            device.queue.write_texture(
                {"texture": texture, "origin": (0, 0, begin)},
                np.ascontiguousarray(part),
                {"bytes_per_row": row, "rows_per_image": height},
                (width, height, len(part)),
            )
            progress(f"upload layers along {AXES[stack.axis]}", begin + len(part), size[2])
    samples_a_layer = width * height
    if stack.levels:
        finest = stack.volume.grid(stack.channels[0], stack.time)
        for number, level in zip(range(1, levels), coarser(finest), strict=False):
            write_level(device, texture, number, layered(level, stack.axis), encodings[0])
            progress("levels", number, levels - 1)
        samples_a_layer = sum(max(1, width >> n) * max(1, height >> n) for n in range(levels))
    return VolumeTexture(texture, encodings, row // width * samples_a_layer * size[2])


def turned(size: tuple[int, int, int], axis: int) -> tuple[int, int, int]:
    """Width and height of the layers of a grid, along the other two axes in rising order, and how many there are."""
    width, height = (n for other, n in enumerate(size) if other != axis)
    return width, height, size[axis]


def layered(samples: AnyArray, axis: int) -> AnyArray:
    """Samples (z, y, x) seen as (layers, height, width) along an axis."""
    return np.moveaxis(samples, 2 - axis, 0)


def check_layers(device: Device, stack: Stack, groups: int) -> None:
    """Refuse what exceeds the device's arrays of textures, before anything is uploaded."""
    name, axis = device.info.name, AXES[stack.axis]
    widest, most = device.limits["max-texture-dimension-2d"], device.limits["max-texture-array-layers"]
    width, height, layers = turned(stack.volume.size, stack.axis)
    if layers * groups > most:
        of_channels = f" for each of {groups} groups of four channels" if groups > 1 else ""
        raise LimitError(
            "volume",
            f"has {layers} layers along {axis}{of_channels}; {name} holds at most {most} in an array of 2-D textures",
            "use the driver slices or march, which read a 3-D texture, crop the volume, or look along another axis",
        )
    if max(width, height) > widest:
        found = f"has layers of {width} x {height} voxels along {axis}; {name} holds at most {widest} a side"
        raise LimitError("volume", found, "crop or downsample it")
