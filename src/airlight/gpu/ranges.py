"""Blocks of voxels: the least and the greatest sample of each, by NumPy straight from the array.

Slowest axis first, so that rows stay in one piece, and a few slices at a time, so that they stay in the processor's caches.
What is left to do along the other axes is a quarter, then a sixteenth. Ends of ranges become texels and values again as all
samples do, which keeps their order; the samples themselves are never converted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..labels import LabelNumbers
from ..stage import BLOCK_VOXELS, BlockRanges
from ..volume import AnyArray, is_empty
from .device import Device
from .textures import Encoding, encode, encodings_of

GREATEST = 1e38  # of what 32-bit floats hold beside marked samples
CHUNK_BYTES = 2 << 20


@dataclass(frozen=True, eq=False)
class Ranges:
    """Least and greatest sample of each block, both (z, y, x); where there is none the least is above the greatest."""

    least: AnyArray
    greatest: AnyArray

    @property
    def bytes(self) -> int:
        """Bytes on the host."""
        return self.least.nbytes + self.greatest.nbytes


def sample_ranges(device: Device, asked: BlockRanges) -> Ranges:
    """Ranges of the samples of a grid's channel as the device holds them, without what the field overshoots."""
    grid, channel = asked.grid, asked.grid.channels[asked.place]
    samples = grid.volume.grid(channel, grid.time)
    found = block_ranges(samples, asked.reach, grid.volume.no_data if grid.masked else None, grid.masked)
    encoding = encodings_of(device, grid)[asked.place]
    return Ranges(*(as_held(ends, encoding, grid.masked) for ends in (found.least, found.greatest)))


def block_ranges(samples: AnyArray, reach: int = 0, no_data: float | None = None, has_empty: bool = False) -> Ranges:
    """Ranges of samples (z, y, x) in blocks of ``BLOCK_VOXELS`` a side, with those at their faces and up to ``reach`` beyond.

    Empty samples are left out where there are any.
    """
    samples = samples.view(np.uint8) if samples.dtype == bool else samples
    depth, count = len(samples), block_count(len(samples))
    least, greatest = (np.empty([block_count(n) for n in samples.shape], samples.dtype) for _ in range(2))
    layers = max(1, CHUNK_BYTES // (BLOCK_VOXELS * max(1, samples[0].nbytes)))
    for first in range(0, count, layers):
        last = min(first + layers, count)
        low, high = max(first * BLOCK_VOXELS - reach, 0), min(last * BLOCK_VOXELS + reach + 1, depth)
        part = samples[low:high]
        mask = is_empty(part, no_data) if has_empty else None
        for target, reduce, others in ((least, np.minimum, _greatest), (greatest, np.maximum, _least)):
            known = part if mask is None else np.where(mask, others(part.dtype), part)
            begins = [z * BLOCK_VOXELS - low for z in range(first, last)]
            slices = [known[max(z - reach, 0) : z + BLOCK_VOXELS + reach + 1] for z in begins]
            rows = np.stack([reduce.reduce(one, axis=0) for one in slices])
            target[first:last] = _along(_along(rows, 1, reach, reduce), 2, reach, reduce)
    return Ranges(least, greatest)


def block_count(voxels: int) -> int:
    """How many blocks there are along an axis; neighbours share the voxels at their faces."""
    return max(1, -(-(voxels - 1) // BLOCK_VOXELS))


def _along(samples: AnyArray, axis: int, reach: int, reduce: np.ufunc) -> AnyArray:
    """Least or greatest sample of blocks along an axis."""
    line = np.moveaxis(samples, axis, 0)
    count = block_count(len(line))
    found = line[: count * BLOCK_VOXELS : BLOCK_VOXELS].copy()
    for offset in range(-reach, BLOCK_VOXELS + reach + 1):
        # The blocks of which the sample at this offset from their first one is there.
        first, last = max(0, -(offset // BLOCK_VOXELS)), min(count, (len(line) - 1 - offset) // BLOCK_VOXELS + 1)
        if offset and first < last:
            begin = first * BLOCK_VOXELS + offset
            others = line[begin : begin + (last - first - 1) * BLOCK_VOXELS + 1 : BLOCK_VOXELS]
            reduce(found[first:last], others, out=found[first:last])
    return np.moveaxis(found, 0, axis)


def _least(dtype: np.dtype[Any]) -> Any:
    return -np.inf if dtype.kind == "f" else np.iinfo(dtype).min


def _greatest(dtype: np.dtype[Any]) -> Any:
    return np.inf if dtype.kind == "f" else np.iinfo(dtype).max


def as_held(samples: AnyArray, encoding: Encoding, masked: bool = False) -> AnyArray:
    """Samples as they come back from texels; those that come back as they were stay as they are."""
    if encoding.error == 0.0:
        return samples
    if masked:
        return np.clip(samples, -GREATEST, GREATEST).astype(np.float32)
    texels = encode(samples, encoding).astype(np.float32)
    return np.asarray(texels * np.float32(encoding.scale) + np.float32(encoding.offset))


def label_ranges(numbers: LabelNumbers, reach: int) -> Ranges:
    """Ranges of labels as places among those that occur, in rising order; what lies outside of the volume is background."""
    samples = numbers.volume.grid(0, numbers.time)
    found = block_ranges(samples, reach)
    ids = np.sort(numbers.ids)
    kind = np.min_scalar_type(len(ids) - 1)
    ranks = Ranges(*(np.searchsorted(ids, ends.astype(ids.dtype)).astype(kind) for ends in (found.least, found.greatest)))
    background = kind.type(np.searchsorted(ids, numbers.ids[0]))
    for axis, voxels in enumerate(samples.shape):
        begin = np.arange(block_count(voxels)) * BLOCK_VOXELS
        outer = (begin - reach <= 0) | (begin + BLOCK_VOXELS + reach >= voxels - 1)
        for ends, reduce in ((ranks.least, np.minimum), (ranks.greatest, np.maximum)):
            line = np.moveaxis(ends, axis, 0)
            line[outer] = reduce(line[outer], background)
    return ranks


def label_shares(ranks: Ranges, drawn: bytes) -> Ranges:
    """Least and greatest share, 0 or 1, that drawn labels take in blocks with labels from the least to the greatest."""
    before = np.concatenate([[0], np.cumsum(np.frombuffer(drawn, dtype=np.uint8))]).astype(np.int32)
    seen = before[1:][ranks.greatest] - before[:-1][ranks.least]
    wide = ranks.greatest - ranks.least
    return Ranges((seen > wide).view(np.uint8), (seen > 0).view(np.uint8))
