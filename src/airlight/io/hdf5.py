"""HDF5: one dataset of a file, with the axes, sizes and units that its attributes tell; Imaris files as one volume."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError, MissingExtraError
from ..volume import AnyArray, Source, Volume, affine, unmistakable
from .given import recipe
from .hdf5_imaris import read_imaris
from .options import ReadOptions
from .paths import detached
from .samples import byte_count, check_kind
from .units import unit_name

SLAB_BYTES = 32 << 20


def read(path: Path, options: ReadOptions) -> Volume:
    """Read one dataset.

    ``options.dataset`` is its path inside the file; it may be left out where the file holds exactly one numeric dataset
    of 3 to 5 dimensions. Axes come from dimension labels or ilastik's ``axistags``, else they are ``(z, y, x)``,
    ``(c, z, y, x)`` or ``(t, c, z, y, x)``. The attributes ``element_size_um``, or ``spacing`` and ``units``, give the
    sizes in the order of the axes (z, y, x).
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingExtraError(str(path), "needs h5py to be read", 'pip install "airlight[hdf5]"') from error
    try:
        file = h5py.File(path, "r")
    except (OSError, RuntimeError) as error:
        raise FileError(str(path), f"cannot be opened as HDF5 ({error})", "copy or write it again") from error
    with file:
        if "DataSetInfo" in file and "DataSet" in file and not options.dataset:
            return read_imaris(file, path, options)
        dataset = _dataset(h5py, file, path, options)
        where = f"{path}: {dataset.name}"
        _check_storage(dataset, path, where)
        axes = _axes(dataset, where)
        array = _ordered(read_dataset(dataset, where, options), axes)
        told, units = _spacing(dataset, axes)
        given = options.spacing if told is None else None
        names = tuple(_text(n) for n in np.ravel(dataset.attrs.get("channel_names", ())))
        fill = dataset.attrs.get("_FillValue")
        return Volume(
            unmistakable(array) if any(_told_axes(dataset)) else array,
            world_from_index=affine(told or given or (1.0, 1.0, 1.0), (0, 0, 0), where),
            units=units,
            value_unit=_text(dataset.attrs.get("value_unit", "")),
            channel_names=names if array.ndim > 3 and len(names) == array.shape[-4] else (),
            no_data=float(np.ravel(fill)[0]) if fill is not None and np.size(fill) else None,
            name=path.name,
            source=Source(str(path), dataset.name, options=recipe(given)),
        )


