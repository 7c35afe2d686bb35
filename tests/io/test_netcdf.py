"""NetCDF 3 and 4: CF coordinates, missing values, packing; damage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import COUNTS, open_damaged_elsewhere

from airlight import io
from airlight.errors import DataError, FileError

h5netcdf = pytest.importorskip("h5netcdf")
scipy_io = pytest.importorskip("scipy.io")

Told = dict[str, tuple[np.ndarray, dict[str, Any]]]


def write(path: Path, dims: str, array: np.ndarray, coordinates: Told, attributes: dict[str, Any], *, classic: bool) -> Path:
    """A file with the variable ``v`` along ``dims`` (names split by spaces)."""
    names = dims.split()
    if classic:
        with scipy_io.netcdf_file(str(path), "w", version=2) as file:
            for name, count in zip(names, array.shape, strict=True):
                file.createDimension(name, count)
            for name, (values, told) in coordinates.items():
                variable = file.createVariable(name, values.dtype, (name,))
                variable[:] = values
                for key, value in told.items():
                    setattr(variable, key, value)
            variable = file.createVariable("v", array.dtype, names)
            variable[:] = array
            for key, value in attributes.items():
                setattr(variable, key, value)
            del variable
        return path
    with h5netcdf.File(str(path), "w") as file:
        file.dimensions = dict(zip(names, array.shape, strict=True))
        for name, (values, told) in coordinates.items():
            file.create_variable(name, (name,), data=values).attrs.update(told)
        variable = file.create_variable("v", tuple(names), data=array)
        variable.attrs.update(attributes)
    return path


@pytest.fixture(params=[True, False], ids=["classic", "netcdf4"])
def classic(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


def test_earth(tmp_path: Path, classic: bool) -> None:
    array = np.arange(120, dtype=np.float32).reshape(2, 3, 4, 5)
    array[0, 0, 0, 0] = 1e20
    coordinates: Told = {
        "time": (np.array([6.0, 12.0]), {"units": "hours since 2000-01-01"}),
        "lev": (np.array([1000.0, 900, 800]), {"units": "hPa", "positive": "down"}),
        "lat": (np.linspace(50, 47, 4), {"units": "degrees_north"}),
        "lon": (np.arange(5.0) * 2, {"units": "degrees_east"}),
    }
    told = {"units": "K", "_FillValue": np.float32(1e20)}
    volume = io.open(write(tmp_path / "f.nc", "time lev lat lon", array, coordinates, told, classic=classic))
    np.testing.assert_array_equal(volume.array, array[:, None])
    expected = [[2, 0, 0, 0], [0, -1, 0, 50], [0, 0, 100, -1000], [0, 0, 0, 1]]
    np.testing.assert_allclose(volume.world_from_index, expected)
    assert (volume.times, volume.time_unit) == ((6, 12), "hours")
    assert (volume.value_unit, volume.no_data, volume.dtype) == ("K", np.float32(1e20), np.float32)


def test_packed(tmp_path: Path, classic: bool) -> None:
    array = np.arange(60, dtype=np.int16).reshape(3, 4, 5)
    told = {"scale_factor": 0.5, "add_offset": 100.0, "_FillValue": np.int16(0), "missing_value": np.int16(7)}
    volume = io.open(write(tmp_path / "f.nc", "z y x", array, {}, told, classic=classic))
    expected = np.where((array == 0) | (array == 7), np.nan, array * 0.5 + 100)
    np.testing.assert_array_equal(volume.array, expected)
    assert volume.no_data is None
    assert volume.units == ""


def test_order_and_channels(tmp_path: Path, classic: bool) -> None:
    array = np.arange(120, dtype=np.int32).reshape(5, 4, 3, 2)
    coordinates: Told = {n: (np.arange(k) * 0.5, {"units": "um"}) for n, k in (("x", 5), ("y", 4), ("z", 3))}
    volume = io.open(write(tmp_path / "f.nc", "x y z member", array, coordinates, {}, classic=classic))
    np.testing.assert_array_equal(volume.array, array.transpose())
    assert (volume.spacing, volume.units) == ((0.5, 0.5, 0.5), "um")


def test_mixed_lengths_get_one_unit(tmp_path: Path, classic: bool) -> None:
    array = np.zeros((3, 4, 5), np.float32)
    coordinates: Told = {
        "z": (np.arange(3.0), {"units": "m"}),
        "y": (np.arange(4.0), {"units": "km"}),
        "x": (np.arange(5.0), {"units": "km"}),
    }
    volume = io.open(write(tmp_path / "f.nc", "z y x", array, coordinates, {}, classic=classic))
    np.testing.assert_allclose(volume.spacing, (1, 1, 0.001))
    assert volume.units == "km"


def test_uneven_is_refused(tmp_path: Path, classic: bool) -> None:
    coordinates: Told = {"y": (np.array([0.0, 1, 2, 6]), {})}
    path = write(tmp_path / "f.nc", "z y x", np.zeros((3, 4, 5), np.float32), coordinates, {}, classic=classic)
    with pytest.raises(DataError, match=r"v: y is uneven: .* 2 is followed by 6: resample"):
        io.open(path)


def test_choice(tmp_path: Path, ramp: np.ndarray) -> None:
    with h5netcdf.File(str(tmp_path / "f.nc"), "w") as file:
        file.dimensions = {"z": 3, "y": 4, "x": 5}
        file.create_variable("a", ("z", "y", "x"), data=ramp)
        file.create_variable("group/b", ("z", "y", "x"), data=ramp + 1)
    with pytest.raises(DataError, match=r"holds 2 variables .*a \(3, 4, 5\), group/b"):
        io.open(tmp_path / "f.nc")
    np.testing.assert_array_equal(io.open(tmp_path / "f.nc", dataset="group/b").array, ramp + 1)
    with pytest.raises(DataError, match="no variable 'q'"):
        io.open(tmp_path / "f.nc", dataset="q")


def test_truncated(tmp_path: Path, ramp: np.ndarray, classic: bool) -> None:
    whole = write(tmp_path / "f.nc", "z y x", ramp, {}, {}, classic=classic).read_bytes()
    for end in (5, 60, len(whole) // 2 if classic else len(whole) - 9, len(whole) - 4):
        (tmp_path / "t.nc").write_bytes(whole[:end])
        with pytest.raises(FileError):
            io.open(tmp_path / "t.nc")


@pytest.mark.parametrize("count", COUNTS)
def test_damaged_files_give_one_error(tmp_path: Path, ramp: np.ndarray, count: int) -> None:
    coordinates: Told = {"z": (np.arange(3.0), {"units": "m"}), "x": (np.arange(5.0), {"units": "m"})}
    told = {"_FillValue": np.int16(4)}
    seeds = [write(tmp_path / f"{i}.nc", "z y x", ramp, coordinates, told, classic=i == 0) for i in range(2)]
    open_damaged_elsewhere(seeds, tmp_path / "t.nc", count)
