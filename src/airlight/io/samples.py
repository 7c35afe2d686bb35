"""Samples out of a file: exactly as many bytes as declared, in pieces, with progress, never more than allowed."""

from __future__ import annotations

import contextlib
import io
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ..errors import DataError, FileError
from .inflate import Inflating, check_ratio
from .messages import shown
from .options import ReadOptions

AnyArray = npt.NDArray[Any]

PIECE_BYTES = 8 << 20  # between two reports of progress
TEXT_PIECE_BYTES = 1 << 20
GAP = re.compile(rb"[\s,]")
LONGEST_AXIS = 1 << 31


def load(
    path: Path,
    dtype: np.dtype[Any],
    shape: Sequence[int],
    options: ReadOptions,
    *,
    codec: str = "",
    offset: int = 0,
    skip: int = 0,
) -> AnyArray:
    """Array of ``shape`` (C order) that begins ``offset`` bytes into the file and, inflated, after ``skip`` bytes more.

    The file must end with it. The result has native byte order.
    """
    where = str(path)
    needed = byte_count(where, dtype, shape, options)
    available = path.stat().st_size - offset
    if codec:
        check_ratio(where, needed + skip, max(available, 0), codec)
    else:
        check_size(where, available - skip, needed)
    with stream(path, codec, offset) as source:
        skip_bytes(source, skip, where)
        array = read_array(source, dtype, shape, where, options)
        if source.read(1):
            raise FileError(where, f"holds more samples than the {needed:,} bytes that it declares", "mend its header")
    return array


def codec_of(path: Path) -> str:
    """Codec that the first bytes of a file tell; empty for none."""
    with path.open("rb") as file:
        magic = file.read(3)
    return "gzip" if magic[:2] == b"\x1f\x8b" else "bz2" if magic == b"BZh" else ""


@contextlib.contextmanager
def stream(path: Path, codec: str = "", offset: int = 0) -> Iterator[io.RawIOBase]:
    """The bytes of a file from ``offset`` on, inflated if ``codec`` is given."""
    with path.open("rb", buffering=0) as file:
        file.seek(offset)
        yield Inflating(cast(Any, file), codec, str(path)) if codec else file


def skip_bytes(source: io.RawIOBase, count: int, where: str) -> None:
    """Read over ``count`` bytes."""
    while count > 0:
        piece = source.read(min(count, 1 << 20))
        if not piece:
            raise FileError(where, "is cut short before its samples", "fetch or write the file again")
        count -= len(piece)


def read_array(source: io.RawIOBase, dtype: np.dtype[Any], shape: Sequence[int], where: str, options: ReadOptions) -> AnyArray:
    """Array from a stream that may go on behind it."""
    count = math.prod(shape)
    array = np.empty(count, dtype=dtype)
    view = array.view(np.uint8).data
    total = len(view)
    done = 0
    while done < total:
        got = source.readinto(view[done : done + PIECE_BYTES])
        if not got:
            raise FileError(
                where, f"is cut short: {done:,} bytes of samples of {total:,} declared", "fetch or write the file again"
            )
        done += got
        options.progress(f"reading {Path(where).name}", done, total)
    return native(array).reshape(tuple(shape))


def byte_count(where: str, dtype: np.dtype[Any], shape: Sequence[int], options: ReadOptions) -> int:
    """Bytes that an array takes, once shape and size are found to be possible and allowed."""
    if not shape or any(not 0 < n < LONGEST_AXIS for n in shape):
        raise FileError(where, f"declares the size {' x '.join(str(n) for n in reversed(shape))}", "mend its header")
    needed = math.prod(int(n) for n in shape) * dtype.itemsize
    options.check_bytes(where, needed)
    return needed


def check_size(where: str, available: int, needed: int) -> None:
    """Refuse samples of another number of bytes than declared."""
    if available != needed:
        short = "the file is cut short or its header is wrong" if available < needed else "its header is wrong"
        raise FileError(where, f"has {max(available, 0):,} bytes of samples where {needed:,} are declared", short)


def native(array: AnyArray) -> AnyArray:
    """The array in native byte order, swapped in place."""
    if array.dtype.isnative:
        return array
    return array.byteswap(inplace=True).view(array.dtype.newbyteorder("="))


