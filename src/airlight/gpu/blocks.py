"""Blocks of voxels: in which of them there is something to be seen, and how far rays may leap over the others."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from ..stage import (
    BLOCK_VOXELS,
    BOUND_GROUP_VOXELS,
    BOUND_VOXELS,
    MOST_LEAP,
    BlockBounds,
    BlockLeaps,
    BlockRanges,
    BlockShares,
    BlockSlopes,
    BlockVariable,
    EvenBlocks,
    Within,
)
from ..volume import AnyArray
from .device import Device
from .ranges import Ranges, label_ranges, label_shares, sample_ranges

MOST_GROUPS = 4096
LEAST_EVEN = 0.4  # of the blocks that hold something: where fewer are even it costs more to look for them than it saves

Known = Callable[[BlockVariable], Ranges]


def known_ranges(device: Device, variable: BlockVariable) -> Ranges:
    """Ranges of a variable, those of samples and labels kept with their volume."""
    match variable:
        case BlockSlopes():
            return known_ranges(device, variable.ranges)
        case BlockShares():
            numbers, reach = variable.numbers, variable.reach
            ranks: Ranges = device.kept.get(("label ranges", reach), lambda: label_ranges(numbers, reach), numbers)
            return label_shares(ranks, variable.drawn)
        case BlockRanges():
            grid = variable.grid
            key = ("ranges", grid.channels[variable.place], grid.time, grid.masked, grid.filtered, variable.reach)
            found: Ranges = device.kept.get(key, lambda: sample_ranges(device, variable), grid.volume)
            return found


def occupied(empty: tuple[tuple[Within, ...], ...], known: Known, shape: tuple[int, ...]) -> npt.NDArray[np.bool_]:
    """Whether there is something in each block (z, y, x): under some condition no alternative holds."""
    found = np.zeros(shape, dtype=bool)
    for condition in empty:
        fails = np.ones(shape, dtype=bool)
        for within in condition:
            fails &= _leaves(known(within.variable), within)
        found |= fails
    return found


def _leaves(ranges: Ranges, within: Within) -> npt.NDArray[np.bool_]:
    """Whether a variable leaves an interval in each block."""
    variable, low, high = within.variable, within.low, within.high
    least, greatest = field_range(ranges, variable)
    leaves = np.zeros(least.shape, dtype=bool)
    if low > -np.inf:
        leaves |= least < _end(low, least.dtype, math.ceil)
    if high < np.inf:
        leaves |= greatest > _end(high, least.dtype, math.floor)
    return leaves


def field_range(ranges: Ranges, variable: BlockVariable) -> tuple[AnyArray, AnyArray]:
    """Least and greatest that a variable takes in each block, from the range of what it is made of."""
    overshoot = variable.overshoot if isinstance(variable, BlockRanges) else 0.0
    if not (overshoot or isinstance(variable, BlockSlopes)):
        return ranges.least, ranges.greatest
    least, greatest = ranges.least.astype(np.float32), ranges.greatest.astype(np.float32)
    width = np.maximum(greatest - least, 0)
    if isinstance(variable, BlockSlopes):
        return np.zeros_like(width), width * np.float32(variable.per_value)
    return least - np.float32(overshoot) * width, greatest + np.float32(overshoot) * width


def _end(end: float, dtype: np.dtype[Any], rounded: Callable[[float], int]) -> Any:
    """End of an interval in the type of what it is compared with, so that nothing is converted."""
    if dtype.kind == "f":
        return np.float32(end) if abs(end) <= np.finfo(np.float32).max else end
    info = np.iinfo(dtype)
    return min(max(rounded(end), info.min - 1), info.max + 1)


def block_bounds(device: Device, asked: BlockBounds) -> Any:
    """Texture of the greatest or the least value of each block, not rounded inwards."""
    told = asked.ranges
    grid = told.grid
    key = (
        "bounds",
        asked.of_least,
        grid.channels[told.place],
        grid.time,
        grid.masked,
        grid.filtered,
        told.reach,
        told.overshoot,
    )

    def make() -> Any:
        ends = field_range(known_ranges(device, told), told)[0 if asked.of_least else 1]
        reduce = np.minimum if asked.of_least else np.maximum
        own = pooled(outwards(ends, asked.of_least), BOUND_VOXELS // BLOCK_VOXELS, reduce)
        group = pooled(own, BOUND_GROUP_VOXELS // BOUND_VOXELS, reduce)
        for axis in range(3):
            group = np.repeat(group, BOUND_GROUP_VOXELS // BOUND_VOXELS, axis)
        z, y, x = own.shape
        return upload_blocks(device, np.stack([own, group[:z, :y, :x]], axis=-1), "rg16float")

    return device.kept.get(key, make, grid.volume)


def pooled(ends: AnyArray, count: int, reduce: np.ufunc) -> AnyArray:
    """Least or greatest of groups of so many numbers along each axis (z, y, x)."""
    for axis in range(3):
        ends = reduce.reduceat(ends, np.arange(0, ends.shape[axis], count), axis=axis)
    return ends


def outwards(ends: AnyArray, of_least: bool) -> npt.NDArray[np.float16]:
    """Half floats that are not above the least values, or not below the greatest."""
    with np.errstate(over="ignore"):
        halves = ends.astype(np.float16)
    inside = halves > ends if of_least else halves < ends
    towards = np.float16(-np.inf if of_least else np.inf)
    return np.where(inside, np.nextafter(halves, towards), halves)


def leaps(near: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint8]:
    """How far each block (z, y, x) is from the next in which there is something, in blocks along the farthest axis.

    At most ``MOST_LEAP``; 0 where there is something in the block itself. What is near grows by a block all round, 64 blocks to
    a word. A block that waits for so many steps has been far at each of them: a bit of their number turns at every so many.
    """
    words = _packed(near)
    bits = [np.zeros_like(words) for _ in range(MOST_LEAP.bit_length())]
    for step in range(1, MOST_LEAP + 1):
        far = ~words
        for power, bit in enumerate(bits):
            if step % (1 << power) == 0:
                bit ^= far
        words = _grown(words)
    distance = np.zeros(near.shape, dtype=np.uint8)
    for bit in reversed(bits):
        distance += distance
        distance |= np.unpackbits(bit.view(np.uint8), axis=-1, count=near.shape[2], bitorder="little")
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
    """Leaps as a texture; and groups of blocks in which there is something: each one's place (n, 3), x y z, and its side.

    ``share`` is that of the blocks in which there is, ``even`` that of those among them in which one medium is.
    """

    texture: Any
    share: float
    even: float
    groups: npt.NDArray[np.int64]
    group_voxels: int

    @property
    def bytes(self) -> int:
        """Bytes on the device and on the host."""
        return int(math.prod(self.texture.size)) + self.groups.nbytes


def block_leaps(device: Device, asked: BlockLeaps, shape: tuple[int, ...]) -> Leaps:
    """Leaps over blocks (z, y, x), made anew only where what is empty, or how it is told, changes."""
    owners: list[Any] = []
    key = tuple(tuple((*_told(w.variable, owners), w.low, w.high) for w in condition) for condition in asked.empty)
    even = asked.even
    if even is not None:
        key += tuple(_told(ranges, owners) for ranges in (even.values, even.around, even.moved)), even.plateaus

    def make() -> Leaps:
        near = occupied(asked.empty, partial(known_ranges, device), shape)
        return make_leaps(device, near, None if even is None else even_blocks(device, even, near))

    found: Leaps = device.kept.get(("leaps", shape, key), make, *owners)
    return found


def _told(variable: BlockVariable, owners: list[Any]) -> tuple[Any, ...]:
    """What tells a variable from others; of what lives as long as the volume, and is put among owners, the place there."""

    def number(owner: Any) -> int:
        if not any(owner is known for known in owners):
            owners.append(owner)
        return next(i for i, known in enumerate(owners) if owner is known)

    match variable:
        case BlockSlopes():
            return ("slopes", variable.per_value, *_told(variable.ranges, owners))
        case BlockShares():
            return ("shares", number(variable.numbers), variable.drawn, variable.reach)
        case BlockRanges():
            grid = variable.grid
            traits = (grid.channels, grid.time, grid.masked, grid.filtered)
            return ("values", number(grid.volume), *traits, variable.place, variable.reach, variable.overshoot)


def even_blocks(device: Device, asked: EvenBlocks, near: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_] | None:
    """Whether one medium is in each block (z, y, x); None where that holds for too few of those ``near``.

    Ranges that reach further are made only where it may matter.
    """
    even = near
    for around, moved in dict.fromkeys(((asked.values, asked.values), (asked.around, asked.moved))):
        ranges = known_ranges(device, around)
        even = ranges.least == ranges.greatest
        for low, high in asked.plateaus:
            even |= ~_leaves(known_ranges(device, moved), Within(moved, low, high))
        if not _share(even, near) > LEAST_EVEN:
            return None
    return even


def _share(flags: npt.NDArray[np.bool_], among: npt.NDArray[np.bool_]) -> float:
    """Share of the flags that are up among some."""
    return int(np.count_nonzero(flags & among)) / max(int(np.count_nonzero(among)), 1)


def make_leaps(device: Device, near: npt.NDArray[np.bool_], even: npt.NDArray[np.bool_] | None = None) -> Leaps:
    """Leaps over blocks, on the device, and where there is something.

    Of even blocks with something in them, numbers above ``MOST_LEAP`` tell how far those of the same medium reach: neighbours
    share the values at their faces.
    """
    distances, share = leaps(near), 0.0
    if even is not None:
        share = _share(even, near)
        distances += np.where(near & even, MOST_LEAP + leaps(~even), 0).astype(np.uint8)
    active, side = near, BLOCK_VOXELS
    while np.count_nonzero(active) > MOST_GROUPS:
        for before in ((), (slice(None),), (slice(None), slice(None))):
            pairs, others = active[(*before, slice(0, None, 2))].copy(), active[(*before, slice(1, None, 2))]
            pairs[(*before, slice(0, others.shape[len(before)]))] |= others
            active = pairs
        side *= 2
    return Leaps(upload_blocks(device, distances, "r8uint"), float(near.mean()), share, np.argwhere(active)[:, ::-1], side)


def upload_blocks(device: Device, texels: AnyArray, texel_format: str) -> Any:
    """Put a number for each block (z, y, x) into a 3-D texture."""
    z, y, x = texels.shape[:3]
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.gpu.create_texture(size=(x, y, z), dimension="3d", format=texel_format, usage=usage)
    layout = {"bytes_per_row": texels[0, 0].nbytes, "rows_per_image": y}
    device.queue.write_texture({"texture": texture}, np.ascontiguousarray(texels), layout, (x, y, z))
    return texture
