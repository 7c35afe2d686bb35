"""What each of the light readers makes of well-formed files, made by other libraries where there are any."""

from __future__ import annotations

import base64
import bz2
import gzip
import struct
import zlib
from pathlib import Path

import mrcfile
import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK as sitk  # noqa: N813

from airlight import io
from airlight.errors import AirlightError, DataError, FileError

DTYPES = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]


# -- NRRD


@pytest.mark.parametrize("encoding", ["raw", "gzip", "bzip2", "ASCII"])
@pytest.mark.parametrize("detached", [False, True])
def test_nrrd_encodings(tmp_path: Path, ramp: np.ndarray, encoding: str, detached: bool) -> None:
    path = tmp_path / ("a.nhdr" if detached else "a.nrrd")
    nrrd.write(str(path), ramp.T, {"encoding": encoding, "spacings": [1.0, 2.0, 3.0]}, detached_header=detached)
    volume = io.open(path)
    np.testing.assert_array_equal(volume.array, ramp)
    assert volume.spacing == (1, 2, 3)
    assert not volume.anatomical
    assert volume.source.path == str(path)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("order", ["<", ">"])
def test_nrrd_types_and_byte_orders(tmp_path: Path, ramp: np.ndarray, dtype: str, order: str) -> None:
    path = tmp_path / "a.nrrd"
    array = ramp.astype(order + dtype)
    header = f"NRRD0004\ntype: {nrrd_type(dtype)}\ndimension: 3\nsizes: 5 4 3\nencoding: raw\n"
    path.write_bytes((header + f"endian: {'little' if order == '<' else 'big'}\n\n").encode() + array.tobytes())
    volume = io.open(path)
    np.testing.assert_array_equal(volume.array, ramp)
    assert volume.dtype == np.dtype(dtype)


def nrrd_type(dtype: str) -> str:
    return {"f4": "float", "f8": "double"}.get(dtype, f"{'u' if dtype[0] == 'u' else ''}int{int(dtype[1]) * 8}")


def nrrd_file(path: Path, lines: str, data: bytes) -> Path:
    path.write_bytes(b"NRRD0005\nencoding: raw\nendian: little\n" + lines.encode() + b"\n\n" + data)
    return path


def test_nrrd_channels_and_times(tmp_path: Path) -> None:
    array = np.arange(2 * 3 * 4 * 5 * 6, dtype=np.int16).reshape(2, 3, 4, 5, 6)  # t c z y x
    fastest = np.moveaxis(array, 1, -1)  # t z y x c
    lines = "type: short\ndimension: 5\nsizes: 3 6 5 4 2\nkinds: vector domain domain domain time\nspace: RAS\n"
    lines += 'space directions: none (2,0,0) (0,3,0) (0,0,4) none\nspace units: "cm" "cm" "cm"\nspace origin: (1,2,3)\n'
    lines += 'spacings: nan nan nan nan 0.5\nunits: "" "" "" "" "seconds"'
    volume = io.open(nrrd_file(tmp_path / "a.nrrd", lines, fastest.tobytes()))
    np.testing.assert_array_equal(volume.array, array)
    assert volume.times == (0, 0.5)
    assert volume.time_unit == "s"
    np.testing.assert_allclose(volume.spacing, (20, 30, 40))
    np.testing.assert_allclose(volume.origin, (-10, -20, 30))


def test_nrrd_list_last_is_channels(tmp_path: Path) -> None:
    array = np.arange(2 * 60, dtype=np.uint8).reshape(2, 3, 4, 5)
    lines = "type: uchar\ndimension: 4\nsizes: 5 4 3 2\nkinds: domain domain domain list\nspace dimension: 3\n"
    lines += "space directions: (1,0,0) (0,1,0) (0,0,1) none"
    volume = io.open(nrrd_file(tmp_path / "a.nrrd", lines, array.tobytes()))
    np.testing.assert_array_equal(volume.array, array)


