"""VTK's ImageData in XML, ``.vti``: text, inline base64 and appended data, plain or compressed with zlib."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from ..volume import Source, Volume, unmistakable
from .messages import brief, shown
from .options import ReadOptions
from .samples import AnyArray, byte_count, parse_text
from .units import FloatArray, matrix_of
from .vti_data import Base64, Plain, VtkFile, decoded

MARK = b"<AppendedData"
DTYPES = {
    "Int8": "i1",
    "UInt8": "u1",
    "Int16": "i2",
    "UInt16": "u2",
    "Int32": "i4",
    "UInt32": "u4",
    "Int64": "i8",
    "UInt64": "u8",
    "Float32": "f4",
    "Float64": "f8",
}
COMPONENTS = {3: ("x", "y", "z"), 6: ("xx", "yy", "zz", "xy", "yz", "xz")}


def read(path: Path, options: ReadOptions) -> Volume:
    """Volume of the point arrays of an image, or of its cell arrays if it has no others; each component is a channel.

    ``dataset`` names one array; otherwise all are read, in the order of the file.
    """
    where = str(path)
    options.check_bytes(where, path.stat().st_size)
    options.progress(f"reading {path.name}", 0, path.stat().st_size)
    file, root = _parsed(path)
    image = root.find("ImageData")
    if image is None:
        raise FileError(where, f"holds {shown(root.get('type', 'no VTK data'))}, not ImageData", "write it as vtkImageData")
    pieces = image.findall("Piece")
    if len(pieces) != 1:
        raise FileError(where, f"has {len(pieces)} pieces", "write it as one piece")
    low, points = _extent(pieces[0].get("Extent", image.get("WholeExtent", "")), where)
    matrix = _geometry(image, low, where)
    found = [(array, points) for array in pieces[0].findall("PointData/DataArray")]
    if not found and all(n > 1 for n in points):
        cells = (points[0] - 1, points[1] - 1, points[2] - 1)
        found = [(array, cells) for array in pieces[0].findall("CellData/DataArray")]
        matrix = matrix @ matrix_of(np.eye(3), (0.5, 0.5, 0.5))
    chosen = [(array, size) for array, size in found if not options.dataset or array.get("Name") == options.dataset]
    if not chosen:
        known = ", ".join(array.get("Name", "?") for array, _ in found) or "none"
        what = f"has no array {shown(options.dataset)}" if options.dataset else "has no arrays"
        raise FileError(where, what, f"its arrays are: {known[:500]}")
    array, names = _channels(chosen, file, options)
    return Volume(
        unmistakable(array),
        world_from_index=matrix,
        channel_names=names,
        name=path.name,
        source=Source(where, dataset=options.dataset),
    )


def _parsed(path: Path) -> tuple[VtkFile, Any]:
    """The file's traits, and the root of its XML without the appended data, which need not be XML."""
    from defusedxml.common import DefusedXmlException
    from defusedxml.ElementTree import ParseError, fromstring

    where = str(path)
    data = path.read_bytes()
    at = data.find(MARK)
    text, appended, encoding = data, 0, "raw"
    if at >= 0:
        start = data.find(b"_", data.find(b">", at) + 1)
        tag = data[at : data.find(b">", at)]
        if start < 0 or data[data.find(b">", at) + 1 : start].strip():
            raise FileError(where, "has AppendedData without its underscore", "write it again")
        encoding = "base64" if b"base64" in tag else "raw"
        text, appended = data[:at] + b"</VTKFile>", start + 1
    try:
        root = fromstring(text, forbid_dtd=True)
    except DefusedXmlException as error:
        raise FileError(where, "declares XML entities or a document type, which is refused", "write it again") from error
    except (ParseError, ValueError, LookupError) as error:
        raise FileError(where, f"is no sound XML ({brief(error)})", "fetch or write the file again") from error
    if root.tag != "VTKFile":
        raise FileError(where, f"is XML of another kind: {shown(root.tag)}", "check its name and kind")
    compressor = root.get("compressor", "")
    if compressor not in ("", "vtkZLibDataCompressor"):
        raise FileError(where, f"is compressed by {shown(compressor)}", "write it with vtkZLibDataCompressor or without any")
    order = {"LittleEndian": "<", "BigEndian": ">"}.get(root.get("byte_order", "LittleEndian"))
    header = {"UInt32": "u4", "UInt64": "u8"}.get(root.get("header_type", "UInt32"))
    if order is None or header is None:
        raise FileError(where, "has an unknown byte_order or header_type", "write it again")
    return VtkFile(where, data, appended, encoding, order, np.dtype(order + header), bool(compressor)), root


