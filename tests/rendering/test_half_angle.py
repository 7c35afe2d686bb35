"""Half-angle slices: shadows against the reference and closed forms, and the laws of light."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import blobs, function, rotation

import airlight as al
from airlight import reference
from airlight.light_image import LightImage
from airlight.reference import half_angle
from airlight.stages.driver_half_angle import half_angle_planes

SIZE = (24, 20)
EVERY_THIRD = np.array([(x, y) for y in range(SIZE[1]) for x in range(SIZE[0]) if (x + y) % 3 == 0])
SHADOWS = al.driver.HalfAngle(light_size=128, group=8, bias=0)
EMITS = al.shade.Phase(ambient=0.0, strength=1.0)
SIDE, BEHIND = (1.0, -0.7, 0.4), (0.5, 0.9, 0.3)


def directional(to_light=SIDE, **kw) -> al.Light:
    return al.Light.directional(to_light=to_light, **kw)


def box(tau=0.1, rgb=(1.0, 0.5, 0.25), n=12, values=None, **kw) -> al.Scene:
    """A homogeneous box from 0 to n - 1, seen along +y by parallel rays, lit as particles are; another medium by values."""
    if values is None:
        values = np.ones((n, n, n), dtype=np.float32)
    tf = kw.pop("transfer", al.TransferFunction([(0, rgb, tau), (3, rgb, tau)]))
    middle = (n - 1) / 2
    camera = al.Camera.orthographic(eye=(middle, -20.0, middle), target=(middle,) * 3, height=n - 1.0)
    look = al.Look(shade=EMITS, lighting="interpolated")
    return al.Scene(al.Volume(values), **{"transfer": tf, "camera": camera, "look": look, "background": None} | kw)


def blob_scene(lights, camera="front", **look) -> al.Scene:
    thin = al.TransferFunction([(p.value, p.colour, p.extinction / 4) for p in points(function())])
    return al.Scene(blobs(), transfer=thin, camera=camera, look=al.Look(**look), lights=lights, background=None)


def points(tf):
    return [type("P", (), {"value": v, "colour": c, "extinction": t}) for v, c, t in tf.points]


# -- against the reference


@pytest.mark.parametrize(
    ("kind", "light", "transport", "camera"),
    [
        ("renderer", directional(), "opaque", "front"),
        ("core_renderer", directional(BEHIND), "coloured", "front"),
        ("renderer", al.Light.point(position=(60.0, -50.0, 40.0)), "coloured", "iso"),
        ("renderer", al.Light.head(), "opaque", "iso"),
    ],
)
def test_parity(request, kind, light, transport, camera):
    """The medium dims from slice to slice as along a ray of its own to the light, within what slabs and texels hold."""
    drawn = blob_scene([light], camera)
    driver = replace(SHADOWS, transport=transport, bias=1.0 if camera == "iso" else 0.0)
    image = request.getfixturevalue(kind).render(drawn, SIZE, driver=driver)
    truth = half_angle.render(drawn, SIZE, driver, light_step=1, pixels=EVERY_THIRD)
    difference = np.abs(image.rgba[EVERY_THIRD[:, 1], EVERY_THIRD[:, 0]] - truth.rgba)
    assert difference.max() <= 1 / 255
    assert difference.mean() <= 0.02 / 255
    plain = reference.render(drawn, SIZE, pixels=EVERY_THIRD)
    assert np.abs(plain.rgba[..., :3] - truth.rgba[..., :3]).max() > 25 / 255  # there are shadows
    sweep = image.stats["lights"]["sweeps"][0]
    assert sweep["order"].startswith("back to front" if light.vector == directional(BEHIND).vector else "front to back")


def test_an_eye_that_looks_through_the_slices_may_be_in_the_volume(renderer):
    volume = blobs()
    middle = volume.corners_world().mean(axis=0)
    reach = np.linalg.norm(volume.corners_world() - middle, axis=1).max()
    eye = middle - (0, 0.45 * reach, 0)
    camera = al.Camera.perspective(eye=tuple(eye), target=tuple(middle), fov_deg=30)
    drawn = blob_scene([directional()], camera)
    image = renderer.render(drawn, SIZE, driver=SHADOWS)
    truth = half_angle.render(drawn, SIZE, SHADOWS, light_step=1, pixels=EVERY_THIRD)
    assert np.abs(image.rgba[EVERY_THIRD[:, 1], EVERY_THIRD[:, 0]] - truth.rgba).max() <= 1 / 255


def test_finer_slices_and_texels_converge(renderer):
    drawn = blob_scene([directional()])
    truth = half_angle.render(drawn, SIZE, SHADOWS, step=0.5, light_step=0.5, pixels=[(12, 10), (8, 6), (15, 12), (10, 14)])
    chosen = (np.array([10, 6, 12, 14]), np.array([12, 8, 15, 10]))
    errors = []
    for step, size in ((2.0, 32), (0.5, 256)):
        image = renderer.render(drawn, SIZE, driver=replace(SHADOWS, light_size=size), step=step)
        errors.append(np.abs(image.rgba[chosen] - truth.rgba).max())
    assert errors[1] < 0.5 * errors[0]
    assert errors[1] < 0.25 / 255


# -- closed forms


def test_shadow_of_a_homogeneous_box(any_renderer):
    """Lit from the right and a little from the front: light at a place has come straight through the medium."""
    tau, way = 0.1, np.array([1.0, -0.2, 0.1])
    drawn = box(tau, lights=[directional(tuple(way))])
    image = any_renderer.render(drawn, (22, 22), driver=SHADOWS)
    x = (np.arange(22) + 0.5) / 2
    z = 11 - x[:, None]
    way /= np.linalg.norm(way)
    y = (np.arange(2000) + 0.5) * 11 / 2000
    leaves = [(11 - x[None, :, None]) / way[0], y / -way[1], (11 - z[..., None]) / way[2]]
    inside = np.minimum.reduce(np.broadcast_arrays(*leaves))
    expected = (np.exp(-tau * (inside + y)) * tau).sum(axis=2) * 11 / 2000
    for channel, colour in enumerate((1.0, 0.5, 0.25)):
        assert np.abs(image.rgba[1:-1, 1:-1, channel] - colour * expected[1:-1, 1:-1]).max() < 2 / 255
    assert np.allclose(image.rgba[..., 3], 1 - np.exp(-tau * 11), atol=1e-4)


@pytest.mark.parametrize("to_light", [(0.0, -1.0, 0.0), (0.0, 1.0, 0.0)])
def test_colours_of_the_light_that_is_let_through(renderer, to_light):
    """Along the view: the light runs with the eye or against it, and each colour has an extinction of its own."""
    tau, rgb = 0.2, np.array([1.0, 0.5, 0.25])
    middle = (slice(8, 12), slice(8, 12))
    for transport, own in (
        ("opaque", 1 + 0 * rgb),
        (al.transport.Coloured(0.8), 1 - 0.8 * rgb),
        (al.transport.Translucent(0.8, 0.0), 1 - 0.8 * rgb),
    ):
        image = renderer.render(
            box(tau, lights=[directional(to_light)]), (20, 20), driver=replace(SHADOWS, transport=transport)
        )
        k = tau * own if to_light[1] < 0 else -tau * own
        expected = rgb * tau * (1 - np.exp(-(tau + k) * 11)) / np.where(tau + k == 0, 1, tau + k)
        expected = np.where(np.abs(tau + k) < 1e-9, rgb * tau * 11, expected) * np.exp(np.minimum(k, 0) * 11)
        assert np.abs(image.rgba[middle][..., :3] - expected).max() < 3e-3


# -- laws


def test_nothing_is_dark_where_nothing_hides(renderer):
    """Light that passes a medium too thin to take any: the picture of the same slices without shadows."""
    drawn = box(1e-4, lights=[directional()])
    shadowed, plain = renderer.render(drawn, SIZE, driver=SHADOWS), renderer.render(drawn, SIZE, driver="slices")
    lit = plain.rgba[..., 0] > 0
    assert lit.any()
    assert np.allclose(shadowed.rgba[lit] / plain.rgba[lit], 1.0, atol=3e-3)


def test_no_light_leaks_through_an_opaque_wall(renderer):
    values = np.zeros((12, 12, 12), dtype=np.float32)
    values[3:9, 3:9, 1:6] = 1
    values[:, :, 7:9] = 3
    tf = al.TransferFunction([(0, "white", 0), (1, "white", 0.02), (2, "white", 0.02), (2.5, "white", 30.0)])
    drawn = [box(values=values, transfer=tf, lights=[directional((x, -0.1, 0.05))]) for x in (1, -1)]
    dark, lit = (renderer.render(scene, (22, 22), driver=SHADOWS).rgba[6:16, 3:10, :3] for scene in drawn)
    assert dark.max() < 1e-3 < 0.02 * lit.min()


def test_lights_of_half_the_strength_are_one(any_renderer):
    """Ambient light, opacity and depth come once."""
    half = [directional(intensity=0.5), directional(intensity=0.5)]
    one, two = (any_renderer.render(blob_scene(lights), SIZE, driver=SHADOWS) for lights in ([directional()], half))
    assert np.allclose(one.rgba, two.rgba, atol=2e-6)
    assert np.array_equal(one.depth, two.depth)


def test_what_glows_counts_once(renderer):
    """A layer that asks no lights, beside one that does: as bright with two lights as with one."""
    lamp = al.Volume(np.ones((4, 4, 4), np.float32), origin=(-6, 4, 4))
    glows = al.Layer(lamp, transfer=al.TransferFunction([(0, "white", 0.2), (1, "white", 0.2)]), look=al.Look(shade="none"))
    lit = box(0.2, lights=[directional()])
    one, two = (
        renderer.render(replace(lit, layers=[lit.layers[0], glows], lights=some), (22, 22), driver=SHADOWS)
        for some in ([directional()], [directional(intensity=0.5)] * 2)
    )
    assert np.allclose(one.rgba, two.rgba, atol=2e-6)


def test_lights_add_up(renderer):
    lights, shade = [directional(), directional(BEHIND, color="red")], al.shade.BlinnPhong(ambient=0)
    one, other, both = (
        renderer.render(blob_scene(some, shade=shade), SIZE, driver=SHADOWS) for some in (lights[:1], lights[1:], lights)
    )
    assert np.allclose(both.rgba[..., :3], one.rgba[..., :3] + other.rgba[..., :3], atol=1e-5)
    assert np.array_equal(both.rgba[..., 3], one.rgba[..., 3])
    assert len(both.stats["lights"]["sweeps"]) == 2
    assert both.stats["samples"] == one.stats["samples"] + other.stats["samples"]


def test_turning_all_together_changes_nothing(renderer):
    turn, shift = rotation((2, -1, 3), 1.1), np.array([30.0, -20.0, 10.0])
    drawn = blob_scene([directional()], al.fit_camera("front", blobs().corners_world(), 1.2))
    volume, camera = drawn.layers[0].volume, drawn.camera
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, shift
    turned = al.Volume(volume.array, world_from_index=matrix @ volume.world_from_index)
    place = {name: tuple(turn @ np.array(getattr(camera, name)) + shift) for name in ("eye", "target")}
    seen = replace(camera, **place, up=tuple(turn @ np.array(camera.up)))
    there = replace(
        drawn,
        layers=[replace(drawn.layers[0], volume=turned)],
        camera=seen,
        lights=[directional(tuple(turn @ np.array(SIDE)))],
    )
    one, other = (renderer.render(scene, SIZE, driver=SHADOWS) for scene in (drawn, there))
    assert np.abs(one.rgba - other.rgba).max() < 1e-3


def test_no_jump_where_the_order_turns(renderer):
    """The light goes round from the eye's side to behind: at a right angle slices turn round, and the picture stays."""

    def seen(angle_deg):
        a = np.radians(angle_deg)
        lamp = directional((np.sin(a), -np.cos(a), 0.2 * np.sin(a)))
        return renderer.render(blob_scene([lamp]), SIZE, driver=SHADOWS)

    before, behind = seen(89.9), seen(90.1)
    orders = [image.stats["lights"]["sweeps"][0]["order"][:5] for image in (before, behind)]
    assert orders == ["front", "back "]
    assert np.abs(before.rgba - behind.rgba).max() < 1 / 255