def test_nrrd_colours_are_channels(tmp_path: Path) -> None:
    array = np.arange(180, dtype=np.uint8).reshape(3, 4, 5, 3)
    lines = "type: uchar\ndimension: 4\nsizes: 3 5 4 3\nkinds: RGB-color domain domain domain"
    volume = io.open(nrrd_file(tmp_path / "a.nrrd", lines, array.tobytes()))
    np.testing.assert_array_equal(volume.array, np.moveaxis(array, -1, 0))
    assert volume.channel_names == ("red", "green", "blue")


def test_nrrd_time_space_has_a_fourth_component(tmp_path: Path) -> None:
    array = np.arange(120, dtype=np.uint8).reshape(2, 3, 4, 5)
    lines = "type: uchar\ndimension: 4\nsizes: 5 4 3 2\nspace: left-posterior-superior-time\n"
    lines += "space directions: (1,0,0,0) (0,2,0,0) (0,0,3,0) (0,0,0,7)\nspace origin: (1,2,3,0)"
    volume = io.open(nrrd_file(tmp_path / "a.nrrd", lines, array.tobytes()))
    np.testing.assert_array_equal(volume.array[:, 0], array)
    assert volume.times == (0, 7)
    assert volume.spacing == (1, 2, 3)


def test_nrrd_cell_centred_axis_mins(tmp_path: Path, ramp: np.ndarray) -> None:
    lines = "type: short\ndimension: 3\nsizes: 5 4 3\naxis mins: 0 0 0\naxis maxs: 10 8 2\ncenterings: cell cell node"
    volume = io.open(nrrd_file(tmp_path / "a.nrrd", lines, ramp.tobytes()))
    assert volume.spacing == (2, 2, 1)
    assert volume.origin == (1, 1, 0)


def test_nrrd_files_in_a_list_and_by_number(tmp_path: Path, ramp: np.ndarray) -> None:
    for i, part in enumerate(ramp):
        (tmp_path / f"s{i + 1:02d}.raw").write_bytes(part.tobytes())
    lines = "type: short\ndimension: 3\nsizes: 5 4 3\n"
    for name in ("data file: s%02d.raw 1 3 1", "data file: LIST\ns01.raw\ns02.raw\ns03.raw"):
        volume = io.open(nrrd_file(tmp_path / "a.nhdr", lines + name, b""))
        np.testing.assert_array_equal(volume.array, ramp)


def test_nrrd_byte_and_line_skip(tmp_path: Path, ramp: np.ndarray) -> None:
    (tmp_path / "d.raw").write_bytes(b"one\ntwo\n1234" + ramp.tobytes())
    lines = "type: short\ndimension: 3\nsizes: 5 4 3\ndata file: d.raw\n"
    for skip in ("line skip: 2\nbyte skip: 4", "byte skip: -1"):
        np.testing.assert_array_equal(io.open(nrrd_file(tmp_path / "a.nhdr", lines + skip, b"")).array, ramp)


def test_nrrd_modality_and_unit(tmp_path: Path, ramp: np.ndarray) -> None:
    lines = "type: short\ndimension: 3\nsizes: 5 4 3\nsample units: HU\nmodality:=CT\nPatientName:=Doe"
    volume = io.open(nrrd_file(tmp_path / "a.nrrd", lines, ramp.tobytes()))
    assert (volume.modality, volume.value_unit) == ("CT", "HU")
    assert "Doe" not in repr(vars(volume))


