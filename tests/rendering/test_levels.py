"""Pre-filtered levels: what they hold, which one is taken, and that small pictures do not alias."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from points import in_reference, inside, on_device, scene_of
from test_filters import sheared

import airlight as al
from airlight.reconstruction.levels import coarser, level_sizes

HAZE = al.TransferFunction([(0, "black", 0.01), (1, "white", 0.01)])


def cameras(volume: al.Volume) -> list[al.Camera]:
    """Pixels (of 64 in height) from a fourth of a voxel to more than the volume wide."""
    middle = tuple(volume.corners_world().mean(axis=0))
    away = [al.Camera.perspective(eye=(3, -d, 5), target=middle, fov_deg=40) for d in (4, 60, 400, 9000)]
    return away + [al.Camera.orthographic(eye=(3, -90, 5), target=middle, height=h) for h in (16, 64, 100, 1e4)]


@settings(max_examples=40)
@given(st.tuples(*[st.integers(1, 19)] * 3), st.integers(0, 2**32 - 1))
def test_levels_keep_the_mean(shape, seed):
    grid = np.random.default_rng(seed).uniform(-5, 9, shape)
    made = list(coarser(grid))
    assert [level.shape[::-1] for level in made] == list(level_sizes(shape[::-1])[1:])
    for level in made:
        assert level.mean(dtype=np.float64) == pytest.approx(grid.mean(), abs=1e-5)
        assert level.min() >= grid.min() - 1e-5
        assert level.max() <= grid.max() + 1e-5


def test_levels_are_means_of_boxes():
    grid = np.random.default_rng(0).uniform(0, 1, (8, 4, 6))
    first = next(coarser(grid))
    assert np.abs(first - grid.reshape(4, 2, 2, 2, 3, 2).mean(axis=(1, 3, 5))).max() < 1e-6
    odd = next(coarser(np.arange(5.0).reshape(1, 1, 5)))[0, 0]
    assert odd == pytest.approx([(0 + 1 + 0.5 * 2) / 2.5, (0.5 * 2 + 3 + 4) / 2.5])


@pytest.mark.parametrize("number", range(8))
@pytest.mark.parametrize("bias", [0.0, 0.7])
def test_against_the_reference(device, number, bias, rng):
    """Random samples: within a thousandth of the range, since texture units mix levels with few bits."""
    volume = sheared(rng.uniform(0, 100, (9, 21, 14)))
    drawn = scene_of(volume, al.field.Levels(bias), "analytic", cameras(volume)[number])
    p = inside(volume, 2000, rng)
    (value, gradient), (true_value, true_gradient) = on_device(device, drawn, p), in_reference(drawn, p)
    assert np.abs(value - true_value).max() <= 1e-3 * 100
    longest = np.linalg.norm(true_gradient, axis=1).max()
    off = np.linalg.norm(gradient - true_gradient, axis=1)
    assert np.quantile(off, 0.99) <= 1e-3 * longest + 1e-6  # places on the border of two cells may fall to either


def test_near_by_it_is_linear(device, rng):
    volume = sheared(rng.uniform(0, 100, (9, 21, 14)))
    p = inside(volume, 500, rng)
    near = on_device(device, scene_of(volume, "levels", "analytic", cameras(volume)[0]), p)
    linear = on_device(device, scene_of(volume, "linear", "analytic"), p)
    assert all(np.abs(a - b).max() < 1e-3 * np.abs(b).max() for a, b in zip(near, linear, strict=True))


def test_there_is_no_transition_to_be_seen(device, rng):
    """What a place shows changes with the distance of the eye, but never at once."""
    volume = sheared(rng.uniform(0, 100, (16, 16, 16)))
    p = inside(volume, 200, rng)
    heights = np.geomspace(8, 2000, 400)
    middle = tuple(volume.corners_world().mean(axis=0))
    seen = [
        on_device(
            device,
            scene_of(volume, "levels", "zero", al.Camera.orthographic(eye=(0, -50, 0), target=middle, height=h)),
            p,
        )[0]
        for h in heights
    ]
    # Eight octaves of levels in 400 steps: none may be larger than a few of such parts.
    change = np.abs(np.diff(seen, axis=0))
    assert change.max() < 4 * 100 * 8 / 400
    assert np.abs(seen[-1] - volume.array.mean()).max() < 0.1


def straight_on(field: str) -> al.Scene:
    """A pattern that changes from voxel to voxel, seen with parallel rays, a voxel to a pixel at 64 x 64."""
    z, _, x = np.indices((64, 8, 64))
    pattern = (0.5 + 0.5 * np.sin(2.9 * x + 0.4 * z) * np.cos(2.7 * z)).astype(np.float32)
    middle = (31.5, 3.5, 31.5)
    camera = al.Camera.orthographic(eye=(31.5, -20, 31.5), target=middle, height=64)
    look = al.Look(field=field, integrate="mean", shade="none")
    return al.Scene(al.Volume(pattern), transfer=HAZE, look=look, camera=camera, background=None)


def test_a_small_picture_is_a_large_one_made_small(renderer):
    """The mean along rays by a straight function: at an eighth of the size it is the mean of 8 x 8 pixels."""
    full = renderer.render(straight_on("linear"), (64, 64)).rgba[..., 0].astype(np.float64)
    wanted = full.reshape(8, 8, 8, 8).mean(axis=(1, 3))[1:-1, 1:-1]
    found = {
        field: renderer.render(straight_on(field), (8, 8)).rgba[1:-1, 1:-1, 0].astype(np.float64)
        for field in ("levels", "linear")
    }
    error = {field: np.sqrt(np.mean((image - wanted) ** 2)) for field, image in found.items()}
    assert error["levels"] < 0.02
    assert error["linear"] > 10 * error["levels"]


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16", "float16", "float64"])
def test_sample_types(device, core_device, dtype, rng):
    volume = al.Volume(rng.uniform(0, 255, (9, 12, 14)).astype(dtype))
    drawn = scene_of(volume, "levels", "zero", cameras(volume)[5])
    p = inside(volume, 500, rng)
    for made in (device, core_device):
        assert np.abs(on_device(made, drawn, p)[0] - in_reference(drawn, p)[0]).max() < 0.2


@dataclass(frozen=True)
class Silent(al.camera.Camera):
    """A camera that does not tell the width of its pixels."""

    name: ClassVar[str] = "silent"
    wgsl: ClassVar[str] = "camera/perspective.wgsl"
    eye: al.Vec3f = al.param((0.0, -4.0, 0.0))
    target: al.Vec3f = al.param((0.0, 0.0, 0.0))
    up: al.Vec3f = al.param((0.0, 0.0, 1.0))


def test_what_is_refused(renderer, rng):
    volume = sheared(rng.uniform(0, 100, (9, 12, 14)))
    for gradient in ("precomputed", al.gradient.Precomputed("analytic")):
        with pytest.raises(al.StageError, match="no levels: use central or analytic"):
            renderer.render(scene_of(volume, "levels", gradient), (8, 8))
    for name, slots in {
        "quantised": {"lighting": "quantised"},
        "ambient_occlusion": {"visibility": "ambient_occlusion"},
    }.items():
        look = al.Look(field="levels", **slots)
        with pytest.raises(al.StageError, match=f"{name}.*no levels: use the field linear"):
            renderer.render(al.Scene(volume, look=look), (8, 8))
    holed = volume.array.copy()
    holed[2, 2, 2] = np.nan
    with pytest.raises(al.StageError, match=r"empty samples.*use linear"):
        renderer.render(scene_of(al.Volume(holed), "levels", "zero"), (8, 8))
    with pytest.raises(al.StageError, match="pixel_width"):
        Silent().pixel_width((8, 8))
    with pytest.raises(al.ValueRangeError, match=r"\[-4, 8\]"):
        al.field.Levels(bias=9)


def test_statistics_tell_of_memory_and_rounding(renderer, rng):
    volume = al.Volume(rng.uniform(0, 255, (16, 16, 16)).astype(np.uint8))
    texture = renderer.render(scene_of(volume, "levels", "zero"), (8, 8)).stats["layers"][0]["textures"][0]
    assert texture["format"] == "r16float"
    assert texture["bytes"] == 2 * sum(8**n for n in range(5))
    assert 0 < texture["error"] < 0.1
