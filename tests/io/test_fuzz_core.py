"""Damaged and hostile files for each of the light readers: ``pytest -m fuzz`` tries 10,000 of them a reader."""

from __future__ import annotations

import base64
import gzip
import io as bytes_io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import mrcfile
import nibabel
import numpy as np
import pytest
from damage import FUZZ_EXAMPLES, ORDINARY_EXAMPLES, survive

from airlight import io
from airlight.volume import Volume

RAMP = np.arange(60, dtype=np.int16).reshape(3, 4, 5)


def nrrd_seeds(folder: Path) -> list[bytes]:
    head = b"NRRD0005\ntype: short\ndimension: 3\nspace: RAS\nsizes: 5 4 3\nspace directions: (1,0,0) (0,2,0.5) (0,0,3)\n"
    head += b'kinds: domain domain domain\nendian: big\nspace units: "mm" "mm" "mm"\nspace origin: (1,2,3)\nencoding: '
    times = b"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 5 4 3\nencoding: raw\nkinds: vector domain domain domain\n"
    times += b"spacings: nan 1 2 3\naxis mins: nan 0 0 0\ncenters: none cell node cell\ndata file: LIST\nsound0.nrrd\n\n"
    text = b"NRRD0001\ntype: int\ndimension: 3\nsizes: 2 2 2\nencoding: text\nbyte skip: 0\n\n1 2 3 4 5 6 7 8\n"
    (folder / "p1.raw").write_bytes(bytes(60))
    (folder / "p2.raw").write_bytes(bytes(60))
    parts = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5 4 6\nencoding: raw\nline skip: 0\ndata file: p%d.raw 1 2 1\n\n"
    seeds = [head + b"gzip\n\n" + gzip.compress(RAMP.tobytes()), head + b"raw\n\n" + RAMP.tobytes(), text, parts]
    return [*seeds, times.replace(b"data file: LIST\nsound0.nrrd\n\n", b"\n") + RAMP.tobytes()]


def nifti_seeds(folder: Path) -> list[bytes]:
    seeds = []
    for kind, array in ((nibabel.Nifti1Image, RAMP.T), (nibabel.Nifti2Image, np.ones((3, 4, 5, 2, 3), np.float32))):
        image = kind(array, np.diag([1, 2, 3, 1]))
        image.header.set_slope_inter(2, -3)
        nibabel.save(image, folder / "seed.nii")
        data = (folder / "seed.nii").read_bytes()
        seeds += [data, gzip.compress(data)]
    return seeds


def metaimage_seeds(folder: Path) -> list[bytes]:
    head = b"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
    head += b"TransformMatrix = 1 0 0 0 1 0 0 0 1\n"
    head += (
        b"Offset = 1 2 3\nAnatomicalOrientation = RAI\nElementSpacing = 1 2 3\nDimSize = 5 4 3\nElementNumberOfChannels = 1\n"
    )
    tail = b"ElementType = MET_SHORT\nElementDataFile = LOCAL\n"
    for i in range(3):
        (folder / f"s{i}.raw").write_bytes(bytes(40))
    listed = head + b"ElementType = MET_SHORT\nElementDataFile = LIST\ns0.raw\ns1.raw\ns2.raw\n"
    numbered = head + b"ElementType = MET_SHORT\nElementDataFile = s%d.raw 0 2 1\n"
    return [
        head + tail + RAMP.tobytes(),
        head + b"CompressedData = True\n" + tail + zlib.compress(RAMP.tobytes()),
        listed,
        numbered,
    ]


def npy_seeds(folder: Path) -> list[bytes]:
    def saved(save: Callable[..., None], *args: object, **keywords: object) -> bytes:
        file = bytes_io.BytesIO()
        save(file, *args, **keywords)
        return file.getvalue()

    return [saved(np.save, RAMP), saved(np.save, np.asfortranarray(RAMP.astype(">f4")))]