@pytest.mark.parametrize(
    ("lines", "what"),
    [
        ("type: short\ndimension: 4\nsizes: 5 4 3 1", "which three are space"),
        ("type: short\ndimension: 3\nsizes: 5 4 inf", "whole numbers"),
        ("type: short\ndimension: 2\nsizes: 5 12", "2 axes"),
        ("type: block\ndimension: 3\nsizes: 5 4 3", "'block'"),
        ("type: short\ndimension: 3\nsizes: 5 4 4", "160|120"),
        ("type: short\ndimension: 3\nsizes: 5 4 0", "0"),
        ("type: short\ndimension: 3\nsizes: 5 4 3 2", "4 numbers for 3 axes"),
        ("type: float\ndimension: 4\nsizes: 2 5 3 1\nkinds: complex domain domain domain", "complex"),
        ("type: short\ndimension: 3\nsizes: 5 4 3\nspace: upside-down", "upside-down"),
        ("type: short\ndimension: 3\nsizes: 5 4 3\nthis is no field", "no colon"),
        ("type: short\ndimension: 3\nsizes: 5 4 3\ndata file: ../secret.raw", "outside"),
        ("type: short\ndimension: 3\nsizes: 5 4 3\ndata file: /etc/passwd", "outside"),
        ("type: short\ndimension: 3\nsizes: 5 4 3\ndata file: absent.raw", "not there"),
        ("dimension: 3\nsizes: 5 4 3", "no 'type'"),
        ("type: short\ndimension: 3\nsizes: 999999 999999 3", "MiB"),
        ("type: short\ndimension: 3\nsizes: 5 4 3\nspace: LPS\nspace directions: (1,0,0) (2,0,0) (0,0,1)", "singular"),
    ],
)
def test_nrrd_faults_are_told(tmp_path: Path, ramp: np.ndarray, lines: str, what: str) -> None:
    with pytest.raises(AirlightError, match=what):
        io.open(nrrd_file(tmp_path / "a.nrrd", lines, ramp.tobytes()))


def test_links_out_of_the_folder_are_refused(tmp_path: Path, ramp: np.ndarray) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "secret.raw").write_bytes(ramp.tobytes())
    (inner / "link.raw").symlink_to(tmp_path / "secret.raw")
    with pytest.raises(FileError, match="outside"):
        io.open(nrrd_file(inner / "a.nhdr", "type: short\ndimension: 3\nsizes: 5 4 3\ndata file: link.raw", b""))


# -- NIfTI


@pytest.mark.parametrize(("slope", "intercept", "dtype"), [(1, 0, "i2"), (1, -1024, "i2"), (2, 70000, "i4"), (0.5, 3, "f4")])
def test_nifti_scaling_stays_whole_where_it_can(tmp_path: Path, ramp: np.ndarray, slope, intercept, dtype) -> None:
    path = tmp_path / "a.nii.gz"
    image = nibabel.Nifti1Image(ramp.T, np.eye(4))
    image.header.set_slope_inter(slope, intercept)
    image.header.set_data_dtype(np.int16)
    path.write_bytes(gzip.compress(nifti_bytes(image, ramp)))
    volume = io.open(path)
    np.testing.assert_array_equal(volume.array, ramp * slope + np.float64(intercept))
    assert volume.dtype == np.dtype(dtype)


def nifti_bytes(image, array: np.ndarray) -> bytes:
    header = image.header
    header.set_data_offset(352)
    header["magic"] = b"n+1"
    return header.binaryblock + b"\0\0\0\0" + array.astype(header.get_data_dtype()).tobytes()


def test_nifti_time_and_units(tmp_path: Path) -> None:
    array = np.arange(2 * 60, dtype=np.uint8).reshape(2, 3, 4, 5)
    image = nibabel.Nifti1Image(array.T, np.diag([1e-3, 1e-3, 2e-3, 1]))
    image.header.set_xyzt_units("meter", "msec")
    image.header.set_zooms((1e-3, 1e-3, 2e-3, 40))
    nibabel.save(image, tmp_path / "a.nii")
    volume = io.open(tmp_path / "a.nii")
    np.testing.assert_array_equal(volume.array[:, 0], array)
    assert (volume.times, volume.time_unit, volume.units) == ((0, 40), "ms", "mm")
    np.testing.assert_allclose(volume.spacing, (1, 1, 2), rtol=1e-6)


def test_nifti_with_one_time_step_is_a_plain_volume(tmp_path: Path, ramp: np.ndarray) -> None:
    nibabel.save(nibabel.Nifti1Image(ramp.T[..., None], np.eye(4)), tmp_path / "a.nii")
    np.testing.assert_array_equal(io.open(tmp_path / "a.nii").array, ramp)


