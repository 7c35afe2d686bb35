"""Several layers in one march: parity with the reference, laws of mixtures, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import lights, rotation

import airlight as al
from airlight import reference
from airlight.app.cli import main
from airlight.rendering.layers import check_textures

SIZE = (40, 32)
LEVEL = 1 / 255
RED = al.TransferFunction([(300, (1, 0.2, 0.1), 0.0), (1000, (1, 0.2, 0.1), 0.4)])
BLUE = al.TransferFunction([(300, (0.1, 0.3, 1), 0.0), (1000, (0.1, 0.3, 1), 0.15)])
GREEN = al.TransferFunction([(300, (0.2, 1, 0.2), 0.0), (900, (0.2, 1, 0.2), 3.0)])
FIRST_HIT = al.Look(integrate=al.integrate.FirstHit(iso=500))
CAMERA = al.Camera.perspective(eye=(45, 40, 30), target=(11, 11, 11), up=(0, 0, 1), fov_deg=30)


@cache
def ball(size: tuple[int, int, int] = (24, 22, 20), radius: float = 8.0, skew: bool = False) -> al.Volume:
    """A ball that rises from 0 to 1000, in the world's axes, or on a finer grid, turned and sheared, inside of the other's."""
    x, y, z = (np.arange(n) - (n - 1) / 2 for n in size)
    distance = np.sqrt(z[:, None, None] ** 2 + y[:, None] ** 2 + x**2)
    field = np.clip((radius - distance) * 60 + 500, 0, 1000).astype(np.float32)
    matrix = np.eye(4)
    if skew:
        shear = np.array([[1, 0.2, 0], [0, 1, 0.3], [0, 0, 1]])
        matrix[:3, :3] = rotation((1, 2, 3), 0.7) @ shear * (0.6, 0.5, 0.7)
        matrix[:3, 3] = (17, 13, 12) - matrix[:3, :3] @ ((np.array(size) - 1) / 2)
    return al.Volume(field, world_from_index=matrix)


def large(**given) -> al.Layer:
    return al.Layer(ball(), **({"transfer": RED} | given))


def small(**given) -> al.Layer:
    return al.Layer(ball((18, 20, 22), 7.0, skew=True), **({"transfer": BLUE} | given))


def inside() -> al.Layer:
    """A dense layer with its own spacing, wholly inside of the large one's box."""
    matrix = np.diag([0.7, 0.9, 0.8, 1.0])
    matrix[:3, 3] = (9, 8, 7)
    volume = al.Volume(ball((12, 12, 12), 5.0).array, world_from_index=matrix)
    return al.Layer(volume, GREEN, al.Look(lighting="interpolated"))


def holed() -> al.Layer:
    """A ball with a gap through its middle."""
    array = ball().array.copy()
    array[9:12] = np.nan
    array[:, 5:7, 11] = np.nan
    return al.Layer(al.Volume(array), RED)


def scene(*layers: al.Layer, **given) -> al.Scene:
    return al.Scene(layers=layers, **({"camera": CAMERA, "lights": lights(), "background": None} | given))


def compare(renderer: al.Renderer, drawn: al.Scene, step: float = 1.0, most: float = LEVEL) -> al.Image:
    image, truth = renderer.render(drawn, SIZE, step=step), reference.render(drawn, SIZE, step=step)
    assert truth.rgba[..., 3].max() > 0.2
    assert np.abs(image.rgba - truth.rgba).max() <= most
    seen = np.isfinite(truth.depth) & np.isfinite(image.depth)
    assert (np.isfinite(image.depth) == np.isfinite(truth.depth)).mean() > 0.99
    assert np.abs(image.depth[seen] - truth.depth[seen]).max(initial=0.0) < 0.01
    return image


