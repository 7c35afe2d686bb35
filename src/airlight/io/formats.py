"""The table of format families, and how a file's family is told: by its extension, else by its first bytes."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

from ..errors import FileError
from .messages import brief


@dataclass(frozen=True)
class Family:
    """Formats that one module reads.

    ``extensions`` are proper to the family; ``magics`` lists further families whose first bytes are right for it, since some
    formats are built on others. ``extra`` is the extra of this package that installs ``needs``.
    """

    title: str
    extensions: tuple[str, ...]
    magics: tuple[str, ...] = ()
    extra: str = ""
    needs: str = ""
    writes: tuple[str, ...] = ()


FAMILIES: dict[str, Family] = {
    "nrrd": Family("NRRD", (".nrrd", ".nhdr"), writes=(".nrrd",)),
    "nifti": Family("NIfTI", (".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"), writes=(".nii", ".nii.gz")),
    "metaimage": Family("MetaImage", (".mha", ".mhd")),
    "dicom": Family("DICOM", (".dcm", ".dicom", ".ima")),
    "tiff": Family("TIFF", (".tif", ".tiff", ".ome.tif", ".ome.tiff", ".lsm", ".btf", ".tf8")),
    "npy": Family("NumPy", (".npy", ".npz"), writes=(".npy",)),
    "raw": Family("raw samples", (".raw", ".dat", ".bin")),
    "vti": Family("VTK ImageData", (".vti",)),
    "mrc": Family("MRC", (".mrc", ".map", ".rec", ".ccp4", ".mrcs", ".mrc.gz", ".map.gz", ".rec.gz", ".ccp4.gz")),
    "hdf5": Family("HDF5", (".h5", ".hdf5", ".he5", ".ims"), ("netcdf",), extra="hdf5", needs="h5py"),
    "zarr": Family("OME-Zarr", (".zarr", ".ome.zarr"), extra="zarr", needs="zarr", writes=(".zarr",)),
    "netcdf": Family("NetCDF", (".nc", ".nc4", ".cdf"), ("hdf5",), extra="netcdf", needs="h5netcdf and scipy"),
}

EXTENSIONS = {extension: name for name, family in FAMILIES.items() for extension in family.extensions}
VAGUE = {".raw", ".dat", ".bin", ".img", ".hdr", ".map", ".rec", ".ima"}
"""Extensions of many kinds of files: the first bytes decide."""

ZARR_MARKS = ("zarr.json", ".zattrs", ".zgroup", ".zarray")
HEAD_BYTES = 4096
FILES_LOOKED_AT = 1000


def family_of(path: Path) -> str:
    """Key in ``FAMILIES`` of what lies at ``path``.

    Raises
    ------
    FileError
        If nothing is there, nothing is known about it, or its extension and its first bytes contradict each other.
    """
    where = str(path)
    try:
        if path.is_dir():
            return _family_of_folder(path)
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(where, f"cannot be read ({brief(error)})", "check the path") from error
    head = first_bytes(path)
    extension = extension_of(path)
    named, found = EXTENSIONS.get(extension, ""), family_of_bytes(head)
    if not named or extension in VAGUE:
        if found or named:
            return found or named
        raise FileError(where, "is of no kind that airlight knows", f"it reads {_titles()}; for raw samples pass shape=")
    if found and found != named and found not in FAMILIES[named].magics:
        proper = FAMILIES[found].extensions[0]
        raise FileError(
            where, f"is named {extension} and holds {FAMILIES[found].title}", f"rename it so that it ends in {proper}"
        )
    return named


def first_bytes(path: Path) -> bytes:
    """What a plain file begins with; everything else that a path may name is refused."""
    where = str(path)
    try:
        if not path.exists():
            raise FileError(where, "does not exist", "check the path")
        if not path.is_file():
            raise FileError(where, "is no plain file", "copy what it yields into a file")
        if path.stat().st_size == 0:
            raise FileError(where, "is empty", "fetch or write the file again")
        with path.open("rb") as file:
            return file.read(HEAD_BYTES)
    except PermissionError as error:
        raise FileError(where, "may not be read", "ask its owner for the permission") from error
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(where, f"cannot be read ({brief(error)})", "check the path") from error


def extension_of(path: Path) -> str:
    """Longest known extension of a name, else its last suffix, in lower case."""
    name = path.name.lower()
    fitting = [extension for extension in EXTENSIONS if name.endswith(extension) and name != extension]
    return max(fitting, key=len) if fitting else path.suffix.lower()


def family_of_bytes(head: bytes) -> str:
    """Family told by a file's first bytes; empty if they tell none."""
    if head[:2] == b"\x1f\x8b":
        try:
            head = zlib.decompressobj(31).decompress(head, HEAD_BYTES)
        except zlib.error:
            return ""
        return _told(head, ("nifti", "mrc"))
    return _told(head, tuple(FAMILIES))


def _told(head: bytes, among: tuple[str, ...]) -> str:
    signs = {
        "nrrd": head.startswith(b"NRRD000"),
        "nifti": head[344:348] in (b"n+1\0", b"ni1\0") or head[4:8] in (b"n+2\0", b"ni2\0"),
        "metaimage": head.startswith((b"ObjectType", b"NDims")) and b"DimSize" in head,
        "dicom": head[128:132] == b"DICM",
        "tiff": head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
        "npy": head.startswith((b"\x93NUMPY", b"PK\3\4")),
        "vti": b"<VTKFile" in head[:1024],
        "mrc": head[208:212] == b"MAP " and len(head) >= 1024,
        "hdf5": head.startswith(b"\x89HDF\r\n\x1a\n"),
        "netcdf": head[:4] in (b"CDF\1", b"CDF\2", b"CDF\5"),
        "raw": b"ObjectFileName:" in head,
    }
    return next((name for name, told in signs.items() if told and name in among), "")


def _family_of_folder(path: Path) -> str:
    if extension_of(path) == ".zarr" or any((path / mark).exists() for mark in ZARR_MARKS):
        return "zarr"
    names = []
    for number, entry in enumerate(sorted(path.iterdir())):
        if number >= FILES_LOOKED_AT:
            break
        if entry.is_file():
            if extension_of(entry) == ".dcm" or entry.name == "DICOMDIR" or _is_dicom(entry):
                return "dicom"
            names.append(entry.name)
        elif entry.is_dir() and any((entry / mark).exists() for mark in ZARR_MARKS):
            names.append(entry.name)
    readable = [name for name in names if extension_of(Path(name)) in EXTENSIONS]
    remedy = f"name one of its files, e.g. {readable[0]}" if readable else f"airlight reads {_titles()}"
    raise FileError(str(path), "is a folder without DICOM files and no OME-Zarr", remedy)


def _is_dicom(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(132)[128:] == b"DICM"
    except OSError:
        return False


def _titles() -> str:
    return ", ".join(family.title for family in FAMILIES.values())