def test_nifti_vectors_are_channels(tmp_path: Path) -> None:
    array = np.arange(3 * 2 * 60, dtype=np.float32).reshape(2, 3, 3, 4, 5)  # t c z y x
    nibabel.save(nibabel.Nifti1Image(array.transpose(4, 3, 2, 0, 1), np.eye(4)), tmp_path / "a.nii")
    np.testing.assert_array_equal(io.open(tmp_path / "a.nii").array, array)


def test_nifti_colours_are_channels(tmp_path: Path) -> None:
    array = np.arange(180, dtype=np.uint8).reshape(5, 4, 3, 3)
    rgb = array.view(np.dtype([("R", "u1"), ("G", "u1"), ("B", "u1")]))[..., 0]
    nibabel.save(nibabel.Nifti1Image(rgb, np.eye(4)), tmp_path / "a.nii")
    volume = io.open(tmp_path / "a.nii")
    np.testing.assert_array_equal(volume.array, np.moveaxis(array, -1, 0).transpose(0, 3, 2, 1))
    assert volume.channel_names == ("red", "green", "blue")


def test_nifti_2_and_big_endian(tmp_path: Path, ramp: np.ndarray) -> None:
    nibabel.save(nibabel.Nifti2Image(ramp.T, np.eye(4)), tmp_path / "a.nii")
    np.testing.assert_array_equal(io.open(tmp_path / "a.nii").array, ramp)
    swapped = nibabel.Nifti1Image(ramp.T, np.eye(4), header=nibabel.Nifti1Header(endianness=">"))
    nibabel.save(swapped, tmp_path / "b.nii")
    assert (tmp_path / "b.nii").read_bytes()[:4] == b"\0\0\1\x5c"
    np.testing.assert_array_equal(io.open(tmp_path / "b.nii").array, ramp)


def test_nifti_complex_and_analyze_are_refused(tmp_path: Path) -> None:
    nibabel.save(nibabel.Nifti1Image(np.ones((3, 4, 5), np.complex64), np.eye(4)), tmp_path / "a.nii")
    with pytest.raises(DataError, match="abs"):
        io.open(tmp_path / "a.nii")
    nibabel.AnalyzeImage(np.ones((3, 4, 5), np.int16), np.eye(4)).to_filename(tmp_path / "b.hdr")
    with pytest.raises(FileError, match="Analyze"):
        io.open(tmp_path / "b.hdr")


# -- MetaImage


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 2])
def test_metaimage_types(tmp_path: Path, ramp: np.ndarray, dtype: str, channels: int) -> None:
    array = np.stack([ramp, ramp + 60], axis=-1).astype(dtype) if channels == 2 else ramp.astype(dtype)
    sitk.WriteImage(sitk.GetImageFromArray(array, isVector=channels == 2), str(tmp_path / "a.mha"))
    volume = io.open(tmp_path / "a.mha")
    np.testing.assert_array_equal(volume.array, np.moveaxis(array, -1, 0) if channels == 2 else array)
    assert volume.dtype == np.dtype(dtype)


def test_metaimage_fourth_axis_is_time(tmp_path: Path) -> None:
    array = np.arange(120, dtype=np.int16).reshape(2, 3, 4, 5)
    image = sitk.JoinSeries([sitk.GetImageFromArray(part) for part in array], 5.0, 0.5)
    sitk.WriteImage(image, str(tmp_path / "a.mha"))
    volume = io.open(tmp_path / "a.mha")
    np.testing.assert_array_equal(volume.array[:, 0], array)
    assert volume.times == (5, 5.5)


def meta(path: Path, lines: str, data: bytes = b"") -> Path:
    head = "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n"
    path.write_bytes((head + lines + "\n").encode() + data)
    return path


