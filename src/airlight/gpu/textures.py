"""Textures: which format holds samples of a type and range, and the way of the samples there.

The one place where formats are chosen. Measured on lavapipe: filtered 8-bit textures give 8-bit results, so 8-bit data goes
as half floats there, which hold whole numbers up to 2048 exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from ..errors import LimitError
from ..reconstruction.levels import coarser, level_sizes
from ..stage import Grid
from ..volume import is_empty, statistics
from .device import Device

CHUNK_BYTES = 32 << 20
EXACT_HALVES = 2048
"""Whole numbers up to it are half floats."""
WIDTHS = {1: "r", 2: "rg", 4: "rgba"}
EMPTY = np.float32(-3.4e38)

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Encoding:
    """How samples lie in a texture: ``value = texel * scale + offset``; ``error`` bounds the quantisation, in data units."""

    format: str
    dtype: str
    scale: float
    offset: float
    error: float = 0.0


@dataclass(frozen=True, eq=False)
class VolumeTexture:
    """A texture with the encoding of each channel, all of one format."""

    texture: Any
    encodings: tuple[Encoding, ...]
    bytes: int

    @property
    def encoding(self) -> Encoding:
        """Encoding of the channel that loses most."""
        return max(self.encodings, key=lambda encoding: encoding.error)


def choose_encoding(
    dtype: np.dtype[Any], low: float, high: float, *, filtered: bool, device: Device, width: int = 1
) -> Encoding:
    """Encoding for samples of a type within a range, ``width`` to a texel: 1, 2 or 4.

    What is not ``filtered`` by the sampler may use any format.
    """
    if width > 1:
        one = choose_encoding(dtype, low, high, filtered=filtered, device=device)
        return replace(one, format=WIDTHS[width] + one.format.removeprefix("r"))
    software, unorm16 = device.info.kind == "software", "texture-format16bit-norm" in device.features
    float32 = not filtered or device.traits.filters_float32
    if dtype.kind == "b" or (dtype.kind in "iu" and dtype.itemsize == 1):
        base = -128.0 if dtype.kind == "i" else 0.0
        if software and filtered:
            return Encoding("r16float", "f2", 1.0, 0.0)
        return Encoding("r8unorm", "u1", 255.0, base)
    # Half floats are densest around zero: the range is centred there. Software samples them quickest.
    middle = float(np.round((low + high) / 2)) if dtype.kind in "iu" else (low + high) / 2
    reach = max(high - middle, middle - low)
    halves = Encoding("r16float", "f2", 1.0, middle)
    if software and filtered and dtype.kind in "iu" and dtype.itemsize == 2 and reach <= EXACT_HALVES:
        return halves
    if dtype.kind in "iu" and dtype.itemsize == 2 and unorm16:
        return Encoding("r16unorm", "u2", 65535.0, -32768.0 if dtype.kind == "i" else 0.0)
    if dtype == np.float16:
        return Encoding("r16float", "f2", 1.0, 0.0)
    if float32:
        return Encoding("r32float", "f4", 1.0, 0.0, float32_error(dtype, low, high))
    if dtype.kind in "iu" and reach <= EXACT_HALVES:
        return halves
    scale = reach or 1.0
    return Encoding("r16float", "f2", scale, middle, scale * 2.0**-12)


def float32_error(dtype: np.dtype[Any], low: float, high: float) -> float:
    """Bound of what 32-bit floats lose of samples of a type within a range, in data units."""
    largest = max(abs(low), abs(high))
    exact = dtype == np.float32 or dtype.itemsize <= 2 or (dtype.kind in "iu" and largest <= 2**24)
    return 0.0 if exact else largest * 2.0**-24


def encode(part: npt.NDArray[Any], encoding: Encoding) -> npt.NDArray[Any]:
    """Texels of samples."""
    if encoding.dtype == "u1":
        return part.view(np.uint8) if part.dtype.kind in "bu" else part.view(np.uint8) ^ np.uint8(0x80)
    if encoding.dtype == "u2":
        return part if part.dtype.kind == "u" else part.view(np.uint16) ^ np.uint16(0x8000)
    if part.dtype.kind in "biu" and part.dtype.itemsize <= 2 and encoding.dtype == "f2":
        bits = np.dtype(f"u{part.dtype.itemsize}")
        values = np.arange(1 << 8 * bits.itemsize, dtype=bits).view(part.dtype if part.dtype != bool else bits)
        with np.errstate(over="ignore"):  # of values that the grid does not have
            table = ((values - encoding.offset) / encoding.scale).astype(np.float16)
        return np.asarray(table[part.view(bits)])
    if encoding.offset == 0.0 and encoding.scale == 1.0:
        return part.astype(encoding.dtype, copy=False)
    centred = part.astype(np.float64) - encoding.offset
    return (centred / encoding.scale).astype(encoding.dtype)


def encode_masked(part: npt.NDArray[Any], no_data: float | None) -> npt.NDArray[np.float32]:
    """32-bit floats with the mark of ``empty.wgsl`` in place of empty samples."""
    mask = is_empty(part, no_data)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows or is not a number is masked or clipped
        texels = np.clip(part.astype(np.float32), -1e38, 1e38)
    if mask is not None:
        texels[mask] = EMPTY
    return texels


def upload_grid(device: Device, grid: Grid, progress: Progress) -> VolumeTexture:
    """Put channels at one time step into a 3-D texture, in chunks of whole slices.

    Raises
    ------
    LimitError
        When the grid, or the stack of its channels, is larger than the device's textures.
    """
    volume, size = grid.volume, grid.volume.size
    check_size(device, size)
    stacks = [grid.channels[first : first + 4] for first in range(0, len(grid.channels), 4)]
    check_stack(device, size, len(stacks))
    encodings, width = encodings_of(device, grid), texel_width(grid)
    encoding = encodings[0]
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    shape = (size[0], size[1], size[2] * len(stacks))
    sizes = level_sizes(size) if grid.levels else (shape,)
    texture = device.gpu.create_texture(
        size=shape, dimension="3d", format=encoding.format, usage=usage, mip_level_count=len(sizes)
    )
    row = size[0] * width * np.dtype(encoding.dtype).itemsize
    rows = max(1, CHUNK_BYTES // max(1, row * size[1]))
    for stack, channels in enumerate(stacks):
        samples = [volume.grid(channel, grid.time) for channel in channels]
        for z in range(0, size[2], rows):
            part = texels_of([s[z : z + rows] for s in samples], grid, encodings[4 * stack : 4 * stack + 4], width)
            first = stack * size[2] + z
            device.queue.write_texture(
                {"texture": texture, "origin": (0, 0, first)},
                np.ascontiguousarray(part),
                {"bytes_per_row": row, "rows_per_image": size[1]},
                (size[0], size[1], part.shape[0]),
            )
            progress("upload", first + part.shape[0], shape[2])
    if grid.levels:
        _write_levels(device, grid, texture, encoding, progress)
    voxel = width * np.dtype(encoding.dtype).itemsize
    return VolumeTexture(texture, encodings, voxel * sum(x * y * z for x, y, z in sizes))


def _write_levels(device: Device, grid: Grid, texture: Any, encoding: Encoding, progress: Progress) -> None:
    """Fill the coarser levels of a texture of one channel."""
    last = len(level_sizes(grid.volume.size)) - 1
    for number, level in enumerate(coarser(grid.volume.grid(grid.channels[0], grid.time)), 1):
        progress("levels", number, last)
        write_level(device, texture, number, level, encoding)


def write_level(device: Device, texture: Any, number: int, level: npt.NDArray[np.float32], encoding: Encoding) -> None:
    """Fill a coarser level of a texture with samples of one channel, slice behind slice."""
    part = np.ascontiguousarray(encode(level, encoding))
    device.queue.write_texture(
        {"texture": texture, "mip_level": number},
        part,
        {"bytes_per_row": part.shape[2] * part.itemsize, "rows_per_image": part.shape[1]},
        part.shape[::-1],
    )


def texel_width(grid: Grid) -> int:
    """Samples to a texel. Where empty samples are marked, all four places of a texel are."""
    return 1 if len(grid.channels) == 1 else 2 if len(grid.channels) == 2 and not grid.masked else 4


def encodings_of(device: Device, grid: Grid) -> tuple[Encoding, ...]:
    """Encodings of a grid's channels: one format, which follows from the type, each in its own range."""
    known = [statistics(grid.volume, channel, grid.time) for channel in grid.channels]
    return tuple(_encoding_of(device, grid, one.minimum, one.maximum) for one in known)


