"""Writing NRRD: everything that a volume knows, in fields of the format or in keys of its own."""

from __future__ import annotations

import json
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError
from ..files import replacing
from ..volume import Volume
from .samples import AnyArray

TYPES = {
    "i1": "int8",
    "u1": "uint8",
    "i2": "int16",
    "u2": "uint16",
    "i4": "int32",
    "u4": "uint32",
    "i8": "int64",
    "u8": "uint64",
    "f4": "float",
    "f8": "double",
}


def write(volume: Volume, path: Path) -> None:
    """Write a ``.nrrd`` file, gzip inside; float16 becomes float32, which NRRD has and which loses nothing."""
    if path.suffix.lower() != ".nrrd":
        raise FileError(str(path), "would need two files", "give a name that ends in .nrrd")
    array = volume.array
    stored = array.view(np.uint8) if array.dtype == bool else array
    if stored.dtype == np.float16:
        stored = stored.astype(np.float32)
    compressor = zlib.compressobj(level=4, wbits=31)
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(_header(volume, stored).encode("utf-8"))
        for part in stored.reshape(-1, *stored.shape[-2:]):
            file.write(compressor.compress(np.ascontiguousarray(part).data))
        file.write(compressor.flush())


def _header(volume: Volume, stored: AnyArray) -> str:
    extra = ["none"] * (stored.ndim - 3)
    kinds = ["domain"] * 3 + ["list", "time"][: stored.ndim - 3]
    space = "space: left-posterior-superior" if volume.anatomical else "space dimension: 3"
    matrix = volume.world_from_index
    lines = [
        "NRRD0005",
        f"type: {TYPES[stored.dtype.str[1:]]}",
        f"dimension: {stored.ndim}",
        space,
        f"sizes: {' '.join(str(n) for n in reversed(stored.shape))}",
        f"space directions: {' '.join([_vector(matrix[:3, i]) for i in range(3)] + extra)}",
        f"kinds: {' '.join(kinds)}",
        f"endian: {sys.byteorder}",
        "encoding: gzip",
        f"space origin: {_vector(matrix[:3, 3])}",
    ]
    if volume.units:
        unit = _word(volume.units)
        lines.append(f'space units: "{unit}" "{unit}" "{unit}"')
    if volume.value_unit:
        lines.append(f"sample units: {_word(volume.value_unit)}")
    if volume.array.dtype == bool:
        lines.append("airlight_dtype:=bool")
    for key, value in (("modality", volume.modality), ("time_unit", volume.time_unit), ("no_data", volume.no_data)):
        if value not in ("", None):
            lines.append(f"{key}:={_word(str(value))}")
    for key, values in (("channel_names", volume.channel_names), ("times", volume.times)):
        if values:
            lines.append(f"{key}:={json.dumps(values)}")
    return "\n".join(lines) + "\n\n"


def _vector(values: Any) -> str:
    return "(" + ",".join(repr(float(v)) for v in values) + ")"


def _word(text: str) -> str:
    return " ".join(text.replace('"', "'").split())
