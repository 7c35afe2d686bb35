"""Scenes that 32-bit floats would spoil: far eyes, far origins, huge and tiny units, sharp functions, rays without an end."""

from __future__ import annotations

import gc
import threading
import time
import weakref
from dataclasses import replace

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, function, lights, scene

import airlight as al
from airlight import reference
from airlight.stage import STAGES

LEVEL = 1 / 255


@pytest.mark.parametrize("distance", [1e3, 1e6, 2e7])
def test_parallel_rays_from_far_away(renderer, distance):
    near = cameras(blobs())["orthographic"]
    _, _, forward = near.basis()
    far = replace(near, eye=tuple(np.asarray(near.target) - distance * forward))
    drawn = al.Scene(blobs(), transfer=function(), camera=far, lights=lights(), background=None)
    image, truth = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.abs(image.rgba - truth.rgba).max() <= LEVEL
    met = np.isfinite(truth.depth)
    assert np.abs(image.depth[met] / truth.depth[met] - 1).max() < (1e-3 if distance < 1e4 else 1e-6)


def test_a_perspective_eye_too_far_away_is_refused(renderer):
    far = al.Camera.perspective(eye=(0, -1e7, 0), target=(0, 0, 0), fov_deg=0.001)
    with pytest.raises(al.ValueRangeError, match=r"steps away from the volume, .*: use Camera.orthographic"):
        renderer.render(al.Scene(blobs(), transfer=function(), camera=far), SIZE)


@pytest.mark.parametrize("integrate", ["emission_absorption", "mip"])
def test_blocks_are_left_by_rays_from_far_away(renderer, integrate):
    """A thousandth of a voxel behind a face, 32 bits tell no place from the one before."""
    near = cameras(blobs())["orthographic"]
    _, _, forward = near.basis()
    eye = tuple(np.asarray(near.target) - 2e5 * forward)
    far = al.Camera.perspective(eye=eye, target=near.target, fov_deg=np.degrees(near.height / 2e5))
    drawn = replace(scene(integrate=integrate, shade="none"), camera=far)
    skipped, whole = (renderer.render(drawn, SIZE, skip=skip) for skip in ("auto", "none"))
    assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL
    assert skipped.stats["samples"] < whole.stats["samples"]


def test_a_world_far_from_its_origin(renderer):
    """A survey in metres: everything is moved together, lights too."""
    shift = np.array([5e5, 6e6, -2e5])
    matrix = blobs().world_from_index.copy()
    matrix[:3, 3] += shift
    for kind in ("perspective", "orthographic", "inside"):
        camera = cameras(blobs())[kind]
        moved = replace(camera, eye=tuple(camera.eye + shift), target=tuple(camera.target + shift))
        there = [replace(s, vector=tuple(s.vector + shift)) if s.kind == "point" else s for s in lights()]
        look = al.Look(gradient="precomputed")
        one = al.Scene(blobs(), transfer=function(), camera=camera, lights=lights(), look=look, background=None)
        far = al.Volume(blobs().array, world_from_index=matrix)
        two = al.Scene(far, transfer=function(), camera=moved, lights=there, look=look, background=None)
        assert np.abs(renderer.render(one, SIZE).rgba - renderer.render(two, SIZE).rgba).max() <= LEVEL


@pytest.mark.parametrize("unit", [1e-9, 1e13])
def test_any_unit_of_length(renderer, unit):
    matrix = np.diag([unit, unit, unit, 1]) @ blobs().world_from_index
    camera = cameras(blobs())["perspective"]
    scaled = replace(camera, eye=tuple(unit * np.asarray(camera.eye)), target=tuple(unit * np.asarray(camera.target)))
    tf = al.TransferFunction([(v, c, e / unit) for v, c, e in function().points])
    drawn = al.Scene(al.Volume(blobs().array, world_from_index=matrix), transfer=tf, camera=scaled, background=None)
    plain = al.Scene(blobs(), transfer=function(), camera=camera, background=None)
    assert np.abs(renderer.render(drawn, SIZE).rgba - renderer.render(plain, SIZE).rgba).max() <= LEVEL


@pytest.mark.parametrize("unit", [1e-25, 1e20])
def test_any_unit_of_value(renderer, unit):
    data = (blobs().array.astype(np.float64) * unit).astype(np.float32)
    tf = al.TransferFunction([(v * unit, c, e) for v, c, e in function().points])
    drawn = al.Scene(
        al.Volume(data, world_from_index=blobs().world_from_index),
        transfer=tf,
        camera=cameras(blobs())["perspective"],
        lights=lights(),
        background=None,
    )
    assert np.abs(renderer.render(drawn, SIZE).rgba - renderer.render(scene(), SIZE).rgba).max() <= LEVEL


SHARP = {
    "step": [(60.03, (1, 0.5, 0), 0), (60.03, (1, 0.5, 0), 1), (110, (1, 1, 1), 1)],
    "peak": [(40, (1, 1, 1), 0), (60.03, (1, 1, 1), 0), (60.5, (1, 0.2, 0), 2), (61, (1, 1, 1), 0), (110, (1, 1, 1), 0)],
}


@pytest.mark.parametrize("points", SHARP.values(), ids=SHARP.keys())
@pytest.mark.parametrize("transfer", ["preintegrated", "postclassified"])
@pytest.mark.parametrize("shade", ["none", "blinn_phong"])
def test_skipping_never_changes_the_image(renderer, points, transfer, shade):
    base = scene(transfer=transfer, shade=shade)
    drawn = al.Scene(
        blobs(), transfer=al.TransferFunction(points), camera=base.camera, look=base.layers[0].look, background=None
    )
    images = [renderer.render(drawn, SIZE, skip=skip).rgba for skip in ("auto", "none")]
    assert np.abs(images[0] - images[1]).max() <= 1e-5


