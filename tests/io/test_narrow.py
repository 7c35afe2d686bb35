"""Volumes of three or four voxels along x: their channels are no colours where the file tells what its axes are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from airlight import io
from airlight.errors import DataError
from airlight.volume import Volume

NARROW = np.arange(5 * 6 * 7 * 4, dtype=np.uint8).reshape(5, 6, 7, 4)
"""Five channels, four voxels along x."""
NARROWER = NARROW[:4, ..., :3]
"""Four channels, three voxels along x, for formats of at most four."""


def _nrrd(folder: Path) -> Path:
    head = f"NRRD0004\ntype: uchar\ndimension: 4\nsizes: {' '.join(map(str, NARROW.shape[::-1]))}\nencoding: raw\n"
    path = folder / "v.nrrd"
    path.write_bytes(f"{head}kinds: domain domain domain list\n\n".encode() + NARROW.tobytes())
    return path


def _tiff(folder: Path) -> Path:
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(folder / "v.tif", NARROW, photometric="minisblack", metadata={"axes": "CZYX"}, ome=True)
    return folder / "v.tif"


def _zarr(folder: Path) -> Path:
    zarr = pytest.importorskip("zarr")
    group = zarr.open_group(folder / "v.zarr", mode="w", zarr_format=2)
    group.create_array("0", data=NARROW)
    axes = [{"name": "c", "type": "channel"}, *({"name": a, "type": "space"} for a in "zyx")]
    scale = [{"type": "scale", "scale": [1, 1, 1, 1]}]
    datasets = [{"path": "0", "coordinateTransformations": scale}]
    group.attrs["multiscales"] = [{"version": "0.4", "axes": axes, "datasets": datasets}]
    return folder / "v.zarr"


def _hdf5(folder: Path) -> Path:
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "v.h5", "w") as file:
        file["v"] = NARROW
        for dimension, letter in zip(file["v"].dims, "czyx", strict=True):
            dimension.label = letter
    return folder / "v.h5"


def _imaris(folder: Path) -> Path:
    h5py = pytest.importorskip("h5py")

    def text(value: object) -> np.ndarray:
        return np.array([c.encode() for c in str(value)], dtype="S1")

    with h5py.File(folder / "v.ims", "w") as file:
        image = file.create_group("DataSetInfo/Image")
        for axis, count in enumerate(NARROW.shape[:0:-1]):
            image.attrs[f"ExtMin{axis}"], image.attrs[f"ExtMax{axis}"] = text(0), text(count)
        for c, samples in enumerate(NARROW):
            channel = file.create_group(f"DataSet/ResolutionLevel 0/TimePoint 0/Channel {c}")
            for a, n in zip("ZYX", samples.shape, strict=True):
                channel.attrs[f"ImageSize{a}"] = text(n)
            channel["Data"] = samples
    return folder / "v.ims"


def _netcdf(folder: Path) -> Path:
    h5netcdf = pytest.importorskip("h5netcdf")
    with h5netcdf.File(str(folder / "v.nc"), "w") as file:
        file.dimensions = dict(zip("czyx", NARROW.shape, strict=True))
        file.create_variable("v", tuple("czyx"), data=NARROW)
    return folder / "v.nc"


def _metaimage(folder: Path) -> Path:
    head = "NDims = 3\nDimSize = 4 7 6\nElementNumberOfChannels = 5\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
    (folder / "v.mha").write_bytes(head.encode() + np.moveaxis(NARROW, 0, -1).tobytes())
    return folder / "v.mha"


def _vti(folder: Path) -> Path:
    numbers = " ".join(map(str, np.moveaxis(NARROW, 0, -1).ravel()))
    array = f'<DataArray type="UInt8" Name="v" NumberOfComponents="5" format="ascii">{numbers}</DataArray>'
    image = (
        f'<ImageData WholeExtent="0 3 0 6 0 5"><Piece Extent="0 3 0 6 0 5"><PointData>{array}</PointData></Piece></ImageData>'
    )
    (folder / "v.vti").write_text(f'<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">{image}</VTKFile>')
    return folder / "v.vti"


@pytest.mark.parametrize("write", [_nrrd, _tiff, _zarr, _hdf5, _imaris, _netcdf, _metaimage, _vti])
def test_channels_of_narrow_files_are_no_colours(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    volume = io.open(write(tmp_path))
    assert volume.channel_count == len(NARROW)
    assert np.array_equal(volume.array.reshape(NARROW.shape), NARROW)


def test_channels_of_narrow_raw_files_are_no_colours(tmp_path: Path) -> None:
    NARROW.tofile(tmp_path / "v.raw")
    volume = io.open(tmp_path / "v.raw", shape=NARROW.shape[::-1], dtype="uint8")
    assert np.array_equal(volume.array.reshape(NARROW.shape), NARROW)
    (tmp_path / "v.dat").write_text("ObjectFileName: v4.raw\nResolution: 3 7 6\nFormat: UCHAR\nObjectModel: RGBA\n")
    np.moveaxis(NARROWER, 0, -1).tofile(tmp_path / "v4.raw")
    volume = io.open(tmp_path / "v.dat")
    assert np.array_equal(volume.array.reshape(NARROWER.shape), NARROWER)
    assert volume.channel_names == ("red", "green", "blue", "alpha")


def test_colours_of_narrow_nifti_are_channels(tmp_path: Path) -> None:
    nibabel = pytest.importorskip("nibabel")
    kinds = np.dtype([(letter, "u1") for letter in "RGBA"])
    samples = np.ascontiguousarray(np.moveaxis(NARROWER, 0, -1)).view(kinds)[..., 0]
    nibabel.save(nibabel.Nifti1Image(samples.T, np.eye(4)), tmp_path / "v.nii")
    assert np.array_equal(io.open(tmp_path / "v.nii").array.reshape(NARROWER.shape), NARROWER)


def _of_xarray() -> Any:
    return pytest.importorskip("xarray").DataArray(NARROW, dims=("c", "z", "y", "x"))


def _of_nibabel() -> Any:
    return pytest.importorskip("nibabel").Nifti1Image(NARROW.T, np.eye(4))


@pytest.mark.parametrize("make", [_of_xarray, _of_nibabel])
def test_channels_of_narrow_objects_are_no_colours(make: Callable[[], Any]) -> None:
    assert np.array_equal(Volume(make()).array.reshape(NARROW.shape), NARROW)


def test_axes_that_nothing_tells_may_be_colours(tmp_path: Path) -> None:
    np.save(tmp_path / "v.npy", NARROW)
    with pytest.raises(DataError, match="colours last"):
        io.open(tmp_path / "v.npy")
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "v.h5", "w") as file:
        file["v"] = NARROW
    with pytest.raises(DataError, match="colours last"):
        io.open(tmp_path / "v.h5")
