"""Round trips through the writers."""

from __future__ import annotations

import math
from pathlib import Path

import nibabel
import numpy as np
import pytest
import SimpleITK as sitk  # noqa: N813
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from strategies import affines, arrays

from airlight import io
from airlight.errors import FileError
from airlight.volume import Volume

TRAITS = ("units", "value_unit", "channel_names", "times", "time_unit", "no_data", "anatomical", "modality")


@st.composite
def volumes(draw: st.DrawFn) -> Volume:
    array = draw(arrays())
    anatomical = draw(st.booleans())
    channels = array.shape[-4] if array.ndim >= 4 else 1
    named = draw(st.booleans()) and array.ndim > 3
    timed = array.ndim == 5 and draw(st.booleans())
    return Volume(
        array,
        world_from_index=draw(affines(shear=True)),
        units="mm" if anatomical else draw(st.sampled_from(["", "mm", "um", "m", "parsec"])),
        value_unit=draw(st.sampled_from(["", "HU", "1/cm"])),
        channel_names=[f"c{i} ü" for i in range(channels)] if named else (),
        times=[0.5 * i for i in range(array.shape[0])] if timed else (),
        time_unit="s" if timed else "",
        no_data=draw(st.sampled_from([None, 0.0, -1.5])),
        anatomical=anatomical,
        modality=draw(st.sampled_from(["", "CT", "labels", "microscopy"])),
    )


@settings(max_examples=150, deadline=None)
@given(volume=volumes())
def test_nrrd_keeps_everything(folder: Path, volume: Volume) -> None:
    path = folder / "a.nrrd"
    io.save(volume, path)
    again = io.open(path)
    np.testing.assert_array_equal(again.array, volume.array)
    assert again.dtype == (np.float32 if volume.dtype == np.float16 else volume.dtype)
    np.testing.assert_array_equal(again.world_from_index, volume.world_from_index)
    assert {t: getattr(again, t) for t in TRAITS} == {t: getattr(volume, t) for t in TRAITS}


def test_channels_of_a_narrow_nifti_are_no_colours(folder: Path) -> None:
    array = np.arange(4 * 4 * 5 * 3, dtype=np.uint8).reshape(1, 4, 4, 5, 3)
    io.save(Volume(array), folder / "narrow.nii")
    assert np.array_equal(io.open(folder / "narrow.nii").array.reshape(array.shape), array)


@settings(max_examples=150, deadline=None)
@given(volume=volumes(), suffix=st.sampled_from([".nii", ".nii.gz"]))
def test_nifti_keeps_samples_geometry_and_times(folder: Path, volume: Volume, suffix: str) -> None:
    path = folder / f"a{suffix}"
    io.save(volume, path)
    again = io.open(path)
    expected = volume.array
    if expected.ndim == 5 and expected.shape[0] == 1:
        expected = expected[0]
    if expected.ndim == 4 and expected.shape[0] == 1:
        expected = expected[0]
    got = again.array
    got = got.reshape(expected.shape) if got.size == expected.size else got
    np.testing.assert_array_equal(got, expected)
    scale = np.abs(volume.world_from_index).max()
    np.testing.assert_allclose(again.world_from_index, volume.world_from_index, atol=2e-7 * scale)
    assert again.anatomical == volume.anatomical
    assert again.units == (volume.units if volume.units != "parsec" else "")
    if volume.times and volume.time_count > 1:
        np.testing.assert_allclose(again.times, volume.times)


@settings(max_examples=100, deadline=None)
@given(array=arrays())
def test_npy_keeps_samples(folder: Path, array: np.ndarray) -> None:
    assume(not (array.ndim == 4 and array.shape[-1] in (3, 4)))  # refused where it looks like colours
    path = folder / "a.npy"
    io.save(Volume(array), path)
    again = io.open(path, spacing=(1, 2, 3))
    np.testing.assert_array_equal(again.array, array)
    assert again.dtype == array.dtype
    assert again.spacing == (1, 2, 3)


def test_others_read_what_is_written(tmp_path: Path, ramp: np.ndarray) -> None:
    matrix = np.array([[0.0, 2, 0, 5], [-3, 0, 0, 6], [0, 0, 4, 7], [0, 0, 0, 1]])
    volume = Volume(ramp, world_from_index=matrix, units="mm", anatomical=True)
    io.save(volume, tmp_path / "a.nrrd")
    io.save(volume, tmp_path / "a.nii.gz")
    for name in ("a.nrrd", "a.nii.gz"):
        image = sitk.ReadImage(str(tmp_path / name))
        np.testing.assert_array_equal(sitk.GetArrayFromImage(image), ramp)
        np.testing.assert_allclose(image.TransformIndexToPhysicalPoint((4, 3, 2)), (matrix @ (4, 3, 2, 1))[:3])
    np.testing.assert_allclose(nibabel.load(tmp_path / "a.nii.gz").affine, np.diag([-1, -1, 1, 1]) @ matrix)


def test_other_lengths_become_millimetres_in_nifti(tmp_path: Path, ramp: np.ndarray) -> None:
    io.save(Volume(ramp, spacing=(10, 20, 30), units="nm"), tmp_path / "a.nii")
    again = io.open(tmp_path / "a.nii")
    assert again.units == "mm"
    np.testing.assert_allclose(again.spacing, (1e-5, 2e-5, 3e-5), rtol=1e-6)


def test_a_failed_write_leaves_the_old_file(tmp_path: Path, ramp: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.npy"
    io.save(Volume(ramp), path)

    def fail(*_args: object, **_kwargs: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "save", fail)
    with pytest.raises(FileError, match="cannot be written"):
        io.save(Volume(ramp + 1), path)
    np.testing.assert_array_equal(io.open(path).array, ramp)
    assert [p.name for p in tmp_path.iterdir()] == ["a.npy"]


@pytest.mark.parametrize("name", ["a.jpg", "a", "a.nhdr", "a.npz", "nowhere/a.nrrd"])
def test_what_cannot_be_written_is_said(tmp_path: Path, ramp: np.ndarray, name: str) -> None:
    with pytest.raises(FileError, match="cannot be written"):
        io.save(Volume(ramp), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_slices_of_a_larger_array_are_written(tmp_path: Path) -> None:
    array = np.arange(4 * 5 * 6, dtype=np.float32).reshape(4, 5, 6)[::2, ::-1, 1:4]
    for name in ("a.nrrd", "a.nii", "a.npy"):
        io.save(Volume(array), tmp_path / name)
        np.testing.assert_array_equal(io.open(tmp_path / name).array, array)
    assert math.prod(array.shape) == 30
