"""Gestures to cameras: laws of each, and what sessions do with them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given, settings

import airlight as al
from airlight.movies.keys import Keyframes
from airlight.scene import VIEWS, Camera
from airlight.stages.camera import Orthographic, Perspective
from airlight.viewer import bookmarks, gesturing
from airlight.viewer.asked import bookmarks as asked
from airlight.viewer.document import Document
from airlight.viewer.gestures import BINDINGS, CAMERAS, Gesture, applied, bound, moving, standing, turning
from airlight.viewer.habits import Habits

VOLUME = al.Volume(np.linspace(0, 1, 8**3, dtype=np.float32).reshape(8, 8, 8))
FUNCTION = al.TransferFunction([(0, "black", 0), (1, "orange", 2)])
SIZE = (120, 100)
SPAN = 7 * math.sqrt(3)

few = settings(max_examples=40)
drags = st.floats(-0.9, 0.9)
points = st.tuples(*[st.floats(-50, 50)] * 3)


@st.composite
def cameras(draw: Callable[..., Any], kinds: tuple[str, ...] = ("perspective", "orthographic")) -> Camera:
    eye, target, up = (np.array(draw(points)) for _ in range(3))
    assume(np.linalg.norm(eye - target) > 1 and np.linalg.norm(up) > 0.1)
    assume(np.linalg.norm(np.cross(eye - target, up)) > 0.1 * np.linalg.norm(eye - target) * np.linalg.norm(up))
    if draw(st.sampled_from(kinds)) == "perspective":
        return Camera.perspective(eye=eye, target=target, up=up, fov_deg=draw(st.floats(5, 100)))
    return Camera.orthographic(eye=eye, target=target, up=up, height=draw(st.floats(0.5, 50)))


def document(camera: Camera | None = None) -> Document:
    camera = camera or Camera.perspective(eye=(3.5, -30, 3.5), target=(3.5, 3.5, 3.5))
    return Document(al.Scene(VOLUME, transfer=FUNCTION, camera=camera, lights=[al.Light.head()]))


def place_of(camera: Camera, p_world: Any) -> np.ndarray[Any, Any]:
    """Where a point is seen: from the middle, right and down, in parts of the view's height."""
    right, up, forward = camera.basis()
    way = np.asarray(p_world) - camera.eye
    deep = way @ forward
    height = camera.height if isinstance(camera, Orthographic) else 2 * deep * math.tan(math.radians(camera.fov_deg) / 2)
    return np.array([way @ right, -(way @ up)]) / height


def under(camera: Camera, at: tuple[float, float]) -> np.ndarray[Any, Any]:
    """The point at the target's depth that is seen at a place."""
    right, up, _ = camera.basis()
    return camera.target + turning.shown_height(camera) * (at[0] * right - at[1] * up)


def same(first: Camera, second: Camera, tolerance: float = 1e-7) -> None:
    assert type(first) is type(second)
    scale = 1 + math.dist(first.eye, first.target)
    for name in ("eye", "target"):
        np.testing.assert_allclose(getattr(first, name), getattr(second, name), atol=tolerance * 60 * scale, rtol=0)
    np.testing.assert_allclose(first.basis(), second.basis(), atol=tolerance * 100)
    assert turning.shown_height(first) == pytest.approx(turning.shown_height(second), rel=tolerance * 100)


# -- laws


@few
@given(cameras(), drags, drags)
def test_orbits_keep_distance_and_what_is_up(camera: Camera, dx: float, dy: float) -> None:
    for turned in (turning.turntable(camera, dx, dy), turning.trackball(camera, dx, dy)):
        assert math.dist(turned.eye, turned.target) == pytest.approx(math.dist(camera.eye, camera.target))
        assert turned.target == camera.target
    table = turning.turntable(camera, dx, dy)
    np.testing.assert_allclose(turning.unit(table.up), turning.unit(camera.up), atol=1e-12)
    angle = 2 * math.pi if dx == 0 else dx * math.pi  # of the turn about what is up, seen from the turned axis to the right
    if dx:
        right, was = table.basis()[0], camera.basis()[0]
        assert right @ was == pytest.approx(math.cos(angle), abs=1e-6)