@pytest.mark.parametrize("step", [0.8, 2.5])
def test_parity_of_layers_with_affines_and_spacings_of_their_own(any_renderer, step):
    image = compare(any_renderer, scene(large(), small()), step)
    assert image.stats["step_world"] == pytest.approx(step * min(small().volume.spacing))
    assert image.stats["skip"]["done"] == "blocks"
    assert len(image.stats["layers"]) == image.stats["several"]["layers"] == 2


def test_three_layers_seen_from_inside(renderer):
    eye = al.Camera.perspective(eye=(14, 8, 10), target=(10, 12, 12), fov_deg=80)
    compare(renderer, scene(large(), small(), inside()))
    compare(renderer, scene(large(), small(), inside(), camera=eye))


def test_layers_may_be_of_any_kind(any_renderer):
    two = np.stack([ball().array, np.roll(ball().array, 4, axis=2)])
    channels = al.Layer(al.Volume(two), al.Channels([al.Channel(0, RED), al.Channel(1, GREEN)]))
    halves = np.ones((20, 22, 24), dtype=np.uint8)
    halves[:, 12:] = 2
    labels = al.Labels(al.Volume(halves), {1: "lime", 2: al.LabelStyle(opacity=0.3)})
    compare(any_renderer, scene(channels, small()))
    compare(any_renderer, scene(holed(), large(labels=labels), small(look=al.Look("bspline", transfer="postclassified"))))


def test_stages_without_parameters_go_with_others_and_tones_follow_in_a_pass_of_their_own(renderer):
    classified = al.Look("preclassified", tone="reinhard")
    compare(renderer, scene(large(look=classified), small(look=al.Look(tone="reinhard"))))
    lit = al.Look(shade=al.shade.Environment(environment=al.Environment.white((0.5, 0.2, 0.1))))
    image = renderer.render(scene(large(look=lit), small(), background=lit.shade.environment), SIZE)
    truth = reference.render(scene(large(look=lit), small(), background=lit.shade.environment), SIZE)
    assert np.abs(image.rgba - truth.rgba).max() <= LEVEL


def test_directions_of_one_volume_are_lit_for_each_layer(renderer):
    """Layers of one volume share its quantised directions, and each has its own shade."""
    matt, shiny = al.shade.BlinnPhong(ambient=0.1, diffuse=0.9), al.shade.BlinnPhong(ambient=0.6, specular=0.9, shininess=3)
    layers = (
        large(look=al.Look(lighting="quantised", shade=matt)),
        large(look=al.Look(lighting="quantised", shade=shiny), transfer=BLUE),
    )
    across = al.Camera.orthographic(eye=(45, 40, 30), target=(11, 11, 11), up=(0, 0, 1), height=30)
    given = {"camera": across, "lights": [al.Light.directional(to_light=(1, 0.5, 1))]}
    # Normals between two directions may be rounded to either: a level or two.
    compare(renderer, scene(*layers, **given), most=4 * LEVEL)


@pytest.mark.parametrize(
    "stage", [al.visibility.AmbientOcclusion(cells=12, directions=24), al.visibility.ShadowVolume(cells=12)]
)
def test_light_is_dimmed_by_all_layers(renderer, stage):
    """Beside a layer that nothing dims, and one that nothing lights."""
    dimmed = al.Look(visibility=stage, shade=al.shade.BlinnPhong(ambient=1.0, diffuse=0.5))
    both = large(look=dimmed, density=5.0), small(look=dimmed, density=5.0)
    image = compare(renderer, scene(*both, inside()))
    assert image.stats["several"]["visibility"] == "by all layers"
    plain = al.Look(shade=dimmed.shade)
    bright = renderer.render(scene(*(replace(one, look=plain) for one in both), inside()), SIZE)
    assert (bright.rgba - image.rgba)[..., :3].max() > 0.1
    compare(renderer, scene(both[0], small(look=al.Look(shade="none"))))


