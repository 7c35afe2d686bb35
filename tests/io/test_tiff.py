"""TIFF: axes, spacing, names and levels by construction; refusals; damage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from fuzzing import COUNTS, open_damaged

from airlight import io
from airlight.errors import DataError, FileError, LimitError, MissingExtraError

SHAPES = {"T": 2, "C": 3, "Z": 4, "Y": 5, "X": 6}


def stack(axes: str, dtype: str = "uint16") -> np.ndarray:
    shape = [SHAPES[a] for a in axes]
    return np.arange(np.prod(shape)).reshape(shape).astype(dtype)


def ordered(array: np.ndarray, axes: str) -> np.ndarray:
    array = array.transpose([axes.index(a) for a in "TCZYX" if a in axes])
    if "Z" not in axes:
        array = array[..., None, :, :]
    return array[:, None] if "T" in axes and "C" not in axes else array


@pytest.mark.parametrize("kind", ["plain", "ome", "imagej"])
@pytest.mark.parametrize("axes", ["ZYX", "CZYX", "ZCYX", "TCZYX", "TZCYX", "TZYX", "CYX", "YX"])
def test_axes(tmp_path: Path, axes: str, kind: str) -> None:
    if kind == "imagej" and axes not in ("ZYX", "ZCYX", "TZCYX", "TZYX", "CYX", "YX"):
        pytest.skip("ImageJ has one order of axes")
    array = stack(axes)
    told = {"photometric": "minisblack", "metadata": {"axes": axes}}
    tifffile.imwrite(tmp_path / "s.tif", array, ome=kind == "ome", imagej=kind == "imagej", **told)
    volume = io.open(tmp_path / "s.tif")
    np.testing.assert_array_equal(volume.array, ordered(array, axes))
    assert volume.spacing == (1, 1, 1)
    assert volume.units == ""


def test_axis_without_a_name_is_z(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "s.tif", stack("ZYX"), photometric="minisblack")
    assert io.open(tmp_path / "s.tif").size == (6, 5, 4)
    tifffile.imwrite(tmp_path / "s.tif", stack("CZYX"), photometric="minisblack")
    with pytest.raises(DataError, match=r"axes QQYX .*not told.*axes.*TCZYX"):
        io.open(tmp_path / "s.tif")


def test_ome(tmp_path: Path) -> None:
    told: dict[str, Any] = {"axes": "TCZYX", "PhysicalSizeX": 0.2, "PhysicalSizeY": 0.3, "PhysicalSizeZ": 1.5}
    told |= {f"PhysicalSize{a}Unit": "µm" for a in "XYZ"}
    told |= {"Channel": {"Name": ["DAPI", "GFP", "RFP"]}, "TimeIncrement": 2.5, "TimeIncrementUnit": "s"}
    tifffile.imwrite(tmp_path / "s.ome.tif", stack("TCZYX"), metadata=told, photometric="minisblack")
    volume = io.open(tmp_path / "s.ome.tif")
    assert volume.spacing == (0.2, 0.3, 1.5)
    assert (volume.units, volume.channel_names, volume.modality) == ("um", ("DAPI", "GFP", "RFP"), "microscopy")
    assert (volume.times, volume.time_unit) == ((0, 2.5), "s")


def test_half_told_spacing_is_none(tmp_path: Path) -> None:
    told = {"axes": "ZYX", "PhysicalSizeX": 0.2, "PhysicalSizeY": 0.2}
    tifffile.imwrite(tmp_path / "s.ome.tif", stack("ZYX"), metadata=told, photometric="minisblack")
    volume = io.open(tmp_path / "s.ome.tif")
    assert (volume.spacing, volume.units) == ((1, 1, 1), "")
    assert io.open(tmp_path / "s.ome.tif", spacing=(0.2, 0.2, 1)).spacing == (0.2, 0.2, 1)


def test_imagej(tmp_path: Path) -> None:
    told = {"axes": "TZYX", "spacing": 3.5, "unit": "micron", "finterval": 0.5}
    array = stack("TZYX")
    tifffile.imwrite(tmp_path / "s.tif", array, imagej=True, resolution=(2, 4), metadata=told)
    volume = io.open(tmp_path / "s.tif")
    np.testing.assert_allclose(volume.spacing, (0.5, 0.25, 3.5))
    assert (volume.units, volume.times) == ("um", (0, 0.5))


def test_dots_per_inch_are_no_spacing(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "s.tif", stack("ZYX"), resolution=(72, 72), resolutionunit=2, photometric="minisblack")
    assert io.open(tmp_path / "s.tif").spacing == (1, 1, 1)


def test_levels(tmp_path: Path) -> None:
    array = np.arange(4 * 64 * 48, dtype=np.uint16).reshape(4, 64, 48)
    told = {"axes": "ZYX", "PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2.0}
    options: dict[str, Any] = {"photometric": "minisblack", "tile": (16, 16)}
    with tifffile.TiffWriter(tmp_path / "p.ome.tif") as file:
        file.write(array, subifds=1, metadata=told, **options)
        file.write(array[:, ::2, ::2], subfiletype=1, **options)
    volume = io.open(tmp_path / "p.ome.tif", level=1)
    np.testing.assert_array_equal(volume.array, array[:, ::2, ::2])
    assert volume.spacing == (1, 1, 2)
    assert volume.origin == (0.25, 0.25, 0)  # the same corner, voxels twice as large
    assert volume.source is not None
    assert volume.source.level == 1
    with pytest.raises(DataError, match="has no level 2: choose 0 to 1"):
        io.open(tmp_path / "p.ome.tif", level=2)


def test_several_series(tmp_path: Path) -> None:
    with tifffile.TiffWriter(tmp_path / "s.ome.tif") as file:
        file.write(stack("ZYX"), metadata={"axes": "ZYX", "Name": "one"}, photometric="minisblack")
        file.write(stack("CZYX"), metadata={"axes": "CZYX", "Name": "two", "PhysicalSizeX": 3.0}, photometric="minisblack")
    with pytest.raises(DataError, match=r"holds 2 series: .*0 'one' ZYX.*1 'two'"):
        io.open(tmp_path / "s.ome.tif")
    assert io.open(tmp_path / "s.ome.tif", dataset="two").channel_count == 3
    assert io.open(tmp_path / "s.ome.tif", dataset="0").channel_count == 1


def test_no_data(tmp_path: Path) -> None:
    tag = (42113, "s", 0, "-9999", True)
    tifffile.imwrite(tmp_path / "s.tif", stack("ZYX", "float32"), extratags=[tag], photometric="minisblack")
    assert io.open(tmp_path / "s.tif").no_data == -9999


def test_broken_private_tag_does_no_harm_and_broken_description_is_told(tmp_path: Path) -> None:
    tag = (65000, "s", 0, "a private tag with a text that is long", True)
    tifffile.imwrite(tmp_path / "s.tif", stack("ZYX"), extratags=[tag], metadata=None, photometric="minisblack")
    whole = bytearray((tmp_path / "s.tif").read_bytes())
    at = whole.index((65000).to_bytes(2, "little"))
    whole[at + 8 : at + 12] = b"\xff\xff\xff\x7f"
    (tmp_path / "s.tif").write_bytes(whole)
    np.testing.assert_array_equal(io.open(tmp_path / "s.tif").array, stack("ZYX"))
    whole[at : at + 2] = (270).to_bytes(2, "little")
    (tmp_path / "s.tif").write_bytes(whole)
    with pytest.raises(FileError, match="damaged"):
        io.open(tmp_path / "s.tif")


def test_colours_and_complex_are_refused(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "c.tif", np.zeros((4, 5, 6, 3), np.uint8), photometric="rgb")
    with pytest.raises(DataError, match=r"holds colours .*grey values"):
        io.open(tmp_path / "c.tif")
    tifffile.imwrite(tmp_path / "z.tif", np.zeros((4, 5, 6), np.complex64), photometric="minisblack")
    with pytest.raises(DataError, match="complex"):
        io.open(tmp_path / "z.tif")


def test_several_files_of_a_set(tmp_path: Path) -> None:
    """An OME set whose second half lies in another file: read where that is there, else one error."""
    xml = (
        '<?xml version="1.0"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0">'
        '<Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint8" SizeX="3" SizeY="2" SizeZ="2" SizeC="1" SizeT="1">'
        '<Channel ID="Channel:0:0" SamplesPerPixel="1"/>'
        '<TiffData FirstZ="0" IFD="0" PlaneCount="1"><UUID FileName="a.ome.tif">urn:uuid:a</UUID></TiffData>'
        '<TiffData FirstZ="1" IFD="0" PlaneCount="1"><UUID FileName="{}">urn:uuid:b</UUID></TiffData>'
        "</Pixels></Image></OME>"
    )
    planes = np.arange(12, dtype=np.uint8).reshape(2, 2, 3)
    for name, plane in zip("ab", planes, strict=True):
        text = xml.format("b.ome.tif").encode()
        tifffile.imwrite(tmp_path / f"{name}.ome.tif", plane, description=text, metadata=None, photometric="minisblack")
    np.testing.assert_array_equal(io.open(tmp_path / "a.ome.tif").array, planes)
    (tmp_path / "b.ome.tif").unlink()
    with pytest.raises(FileError, match="not there"):
        io.open(tmp_path / "a.ome.tif")
    (tmp_path / "sub").mkdir()
    text = xml.format("../a.ome.tif").encode()
    tifffile.imwrite(tmp_path / "sub" / "a.ome.tif", planes[0], description=text, metadata=None, photometric="minisblack")
    with pytest.raises(FileError, match="outside"):
        io.open(tmp_path / "sub" / "a.ome.tif")


def test_entities_are_refused(tmp_path: Path) -> None:
    bomb = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bbbb">]><OME>&b;</OME>'
    tifffile.imwrite(tmp_path / "s.ome.tif", stack("ZYX"), description=bomb, metadata=None, photometric="minisblack")
    with pytest.raises(FileError, match="entities"):
        io.open(tmp_path / "s.ome.tif")


@pytest.mark.parametrize("compression", [None, "zlib"])
def test_truncated(tmp_path: Path, compression: str | None) -> None:
    rng = np.random.default_rng(1)
    array = rng.integers(0, 255, (6, 40, 50), dtype=np.uint8)
    tifffile.imwrite(tmp_path / "s.tif", array, compression=compression, photometric="minisblack")
    whole = (tmp_path / "s.tif").read_bytes()
    refused = 0
    for end in range(7, len(whole), 97):
        (tmp_path / "t.tif").write_bytes(whole[:end])
        try:
            np.testing.assert_array_equal(io.open(tmp_path / "t.tif").array, array)
        except FileError:
            refused += 1
    assert refused >= (len(whole) - 7) // 97 - 10  # a file that lacks its last, unused bytes may be read


def test_size_is_checked_first(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "s.tif", stack("ZYX"), photometric="minisblack")
    with pytest.raises(LimitError):
        io.open(tmp_path / "s.tif", max_memory=100)


def test_missing_codec_names_the_pip_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tifffile.imwrite(tmp_path / "s.tif", stack("ZYX"), photometric="minisblack", compression="zlib")

    def fail(*_: Any, **__: Any) -> None:
        raise ValueError("<COMPRESSION.LZW: 5> requires the 'imagecodecs' package")

    monkeypatch.setattr(tifffile.TiffPageSeries, "asarray", fail)
    with pytest.raises(MissingExtraError, match=r'LZW.*pip install "airlight\[tiff\]"'):
        io.open(tmp_path / "s.tif")


@pytest.mark.data
def test_real_files(data_dir: Path) -> None:
    cells = io.open(data_dir / "cellfinder_2ch_crop.ome.tif")
    assert (cells.size, cells.spacing, cells.units) == ((500, 500, 26), (2, 2, 5), "um")
    assert cells.channel_names == ("signal", "background")
    sitk = pytest.importorskip("SimpleITK")
    shell = io.open(data_dir / "shell_225x128x128.tif")
    np.testing.assert_array_equal(shell.array, sitk.GetArrayFromImage(sitk.ReadImage(data_dir / "shell_225x128x128.tif")))
    assert io.open(data_dir / "labels" / "nuclei.tif").units == ""


@pytest.mark.parametrize("count", COUNTS)
def test_damaged_files_give_one_error(tmp_path: Path, count: int) -> None:
    told = {"axes": "CZYX", "PhysicalSizeX": 0.2, "PhysicalSizeY": 0.3, "PhysicalSizeZ": 1.5}
    tifffile.imwrite(tmp_path / "a", stack("CZYX"), metadata=told, ome=True, photometric="minisblack")
    tifffile.imwrite(tmp_path / "b", stack("ZYX"), imagej=True, metadata={"spacing": 2, "unit": "um"})
    tifffile.imwrite(tmp_path / "c", stack("ZYX"), compression="zlib", tile=(16, 16), photometric="minisblack")
    assert open_damaged([(tmp_path / n).read_bytes() for n in "abc"], tmp_path / "t.tif", count) > count // 4