def read_dataset(dataset: Any, where: str, options: ReadOptions) -> AnyArray:
    """All samples of a dataset, in slabs with progress."""
    check_kind(where, dataset.dtype)
    byte_count(where, dataset.dtype, dataset.shape, options)
    array = np.empty(dataset.shape, dataset.dtype)
    row = max(1, array.nbytes // max(1, len(array)))
    chunk = dataset.chunks[0] if dataset.chunks else 1
    slab = max(1, SLAB_BYTES // row // chunk) * chunk
    try:
        for start in range(0, len(array), slab):
            options.progress("reading HDF5", start, len(array))
            place = np.s_[start : start + slab]
            dataset.read_direct(array, place, place)
    except (OSError, RuntimeError) as error:
        told = "install the filter it names" if "filter" in str(error) else "copy or write it again"
        raise FileError(where, f"cannot be read ({error})", told) from error
    return array


def _dataset(h5py: Any, file: Any, path: Path, options: ReadOptions) -> Any:
    found = _candidates(h5py, file)
    told = ", ".join(f"{name} {shape} {dtype}" for name, shape, dtype in found[:20]) or "none of 3 to 5 dimensions"
    name = options.dataset
    if not name:
        if len(found) != 1:
            remedy = f"choose one by its path (--dataset, dataset=): {told}"
            raise DataError(str(path), f"holds {len(found)} datasets of 3 to 5 dimensions", remedy if found else "")
        return file[found[0][0]]
    _check_links(h5py, file, path, name)
    item = file.get(name)
    if not isinstance(item, h5py.Dataset):
        raise DataError(str(path), f"has no dataset {name!r}", f"choose one of {told}")
    if len(item.shape or ()) not in (3, 4, 5):
        raise DataError(f"{path}: {name}", f"has the shape {item.shape}, must have 3 to 5 dimensions", f"choose one of {told}")
    return item


def _candidates(h5py: Any, file: Any) -> list[tuple[str, tuple[int, ...], str]]:
    found: list[tuple[str, tuple[int, ...], str]] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and len(item.shape or ()) in (3, 4, 5) and item.dtype.kind in "biufc":
            found.append(("/" + name, item.shape, str(item.dtype)))

    file.visititems(visit)
    return found


def _check_links(h5py: Any, file: Any, path: Path, name: str) -> None:
    """Refuse paths that lead into other files."""
    parts = [p for p in name.split("/") if p]
    for count in range(1, len(parts) + 1):
        link = file.get("/".join(parts[:count]), getlink=True) if "/".join(parts[: count - 1]) in file or count == 1 else None
        if isinstance(link, h5py.ExternalLink):
            raise FileError(f"{path}: {name}", f"is a link into the file {link.filename!r}", "open that file")


def _check_storage(dataset: Any, path: Path, where: str) -> None:
    """Samples kept in other files must lie beside this one."""
    for name, *_ in dataset.external or ():
        detached(path, _text(name), "external storage")
    if dataset.is_virtual:
        for source in dataset.virtual_sources():
            if source.file_name != ".":
                detached(path, source.file_name, "virtual dataset")


# -- what the attributes say


def _axes(dataset: Any, where: str) -> str:
    axes = "".join(_told_axes(dataset)).lower()
    if not axes:
        return "tczyx"[-len(dataset.shape) :]
    if len(axes) != len(dataset.shape) or len(set(axes)) != len(axes) or not set("zyx") <= set(axes) <= set("tczyx"):
        raise DataError(where, f"has axes {axes!r}, must be x, y, z, and c or t", "write it in the order t, c, z, y, x")
    return axes


def _told_axes(dataset: Any) -> Iterator[str]:
    tags = dataset.attrs.get("axistags")
    if tags is not None:
        try:
            yield from (str(a["key"]) for a in json.loads(_text(tags))["axes"])
        except (ValueError, KeyError, TypeError) as error:
            raise DataError(dataset.name, f"has axistags that cannot be read ({error})") from error
        return
    labels = [_text(d.label) for d in dataset.dims]
    if all(len(label) == 1 for label in labels):
        yield from labels


def _ordered(array: AnyArray, axes: str) -> AnyArray:
    array = array.transpose([axes.index(a) for a in "tczyx" if a in axes])
    if "t" in axes and "c" not in axes:
        array = array[:, None]
    return np.ascontiguousarray(array)


def _spacing(dataset: Any, axes: str) -> tuple[tuple[float, float, float] | None, str]:
    attrs = dataset.attrs
    for key, unit in (("element_size_um", "um"), ("spacing", _text(attrs.get("units", attrs.get("unit", ""))))):
        told = attrs.get(key)
        if told is None:
            continue
        try:
            sizes = [float(v) for v in np.ravel(told)]
        except (TypeError, ValueError):
            sizes = []
        if len(sizes) == len(axes) and len(sizes) > 3:
            sizes = [sizes[axes.index(a)] for a in "zyx"]
        if len(sizes) != 3 or not all(math.isfinite(s) and s > 0 for s in sizes):
            raise DataError(f"{dataset.name}.{key}", f"is {told}, must be three positive numbers (z, y, x)")
        return (sizes[2], sizes[1], sizes[0]), unit_name(unit)
    return None, ""


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size == 1 else b"".join(np.asarray(value, dtype="S").ravel())
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