def test_clips_solid_faces_and_meshes(renderer):
    clips = [
        al.Clip.plane(point=(11, 9, 11), normal=(0.2, 1, 0.3)),
        al.Clip.sphere(center=(15, 8, 12), radius=6, keep="outside", capped=True),
    ]
    triangle = al.Mesh([(0, 10, 0), (24, 10, 0), (12, 12, 24)], [(0, 1, 2)], color=(0.2, 0.9, 0.3), opacity=0.5)
    compare(renderer, scene(large(), small(), clips=clips))
    compare(renderer, scene(large(), small(), meshes=[triangle]))


@pytest.mark.parametrize("step", [0.8, 2.0])
def test_the_nearest_surface_of_all_layers_is_met(renderer, step):
    layers = large(look=FIRST_HIT), small(look=FIRST_HIT)
    image = compare(renderer, scene(*layers), step)
    alone = [renderer.render(scene(layer), SIZE, step=step).depth for layer in layers]
    both = np.minimum(*alone)
    seen = np.isfinite(both) & np.isfinite(image.depth)
    assert (alone[0] < alone[1]).any()
    assert (alone[1] < alone[0]).any()
    assert np.abs(image.depth[seen] - both[seen]).max() < 0.05


def test_each_layer_has_a_surface_of_its_own(renderer):
    """At a value, by a side and in colours of its own; left out, that of its function."""
    far = al.integrate.FirstHit(iso=820, colour_by="distance", low=35, high=60)
    layers = large(look=al.Look(integrate=far)), small(look=al.Look(integrate="first_hit"))
    image = compare(renderer, scene(*layers), 0.8)
    other = compare(renderer, scene(*layers[::-1]), 0.8)
    np.testing.assert_array_equal(image.rgba, other.rgba)


@pytest.mark.parametrize("look", [al.Look(), FIRST_HIT])
def test_what_is_kept_is_that_of_the_layer_that_was_met(any_renderer, look):
    drawn = scene(large(look=look, density=0.0), large(look=look), small(look=look, density=5.0))
    image = any_renderer.render(drawn, SIZE, keep_hits=True)
    np.testing.assert_array_equal(image.rgba, any_renderer.render(drawn, SIZE).rgba)
    rows, columns = np.nonzero(image.hits.side)
    assert np.array_equal(image.hits.side > 0, np.isfinite(image.depth))
    assert set(image.hits.side[rows, columns]) <= ({4} if look is not FIRST_HIT else {1, 2, 3})
    assert set(image.hits.layer[rows, columns]) == {1, 2}
    for row, column in list(zip(rows.tolist(), columns.tolist(), strict=True))[::11]:
        picked = image.pick(column, row)
        assert picked.layer == image.hits.layer[row, column]
        np.testing.assert_allclose(image.normal[row, column], picked.normal, atol=0.02)


def test_surfaces_of_layers_are_lit_again(any_renderer):
    """Each in its own colours and by its own material, whatever is not drawn lies between them in the list."""
    first = scene(large(look=FIRST_HIT), large(density=0.0, look=FIRST_HIT), small(look=FIRST_HIT))
    image = any_renderer.render(first, SIZE, keep_hits=True)
    shiny = replace(FIRST_HIT, shade=al.shade.BlinnPhong(ambient=0.4, specular=0.7, shininess=5))
    other = scene(
        large(look=replace(FIRST_HIT, shade="none")),
        large(density=0.0, look=FIRST_HIT),
        small(look=shiny, transfer=GREEN),
        lights=[al.Light.directional(to_light=(0.2, 1, 1), color=(1, 0.8, 0.6))],
    )
    again, anew = any_renderer.relight(image, other), any_renderer.render(other, SIZE)
    assert set(np.unique(image.hits.layer[image.hits.side > 0])) == {0, 2}
    assert np.abs(again.rgba - anew.rgba).max() < 2e-4
    np.testing.assert_array_equal(again.depth, anew.depth)
    assert np.abs(again.rgba - image.rgba).max() > 0.1
    assert again.stats["samples"] == 0
    for changed in (scene(large(look=FIRST_HIT)), scene(*(replace(one, density=1.0) for one in first.layers))):
        with pytest.raises(al.DataError, match="scene shows other layers than the image"):
            any_renderer.relight(image, changed)
    moved = replace(
        other, layers=[*other.layers[:2], replace(small(look=FIRST_HIT), clips=[al.Clip.sphere(center=(9, 9, 9), radius=4)])]
    )
    with pytest.raises(al.DataError, match="another clip"):
        any_renderer.relight(image, moved)


