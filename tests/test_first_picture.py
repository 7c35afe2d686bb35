"""A good first picture of anything: of objects before noise, of labels, and of what hardly is a volume."""

from __future__ import annotations

import runpy
import time
from pathlib import Path

import numpy as np
import pytest

import airlight as al
from airlight.errors import ValueRangeError
from airlight.first_picture import automatic_transfer, first_picture, resolve
from airlight.first_picture.survey import survey
from airlight.first_picture.view import chosen_direction, fitted_camera, visible_points
from airlight.transfer import presets
from airlight.volume import Volume

SIZE = (64, 64)
REAL = {
    "ct_head.nrrd": "ct",
    "labels/ts_example_ct.nii.gz": "ct",
    "engine.nii.gz": "object",
    "tooth.nrrd": "object",
    "shell_225x128x128.tif": "object",
    "ch2.nii.gz": "object",
    "stroke_T1.nii.gz": "object",
    "fuel.nii.gz": "cloud",
    "hydrogen.vti": "cloud",
    "labels/aal.nii.gz": "labels",
    "labels/nuclei.tif": "cloud",
    "labels/nuclei_label.tif": "labels",
}


def ball(size: int = 40, radius: float = 12.0, centre: tuple[float, float, float] | None = None) -> np.ndarray:
    """Share of each voxel that a ball fills, about."""
    z, y, x = np.mgrid[:size, :size, :size]
    cx, cy, cz = centre or ((size - 1) / 2,) * 3
    return np.clip(radius - np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) + 0.5, 0, 1)


def noisy_object(rng: np.random.Generator) -> Volume:
    return Volume((100 * ball() + rng.normal(20, 4, (40, 40, 40))).clip(0, 255).astype(np.uint8))


def hounsfield(rng: np.random.Generator) -> np.ndarray:
    """A body with a bone inside, in air, with noise."""
    return (-1000 + 1040 * ball(40, 14.0) + 900 * ball(40, 5.0) + rng.normal(0, 8, (40, 40, 40))).astype(np.int16)


ODD = {
    "constant": np.full((5, 6, 7), 3.0),
    "zeros": np.zeros((4, 4, 4), np.uint8),
    "all NaN": np.full((4, 5, 6), np.nan, np.float32),
    "one NaN": np.where(np.arange(60).reshape(3, 4, 5) == 7, np.nan, np.arange(60.0).reshape(3, 4, 5)),
    "one voxel": np.ones((1, 1, 1), np.int16),
    "two voxels": np.array([[[0, 9]]], np.uint8),
    "slice along z": np.arange(30.0).reshape(1, 5, 6),
    "slice along y": np.arange(30).reshape(5, 1, 6).astype(np.int16),
    "slice along x": np.arange(30).reshape(5, 6, 1).astype(np.uint16),
    "row": np.arange(9.0).reshape(1, 1, 9),
    "huge": np.linspace(-1e300, 1e300, 125).reshape(5, 5, 5),
    "tiny": np.linspace(0, 1e-30, 125).reshape(5, 5, 5),
    "bool": ball(12, 4.0) > 0.5,
    "two values": np.where(ball(12, 4.0) > 0.5, 0.25, -0.5),
    "negative": -1.0 - ball(12, 4.0),
    "signed bytes": (ball(12, 4.0) * 200 - 100).astype(np.int8),
    "far labels": np.where(ball(12, 4.0) > 0.5, 4_000_000_000, 7).astype(np.uint32),
    "one outlier": np.where(np.arange(1000).reshape(10, 10, 10) == 555, 1e9, 0.0),
}


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("anatomical", [False, True])
def test_odd_volumes_get_a_picture(name, anatomical):
    volume = Volume(ODD[name], anatomical=anatomical)
    scene = first_picture(volume, (60, 40))
    assert len(scene.layers) == 1
    camera = scene.camera
    assert np.isfinite([*camera.eye, *camera.target, *camera.up]).all()
    assert camera.eye != camera.target
    assert first_picture(Volume(ODD[name].copy(), anatomical=anatomical), (60, 40)) == scene


@pytest.mark.parametrize("name", ["constant", "all NaN", "one voxel", "slice along y", "bool", "two values", "one NaN"])
def test_odd_volumes_are_drawn(renderer, name):
    image = renderer.render(first_picture(Volume(ODD[name]), SIZE), SIZE)
    assert np.isfinite(image.rgba).all()
    shown = float((image.rgba[..., 3] > 0.05).mean())
    assert shown == 0 if name == "all NaN" else shown > 0.1


def test_object_is_shown_and_noise_is_not(renderer, rng):
    volume = noisy_object(rng)
    found = survey(volume)
    assert found.kind == "object"
    assert 30 < found.begin < 100
    image = renderer.render(first_picture(volume, SIZE), SIZE)
    alpha = image.rgba[..., 3]
    assert alpha[32, 32] > 0.99
    # A disc that fills the picture, and nothing in the corners.
    assert 0.55 < (alpha > 0.5).mean() < 0.8
    assert alpha[:6, :6].max() < 0.01
    assert (image.rgb.max(axis=-1) >= 1)[alpha > 0.1].mean() < 0.01


