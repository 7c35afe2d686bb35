"""NetCDF 3 (through scipy) and 4 (through h5netcdf), with CF coordinates, fill values and packing."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import AirlightError, DataError, FileError, MissingExtraError
from ..volume import AnyArray, FloatArray, Source, Volume, unmistakable
from .netcdf_axes import axis_letters, world
from .options import ReadOptions
from .samples import byte_count, check_kind

SLAB_BYTES = 32 << 20


def read(path: Path, options: ReadOptions) -> Volume:
    """Read one variable.

    ``options.dataset`` is its name (with its groups: ``group/name``); it may be left out where only one variable has 3 to
    5 dimensions. Axes are told by CF attributes or names of their coordinates; one more dimension becomes the channels.
    Coordinates must be even; those marked ``positive: down`` are negated, so that up is up. Packed values are unpacked to
    float32 with NaN where nothing was measured, others keep their type and the fill value as ``no_data``.

    Raises
    ------
    DataError
        For uneven coordinates, or several variables without a choice.
    """
    with _variables(path) as variables:
        chosen = variables[_choose(variables, path, options)]
        where = f"{path}: {chosen.name}"
        letters = axis_letters(chosen.dims, _coordinates(chosen, variables), where)
        matrix, units = world(chosen.dims, letters, _coordinates(chosen, variables), where)
        array, no_data = _unpacked(_samples(chosen, where, options), chosen.attributes, where)
        times, time_unit = _times(chosen, letters, variables)
        unit = _text(chosen.attributes.get("units", ""))
        order = [letters.index(a) for a in "tczyx" if a in letters]
        array = array.transpose(order)
        if "z" not in letters:
            array = np.expand_dims(array, -3)
        if "t" in letters and "c" not in letters:
            array = array[:, None]
        return Volume(
            unmistakable(np.ascontiguousarray(array)),
            world_from_index=matrix,
            units=units,
            value_unit="" if unit == "1" else unit,
            times=times,
            time_unit=time_unit,
            no_data=no_data,
            name=path.name,
            source=Source(str(path), chosen.name),
        )


@dataclass(frozen=True)
class Variable:
    """A variable of either library."""

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: Mapping[str, Any]
    data: Any


@contextmanager
def _variables(path: Path) -> Iterator[dict[str, Variable]]:
    with path.open("rb") as stream:
        magic = stream.read(4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with _opened(path, magic) as file:
                yield dict(_classic(file) if magic[:3] == b"CDF" else _groups(file, ""))
        except AirlightError:
            raise
        except Exception as error:
            raise FileError(str(path), f"cannot be read as NetCDF ({type(error).__name__}: {error})") from error


def _opened(path: Path, magic: bytes) -> Any:
    try:
        if magic[:3] == b"CDF":
            if magic[3:] == b"\x05":
                raise FileError(str(path), "is NetCDF-5 (64-bit data)", "convert it: nccopy -k netCDF-4 IN OUT")
            from scipy.io import netcdf_file

            return netcdf_file(str(path), "r", mmap=True)
        import h5netcdf

        return h5netcdf.File(str(path), "r", phony_dims="access")
    except ImportError as error:
        raise MissingExtraError(str(path), f"needs {error.name} to be read", 'pip install "airlight[netcdf]"') from error


def _classic(file: Any) -> Iterator[tuple[str, Variable]]:
    for name, item in file.variables.items():
        yield name, Variable(name, tuple(item.dimensions), tuple(item.shape), item.data.dtype, item._attributes, item.data)


def _groups(group: Any, prefix: str) -> Iterator[tuple[str, Variable]]:
    for name, item in group.variables.items():
        dtype = np.dtype(item.dtype) if isinstance(item.dtype, (np.dtype, type)) else np.dtype("O")
        full = prefix + name
        yield full, Variable(full, tuple(item.dimensions), tuple(item.shape), dtype, dict(item.attrs), item)
    for name, child in group.groups.items():
        yield from _groups(child, f"{prefix}{name}/")


def _choose(variables: dict[str, Variable], path: Path, options: ReadOptions) -> str:
    names = [n for n, v in variables.items() if v.dtype.kind in "biufc" and len(v.shape) in (3, 4, 5) and 0 not in v.shape]
    told = ", ".join(f"{n} {variables[n].shape}" for n in names[:20])
    wanted = options.dataset.strip("/")
    if wanted:
        if wanted not in variables or len(variables[wanted].shape) not in (2, 3, 4, 5):
            raise DataError(
                str(path), f"has no variable {wanted!r} of 3 to 5 dimensions", f"choose one of {told}" if told else ""
            )
        return wanted
    if len(names) != 1:
        remedy = f"choose one (--dataset, dataset=): {told}" if names else ""
        raise DataError(str(path), f"holds {len(names)} variables of 3 to 5 dimensions", remedy)
    return names[0]


def _coordinates(variable: Variable, variables: dict[str, Variable]) -> dict[str, tuple[FloatArray, dict[str, str]]]:
    """Values and attributes of the coordinate of each dimension that has one; the nearest group's counts."""
    found = {}
    for dim in variable.dims:
        parts = variable.name.split("/")[:-1]
        for depth in range(len(parts), -1, -1):
            item = variables.get("/".join([*parts[:depth], dim]))
            if item is not None and len(item.shape) == 1 and item.dtype.kind in "iuf":
                texts = {str(k): _text(v) for k, v in item.attributes.items() if isinstance(v, (str, bytes))}
                found[dim] = np.array(item.data[...], dtype=np.float64), texts
                break
    return found