def test_translucent_light(renderer):
    """Less scattered is darker, none is the opaque medium, and what goes aside reaches behind what hides."""
    values = np.zeros((16, 16, 16), dtype=np.float32)
    values[:, 6:10] = 1
    values[6:10, :, 10:12] = 3
    tf = al.TransferFunction([(0, "white", 0), (1, "white", 0.08), (2, "white", 0.08), (2, "black", 0.08), (2.5, "black", 8.0)])
    drawn = box(n=16, values=values, transfer=tf, lights=[directional((1, -0.05, 0))])

    def image(transport):
        return renderer.render(drawn, (30, 30), driver=replace(SHADOWS, transport=transport)).rgba[..., 0]

    opaque, none = image("opaque"), image(al.transport.Translucent(0.0, 60.0))
    assert np.abs(opaque - none).max() < 1e-3
    straight, aside = image(al.transport.Translucent(0.9, 0.0)), image(al.transport.Translucent(0.9, 60.0))
    assert (straight >= opaque - 1e-3).all()
    shadow = (slice(13, 17), slice(12, 16))
    assert aside[shadow].mean() > 1.1 * straight[shadow].mean()
    lit = renderer.render(drawn, (30, 30), driver="slices").rgba[..., 0]
    assert (aside <= lit + 3e-3).all()  # nothing is brighter than without shadows


