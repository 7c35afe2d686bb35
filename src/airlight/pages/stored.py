"""The volume that a page carries: means over boxes of voxels, in 8 or 16 bits, and what that costs."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError, LimitError, ValueRangeError
from ..gpu.textures import Encoding, Progress, choose_encoding, encode
from ..reconstruction.levels import averaged
from ..scene import Layer
from ..transfer.given import whole
from ..volume import Volume, statistics
from .device import PageDevice

MOST_VOXELS = 512  # along an axis
BITS = (8, 16)


@dataclass(frozen=True, eq=False)
class Stored:
    """A volume as a page draws it.

    ``volume`` holds the values that the page's texels stand for; ``texels`` (z, y, x) are uint8 or float16. Each is the mean of
    ``factors`` (x, y, z) voxels of the original, no whole numbers; ``error`` bounds what the bits cost it, in data units.
    """

    volume: Volume
    texels: npt.NDArray[Any]
    encoding: Encoding
    factors: tuple[float, float, float]

    @property
    def error(self) -> float:
        """Bound of the quantisation, in data units."""
        return self.encoding.error

    @property
    def bits(self) -> int:
        """Bits of a texel."""
        return 8 * self.texels.itemsize

    def packed(self) -> bytes:
        """Texels for a page: all low bytes before all high ones, deflated without a header."""
        places = self.texels.astype(self.texels.dtype.newbyteorder("<")).view(np.uint8).reshape(-1, self.texels.itemsize).T
        packer = zlib.compressobj(6, zlib.DEFLATED, -15)
        return packer.compress(places.tobytes()) + packer.flush()


def store(layer: Layer, voxels: int | None, bits: int | None, progress: Progress) -> Stored:
    """Make what a page carries of a layer's channel and time step.

    Parameters
    ----------
    voxels
        Most voxels along an axis; None keeps all.
    bits
        8 or 16 of a texel; None takes 8 where they hold all samples, else 16.

    Raises
    ------
    ValueRangeError
        For other numbers of bits or voxels.
    DataError
        When some samples are empty: their mark needs 32 bits.
    LimitError
        When the volume is larger than a page may be.
    """
    if bits is not None and bits not in BITS:
        raise ValueRangeError("bits", f"is {bits}, must be 8 or 16")
    voxels = None if voxels is None else whole(voxels, "voxels", 2, MOST_VOXELS)
    volume, channel = layer.volume, layer.channels[0]
    if statistics(volume, channel, layer.time).empty:
        what = "has empty samples (NaN or the file's no-data value), whose mark a page has no bits for"
        raise DataError("volume", what, "put a value in their place, e.g. airlight.Volume(numpy.nan_to_num(volume.array))")
    if voxels is None and max(volume.size) > MOST_VOXELS:
        what = f"has {' x '.join(map(str, volume.size))} voxels, a page carries at most {MOST_VOXELS} a side"
        raise LimitError("volume", what, f"give voxels={MOST_VOXELS} or less")
    size = stored_size(volume, voxels)
    samples = volume.grid(channel, layer.time)
    if size != volume.size:
        samples = averaged(samples, size[::-1], lambda done, total: progress("down-sample", done, total))
    elif samples.dtype.kind == "b" or (bits == 16 and samples.dtype.itemsize == 1):
        samples = samples.astype(np.uint8 if bits != 16 else np.int16)
    low, high = float(samples.min()), float(samples.max())
    encoding = _encoding(samples.dtype, low, high, bits)
    texels = _codes(samples, encoding) if encoding.dtype == "u1" else encode(samples, encoding)
    x, y, z = (n / m for n, m in zip(volume.size, size, strict=True))
    return Stored(_volume_of(volume, decoded(texels, encoding), (x, y, z)), texels, encoding, (x, y, z))


def stored_size(volume: Volume, voxels: int | None) -> tuple[int, int, int]:
    """Voxels (x, y, z) of which the longest side has so many, as wide as high as far as the volume's own are no larger."""
    if voxels is None or max(volume.size) <= voxels:
        return volume.size
    longest = max(n * width for n, width in zip(volume.size, volume.spacing, strict=True))
    x, y, z = (
        min(n, voxels, max(1, math.ceil(voxels * n * width / longest - 1e-6)))
        for n, width in zip(volume.size, volume.spacing, strict=True)
    )
    return x, y, z


def _encoding(dtype: np.dtype[Any], low: float, high: float, bits: int | None) -> Encoding:
    whole = dtype.kind in "iu" and high - low <= 255
    if bits == 8 or (bits is None and whole):
        scale = 255.0 if whole else (high - low) or 1.0
        return Encoding("r8unorm", "u1", scale, low, 0.0 if whole else scale / 510)
    device: Any = PageDevice(Encoding("", "", 1.0, 0.0))
    return choose_encoding(dtype, low, high, filtered=True, device=device)


def _codes(samples: npt.NDArray[Any], encoding: Encoding) -> npt.NDArray[np.uint8]:
    shares = (samples.astype(np.float32) - np.float32(encoding.offset)) * np.float32(255 / encoding.scale)
    return np.asarray(np.rint(np.clip(shares, 0, 255)), dtype=np.uint8)


def decoded(texels: npt.NDArray[Any], encoding: Encoding) -> npt.NDArray[np.float32]:
    """Values that texels stand for."""
    unit = np.float32(255 if encoding.dtype == "u1" else 1)
    return np.asarray(texels.astype(np.float32) / unit * np.float32(encoding.scale) + np.float32(encoding.offset))


def _volume_of(volume: Volume, values: npt.NDArray[np.float32], factors: tuple[float, float, float]) -> Volume:
    """Values with the place of the volume that they are means of: the first lies in the middle of its box."""
    index_from_box = np.diag([*map(float, factors), 1.0])
    index_from_box[:3, 3] = [0.5 * (factor - 1) for factor in factors]
    world_from_index = volume.world_from_index @ index_from_box
    return Volume(values, world_from_index=world_from_index, units=volume.units, value_unit=volume.value_unit)