def _times(variable: Variable, letters: str, variables: dict[str, Variable]) -> tuple[tuple[float, ...], str]:
    if "t" not in letters:
        return (), ""
    coordinate = _coordinates(variable, variables).get(variable.dims[letters.index("t")])
    if coordinate is None:
        return (), ""
    return tuple(map(float, coordinate[0])), coordinate[1].get("units", "").partition(" since ")[0]


# -- samples


def _samples(variable: Variable, where: str, options: ReadOptions) -> AnyArray:
    check_kind(where, variable.dtype)
    byte_count(where, variable.dtype, variable.shape, options)
    row = math.prod(variable.shape[1:]) * variable.dtype.itemsize
    slab = max(1, SLAB_BYTES // max(1, row))
    array = np.empty(variable.shape, variable.dtype.newbyteorder("="))
    for start in range(0, variable.shape[0], slab):
        options.progress("reading NetCDF", start, variable.shape[0])
        array[start : start + slab] = variable.data[start : start + slab]
    return array


def _unpacked(array: AnyArray, attributes: Mapping[str, Any], where: str) -> tuple[AnyArray, float | None]:
    """Values as CF means them: unsigned, filled, scaled."""
    if _text(attributes.get("_Unsigned", "")).lower() == "true" and array.dtype.kind == "i":
        array = array.view(f"u{array.dtype.itemsize}")
    fills = [f for key in ("_FillValue", "missing_value") for f in _numbers(attributes.get(key), array.dtype)]
    scale, offset = (_numbers(attributes.get(key), np.dtype(float)) for key in ("scale_factor", "add_offset"))
    if not scale and not offset:
        for other in fills[1:]:
            if other != fills[0] and np.isfinite(other):
                array[array == other] = fills[0]
        return array, next((float(f) for f in fills if np.isfinite(f)), None)
    if not np.isfinite([*scale, *offset]).all() or scale[:1] == [0]:
        raise FileError(where, f"has scale_factor {scale} and add_offset {offset}")
    wide = np.float64 if array.dtype.itemsize > 4 else np.float32
    out = array.astype(wide)
    np.multiply(out, wide(scale[0] if scale else 1), out=out)
    np.add(out, wide(offset[0] if offset else 0), out=out)
    for fill in fills:
        out[array == fill] = np.nan
    return out, None


def _numbers(value: Any, dtype: np.dtype[Any]) -> list[Any]:
    """Attribute values in the type of the samples, which fill values are compared in."""
    if value is None or isinstance(value, (str, bytes)):
        return []
    values = np.ravel(np.asarray(value))
    if values.dtype.kind not in "iuf":
        return []
    with np.errstate(all="ignore"):
        return [v for v in values.astype(dtype) if dtype.kind == "f" or float(v) in values.astype(float)] or []


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
