"""NRRD: ``.nrrd``, and ``.nhdr`` beside its data. pynrrd parses the header; the samples are read here, bounded."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError
from ..volume import Source, Volume, unmistakable
from .messages import brief, shown
from .nrrd_axes import axes_of
from .nrrd_write import write
from .options import ReadOptions
from .paths import detached, numbered
from .samples import AnyArray, byte_count, check_size, load, parse_text
from .units import unit_name

__all__ = ["read", "write"]

MAX_HEADER_BYTES = 1 << 20
CODECS = {"raw": "", "gzip": "gzip", "gz": "gzip", "bzip2": "bz2", "bz2": "bz2"}
TEXT = {"text", "txt", "ascii"}
TYPES = {
    "i1": ("signed char", "int8", "int8_t"),
    "u1": ("uchar", "unsigned char", "uint8", "uint8_t"),
    "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
    "u2": ("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"),
    "i4": ("int", "signed int", "int32", "int32_t"),
    "u4": ("uint", "unsigned int", "uint32", "uint32_t"),
    "i8": ("longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"),
    "u8": ("ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"),
    "f4": ("float",),
    "f8": ("double",),
}
DTYPES = {name: dtype for dtype, names in TYPES.items() for name in names}
MODALITIES = {"CT": "CT", "MR": "MR", "DWMRI": "MR", "PT": "PT", "US": "US"}


def read(path: Path, options: ReadOptions) -> Volume:
    """Volume in a NRRD file; ``space directions`` become patient LPS where the file names an anatomical space."""
    lines, data_start = _header_lines(path)
    fields = _parse(path, lines)
    axes = axes_of(fields, str(path))
    array = axes.arrange(_samples(path, fields, axes.file_shape, lines, data_start, options))
    if array.dtype.itemsize == 1 and str(fields.get("airlight_dtype")) == "bool":
        array = array.view(np.bool_)
    names = _listed(fields, "channel_names") or axes.channel_names
    times = _listed(fields, "times") or axes.times
    return Volume(
        unmistakable(array),
        world_from_index=axes.world_from_index,
        units=axes.units,
        value_unit=str(fields.get("sample units", fields.get("sampleunits", ""))).strip().strip('"'),
        channel_names=names if len(names) == axes.channel_count else (),
        times=times if len(times) == axes.time_count else (),
        time_unit=unit_name(str(fields.get("time_unit", axes.time_unit))),
        no_data=_number(fields.get("no_data")),
        anatomical=axes.anatomical,
        modality=_modality(fields),
        name=path.name,
        source=Source(str(path)),
    )


def _header_lines(path: Path) -> tuple[list[str], int]:
    """Lines of the header, and the byte behind it."""
    with path.open("rb") as file:
        head = file.read(MAX_HEADER_BYTES)
    if not head.startswith(b"NRRD000"):
        raise FileError(str(path), "is no NRRD file: it does not begin with NRRD000", "check its name and kind")
    lines: list[str] = []
    at = 0
    while at < len(head):
        end = head.find(b"\n", at)
        end = len(head) if end < 0 else end
        line = head[at:end].decode("utf-8", "replace").rstrip()
        at = end + 1
        if not line:
            return lines, at
        lines.append(line)
    if len(head) == MAX_HEADER_BYTES:
        raise FileError(str(path), f"has a header of more than {MAX_HEADER_BYTES:,} bytes", "the file is damaged")
    return lines, len(head)


def _parse(path: Path, lines: list[str]) -> Mapping[str, Any]:
    import nrrd

    for number, line in enumerate(lines[1:], start=2):
        if not line.startswith("#") and ":" not in line:
            raise FileError(f"{path}:{number}", f"has no colon: {shown(line)}", "mend the header")
        key, _, value = line.partition(":")
        if key in ("sizes", "dimension") and not all(word.isdecimal() and len(word) < 19 for word in value.split()):
            raise FileError(f"{path}: {key}", f"is {shown(value.strip())}", "write whole numbers")
        if line.replace(" ", "").lower().startswith("datafile:list"):
            lines = lines[:number]  # the lines behind it are names of files
            break
    fields = dict(nrrd.read_header([line + "\n" for line in lines]))
    for key in ("type", "dimension", "sizes", "encoding"):
        if key not in fields:
            raise FileError(str(path), f"has no {key!r} in its header", "add it")
    return fields


def _dtype(path: Path, fields: Mapping[str, Any]) -> np.dtype[Any]:
    name = str(fields["type"]).strip()
    if name not in DTYPES:
        raise FileError(f"{path}: type", f"is {shown(name)}", f"write one of {', '.join(sorted(DTYPES))}")
    dtype = np.dtype(DTYPES[name])
    if dtype.itemsize == 1 or str(fields["encoding"]).lower() in TEXT:
        return dtype
    order = str(fields.get("endian", ""))
    if order not in ("little", "big"):
        raise FileError(f"{path}: endian", f"is {shown(order)}", "write little or big")
    return dtype.newbyteorder("<" if order == "little" else ">")


def _samples(
    path: Path, fields: Mapping[str, Any], shape: tuple[int, ...], lines: list[str], data_start: int, options: ReadOptions
) -> AnyArray:
    dtype = _dtype(path, fields)
    byte_count(str(path), dtype, shape, options)
    encoding = str(fields["encoding"]).lower()
    line_skip = int(fields.get("line skip", fields.get("lineskip", 0)))
    byte_skip = int(fields.get("byte skip", fields.get("byteskip", 0)))
    if line_skip < 0 or byte_skip < -1:
        raise FileError(str(path), f"skips {line_skip} lines and {byte_skip} bytes", "mend its header")
    name = fields.get("data file", fields.get("datafile"))
    if name is None:
        parts = [_Part(path, data_start)]
    else:
        parts = [_Part(detached(path, each, "data file"), 0) for each in _file_names(str(name), lines, shape[0])]
    if len(parts) > 1 and shape[0] % len(parts):
        raise FileError(f"{path}: data file", f"lists {len(parts)} files for {shape[0]} slices", "list one a slice")
    part_shape = (shape[0] // len(parts), *shape[1:])
    if len(parts) == 1:
        return _part(parts[0], dtype, shape, encoding, line_skip, byte_skip, options)
    array = np.empty(shape, dtype.newbyteorder("="))
    depth = part_shape[0]
    for number, part in enumerate(parts):
        piece = _part(part, dtype, part_shape, encoding, line_skip, byte_skip, options)
        array[number * depth : (number + 1) * depth] = piece
    return array


@dataclass(frozen=True)
class _Part:
    path: Path
    offset: int


def _part(
    part: _Part,
    dtype: np.dtype[Any],
    shape: tuple[int, ...],
    encoding: str,
    line_skip: int,
    byte_skip: int,
    options: ReadOptions,
) -> AnyArray:
    where = str(part.path)
    if encoding in CODECS:
        codec, offset = CODECS[encoding], part.offset
        if line_skip:  # lines are skipped before, bytes after inflating
            with part.path.open("rb") as file:
                file.seek(offset)
                for _ in range(line_skip):
                    if not file.readline(MAX_HEADER_BYTES):
                        raise FileError(where, f"ends within the {line_skip} lines to skip", "mend its header")
                offset = file.tell()
        if byte_skip < 0 and not codec:
            offset, byte_skip = part.path.stat().st_size - math.prod(shape) * dtype.itemsize, 0
            if offset < part.offset:
                check_size(where, part.path.stat().st_size - part.offset, math.prod(shape) * dtype.itemsize)
        if byte_skip < 0:
            raise FileError(where, "skips -1 bytes of compressed data", "give the number of bytes")
        return load(part.path, dtype, shape, options, codec=codec, offset=offset, skip=byte_skip)
    if encoding in TEXT or encoding == "hex":
        options.check_bytes(where, part.path.stat().st_size)
        text = part.path.read_bytes()[part.offset :]
        text = b"\n".join(text.split(b"\n")[line_skip:])[max(byte_skip, 0) :]
        if encoding != "hex":
            return parse_text(text, dtype, shape, where)
        try:
            data = bytes.fromhex(text.decode("ascii"))
        except ValueError as error:
            raise FileError(where, f"holds text that is no hex ({brief(error)})", "mend the file") from error
        check_size(where, len(data), math.prod(shape) * dtype.itemsize)
        swapped = np.frombuffer(data, dtype).reshape(shape)
        return swapped.astype(dtype.newbyteorder("="))
    raise FileError(f"{where}: encoding", f"is {shown(encoding)}", "write it again as raw, gzip, bzip2, text or hex")


def _file_names(value: str, lines: list[str], slices: int) -> list[str]:
    """Names out of ``NAME``, ``PATTERN FIRST LAST STEP [SUBDIM]`` or ``LIST [SUBDIM]`` with the names in lines of their own."""
    words = value.split()
    if words and words[0] == "LIST":
        start = next(i for i, line in enumerate(lines) if line.replace(" ", "").lower().startswith("datafile:list"))
        return [line.strip() for line in lines[start + 1 :]] or [""]
    if len(words) >= 4 and "%" in words[0]:
        first, last, step = (int(word) for word in words[1:4])
        numbers = range(first, last + (1 if step > 0 else -1), step)
        if not 0 < len(numbers) <= max(slices, 1):
            raise FileError("data file", f"lists {len(numbers)} files for {slices} slices", "mend the header")
        return [numbered(words[0], number, "data file") for number in numbers]
    return [value]


def _listed(fields: Mapping[str, Any], key: str) -> tuple[Any, ...]:
    try:
        value = json.loads(str(fields.get(key, "[]")))
    except (ValueError, RecursionError):
        return ()
    return tuple(value) if isinstance(value, list) else ()


def _number(value: Any) -> float | None:
    try:
        return None if value is None else float(value)
    except ValueError:
        return None


def _modality(fields: Mapping[str, Any]) -> str:
    for key, value in fields.items():
        if key.lower() in ("modality", "0008|0060", "dicom_0008_0060_modality"):
            return MODALITIES.get(str(value).strip().upper(), str(value).strip() if key == "modality" else "")
    return ""
