"""Rays cut by clips, against the float64 reference and against laws that hold for all of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, cameras, function, lights, rotation, scene

import airlight as al
from airlight import reference
from airlight.clips import Box, Plane, Sphere
from airlight.reference.clips import pieces

LEVEL = 1 / 255
MIDDLE = blobs().corners_world().mean(axis=0)


def at(*offset: float) -> tuple[float, float, float]:
    x, y, z = MIDDLE + offset
    return float(x), float(y), float(z)


def turned() -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 1, 0), 0.5) @ [[1, 0.3, 0], [0, 1, 0], [0, 0, 1]]
    matrix[:3, 3] = MIDDLE
    return matrix


BOX = al.Clip.box(low=(-6, -8, -10), high=(6, 8, 10), world_from_box=turned(), capped=True)
CLIPS = {
    "plane": [al.Clip.plane(point=at(0, 0, 0), normal=(1, -1, 0.3))],
    "behind a plane, capped": [al.Clip.plane(point=at(0, 0, 0), normal=(1, 1, 0.3), keep="outside", capped=True)],
    "box": [BOX],
    "outside a box": [al.Clip.box(low=at(0, -40, 0), high=at(40, 40, 40), keep="outside")],
    "sphere": [al.Clip.sphere(center=at(0, 0, 0), radius=12)],
    "outside a sphere, capped": [al.Clip.sphere(center=at(0, 0, 0), radius=12, keep="outside", capped=True)],
    "several": [
        al.Clip.sphere(center=at(4, -5, 2), radius=9, keep="outside"),
        al.Clip.sphere(center=at(-4, 5, -2), radius=9, keep="outside", capped=True),
        al.Clip.plane(point=at(0, 0, 0), normal=(0.2, 0.1, 1)),
        al.Clip.box(low=at(-1, -40, -40), high=at(1, 40, 40), keep="outside"),
    ],
}


def clipped(clips, volume=None, camera="perspective", **look) -> al.Scene:
    return dataclasses.replace(scene(volume, camera, **look), clips=clips)


def compare(renderer, drawn, tolerance=LEVEL, **options):
    image, truth = renderer.render(drawn, SIZE, **options), reference.render(drawn, SIZE, **options)
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert error.max() <= tolerance
    assert (np.isfinite(image.depth) == np.isfinite(truth.depth)).mean() > 0.999
    return image


# -- parity


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("kind", CLIPS)
def test_pieces_and_faces(either_renderer, kind, camera):
    for look in ({"lighting": "interpolated"}, {"integrate": al.integrate.FirstHit(iso=70.0)}):
        image = compare(either_renderer, clipped(CLIPS[kind], camera=camera, **look))
        assert image.stats["clips"]["cutting"] == len(CLIPS[kind])


@pytest.mark.parametrize(
    "integrate", ["mip", "minip", "mean", "xray", "weighted_sum", "local_mip", "depth_shaded_mip", "attenuated_mip"]
)
def test_what_is_gathered(renderer, integrate):
    compare(renderer, clipped(CLIPS["several"], integrate=integrate))


@pytest.mark.parametrize("lighting", ["sampled", "supersampled", "averaged", "unlit"])
def test_lighting(renderer, lighting):
    compare(renderer, clipped(CLIPS["several"], lighting=lighting))


@pytest.mark.parametrize("step", [0.4, 3.0])
def test_steps(renderer, step):
    compare(renderer, clipped(CLIPS["outside a sphere, capped"], lighting="interpolated"), step=step)


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated_fast"])
def test_transfer(renderer, transfer):
    compare(renderer, clipped([BOX], transfer=transfer))


def test_empty_samples_have_no_face(renderer):
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    for look in ({}, {"integrate": "mean"}):
        compare(renderer, clipped(CLIPS["several"], volume, **look))


def test_labels_and_channels(renderer):
    numbers = (np.indices((40, 36, 32)).sum(axis=0) // 20).astype(np.uint8)
    labels = al.Labels(al.Volume(numbers, world_from_index=blobs().world_from_index)).hide(1)
    base = clipped([BOX], shade="none")
    compare(renderer, dataclasses.replace(base, layers=[dataclasses.replace(base.layers[0], labels=labels)]))
    two = np.stack([blobs().array, blobs().array[::-1]])
    mixture = [function(), al.TransferFunction([(50, "white", 0), (110, "red", 0.4)])]
    volume = al.Volume(two, world_from_index=blobs().world_from_index)
    drawn = al.Scene(volume, transfer=mixture, camera=cameras(volume)["perspective"], background=None, clips=[BOX])
    compare(renderer, drawn)


def test_surfaces_in_a_medium(renderer):
    base = clipped(CLIPS["sphere"])
    tf = function().with_surfaces([al.Surface(75.0, "lime", 0.5)])
    compare(renderer, dataclasses.replace(base, layers=[dataclasses.replace(base.layers[0], transfer=tf)]))


def test_occlusion_knows_what_is_cut_away(any_renderer):
    shade = al.shade.BlinnPhong(ambient=0.9, diffuse=0.1)
    drawn = clipped(CLIPS["outside a box"], visibility=al.visibility.AmbientOcclusion(cells=12, directions=16), shade=shade)
    any_renderer.render(dataclasses.replace(drawn, clips=[]), SIZE)
    compare(any_renderer, drawn)


def test_a_clip_of_a_layer_is_one_of_the_scene(renderer):
    whole = clipped([BOX])
    own = dataclasses.replace(whole, clips=[], layers=[dataclasses.replace(whole.layers[0], clips=[BOX])])
    assert np.array_equal(renderer.render(whole, SIZE).rgba, renderer.render(own, SIZE).rgba)


# -- closed forms and laws


def homogeneous(extinction: float) -> al.Scene:
    volume = al.Volume(np.full((30, 30, 30), 100, np.float32))
    tf = al.TransferFunction([(0, "white", extinction), (200, "white", extinction)])
    camera = al.Camera.orthographic(eye=(14.3, -30, 14.6), target=(14.3, 10, 14.6), height=24)
    look = al.Look(shade="none", integrate=al.integrate.EmissionAbsorption(opaque_at=1.0))
    return al.Scene(volume, transfer=tf, camera=camera, look=look, background=None)


@pytest.mark.parametrize("step", [1.0, 2.7])
def test_cuts_have_no_stairs(renderer, step):
    """Opacity follows the exact length of the way through a sphere, and round it."""
    drawn = homogeneous(0.05)
    sphere = Sphere((14.3, 14.1, 14.6), 9.0)
    y, x = np.indices((40, 40))
    across = np.hypot(*((c + 0.5) / 40 * 24 - 12 for c in (x, y)))
    chord = 2 * np.sqrt(np.maximum(9.0**2 - across**2, 0))
    for keep, length in (("inside", chord), ("outside", 29 - chord)):
        clip = dataclasses.replace(sphere, keep=keep)
        image = renderer.render(dataclasses.replace(drawn, clips=[clip]), (40, 40), step=step)
        assert np.abs(image.rgba[..., 3] - (1 - np.exp(-0.05 * length))).max() < 1e-4


@settings(max_examples=12)
@given(
    normal=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1 and abs(n[1]) > 0.05),
    offset=st.tuples(*[st.floats(-6, 6)] * 3),
    step=st.floats(0.5, 3),
)
def test_both_sides_of_a_plane_composite_to_the_whole(renderer, normal, offset, step):
    z, y, x = np.indices((24, 24, 24), dtype=np.float32)
    volume = al.Volume(40 + 1.5 * x + 0.9 * y + 0.5 * z)
    camera = al.Camera.orthographic(eye=(11.5, -30, 11.5), target=(11.5, 10, 11.5), height=30)
    look = al.Look(shade="none", integrate=al.integrate.EmissionAbsorption(opaque_at=1.0))
    drawn = al.Scene(volume, transfer=function(), camera=camera, look=look, background=None)
    towards_eye = np.array(normal) * -np.sign(normal[1])
    plane = Plane(tuple(np.add(11.5, offset)), tuple(towards_eye))
    whole, near, far = (
        renderer.render(dataclasses.replace(drawn, clips=clips), SIZE, step=step).rgba
        for clips in ([], [plane], [dataclasses.replace(plane, keep="outside")])
    )
    assert np.abs(near + (1 - near[..., 3:]) * far - whole).max() < 5e-4


@settings(max_examples=6)
@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle_rad=st.floats(0, 6.28),
    shift=st.tuples(*[st.floats(-200, 200)] * 3),
    kind=st.sampled_from(["plane", "box", "outside a sphere, capped"]),
)
def test_moving_all_together_changes_nothing(renderer, axis, angle_rad, shift, kind):
    move = np.eye(4)
    move[:3, :3], move[:3, 3] = rotation(axis, angle_rad), shift
    drawn = dataclasses.replace(scene(), lights=lights()[:1], clips=CLIPS[kind])
    volume, camera = blobs(), drawn.camera

    def there(point):
        return tuple(move[:3, :3] @ point + move[:3, 3])

    def moved(clip):
        match clip:
            case Plane():
                return dataclasses.replace(clip, point=there(clip.point), normal=tuple(move[:3, :3] @ clip.normal))
            case Box():
                return dataclasses.replace(clip, world_from_box=move @ clip.matrix)
            case Sphere():
                return dataclasses.replace(clip, center=there(clip.center))

    layer = dataclasses.replace(
        drawn.layers[0], volume=al.Volume(volume.array, world_from_index=move @ volume.world_from_index)
    )
    view = dataclasses.replace(camera, eye=there(camera.eye), target=there(camera.target), up=tuple(move[:3, :3] @ camera.up))
    elsewhere = dataclasses.replace(drawn, layers=[layer], camera=view, clips=[moved(c) for c in drawn.clips])
    one, two = renderer.render(drawn, SIZE), renderer.render(elsewhere, SIZE)
    # On a silhouette a ray may pass by or meet.
    assert np.sort(np.abs(one.rgba - two.rgba).max(axis=-1).ravel())[-4] <= LEVEL


def test_clips_that_cut_nothing_cost_nothing(renderer):
    """Not a bit of the image changes, and the program is the same."""
    around = [al.Clip.plane(point=at(0, 0, -100 - n), normal=(0, 0.01 * n, 1)) for n in range(20)]
    around += [al.Clip.sphere(center=at(0, 0, 0), radius=100), al.Clip.sphere(center=at(90, 0, 0), radius=50, keep="outside")]
    around += [
        al.Clip.box(low=at(-60, -60, -60), high=at(60, 60, 60)),
        al.Clip.box(low=at(60, 0, 0), high=at(70, 9, 9), keep="outside"),
    ]
    plain, drawn = scene(), clipped(around)
    image = renderer.render(drawn, SIZE)
    assert image.stats["clips"] == {"given": 24, "cutting": 0, "capped": 0}
    assert np.array_equal(image.rgba, renderer.render(plain, SIZE).rgba)
    assert renderer.explain(drawn).key == renderer.explain(plain).key


def test_what_lies_outside_is_not_sampled(renderer):
    small = renderer.render(clipped([al.Clip.sphere(center=at(0, 0, 0), radius=3)], integrate="mean"), SIZE)
    assert 0 < small.stats["samples"] < 0.02 * renderer.render(scene(integrate="mean"), SIZE).stats["samples"]


@settings(max_examples=30)
@given(st.data())
def test_pieces_are_what_all_clips_keep(data):
    """Of the reference: no ray is cut twice at one place, and points are kept as the clips say."""
    rng = np.random.default_rng(data.draw(st.integers(0, 1 << 30)))
    clips = tuple(
        data.draw(st.sampled_from(CLIPS["several"] + CLIPS["box"] + CLIPS["sphere"]))
        for _ in range(data.draw(st.integers(1, 4)))
    )
    target, origin = MIDDLE + rng.uniform(-10, 10, (20, 3)), MIDDLE + rng.uniform(-60, 60, (20, 3))
    direction = (target - origin) / np.linalg.norm(target - origin, axis=1, keepdims=True)
    found = list(pieces(clips, origin, direction, np.zeros(20), np.full(20, 120.0)))
    for t_world in rng.uniform(0, 120, (50, 20)):
        drawn = np.zeros(20, dtype=int)
        for piece in found:
            drawn += (piece.begin < t_world) & (t_world < piece.end)
        expected = reference.clips.kept_by_all(clips, origin + t_world[:, None] * direction)
        assert np.array_equal(drawn, expected.astype(int))


# -- what is seen of faces


def test_a_face_is_lit_by_the_normal_of_its_clip(renderer):
    """A homogeneous block has no gradients: all its light comes from the faces."""
    drawn = homogeneous(2.0)
    shade = al.shade.BlinnPhong(ambient=0.1, diffuse=0.8, specular=0)
    normal = np.array([0.6, 0.8, 0.0])
    for capped in (False, True):
        plane = al.Clip.plane(point=(14, 14, 14), normal=tuple(normal), capped=capped)
        look = dataclasses.replace(drawn.layers[0].look, shade=shade)
        faced = dataclasses.replace(drawn, layers=[dataclasses.replace(drawn.layers[0], look=look)], clips=[plane])
        middle = renderer.render(faced, (41, 41)).rgba[20, 20]
        lit = 0.1 + 0.8 * 0.8
        assert middle[3] > 0.999
        assert middle[0] == pytest.approx(lit, abs=1e-3 if capped else 0.15)
        assert middle[0] <= lit + 1e-3


def test_surfaces_at_cuts_keep_the_normal_of_the_clip(renderer):
    clip = al.Clip.plane(point=at(0, 0, 0), normal=(1, 1, -0.5))
    drawn = clipped([clip], integrate=al.integrate.FirstHit(iso=70.0))
    image = renderer.render(drawn, SIZE, keep_hits=True)
    cut = image.hits.side == 3
    assert cut.sum() > 20
    assert np.abs(image.normal[cut] + np.array([1, 1, -0.5]) / 1.5).max() < 1e-5
    assert not (np.abs(image.normal[image.hits.side == 1] + np.array([1, 1, -0.5]) / 1.5).max(axis=-1) < 1e-3).all()
    again = renderer.relight(image, drawn)
    assert np.abs(again.rgba - image.rgba).max() < 1e-5
    with pytest.raises(al.DataError, match="another clip"):
        renderer.relight(image, dataclasses.replace(drawn, clips=[]))


# -- nothing left


def test_a_clip_that_leaves_nothing_says_so(renderer):
    for clips, reason in (
        ([BOX, al.Clip.plane(point=at(0, 0, 90), normal=(0, 0, 1))], "scene.clips[1], a plane, leaves nothing of the volume"),
        (
            [al.Clip.sphere(center=at(0, 0, 0), radius=90, keep="outside")],
            "scene.clips[0], a sphere, leaves nothing of the volume",
        ),
        ([al.Clip.box(low=at(80, 0, 0), high=at(90, 9, 9))], "scene.clips[0], a box, leaves nothing of the volume"),
        (
            [al.Clip.plane(point=at(0, 0, z), normal=(0, 0, z)) for z in (1, -1)],
            "nothing is seen of what the clips leave",
        ),
    ):
        image = renderer.render(clipped(clips), SIZE)
        assert image.stats["reason"] == reason
        assert not image.rgba.any()
        assert np.isinf(image.depth).all()
    filled = dataclasses.replace(homogeneous(2.0), clips=[al.Clip.plane(point=(14, 14, 14), normal=(0, 1, 0), capped=True)])
    assert "reason" not in renderer.render(filled, (16, 16)).stats
    sky = dataclasses.replace(clipped([al.Clip.sphere(center=at(200, 0, 0), radius=9)]), background=al.Environment.studio())
    image = renderer.render(sky, SIZE)
    assert "leaves nothing" in image.stats["reason"]
    assert image.rgba.any()
