"""Cameras, pixels, tone, and what is refused."""

import math

import numpy as np
import pytest
from reference_scenes import along_z, blob, constant, ramp_z, scene

from airlight import reference
from airlight.errors import DataError, StageError
from airlight.reference.camera import CAMERAS
from airlight.reference.tone import TONES
from airlight.scene import Camera, Layer, Look, Scene, fit_camera
from airlight.stages.integrate import FirstHit
from airlight.stages.tone import Linear, Reinhard
from airlight.transfer import TransferFunction
from airlight.volume import Volume

TF = TransferFunction([(0.1, (0.1, 0.2, 0.9), 0), (0.9, (1, 0.6, 0.2), 3)])


def test_perspective_rays():
    camera = Camera.perspective(eye=(1, 2, 3), target=(1, 5, 3), up=(0, 0, 1), fov_deg=90)
    origin, direction = CAMERAS["perspective"](camera, (4, 2), np.array([0, 3]), np.array([0, 1]))
    # Centres of the outer pixels: ndc x = -+3/4 of half a width of 2, y = +-1/2.
    expected = np.array([[-1.5, 1, 0.5], [1.5, 1, -0.5]])
    assert direction == pytest.approx(expected / np.linalg.norm(expected, axis=1, keepdims=True))
    assert (origin == (1, 2, 3)).all()


def test_orthographic_rays():
    camera = Camera.orthographic(eye=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), height=4)
    origin, direction = CAMERAS["orthographic"](camera, (4, 2), np.array([0, 3]), np.array([0, 1]))
    assert origin == pytest.approx(np.array([[-3, 1, 9], [3, -1, 9]]))
    assert direction == pytest.approx(np.array([[0, 0, -1], [0, 0, -1]]))


def test_the_first_row_is_on_top():
    array = np.zeros((4, 4, 4))
    array[3, :, 0] = 1  # greatest z, least x: from the front top left
    image = reference.render(scene(Volume(array), TF, "front", integrate="mip"), (4, 4))
    assert np.unravel_index(image.rgba[..., 0].argmax(), (4, 4)) == (0, 0)


def test_views_fit():
    for field in ("nearest", "linear"):
        look = scene(blob(), constant(100.0), "iso", field=field)
        corners = look.layers[0].volume.corners_world(field == "nearest")
        image = reference.render(look, (30, 20))
        camera = fit_camera("iso", corners, aspect=1.5)
        again = reference.render(scene(blob(), constant(100.0), camera, field=field), (30, 20))
        assert (image.rgba == again.rgba).all()
        assert image.rgba[:, 0, 3].max() == image.rgba[0, :, 3].max() == 0
        assert image.rgba[10, 15, 3] > 0.99


def test_chosen_pixels_are_the_images():
    look = scene(blob(), TF, "iso", shade="blinn_phong")
    whole = reference.render(look, (8, 6))
    pixels = np.array([[3, 2], [7, 5], [0, 0], [4, 3]])
    some = reference.render(look, (8, 6), pixels=pixels)
    assert some.rgba.shape == (4, 4)
    assert (some.rgba == whole.rgba[pixels[:, 1], pixels[:, 0]]).all()
    assert (some.depth == whole.depth[pixels[:, 1], pixels[:, 0]]).all()
    finest = reference.converged(look, (8, 6), pixels=pixels[:1])
    assert finest.rgba == pytest.approx(some.rgba[:1], abs=0.05)


def test_chunks_substeps_and_progress(monkeypatch):
    look = scene(blob(), TF, "iso")
    whole = reference.render(look, (8, 6), step=0.5)
    monkeypatch.setattr(reference, "RAYS_AT_ONCE", 7)
    seen = []
    parts = reference.render(look, (8, 6), step=2, substeps=4, progress=seen.append)
    assert (parts.rgba == whole.rgba).all()
    assert len(seen) == 7
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_samples_lie_on_the_lattice_from_the_eye():
    # MIP sees only samples: of a spike at z = 2 with neighbours 0, the greatest at distances k h.
    values = np.array([0, 0, 1.0, 0, 0])
    volume = Volume(np.broadcast_to(values[:, None, None], (5, 3, 3)))
    tf = TransferFunction([(0, (0, 0, 0), 0), (1, (1, 1, 1), 1)])
    image = reference.render(scene(volume, tf, along_z(1, 1, -10.25), integrate="mip"), (1, 1))
    assert image.rgba[0, 0, 0] == pytest.approx(0.75)
    assert image.depth[0, 0] == pytest.approx(12)


# -- tone


def test_linear_tone():
    rgba = np.array([[[0.1, 0.2, 0.3, 0.5]]])
    assert TONES["linear"](Linear(exposure=2), rgba)[0, 0] == pytest.approx([0.4, 0.8, 1.2, 0.5])
    assert (TONES["linear"](Linear(), rgba) == rgba).all()


