"""Where voxels lie: compared with SimpleITK (LPS) and nibabel (RAS), which share no code with the readers here."""

from __future__ import annotations

import itertools
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK as sitk  # noqa: N813
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import affines

from airlight import io

LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
RAMP = np.arange(60, dtype=np.int16).reshape(3, 4, 5)
SPACES = ["RAS", "LAS", "LPS", "left-posterior-superior", "right-anterior-superior", "left-anterior-superior"]
VOXELS = [(0, 0, 0), (4, 0, 0), (0, 3, 0), (0, 0, 2), (4, 3, 2), (2, 1, 1)]


def same_as_sitk(volume, image, voxels=VOXELS, atol=1e-6):
    for voxel in voxels:
        place = volume.world_from_index @ (*voxel, 1.0)
        np.testing.assert_allclose(place[:3], image.TransformIndexToPhysicalPoint(voxel), atol=atol, rtol=1e-6)
        assert volume.array[..., voxel[2], voxel[1], voxel[0]].flat[0] == np.ravel(image.GetPixel(*voxel))[0]


def same_as_nibabel(volume, image, voxels=VOXELS):
    data = image.get_fdata()
    data = data.reshape(data.shape + (1,) * (3 - data.ndim))
    for voxel in voxels:
        place = volume.world_from_index @ (*voxel, 1.0)
        np.testing.assert_allclose(place, LPS_FROM_RAS @ image.affine @ (*voxel, 1.0), atol=1e-5)
        value = volume.array[..., voxel[2], voxel[1], voxel[0]].flat[0]
        np.testing.assert_allclose(value, data[voxel].flat[0], rtol=1e-6)


def corners(size):
    return [tuple(int(n) for n in voxel) for voxel in itertools.product(*[(0, n // 2, n - 1) for n in size])]


@settings(max_examples=60, deadline=None)
@given(
    matrix=affines(shear=True),
    space=st.sampled_from(SPACES),
)
def test_nrrd_lies_where_simpleitk_puts_it(folder: Path, matrix, space) -> None:
    path = folder / "o.nrrd"
    header = {
        "space": space,
        "space directions": matrix[:3, :3].T,
        "space origin": matrix[:3, 3],
        "kinds": ["domain"] * 3,
    }
    nrrd.write(str(path), RAMP.T, header)
    volume = io.open(path)
    assert volume.anatomical
    assert volume.units == "mm"
    same_as_sitk(volume, sitk.ReadImage(str(path)), atol=1e-4)
    np.testing.assert_array_equal(volume.array, RAMP)


@settings(max_examples=60, deadline=None)
@given(matrix=affines(shear=False), suffix=st.sampled_from([".mha", ".mhd"]), compress=st.booleans())
def test_metaimage_lies_where_simpleitk_puts_it(folder: Path, matrix, suffix, compress) -> None:
    path = folder / f"o{suffix}"
    image = sitk.GetImageFromArray(RAMP)
    spacing = np.linalg.norm(matrix[:3, :3], axis=0)
    image.SetSpacing(spacing.tolist())
    image.SetDirection((matrix[:3, :3] / spacing).ravel().tolist())
    image.SetOrigin(matrix[:3, 3].tolist())
    sitk.WriteImage(image, str(path), useCompression=compress)
    volume = io.open(path)
    assert volume.anatomical
    same_as_sitk(volume, sitk.ReadImage(str(path)))
    same_as_sitk(volume, image, atol=1e-4)


@settings(max_examples=60, deadline=None)
@given(matrix=affines(shear=True))
def test_sheared_metaimage_keeps_its_columns(folder: Path, matrix) -> None:
    path = folder / "s.mha"
    spacing = np.linalg.norm(matrix[:3, :3], axis=0)
    turns = " ".join(repr(float(n)) for n in (matrix[:3, :3] / spacing).T.ravel())
    head = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
    head += f"TransformMatrix = {turns}\nOffset = {' '.join(repr(float(n)) for n in matrix[:3, 3])}\n"
    head += f"ElementSpacing = {' '.join(repr(float(n)) for n in spacing)}\nDimSize = 5 4 3\n"
    path.write_bytes(head.encode() + b"ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + RAMP.tobytes())
    same_as_sitk(io.open(path), sitk.ReadImage(str(path)), atol=1e-4)
    np.testing.assert_allclose(io.open(path).world_from_index, matrix, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(matrix=affines(shear=True), code=st.sampled_from(["sform", "both"]), suffix=st.sampled_from([".nii", ".nii.gz", ".img"]))
def test_nifti_lies_where_nibabel_puts_it(folder: Path, matrix, code, suffix) -> None:
    path = folder / f"o{suffix}"
    kind = nibabel.Nifti1Pair if suffix == ".img" else nibabel.Nifti1Image
    image = kind(RAMP.T, None)
    image.set_sform(matrix, 2)
    if code == "both":
        image.set_qform(np.diag([2.0, 3.0, 4.0, 1.0]), 1)
    nibabel.save(image, path)
    volume = io.open(path.with_suffix(".hdr") if suffix == ".img" else path)
    assert volume.anatomical
    assert volume.dtype == np.int16
    same_as_nibabel(volume, nibabel.load(path))


@settings(max_examples=40, deadline=None)
@given(matrix=affines(shear=False))
def test_nifti_by_qform_lies_where_both_put_it(folder: Path, matrix) -> None:
    path = folder / "q.nii"
    image = nibabel.Nifti1Image(RAMP.T, None)
    image.set_qform(matrix, 1)
    nibabel.save(image, path)
    volume = io.open(path)
    same_as_nibabel(volume, nibabel.load(path))
    same_as_sitk(volume, sitk.ReadImage(str(path)), atol=1e-2)


def test_nifti_without_codes_takes_nibabels_base_affine(tmp_path: Path) -> None:
    path = tmp_path / "n.nii"
    image = nibabel.Nifti1Image(RAMP.T, None)
    image.header.set_zooms((2.0, 3.0, 4.0))
    nibabel.save(image, path)
    volume = io.open(path)
    assert not volume.anatomical
    same_as_nibabel(volume, nibabel.load(path))


REAL_NIFTI = ["ch2.nii.gz", "fuel.nii.gz", "labels/aal.nii.gz", "labels/ts_example_ct.nii.gz", "stroke_T1.nii.gz"]
REAL = ["ct_head.nrrd", "tooth.nrrd", "formats/LIDC2.mha", "ch2.nii.gz", "engine.nii.gz", "fuel.nii.gz", "stroke_FLAIR.nii.gz"]


@pytest.mark.data
@pytest.mark.parametrize("name", [*REAL, "labels/inia19-NeuroMaps.nii.gz", "labels/example_ct_sm.nii.gz"])
def test_real_volumes_lie_where_simpleitk_puts_them(data_dir: Path, name: str) -> None:
    volume = io.open(data_dir / name)
    image = sitk.ReadImage(str(data_dir / name))
    assert volume.size == image.GetSize()
    same_as_sitk(volume, image, corners(volume.size), atol=1e-3)
    np.testing.assert_array_equal(volume.array, sitk.GetArrayViewFromImage(image))


@pytest.mark.data
@pytest.mark.parametrize("name", REAL_NIFTI)
def test_real_nifti_lies_where_nibabel_puts_it(data_dir: Path, name: str) -> None:
    volume = io.open(data_dir / name)
    same_as_nibabel(volume, nibabel.load(data_dir / name), corners(volume.size))