def test_dark_objects_in_bright_surroundings_are_shown(renderer, rng):
    volume = Volume((200 - 120 * ball() + rng.normal(0, 3, (40, 40, 40))).clip(0, 255).astype(np.uint8))
    found = survey(volume)
    assert (found.kind, found.dark) == ("object", True)
    _, (surroundings, inside) = automatic_transfer(volume)([200, 80])
    assert surroundings == 0 < inside
    alpha = renderer.render(first_picture(volume, SIZE), SIZE).rgba[..., 3]
    assert alpha[32, 32] > 0.99
    assert alpha[:6, :6].max() < 0.01


def test_content_is_framed_not_the_box():
    volume = Volume((200 * ball(48, 6.0, (10, 12, 30))).astype(np.uint8), spacing=(2, 2, 2))
    points = visible_points(volume, automatic_transfer(volume), survey(volume))
    assert np.allclose((points.min(axis=0) + points.max(axis=0)) / 2, (20, 24, 60), atol=3)
    assert np.ptp(points, axis=0).max() < 34
    assert np.allclose(first_picture(volume).camera.target, (20, 24, 60), atol=4)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_all_points_are_in_the_picture(rng, aspect):
    points = rng.normal(0, (3, 10, 1), (200, 3)) + np.array([50, -20, 7])
    to_eye, up = np.array([0.48, -0.64, 0.6]), np.array([0.0, 0.0, 1.0])
    camera = fitted_camera(points, to_eye, up, aspect)
    right = np.cross(up, to_eye) / np.linalg.norm(np.cross(up, to_eye))
    p = points - camera.eye
    depth = -(p @ to_eye)
    assert (depth > 0).all()
    x = p @ right / depth / np.tan(np.radians(15)) / aspect
    y = p @ np.cross(to_eye, right) / depth / np.tan(np.radians(15))
    assert np.abs(x).max() < 1
    assert np.abs(y).max() < 1
    assert max(np.abs(x).max(), np.abs(y).max()) > 0.85


def test_flat_volumes_are_seen_from_above():
    wide = Volume(np.ones((3, 60, 60), np.uint8) * np.arange(1, 61, dtype=np.uint8))
    points = wide.corners_world()
    assert chosen_direction(points, wide, survey(wide))[0][2] > 0.8
    cube = Volume(np.ones((60, 60, 60), np.uint8) * np.arange(1, 61, dtype=np.uint8))
    assert 0.2 < chosen_direction(cube.corners_world(), cube, survey(cube))[0][2] < 0.6


def test_anatomy_is_seen_from_the_front(rng):
    volume = Volume(hounsfield(rng), anatomical=True, units="mm")
    assert chosen_direction(volume.corners_world(), volume, survey(volume))[0].tolist() == [0, -1, 0]


@pytest.mark.parametrize("flipped", [False, True])
def test_no_view_through_the_table(rng, flipped):
    grid = hounsfield(rng)
    grid[:, 1:3, :] = 400
    matrix = np.diag([1.0, -1.0 if flipped else 1.0, 1.0, 1.0])
    volume = Volume(grid, world_from_index=matrix, anatomical=True)
    direction, _ = chosen_direction(volume.corners_world(), volume, survey(volume))
    assert direction[1] == (-1 if flipped else 1)


def test_hounsfield_units_are_known_by_file_or_by_histogram(rng):
    grid = hounsfield(rng)
    assert survey(Volume(grid)).kind == "ct"
    assert survey(Volume(grid + 1024)).kind == "object"
    assert survey(Volume(grid, modality="MR")).kind != "ct"
    assert survey(Volume(np.maximum(grid, -600), value_unit="HU")).kind == "ct"
    function = automatic_transfer(Volume(grid))
    _, (air, skin, tissue, bone) = function([-1000, -350, 40, 800])
    assert air == tissue == 0
    assert 0 < skin < bone


def test_bone_free_ct_shows_tissue(rng):
    grid = (-1000 + 1040 * ball(40, 14.0) + rng.normal(0, 8, (40, 40, 40))).astype(np.int16)
    assert automatic_transfer(Volume(grid, modality="CT"))([60.0])[1] > 0


def test_labels_get_colours_of_their_own():
    labels = np.zeros((24, 24, 24), np.uint16)
    for i, label in enumerate((1, 2, 5, 40)):
        labels[4:20, 4:20, 4 * i + 4 : 4 * i + 8] = label
    volume = Volume(labels)
    found = survey(volume)
    assert (found.kind, found.labels) == ("labels", (0, 1, 2, 5, 40))
    function = automatic_transfer(volume)
    colours, extinctions = function([0, 1, 2, 5, 40])
    assert extinctions[0] == 0
    assert (extinctions[1:] > 0).all()
    distances = [np.abs(a - b).max() for i, a in enumerate(colours[1:]) for b in colours[i + 2 :]]
    assert min(distances) > 0.15
    look = first_picture(volume).layers[0].look
    assert (look.field.name, look.transfer.name) == ("nearest", "postclassified")