def test_surfaces_of_functions_and_sums(renderer):
    glass = [al.TransferFunction.from_surfaces([al.Surface(500, colour, 0.5)]) for colour in ("red", "blue")]
    compare(renderer, scene(large(transfer=glass[0]), small(transfer=glass[1])))
    xray = al.Look(integrate="xray", shade="none")
    compare(renderer, scene(large(look=xray), small(look=xray)))


def test_order_does_not_matter_and_nothing_adds_nothing(renderer):
    one = renderer.render(scene(large(), small()), SIZE)
    other = renderer.render(scene(small(), large()), SIZE)
    assert np.abs(one.rgba - other.rgba).max() < 2e-6
    alone = renderer.render(scene(large()), SIZE)
    without = renderer.render(scene(large(), small(density=0.0)), SIZE)
    np.testing.assert_array_equal(without.rgba, alone.rgba)
    truth = reference.render(scene(large(), small(density=0.0)), SIZE)
    assert np.abs(without.rgba - truth.rgba).max() <= LEVEL / 10
    hidden = renderer.render(scene(large(), small(visible=False)), SIZE)
    np.testing.assert_array_equal(hidden.rgba, alone.rgba)
    # A function without anything in its range is there, and cuts slabs where its volume begins and ends.
    dark = renderer.render(
        scene(large(), small(transfer=al.TransferFunction([(2000, "red", 0.0), (3000, "red", 1.0)]))), SIZE, step=0.5
    )
    assert np.abs(dark.rgba - renderer.render(scene(large()), SIZE, step=0.5 * min(small().volume.spacing)).rgba).max() < LEVEL


def test_steps_of_several_layers_have_one_length(renderer):
    layers = large(density=4.0), small()
    image = renderer.render(scene(*layers), SIZE, driver=al.driver.March(adaptive=True))
    assert image.stats["adaptive"] is False
    np.testing.assert_array_equal(image.rgba, renderer.render(scene(*layers), SIZE).rgba)


def test_two_halves_are_the_whole_and_twice_is_twice_as_dense(renderer):
    look = al.Look(shade="none", gradient="central")
    whole = ball()
    far = np.eye(4)
    far[0, 3] = 12
    halves = al.Volume(whole.array[..., :13]), al.Volume(whole.array[..., 12:], world_from_index=far)
    truth = renderer.render(scene(large(look=look)), SIZE)
    parts = renderer.render(scene(*(al.Layer(half, RED, look) for half in halves)), SIZE)
    assert np.abs(parts.rgba - truth.rgba).max() < LEVEL
    dense = renderer.render(scene(large(density=2.0)), SIZE)
    twice = renderer.render(scene(large(), large()), SIZE)
    assert np.abs(twice.rgba - dense.rgba).max() < LEVEL


def test_layers_far_apart_are_drawn_as_each_alone(renderer):
    away = np.eye(4)
    away[:3, 3] = (60, 0, 0)
    beside = al.Layer(al.Volume(ball().array, world_from_index=away), BLUE)
    wide = al.Camera.orthographic(eye=(40, -100, 10), target=(40, 0, 10), height=70)
    alone = [renderer.render(scene(layer, camera=wide), (64, 48)).rgba for layer in (large(), beside)]
    both = renderer.render(scene(large(), beside, camera=wide), (64, 48))
    assert np.abs(both.rgba - sum(alone)).max() < 1e-5
    along = al.Camera.orthographic(eye=(-100, 10, 10), target=(40, 10, 10), height=40)
    image = compare(renderer, scene(large(), beside, camera=along))
    unskipped = renderer.render(scene(large(), beside, camera=along), SIZE, skip="none")
    assert np.abs(image.rgba - unskipped.rgba).max() < LEVEL
    assert image.stats["samples"] < unskipped.stats["samples"]