def parse_text(text: bytes, dtype: np.dtype[Any], shape: Sequence[int], where: str) -> AnyArray:
    """Array out of numbers in text, split by white space or commas; in pieces, since words take more room than text."""
    array = np.empty(math.prod(shape), dtype=dtype)
    done = at = 0
    while at < len(text):
        gap = GAP.search(text, at + TEXT_PIECE_BYTES)
        end = gap.start() if gap else len(text)
        words = text[at:end].replace(b",", b" ").split()
        if done + len(words) > len(array):
            raise FileError(where, f"has more numbers than the {len(array):,} declared", "mend its header")
        array[done : done + len(words)] = _numbers(words, dtype, where)
        done, at = done + len(words), end
    if done < len(array):
        raise FileError(where, f"has {done:,} numbers where {len(array):,} are declared", "mend its header")
    return array.reshape(tuple(shape))


def _numbers(words: list[bytes], dtype: np.dtype[Any], where: str) -> AnyArray:
    try:
        if dtype.kind != "f":
            return np.array([int(word) for word in words], dtype=dtype)
        with np.errstate(over="raise"):
            return np.array([float(word) for word in words], dtype=np.float64).astype(dtype)
    except (ValueError, OverflowError, FloatingPointError) as error:
        raise FileError(where, f"holds text that is no {dtype} ({str(error)[:80]})", "mend the file") from error


def scaled(array: AnyArray, slope: float, intercept: float, where: str, options: ReadOptions) -> AnyArray:
    """``array * slope + intercept``; integers stay integers where both numbers are whole and 64 bits hold the result."""
    if slope == 1 and intercept == 0:
        return array
    if not (math.isfinite(slope) and math.isfinite(intercept)):
        raise FileError(where, f"scales its samples by {slope} and {intercept}", "mend its header")
    if array.dtype.kind == "b":
        array = array.view(np.uint8)
    whole = _whole_type(array, slope, intercept)
    wide = array.dtype.itemsize > 4 or (array.dtype.itemsize == 4 and array.dtype.kind in "iu")
    kind = np.float64 if wide else np.float32
    options.check_bytes(where, array.nbytes + array.size * (whole or np.dtype(kind)).itemsize)
    if whole is not None:
        return _scaled_whole(array, int(slope), int(intercept), whole)
    result: AnyArray = array.astype(kind)
    np.multiply(result, kind(slope), out=result)
    return np.add(result, kind(intercept), out=result)


def _whole_type(array: AnyArray, slope: float, intercept: float) -> np.dtype[Any] | None:
    """The narrowest integer type, not narrower than the array's, that holds the scaled values; None if none does."""
    if array.dtype.kind not in "iu" or not float(slope).is_integer() or not float(intercept).is_integer():
        return None
    ends = [int(end) * int(slope) + int(intercept) for end in (array.min(), array.max())]
    for kind in (array.dtype.type, np.int16, np.int32, np.int64):
        info = np.iinfo(kind)
        if min(ends) >= info.min and max(ends) <= info.max and info.bits >= array.dtype.itemsize * 8:
            return np.dtype(kind)
    return None


def _scaled_whole(array: AnyArray, slope: int, intercept: int, dtype: np.dtype[Any]) -> AnyArray:
    # Two's complement wraps to the right result, which is known to fit, though factor, term or steps between may not.
    bits = dtype.itemsize * 8
    unsigned = np.dtype(f"u{dtype.itemsize}")
    result = array.astype(dtype).view(unsigned)
    np.multiply(result, unsigned.type(slope % (1 << bits)), out=result)
    np.add(result, unsigned.type(intercept % (1 << bits)), out=result)
    return result.view(dtype)


def check_kind(where: str, dtype: np.dtype[Any]) -> None:
    """Refuse complex and other samples that no volume can have."""
    if dtype.kind == "c":
        raise DataError(where, f"is complex ({dtype})", "write abs(array) or np.angle(array) into a file")
    if dtype.kind not in "biuf" or dtype.itemsize > 8:
        raise DataError(where, f"has samples of type {shown(dtype)}", "use bool, integers, float16, float32 or float64")
