"""Imaris files (.ims): HDF5 with one dataset a level, time step and channel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from ..volume import Source, Volume, unmistakable
from .options import ReadOptions
from .samples import byte_count, check_kind
from .units import unit_name


def read_imaris(file: Any, path: Path, options: ReadOptions) -> Volume:
    """All channels and time steps at ``options.level``; the world is Imaris' own, in its unit."""
    where = f"{path}: DataSet"
    levels = sorted(int(n.split()[-1]) for n in file["DataSet"] if n.startswith("ResolutionLevel "))
    if options.level not in levels:
        raise DataError(str(path), f"has no level {options.level}", f"choose one of {levels} (--level, level=)")
    steps = file[f"DataSet/ResolutionLevel {options.level}"]
    channels = steps["TimePoint 0"]
    first = channels["Channel 0"]
    size = [int(_attribute(first, f"ImageSize{a}")) for a in "ZYX"]
    dtype = first["Data"].dtype
    check_kind(where, dtype)
    shape = (len(steps), len(channels), *size)
    byte_count(where, dtype, shape, options)
    array = np.empty(shape, dtype)
    for t in range(shape[0]):
        for c in range(shape[1]):
            options.progress("reading Imaris", t * shape[1] + c, shape[0] * shape[1])
            data = steps[f"TimePoint {t}/Channel {c}/Data"]
            if data.dtype != dtype or any(have < want for have, want in zip(data.shape, size, strict=True)):
                raise FileError(where, f"has a channel of shape {data.shape} {data.dtype}, others {tuple(size)} {dtype}")
            array[t, c] = data[: size[0], : size[1], : size[2]]  # stored in whole chunks, padded at the ends
    image = file["DataSetInfo/Image"]
    low = np.array([float(_attribute(image, f"ExtMin{i}")) for i in range(3)])
    high = np.array([float(_attribute(image, f"ExtMax{i}")) for i in range(3)])
    spacing = (high - low) / np.array(size[::-1])
    matrix = np.diag([*spacing, 1.0])
    matrix[:3, 3] = low + spacing / 2  # the extent is that of cells
    names = [file["DataSetInfo"].get(f"Channel {c}") for c in range(shape[1])]
    told = tuple(_attribute(n, "Name") if n is not None and "Name" in n.attrs else "" for n in names)
    return Volume(
        unmistakable(array if shape[0] > 1 else array[0] if shape[1] > 1 else array[0, 0]),
        world_from_index=matrix,
        units=unit_name(_attribute(image, "Unit")) if "Unit" in image.attrs else "",
        channel_names=told if all(told) else (),
        modality="microscopy",
        name=path.name,
        source=Source(str(path), "", options.level),
    )


def _attribute(item: Any, name: str) -> str:
    """Imaris writes every attribute as an array of single characters."""
    value = item.attrs[name]
    return b"".join(value).decode("latin-1") if isinstance(value, np.ndarray) and value.dtype.kind == "S" else str(value)