def test_spot_light(renderer):
    """The light's picture, first row on top as seen from the light, against the reference; no light beside it."""
    picture = np.zeros((8, 12, 3))
    picture[:4, :6], picture[4:, :6], picture[:, 6:] = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    light = al.Light.spot(position=(8.5, -30.0, 6.0), target=(5.5, 5.5, 5.5), angle_deg=14, image=picture)
    drawn = box(0.05, lights=[light])
    image = renderer.render(drawn, (44, 44), driver=SHADOWS)
    truth = half_angle.render(drawn, (44, 44), SHADOWS, light_step=1)
    assert np.quantile(np.abs(image.rgba - truth.rgba).max(axis=-1), 0.97) < 3 / 255  # but at borders of colours
    assert (image.rgba[..., :3].max(axis=-1) < 1e-6).any()
    soft = replace(light, beam=replace(light.beam, image=None))
    assert renderer.render(box(0.05, lights=[soft]), (44, 44), driver=SHADOWS).rgba[22, 22, 0] > 0.1


def test_layers_hide_the_light_from_each_other(renderer):
    """Two layers of half the density in one place are one."""
    one = box(0.2, lights=[directional()])
    half = replace(one.layers[0], density=0.5)
    two = replace(one, layers=[half, half])
    images = [renderer.render(drawn, (22, 22), driver=SHADOWS).rgba for drawn in (one, two)]
    assert np.abs(images[0] - images[1]).max() < 2e-3