@few
@given(cameras(), drags, drags)
def test_a_trackball_is_undone_by_the_way_back(camera: Camera, dx: float, dy: float) -> None:
    same(turning.trackball(turning.trackball(camera, dx, dy), -dx, -dy), camera)


@few
@given(cameras(), drags, drags, st.tuples(drags, drags))
def test_what_is_under_the_pointer_goes_with_it(camera: Camera, dx: float, dy: float, at: tuple[float, float]) -> None:
    point = under(camera, at)
    moved = place_of(moving.pan(camera, dx, dy), point)
    np.testing.assert_allclose(moved, np.add(at, (dx, dy)), atol=1e-6)
    np.testing.assert_allclose(place_of(moving.dolly(camera, dy, at, SPAN, 30), point), at, atol=1e-6)


@few
@given(cameras(("perspective",)), st.floats(-0.5, 0.5), st.one_of(st.none(), st.tuples(drags, drags)))
def test_a_dolly_is_undone_by_the_way_back(camera: Camera, dy: float, at: Any) -> None:
    same(moving.dolly(moving.dolly(camera, dy, at, 100, 30), -dy, at, 100, 30), camera)


@few
@given(cameras(("orthographic",)), st.floats(0, 0.5))
def test_parallel_rays_zoomed_in_and_out_are_not_cut(camera: Camera, dy: float) -> None:
    near = moving.dolly(camera, -dy, None, 100, 30)
    again = moving.dolly(near, dy, None, 100, 30)
    assert turning.shown_height(again) == pytest.approx(camera.height)
    assert math.dist(again.eye, again.target) >= math.dist(camera.eye, camera.target) * (1 - 1e-9)


@few
@given(cameras(("perspective",)))
def test_parallel_rays_and_back_change_nothing(camera: Perspective) -> None:
    parallel = standing.other_projection(camera, camera.fov_deg)
    assert isinstance(parallel, Orthographic)
    assert parallel.height == pytest.approx(turning.shown_height(camera))
    assert standing.other_projection(parallel, camera.fov_deg) == camera


@few
@given(cameras(), st.integers(1, 7))
def test_a_full_roll_changes_nothing(camera: Camera, parts: int) -> None:
    rolled = camera
    for _ in range(parts):
        rolled = turning.roll(rolled, 2 / parts)
    same(rolled, camera)