def test_metaimage_text_lists_patterns_and_byte_order(tmp_path: Path, ramp: np.ndarray) -> None:
    for i, part in enumerate(ramp):
        (tmp_path / f"s{i}.raw").write_bytes(part.tobytes())
    (tmp_path / "all.raw").write_bytes(b"head" + ramp.tobytes())
    text = " ".join(str(n) for n in ramp.ravel()).encode()
    for lines, data in (
        ("ElementDataFile = s%d.raw 0 2 1", b""),
        ("ElementDataFile = LIST", b"s0.raw\ns1.raw\ns2.raw\n"),
        ("HeaderSize = -1\nElementDataFile = all.raw", b""),
        ("HeaderSize = 4\nElementDataFile = all.raw", b""),
        ("BinaryData = False\nElementDataFile = LOCAL", text),
        ("BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL", ramp.astype(">i2").tobytes()),
        ("CompressedData = True\nElementDataFile = LOCAL", zlib.compress(ramp.tobytes())),
        ("ElementToIntensityFunctionSlope = 1\nElementDataFile = LOCAL", ramp.tobytes()),
    ):
        np.testing.assert_array_equal(io.open(meta(tmp_path / "a.mhd", lines, data)).array, ramp)
    assert io.open(meta(tmp_path / "a.mhd", "Modality = MET_MOD_CT\nElementDataFile = LOCAL", ramp.tobytes())).modality == "CT"


@pytest.mark.parametrize(
    ("lines", "what"),
    [
        ("ElementDataFile = ../x.raw", "outside"),
        ("ElementDataFile = LOCAL", "0 bytes of samples"),
        ("ElementSpacing = 1 2\nElementDataFile = LOCAL", "3 numbers"),
        ("ElementDataFile = a.mhd", "bytes of samples"),
        ("", "ElementDataFile"),
        ("CompressedData = True\nElementDataFile = LOCAL", "cut short|damaged"),
    ],
)
def test_metaimage_faults_are_told(tmp_path: Path, lines: str, what: str) -> None:
    with pytest.raises(FileError, match=what):
        io.open(meta(tmp_path / "a.mhd", lines))


# -- raw


def test_raw(tmp_path: Path, ramp: np.ndarray) -> None:
    path = tmp_path / "a_5x4x3_int16.raw"
    path.write_bytes(b"xx" + ramp.astype(">i2").tobytes())
    volume = io.open(path, shape=(5, 4, 3), dtype="int16", big_endian=True, offset=2, spacing=(1, 2, 3))
    np.testing.assert_array_equal(volume.array, ramp)
    assert volume.spacing == (1, 2, 3)
    assert dict(volume.source.options) == {
        "shape": "5 4 3", "dtype": "int16", "spacing": "1.0 2.0 3.0", "offset": "2", "big_endian": "true"
    }  # fmt: skip
    with pytest.raises(FileError, match=r"shape=\(5, 4, 3\), dtype='int16'"):
        io.open(path)
    with pytest.raises(FileError, match="122 bytes of samples where 120"):
        io.open(path, shape=(5, 4, 3), dtype="int16")
    with pytest.raises(DataError, match="dtype is not given"):
        io.open(path, shape=(5, 4, 3))
    with pytest.raises(DataError, match="complex"):
        io.open(path, shape=(5, 4, 3), dtype="complex64")


def test_dat_header(tmp_path: Path, ramp: np.ndarray) -> None:
    (tmp_path / "a.raw").write_bytes(ramp.astype("<u2").tobytes())
    dat = tmp_path / "a.dat"
    dat.write_text("ObjectFileName: a.raw\nTaggedFileName: ---\nResolution: 5 4 3\nSliceThickness: 1 1 2\nFormat: USHORT\n")
    volume = io.open(dat)
    np.testing.assert_array_equal(volume.array, ramp)
    assert volume.dtype == np.uint16
    assert volume.spacing == (1, 1, 2)
    dat.write_text("ObjectFileName: ../a.raw\nResolution: 5 4 3\nFormat: USHORT\n")
    with pytest.raises(FileError, match="outside"):
        io.open(dat)


