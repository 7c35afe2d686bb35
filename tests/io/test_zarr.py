"""OME-Zarr: round trip, levels and their places, versions 0.4 and 0.5, refusals, damage."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import COUNTS, damaged

from airlight import io
from airlight.errors import AirlightError, DataError, FileError, LimitError, MissingExtraError
from airlight.io import zarr as ome
from airlight.io.options import ReadOptions
from airlight.volume import Volume

zarr = pytest.importorskip("zarr")


def assert_same(first: Volume, second: Volume) -> None:
    np.testing.assert_array_equal(first.array, second.array)
    assert first.dtype == second.dtype
    np.testing.assert_array_equal(first.world_from_index, second.world_from_index)
    assert first._traits() == second._traits()


@pytest.mark.parametrize("dtype", ["bool", "uint8", "int16", "uint32", "int64", "float16", "float32", "float64"])
@pytest.mark.parametrize("shape", [(3, 4, 5), (2, 3, 4, 5), (2, 1, 3, 4, 5)])
def test_round_trip(tmp_path: Path, shape: tuple[int, ...], dtype: str) -> None:
    array = np.arange(np.prod(shape)).reshape(shape).astype(dtype)
    volume = Volume(array, spacing=(0.5, 0.25, 2), origin=(1, -2, 3), units="um")
    io.save(volume, tmp_path / "v.ome.zarr")
    assert_same(io.open(tmp_path / "v.ome.zarr"), volume)


def test_round_trip_of_everything(tmp_path: Path) -> None:
    array = np.random.default_rng(1).random((3, 2, 4, 5, 6), dtype=np.float32)
    volume = Volume(
        array,
        world_from_index=np.diag([-1.0, 2.0, 3.0, 1.0]),
        units="mm",
        value_unit="HU",
        channel_names=("a", "b"),
        times=(1.0, 1.5, 2.0),
        time_unit="s",
        no_data=-5.0,
        anatomical=True,
        modality="CT",
    )
    for _ in range(2):  # the second replaces the first
        io.save(volume, tmp_path / "v.zarr")
        assert_same(io.open(tmp_path / "v.zarr"), volume)
    assert [p.name for p in tmp_path.iterdir()] == ["v.zarr"]


def test_levels_are_means_in_their_place(tmp_path: Path) -> None:
    """A linear field is its own mean: every level must give the same value at the same place of the world."""
    z, y, x = np.mgrid[0:40, 0:60, 0:300].astype(np.float64)
    volume = Volume(2 * x + 3 * y - 5 * z, spacing=(0.5, 0.5, 0.5), origin=(7, 8, 9))
    io.save(volume, tmp_path / "v.zarr")
    sizes = []
    for level in range(3):
        coarse = io.open(tmp_path / "v.zarr", level=level)
        sizes.append(coarse.size)
        k, j, i = np.mgrid[: coarse.size[2], : coarse.size[1], : coarse.size[0]]
        world = coarse.world_from_index @ np.stack([i, j, k, np.ones_like(i)]).reshape(4, -1)
        back = volume.index_from_world @ world
        expected = (2 * back[0] + 3 * back[1] - 5 * back[2]).reshape(coarse.array.shape)
        np.testing.assert_allclose(coarse.array, expected, atol=1e-9)
    assert sizes == [(300, 60, 40), (150, 30, 20), (75, 15, 10)]
    with pytest.raises(DataError, match="no level 3: choose 0 to 2"):
        io.open(tmp_path / "v.zarr", level=3)


def test_pooling(tmp_path: Path) -> None:
    array = np.zeros((2, 2, 130), np.float32)
    array[0, 0, 0] = np.nan
    array[..., 2:4] = np.nan
    array[..., 4:] = 6
    ome.write(Volume(array), tmp_path / "v.zarr")
    coarse = io.open(tmp_path / "v.zarr", level=1).array
    assert coarse.shape == (1, 1, 65)
    np.testing.assert_array_equal(coarse[0, 0, :3], [0, np.nan, 6])  # empty samples stay out
    labels = np.arange(130, dtype=np.uint8).reshape(1, 1, 130)
    ome.write(Volume(labels, modality="labels"), tmp_path / "l.zarr")
    coarse_labels = io.open(tmp_path / "l.zarr", level=1)
    np.testing.assert_array_equal(coarse_labels.array, labels[..., ::2])
    assert coarse_labels.origin == (0, 0, 0)
    ome.write(Volume(array, spacing=(1, 1, 5)), tmp_path / "a.zarr", levels=2)
    assert io.open(tmp_path / "a.zarr", level=1).spacing == (2, 2, 5)


def test_written_files_are_valid_to_others(tmp_path: Path) -> None:
    models = pytest.importorskip("ome_zarr_models.v05.image")
    io.save(Volume(np.zeros((2, 4, 5, 200), np.uint8), channel_names=("a", "b"), units="um"), tmp_path / "v.zarr")
    image = models.Image.from_zarr(zarr.open_group(tmp_path / "v.zarr", mode="r"))
    assert [a.name for a in image.attributes.ome.multiscales[0].axes] == ["c", "z", "y", "x"]
    assert len(image.attributes.ome.multiscales[0].datasets) == 2


def version_4(folder: Path, array: np.ndarray, axes: Any, transforms: Any = (), image: Any = (), **more: Any) -> Path:
    group = zarr.open_group(folder, mode="w", zarr_format=2)
    group.create_array("0", shape=array.shape, dtype=array.dtype, chunks=array.shape)[...] = array
    scales = {"version": "0.4", "axes": axes, "datasets": [{"path": "0", "coordinateTransformations": list(transforms)}]}
    scales["coordinateTransformations"] = list(image)
    group.attrs.update({"multiscales": [scales], **more})
    return folder


def test_version_4(tmp_path: Path) -> None:
    array = np.arange(48, dtype=">u2").reshape(2, 2, 3, 4)
    units = {"z": "micrometer", "y": "nanometer", "x": "micrometer"}
    axes = [{"name": "c", "type": "channel"}, *({"name": n, "type": "space", "unit": u} for n, u in units.items())]
    transforms = [{"type": "scale", "scale": [1, 2, 500, 0.5]}, {"type": "translation", "translation": [0, 10, 20, 30]}]
    omero = {"channels": [{"label": "DAPI"}, {"label": "GFP"}]}
    doubled = [{"type": "scale", "scale": [1, 2, 2, 2]}]
    volume = io.open(version_4(tmp_path / "v.zarr", array, axes, transforms, doubled, omero=omero))
    np.testing.assert_array_equal(volume.array, array)
    np.testing.assert_allclose(volume.spacing, (1, 1, 4))
    np.testing.assert_allclose(volume.origin, (60, 0.04, 20))
    assert (volume.units, volume.channel_names, volume.modality) == ("um", ("DAPI", "GFP"), "microscopy")


def test_older_axes_and_strange_ones(tmp_path: Path) -> None:
    array = np.zeros((2, 3, 4), np.uint8)
    assert io.open(version_4(tmp_path / "a.zarr", array, ["z", "y", "x"])).size == (4, 3, 2)
    assert io.open(version_4(tmp_path / "b.zarr", array, ["c", "y", "x"])).array.shape == (2, 1, 3, 4)
    with pytest.raises(DataError, match="axes 'qyx'"):
        io.open(version_4(tmp_path / "c.zarr", array, ["q", "y", "x"]))
    turned = [{"type": "rotation", "rotation": [[1, 0], [0, 1]]}]
    with pytest.raises(DataError, match="'rotation' that is not understood"):
        io.open(version_4(tmp_path / "d.zarr", array, ["z", "y", "x"], turned))


def test_images_inside_and_plain_arrays(tmp_path: Path) -> None:
    group = zarr.open_group(tmp_path / "g.zarr", mode="w", zarr_format=3)
    array = np.arange(24, dtype=np.int32).reshape(2, 3, 4)
    group.create_array("plain", shape=array.shape, dtype=array.dtype)[...] = array
    io.save(Volume(array), tmp_path / "image.zarr")
    shutil.copytree(tmp_path / "image.zarr", tmp_path / "g.zarr" / "labels" / "cells")
    with pytest.raises(DataError, match=r"no multiscales.*plain"):
        io.open(tmp_path / "g.zarr")
    for name in ("plain", "labels/cells", "labels/cells/0"):
        np.testing.assert_array_equal(io.open(tmp_path / "g.zarr", dataset=name).array, array)
    with pytest.raises(FileError, match="inside"):
        io.open(tmp_path / "g.zarr", dataset="../image.zarr")


def test_zip(tmp_path: Path) -> None:
    volume = Volume(np.arange(24).reshape(2, 3, 4))
    io.save(volume, tmp_path / "v.zarr")
    shutil.make_archive(str(tmp_path / "z"), "zip", tmp_path / "v.zarr")
    assert_same(ome.read(tmp_path / "z.zip", ReadOptions()), volume)


def test_refusals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    turned = np.eye(4)[[1, 0, 2, 3]]
    with pytest.raises(DataError, match=r"turned or sheared.*nrrd"):
        io.save(Volume(np.zeros((2, 3, 4)), world_from_index=turned), tmp_path / "v.zarr")
    (tmp_path / "mine.zarr").mkdir()
    (tmp_path / "mine.zarr" / "thesis.txt").write_text("years of work")
    with pytest.raises(FileError, match="no Zarr folder"):
        io.save(Volume(np.zeros((2, 3, 4))), tmp_path / "mine.zarr")
    assert (tmp_path / "mine.zarr" / "thesis.txt").exists()
    group = zarr.open_group(tmp_path / "big.zarr", mode="w")
    group.create_array("a", shape=(10**4, 10**4, 10**4), dtype="u1", chunks=(64, 64, 64))
    with pytest.raises(LimitError):
        io.open(tmp_path / "big.zarr", dataset="a")
    import sys

    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(MissingExtraError, match=r'pip install "airlight\[zarr\]"'):
        io.open(tmp_path / "big.zarr")


def test_interrupted_writing_leaves_the_old(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from airlight.io import zarr_write

    old = Volume(np.arange(24).reshape(2, 3, 4))
    io.save(old, tmp_path / "v.zarr")

    def fail(*_: Any) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(zarr_write, "_attributes", fail)
    with pytest.raises(FileError, match="no space left"):
        io.save(Volume(np.zeros((2, 3, 4))), tmp_path / "v.zarr")
    assert_same(io.open(tmp_path / "v.zarr"), old)
    assert [p.name for p in tmp_path.iterdir()] == ["v.zarr"]


@pytest.mark.parametrize("count", COUNTS)
def test_damaged_files_give_one_error(tmp_path: Path, count: int) -> None:
    array = np.arange(60, dtype=np.int16).reshape(3, 4, 5)
    io.save(Volume(array, units="um"), tmp_path / "a.zarr")
    version_4(tmp_path / "b.zarr", array, [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"])
    files = [p for name in "ab" for p in sorted((tmp_path / f"{name}.zarr").rglob("*")) if p.is_file()]
    wholes = [p.read_bytes() for p in files]
    rng = np.random.default_rng(5)
    for number in range(count):
        path, whole = files[number % len(files)], wholes[number % len(files)]
        changed = damaged(whole, rng)
        if rng.random() < 0.3 and whole[:1] == b"{":  # still JSON, with another value somewhere
            changed = json.dumps(_other_value(json.loads(whole), rng)).encode()
        path.write_bytes(changed)
        try:
            io.open(tmp_path / path.relative_to(tmp_path).parts[0], max_memory=1 << 26)
        except AirlightError:
            pass
        finally:
            path.write_bytes(whole)


def _other_value(node: Any, rng: np.random.Generator) -> Any:
    if isinstance(node, dict) and node and rng.random() < 0.9:
        key = str(rng.choice(list(node)))
        return {k: _other_value(v, rng) if k == key else v for k, v in node.items()}
    if isinstance(node, list) and node and rng.random() < 0.9:
        at = int(rng.integers(0, len(node)))
        return [_other_value(v, rng) if i == at else v for i, v in enumerate(node)]
    others = [None, -1, 0, 10**12, 1e308, "", "..", [], {}, "x", True, [0], float("nan")]
    return others[int(rng.integers(0, len(others)))]
