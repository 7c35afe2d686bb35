"""MRC and CCP4 maps of electron density. mrcfile knows the header; the samples are read here, bounded."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from ..volume import Source, Volume
from .options import ReadOptions
from .samples import LONGEST_AXIS, codec_of, load, stream
from .units import FloatArray, matrix_of

HEADER_BYTES = 1024
DTYPES = {0: "i1", 1: "i2", 2: "f4", 6: "u2", 12: "f2"}
IMOD_STAMP = 1146047817
VOLUME_STACK = 401


def read(path: Path, options: ReadOptions) -> Volume:
    """Map in ångström; the file's columns, rows and sections are brought to z, y, x, and skewed cells keep their shear.

    A stack of volumes becomes time steps, since it is shown one at a time.
    """
    where = str(path)
    codec = codec_of(path)
    with stream(path, codec) as file:
        head = file.read(HEADER_BYTES) or b""
    header = _header(head, where)
    mode = int(header["mode"])
    if mode in (3, 4):
        raise DataError(where, "holds complex samples (a transform)", "write the map itself, or its magnitude")
    if mode not in DTYPES:
        raise DataError(where, f"has mode {mode}", f"write one of the modes {', '.join(str(m) for m in DTYPES)}")
    dtype = np.dtype("u1" if mode == 0 and _unsigned_bytes(header) else DTYPES[mode])
    dtype = dtype.newbyteorder(header.dtype["nx"].byteorder)
    sizes = tuple(int(header[key]) for key in ("nx", "ny", "nz"))
    skip = HEADER_BYTES + int(header["nsymbt"])
    if min(sizes) < 1 or int(header["nsymbt"]) < 0:
        raise FileError(where, f"declares the size {sizes} and {int(header['nsymbt'])} more bytes", "it is damaged")
    volumes = 1
    if int(header["ispg"]) >= VOLUME_STACK:
        volumes, rest = divmod(sizes[2], max(int(header["mz"]), 1))
        if rest or not volumes:
            raise FileError(where, f"has {sizes[2]} sections in volumes of {int(header['mz'])}", "mend its header")
    shape = (volumes, sizes[2] // volumes, sizes[1], sizes[0])
    if codec:
        array = load(path, dtype, shape, options, codec=codec, skip=skip)
    else:
        array = load(path, dtype, shape, options, offset=skip)
    order = _axis_order(header, where)
    sections_rows_columns = (order[2], order[1], order[0])
    array = array.transpose(0, *(1 + sections_rows_columns.index(axis) for axis in (2, 1, 0)))
    matrix = _geometry(header, order, where)
    return Volume(
        array[0] if volumes == 1 else array[:, None],
        world_from_index=matrix,
        units="angstrom" if np.any(header["cella"].tolist()) else "",
        name=path.name,
        source=Source(where),
    )


def _header(head: bytes, where: str) -> Any:
    """The header as a NumPy record, in the byte order in which its mode and size are sound."""
    from mrcfile.dtypes import HEADER_DTYPE

    if len(head) < HEADER_BYTES:
        raise FileError(where, f"is cut short: {len(head)} of the {HEADER_BYTES} bytes of a header", "fetch it again")
    for order in ("<", ">"):
        header = np.frombuffer(head, HEADER_DTYPE.newbyteorder(order))[0]
        sizes = [int(header[key]) for key in ("nx", "ny", "nz")]
        if 0 <= int(header["mode"]) <= 200 and all(0 < n < LONGEST_AXIS >> 8 for n in sizes):
            return header
    raise FileError(where, "is no MRC file: neither byte order gives a sound header", "check its name and kind")


def _unsigned_bytes(header: Any) -> bool:
    """IMOD writes bytes without sign unless a flag beside its stamp says otherwise."""
    stamp, flags = np.frombuffer(header.tobytes()[152:160], np.dtype("i4").newbyteorder(header.dtype["nx"].byteorder))
    return bool(stamp == IMOD_STAMP and not flags & 1)


def _axis_order(header: Any, where: str) -> tuple[int, int, int]:
    """Spatial axis (0 x, 1 y, 2 z) of columns, rows and sections."""
    order = tuple(int(header[key]) - 1 for key in ("mapc", "mapr", "maps"))
    if order == (-1, -1, -1):  # old files leave it out
        return 0, 1, 2
    if sorted(order) != [0, 1, 2]:
        raise FileError(f"{where}: mapc, mapr, maps", f"are {tuple(n + 1 for n in order)}", "write 1, 2 and 3 in some order")
    return order[0], order[1], order[2]


def _geometry(header: Any, order: tuple[int, int, int], where: str) -> FloatArray:
    cell = np.array([float(header["cella"][key]) for key in "xyz"])
    angles = np.array([float(header["cellb"][key]) for key in ("alpha", "beta", "gamma")])
    samples = np.array([float(header[key]) for key in ("mx", "my", "mz")])
    if not (np.isfinite(cell).all() and np.isfinite(angles).all()):
        raise FileError(where, "has a cell that is no number", "mend its header")
    spacing = np.where((cell > 0) & (samples > 0), cell / np.where(samples > 0, samples, 1.0), 1.0)
    columns = _cell_axes(angles, where) * spacing
    origin = np.array([float(header["origin"][key]) for key in "xyz"])
    starts = np.zeros(3)
    for axis, key in zip(order, ("nxstart", "nystart", "nzstart"), strict=True):
        starts[axis] = float(header[key])
    if not np.isfinite(origin).all() or not origin.any():
        origin = columns @ starts
    return matrix_of(columns, origin)


def _cell_axes(angles_deg: FloatArray, where: str) -> FloatArray:
    """Unit vectors of the cell's axes as columns: a along x, b in the plane of x and y."""
    if not angles_deg.any() or (angles_deg == 90).all():
        return np.eye(3)
    cos_a, cos_b, cos_c = (math.cos(math.radians(angle)) for angle in angles_deg)
    sin_c = math.sin(math.radians(angles_deg[2]))
    if angles_deg.min() <= 0 or angles_deg.max() >= 180:
        raise FileError(f"{where}: cellb", f"has the angles {angles_deg.tolist()}", "mend its header")
    c_y = (cos_a - cos_b * cos_c) / sin_c
    c_z = 1 - cos_b**2 - c_y**2
    if c_z <= 0:
        raise FileError(f"{where}: cellb", f"has the angles {angles_deg.tolist()}, which span no cell", "mend its header")
    return np.array([[1, cos_c, cos_b], [0, sin_c, c_y], [0, 0, math.sqrt(c_z)]])
