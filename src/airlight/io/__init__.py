"""Readers and writers of volume files: one module a format family, imported when a file of it is opened."""

from __future__ import annotations

import dataclasses
import importlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from ..errors import AirlightError, FileError, LimitError, MissingExtraError
from ..volume import Volume
from .formats import FAMILIES, extension_of, family_of, first_bytes
from .messages import brief
from .options import Progress, ReadOptions

__all__ = ["open", "save"]


def open(
    path: str | os.PathLike[str],
    *,
    dataset: str = "",
    level: int = 0,
    shape: Sequence[int] | None = None,
    dtype: str = "",
    spacing: Sequence[float] | None = None,
    offset: int = 0,
    big_endian: bool = False,
    max_memory: int = 8 << 30,
    untrusted: bool = False,
    progress: Progress | None = None,
) -> Volume:
    """Read a volume, with its geometry, units, channels and times.

    Parameters
    ----------
    path
        A file, or a folder of DICOM files or of OME-Zarr. NRRD, NIfTI, MetaImage, DICOM, TIFF, NumPy, raw, VTK ImageData, MRC,
        HDF5, OME-Zarr and NetCDF are told by their extension, else by their first bytes.
    dataset
        Name of one array inside the file.
    level
        Level of a pyramid; 0 is the finest.
    shape
        Size of raw samples as ``(x, y, z)``, with channels and times behind it. What is given a shape is read as raw.
    dtype
        NumPy's name for the type of raw samples.
    spacing
        World size of a voxel along x, y, z, for files that cannot tell it.
    offset
        Bytes before the raw samples.
    big_endian
        Whether raw samples have their highest byte first.
    max_memory
        Bytes that the file may take in memory.
    untrusted
        Read in a process of its own with limits on memory and time.
    progress
        Called with what is done, how much of it is done and how much there is (0 when unknown).

    Returns
    -------
    Volume
        World of anatomical data is patient LPS in millimetres; nothing is flipped silently.

    Raises
    ------
    FileError
        For a missing, damaged, hostile or unknown file.
    DataError
        For contents that cannot be drawn: complex samples, colours last, too few axes.
    LimitError
        For more than ``max_memory``.
    MissingExtraError
        For a format whose package is not installed; the remedy is the pip command.
    """
    place = Path(path).expanduser()
    options = ReadOptions(
        dataset=dataset,
        level=level,
        shape_xyz=None if shape is None else tuple(int(n) for n in shape),
        dtype=dtype,
        spacing=None if spacing is None else cast(tuple[float, float, float], tuple(float(s) for s in spacing)),
        offset_bytes=offset,
        big_endian=big_endian,
        max_bytes=max_memory,
        **({} if progress is None else {"progress": progress}),
    )
    if untrusted:
        from .untrusted import read_untrusted

        return _with_absolute_source(read_untrusted(place, options))
    return _with_absolute_source(read_trusted(place, options))


def _with_absolute_source(volume: Volume) -> Volume:
    """Make the source's path absolute, so that volumes of one file are equal wherever they were opened from."""
    if volume.source is not None:
        volume.source = dataclasses.replace(volume.source, path=os.path.abspath(volume.source.path))
    return volume


def read_trusted(path: Path, options: ReadOptions) -> Volume:
    """Read within this process: the one place where what a library raises becomes an error of ours."""
    if options.shape_xyz is None:
        name = family_of(path)
    else:
        name = "raw"
        first_bytes(path)
    family = FAMILIES[name]
    try:
        module = importlib.import_module(f".{name}", __package__)
        return cast(Volume, module.read(path, options))
    except AirlightError:
        raise
    except MemoryError as error:
        raise LimitError(str(path), "needs more memory than there is", "choose a coarser level or a smaller file") from error
    except ModuleNotFoundError as error:
        if not family.extra or (error.name or "").startswith("airlight"):
            raise
        raise MissingExtraError(
            str(path), f"is {family.title}, which needs {family.needs}", f'pip install "airlight[{family.extra}]"'
        ) from error
    except Exception as error:
        raise FileError(
            str(path), f"cannot be read as {family.title} ({brief(error)})", "it is damaged, or not of that kind"
        ) from error


def save(volume: Volume, path: str | os.PathLike[str]) -> None:
    """Write a volume to ``.nrrd``, ``.nii``, ``.nii.gz``, ``.npy`` or ``.ome.zarr``; the file appears whole or not at all.

    NRRD keeps everything; NIfTI has no names of channels and an affine of float32; ``.npy`` holds the samples alone.
    """
    place = Path(path).expanduser()
    extension = extension_of(place)
    extension = ".zarr" if extension == ".ome.zarr" else extension
    name = next((name for name, family in FAMILIES.items() if extension in family.writes), "")
    if not name:
        known = ", ".join(each for each_family in FAMILIES.values() for each in each_family.writes)
        raise FileError(str(place), f"cannot be written: {extension or 'no extension'} has no writer", f"choose one of {known}")
    if not place.parent.is_dir():
        raise FileError(str(place), "cannot be written: its folder does not exist", f"make {place.parent}")
    family = FAMILIES[name]
    try:
        importlib.import_module(f".{name}", __package__).write(volume, place)
    except AirlightError:
        raise
    except ModuleNotFoundError as error:
        if not family.extra or (error.name or "").startswith("airlight"):
            raise
        raise MissingExtraError(
            str(place), f"needs {family.needs} to be written", f'pip install "airlight[{family.extra}]"'
        ) from error
    except OSError as error:
        raise FileError(str(place), f"cannot be written ({brief(error)})", "check the folder and the space in it") from error
