"""OME-Zarr 0.5 (Zarr 3): an image with its pyramid of means, written beside its place and then moved there."""

from __future__ import annotations

import os
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DataError, FileError, MissingExtraError
from ..volume import AnyArray, FloatArray, Volume, is_empty

COARSEST = 128
"""Levels are added until no side is longer."""

CHUNK = 64
LONG_UNITS = {
    "mm": "millimeter",
    "um": "micrometer",
    "nm": "nanometer",
    "cm": "centimeter",
    "m": "meter",
    "km": "kilometer",
    "inch": "inch",
    "angstrom": "angstrom",
    "s": "second",
    "ms": "millisecond",
    "us": "microsecond",
    "min": "minute",
    "h": "hour",
}


def write(volume: Volume, path: Path, *, levels: int | None = None) -> None:
    """Write a volume as OME-Zarr 0.5.

    Each level halves the axes that are sampled finest by the mean of 2 samples an axis (labels: every second sample),
    until no side is longer than 128, or ``levels`` are there. Empty samples stay out of means. An older Zarr folder of
    that name is replaced once the new one is complete.

    Raises
    ------
    DataError
        For volumes that are turned or sheared: OME-Zarr 0.5 holds a scale and a translation only.
    """
    try:
        import zarr
    except ImportError as error:
        raise MissingExtraError(str(path), "needs zarr to be written", 'pip install "airlight[zarr]"') from error
    matrix = volume.world_from_index
    if np.abs(matrix[:3, :3] - np.diag(np.diag(matrix[:3, :3]))).max() > 1e-9 * max(volume.spacing):
        raise DataError(str(path), "cannot hold a turned or sheared volume", "save it as .nrrd or .nii.gz")
    _check_place(path)
    try:
        folder = Path(tempfile.mkdtemp(prefix=".airlight-", suffix=".zarr", dir=path.parent))
    except OSError as error:
        raise FileError(str(path), f"cannot be written ({error.strerror})", "choose a folder that is there") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            _fill(zarr.open_group(folder, mode="w", zarr_format=3), volume, levels)
        mask = os.umask(0)
        os.umask(mask)
        folder.chmod(0o777 & ~mask)  # mkdtemp makes folders that only their owner reads
        _move(folder, path)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def pooled(volume: Volume, array: AnyArray, factors: tuple[int, int, int]) -> AnyArray:
    """``array`` with every ``factors`` (z, y, x) samples made one: their mean, or the first of labels."""
    if volume.modality == "labels" or array.dtype.kind == "b":
        return array[..., :: factors[0], :: factors[1], :: factors[2]]
    shape = (*array.shape[:-3], *(-(-n // f) for n, f in zip(array.shape[-3:], factors, strict=True)))
    out = np.empty(shape, array.dtype)
    for place in np.ndindex(*array.shape[:-3]):
        for z in range(shape[-3]):
            slab = array[place][z * factors[0] : (z + 1) * factors[0]]
            out[place][z] = _mean(slab, factors, volume.no_data)
    return out


def _mean(slab: AnyArray, factors: tuple[int, int, int], no_data: float | None) -> AnyArray:
    # a last odd sample is repeated, so that all means lie on one grid
    pads = [(0, -n % f) for n, f in zip(slab.shape, factors, strict=True)]
    if any(p for _, p in pads):
        slab = np.pad(slab, pads, mode="edge")
    z, y, x = (n // f for n, f in zip(slab.shape, factors, strict=True))
    cells = slab.reshape(z, factors[0], y, factors[1], x, factors[2])
    empty = is_empty(cells, no_data)
    if empty is None:
        mean = cells.mean(axis=(1, 3, 5), dtype=np.float64)[0]
        return np.asarray(np.rint(mean) if slab.dtype.kind in "iu" else mean).astype(slab.dtype)
    count = (~empty).sum(axis=(1, 3, 5))[0]
    total = np.where(empty, 0, cells).sum(axis=(1, 3, 5), dtype=np.float64)[0]
    mean = total / np.maximum(count, 1)
    filler = np.nan if no_data is None else no_data
    mean = np.rint(mean) if slab.dtype.kind in "iu" else mean
    return np.where(count > 0, mean, filler).astype(slab.dtype)


def _fill(group: Any, volume: Volume, levels: int | None) -> None:
    array = volume.array
    axes = "tczyx"[-array.ndim :]
    matrix = np.array(volume.world_from_index)
    datasets: list[dict[str, Any]] = []
    while True:
        name = str(len(datasets))
        chunks = tuple(1 if a in "tc" else min(n, CHUNK) for a, n in zip(axes, array.shape, strict=True))
        target = group.create_array(name, shape=array.shape, dtype=array.dtype, chunks=chunks, dimension_names=list(axes))
        for place in np.ndindex(*array.shape[:-3]):
            target[place] = array[place]
        datasets.append({"path": name, "coordinateTransformations": _transformations(matrix, axes, volume)})
        if len(datasets) == levels or (levels is None and max(array.shape[-3:]) <= COARSEST) or max(array.shape[-3:]) == 1:
            break
        factors = _factors(matrix, array.shape[-3:])
        array = pooled(volume, array, factors)
        shift = np.array(factors[::-1]) / 2 - 0.5 if volume.modality != "labels" and array.dtype.kind != "b" else np.zeros(3)
        matrix[:3, 3] += matrix[:3, :3] @ shift
        matrix[:3, :3] = matrix[:3, :3] * np.array(factors[::-1])
    group.attrs.update(_attributes(volume, axes, datasets))


def _factors(matrix: FloatArray, shape: tuple[int, ...]) -> tuple[int, int, int]:
    """Halve the axes that are sampled finest, and any that is about as fine."""
    spacing = np.abs(np.diag(matrix)[:3])[::-1]
    long = np.array(shape) > 1
    finest = spacing[long].min()
    z, y, x = (2 if n > 1 and s < 1.5 * finest else 1 for n, s in zip(shape, spacing, strict=True))
    return z, y, x


def _transformations(matrix: FloatArray, axes: str, volume: Volume) -> list[dict[str, Any]]:
    step = volume.times[1] - volume.times[0] if len(volume.times) > 1 else 1.0
    start = volume.times[0] if volume.times else 0.0
    if len(volume.times) > 2 and not np.allclose(np.diff(volume.times), step, rtol=1e-6):
        raise DataError("volume.times", "are uneven, OME-Zarr holds one step of time", "choose even times")
    place = {"t": (step, start), "c": (1.0, 0.0)} | {a: (matrix[i, i], matrix[i, 3]) for i, a in enumerate("xyz")}
    scale, shift = ([float(place[a][i]) for a in axes] for i in (0, 1))
    return [{"type": "scale", "scale": scale}, {"type": "translation", "translation": shift}]


def _attributes(volume: Volume, axes: str, datasets: list[dict[str, Any]]) -> dict[str, Any]:
    told: list[dict[str, str]] = []
    for a in axes:
        axis = {"name": a, "type": {"t": "time", "c": "channel"}.get(a, "space")}
        unit = {"t": volume.time_unit, "c": ""}.get(a, volume.units)
        told.append(axis | ({"unit": LONG_UNITS.get(unit, unit)} if unit else {}))
    pooling = "labels: every second sample" if volume.modality == "labels" or volume.dtype == bool else "mean"
    ome: dict[str, Any] = {
        "version": "0.5",
        "multiscales": [{"name": "image", "axes": told, "datasets": datasets, "type": pooling}],
    }
    if volume.channel_names:
        ome["omero"] = {"channels": [{"label": n, "color": "FFFFFF", "active": True} for n in volume.channel_names]}
        for channel, window in zip(ome["omero"]["channels"], _windows(volume), strict=True):
            channel["window"] = window
    own: dict[str, Any] = {"value_unit": volume.value_unit, "modality": volume.modality, "anatomical": volume.anatomical}
    if volume.no_data is not None and np.isfinite(volume.no_data):
        own["no_data"] = volume.no_data
    return {"ome": ome, "airlight": own}


def _windows(volume: Volume) -> list[dict[str, float]]:
    windows = []
    for c in range(volume.channel_count):
        grid = volume.grid(c)
        empty = is_empty(grid, volume.no_data)
        values = grid if empty is None else grid[~empty]
        low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
        windows.append({"min": low, "max": high, "start": low, "end": high})
    return windows


def _check_place(path: Path) -> None:
    if path.exists() and not (path.is_dir() and any((path / n).is_file() for n in ("zarr.json", ".zgroup", ".zattrs"))):
        raise FileError(str(path), "is there and is no Zarr folder", "choose another name")


def _move(folder: Path, path: Path) -> None:
    """Put the folder in its place; folders cannot be replaced in one step, so an older one steps aside."""
    if not path.exists():
        os.replace(folder, path)
        return
    aside = folder.with_name(folder.name + ".old")
    os.replace(path, aside)
    try:
        os.replace(folder, path)
    except OSError:
        os.replace(aside, path)
        raise
    shutil.rmtree(aside, ignore_errors=True)