def test_a_dense_face_inside_of_a_medium_has_no_stairs(renderer):
    """A block of glass-like density in fog, its face oblique to the eye: the fog before it has its real length."""
    fog = al.Layer(
        al.Volume(np.ones((4, 4, 4), np.float32), spacing=(10, 10, 10)),
        al.TransferFunction([(0, "white", 0.05)]),
        al.Look(shade="none"),
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((0, 0, 1), 0.3)
    matrix[:3, 3] = (8, 12, 8)
    block = al.Layer(
        al.Volume(np.ones((12, 12, 12), np.float32), world_from_index=matrix),
        al.TransferFunction([(0, "black", 1e3)]),
        al.Look(shade="none"),
    )
    across = al.Camera.orthographic(eye=(15, -50, 15), target=(15, 0, 15), height=10)
    image = renderer.render(scene(fog, block, camera=across), SIZE, step=3.0)
    # Of the fog the way from its face to the block's shows, where the block is opaque.
    normal = matrix[:3, 1]
    for column in range(12, 28):
        origin, direction = across.ray((column + 0.5, 16.5), SIZE)
        way = (matrix[:3, 3] - origin) @ normal / (direction @ normal) - 50
        assert image.rgba[16, column, 0] == pytest.approx(1 - np.exp(-0.05 * way), abs=1e-3)


@pytest.mark.parametrize(
    ("layers", "given", "error", "match"),
    [
        (
            (al.Look(), FIRST_HIT),
            {},
            al.StageError,
            r"layers\[1\].look.integrate is first_hit, that of another emission_absorption",
        ),
        ((al.Look(), al.Look(tone="reinhard")), {}, al.StageError, r"look.tone is reinhard.* give all layers the same"),
        (
            (al.Look(), al.Look(visibility="ambient_occlusion")),
            {"driver": "half_angle"},
            al.StageError,
            "tells itself what reaches a place, and so does ambient_occlusion",
        ),
        ((al.Look(),) * 9, {}, al.LimitError, "has 9 visible layers, one march takes 8: hide"),
    ],
)
def test_what_cannot_be_drawn_is_refused(renderer, layers, given, error, match):
    with pytest.raises(error, match=match):
        renderer.render(scene(*(large(look=look) for look in layers)), SIZE, **given)


def test_textures_beyond_a_devices_limit_are_refused(core_renderer):
    with pytest.raises(al.LimitError, match=r"layers are 6 with .* textures, and .* takes 16"):
        core_renderer.render(scene(*(replace(small(), density=1 + n / 10) for n in range(6))), SIZE)


def test_samplers_beyond_a_devices_limit_are_refused():
    limits = {"max-sampled-textures-per-shader-stage": 128, "max-samplers-per-shader-stage": 16}
    device = SimpleNamespace(limits=limits, info=SimpleNamespace(name="some GPU"))
    program = SimpleNamespace(bindings=[SimpleNamespace(kind="sampler")] * 18)
    with pytest.raises(al.LimitError, match="layers are 6 with 18 samplers, and some GPU takes 16"):
        check_textures(SimpleNamespace(device=device, layers=[None] * 6), program)


def own_clips() -> dict[str, al.Clip]:
    corners = np.array([[6, 8, 5], [16, 9, 6], [9, 17, 6], [10, 11, 16]], dtype=float)
    return {
        "sphere": al.Clip.sphere(center=(12, 12, 9), radius=5, keep="outside", capped=True),
        "plane": al.Clip.plane(point=(12, 11, 10), normal=(1, 0.4, 0.2), capped=True),
        "front": al.Clip.box(low=(6, 6, 6), high=(14, 15, 13), keep="outside", cuts="front"),
        "mesh": al.Clip.mesh(al.Mesh(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]), keep="outside"),
    }