def npz_seeds(folder: Path) -> list[bytes]:
    seeds = []
    for save in (np.savez, np.savez_compressed):
        file = bytes_io.BytesIO()
        save(file, volume=RAMP, world_from_index=np.eye(4), units="mm")
        seeds.append(file.getvalue())
    return seeds


def dat_seeds(folder: Path) -> list[bytes]:
    (folder / "a.raw").write_bytes(RAMP.tobytes())
    return [b"ObjectFileName: a.raw\nResolution: 5 4 3\nSliceThickness: 1 1 2.5\nFormat: USHORT\nObjectModel: I\n"]


def vti_seeds(folder: Path) -> list[bytes]:
    head = '<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt32" {0}>'
    head += '<ImageData WholeExtent="0 4 0 3 0 2" Origin="0 0 0" Spacing="1 2 3" Direction="1 0 0 0 1 0 0 0 1">'
    head += '<Piece Extent="0 4 0 3 0 2"><PointData><DataArray type="Int16" Name="a" {1}</DataArray></PointData></Piece>'
    head += "</ImageData>"
    data = RAMP.tobytes()
    packed = zlib.compress(data)
    blocks = struct.pack("<4I", 1, 120, 0, len(packed))
    length = struct.pack("<I", 120)
    compressor = 'compressor="vtkZLibDataCompressor"'
    end = "</VTKFile>"
    inline = head.format(compressor, f'format="binary">{(base64.b64encode(blocks) + base64.b64encode(packed)).decode()}') + end
    text = head.format("", 'NumberOfComponents="1" format="ascii">' + " ".join(str(n) for n in RAMP.ravel())) + end
    plain = head.format("", f'format="binary">{base64.b64encode(length + data).decode()}') + end
    seeds = [inline.encode(), text.encode(), plain.encode()]
    for extra, content in (("", length + data), (compressor, blocks + packed)):
        start = head.format(extra, 'format="appended" offset="0">') + '<AppendedData encoding="raw">_'
        seeds.append(start.encode() + content + b"</AppendedData></VTKFile>")
    return seeds


def mrc_seeds(folder: Path) -> list[bytes]:
    seeds = []
    for array in (RAMP, RAMP.astype(np.float32)):
        with mrcfile.new(folder / "seed.mrc", overwrite=True) as file:
            file.set_data(array)
            file.voxel_size = 2.0
        data = (folder / "seed.mrc").read_bytes()
        seeds += [data, gzip.compress(data)]
    return seeds


READERS = {
    ".nrrd": nrrd_seeds,
    ".nii": nifti_seeds,
    ".mha": metaimage_seeds,
    ".npy": npy_seeds,
    ".npz": npz_seeds,
    ".dat": dat_seeds,
    ".vti": vti_seeds,
    ".mrc": mrc_seeds,
}


@pytest.mark.parametrize("suffix", READERS)
def test_damaged_files_are_survived(tmp_path: Path, suffix: str) -> None:
    survive(tmp_path, suffix, READERS[suffix](tmp_path), ORDINARY_EXAMPLES)


@pytest.mark.fuzz
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("suffix", READERS)
def test_ten_thousand_damaged_files_are_survived(tmp_path: Path, suffix: str) -> None:
    tally = survive(tmp_path, suffix, READERS[suffix](tmp_path), FUZZ_EXAMPLES)
    assert tally["refused"] > tally["read"] / 10


def test_every_single_byte_of_a_header_may_be_cut(tmp_path: Path) -> None:
    io.save(Volume(RAMP), tmp_path / "a.nrrd")
    io.save(Volume(RAMP), tmp_path / "a.nii")
    io.save(Volume(RAMP), tmp_path / "a.npy")
    for path in sorted(tmp_path.iterdir()):
        whole = path.read_bytes()
        for length in range(len(whole)):
            path.write_bytes(whole[:length])
            with pytest.raises(io.FileError):
                io.open(path)