def test_a_shape_makes_any_file_raw(tmp_path: Path, ramp: np.ndarray) -> None:
    path = tmp_path / "a.volume"
    path.write_bytes(ramp.tobytes())
    np.testing.assert_array_equal(io.open(path, shape=(5, 4, 3), dtype="int16").array, ramp)
    np.testing.assert_array_equal(io.open(path, shape=(5, 4, 1, 3), dtype="<i2").array, ramp[:, None])
    with pytest.raises(FileError, match="does not exist"):
        io.open(tmp_path / "absent", shape=(5, 4, 3), dtype="int16")
    with pytest.raises(FileError, match="no plain file"):
        io.open(tmp_path, shape=(5, 4, 3), dtype="int16")


# -- NumPy


def test_npy_fortran_order_and_byte_order(tmp_path: Path, ramp: np.ndarray) -> None:
    for array in (np.asfortranarray(ramp), ramp.astype(">f8")):
        np.save(tmp_path / "a.npy", array)
        np.testing.assert_array_equal(io.open(tmp_path / "a.npy").array, ramp)


def test_npz(tmp_path: Path, ramp: np.ndarray) -> None:
    matrix = np.diag([1.0, 2, 3, 1])
    np.savez_compressed(tmp_path / "a.npz", samples=ramp, world_from_index=matrix, units="um", notes=np.arange(3))
    volume = io.open(tmp_path / "a.npz")
    np.testing.assert_array_equal(volume.array, ramp)
    assert volume.spacing == (1, 2, 3)
    assert volume.units == "um"
    np.savez(tmp_path / "b.npz", one=ramp, two=ramp + 1)
    with pytest.raises(FileError, match="several arrays: one, two"):
        io.open(tmp_path / "b.npz")
    two = io.open(tmp_path / "b.npz", dataset="two")
    np.testing.assert_array_equal(two.array, ramp + 1)
    assert two.source.dataset == "two"


def test_npy_refuses_pickles_colours_and_complex(tmp_path: Path, ramp: np.ndarray) -> None:
    path = tmp_path / "a.npy"
    for array, what in (
        (np.array([[[object()]]]), "Python objects"),
        (ramp.astype(complex), "complex"),
        (np.zeros((9, 9, 9, 3), np.uint8), "colours last"),
        (np.zeros((9, 9)), "2 axes"),
        (np.zeros((3, 0, 3)), "size"),
    ):
        np.save(path, array, allow_pickle=True)
        with pytest.raises(AirlightError, match=what):
            io.open(path)


# -- VTI


def vti(path: Path, arrays: str, *, appended: bytes = b"", encoding: str = "raw", root: str = "") -> Path:
    head = f"""<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" {root}>
<ImageData WholeExtent="1 5 0 3 0 2" Origin="10 20 30" Spacing="1 2 3" Direction="0 1 0 -1 0 0 0 0 1">
<Piece Extent="1 5 0 3 0 2"><PointData>{arrays}</PointData></Piece></ImageData>"""
    tail = b"</VTKFile>"
    if appended:
        tail = f'<AppendedData encoding="{encoding}">_'.encode() + appended + b"</AppendedData></VTKFile>"
    path.write_bytes(head.encode() + tail)
    return path


def vtk_blocks(data: bytes, header: str, size: int = 50) -> tuple[bytes, bytes]:
    blocks = [data[i : i + size] for i in range(0, len(data), size)]
    packed = [zlib.compress(block) for block in blocks]
    last = len(data) % size
    head = struct.pack(f"<{3 + len(packed)}{header}", len(packed), size, last, *[len(p) for p in packed])
    return head, b"".join(packed)


