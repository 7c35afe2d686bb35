"""The bytes of one array of a VTK XML file: plain or base64, whole or in blocks that zlib compressed."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import FileError
from .inflate import check_ratio, inflated
from .samples import AnyArray, check_size, native


@dataclass(frozen=True)
class VtkFile:
    """What every array of a file needs to be read."""

    where: str
    data: bytes  # all of the file
    appended: int  # first byte behind the underscore of AppendedData, 0 without
    encoding: str
    order: str
    header: np.dtype[Any]
    compressed: bool


class Plain:
    """Bytes taken from the front, as they are."""

    def __init__(self, data: memoryview, where: str) -> None:
        self.data, self.where, self.at = data, where, 0

    def take(self, count: int) -> memoryview:
        """The next ``count`` bytes, or an error if there are fewer."""
        if count > len(self.data) - self.at:
            raise FileError(self.where, "is cut short: its data ends early", "fetch or write the file again")
        self.at += count
        return self.data[self.at - count : self.at]

    def close_header(self, always: bool) -> None:
        """Go to where the data begins."""


class Base64(Plain):
    """Bytes taken from base64 text, of which header and data may be encoded apart, each with its own padding."""

    taken = 0  # bytes since ``at``, which stands at a whole group of four letters

    def take(self, count: int) -> memoryview:
        """The next ``count`` bytes, or an error if there are fewer."""
        skipped, inside = divmod(self.taken, 3)
        start = self.at + 4 * skipped
        text = self.data[start : start + 4 * -(-(inside + count) // 3)]
        try:
            decoded = base64.b64decode(text, validate=True)
        except binascii.Error as error:
            raise FileError(self.where, f"holds damaged base64 ({error})", "fetch or write the file again") from error
        if len(decoded) < inside + count:
            raise FileError(self.where, "is cut short: its data ends early", "fetch or write the file again")
        self.taken += count
        return memoryview(decoded)[inside : inside + count]

    def close_header(self, always: bool) -> None:
        """Go to the next whole group if what follows was encoded by itself: some writers do so ``always``, some pad."""
        end = self.at + 4 * -(-self.taken // 3)
        if always or bytes(self.data[end - 1 : end]) == b"=":
            self.at, self.taken = end, 0


def decoded(source: Plain, needed: int, dtype: np.dtype[Any], shape: tuple[int, ...], where: str, file: VtkFile) -> AnyArray:
    """The array that ``source`` stands at; the sizes that precede it must agree with ``needed`` bytes."""
    width = file.header.itemsize
    if not file.compressed:
        declared = int(np.frombuffer(source.take(width), file.header)[0])
        check_size(where, declared, needed)
        source.close_header(always=False)
        return np.frombuffer(source.take(needed), dtype).astype(dtype.newbyteorder("=")).reshape(shape)
    blocks, size, last = (int(n) for n in np.frombuffer(source.take(3 * width), file.header))
    full = blocks - 1 if last else blocks
    if blocks > needed or full * size + last != needed:
        raise FileError(where, f"declares {full * size + last:,} bytes where {needed:,} are needed", "mend or rewrite it")
    packed = np.frombuffer(source.take(blocks * width), file.header).tolist()
    source.close_header(always=True)
    check_ratio(where, needed, sum(packed), "zlib")
    data = np.empty(needed, dtype=np.uint8)
    for block, length in enumerate(packed):
        count = size if block < full else last
        data[block * size : block * size + count] = np.frombuffer(inflated(source.take(length), "zlib", count, where), np.uint8)
    return native(data.view(dtype)).reshape(shape)
