"""Light of environments and environments as background: parity, the furnace, laws, scene files, the command line."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, cameras, function, rotation, scene

import airlight as al
from airlight import reference
from airlight.app import cli
from airlight.environment.maps import light_maps
from airlight.scene_file import load_scene, save_scene

LEVEL = 1 / 255
SMOOTH = al.Environment.from_picture(
    np.stack(
        np.broadcast_arrays(*(np.linspace(a, b, 32)[:, None] * np.ones(64) for a, b in ((2, 0.2), (1, 0.6), (0.3, 1.2)))), -1
    )
    * (1 + 0.5 * np.sin(np.linspace(0, 2 * np.pi, 64, endpoint=False)))[None, :, None]
)
STAGES = [
    al.shade.Environment(al.Environment.sky()),
    al.shade.Environment(roughness=0.0, reflectance=0.3),
    al.shade.Environment(metallic=0.7, reflectance=0.3, roughness=0.5, intensity=2.0, diffuse=0.5),
    al.shade.Environment(al.Environment.sky().turned(1, (1, 2, 3)), two_sided=False, roughness=0.6),
    al.shade.Environment(gradient_threshold=30.0),
]


@pytest.mark.parametrize("stage", STAGES, ids=["sky", "mirror", "metal", "turned", "faded"])
def test_parity(renderer, stage):
    drawn = scene(shade=stage)
    assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() <= 1.5 * LEVEL


def test_parity_on_a_core_device(core_renderer):
    drawn = scene(shade=STAGES[2])
    assert np.abs(core_renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() <= LEVEL


def test_surfaces_are_lit(renderer):
    drawn = scene(shade=STAGES[2], integrate=al.integrate.FirstHit(iso=70.0))
    error = np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba)[..., :3]
    assert np.quantile(error, 0.99) <= LEVEL  # at silhouettes the normal is that of either side
    shown = al.TransferFunction.from_surfaces([al.Surface(60, "gold", 0.5), al.Surface(90, "white", 1.0)])
    drawn = al.Scene(blobs(), transfer=shown, camera=drawn.camera, look=al.Look(shade=STAGES[2]), background=None)
    error = np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba)[..., :3]
    assert np.quantile(error, 0.99) <= LEVEL


# -- energy


def furnace(rgb, **parameters) -> al.Scene:
    """Opaque blobs of one colour in white light from everywhere."""
    opaque = al.TransferFunction([(60, rgb, 0), (60, rgb, 200), (200, rgb, 200)])
    stage = al.shade.Environment(al.Environment.white(), **parameters)
    camera = cameras(blobs())["perspective"]
    return al.Scene(blobs(), transfer=opaque, camera=camera, look=al.Look(shade=stage), background=None)


@pytest.mark.parametrize("roughness", [0.0, 0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
def test_a_white_environment_gives_back_the_albedo(either_renderer, roughness, metallic):
    albedo = np.array([0.9, 0.5, 0.2])
    rgba = either_renderer.render(furnace(tuple(albedo), roughness=roughness, metallic=metallic, reflectance=0.0), SIZE).rgba
    covered = rgba[..., 3] > 0.9
    assert covered.sum() > 50
    assert np.abs(rgba[covered, :3] / rgba[covered, 3:] - albedo).max() < 1e-3


@pytest.mark.parametrize("roughness", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("reflectance", [0.04, 0.5, 1.0])
def test_white_in_a_white_environment_is_white_under_any_coat(either_renderer, roughness, reflectance):
    rgba = either_renderer.render(furnace((1, 1, 1), roughness=roughness, reflectance=reflectance), SIZE).rgba
    assert np.abs(rgba[..., :3] - rgba[..., 3:]).max() < 1e-3


def test_a_coat_adds_what_it_reflects_and_never_more_than_there_is(renderer):
    bare, coated = (renderer.render(furnace((0.9, 0.5, 0.2), reflectance=f), SIZE).rgba[..., :3] for f in (0.0, 0.5))
    alpha = renderer.render(furnace((0.9, 0.5, 0.2)), SIZE).rgba[..., 3:]
    assert (coated >= bare - 1e-5).all()
    assert (coated <= alpha + 1e-5).all()
    assert coated.mean() > 1.2 * bare.mean()


def test_weak_gradients_get_the_mean_light(renderer):
    """Where no gradient means a surface the medium has its colour times the mean of the environment."""
    stage = al.shade.Environment(SMOOTH, gradient_threshold=1e6, diffuse=0.8, intensity=1.5)
    lit, plain = (renderer.render(scene(shade=s), SIZE).rgba for s in (stage, "none"))
    mean = reference.environment.mean(SMOOTH)
    assert np.abs(lit[..., :3] - 0.8 * 1.5 * mean * plain[..., :3]).max() < 1e-5


def test_occlusion_dims_all_of_it(renderer):
    light, dark = (scene(shade="environment", visibility=v) for v in ("none", "ambient_occlusion"))
    one, two = (renderer.render(drawn, SIZE).rgba for drawn in (light, dark))
    assert (two[..., :3] <= one[..., :3] + 1e-6).all()
    assert two[..., :3].sum() < 0.95 * one[..., :3].sum()


# -- laws


@settings(max_examples=6)
@given(factor=st.floats(0.01, 50))
def test_light_is_linear_in_intensity_and_radiance(renderer, factor):
    once = renderer.render(scene(shade=al.shade.Environment(SMOOTH)), SIZE).rgba[..., :3]
    brighter = renderer.render(scene(shade=al.shade.Environment(SMOOTH, intensity=factor)), SIZE).rgba[..., :3]
    assert np.allclose(brighter, factor * once, rtol=1e-4, atol=1e-6 * factor)
    scaled = al.Environment.from_picture(2 * SMOOTH.source.pixels)
    assert np.allclose(renderer.render(scene(shade=al.shade.Environment(scaled)), SIZE).rgba[..., :3], 2 * once, atol=1e-5)


@settings(max_examples=6)
@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle_rad=st.floats(0, 6.28),
    kind=st.sampled_from(["perspective", "orthographic"]),
    behind=st.booleans(),
)
def test_turning_all_together_changes_nothing(renderer, axis, angle_rad, kind, behind):
    volume, camera = blobs(), cameras(blobs())[kind]
    turn = rotation(axis, angle_rad)
    move = np.eye(4)
    move[:3, :3] = turn
    moved = al.Volume(volume.array, world_from_index=move @ volume.world_from_index)
    parts = {name: tuple(turn @ getattr(camera, name)) for name in ("eye", "target", "up")}
    images = []
    for shown, seen, environment in (
        (volume, camera, SMOOTH),
        (moved, dataclasses.replace(camera, **parts), SMOOTH.turned(angle_rad, axis)),
    ):
        look = al.Look(shade=al.shade.Environment(environment))
        background = environment if behind else None
        made = al.Scene(shown, transfer=function(), camera=seen, look=look, background=background)
        images.append(renderer.render(made, SIZE).rgba)
    assert np.abs(images[0] - images[1]).max() <= LEVEL


def test_a_turn_makes_no_maps_and_links_no_program(renderer):
    one = scene(shade=al.shade.Environment(SMOOTH))
    two = scene(shade=al.shade.Environment(SMOOTH.turned(1.0)))
    assert renderer.explain(one, SIZE) is renderer.explain(two, SIZE)
    maps = [light_maps(drawn.layers[0].look.shade.environment.source) for drawn in (one, two)]
    assert maps[0] is maps[1]
    assert not np.allclose(renderer.render(one, SIZE).rgba, renderer.render(two, SIZE).rgba, atol=LEVEL)


# -- background


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside"])
@pytest.mark.parametrize("tone", ["linear", "reinhard"])
def test_background_parity(either_renderer, camera, tone):
    made = al.Scene(
        blobs(),
        transfer=function(),
        camera=cameras(blobs())[camera],
        look=al.Look(shade="none", tone=tone),
        background=SMOOTH.turned(0.7, (1, 1, 0)),
    )
    image, truth = either_renderer.render(made, SIZE), reference.render(made, SIZE)
    assert np.abs(image.rgba - truth.rgba).max() <= LEVEL
    assert (image.rgba[..., 3] == 1).all()
    assert np.isinf(image.depth).any() == np.isinf(truth.depth).any()
    assert image.picture().shape == (*SIZE[::-1], 3)


def test_a_background_is_what_is_left_of_transparent_pixels(renderer):
    """Before tone: the scene over the environment, exactly."""
    base = scene(shade="none", tone=al.tone.Linear(exposure=1.0))
    behind = al.Environment.white((0.3, 0.2, 0.1))
    over = renderer.render(dataclasses.replace(base, background=behind), SIZE).rgba
    alone = renderer.render(base, SIZE).rgba
    assert np.allclose(over[..., :3], alone[..., :3] + (1 - alone[..., 3:]) * 2 * np.array([0.3, 0.2, 0.1]), atol=1e-5)


def test_columns_go_round(renderer):
    """No seam at -y, where the picture begins and ends."""
    behind = al.Environment.from_picture(
        1 + np.cos(np.linspace(0, 2 * np.pi, 64, endpoint=False))[None, :, None] * np.ones((32, 1, 3))
    )
    camera = al.Camera.perspective(eye=(0, 0, 0), target=(0, -1, 0), fov_deg=40)
    hidden = al.Layer(blobs(), function(), visible=False)
    row = renderer.render(al.Scene(layers=[hidden], camera=camera, background=behind), (61, 41)).rgba[20, :, 0]
    assert np.abs(np.diff(row, 2)).max() < 0.01
    assert row.max() - row.min() > 0.03


def test_without_a_visible_layer_the_environment_is_seen(renderer):
    hidden = al.Layer(blobs(), function(), visible=False)
    image = renderer.render(al.Scene(layers=[hidden], background=al.Environment.white((0.25, 0.5, 1))), (8, 6))
    assert np.allclose(image.rgba, (0.25, 0.5, 1, 1), atol=1e-6)
    assert np.isinf(image.depth).all()


def test_parallel_rays_see_one_direction(renderer):
    camera = al.Camera.orthographic(eye=(0, -500, 0), target=(0, 0, 0), height=1e4)
    made = al.Scene(blobs(), transfer=function(), camera=camera, background=al.Environment.sky(to_sun=(0, 1, 0.5)))
    rgba = renderer.render(made, (24, 16)).rgba
    assert np.allclose(rgba[0], rgba[0, 0], atol=1e-5)


# -- scene files and the command line


@pytest.fixture
def head(tmp_path):
    al.save(blobs(), tmp_path / "blobs.nrrd")
    return al.open(tmp_path / "blobs.nrrd")


def test_a_scene_file_loads_back_equal(tmp_path, head):
    (tmp_path / "light").mkdir()
    np.save(tmp_path / "light" / "probe.npy", SMOOTH.source.pixels)
    picture = al.Environment.open(tmp_path / "light" / "probe.npy").turned(0.5, (1, 2, 3))
    look = al.Look(shade=al.shade.Environment(picture, roughness=0.2))
    made = al.Scene(head, transfer=function(), look=look, background=al.Environment.sky(turbidity=5))
    save_scene(made, tmp_path / "a.toml")
    text = (tmp_path / "a.toml").read_text()
    assert 'file = "light/probe.npy"' in text
    assert str(tmp_path) not in text
    again, _ = load_scene(tmp_path / "a.toml")
    assert again.background == made.background
    assert again.layers[0].look == look


def test_a_scene_file_may_name_one_by_a_word_or_a_picture(tmp_path, head):
    np.save(tmp_path / "probe.npy", SMOOTH.source.pixels)
    for word, meant in (("sky", al.Environment.sky()), ("probe.npy", SMOOTH)):
        text = f'[[layers]]\nvolume = "blobs.nrrd"\nlook.shade = {{ name = "environment", environment = "{word}" }}\n'
        (tmp_path / "a.toml").write_text(text)
        assert load_scene(tmp_path / "a.toml")[0].layers[0].look.shade.environment == meant


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('background = { kind = "moon" }', "must be one of white, sky, studio, picture"),
        ('background = { kind = "sky", turbidity = 99 }', "must lie in"),
        ('background = { kind = "sky", turbid = 3 }', "no parameter of sky"),
        ('background = { file = "missing.hdr" }', "cannot be read"),
    ],
)
def test_scene_files_say_what_is_wrong(tmp_path, head, line, words):
    (tmp_path / "a.toml").write_text(f'{line}\n[[layers]]\nvolume = "blobs.nrrd"\n')
    with pytest.raises(al.AirlightError, match=words) as error:
        load_scene(tmp_path / "a.toml")
    assert "a.toml:1" in str(error.value)


def test_a_picture_without_a_file_is_not_saved(tmp_path, head):
    made = al.Scene(head, transfer=function(), background=SMOOTH)
    with pytest.raises(al.DataError, match="came from no file"):
        save_scene(made, tmp_path / "a.toml")


def job(monkeypatch, *words):
    """Scene that a command would draw."""
    from airlight.app import build

    made = []
    monkeypatch.setattr(
        build, "Job", lambda scene, size, arguments: made.append(scene) or (_ for _ in ()).throw(al.DataError("a", "b"))
    )
    cli.main(["render", *words, "-o", "-"])
    return made[0] if made else None


def test_command_line(tmp_path, head, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lit = job(monkeypatch, "blobs.nrrd", "--environment", "sky:turbidity=5,to_sun=[0,1,1]", "--environment-turn", "90")
    assert lit.layers[0].look.shade.environment == al.Environment.sky(turbidity=5, to_sun=(0, 1, 1)).turned(np.pi / 2)
    both = job(
        monkeypatch, "blobs.nrrd", "--shade", "environment:roughness=0.2", "--environment", "sky", "--background", "environment"
    )
    assert both.layers[0].look.shade == al.shade.Environment(al.Environment.sky(), roughness=0.2)
    assert both.background == al.Environment.sky()
    behind = job(monkeypatch, "blobs.nrrd", "--shade", "blinn_phong", "--environment", "studio", "--background", "environment")
    assert behind.layers[0].look.shade.name == "blinn_phong"
    capsys.readouterr()
    for words, message in (
        (["--environment", "moon"], "is no picture of an environment"),
        (["--environment", "sky:turbidity=99"], "--environment"),
        (["--environment", "sky:to_sun=[a,b,c]"], "--environment"),
        (["--environment", "sky:turn=3"], "axis times radians"),
        (["--environment-turn", "90"], "--environment-turn turns no environment"),
        (["--background", "environment"], "add --environment studio"),
        (["--environment", "sky:foo=1"], "--environment.foo is no parameter of sky"),
        (["--shade", "none", "--environment", "sky"], "lights nothing, --shade is none"),
        (["--integrate", "mip", "--environment", "studio"], "lights nothing, --integrate mip is not lit"),
    ):
        assert job(monkeypatch, "blobs.nrrd", *words) is None
        assert message in capsys.readouterr().err
