"""Turntables, keyframes and plans: values alone, nothing is drawn."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import airlight as al
from airlight.first_picture import resolved_camera
from airlight.movies import Keyframe, Keyframes, Turntable, changes_of, load_keyframes, make_plan, save_keyframes
from airlight.movies.between import between, camera_between, rotation, turn_between
from airlight.movies.saving import keyframes_and_scene
from airlight.movies.turning import with_room_to_turn

SIZE = (64, 48)
TF = al.TransferFunction([(0, "black", 0.0), (1, "white", 0.5), (3, "red", 1.0)])
numbers = st.floats(-10, 10).map(lambda x: round(x, 3))
vectors = st.tuples(numbers, numbers, numbers)


@st.composite
def cameras(draw: st.DrawFn) -> al.Camera:
    target, away, distance = draw(vectors), np.array(draw(vectors)), draw(st.floats(0.1, 100))
    up = np.array(draw(vectors))
    cross = np.linalg.norm(np.cross(away, up))
    if cross < 1e-3 * max(np.linalg.norm(away) * np.linalg.norm(up), 1e-3):
        away, up = np.array([0.3, -1, 0.2]), np.array([0.0, 0, 1])
    eye = np.array(target) + distance * away / np.linalg.norm(away)
    return al.Camera.perspective(eye=tuple(eye), target=target, up=tuple(up), fov_deg=draw(st.floats(10, 90)))


@pytest.fixture(scope="module")
def scene() -> al.Scene:
    volume = al.samples.load("vortex", size=8)
    clip = al.Clip.plane(point=(0, 0, 0), normal=(0, 1, 0))
    lights = [al.Light.head(), al.Light.directional(to_light=(0, -1, 1)), al.Light.point(position=(0, -9, 3))]
    sphere = al.Lines([(0, 0, 0), (1, 1, 1)])
    return al.Scene(volume, transfer=TF, camera="front", clips=[clip], lights=lights, meshes=[sphere])


# -- cameras


@given(cameras(), cameras(), st.floats(0.01, 0.99))
def test_the_eye_moves_on_a_sphere_round_the_target(first: al.Camera, second: al.Camera, share: float) -> None:
    found = camera_between(first, second, share)
    distances = [math.dist(c.eye, c.target) for c in (first, second, found)]
    assert math.log(distances[2]) == pytest.approx(
        (1 - share) * math.log(distances[0]) + share * math.log(distances[1]), abs=1e-6
    )
    assert found.target == pytest.approx((1 - share) * np.array(first.target) + share * np.array(second.target), abs=1e-9)
    axes = [np.stack([c.basis()[0], c.basis()[1], -c.basis()[2]], axis=1) for c in (first, found, second)]
    whole, part = turn_between(axes[0], axes[2])[1], turn_between(axes[0], axes[1])[1]
    assert part == pytest.approx(share * whole, abs=1e-5)
    if whole < math.pi - 1e-3:
        back = camera_between(second, first, 1 - share)
        assert np.stack(back.basis()) == pytest.approx(np.stack(found.basis()), abs=1e-5)


def test_ends_are_the_cameras_themselves_and_half_turns_keep_up() -> None:
    front = al.Camera.perspective(eye=(0, -4, 0), target=(0, 0, 0), up=(0, 0, 1))
    back = al.Camera.perspective(eye=(0, 4, 0), target=(0, 0, 0), up=(0, 0, 1))
    assert camera_between(front, back, 0) is front
    assert camera_between(front, back, 1) is back
    half = camera_between(front, back, 0.5)
    assert half.up == pytest.approx((0, 0, 1))
    assert np.abs(half.eye) == pytest.approx((4, 0, 0), abs=1e-9)
    flat = [al.Camera.orthographic(eye=(0, -4, 0), target=(0, 0, 0), height=height) for height in (1, 4)]
    assert camera_between(*flat, 0.5).height == pytest.approx(2)
    assert camera_between(front, flat[0], 0.9) is front, "nothing lies between kinds"


@given(vectors.filter(lambda v: np.linalg.norm(v) > 0.1), st.floats(-7, 7))
def test_rotations_keep_lengths_and_their_axis(axis: tuple[float, float, float], angle_rad: float) -> None:
    unit = np.array(axis) / np.linalg.norm(axis)
    turn = rotation(unit, angle_rad)
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-9)
    assert turn @ unit == pytest.approx(unit, abs=1e-9)
    assert rotation((0, 0, 1), math.pi / 2) @ [1, 0, 0] == pytest.approx((0, 1, 0), abs=1e-9)


# -- what lies between


def test_numbers_are_blended_words_wait() -> None:
    first = {"a": 1.0, "n": 2, "word": "x", "flag": True, "list": [0.0, 1.0], "stage": {"name": "p", "q": 1.0}}
    second = {"a": 3.0, "n": 5, "word": "y", "flag": False, "list": [1.0, 3.0], "stage": {"name": "r", "s": 2.0}}
    found = between(first, second, 0.5)
    assert found == first | {"a": 2.0, "n": 4, "list": [0.5, 2.0]}
    with pytest.raises(al.ValueRangeError, match=r"list has 2 entries at one key and 1 at the next"):
        between(first, second | {"list": [1.0]}, 0.5)
    with pytest.raises(al.ValueRangeError, match="a is given at one key only"):
        between(first, {name: value for name, value in second.items() if name != "a"}, 0.5)


# -- keyframes


def test_a_keys_own_time_is_exactly_its_scene(scene: al.Scene) -> None:
    look = al.Look(shade=al.shade.BlinnPhong(ambient=0.5))
    keys = Keyframes(
        (
            (0, {}),
            (0.7, {"camera": "top", "layers[0].density": 2, "layers[0].look.shade": look.shade, "background": "white"}),
            (1.5, {"clips[0].point": [0, 2, 0], "layers[0].transfer": TF, "meshes[0].opacity": 0.5}),
        )
    )
    course = keys.of(scene, SIZE)
    camera = resolved_camera(scene, SIZE)
    layer = dataclasses.replace(scene.layers[0], density=2.0, look=look)
    asked = dataclasses.replace(scene, layers=(layer,), background="white", camera="top")
    asked = dataclasses.replace(asked, camera=resolved_camera(asked, SIZE))
    assert course.at(0) == dataclasses.replace(scene, camera=camera)
    assert course.at(0.7) == asked
    assert course.at(1.5).clips[0] == al.Clip.plane(point=(0, 2, 0), normal=(0, 1, 0))
    assert course.at(1.5).layers[0].density == 1, "what a key does not name is as in the scene"
    assert course.at(9) is course.at(1.5)
    assert course.at(0.35).layers[0].density == pytest.approx(1.5)
    assert course.at(0.35).background == pytest.approx((0.5, 0.5, 0.5))
    assert course.at(1.1).clips[0].point == pytest.approx((0, 1, 0))
    assert course.at(1.1).meshes[0].opacity == pytest.approx(0.75)


def test_what_does_not_change_stays_the_same_object(scene: al.Scene) -> None:
    course = Keyframes(((0, {}), (1, {"layers[0].density": 0.5, "lights[1].intensity": 0.0}))).of(scene, SIZE)
    found = course.at(0.25)
    assert found.layers[0].volume is scene.layers[0].volume
    assert found.layers[0].transfer is scene.layers[0].transfer
    assert found.clips[0] is course.at(0).clips[0]
    assert found.meshes[0] is scene.meshes[0]
    assert 0 < found.lights[1].intensity < 1


def test_points_of_functions_and_time_steps_move(scene: al.Scene) -> None:
    other = al.TransferFunction([(1, "black", 0.0), (2, "white", 0.1), (5, "blue", 1.0)])
    times = al.Volume(np.zeros((9, 1, 4, 4, 4), np.float32))
    two = dataclasses.replace(scene, layers=(al.Layer(times, TF),), clips=())
    course = Keyframes((Keyframe(0, {}, "linear"), Keyframe(2, {"layers[0].transfer": other, "layers[0].time": 8}))).of(
        two, SIZE
    )
    found = course.at(1.0).layers[0]
    assert found.time == 4
    assert [p[0] for p in found.transfer.to_dict()["points"]] == pytest.approx([0.5, 1.5, 4])
    smooth = Keyframes(((0, {}), (2, {"layers[0].density": 0}))).of(scene, SIZE)
    assert smooth.at(0.5).layers[0].density == pytest.approx(1 - (3 * 0.25**2 - 2 * 0.25**3))


def test_no_channel_lies_between_two(scene: al.Scene) -> None:
    three = al.Scene(layers=[al.Layer(al.Volume(np.zeros((3, 4, 4, 4), np.float32)), TF)], camera="front")
    course = Keyframes(((0, {}), (2, {"layers[0].channel": 2}))).of(three, SIZE)
    assert [course.at(time_s).layers[0].channel for time_s in (0, 1, 1.9, 2)] == [0, 0, 0, 2]


def test_styles_of_labels_are_changes_other_labels_are_not(scene: al.Scene) -> None:
    labels = al.Labels(np.arange(512, dtype=np.uint8).reshape(8, 8, 8) % 3, {1: "red"})
    base = dataclasses.replace(scene, layers=(dataclasses.replace(scene.layers[0], labels=labels),))
    base = dataclasses.replace(base, camera=resolved_camera(base, SIZE))
    hidden = dataclasses.replace(base, layers=(dataclasses.replace(base.layers[0], labels=labels.hide(2)),))
    again = Keyframes((Keyframe(0, changes_of(hidden, base)),)).of(base, SIZE).at(0)
    assert again.layers[0].labels.to_dict() == labels.hide(2).to_dict()
    assert again.layers[0].labels.volume is labels.volume
    with pytest.raises(al.DataError, match="make two movies"):
        changes_of(base, scene)


def test_labels_with_other_entries_change_at_the_later_key(scene: al.Scene) -> None:
    labels = al.Labels(np.arange(512, dtype=np.uint8).reshape(8, 8, 8) % 5, {1: "red"}, names={1: "liver"})
    base = dataclasses.replace(scene, layers=(dataclasses.replace(scene.layers[0], labels=labels),))
    for changed in (labels.hide(2), labels.highlight(1), labels.with_style(3, "blue"), labels.with_names({2: "spleen"})):
        other = dataclasses.replace(base, layers=(dataclasses.replace(base.layers[0], labels=changed),))
        course = Keyframes((Keyframe(0), Keyframe(1, changes_of(other, base)))).of(base, SIZE)
        assert course.at(0.9).layers[0].labels is labels
        assert course.at(1).layers[0].labels == changed
    styled = dataclasses.replace(base, layers=(dataclasses.replace(base.layers[0], labels=labels.with_style(1, "blue")),))
    found = Keyframes((Keyframe(0, {}, "linear"), Keyframe(1, changes_of(styled, base)))).of(base, SIZE).at(0.5)
    assert found.layers[0].labels is not None
    assert found.layers[0].labels.style_of(1).colour == pytest.approx((0.5, 0, 0.5))


def test_meshes_fade_as_they_are(scene: al.Scene) -> None:
    meshes = [al.Lines([(n, 0, 0), (n, 1, 1)]) for n in range(3)]
    course = Keyframes(((0, {}), (2, {"meshes[0].opacity": 0.0}))).of(dataclasses.replace(scene, meshes=meshes), SIZE)
    for time_s, opacity in ((0, 1), (1, 0.5), (1.999, 0.0), (2, 0)):
        found = course.at(time_s).meshes
        assert found[0].opacity == pytest.approx(opacity, abs=1e-5)
        assert np.array_equal(found[0].points, meshes[0].points)
        assert found[1] is meshes[1] or np.array_equal(found[1].points, meshes[1].points)


def test_changes_of_a_scene_make_it_again(scene: al.Scene) -> None:
    base = dataclasses.replace(scene, camera=resolved_camera(scene, SIZE))
    layer = dataclasses.replace(scene.layers[0], density=0.25, look=al.Look(tone=al.tone.Reinhard(), shade="none"))
    camera = al.Camera.orthographic(eye=(1, -9, 2), target=(0, 0, 0), height=5)
    other = dataclasses.replace(base, layers=(layer,), camera=camera, lights=scene.lights[:1], background="navy")
    changes = changes_of(other, base)
    assert changes["layers[0].density"] == 0.25
    assert set(changes) <= {
        "layers[0].density",
        "layers[0].look.tone",
        "layers[0].look.shade",
        "camera",
        "lights",
        "background",
    }
    assert Keyframes((Keyframe(0, changes),)).of(base, SIZE).at(0) == other
    assert changes_of(base, base) == {}
    faded = dataclasses.replace(base.meshes[0], opacity=0.5)
    clips = (*base.clips, al.Clip.sphere(center=(0, 0, 0), radius=2))
    own = dataclasses.replace(base.layers[0], clips=base.clips)
    for parts in ({"clips": clips}, {"clips": ()}, {"meshes": [faded]}, {"annotations": [al.Axes()]}, {"layers": (own,)}):
        other = dataclasses.replace(base, **parts)
        course = Keyframes((Keyframe(0), Keyframe(1, changes_of(other, base)), Keyframe(2))).of(base, SIZE)
        again = course.at(1)
        assert changes_of(again, other) == {}
        assert course.at(0.5).clips == base.clips, "lists of other lengths change at the later key"
    for parts in ({"meshes": ()}, {"meshes": [al.Lines([(0, 0, 0), (9, 9, 9)])]}, {"layers": 2 * base.layers}):
        with pytest.raises(al.DataError, match="make two movies"):
            changes_of(dataclasses.replace(base, **parts), base)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ([], "has no keys"),
        ([(0, {}), (0, {})], r"keyframes\[1\].time_s is 0"),
        ([(-1, {})], r"keyframes\[0\]: keyframe.time_s is -1"),
        ([(0, {}, "bouncy")], "easing is 'bouncy'"),
        ([(0, {"layers[1].density": 1})], r"keyframes\[0\]: layers\[1\].density is not in the scene"),
        ([(0, {"layers[0].densty": 1})], r"layers\[0\].densty is unknown"),
        ([(0, {"layers[0].density": "thick"})], r"layers\[0\].density is 'thick', must be a number"),
        ([(0, {"layers 0": 1})], "names 'layers 0'"),
        ([(0, {"layers[0].volume": "other.nrrd"})], "holds data"),
        ([(0, {"layers[0].labels": "other.nrrd"})], r"layers\[0\].labels.file is 'other.nrrd'"),
        ([(0, {"meshes[0].vertices": 1})], "mesh.vertices is unknown"),
        ([(0, {"clips": [{"kind": "mesh", "file": "/no.stl"}]})], r"keyframes\[0\]: clips\[0\]: /no.stl cannot be read"),
        ([(0, {}), (1, {"layers[0].transfer.points": [[0, "red", 1]]})], r"\[0\] to keyframes\[1\]: .*points has 3 entries"),
    ],
)
def test_keys_that_are_wrong_name_the_key(scene: al.Scene, keys: list[object], told: str) -> None:
    with pytest.raises(al.AirlightError, match=told):
        Keyframes(tuple(keys)).of(scene, SIZE)  # type: ignore[arg-type]


@pytest.mark.parametrize("ending", [".toml", ".json"])
def test_keyframes_are_saved_and_loaded(tmp_path: Path, ending: str) -> None:
    keys = Keyframes((Keyframe(0, {"camera": {"eye": [0, -9, 0]}}, "linear"), (2.5, {"layers[0].density": 0.5})))  # type: ignore[arg-type]
    path = tmp_path / f"tour{ending}"
    (tmp_path / "data").mkdir()
    save_keyframes(keys, path, scene=tmp_path / "data" / "head.toml")
    assert load_keyframes(path) == keys
    found, folder, what = keyframes_and_scene(str(path), None, alone=True)
    assert (found, Path(folder), Path(what)) == (keys, tmp_path, tmp_path / "data" / "head.toml")
    assert keyframes_and_scene(str(path), None, alone=False)[0] is None
    with pytest.raises(al.FileError, match=r"use \.toml or \.json"):
        save_keyframes(keys, tmp_path / "tour.txt")


def test_a_list_beside_a_scene_is_left_to_movies(tmp_path: Path, scene: al.Scene) -> None:
    path = tmp_path / "scene.toml"
    al.save_scene(dataclasses.replace(scene, meshes=()), path, embed=tmp_path / "volume.nrrd")
    text = path.read_text()
    path.write_text(
        text + '\n[[keyframes]]\ntime_s = 0\n\n[[keyframes]]\ntime_s = 2\n"layers[0].density" = 0.5\ncamera.fov_deg = 10\n'
    )
    assert al.load_scene(path)[0].layers[0].density == 1
    found = load_keyframes(path).of(al.load_scene(path)[0], SIZE).at(2)
    assert (found.layers[0].density, found.camera.fov_deg) == (0.5, 10)
    path.write_text(text + "\n[[keyframes]]\ntime_s = 0\n\n[[keyframes]]\n\ntime_s = -2\n")
    with pytest.raises(al.ValueRangeError, match=rf"scene.toml:{text.count(chr(10)) + 7}: keyframes\[1\].*is -2"):
        load_keyframes(path)
    path.write_text(text)
    with pytest.raises(al.FileError, match="has no keyframes"):
        load_keyframes(path)


# -- turntables


def test_turntables_turn_the_object_before_the_eye(scene: al.Scene) -> None:
    quarter = Turntable(degrees=90).turned(scene, 1.0, SIZE)
    camera, first = quarter.camera, resolved_camera(scene, SIZE)
    assert np.subtract(camera.eye, camera.target) == pytest.approx(
        (math.dist(first.eye, first.target) * np.array([-1, 0, 0])), abs=1e-6
    )
    to_light = [
        np.array(one.camera.basis()) @ one.lights[1].vector for one in (dataclasses.replace(scene, camera=first), quarter)
    ]
    assert to_light[0] == pytest.approx(to_light[1]), "lights stay with the eye"
    assert Turntable(degrees=90, lights_stay=False).turned(scene, 1.0, SIZE).lights == scene.lights
    assert Turntable(degrees=720).closes
    assert not Turntable(degrees=90).closes
    with pytest.raises(al.ValueRangeError, match="use scene, view or a direction"):
        Turntable(axis="up")


@pytest.mark.parametrize("camera", ["front", "iso", "parallel"])
def test_all_of_a_turn_is_seen(scene: al.Scene, camera: str) -> None:
    if camera == "parallel":
        camera = al.Camera.orthographic(eye=(0, -9, 0), target=(0, 0, 0), height=1)
    scene = dataclasses.replace(scene, camera=camera, layers=(al.Layer(scene.layers[0].volume, TF),))
    table = Turntable()
    fitted = with_room_to_turn(scene, table, SIZE)
    corners, greatest = scene.layers[0].volume.corners_world(), 0.0
    for share in np.linspace(0, 1, 17):
        seen = table.turned(fitted, float(share), SIZE).camera
        right, up, forward = seen.basis()
        away = (corners - seen.eye) @ forward if isinstance(camera, str) else np.ones(len(corners))
        x, y = (corners - seen.eye) @ right / away, (corners - seen.eye) @ up / away
        greatest = max(greatest, *np.abs(x) / seen.half_height / (SIZE[0] / SIZE[1]), *np.abs(y) / seen.half_height)
    assert 0.7 < greatest <= 1


# -- plans


def test_plans_have_a_scene_for_each_frame(scene: al.Scene) -> None:
    assert len(make_plan().scenes(scene, SIZE, 30)) == 180
    turn = make_plan(turns=1, frames=4).scenes(scene, SIZE, 30)
    assert turn[2].camera.eye[1] == pytest.approx(2 * turn[0].camera.target[1] - turn[0].camera.eye[1])
    half = make_plan(turns=0.5, frames=3).scenes(scene, SIZE, 30)
    assert half[2].camera.eye == pytest.approx(turn[2].camera.eye)
    keyed = make_plan(keyframes=[(0, {}), (0.3, {"camera": "top"})]).scenes(scene, SIZE, 10)
    assert len(keyed) == 4, "the last key is seen"
    times = dataclasses.replace(scene, layers=(al.Layer(al.Volume(np.zeros((5, 1, 4, 4, 4), np.float32)), TF), *scene.layers))
    played = make_plan(over="time").scenes(times, SIZE, 20)
    assert [one.layers[0].time for one in played] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
    assert played[0] is played[1], "drawn once"
    both = make_plan(over="time", turns=1, frames=5).scenes(times, SIZE, 20)
    assert [one.layers[0].time for one in both] == [0, 1, 2, 3, 4]
    assert both[1].camera != both[2].camera
    for wrong, told in (
        ({"over": "time", "seconds": 0.1}, "there are 5 time steps"),
        ({"over": "channel"}, "over is 'channel'"),
        ({"seconds": 1, "frames": 3}, "exclude each other"),
        ({"keyframes": [(0, {})], "seconds": 3}, "is given beside keyframes"),
        ({"seconds": 1e9}, "at most 1,000,000"),
        ({"turns": "many"}, "turns is 'many'"),
    ):
        with pytest.raises(al.AirlightError, match=told):
            make_plan(**wrong).scenes(times, SIZE, 20)  # type: ignore[arg-type]
    with pytest.raises(al.DataError, match="needs a volume of several time steps"):
        make_plan(over="time").scenes(scene, SIZE, 20)


def test_pictures_that_keys_name_lie_beside_them(tmp_path: Path, scene: al.Scene) -> None:
    picture = tmp_path / "sky.npy"
    np.save(picture, np.ones((4, 8, 3), np.float32))
    key = Keyframe(0, {"background": {"kind": "picture", "file": "sky.npy"}})
    found = Keyframes((key,)).of(scene, SIZE, tmp_path).at(0)
    assert found.background == al.Environment.open(picture)