def test_clips_cut_chosen_layers(renderer):
    """Of each kind, beside one of the scene and a line; each layer has faces and caps of its own, also round the eye."""
    clips, lit = own_clips(), al.Look(lighting="interpolated")
    one, other = large(clips=[clips["sphere"], clips["mesh"]], look=lit), small(clips=[clips["front"]], look=lit)
    pin = al.Lines([[(4, 4, 4), (18, 20, 16)]], width_world=1.0, opacity=0.5)
    image = compare(renderer, scene(one, other, clips=[clips["plane"]], meshes=[pin]))
    assert image.stats["clips"] == {"given": 4, "cutting": 4, "capped": 2}
    cut_away = al.Camera.perspective(eye=(14, 8, 10), target=(10, 12, 12), fov_deg=80)
    compare(renderer, scene(large(clips=[clips["sphere"]], look=lit), small(look=lit), camera=cut_away), 2.5)


def test_surfaces_of_chosen_layers_are_cut(renderer):
    clips = own_clips()
    one, other = large(clips=[clips["sphere"]], look=FIRST_HIT), small(clips=[clips["plane"], clips["mesh"]], look=FIRST_HIT)
    compare(renderer, scene(one, other))


def test_a_clip_of_all_layers_is_one_of_the_scene_and_one_alone_leaves_others_whole(renderer):
    sphere = own_clips()["sphere"]
    both = scene(large(clips=[sphere]), small(clips=[sphere]))
    assert np.array_equal(renderer.render(both, SIZE).rgba, renderer.render(scene(large(), small(), clips=[sphere]), SIZE).rgba)
    far = al.Layer(al.Volume(ball().array, world_from_index=np.eye(4) + 400.0 * np.eye(4, k=3)), RED)
    cut, alone = scene(large(clips=[sphere]), far), scene(large(), clips=[sphere])
    assert np.abs(renderer.render(cut, SIZE).rgba - renderer.render(alone, SIZE).rgba).max() <= LEVEL
    unseen = scene(large(density=0.0, clips=[sphere]), small())
    assert np.abs(renderer.render(unseen, SIZE).rgba - renderer.render(scene(small()), SIZE).rgba).max() == 0
    with pytest.raises(al.LimitError, match=r"layer.clips cut some layers alone, which the driver 'slices' cannot"):
        renderer.render(scene(large(clips=[sphere]), small()), SIZE, driver="slices")


def test_scene_files_hold_all_layers(renderer, tmp_path):
    drawn = scene(large(), small(density=0.5), background=(0, 0, 0))
    al.save_scene(drawn, tmp_path / "two.toml", embed=tmp_path / "volume.nrrd")
    loaded = al.load_scene(tmp_path / "two.toml")[0]
    assert [layer.density for layer in loaded.layers] == [1.0, 0.5]
    np.testing.assert_array_equal(renderer.render(loaded, SIZE).rgba, renderer.render(drawn, SIZE).rgba)
    assert main(["render", str(tmp_path / "two.toml"), "-o", str(tmp_path / "two.png"), "--size", "40x32"]) == 0


@pytest.mark.parametrize("look", [al.Look(), FIRST_HIT])
def test_picking_tells_the_layer_that_shows_most(renderer, look):
    drawn = scene(large(look=look), small(look=look, density=5.0))
    image = renderer.render(drawn, SIZE)
    found = {}
    for row, column in np.argwhere(np.isfinite(image.depth))[::11].tolist():
        found.setdefault(image.pick(column, row).layer, []).append(image.rgba[row, column])
    assert set(found) == {0, 1}
    reds, blues = (np.mean(found[number], axis=0) for number in (0, 1))
    assert reds[0] > reds[2]
    assert blues[2] > blues[0]
    assert image.pick(column, row, layer=0).layer == 0