def _encoding_of(device: Device, grid: Grid, low: float, high: float) -> Encoding:
    dtype, width = grid.volume.dtype, texel_width(grid)
    if grid.masked:
        return Encoding(f"{WIDTHS[width]}32float", "f4", 1.0, 0.0, float32_error(dtype, low, high))
    if grid.levels and dtype.kind in "biu":
        if dtype.itemsize == 1:  # half floats hold the samples exactly, and means to a sixteenth
            return Encoding("r16float", "f2", 1.0, 0.0, 2.0**-12 * max(abs(low), abs(high)))
        dtype = np.dtype(np.float32)  # means are no whole numbers
    return choose_encoding(dtype, low, high, filtered=grid.filtered, device=device, width=width)


def texels_of(samples: list[npt.NDArray[Any]], grid: Grid, encodings: Sequence[Encoding], width: int) -> npt.NDArray[Any]:
    """Texels of the same slices of channels; what a channel more would have is empty, or the least that texels hold."""

    def one(part: npt.NDArray[Any], encoding: Encoding) -> npt.NDArray[Any]:
        return encode_masked(part, grid.volume.no_data) if grid.masked else encode(part, encoding)

    if width == 1:
        return one(samples[0], encodings[0])
    texels = np.full((*samples[0].shape, width), EMPTY if grid.masked else 0, dtype=encodings[0].dtype)
    for number, (part, encoding) in enumerate(zip(samples, encodings, strict=True)):
        texels[..., number] = one(part, encoding)
    return texels


