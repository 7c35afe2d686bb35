"""NumPy's ``.npy`` and ``.npz``: arrays only, never pickles."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np

from ..errors import DataError, FileError
from ..files import replacing
from ..volume import Source, Volume
from .inflate import check_ratio
from .messages import brief, shown
from .options import ReadOptions
from .samples import AnyArray, byte_count, check_kind, check_size, read_array

GEOMETRY = ("world_from_index", "spacing", "origin", "units")
USUAL_NAMES = ("array", "volume", "data", "image", "arr_0")
MAX_SMALL_BYTES = 1 << 16


def read(path: Path, options: ReadOptions) -> Volume:
    """Array of a ``.npy`` file, or of a ``.npz``: the only one with 3 to 5 axes, or the one that ``dataset`` names.

    In a ``.npz``, arrays named ``world_from_index``, or ``spacing`` and ``origin``, give the geometry.
    """
    with path.open("rb") as file:
        zipped = file.read(2) == b"PK"
        if zipped:
            return _read_zip(path, options)
        file.seek(0)
        array = _read_member(file, path.stat().st_size, str(path), options)
    return Volume(array, spacing=options.spacing, name=path.name, source=Source(str(path), options=_recipe(options)))


def _recipe(options: ReadOptions) -> tuple[tuple[str, str], ...]:
    if options.spacing is None:
        return ()
    return (("spacing", " ".join(repr(float(s)) for s in options.spacing)),)


def _read_zip(path: Path, options: ReadOptions) -> Volume:
    where = str(path)
    try:
        with zipfile.ZipFile(path) as archive:
            members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            shapes = {name: _peek(archive, info, where) for name, info in members.items() if name not in GEOMETRY}
            name = _choose(shapes, where, options.dataset)
            array = _member(archive, members[name], where, options)
            given = {key: _small(archive, members[key], where, options) for key in GEOMETRY if key in members}
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError) as error:
        raise FileError(where, f"is a damaged zip archive ({brief(error)})", "fetch or write the file again") from error
    units = str(given.get("units", ""))
    source = Source(where, dataset=options.dataset, options=_recipe(options))
    if "world_from_index" in given:
        return Volume(array, world_from_index=given["world_from_index"], units=units, name=path.name, source=source)
    spacing, origin = options.spacing or given.get("spacing"), given.get("origin")
    return Volume(
        array,
        spacing=None if spacing is None else tuple(float(s) for s in spacing),
        origin=None if origin is None else tuple(float(o) for o in origin),
        units=units,
        name=path.name,
        source=source,
    )


def _choose(shapes: dict[str, tuple[int, ...]], where: str, wanted: str) -> str:
    if wanted:
        if wanted not in shapes:
            raise FileError(where, f"has no array {shown(wanted)}", f"choose one of {', '.join(list(shapes)[:20])[:500]}")
        return wanted
    fitting = [name for name, shape in shapes.items() if 3 <= len(shape) <= 5]
    if len(fitting) == 1:
        return fitting[0]
    for name in USUAL_NAMES:
        if name in fitting:
            return name
    if not fitting:
        raise DataError(where, "holds no array of 3 to 5 axes", "save one of shape (z, y, x)")
    raise FileError(where, f"holds several arrays: {', '.join(fitting[:20])[:500]}", "name one by dataset= (--dataset)")


def _checked_info(archive: zipfile.ZipFile, info: zipfile.ZipInfo, where: str) -> IO[bytes]:
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise FileError(where, "is compressed in a way that NumPy does not write", "write it with numpy.savez_compressed")
    if info.flag_bits & 1:
        raise FileError(where, "is encrypted", "unpack it first")
    check_ratio(where, info.file_size, info.compress_size, "zlib")
    return archive.open(info)


def _peek(archive: zipfile.ZipFile, info: zipfile.ZipInfo, where: str) -> tuple[int, ...]:
    with _checked_info(archive, info, where) as file:
        return _array_header(file, where)[0]


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo, where: str, options: ReadOptions) -> AnyArray:
    with _checked_info(archive, info, where) as file:
        return _read_member(file, info.file_size, where, options)


def _small(archive: zipfile.ZipFile, info: zipfile.ZipInfo, where: str, options: ReadOptions) -> Any:
    with _checked_info(archive, info, where) as file:
        shape, _, dtype = _array_header(file, where)
        if dtype.kind not in "iufU" or dtype.itemsize > MAX_SMALL_BYTES or len(shape) > 2 or any(n > 4 for n in shape):
            what = f"has type {shown(dtype)} and shape {shape}"
            raise FileError(f"{where}: {shown(info.filename)}", what, "give a matrix of 4x4, or three numbers")
        if dtype.kind == "U":
            return np.frombuffer(file.read(dtype.itemsize), dtype)[0] if dtype.itemsize else ""
        return read_array(file, dtype, shape or (1,), where, options).reshape(shape)  # type: ignore[arg-type]


def _read_member(file: IO[bytes], size: int, where: str, options: ReadOptions) -> AnyArray:
    shape, fortran, dtype = _array_header(file, where)
    check_kind(where, dtype)
    if not 3 <= len(shape) <= 5:
        raise DataError(where, f"has {len(shape)} axes", "save an array of shape (z, y, x), (c, z, y, x) or (t, c, z, y, x)")
    stored = shape[::-1] if fortran else shape
    check_size(where, size - file.tell(), byte_count(where, dtype, stored, options))
    array = read_array(file, dtype, stored, where, options)  # type: ignore[arg-type]
    if file.read(1):
        raise FileError(where, "goes on behind its array", "write it again")
    return array.T if fortran else array


def _array_header(file: IO[bytes], where: str) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    try:
        version = np.lib.format.read_magic(file)
        if version == (1, 0):
            shape, fortran, dtype = np.lib.format.read_array_header_1_0(file)
        elif version == (2, 0):
            shape, fortran, dtype = np.lib.format.read_array_header_2_0(file)
        else:
            raise ValueError(f"format version {version}")
    except (ValueError, SyntaxError, TypeError, RecursionError) as error:
        raise FileError(where, f"has no sound NumPy header ({brief(error)})", "write it with numpy.save") from error
    if dtype.hasobject:
        raise FileError(where, "holds Python objects, which may run code when read", "save numbers, e.g. array.astype(float)")
    return shape, fortran, dtype


def write(volume: Volume, path: Path) -> None:
    """Write the samples to ``.npy``; the file cannot hold geometry, units or names."""
    if path.suffix.lower() != ".npy":
        raise FileError(str(path), "cannot be written", "give a name that ends in .npy")
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.save(file, np.ascontiguousarray(volume.array), allow_pickle=False)