@few
@given(cameras(("perspective",)), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_looking_round_keeps_the_eye_and_what_is_seen_goes_with_the_pointer(camera: Camera, dx: float, dy: float) -> None:
    turned = turning.look(camera, dx, dy)
    assert turned.eye == camera.eye
    assert math.dist(turned.eye, turned.target) == pytest.approx(math.dist(camera.eye, camera.target))
    _, _, forward = camera.basis()
    if abs(dx) > 1e-3 and abs(forward @ turning.unit(camera.up)) < 0.5:
        assert place_of(turning.look(camera, dx, 0), camera.target)[0] * dx > 0
    if abs(dy) > 1e-3 and abs(forward @ turning.unit(camera.up)) < 0.5:
        assert place_of(turning.look(camera, 0, dy), camera.target)[1] * dy > 0


@few
@given(cameras(("perspective",)), points)
def test_a_point_that_is_aimed_at_is_in_the_middle_and_as_far_as_it_was(camera: Camera, point: Any) -> None:
    _, _, forward = camera.basis()
    depth = (np.array(point) - camera.eye) @ forward
    assume(depth > 0.1)
    aimed = moving.aimed(camera, point)
    np.testing.assert_allclose(aimed.basis()[2], forward, atol=1e-6)
    np.testing.assert_allclose(place_of(aimed, point), (0, 0), atol=1e-6)
    assert math.dist(aimed.eye, aimed.target) == pytest.approx(depth, rel=1e-6)


@few
@given(cameras(("perspective",)), st.floats(5, 100))
def test_another_angle_keeps_the_size_at_the_target(camera: Camera, fov_deg: float) -> None:
    assert turning.shown_height(standing.of_angle(camera, fov_deg)) == pytest.approx(turning.shown_height(camera))


@few
@given(cameras(), st.floats(0.4, 3))
def test_what_is_fitted_shows_all_corners(camera: Camera, aspect: float) -> None:
    corners = VOLUME.corners_world(cells=False)
    fitted = standing.fitted(camera, corners, aspect, 30)
    places = np.array([place_of(fitted, corner) for corner in corners])
    assert np.abs(places[:, 0]).max() <= aspect / 2
    assert np.abs(places[:, 1]).max() <= 0.5
    assert np.abs(places / (aspect, 1)).max() > 0.2
    np.testing.assert_allclose(fitted.basis()[2], camera.basis()[2], atol=1e-9)


@pytest.mark.parametrize("name", VIEWS)
def test_named_views_look_along_their_axes(name: str) -> None:
    home = document().camera
    there = standing.named(home, name, home.up)
    np.testing.assert_allclose(-there.basis()[2], turning.unit(VIEWS[name][0]), atol=1e-12)
    assert there.target == home.target
    assert math.dist(there.eye, there.target) == pytest.approx(33.5)
    # From there the table turns about its own axis again: from top and bottom, too.
    turned = turning.turntable(there, 0.25, 0.0, home.up)
    np.testing.assert_allclose(turned.up, home.up, atol=1e-12)
    was, now = (np.subtract(camera.eye, camera.target) for camera in (there, turned))
    assert now[2] == pytest.approx(was[2], abs=0.1)
    level = np.array([math.cos(0.25 * math.pi), math.sin(0.25 * math.pi)])
    np.testing.assert_allclose(np.abs(turned.basis()[0] @ there.basis()[0]), level[0], atol=0.01)


def test_the_eye_stops_at_limits() -> None:
    camera = document().camera
    near = far = camera
    for _ in range(30):
        near, far = moving.dolly(near, -2, None, SPAN, 30), moving.dolly(far, 2, None, SPAN, 30)
    assert math.dist(near.eye, near.target) == pytest.approx(moving.NEAREST * SPAN)
    assert math.dist(far.eye, far.target) == pytest.approx(moving.FARTHEST * SPAN)
    same(moving.dolly(near, 0.3, None, SPAN, 30), moving.dolly(moving.dolly(near, 0.1, None, SPAN, 30), 0.2, None, SPAN, 30))


def test_every_camera_takes_every_gesture() -> None:
    frame = {"eye": (3.5, -30.0, 3.5), "target": (3.5, 3.5, 3.5)}
    makers = (Camera.perspective, Camera.orthographic, Camera.stereo, Camera.panorama, Camera.dome)
    for camera in [make(**frame) for make in makers]:
        first = document(camera)
        for kind in set(CAMERAS) - {"fov", "view", "target"}:
            assert applied(first, Gesture(kind, 0.1, 0.2, 0.1), Habits.of(first), SIZE).camera is not None
    with pytest.raises(al.AirlightError, match="perspective"):
        applied(document(Camera.orthographic(**frame)), Gesture("fov", dy=0.1), Habits.of(document()), SIZE)


@pytest.mark.parametrize(
    "message",
    [
        {"kind": "jump"},
        {"kind": "orbit", "dx": float("nan")},
        {"kind": "orbit", "dx": "1"},
        {"kind": "view", "name": "__class__"},
        {"kind": "view", "direction": [0, 0, 0]},
        {"kind": "target", "p_world": [1, 2]},
        {"kind": "target"},
        {"kind": "dolly", "at": [1, "x"]},
        {"kind": "orbit", "stroke": -1},
    ],
)
def test_wrong_gestures_are_told(message: dict[str, Any]) -> None:
    with pytest.raises(al.AirlightError, match=r"gesture|camera"):
        applied(document(), Gesture.of(message), Habits.of(document()), SIZE)


def test_drags_are_bounded() -> None:
    assert Gesture.of({"kind": "orbit", "dx": 1e300}).dx < 10


# -- bindings


def test_bindings_know_their_gestures_and_the_most_particular_goes_first() -> None:
    for entry in BINDINGS:
        assert ("pointer" in entry) != ("key" in entry)
        assert entry["help"]
        assert ("kind" in entry) != ("command" in entry)
        assert entry.get("kind", "orbit") in {*CAMERAS, *gesturing.OTHERS, "aim"}
    none = frozenset[str]()
    assert bound("pointer", "left", none, "turntable")["kind"] == "orbit"
    assert bound("pointer", "left", frozenset({"Meta"}), "turntable")["kind"] == "window"
    assert bound("key", "ArrowLeft", frozenset({"Shift"}), "turntable")["kind"] == "pan"
    assert bound("key", "ArrowLeft", none, "fly")["kind"] == "look"
    assert bound("key", "w", none, "turntable") is None
    assert bound("key", "w", frozenset({"Shift"}), "fly")["kind"] == "fly"


# -- sessions


@few
@given(cameras(("perspective",)), st.floats(0.3, 1.4), st.integers(0, 1000))
def test_narrow_views_stand_back_and_show_all_that_was_seen(camera: Camera, aspect: float, seed: int) -> None:
    points_world = np.random.default_rng(seed).uniform(-5, 5, (40, 3)) + camera.target
    chosen = standing.fitted(camera, points_world, 1.0, 30)
    seen = standing.stood_back(chosen, points_world, aspect, 1.0)
    assert np.abs([place_of(seen, point)[0] for point in points_world]).max() < aspect / 2
    assert (seen is chosen) == (aspect >= 1)
    np.testing.assert_allclose(seen.basis(), chosen.basis(), atol=1e-9)


class Seen:
    """A session as gestures know it, without a renderer."""

    def __init__(self) -> None:
        from airlight.viewer.history import History

        self.history = History(document())
        self.habits, self.travels, self.size_px, self.merges = Habits.of(document()), 0, SIZE, []

    document = property(lambda self: self.history.document)
    camera = property(lambda self: self.document.camera)

    def look(self, change: Any) -> None:
        from dataclasses import replace

        self.history = replace(self.history, document=change(self.document))
        self.habits = self.habits.seen(self.camera)

    def change(self, document: Document, merge: str = "") -> None:
        self.history = self.history.edited(document, merge)

    def keep(self, change: Callable[[Habits], Habits]) -> None:
        self.habits = change(self.habits)


@pytest.fixture
def session() -> Iterator[Any]:
    seen = Seen()
    yield seen
    seen.travels += 1  # ends what travels


def test_gestures_of_a_frame_come_together(session: Any) -> None:
    gesturing.take(session, {"all": [{"kind": "pan", "dx": 0.1}, {"kind": "dolly", "dy": 0.1}]})
    expected = moving.dolly(moving.pan(document().camera, 0.1, 0), 0.1, None, SPAN, 30)
    same(session.camera, expected)
    assert not session.history.past
    with pytest.raises(al.AirlightError):
        gesturing.take(session, {"all": [{"kind": "pan"}] * 1000})


def test_window_and_level_are_one_step_of_undo_a_stroke(session: Any) -> None:
    for _ in range(5):
        gesturing.take(session, {"kind": "window", "dx": math.log(2) / 10, "dy": -0.1, "stroke": 1})
    function = session.document.scene.layers[0].transfer
    width, centre = function.domain[1] - function.domain[0], sum(function.domain) / 2
    assert width == pytest.approx(2)
    assert centre > 0.5
    assert len(session.history.past) == 1
    gesturing.take(session, {"kind": "window", "dx": 0.1, "stroke": 2})
    assert len(session.history.past) == 2
    assert session.history.undone().undone().document.scene.layers[0].transfer == FUNCTION


def test_ways_of_turning_give_way_to_the_one_before(session: Any) -> None:
    seen = []
    for name in ("trackball", "fly", "fly", "trackball", "fly", "turntable"):
        gesturing.take(session, {"kind": "turning", "name": name})
        seen.append(session.habits.turning)
    assert seen == ["trackball", "fly", "trackball", "turntable", "fly", "turntable"]
    before = session.camera
    gesturing.take(session, {"kind": "turning", "name": "fly"})
    gesturing.take(session, {"kind": "orbit", "dx": 0.1})
    assert session.camera.eye == before.eye
    assert session.camera.target != before.target


def test_keyframes_of_a_scene_file_are_bookmarks(tmp_path: Any) -> None:
    file = tmp_path / "scene.toml"
    document_of_file = document()
    assert bookmarks.of_keyframes("head.nii.gz", document_of_file) == ()
    file.write_text('[[keyframes]]\ntime_s = 0\ncamera = "left"\n[[keyframes]]\ntime_s = 2\n"layers[0].density" = 3.0\n')
    left, dense = bookmarks.of_keyframes(file, document_of_file)
    assert (left.name, left.document, dense.name) == ("Key 1", None, "Key 2")
    np.testing.assert_allclose(-left.camera.basis()[2], VIEWS["left"][0], atol=1e-12)
    assert dense.document is not None
    assert dense.document.scene.layers[0].density == 3.0
    assert dense.document.scene.layers[0].volume is VOLUME
    file.write_text("")
    assert bookmarks.of_keyframes(file, document_of_file) == ()


def test_keys_walk_through_bookmarks(session: Any) -> None:
    with pytest.raises(al.AirlightError, match="keep a view"):
        gesturing.take(session, {"kind": "recall", "dx": 1})
    kept = []
    for name in ("front", "left", "top"):
        gesturing.take(session, {"kind": "view", "name": name})
        gesturing.take(session, {"kind": "bookmark"})
        kept.append(session.camera)
    next_key, previous = (bound("key", name, frozenset(), "turntable") for name in ("PageDown", "PageUp"))
    for key, n in ((next_key, 0), (next_key, 1), (next_key, 2), (next_key, 0), (previous, 2), (previous, 1)):
        assert key is not None
        gesturing.take(session, {"kind": key["kind"], "dx": key["dx"]})
        assert session.camera == kept[n]


def test_cameras_travel_and_the_next_gesture_ends_it(session: Any) -> None:
    gesturing.take(session, {"kind": "view", "name": "left", "seconds": 0.05})
    deadline = time.monotonic() + 5
    left = standing.named(document().camera, "left", (0, 0, 1))
    while session.camera != left and time.monotonic() < deadline:
        time.sleep(0.005)
    same(session.camera, left)
    gesturing.take(session, {"kind": "view", "name": "top", "seconds": 2})
    gesturing.take(session, {"kind": "reset"})
    home = session.camera
    time.sleep(0.05)
    assert session.camera is home == session.habits.home


def test_parallel_rays_remember_the_angle(session: Any) -> None:
    gesturing.take(session, {"kind": "fov", "dy": 0.2})
    before = session.camera
    for _ in range(2):
        gesturing.take(session, {"kind": "orthographic"})
    assert session.camera == before


def test_bookmarks_are_kept_recalled_and_become_keys(session: Any) -> None:
    gesturing.take(session, {"kind": "bookmark"})
    gesturing.take(session, {"kind": "orbit", "dx": 0.3})
    asked.add(session, "side", whole=True)
    gesturing.take(session, {"kind": "window", "dx": 0.2})
    narrow = session.document.scene.layers[0].transfer
    gesturing.take(session, {"kind": "recall", "name": "View 1"})
    assert session.camera == document().camera
    assert session.document.scene.layers[0].transfer == narrow
    gesturing.take(session, {"kind": "recall", "name": "side"})
    assert session.document.scene.layers[0].transfer == FUNCTION
    keys = bookmarks.keyframes(session.habits.bookmarks, session.document.scene)
    assert isinstance(keys, Keyframes)
    assert bookmarks.keyframes((), session.document.scene) is None
    other = bookmarks.added(
        (), Document(al.Scene(al.Volume(np.ones((3, 3, 3))), transfer=FUNCTION, camera=session.camera)), "x", True
    )
    assert bookmarks.keyframes(other, session.document.scene) is None
    course = keys.of(session.document.scene)
    assert course.at(0).camera == document().camera
    assert course.at(2).camera == session.camera
    assert [mark["whole"] for mark in session.habits.plain()["bookmarks"]] == [False, True]
    marks = bookmarks.renamed(session.habits.bookmarks, "side", "other")
    with pytest.raises(al.AirlightError, match="side"):
        bookmarks.found(marks, "side")
    assert bookmarks.removed(marks, "other") == session.habits.bookmarks[:1]
    for wrong in ("", "x" * 100, "a\nb"):
        with pytest.raises(al.AirlightError, match="characters"):
            bookmarks.renamed(marks, "other", wrong)


def test_habits_refuse_what_they_do_not_know() -> None:
    habits = Habits.of(document())
    assert habits.changed({"hidden": ["status"], "turning": "trackball"}).plain()["hidden"] == ["status"]
    for wrong in ({"hidden": ["body"]}, {"hidden": "cube"}, {"turning": "spin"}):
        with pytest.raises(al.AirlightError):
            habits.changed(wrong)