def check_stack(device: Device, size: tuple[int, int, int], groups: int) -> None:
    """Refuse more groups of four channels, one behind the other, than the device's 3-D textures are deep."""
    most = device.limits["max-texture-dimension-3d"]
    if size[2] * groups > most:
        raise LimitError(
            "transfer.channels",
            f"make {groups} groups of four with {size[2]} slices each; {device.info.name} holds at most {most} slices",
            f"draw {4 * (most // size[2])} channels at a time, or crop the volume",
        )


def check_size(device: Device, size: tuple[int, int, int]) -> None:
    """Refuse what exceeds the device's 3-D textures, before anything is uploaded."""
    most = device.limits["max-texture-dimension-3d"]
    if max(size) > most:
        raise LimitError(
            "volume",
            f"has {' x '.join(map(str, size))} voxels; {device.info.name} holds at most {most} a side",
            "crop or downsample it, choose a coarser level, or another device",
        )


def upload_table(device: Device, texels: npt.NDArray[np.float32]) -> Any:
    """Put a table, ``(d, h, w, 4)``, into a 3-D texture of 32-bit floats."""
    count, height, width, _ = texels.shape
    most = device.limits["max-texture-dimension-3d"]
    if max(height, width) > most:
        raise LimitError("table", f"has {width} x {height} entries, the device holds {most}", "choose fewer entries")
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.gpu.create_texture(size=(width, height, count), dimension="3d", format="rgba32float", usage=usage)
    device.queue.write_texture(
        {"texture": texture},
        np.ascontiguousarray(texels),
        {"bytes_per_row": width * 16, "rows_per_image": height},
        (width, height, count),
    )
    return texture