def test_what_is_skipped_and_drawn_at_once_changes_nothing(renderer):
    drawn = blob_scene([directional()])
    plain = renderer.render(drawn, SIZE, driver=SHADOWS)
    assert np.abs(plain.rgba - renderer.render(drawn, SIZE, driver=SHADOWS, skip="none").rgba).max() < 1e-5
    plate = np.zeros((16, 16, 16), dtype=np.float32)
    plate[3:13, 6:10, 3:13] = 3  # with air round it: light is dimmed first somewhere within a group
    dense = al.TransferFunction([(0, "white", 0), (2.5, "white", 1.0)])
    drawn = box(n=16, values=plate, transfer=dense, lights=[directional((0.3, -1, 0.2))])
    at_once, *groups = (renderer.render(drawn, SIZE, driver=replace(SHADOWS, group=g, bias=1)) for g in (64, 1, 2, 5))
    assert at_once.rgba[..., 0].max() > 0.1
    for image in groups:
        assert np.abs(at_once.rgba - image.rgba).max() < 1e-4


def test_light_is_kept_where_something_is(renderer):
    """Something small in a large volume has shadows as sharp as it would have alone."""
    values = np.zeros((48, 48, 48), dtype=np.float32)
    values[36:44, 4:12, 4:12] = 3
    dense = al.TransferFunction([(0, "white", 0), (2.5, "white", 0.5)])
    camera = al.Camera.orthographic(eye=(8, -60.0, 40), target=(8, 8, 40), height=14)
    drawn = box(n=48, values=values, transfer=dense, camera=camera, lights=[directional((1, -0.4, 0.6))])
    coarse, fine = (renderer.render(drawn, (24, 24), driver=replace(SHADOWS, light_size=n)) for n in (24, 192))
    assert fine.rgba[..., 0].max() > 0.1
    assert np.sqrt(np.mean((coarse.rgba - fine.rgba) ** 2)) < 0.015  # ten times that with texels over all of the volume


def test_turning_lights_keep_what_is_on_the_device(renderer):
    """Tables, buffers and programs are those of the frame before."""

    counts = set()

    def kept(angle_rad):
        lamp = directional((np.cos(angle_rad), -0.7, np.sin(angle_rad)))
        image = renderer.render(blob_scene([lamp]), SIZE, driver=replace(SHADOWS, group=64))
        counts.add(image.stats["lights"]["sweeps"][0]["count"])
        return renderer.kept_bytes

    kept(0.0)
    assert abs(kept(0.0) - kept(0.3)) < 1 << 16
    assert len(counts) == 2


def test_clips_let_light_in(renderer):
    drawn = box(0.3, lights=[directional((1, -0.1, 0))])
    cut = replace(drawn, clips=[al.Clip.plane(point=(6, 0, 0), normal=(-1, 0, 0))])
    one, other = (renderer.render(scene, (22, 22), driver=SHADOWS).rgba for scene in (drawn, cut))
    assert other[11, 10, 0] > 1.5 * one[11, 10, 0]


# -- what is refused


