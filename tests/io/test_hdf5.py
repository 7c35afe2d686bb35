"""HDF5: datasets, axes, sizes; links and storage elsewhere; Imaris; damage."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import COUNTS, open_damaged_elsewhere

from airlight import io
from airlight.errors import DataError, FileError, LimitError, MissingExtraError

h5py = pytest.importorskip("h5py")


def write(path: Path, array: np.ndarray, name: str = "a/b", attributes: dict[str, Any] | None = None, **how: Any) -> Path:
    with h5py.File(path, "a") as file:
        dataset = file.create_dataset(name, data=array, **how)
        dataset.attrs.update(attributes or {})
    return path


@pytest.mark.parametrize("dtype", ["bool", "uint8", ">i2", "<u4", "int64", "float16", ">f8"])
@pytest.mark.parametrize("shape", [(3, 4, 5), (2, 3, 4, 5), (2, 1, 3, 4, 5)])
def test_round_trip(tmp_path: Path, shape: tuple[int, ...], dtype: str) -> None:
    array = np.arange(np.prod(shape)).reshape(shape).astype(dtype)
    volume = io.open(write(tmp_path / "f.h5", array, chunks=True, compression="gzip"))
    np.testing.assert_array_equal(volume.array, array)
    assert (volume.spacing, volume.units) == ((1, 1, 1), "")
    assert volume.source is not None
    assert volume.source.dataset == "/a/b"


def test_dataset_is_chosen(tmp_path: Path, ramp: np.ndarray) -> None:
    path = write(tmp_path / "f.h5", ramp, "x")
    write(path, ramp + 1, "g/y")
    write(path, ramp[0], "flat")
    with pytest.raises(DataError, match=r"holds 2 datasets .*: /g/y .*, /x "):
        io.open(path)
    np.testing.assert_array_equal(io.open(path, dataset="g/y").array, ramp + 1)
    with pytest.raises(DataError, match="no dataset 'q': choose one of /g/y"):
        io.open(path, dataset="q")
    with pytest.raises(DataError, match="must have 3 to 5 dimensions"):
        io.open(path, dataset="flat")


def test_axes_of_ilastik(tmp_path: Path) -> None:
    array = np.arange(120).reshape(3, 4, 5, 2)
    tags = json.dumps({"axes": [{"key": k, "typeFlags": 2} for k in "zyxc"]})
    volume = io.open(write(tmp_path / "f.h5", array, attributes={"axistags": tags}))
    np.testing.assert_array_equal(volume.array, np.moveaxis(array, -1, 0))
    with pytest.raises(DataError, match="axes 'zyxq'"):
        io.open(write(tmp_path / "g.h5", array, attributes={"axistags": tags.replace('"c"', '"q"')}))


def test_dimension_labels(tmp_path: Path, ramp: np.ndarray) -> None:
    path = write(tmp_path / "f.h5", ramp)
    with h5py.File(path, "a") as file:
        for axis, label in enumerate("xyz"):
            file["a/b"].dims[axis].label = label
    np.testing.assert_array_equal(io.open(path).array, ramp.transpose())


def test_sizes(tmp_path: Path, ramp: np.ndarray) -> None:
    volume = io.open(write(tmp_path / "a.h5", ramp, attributes={"element_size_um": [3.0, 0.5, 0.25]}))
    assert (volume.spacing, volume.units) == ((0.25, 0.5, 3.0), "um")
    volume = io.open(write(tmp_path / "b.h5", ramp, attributes={"spacing": [3.0, 0.5, 0.25], "units": "micron"}))
    assert (volume.spacing, volume.units) == ((0.25, 0.5, 3.0), "um")
    assert io.open(write(tmp_path / "c.h5", ramp), spacing=(1, 2, 3)).spacing == (1, 2, 3)
    with pytest.raises(DataError, match="three positive numbers"):
        io.open(write(tmp_path / "d.h5", ramp, attributes={"element_size_um": [3.0, 0.0, 0.25]}))


def test_imaris(tmp_path: Path) -> None:
    def text(value: str) -> np.ndarray:
        return np.array([c.encode() for c in value], dtype="S1")

    array = np.arange(2 * 3 * 4 * 5, dtype=np.uint8).reshape(2, 3, 4, 5)
    with h5py.File(tmp_path / "f.ims", "w") as file:
        image = file.create_group("DataSetInfo/Image")
        told = {"Unit": "um", "ExtMin0": "10", "ExtMax0": "20", "ExtMin1": "0", "ExtMax1": "2", "ExtMin2": "0", "ExtMax2": "9"}
        for key, value in told.items():
            image.attrs[key] = text(value)
        for c in range(2):
            file.create_group(f"DataSetInfo/Channel {c}").attrs["Name"] = text(f"dye {c}")
            channel = file.create_group(f"DataSet/ResolutionLevel 0/TimePoint 0/Channel {c}")
            for a, n in zip("ZYX", (3, 4, 5), strict=True):
                channel.attrs[f"ImageSize{a}"] = text(str(n))
            channel["Data"] = np.pad(array[c], [(0, 5), (0, 4), (0, 3)])
    volume = io.open(tmp_path / "f.ims")
    np.testing.assert_array_equal(volume.array, array)
    assert (volume.spacing, volume.units, volume.channel_names) == ((2, 0.5, 3), "um", ("dye 0", "dye 1"))
    assert volume.origin == (11, 0.25, 1.5)
    with pytest.raises(DataError, match="no level 1"):
        io.open(tmp_path / "f.ims", level=1)


def test_data_elsewhere_is_refused(tmp_path: Path, ramp: np.ndarray) -> None:
    (tmp_path / "in").mkdir()
    write(tmp_path / "other.h5", ramp, "x")
    ramp.tofile(tmp_path / "raw")
    path = tmp_path / "in" / "f.h5"
    with h5py.File(path, "w") as file:
        file["link"] = h5py.ExternalLink("../other.h5", "/x")
        file.create_dataset("raw", ramp.shape, ramp.dtype, external=[("../raw", 0, h5py.h5f.UNLIMITED)])
        layout = h5py.VirtualLayout(ramp.shape, ramp.dtype)
        layout[...] = h5py.VirtualSource("../other.h5", "x", ramp.shape)
        file.create_virtual_dataset("virtual", layout)
    for name in ("link", "raw", "virtual"):
        with pytest.raises(FileError, match=r"link into the file|outside"):
            io.open(path, dataset=name)


def test_complex_and_size(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="complex"):
        io.open(write(tmp_path / "f.h5", np.zeros((2, 3, 4), np.complex64)))
    with h5py.File(tmp_path / "g.h5", "w") as file:
        file.create_dataset("big", (10**4, 10**4, 10**4), "u1", chunks=(64, 64, 64), compression="gzip")
    with pytest.raises(LimitError):
        io.open(tmp_path / "g.h5")


def test_truncated(tmp_path: Path, ramp: np.ndarray) -> None:
    whole = write(tmp_path / "f.h5", np.tile(ramp, (9, 9, 9)), chunks=(3, 3, 3), compression="gzip").read_bytes()
    for end in (9, 100, len(whole) // 2, len(whole) - 1):
        (tmp_path / "t.h5").write_bytes(whole[:end])
        with pytest.raises(FileError):
            io.open(tmp_path / "t.h5")


def test_missing_library_names_the_pip_command(tmp_path: Path, ramp: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    path = write(tmp_path / "f.h5", ramp)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingExtraError, match=r'pip install "airlight\[hdf5\]"'):
        io.open(path)


@pytest.mark.parametrize("count", COUNTS)
def test_damaged_files_give_one_error(tmp_path: Path, ramp: np.ndarray, count: int) -> None:
    seeds = [write(tmp_path / "a.h5", ramp), write(tmp_path / "b.h5", ramp, chunks=(2, 2, 2), compression="gzip")]
    write(tmp_path / "b.h5", ramp, "c", {"element_size_um": [1.0, 2, 3]})
    open_damaged_elsewhere(seeds, tmp_path / "t.h5", count)