@pytest.mark.parametrize("header", ["I", "Q"])
@pytest.mark.parametrize("kind", ["ascii", "binary", "padded", "raw", "base64", "zlib binary", "zlib raw", "zlib base64"])
def test_vti_encodings(tmp_path: Path, ramp: np.ndarray, kind: str, header: str) -> None:
    data, b64 = ramp.tobytes(), base64.b64encode
    length = struct.pack(f"<{header}", len(data))
    head, blocks = vtk_blocks(data, header)
    root = f'header_type="{"UInt32" if header == "I" else "UInt64"}"'
    root += ' compressor="vtkZLibDataCompressor"' if "zlib" in kind else ""
    inline = {
        "ascii": " ".join(str(n) for n in ramp.ravel()).encode(),
        "binary": b64(length + data),
        "padded": b64(length) + b64(data),
        "zlib binary": b"\n  " + b64(head) + b64(blocks) + b"\n",
    }
    appended = {
        "raw": b"12345" + length + data,
        "base64": b"QUJDRA==" + b64(length + data),
        "zlib raw": b"12345" + head + blocks,
        "zlib base64": b"QUJDRA==" + b64(head) + b64(blocks),
    }
    if kind in inline:
        form = "ascii" if kind == "ascii" else "binary"
        text = f'<DataArray type="Int16" Name="density" format="{form}">{inline[kind].decode()}</DataArray>'
        path = vti(tmp_path / "a.vti", text, root=root)
    else:
        offset = 8 if "base64" in kind else 5
        text = f'<DataArray type="Int16" Name="density" format="appended" offset="{offset}"/>'
        encoding = "base64" if "base64" in kind else "raw"
        path = vti(tmp_path / "a.vti", text, root=root, appended=appended[kind], encoding=encoding)
    volume = io.open(path)
    np.testing.assert_array_equal(volume.array, ramp)
    expected = np.array([[0, 2, 0, 10], [-1, 0, 0, 19], [0, 0, 3, 30], [0, 0, 0, 1]])
    np.testing.assert_allclose(volume.world_from_index, expected)
    assert volume.channel_names == ("density",)


def test_vti_arrays_and_components_are_channels(tmp_path: Path, ramp: np.ndarray) -> None:
    vectors = np.stack([ramp, -ramp, ramp + 7], axis=-1)

    def text(array: np.ndarray) -> str:
        return " ".join(str(n) for n in array.ravel())

    arrays = f'<DataArray type="Float32" Name="p" format="ascii">{text(ramp)}</DataArray>'
    arrays += f'<DataArray type="Int16" Name="v" NumberOfComponents="3" format="ascii">{text(vectors)}</DataArray>'
    path = vti(tmp_path / "a.vti", arrays)
    volume = io.open(path)
    assert volume.channel_names == ("p", "v_x", "v_y", "v_z")
    np.testing.assert_array_equal(volume.array, [ramp, ramp, -ramp, ramp + 7])
    np.testing.assert_array_equal(io.open(path, dataset="p").array, ramp)
    with pytest.raises(FileError, match="its arrays are: p, v"):
        io.open(path, dataset="q")


def test_vti_entities_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.vti"
    path.write_text('<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><VTKFile type="ImageData">&b;</VTKFile>')
    with pytest.raises(FileError, match="entities"):
        io.open(path)


@pytest.mark.data
def test_real_vti(data_dir: Path) -> None:
    orbital = io.open(data_dir / "hydrogen.vti")
    assert (orbital.size, orbital.dtype) == ((64, 64, 64), np.float32)
    assert orbital.array.min() >= 0
    assert orbital.array.max() <= 1
    storm = io.open(data_dir / "time" / "isabel_03.vti")
    np.testing.assert_allclose(storm.array.max(), 70.75894797)


# -- MRC


