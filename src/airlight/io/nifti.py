"""NIfTI-1 and -2: ``.nii``, ``.nii.gz``, ``.hdr`` with ``.img``. nibabel parses the header; the samples are read here, bounded.

nibabel takes a third of a second to import, so only the functions that need it do.
"""

from __future__ import annotations

import io
import logging
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from ..files import replacing
from ..volume import Source, Volume, unmistakable
from .messages import shown
from .options import ReadOptions
from .paths import detached
from .samples import AnyArray, check_kind, codec_of, load, scaled, stream
from .units import MILLIMETRES, in_lps, in_millimetres, unit_name

NOT_PATIENT = "airlight: not patient space"
LABEL_INTENT = 1002
VECTOR_INTENT = 1007
LARGEST_AXIS = 32767  # of NIfTI-1


def read(path: Path, options: ReadOptions) -> Volume:
    """Volume in a NIfTI file: nibabel's best affine, turned from RAS to LPS; scaled where the file says so."""
    header, single = _header(path)
    where = str(path)
    shape = tuple(int(n) for n in header.get_data_shape())
    dtype, offset = header.get_data_dtype(), int(header.get_data_offset())
    if dtype.names is None:
        check_kind(where, dtype)
    shape = _checked_shape(shape, where)
    least = int(header["sizeof_hdr"]) if single else 0
    if offset < least:
        raise FileError(f"{where}: vox_offset", f"is {offset}, inside of the header", "write the file again")
    data_path = path if single else _image_path(path)
    codec = codec_of(data_path)
    if codec:
        array = load(data_path, dtype, shape[::-1], options, codec=codec, skip=offset)
    else:
        array = load(data_path, dtype, shape[::-1], options, offset=offset)
    names: tuple[str, ...] = ()
    array = _arranged(array)
    if dtype.names is not None:
        array, names = _split_colours(array, where)
    elif (slope := header.get_slope_inter())[0] is not None:
        slope_value, intercept = float(slope[0]), float(slope[1])
        if dtype.kind in "iuf" and (slope_value, intercept) != (1.0, 0.0):
            array = scaled(array, slope_value, intercept, where, options)
    return _volume(path, header, array, names)


def _header(path: Path) -> tuple[Any, bool]:
    """Header (nibabel's), and whether the samples are in the same file."""
    import nibabel

    with stream(path, codec_of(path)) as file:
        head = file.read(540) or b""
    if len(head) < 348:
        raise FileError(str(path), f"is cut short: {len(head)} bytes of a NIfTI header", "fetch or write the file again")
    size = {int.from_bytes(head[:4], order) for order in ("little", "big")}
    if 540 in size:
        kind, magic = nibabel.Nifti2Header, head[4:8]
    elif 348 in size:
        kind, magic = nibabel.Nifti1Header, head[344:348]
    else:
        raise FileError(str(path), "is no NIfTI file: it does not begin with 348 or 540", "check its name and kind")
    if magic[:1] != b"n" or magic[1:2] not in (b"+", b"i"):
        raise FileError(
            str(path),
            "is no NIfTI but perhaps an Analyze 7.5 file, which does not tell left from right",
            "convert it: nibabel.save(nibabel.load(path), 'converted.nii.gz')",
        )
    if 540 in size and len(head) < 540:
        raise FileError(str(path), f"is cut short: {len(head)} bytes of a NIfTI-2 header", "fetch or write the file again")
    # No more than the header: behind it nibabel would look for extensions, which are not needed and may be long.
    header = kind.from_fileobj(io.BytesIO(head[: 540 if 540 in size else 348]), check=False)
    quiet = logging.Logger("airlight.io.nifti")
    quiet.addHandler(logging.NullHandler())
    header.check_fix(logger=quiet, error_level=40)
    return header, magic[1:2] == b"+"


def _image_path(path: Path) -> Path:
    """The ``.img`` beside a ``.hdr``."""
    name = path.name
    for header, image in ((".hdr.gz", ".img.gz"), (".hdr", ".img"), (".HDR", ".IMG")):
        if name.endswith(header):
            for choice in (image, image + ".gz", image.removesuffix(".gz")):
                if path.with_name(name.removesuffix(header) + choice).exists():
                    return detached(path, name.removesuffix(header) + choice, "image")
            return detached(path, name.removesuffix(header) + image, "image")
    raise FileError(str(path), "holds a NIfTI header without samples", "open the .hdr file, with the .img beside it")


def _checked_shape(shape: tuple[int, ...], where: str) -> tuple[int, ...]:
    while len(shape) > 5 and shape[-1] == 1:
        shape = shape[:-1]
    if not 1 <= len(shape) <= 5:
        raise DataError(where, f"has {len(shape)} axes", "a volume has up to 5: x, y, z, time, channels")
    return shape + (1,) * (3 - len(shape))


