"""Inflating in pieces: nothing grows beyond what was asked for, and no memory is taken for a size that no codec reaches."""

from __future__ import annotations

import bz2
import io
import zlib
from typing import Any, BinaryIO

from ..errors import FileError

GREATEST_RATIO = {"gzip": 1032, "zlib": 1032, "bz2": 1_400_000}
"""What one byte may inflate to at most; deflate: 258 bytes of 2 bits, bzip2: a block of one repeated byte."""

PIECE_BYTES = 1 << 16  # input taken at a time: small, because a stream of tiny members copies the rest of the piece for each
SLACK_BYTES = 1 << 16
MEMBER_MAGIC = {"gzip": b"\x1f\x8b", "bz2": b"BZh"}


class Inflating(io.RawIOBase):
    """The bytes inside a gzip, zlib or bzip2 stream, as a file that is read forwards.

    Parameters
    ----------
    source
        The compressed bytes, standing at their first.
    codec
        ``"gzip"``, ``"zlib"`` (a zlib or gzip header is told by itself) or ``"bz2"``.
    where
        Name for messages.
    """

    def __init__(self, source: BinaryIO, codec: str, where: str) -> None:
        self._source, self._codec, self._where = source, codec, where
        self._engine: Any = _engine(codec)
        self._input = b""
        self._ended = False

    def readable(self) -> bool:
        """Always true."""
        return True

    def readinto(self, target: Any) -> int:
        """Fill ``target`` as far as the stream reaches and return how many bytes that were."""
        view = memoryview(target).cast("B")
        done = 0
        while done < len(view) and not self._ended:
            piece = self._inflate(len(view) - done)
            view[done : done + len(piece)] = piece
            done += len(piece)
            if self._engine.eof:
                self._next_member()
        return done

    def _inflate(self, room: int) -> bytes:
        data = self._input
        if not data and (self._codec != "bz2" or self._engine.needs_input):
            data = self._source.read(PIECE_BYTES)
        starved = not data
        try:
            piece: bytes = self._engine.decompress(data, room)
        except (zlib.error, OSError, ValueError) as error:
            raise FileError(
                self._where, f"holds damaged {self._codec} data ({error})", "fetch or write the file again"
            ) from error
        self._input = b"" if self._codec == "bz2" else self._engine.unconsumed_tail
        if starved and not piece and not self._engine.eof and (self._codec != "bz2" or self._engine.needs_input):
            raise FileError(self._where, f"is cut short: its {self._codec} data ends early", "fetch or write the file again")
        return piece

    def _next_member(self) -> None:
        rest = self._engine.unused_data.lstrip(b"\0")  # gzip files may be padded with zeros
        while not rest:
            more = self._source.read(PIECE_BYTES)
            if not more:
                self._ended = True
                return
            rest = more.lstrip(b"\0")
        magic = MEMBER_MAGIC.get(self._codec, b"")
        if len(rest) < len(magic):
            rest += self._source.read(PIECE_BYTES)
        if not magic or not rest.startswith(magic):
            raise FileError(self._where, f"goes on after the end of its {self._codec} data", "fetch or write the file again")
        self._engine, self._input = _engine(self._codec), rest


def check_ratio(where: str, declared: int, compressed: int, codec: str) -> None:
    """Refuse a declared size that ``compressed`` bytes cannot inflate to, before memory is taken for it."""
    if declared > compressed * GREATEST_RATIO[codec] + SLACK_BYTES:
        raise FileError(
            where,
            f"declares {declared:,} bytes of samples, more than {compressed:,} bytes of {codec} can hold",
            "the file is cut short or its header is wrong",
        )


def inflated(data: bytes | memoryview, codec: str, size: int, where: str) -> bytes:
    """Exactly ``size`` bytes out of ``data``; anything else is refused."""
    check_ratio(where, size, len(data), codec)
    stream = Inflating(io.BytesIO(data), codec, where)
    target = bytearray(size)
    done = stream.readinto(target)
    if done != size or stream.read(1):
        raise FileError(where, f"inflates to another size than the {size:,} bytes that it declares", "the file is damaged")
    return bytes(target)


def _engine(codec: str) -> Any:
    return bz2.BZ2Decompressor() if codec == "bz2" else zlib.decompressobj({"gzip": 31, "zlib": 47}[codec])