def test_a_single_step_on_small_values(renderer):
    tf = al.TransferFunction([(5e-5, (1, 0, 0), 0), (5e-5, (1, 0, 0), 2)])
    data = (blobs().array / 120 * 1e-4).astype(np.float32)
    volume = al.Volume(data, world_from_index=blobs().world_from_index)
    drawn = al.Scene(volume, transfer=tf, camera=cameras(blobs())["perspective"], look=al.Look(shade="none"), background=None)
    assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() < 0.02


def test_rays_that_a_driver_cuts_short_are_an_error(renderer):
    """Software Vulkan ends loops after 65,536 turns; half a picture is not drawn silently."""
    volume = al.Volume(np.full((2, 101, 2), 1.0, dtype=np.float32))
    camera = al.Camera.orthographic(eye=(0.5, -10, 0.5), target=(0.5, 0, 0.5), height=0.5)
    tf = al.TransferFunction([(0, (1, 1, 1), 0.01), (2, (1, 1, 1), 0.01)])
    drawn = al.Scene(volume, transfer=tf, camera=camera, look=al.Look(shade="none"))
    if renderer.render(drawn, (1, 1)).stats["adapter"]["kind"] != "software":
        pytest.skip("a GPU does not bound its loops")
    with pytest.raises(al.LimitError, match="bounds loops: draw with a larger step"):
        renderer.render(drawn, (2, 2), step=0.001, skip="none")


def test_very_tall_images(renderer):
    image = renderer.render(scene(tone="reinhard"), (1, 65536))
    assert image.rgba.shape == (65536, 1, 4)


def test_no_visible_layer_is_an_empty_picture(renderer):
    hidden = al.Scene(layers=[al.Layer(blobs(), function(), visible=False)])
    image = renderer.render(hidden, SIZE)
    assert not image.rgba.any()
    assert image.stats["reason"] == "no visible layer"


def test_nothing_is_hit_where_there_is_no_density(renderer):
    layer = al.Layer(blobs(), function(), look=al.Look(integrate="first_hit"), density=0.0)
    assert not renderer.render(al.Scene(layers=[layer]), SIZE).rgba.any()


def test_named_views_frame_the_fields_own_box(renderer):
    drawn = al.Scene(blobs(), transfer=function(), camera="front", look=al.Look(field="nearest", shade="none"))
    error = np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max(axis=-1)
    assert np.quantile(error, 0.99) <= LEVEL


@pytest.mark.parametrize("matrix", ["mirrored", "sheared"])
def test_mirrored_and_sheared_grids(renderer, matrix):
    change = np.diag([-1.0, 1, 1, 1]) if matrix == "mirrored" else np.eye(4) + 0.4 * np.eye(4, k=1) * [[1], [1], [0], [0]]
    volume = al.Volume(blobs().array, world_from_index=blobs().world_from_index @ change)
    drawn = scene(volume)
    assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() <= LEVEL


def test_exact_paths_are_exact(renderer):
    """Without tables of slabs and without light there is nothing to be off by more than rounding."""
    for integrate in ("minip", "mean"):
        drawn = scene(field="linear_exact", integrate=integrate, transfer="postclassified")
        assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() < 5e-4


def first_of_refined(renderer, drawn):
    images = renderer.refine(drawn, (8, 8), tolerance=0.001)
    for _ in range(5):
        next(images)


def with_an_error(renderer, drawn):
    def progress(*_):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        renderer.render(drawn, (8, 8), progress=progress)


@pytest.mark.parametrize(
    "use",
    [
        lambda renderer, drawn: renderer.render(drawn, (8, 8)),
        lambda renderer, drawn: renderer.refine(drawn, (8, 8)) and None,
        first_of_refined,
        with_an_error,
    ],
    ids=["drawn", "refined, but not begun", "refined, but not to the end", "broken off"],
)
def test_volumes_are_let_go_at_once(renderer, use):
    """No ring of references waits for the garbage to be collected: volumes are large."""
    volume = al.Volume(np.linspace(0, 120, 9**3, dtype=np.float32).reshape(9, 9, 9) % 97)
    known = weakref.ref(volume)
    gc.collect()
    gc.disable()
    try:
        use(renderer, al.Scene(volume, camera="iso", transfer=function(), look=al.Look(shade="none")))
        del volume
        deadline = time.monotonic() + 5
        while known() is not None and time.monotonic() < deadline:
            time.sleep(0.01)
        assert known() is None
    finally:
        gc.enable()


def test_forgotten_renderers_end_their_threads():
    before = threading.active_count()
    for _ in range(3):
        al.Renderer().render(scene(), (4, 4))
    gc.collect()
    for _ in range(100):
        if threading.active_count() <= before:
            break
        threading.Event().wait(0.1)
    assert threading.active_count() <= before


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: al.tone.Linear(exposure=None), "tone.linear.exposure is None, must be a number"),
        (lambda: al.shade.BlinnPhong(ambient="red"), "ambient is 'red', must be a number"),
        (lambda: al.transfer.PreIntegrated(entries=100.5), "entries is 100.5, must be a whole number"),
        (lambda: STAGES["driver"]["march"](offsets="some"), "must be one of none, interleaved"),
    ],
)
def test_parameters_of_the_wrong_kind(make, message):
    with pytest.raises(al.ValueRangeError, match=message):
        make()