def test_half_angle_axes():
    """Halfway between the two, or at right angles to that; the light runs with the planes or against them."""
    for to_light in np.random.default_rng(4).normal(size=(50, 3)):
        light, eye = to_light / np.linalg.norm(to_light), np.array([0.0, -1.0, 0.0])
        planes, is_opposite = half_angle_planes(light, eye, np.array([1.0, 2.0, 3.0]), 0.5)
        assert np.isclose(planes.normal @ eye, (planes.normal @ light) * (-1 if is_opposite else 1))
        assert -planes.normal @ eye >= np.sqrt(0.5) - 1e-9  # the eye passes them at 45 degrees at the most
        assert np.isclose(planes.spacing_world, 0.5 * abs(planes.normal @ eye))
        assert is_opposite == (light @ eye < 0)


@pytest.mark.parametrize(
    ("change", "driver", "named"),
    [
        ({"lights": [al.Light.point(position=(5.0, 5.0, 5.0))]}, SHADOWS, "lies in the volume"),
        ({"lights": [al.Light.point(position=(11.5, 5.0, 5.0))]}, SHADOWS, "so near"),
        ({"lights": []}, SHADOWS, "makes shadows of lights"),
        ({"look": al.Look(shade="none")}, SHADOWS, "asks none"),
        ({"look": al.Look(integrate="mip")}, SHADOWS, "lets light through slabs"),
        ({"look": al.Look(visibility="ambient_occlusion")}, SHADOWS, "what reaches a place"),
        ({"camera": al.Camera.perspective(eye=(5, 4, 5), target=(5, -11, 5))}, SHADOWS, "among the slices"),
        ({"camera": al.Camera.perspective(eye=(5.5,) * 3, target=(5.5, 11, 5.5))}, SHADOWS, "among the slices"),
        ({"camera": al.Camera.panorama(eye=(5, 4, 5), target=(5, 11, 5))}, SHADOWS, "draws no panorama"),
        ({"lights": [al.Light.spot(position=(0, -30, 0), target=(5, 5, 5))]}, "march", "throws no pictures"),
    ],
)
def test_refused(renderer, change, driver, named):
    with pytest.raises(al.AirlightError, match=named):
        renderer.render(box(**{"lights": [directional()]} | change), (8, 8), driver=driver)


def test_numbers_that_are_refused(renderer):
    for given in (
        {"group": 0},
        {"bias": -1},
        {"bias": 99},
        {"light_size": 0},
        {"light_size": 8192},
        {"transport": "sticky"},
        {"group": 1.5},
    ):
        with pytest.raises(al.ValueRangeError):
            al.driver.HalfAngle(**given)
    with pytest.raises(al.LimitError, match="slices"):
        renderer.render(box(n=80, lights=[directional()]), (8, 8), driver=SHADOWS, step=0.001)


@pytest.mark.parametrize(
    "image",
    [
        "no such file.npy",
        "picture of another kind.png",
        np.ones(3),
        np.ones((2, 2, 4)),
        np.full((2, 2), -1.0),
        np.array([["a"]]),
        np.ones((2, 2), complex),
        np.full((2, 2), np.nan),
    ],
)
def test_pictures_that_are_refused(image):
    with pytest.raises(al.AirlightError, match=r"image|npy"):
        al.Light.spot(position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), image=image)


def test_spot_lights_are_values_and_saved(tmp_path):
    np.save(tmp_path / "window.npy", np.eye(4))
    light = al.Light.spot(position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), image=tmp_path / "window.npy", radius=5)
    again = al.Light.spot(position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), image=np.eye(4), radius=5)
    assert light == again
    assert hash(light) == hash(again)
    assert LightImage(np.full((2, 2), 255, np.uint8)) == LightImage(np.ones((2, 2)))
    volume = al.Volume(np.zeros((4, 4, 4), np.float32))
    drawn = al.Scene(volume, lights=[light])
    driver = al.driver.HalfAngle(transport=al.transport.Translucent(angle_deg=20))
    al.save_scene(drawn, tmp_path / "scene.toml", embed=tmp_path / "v.nrrd", render={"driver": driver})
    text = (tmp_path / "scene.toml").read_text()
    assert 'file = "window.npy"' in text
    scene, options = al.load_scene(tmp_path / "scene.toml")
    assert scene.lights == (light,)
    assert options["driver"] == driver
    with pytest.raises(al.DataError, match="no file"):
        al.save_scene(replace(drawn, lights=[again]), tmp_path / "other.toml", embed=tmp_path / "w.nrrd")


def test_the_plain_reference_knows_no_shadows():
    with pytest.raises(al.DataError, match="half_angle"):
        reference.render(box(lights=[directional()]), (4, 4), driver=SHADOWS)