def _arranged(array: AnyArray) -> AnyArray:
    """``(c, t, z, y, x)`` as ``(t, c, z, y, x)``; 4-D files are time; one step alone is left out."""
    if array.ndim == 5:
        array = array.swapaxes(0, 1)
        return array[0] if array.shape[0] == 1 else array
    if array.ndim == 4:
        return array[0] if array.shape[0] == 1 else array[:, None]
    return array


def _split_colours(array: AnyArray, where: str) -> tuple[AnyArray, tuple[str, ...]]:
    names = {"R": "red", "G": "green", "B": "blue", "A": "alpha"}
    fields = array.dtype.names or ()
    if array.ndim > 3 or not set(fields) <= set(names):
        raise DataError(where, f"has samples of type {shown(array.dtype)}", "write numbers, one channel after the other")
    return np.stack([array[field] for field in fields]), tuple(names[field] for field in fields)


def _volume(path: Path, header: Any, array: AnyArray, names: tuple[str, ...]) -> Volume:
    space, clock = (unit_name(unit) if unit != "unknown" else "" for unit in header.get_xyzt_units())
    said = int(header["sform_code"]) > 0 or int(header["qform_code"]) > 0
    anatomical = said and not bytes(header["descrip"]).startswith(NOT_PATIENT.encode())
    affine = np.asarray(header.get_best_affine(), dtype=np.float64)
    if anatomical:
        affine, space = in_millimetres(affine, space), "mm"
    times: tuple[float, ...] = ()
    zooms = header.get_zooms()
    if array.ndim == 5 and len(zooms) > 3 and zooms[3] > 0:
        times = tuple(float(header["toffset"]) + float(zooms[3]) * i for i in range(array.shape[0]))
    return Volume(
        unmistakable(array),
        world_from_index=in_lps(affine, "RAS"),
        units=space,
        channel_names=names,
        times=times,
        time_unit=clock if times else "",
        anatomical=anatomical,
        modality="labels" if int(header["intent_code"]) == LABEL_INTENT else "",
        name=path.name,
        source=Source(str(path)),
    )


# -- writing


def write(volume: Volume, path: Path) -> None:
    """Write ``.nii`` or ``.nii.gz``: NIfTI-1, whose affine is float32, or NIfTI-2 for axes of more than 32767 voxels.

    NIfTI has no bool and no float16: uint8 and float32 stand for them, without loss.
    """
    import nibabel

    name = path.name.lower()
    if not name.endswith((".nii", ".nii.gz")):
        raise FileError(str(path), "would need two files", "give a name that ends in .nii or .nii.gz")
    array = volume.array.view(np.uint8) if volume.array.dtype == bool else volume.array
    if array.dtype == np.float16:
        array = array.astype(np.float32)
    if array.ndim == 5:
        stored = array.transpose(4, 3, 2, 0, 1)
        stored = stored[..., 0] if stored.shape[-1] == 1 else stored
    else:
        stored = array.transpose(3, 2, 1, 0)[:, :, :, None, :] if array.ndim == 4 else array.T
    unit = volume.units
    matrix = volume.world_from_index
    if unit in MILLIMETRES and unit not in ("m", "mm", "um"):
        matrix, unit = in_millimetres(matrix, unit), "mm"
    kind = nibabel.Nifti2Image if max(stored.shape) > LARGEST_AXIS else nibabel.Nifti1Image
    image = kind(stored, None, dtype=stored.dtype)
    header = image.header
    header.set_data_dtype(stored.dtype)
    header.set_sform(in_lps(matrix, "RAS"), code=1)
    header["pixdim"][1:4] = volume.spacing
    space = {"m": "meter", "mm": "mm", "um": "micron"}.get(unit, "unknown")
    clock = {"s": "sec", "ms": "msec", "us": "usec"}.get(unit_name(volume.time_unit), "unknown")
    header.set_xyzt_units(space, clock)
    if not volume.anatomical:
        header["descrip"] = NOT_PATIENT.encode()
    if volume.modality == "labels":
        header["intent_code"] = LABEL_INTENT
    elif stored.ndim == 5:
        header["intent_code"] = VECTOR_INTENT
    if len(volume.times) > 1:
        header["pixdim"][4] = (volume.times[-1] - volume.times[0]) / (len(volume.times) - 1)
        header["toffset"] = volume.times[0]
    suffix = ".nii.gz" if name.endswith(".gz") else ".nii"
    with replacing(path, suffix) as temporary:
        nibabel.save(image, temporary)
