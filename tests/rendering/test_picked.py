"""What pixels show and what rays meet, against the reference and closed forms."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, function, scene

import airlight as al
from airlight import reference
from airlight.reference.gradient import field_gradient

CAMERAS = cameras(blobs()) | {
    "stereo": al.Camera.stereo(eye=(60, -80, 40), target=(18, 16, 18), fov_deg=35),
    "panorama": al.Camera.panorama(eye=(9, -2, 4), target=(20, 13, 12)),
    "dome": al.Camera.dome(eye=(9, -2, 4), target=(20, 13, 12), angle_deg=300),
}


def seen(camera: str, **look) -> al.Scene:
    return dataclasses.replace(scene(**look), camera=CAMERAS[camera])


@pytest.mark.parametrize("camera", CAMERAS)
def test_values_and_gradients_are_the_fields(renderer, camera):
    drawn = seen(camera, integrate=al.integrate.FirstHit(iso=70.0))
    image = renderer.render(drawn, SIZE, step=0.5)
    setup = reference.prepare(drawn)
    pixels = [(int(x), int(y)) for y, x in np.argwhere(np.isfinite(image.depth))[::9]]
    assert len(pixels) >= 3
    for pixel in pixels:
        found = image.pick(*pixel)
        p_index = setup.index_of(np.array([found.p_world]))
        assert found.p_world == pytest.approx(al.pick(image, drawn, pixel))
        assert found.p_index == pytest.approx(tuple(p_index[0]))
        assert found.value == pytest.approx(reference.field.field_value(setup, p_index)[0][0], abs=1e-9)
        assert found.gradient == pytest.approx(tuple(field_gradient(setup, p_index)[0]), abs=1e-9)
        assert np.linalg.norm(found.normal) == pytest.approx(1)
        assert found.t_world == image.depth[pixel[1], pixel[0]]
    empty = np.argwhere(~np.isfinite(image.depth))
    for y, x in empty[:1]:
        assert image.pick(int(x), int(y)) is None


def test_an_unlit_look_has_gradients_too(renderer):
    image = renderer.render(seen("inside", shade="none"), SIZE)
    assert np.linalg.norm(image.pick(24, 20).gradient) > 0.1


def test_labels_have_numbers_and_names(renderer):
    regions = np.zeros(blobs().array.shape, dtype=np.uint16)
    regions[:, :, 16:] = 700
    labels = al.Labels(al.Volume(regions, world_from_index=blobs().world_from_index), names={700: "right half"})
    image = renderer.render(al.Scene(blobs(), transfer=function(), labels=labels, camera=CAMERAS["perspective"]), SIZE)
    names = set()
    for y, x in np.argwhere(np.isfinite(image.depth))[::13]:
        found = image.pick(int(x), int(y))
        assert found.label == (700 if found.p_index[0] >= 15.5 else 0)
        names.add(found.label_name)
    assert names == {"0", "right half"}


def test_each_channel_has_a_value(renderer):
    array = np.stack([blobs().array, 200 - blobs().array, np.full_like(blobs().array, 7)])
    volume = al.Volume(array, world_from_index=blobs().world_from_index)
    drawn = al.Scene(volume, transfer=[function(), function(), function()], camera=CAMERAS["perspective"])
    found = renderer.render(drawn, SIZE).pick(24, 20)
    one, other, third = found.values
    assert (other, third) == pytest.approx((200 - one, 7))


def test_only_the_voxels_near_the_point_are_read(renderer, monkeypatch):
    """A long volume: what is far away is never touched, and the result is that of the whole."""
    array = np.zeros((300, 20, 20), dtype=np.float32)
    array[150:] = 100
    volume = al.Volume(array)
    drawn = al.Scene(volume, transfer=al.TransferFunction([(40, "white", 0), (60, "white", 5)]), camera="bottom")
    image = renderer.render(drawn, SIZE)
    sizes = []
    whole = reference.setup.Setup.grid.func
    monkeypatch.setattr(
        reference.setup.Setup, "grid", property(lambda setup: sizes.append(setup.layer.volume.size) or whole(setup))
    )
    found = image.pick(24, 20)
    assert found.p_world[2] == pytest.approx(149.5, abs=1)
    assert max(size[2] for size in sizes) < 60


@pytest.mark.parametrize("field", ["linear", "nearest", "bspline", "levels", "preclassified"])
@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "panorama"])
def test_opacity_along_a_ray_is_that_of_the_picture(renderer, camera, field):
    drawn = seen(camera, field=field, shade="none", integrate=al.integrate.EmissionAbsorption(opaque_at=1.0))
    image = renderer.render(drawn, SIZE)
    truth = reference.converged(drawn, SIZE, pixels=[(24, 20), (20, 14)])
    for n, (x, y) in enumerate([(24, 20), (20, 14)]):
        ray = image.profile(x, y, step=0.25)
        assert len(ray.t_world) > 10
        assert ray.opacity[-1] == pytest.approx(truth.rgba[n, 3], abs=2e-3)
        assert (np.diff(ray.opacity) >= 0).all()
        if np.isfinite(truth.depth[n]):
            assert np.interp(0.5, ray.opacity, ray.t_world) == pytest.approx(truth.depth[n], abs=0.3)


def test_media_along_a_ray_are_those_of_the_function(renderer):
    ray = renderer.render(seen("perspective", shade="none"), SIZE).profile(24, 20)
    rgb, extinction = function()(ray.value)
    assert ray.extinction == pytest.approx(extinction, rel=1e-6, abs=1e-9)
    dense = extinction > 0
    assert dense.sum() > 20
    assert ray.rgb[dense] == pytest.approx(rgb[dense], rel=1e-5)
    assert ray.p_world - CAMERAS["perspective"].eye == pytest.approx(
        ray.t_world[:, None] * (ray.p_world[-1] - CAMERAS["perspective"].eye) / ray.t_world[-1]
    )


def test_glow_without_extinction_is_a_source():
    glow = al.TransferFunction([(0, (0.1, 0.2, 0), 0), (10, (0.1, 0.2, 0), 0)], associated=True)
    volume = al.Volume(np.full((8, 8, 8), 5.0, dtype=np.float32))
    camera = al.Camera.orthographic(eye=(3.5, -5, 3.5), target=(3.5, 3.5, 3.5), height=4)
    drawn = al.Scene(volume, transfer=glow, camera=camera, look=al.Look(shade="none"))
    ray = al.ray_profile(drawn, (8, 8), (4, 4), step=1)
    assert ray.t_world == pytest.approx([5, 6, 7, 8, 9, 10, 11, 12])
    assert ray.source == pytest.approx(np.broadcast_to((0.1, 0.2, 0), (8, 3)))
    assert not ray.extinction.any()
    assert not ray.opacity.any()


def test_a_homogeneous_block_has_beers_law():
    volume = al.Volume(np.full((9, 9, 9), 5.0, dtype=np.float32), spacing=(2, 2, 2))
    function = al.TransferFunction([(0, "red", 0.3), (10, "red", 0.3)])
    camera = al.Camera.orthographic(eye=(8, -3, 8), target=(8, 8, 8), height=4)
    ray = al.ray_profile(al.Scene(volume, transfer=function, camera=camera), (5, 5), (2.5, 2.5))
    assert ray.opacity == pytest.approx(1 - np.exp(-0.3 * (ray.t_world - 3)))
    assert (ray.value == 5).all()
    assert ray.label is None


@pytest.mark.parametrize("modulation", ["change", "gradient_magnitude"])
def test_modulation_thins_what_is_accumulated(renderer, modulation):
    thin = [al.Layer(blobs(), function(), al.Look(shade="none", modulation=m), density=0.1) for m in (modulation, "none")]
    drawn, other = (al.Scene(layers=[layer], camera=CAMERAS["perspective"]) for layer in thin)
    image = renderer.render(drawn, SIZE, step=0.5)
    ray, plain = image.profile(24, 20), al.ray_profile(other, SIZE, (24.5, 20.5))
    assert ray.extinction == pytest.approx(plain.extinction)
    assert ray.opacity[-1] == pytest.approx(image.rgba[20, 24, 3], abs=0.01)
    assert ray.opacity[-1] < plain.opacity[-1] - 0.05


@pytest.mark.parametrize("keep", ["inside", "outside"])
def test_what_clips_cut_away_is_not_met(renderer, keep):
    ball = al.Clip.sphere(center=(17, 20.6, 19), radius=9, keep=keep)
    whole = seen("perspective", shade="none")
    drawn = al.Scene(blobs(), transfer=function(), look=whole.layers[0].look, camera=whole.camera, clips=[ball])
    image = renderer.render(drawn, SIZE, step=0.5)
    for x, y in ((24, 20), (21, 22)):
        ray = image.profile(x, y)
        away = np.linalg.norm(ray.p_world - (17, 20.6, 19), axis=1)
        assert ((away < 8.9).any(), (away > 9.1).any()) == (True, True)
        gone = away > 9.1 if keep == "inside" else away < 8.9
        assert not ray.extinction[gone].any()
        assert np.isfinite(ray.value).all()
        assert ray.opacity[-1] == pytest.approx(image.rgba[y, x, 3], abs=0.005)


def test_empty_samples_are_gaps(renderer):
    holed = blobs().array.copy()
    holed[14:26] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    drawn = dataclasses.replace(
        seen("perspective", shade="none"), layers=(al.Layer(volume, function(), al.Look(shade="none")),)
    )
    ray = renderer.render(drawn, SIZE).profile(24, 20)
    gaps = np.isnan(ray.value)
    assert 5 < gaps.sum() < len(gaps)
    assert not ray.extinction[gaps].any()


def test_rays_that_miss_meet_nothing(renderer):
    image = renderer.render(seen("dome"), SIZE)
    ray = image.profile(0, 0)
    assert [len(part) for part in (ray.t_world, ray.value, ray.opacity, ray.rgb)] == [0, 0, 0, 0]


def test_a_cut_ray_is_the_whole_one(renderer):
    """Two ways through the same volume: in pieces, and with all voxels at once."""
    rng = np.random.default_rng(1)
    volume = al.Volume(rng.uniform(0, 100, (20, 150, 20)).astype(np.float32))
    camera = al.Camera.perspective(eye=(9, -40, 9), target=(9, 75, 11), fov_deg=10)
    drawn = al.Scene(volume, transfer=function(), camera=camera, look=al.Look(field="bspline", shade="none"))
    ray = al.ray_profile(drawn, SIZE, (24, 20))
    setup = reference.prepare(dataclasses.replace(drawn))
    value, _ = reference.field.field_value(setup, setup.index_of(ray.p_world))
    assert len(value) > 200
    assert ray.value == pytest.approx(value, abs=1e-8)


def test_what_is_refused(renderer):
    image = renderer.render(scene(), SIZE)
    with pytest.raises(al.ValueRangeError, match="layer is 1, and 1 layers are visible"):
        image.pick(24, 20, layer=1)
    with pytest.raises(al.ValueRangeError, match="must lie in the image of 48 x 40"):
        image.profile(48, 3)
    with pytest.raises(al.ValueRangeError, match=r"step is 0, must lie in \[0.001, 1000\] voxels"):
        image.profile(3, 3, step=0)
    with pytest.raises(al.ValueRangeError, match=r"p_px is \(1, 2, 3\), must be two numbers"):
        al.ray_profile(scene(), SIZE, (1, 2, 3))
    with pytest.raises(al.DataError, match="scene is a NoneType"):
        al.ray_profile(None, SIZE, (1, 1))
    with pytest.raises(al.DataError, match="image does not know its scene"):
        dataclasses.replace(image, scene=None).pick(24, 20)
    nothing = renderer.render(al.Scene(layers=[al.Layer(blobs(), function(), visible=False)]), SIZE)
    assert nothing.pick(3, 3) is None


def test_points_outside_of_the_volume_have_no_value(renderer):
    """Where something else than the volume is at the image's depth."""
    image = renderer.render(scene(), SIZE)
    far = dataclasses.replace(image, depth=np.full_like(image.depth, 1.0))
    found = far.pick(24, 20)
    assert np.isnan(found.value)
    assert found.gradient == found.normal == (0, 0, 0)