def _extent(text: str, where: str) -> tuple[FloatArray, tuple[int, int, int]]:
    """Lowest index and number of points along x, y, z."""
    words = text.split()
    try:
        ends = [int(word) for word in words]
        low, (x, y, z) = ends[0::2], (high - low + 1 for low, high in zip(ends[0::2], ends[1::2], strict=True))
    except ValueError as error:
        raise FileError(f"{where}: Extent", f"is {shown(text)}", "write six whole numbers") from error
    return np.array(low, dtype=np.float64), (x, y, z)


def _geometry(image: Any, low: FloatArray, where: str) -> FloatArray:
    def numbers(key: str, default: str, count: int) -> FloatArray:
        try:
            values = np.array([float(word) for word in image.get(key, default).split()])
        except ValueError:
            values = np.zeros(0)
        if len(values) != count or not np.isfinite(values).all():
            raise FileError(f"{where}: {key}", f"is {shown(image.get(key))}", f"write {count} numbers")
        return values

    columns = numbers("Direction", "1 0 0 0 1 0 0 0 1", 9).reshape(3, 3) * numbers("Spacing", "1 1 1", 3)
    return matrix_of(columns, numbers("Origin", "0 0 0", 3) + columns @ low)


def _channels(
    chosen: list[tuple[Any, tuple[int, int, int]]], file: VtkFile, options: ReadOptions
) -> tuple[AnyArray, tuple[str, ...]]:
    names: list[str] = []
    kinds: list[tuple[np.dtype[Any], int]] = []
    total = len(file.data)
    for element, size in chosen:
        name, components = element.get("Name", "values"), _count(element, file.where)
        dtype = _dtype(element, file)
        total += byte_count(file.where, dtype, (*reversed(size), components), options)
        kinds.append((dtype, components))
        ends = COMPONENTS.get(components, tuple(str(i) for i in range(min(components, 1 << 16))))
        names += [name] if components == 1 else [f"{name}_{end}" for end in ends]
    options.check_bytes(file.where, total)
    parts = []
    for (element, size), (dtype, components) in zip(chosen, kinds, strict=True):
        samples = _array(element, dtype, (*reversed(size), components), file)
        parts.append(np.moveaxis(samples, -1, 0))
    if len(parts) == 1:
        return (parts[0][0] if len(parts[0]) == 1 else parts[0]), tuple(names)
    return np.concatenate(parts), tuple(names)


def _count(element: Any, where: str) -> int:
    text = element.get("NumberOfComponents", "1")
    if not text.isdecimal() or len(text) > 9 or not 0 < int(text) <= 1 << 16:
        raise FileError(f"{where}: NumberOfComponents", f"is {shown(text)}", "write a whole number from 1 on")
    return int(text)


def _dtype(element: Any, file: VtkFile) -> np.dtype[Any]:
    name = element.get("type", "")
    if name not in DTYPES:
        where = f"{file.where}: {shown(element.get('Name'))}"
        raise DataError(where, f"has type {shown(name)}", f"choose one of {', '.join(DTYPES)}")
    return np.dtype(file.order + DTYPES[name])


def _array(element: Any, dtype: np.dtype[Any], shape: tuple[int, ...], file: VtkFile) -> AnyArray:
    where, kind = f"{file.where}: {shown(element.get('Name'))}", element.get("format", "ascii")
    needed = int(np.prod(shape, dtype=object)) * dtype.itemsize
    if kind == "ascii":
        return parse_text((element.text or "").encode(), dtype.newbyteorder("="), shape, where)
    if kind == "binary":
        text = "".join((element.text or "").split()).encode("ascii", "replace")
        return decoded(Base64(memoryview(text), where), needed, dtype, shape, where, file)
    if kind != "appended" or not file.appended:
        raise FileError(where, f"has format {shown(kind)}", "write ascii, binary or appended data")
    offset = element.get("offset", "")
    if not offset.isdecimal() or len(offset) > 18 or file.appended + int(offset) >= len(file.data):
        raise FileError(where, f"has offset {shown(offset)}, outside of the file", "fetch or write the file again")
    start = file.appended + int(offset)
    source = (Base64 if file.encoding == "base64" else Plain)(memoryview(file.data)[start:], where)
    return decoded(source, needed, dtype, shape, where, file)