def test_masks_and_signs():
    assert survey(Volume(ball(12, 4.0) > 0.5)).kind == "mask"
    assert survey(Volume((ball(12, 4.0) > 0.5).astype(np.uint8) * 255)).kind == "mask"
    wave = al.samples.load("hydrogen", size=32)
    assert survey(wave).kind == "signed"
    function = automatic_transfer(wave)
    low, high = function.domain
    assert low == -high
    assert function([0.0])[1] == 0
    assert function([low])[1] == function([high])[1] > 0


def test_noise_above_the_background_is_left_out(rng):
    cells = sum(900 * ball(48, 4.0, c) ** 2 for c in ((12, 12, 12), (30, 20, 25), (24, 36, 34)))
    volume = Volume((cells + rng.normal(300, 40, (48, 48, 48))).clip(0).astype(np.uint16))
    function = automatic_transfer(volume)
    below = function.domain[0]
    assert function([below])[1] == 0
    assert 380 < below < 900


def test_opacity_goes_with_the_size_of_the_world():
    small, large = (Volume((200 * ball()).astype(np.uint8), spacing=(s, s, s)) for s in (1.0, 10.0))
    a, b = automatic_transfer(small), automatic_transfer(large)
    assert a.values.tolist() == b.values.tolist()
    assert np.allclose(a.extinctions, 10 * b.extinctions)


def test_functions_suit_small_tables(rng):
    from airlight.transfer.tables import entries_needed

    for volume in (
        noisy_object(rng),
        Volume(hounsfield(rng)),
        Volume(ball() > 0.5),
        Volume(200 * ball()),
        al.samples.load("hydrogen", size=32),
        al.samples.load("vortex", size=32),
        al.samples.load("marschner-lobb"),
    ):
        assert entries_needed(automatic_transfer(volume), min(volume.spacing)) <= 256


def test_resolve_fills_in_what_is_open(rng):
    volume = noisy_object(rng)
    resolved = resolve(al.Scene(volume, camera="left"), SIZE)
    assert resolved.layers[0].transfer is automatic_transfer(volume)
    assert resolved.camera.eye[0] > 40
    assert resolve(resolved, SIZE) == resolved
    start = time.perf_counter()
    for _ in range(20):
        resolve(al.Scene(volume, camera="left"), SIZE)
    assert time.perf_counter() - start < 1


# -- presets


@pytest.mark.parametrize("name", presets.names())
def test_presets_give_functions(rng, name):
    volume = Volume(hounsfield(rng), units="mm")
    function = presets.get(name, volume)
    assert function.extinctions[0] == 0
    assert function.extinctions.max() > 0
    assert presets.get(name.replace("_", "-"), volume) == function
    assert presets.describe(name)
    empty = presets.get(name, Volume(np.full((2, 2, 2), np.nan)))
    assert np.isfinite(empty.extinctions).all()


def test_presets_go_by_millimetres(rng):
    mm, m, um = (presets.get("ct_bone", Volume(hounsfield(rng), units=u)) for u in ("mm", "m", "um"))
    assert np.allclose(m.extinctions, 1000 * mm.extinctions)
    assert np.allclose(um.extinctions, mm.extinctions / 1000)


def test_relative_presets_go_by_the_range(rng):
    grid = rng.normal(0, 1, (16, 16, 16))
    a, b = presets.get("mri", Volume(grid)), presets.get("mri", Volume(1000 * grid + 5))
    assert np.allclose(b.values, 1000 * a.values + 5, rtol=1e-3, atol=20)


def test_unknown_presets_are_told_the_known(rng):
    with pytest.raises(ValueRangeError, match=r"preset is 'nothing', must be one of ct_bone, .*xray"):
        presets.get("nothing", noisy_object(rng))


# -- real volumes


@pytest.mark.data
@pytest.mark.parametrize("name", REAL)
def test_real_volumes(renderer, data_dir, name):
    path = data_dir / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    volume = al.open(path)
    assert survey(volume).kind == REAL[name]
    image = renderer.render(first_picture(volume, (96, 96)), (96, 96))
    covered = image.rgba[..., 3] > 0.1
    assert 0.05 < covered.mean() < 0.9
    assert (image.rgb.max(axis=-1) >= 1)[covered].mean() < 0.01
    assert 0.03 < image.rgb[covered].mean() < 0.7


@pytest.mark.data
def test_first_picture_is_quick(data_dir):
    volume = al.open(data_dir / "ct_head.nrrd")
    start = time.perf_counter()
    first_picture(volume)
    # 0.06 s on a free machine; other tests may run beside.
    assert time.perf_counter() - start < 1.0


# -- the gallery


def test_gallery_is_complete(capsys):
    scripts = Path(__file__).parent.parent / "scripts" / "gallery.py"
    gallery = runpy.run_path(str(scripts))
    names = [entry.name for entry in gallery["ENTRIES"]]
    assert len(set(names)) == len(names)
    assert {entry.volume for entry in gallery["ENTRIES"] if entry.is_sample} <= set(al.samples.names())
    assert gallery["check"]() == 0, capsys.readouterr().out
