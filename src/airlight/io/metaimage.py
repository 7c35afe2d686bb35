"""MetaImage: ``.mha``, and ``.mhd`` beside its data. Its world is LPS already; ``AnatomicalOrientation`` only informs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from ..volume import Source, Volume, unmistakable
from .messages import shown
from .options import ReadOptions
from .paths import detached, numbered
from .samples import AnyArray, byte_count, check_size, load, parse_text, scaled
from .units import FloatArray, in_millimetres, matrix_of, unit_name

MAX_HEADER_BYTES = 1 << 20
DTYPES = {
    "MET_CHAR": "i1",
    "MET_ASCII_CHAR": "i1",
    "MET_UCHAR": "u1",
    "MET_SHORT": "i2",
    "MET_USHORT": "u2",
    "MET_INT": "i4",
    "MET_UINT": "u4",
    "MET_LONG": "i4",  # 4 bytes in MetaIO's own table, on every machine
    "MET_ULONG": "u4",
    "MET_LONG_LONG": "i8",
    "MET_ULONG_LONG": "u8",
    "MET_FLOAT": "f4",
    "MET_DOUBLE": "f8",
}
MODALITIES = {"MET_MOD_CT": "CT", "MET_MOD_MR": "MR", "MET_MOD_NM": "NM", "MET_MOD_US": "US"}


def read(path: Path, options: ReadOptions) -> Volume:
    """Volume in a MetaImage file of 3 axes, or 4 of which the last is time; channels are those of its elements."""
    fields, data_start = _header(path)
    where = str(path)
    sizes = _whole(fields, "DimSize", where)
    dimensions = int(fields.get("NDims", len(sizes)))
    if len(sizes) != dimensions:
        raise FileError(f"{where}: DimSize", f"lists {len(sizes)} numbers for {dimensions} axes", "mend the header")
    if dimensions not in (3, 4):
        raise DataError(where, f"has {dimensions} axes, a volume has 3, or 4 with time", "stack its slices into one file")
    channels = int(fields.get("ElementNumberOfChannels", "1"))
    shape = (*reversed(sizes), channels)
    dtype = _dtype(fields, where)
    byte_count(where, dtype, shape, options)
    matrix, start, step = _geometry(fields, dimensions, where)
    array = _samples(path, fields, data_start, dtype, shape, options)
    array = _arranged(array, dimensions, channels)
    slope = _numbers(fields, ("ElementToIntensityFunctionSlope",), 1, (1.0,), where)[0]
    intercept = _numbers(fields, ("ElementToIntensityFunctionOffset",), 1, (0.0,), where)[0]
    letters = fields.get("AnatomicalOrientation", "")
    anatomical = len(letters) >= 3 and set(letters[:3].upper()) <= set("RLAPIS")
    unit = unit_name(fields.get("DistanceUnits", "").strip("?"))
    if anatomical:
        matrix, unit = in_millimetres(matrix, unit), "mm"
    return Volume(
        unmistakable(scaled(array, slope, intercept, where, options)),
        world_from_index=matrix,
        units=unit,
        times=tuple(start + step * i for i in range(sizes[3])) if dimensions == 4 else (),
        anatomical=anatomical,
        modality=MODALITIES.get(fields.get("Modality", ""), ""),
        name=path.name,
        source=Source(str(path)),
    )


def _header(path: Path) -> tuple[dict[str, str], int]:
    """Fields up to ``ElementDataFile``, which ends every header, and the byte behind it."""
    with path.open("rb") as file:
        head = file.read(MAX_HEADER_BYTES)
    fields: dict[str, str] = {}
    at = 0
    while at < len(head):
        end = head.find(b"\n", at)
        end = len(head) if end < 0 else end
        line = head[at:end].decode("latin-1")
        at = end + 1
        key, equals, value = line.partition("=")
        if not equals:
            if not line.strip():
                continue
            break
        fields[key.strip()] = value.strip()
        if key.strip() == "ElementDataFile":
            return fields, min(at, len(head))
    what = "is no MetaImage file" if "NDims" not in fields else "has no 'ElementDataFile' at the end of its header"
    raise FileError(str(path), what, "check its name and kind")


def _dtype(fields: dict[str, str], where: str) -> np.dtype[Any]:
    name = fields.get("ElementType", "").removesuffix("_ARRAY")
    if name not in DTYPES:
        raise FileError(f"{where}: ElementType", f"is {shown(name)}", f"write one of {', '.join(DTYPES)}")
    big = fields.get("BinaryDataByteOrderMSB", fields.get("ElementByteOrderMSB", "False"))
    return np.dtype(DTYPES[name]).newbyteorder(">" if _truth(big) else "<")


def _samples(
    path: Path, fields: dict[str, str], data_start: int, dtype: np.dtype[Any], shape: tuple[int, ...], options: ReadOptions
) -> AnyArray:
    names, per_file = _data_files(path, fields, data_start, shape)
    codec = "zlib" if _truth(fields.get("CompressedData", "False")) else ""
    text = not _truth(fields.get("BinaryData", "True"))
    header_size = int(fields.get("HeaderSize", "0"))
    array = np.empty((len(names), *per_file) if len(names) > 1 else 0, dtype.newbyteorder("="))
    for number, name in enumerate(names):
        target = path if name is None else detached(path, name, "ElementDataFile")
        offset = data_start if name is None else max(header_size, 0)
        needed = math.prod(per_file) * dtype.itemsize
        if header_size == -1 and not codec and name is not None:
            offset = target.stat().st_size - needed
            if offset < 0:
                check_size(str(target), target.stat().st_size, needed)
        if text:
            options.check_bytes(str(target), target.stat().st_size)
            piece = parse_text(target.read_bytes()[offset:], dtype.newbyteorder("="), per_file, str(target))
        else:
            piece = load(target, dtype, per_file, options, codec=codec, offset=offset)
        if len(names) == 1:
            return piece.reshape(shape)
        array[number] = piece
    return array.reshape(shape)


def _data_files(
    path: Path, fields: dict[str, str], data_start: int, shape: tuple[int, ...]
) -> tuple[list[str | None], tuple[int, ...]]:
    """Names of the files with samples (None: this one), and the shape of what each holds."""
    value = fields["ElementDataFile"]
    words = value.split()
    if value.upper() == "LOCAL":
        return [None], shape
    names: list[str | None]
    if words and words[0].upper() == "LIST":
        with path.open("rb") as file:
            file.seek(data_start)
            names = [n.strip() for n in file.read(MAX_HEADER_BYTES).decode("utf-8", "replace").split("\n") if n.strip()]
        depth = int(words[1].rstrip("Dd")) if len(words) > 1 else len(shape) - 2
    elif len(words) >= 3 and "%" in words[0]:
        first, last, step = (int(word) for word in (*words[1:3], *words[3:4], "1")[:3])
        numbers = range(first, last + 1, step)
        if len(numbers) > math.prod(shape[:-3]) or words[0].count("%") != 1:
            raise FileError(f"{path}: ElementDataFile", f"is {shown(value)}", "name one file a slice")
        names, depth = [numbered(words[0], number, "ElementDataFile") for number in numbers], len(shape) - 2
    else:
        return [value], shape
    rest = shape[len(shape) - 1 - depth :]
    count = math.prod(shape[: len(shape) - 1 - depth])
    if len(names) != count or depth < 1:
        raise FileError(f"{path}: ElementDataFile", f"lists {len(names)} files where {count} are needed", "list one a slice")
    return names, (1, *rest)


def _arranged(array: AnyArray, dimensions: int, channels: int) -> AnyArray:
    """``([t,] z, y, x, c)`` as ``(z, y, x)``, ``(c, z, y, x)`` or ``(t, c, z, y, x)``."""
    if dimensions == 3 and channels == 1:
        return array[..., 0]
    return np.moveaxis(array, -1, dimensions - 3)


def _geometry(fields: dict[str, str], dimensions: int, where: str) -> tuple[FloatArray, float, float]:
    """``world_from_index``, and start and step of time."""
    ones = (1.0,) * dimensions
    size = _numbers(fields, ("ElementSize",), dimensions, ones, where)
    spacing = _numbers(fields, ("ElementSpacing",), dimensions, tuple(size), where)
    offset = _numbers(fields, ("Offset", "Position", "Origin"), dimensions, (0.0,) * dimensions, where)
    flat = np.eye(dimensions).ravel()
    turns = _numbers(fields, ("TransformMatrix", "Rotation", "Orientation"), dimensions**2, tuple(flat), where)
    axes = turns.reshape(dimensions, dimensions)  # one axis' direction after the other: a row here is a column there
    if dimensions == 4 and (axes[3, :3].any() or axes[:3, 3].any()):
        raise DataError(where, "mixes time and space in its TransformMatrix", "write it with time as an axis of its own")
    matrix = matrix_of(axes[:3, :3].T * spacing[:3], offset[:3])
    return (matrix, float(offset[3]), float(spacing[3])) if dimensions == 4 else (matrix, 0.0, 0.0)


def _numbers(fields: dict[str, str], keys: tuple[str, ...], count: int, default: tuple[float, ...], where: str) -> FloatArray:
    for key in keys:
        if key in fields:
            words = fields[key].split()
            try:
                numbers = np.array([float(word) for word in words], dtype=np.float64)
            except ValueError as error:
                raise FileError(f"{where}: {key}", f"is {shown(fields[key])}", "write numbers") from error
            if len(numbers) != count or not np.isfinite(numbers).all():
                raise FileError(f"{where}: {key}", f"is {shown(fields[key])}", f"write {count} numbers")
            return numbers
    return np.array(default, dtype=np.float64)


def _whole(fields: dict[str, str], key: str, where: str) -> tuple[int, ...]:
    try:
        return tuple(int(word) for word in fields[key].split())
    except (KeyError, ValueError) as error:
        raise FileError(f"{where}: {key}", f"is {shown(fields.get(key, 'missing'))}", "write whole numbers") from error


def _truth(text: str) -> bool:
    return text.strip().lower() in ("true", "1", "t", "yes")