@pytest.mark.parametrize("dtype", ["i1", "i2", "f4", "u2", "f2"])
@pytest.mark.parametrize("suffix", [".mrc", ".map", ".mrc.gz"])
def test_mrc_types(tmp_path: Path, ramp: np.ndarray, dtype: str, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    opener = {"compression": "gzip"} if suffix.endswith("gz") else {}
    with mrcfile.new(path, **opener) as file:
        file.set_data(ramp.astype(dtype))
        file.voxel_size = (1.5, 2, 3)
        file.header.origin = (7, 8, 9)
    volume = io.open(path)
    np.testing.assert_array_equal(volume.array, ramp)
    assert volume.dtype == np.dtype(dtype)
    assert volume.units == "angstrom"
    np.testing.assert_allclose(volume.spacing, (1.5, 2, 3))
    np.testing.assert_allclose(volume.origin, (7, 8, 9))


def test_mrc_axes_starts_and_skew(tmp_path: Path, ramp: np.ndarray) -> None:
    path = tmp_path / "a.mrc"
    with mrcfile.new(path) as file:
        file.set_data(ramp)  # sections, rows, columns
        file.header.mapc, file.header.mapr, file.header.maps = 3, 1, 2  # columns are z, rows x, sections y
        file.header.mx, file.header.my, file.header.mz = 4, 3, 5
        file.header.cella = (4, 3, 5)
        file.header.cellb = (90, 90, 60)
        file.header.nxstart, file.header.nystart, file.header.nzstart = 10, 20, 30
    volume = io.open(path)
    assert volume.size == (4, 3, 5)
    np.testing.assert_array_equal(volume.array, ramp.transpose(2, 0, 1))
    axis_b = np.array([0.5, np.sqrt(0.75), 0])
    np.testing.assert_allclose(volume.world_from_index[:3, 1], axis_b, atol=1e-7)
    np.testing.assert_allclose(volume.origin, 20 * np.array([1.0, 0, 0]) + 30 * axis_b + [0, 0, 10], atol=1e-6)


def test_mrc_stack_and_complex(tmp_path: Path) -> None:
    array = np.arange(120, dtype=np.int16).reshape(2, 3, 4, 5)
    with mrcfile.new(tmp_path / "a.mrc") as file:
        file.set_data(array)
        file.set_volume_stack() if not file.is_volume_stack() else None
    volume = io.open(tmp_path / "a.mrc")
    np.testing.assert_array_equal(volume.array[:, 0], array)
    with mrcfile.new(tmp_path / "b.mrc") as file:
        file.set_data(np.ones((3, 4, 5), np.complex64))
    with pytest.raises(DataError, match="complex"):
        io.open(tmp_path / "b.mrc")


def test_gzip_members_padding_and_rubbish(tmp_path: Path, ramp: np.ndarray) -> None:
    head = b"NRRD0004\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: %s\n\n"
    data = ramp.tobytes()
    path = tmp_path / "a.nrrd"
    whole = gzip.compress(data[:50]) + gzip.compress(b"") + gzip.compress(data[50:])
    path.write_bytes(head % b"gzip" + whole + b"\0" * 100)
    np.testing.assert_array_equal(io.open(path).array, ramp)
    path.write_bytes(head % b"bzip2" + bz2.compress(data[:50]) + bz2.compress(data[50:]))
    np.testing.assert_array_equal(io.open(path).array, ramp)
    for bad, what in (
        (whole + b"rubbish", "goes on after"),
        (gzip.compress(data)[:-9], "cut short"),
        (gzip.compress(data[:-2]), "cut short"),
        (gzip.compress(data + b"x"), "more samples"),
        (gzip.compress(data)[:-8] + bytes(8), "damaged"),
    ):
        path.write_bytes(head % b"gzip" + bad)
        with pytest.raises(FileError, match=what):
            io.open(path)


def test_nifti_with_a_long_extension(tmp_path):
    """What lies between header and samples (label names, for instance) is stepped over."""
    nibabel = pytest.importorskip("nibabel")
    image = nibabel.Nifti1Image(np.arange(24, dtype=np.int16).reshape(2, 3, 4), np.eye(4))
    image.header.extensions.append(nibabel.nifti1.Nifti1Extension("comment", b"x" * 5000))
    nibabel.save(image, tmp_path / "a.nii.gz")
    assert np.array_equal(io.open(tmp_path / "a.nii.gz").array, np.asarray(image.dataobj).T)
