"""Raw samples: a file of nothing else, whose shape the caller gives, or that a classical ``.dat`` header describes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from ..volume import Source, Volume, affine, unmistakable
from .messages import shown
from .options import ReadOptions
from .paths import detached
from .samples import check_kind, load

MAX_HEADER_BYTES = 1 << 16
FORMATS = {
    "UCHAR": "u1",
    "CHAR": "i1",
    "BYTE": "u1",
    "USHORT": "u2",
    "SHORT": "i2",
    "USHORT_12": "u2",
    "UINT": "u4",
    "INT": "i4",
    "HALF": "f2",
    "FLOAT": "f4",
    "DOUBLE": "f8",
    "UINT8": "u1",
    "UINT16": "u2",
    "UINT32": "u4",
    "INT8": "i1",
    "INT16": "i2",
    "INT32": "i4",
    "FLOAT32": "f4",
    "FLOAT64": "f8",
}
MODELS = {"I": 1, "LA": 2, "XY": 2, "RGB": 3, "XYZ": 3, "RGBA": 4, "XYZW": 4}


def read(path: Path, options: ReadOptions) -> Volume:
    """Volume out of raw samples: of the shape in ``options``, or of a ``.dat`` header."""
    if options.shape_xyz is None:
        return _read_described(path, options)
    shape = tuple(reversed(options.shape_xyz))
    if not 3 <= len(shape) <= 5:
        raise DataError("shape", f"is {options.shape_xyz}", "give it as (x, y, z), (x, y, z, channels) or with times last")
    if options.offset_bytes < 0:
        raise DataError("offset", f"is {options.offset_bytes}, must not be negative")
    dtype = _dtype(options.dtype, options.big_endian)
    array = load(path, dtype, shape, options, offset=options.offset_bytes)
    source = Source(str(path), options=_recipe(options))
    return Volume(unmistakable(array), spacing=options.spacing, name=path.name, source=source)


def _dtype(name: str, big_endian: bool) -> np.dtype[Any]:
    if not name:
        raise DataError("dtype", "is not given", "a raw file needs it, e.g. dtype='uint8'")
    try:
        dtype = np.dtype(name)
    except (TypeError, ValueError) as error:
        raise DataError("dtype", f"is {shown(name)}", "name a NumPy type, e.g. uint8, int16 or float32") from error
    check_kind("dtype", dtype)
    return dtype.newbyteorder(">") if big_endian else dtype.newbyteorder("<") if dtype.isnative else dtype


def _recipe(options: ReadOptions) -> tuple[tuple[str, str], ...]:
    """What must be told again to read the file again."""
    recipe = [("shape", " ".join(str(n) for n in options.shape_xyz or ())), ("dtype", options.dtype)]
    if options.spacing is not None:
        recipe.append(("spacing", " ".join(repr(float(s)) for s in options.spacing)))
    if options.offset_bytes:
        recipe.append(("offset", str(options.offset_bytes)))
    if options.big_endian:
        recipe.append(("big_endian", "true"))
    return tuple(recipe)


def _read_described(path: Path, options: ReadOptions) -> Volume:
    where = str(path)
    fields = _described(path)
    if "objectfilename" not in fields or "resolution" not in fields:
        raise _shapeless(path)
    sizes = [int(word) for word in fields["resolution"].split()]
    if len(sizes) != 3:
        raise FileError(f"{where}: Resolution", f"is {shown(fields['resolution'])}", "write three whole numbers")
    name = fields.get("format", "").upper()
    if name not in FORMATS:
        raise FileError(f"{where}: Format", f"is {shown(name)}", f"write one of {', '.join(FORMATS)}")
    model = fields.get("objectmodel", "I").upper()
    if model not in MODELS:
        raise FileError(f"{where}: ObjectModel", f"is {shown(model)}", f"write one of {', '.join(MODELS)}")
    spacing = [float(word) for word in fields.get("slicethickness", "1 1 1").split()]
    channels = MODELS[model]
    samples = detached(path, fields["objectfilename"], "ObjectFileName")
    array = load(samples, _dtype(FORMATS[name], options.big_endian), (*reversed(sizes), channels), options)
    array = array[..., 0] if channels == 1 else np.moveaxis(array, -1, 0)
    recipe = (("big_endian", "true"),) if options.big_endian else ()
    return Volume(
        unmistakable(array),
        world_from_index=affine(spacing, (0, 0, 0), f"{where}: SliceThickness"),
        channel_names=("red", "green", "blue", "alpha")[:channels] if model in ("RGB", "RGBA") else (),
        name=path.name,
        source=Source(where, options=recipe),
    )


def _described(path: Path) -> dict[str, str]:
    with path.open("rb") as file:
        head = file.read(MAX_HEADER_BYTES)
    if b"\0" in head:
        return {}
    lines = (line.partition(":") for line in head.decode("latin-1").splitlines())
    return {key.strip().lower(): value.strip() for key, colon, value in lines if colon}


def _shapeless(path: Path) -> FileError:
    """The error for raw samples alone; many names tell their shape, and the remedy repeats it."""
    remedy = "pass shape=(x, y, z) and dtype=, e.g. shape=(256, 256, 128), dtype='uint8'"
    sizes = re.search(r"(\d+)x(\d+)x(\d+)", path.name)
    dtype = re.search(r"u?int(?:8|16|32)|float(?:16|32|64)?", path.name)
    if sizes:
        shape = ", ".join(sizes.groups())
        remedy = f"pass shape=({shape}), dtype='{dtype.group() if dtype else 'uint8'}', if its name says what it holds"
    return FileError(str(path), "is raw: nothing in it tells its shape and type", remedy)