def test_reinhard_by_hand():
    # Two pixels, grey: one covered with radiance 4, one half covered with radiance 1, and one that misses.
    rgba = np.array([[[4, 4, 4, 1], [0.5, 0.5, 0.5, 0.5], [0, 0, 0, 0]]], dtype=float)
    found = TONES["reinhard"](Reinhard(exposure=1, key=0.2, white=3), rgba)
    average = math.exp((math.log(4 + 1e-6) + 0.5 * math.log(1 + 1e-6)) / 1.5)
    # The average is that of what covers; the operator maps the radiance that reaches the pixel.
    for pixel, luminance, alpha in ((0, 4.0, 1.0), (1, 0.5, 0.5)):
        scaled = 2 * 0.2 / average * luminance
        shown = scaled * (1 + scaled / 9) / (1 + scaled)
        assert found[0, pixel] == pytest.approx([shown] * 3 + [alpha])
    assert (found[0, 2] == 0).all()


def test_reinhard_shows_its_white_as_one():
    rgba = np.array([[[0.3, 0.3, 0.3, 1.0], [3.0, 3.0, 3.0, 1.0]]])
    average = math.sqrt((0.3 + 1e-6) * (3 + 1e-6))
    found = TONES["reinhard"](Reinhard(key=0.5, white=0.5 / average * 3), rgba)
    assert found[0, 1, :3] == pytest.approx([1, 1, 1])


def test_reinhard_of_nothing():
    assert (TONES["reinhard"](Reinhard(), np.zeros((2, 2, 4))) == 0).all()
    look = scene(blob(), constant(0.0), "iso", tone="reinhard")
    assert (reference.render(look, (3, 3)).rgba == 0).all()


def test_images_are_toned():
    plain = reference.render(scene(blob(), TF, "iso"), (6, 6))
    toned = reference.render(scene(blob(), TF, "iso", tone=Reinhard(key=0.3)), (6, 6))
    assert toned.rgba == pytest.approx(TONES["reinhard"](Reinhard(key=0.3), plain.rgba))
    assert (toned.depth == plain.depth).all()


# -- what is refused


def test_refusals():
    with pytest.raises(DataError, match="tone reinhard needs the whole image"):
        reference.render(scene(blob(), TF, "iso", tone="reinhard"), (4, 4), pixels=[(0, 0)])
    with pytest.raises(DataError, match="pass a TransferFunction"):
        reference.render(Scene(blob()), (4, 4))
    with pytest.raises(DataError, match="no visible layer"):
        reference.render(Scene(layers=[Layer(blob(), TF, visible=False)]), (4, 4))
    with pytest.raises(DataError, match="2 visible layers, and one is asked for"):
        reference.prepare(Scene(layers=[Layer(blob(), TF), Layer(blob(), TF)]))
    with pytest.raises(StageError, match="no slot"):
        reference.register("gradients", "x", None)


def test_hidden_layers_are_left_out():
    layers = [Layer(blob(), TF, visible=False), Layer(blob(), TF, Look(shade="none"))]
    assert reference.render(Scene(layers=layers, camera="iso"), (3, 3)).rgba[1, 1, 3] > 0


def test_channels_and_times():
    array = np.zeros((2, 3, 4, 3, 3))
    array[1, 2] = 1
    volume = Volume(array, channel_names=("a", "b", "c"))
    tf = TransferFunction([(0, (0, 0, 0), 0), (1, (1, 1, 1), 1)])
    for channel, time, value in (("c", 1, 1), ("b", 1, 0), (2, 0, 0)):
        look = Scene(volume, transfer=tf, look=Look(integrate="mip"), channel=channel, time=time, camera="front")
        assert reference.render(look, (1, 1)).rgba[0, 0, 0] == value


def test_a_stage_from_outside(monkeypatch):
    class Doubled(reference.INTEGRATES["mip"]):
        def finish(self, acc):
            acc.value = acc.value * 2
            return super().finish(acc)

    monkeypatch.setitem(reference.TABLES["integrate"], "mip", Doubled)
    tf = TransferFunction([(0, (0, 0, 0), 0), (1, (1, 1, 1), 1)])
    look = scene(ramp_z(5, 0, 0.4), tf, integrate="mip")
    assert reference.render(look, (1, 1)).rgba[0, 0, 0] == pytest.approx(0.8)


def test_every_stage_has_its_function():
    from airlight.stage import STAGES

    ours = {s: {n for n, c in names.items() if c.__module__.startswith("airlight.")} for s, names in STAGES.items()}
    for slot in reference.TABLES:
        assert ours[slot] <= set(reference.TABLES[slot]), slot


def test_first_hit_takes_the_surface_only():
    image = reference.render(scene(blob(), TF, "iso", integrate=FirstHit(iso=0.5)), (8, 8))
    hit = np.isfinite(image.depth)
    assert (image.rgba[hit, 3] == 1).all()
    assert (image.rgba[~hit] == 0).all()
    assert 0 < hit.sum() < 64
