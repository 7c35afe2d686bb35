"""The stream: the newest first, two on their way to a client, what rests is refined, and what comes ends that."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np
import pytest
from fake_drawing import Drawing, Watching, eventually

import airlight as al
from airlight.errors import LimitError
from airlight.viewer import clients, stream
from airlight.viewer.document import Document
from airlight.viewer.session import Viewer


@pytest.fixture
def drawing(monkeypatch) -> Drawing:
    for name, seconds in {"REST_S": 0.05, "CALM_S": 0.05, "PATIENCE_S": 0.08, "TOLD_S": 0.03}.items():
        monkeypatch.setattr(stream, name, seconds)
    return Drawing()


@pytest.fixture
def viewer(drawing) -> Any:
    z, y, x = np.mgrid[-1:1:6j, -1:1:6j, -1:1:6j]
    volume = al.Volume(np.exp(-(x * x + y * y + z * z)).astype(np.float32))
    made = Viewer(Document(al.Scene(volume)), "ball", drawing)  # type: ignore[arg-type]
    yield made
    made.close()


def test_first_a_quick_picture_then_the_full_one_then_better_ones_and_then_nothing(viewer, drawing):
    watching = Watching(viewer.session())
    eventually(lambda: drawing.refined == ["done"])
    frames = watching.of("frame")
    assert [(f["kind"], f["scale"], f["step"], f["final"], f["refined"]) for f in frames] == [
        ("jpeg", 0.5, 2.0, False, False),
        ("png", 1.0, 1.0, True, False),
        ("png", 1.0, 0.5, True, True),
        ("png", 1.0, 0.25, True, True),
        ("png", 1.0, 0.125, True, True),
    ]
    assert [f.get("tolerance_reached") for f in frames] == [None, None, False, False, True]
    assert frames[0]["drawn_px"] == [16, 12]
    assert frames[1]["stats"]["samples"] == 7
    assert "stats" not in frames[0]
    assert {"fps", "ms", "camera", "rev", "size_px"} <= set(frames[0])
    watching.turn(0.0)
    watching.session.receive({"type": "size", "size_px": [32, 24]})
    time.sleep(0.2)
    assert len(watching.of("frame")) == len(frames)
    assert len(drawing.drawn) == 2


def test_a_chosen_camera_stands_back_in_narrow_views_until_somebody_moves_it(viewer):
    named, viewer.first = viewer.session(), dataclasses.replace(viewer.first, chosen_for=1.0)
    session = viewer.session()
    first = named.camera
    for one in (named, session):
        one.receive({"type": "hello", "size_px": [20, 40]})
    assert named.camera == first
    narrow = session.camera
    assert np.linalg.norm(np.subtract(narrow.eye, first.eye)) > 1
    assert session.habits.home == narrow
    session.receive({"type": "edit", "ops": [{"op": "set", "path": ["scene", "layers", 0, "density"], "value": 2.0}]})
    session.receive({"type": "size", "size_px": [40, 40]})
    assert session.camera == first == session.habits.home
    session.receive({"type": "gesture", "kind": "orbit", "dx": 0.1})
    turned = session.camera
    session.receive({"type": "size", "size_px": [20, 40]})
    assert session.camera == turned
    assert not session.receive({"type": "undo"})
    assert session.document.scene.layers[0].density == 1.0


def test_of_many_inputs_the_newest_is_drawn(viewer, drawing):
    watching = Watching(viewer.session())
    eventually(lambda: drawing.refined)
    drawing.takes_s, before = 0.04, len(drawing.drawn)
    for _ in range(60):
        watching.turn()
        time.sleep(0.002)
    eventually(lambda: watching.last["inputs"] == viewer.session(watching.session.key).inputs)
    assert len(drawing.drawn) - before < 12
    assert watching.last["camera"]["eye"] == list(watching.session.camera.eye)


def test_what_comes_ends_the_refinement_of_all_views_and_each_goes_on_later(viewer, drawing):
    one, other = Watching(viewer.session()), Watching(viewer.session())
    eventually(lambda: drawing.refined == ["done", "done"])
    drawing.level_s, drawing.LEVELS = 1.0, 1
    one.turn()
    eventually(lambda: one.last["final"])
    time.sleep(0.12)
    start = time.monotonic()
    other.turn()
    eventually(lambda: "ended" in drawing.refined)
    eventually(lambda: not other.last["final"])
    assert time.monotonic() - start < 0.5
    eventually(lambda: one.last["refined"] and other.last["refined"])


def test_programs_are_compiled_once_for_all_views_as_soon_as_one_rests(viewer, drawing):
    """Not only when all rest at once, which many views may never do; what they take of memory is there from the start on."""
    mover, rests = Watching(viewer.session()), [Watching(viewer.session()) for _ in range(2)]

    def is_warm() -> bool:
        mover.turn()
        return stream.SMALL_PX in drawing.warmed

    eventually(is_warm)
    assert not drawing.refined
    assert all(watching.last["final"] for watching in rests)
    eventually(lambda: len(drawing.refined) == 3)
    assert len(drawing.warmed) == len(set(drawing.warmed)) >= 10


def test_a_slow_client_has_two_pictures_on_their_way_and_slows_no_other(viewer, drawing):
    session = viewer.session()
    slow, quick = Watching(session, acks=False), Watching(session)
    eventually(lambda: drawing.refined)
    shown = len(slow.of("frame"))
    for _ in range(6):
        before = len(quick.of("frame"))
        quick.turn()
        eventually(lambda before=before: len(quick.of("frame")) > before)
    assert len(slow.of("frame")) == shown
    newest = quick.last
    slow.acks = True
    slow.show_all()
    eventually(lambda: slow.last["inputs"] >= newest["inputs"])
    numbers = [f["frame"] for f in slow.of("frame")]
    assert numbers == sorted(set(numbers))
    assert not set(numbers) & {f["frame"] for f in quick.of("frame")}


def test_nothing_is_drawn_for_nobody_and_who_comes_back_finds_a_picture(viewer, drawing, monkeypatch):
    session = viewer.session()
    first = Watching(session)
    eventually(lambda: drawing.refined == ["done"])
    drawn = len(drawing.drawn)
    first.detach()
    session.receive({"type": "gesture", "kind": "orbit", "dx": 0.1, "dy": 0})
    session.receive({"type": "edit", "ops": [{"op": "set", "path": ["scene", "layers", 0, "density"], "value": 2.0}]})
    time.sleep(0.15)
    assert len(drawing.drawn) == drawn
    again = Watching(viewer.session(session.key))
    assert [message["type"] for message in again.messages[:3]] == ["welcome", "state", "frame"]
    assert again.of("state")[0]["document"]["scene"]["layers"][0]["density"] == 2.0
    eventually(lambda: again.last["rev"] == 1)


def test_one_who_never_shows_anything_is_sent_more_after_a_while(viewer, drawing, monkeypatch):
    monkeypatch.setattr(clients, "LOST_S", 0.1)
    watching = Watching(viewer.session(), acks=False)
    eventually(lambda: len(watching.of("frame")) >= 2)
    time.sleep(0.15)
    watching.turn()
    eventually(lambda: len(watching.of("frame")) >= 3)


def test_an_error_is_told_once_and_the_next_picture_comes(viewer, drawing):
    watching = Watching(viewer.session())
    eventually(lambda: drawing.refined)
    frames, drawing.error = len(watching.of("frame")), LimitError("device", "is too small", "buy another")
    for _ in range(3):
        watching.turn()
        time.sleep(0.1)
    assert [error["what"] for error in watching.of("error")] == ["is too small"]
    assert len(watching.of("frame")) == frames
    drawing.error = None
    watching.turn()
    eventually(lambda: len(watching.of("frame")) > frames)
    drawing.error = RuntimeError("a bug")
    watching.turn()
    eventually(lambda: len(watching.of("error")) == 2)


def test_what_answers_an_edit_names_it(viewer):
    watching = Watching(viewer.session())
    edit = {"op": "set", "path": ["scene", "layers", 0, "density"], "value": 2.0}
    watching.session.receive({"type": "edit", "id": "a1", "ops": [edit]})
    assert watching.of("state")[-1]["answers"] == "a1"
    watching.session.receive({"type": "edit", "id": "a2", "ops": [edit | {"value": "?"}]})
    assert watching.of("error")[-1]["answers"] == "a2"
    watching.session.receive({"type": "undo"})
    assert watching.of("state")[-1]["answers"] == ""


def test_what_takes_long_is_told_of(viewer, drawing):
    drawing.takes_s = 0.2
    watching = Watching(viewer.session())
    eventually(lambda: watching.of("frame"))
    told = watching.of("progress")
    assert (told[0]["what"], told[0]["done"], told[0]["total"]) == ("drawing, step 1", 1, 10)
    assert told[-1]["done"] == told[-1]["total"]


def test_drivers_of_whole_images_are_not_refined(viewer, drawing):
    session = viewer.session()
    session.receive({"type": "edit", "ops": [{"op": "set", "path": ["render", "driver"], "value": "slices"}]})
    watching = Watching(session)
    eventually(lambda: watching.last["final"])
    time.sleep(0.2)
    assert not drawing.refined
    assert not watching.of("error")


def test_sessions_that_nobody_looks_at_end(viewer, drawing):
    session = viewer.session()
    watching = Watching(session)
    viewer.idle_s = 0.1
    time.sleep(0.2)
    assert viewer.session(session.key) is session
    watching.detach()
    eventually(lambda: session.key not in viewer.sessions)
    assert viewer.session(session.key) is not session


def test_of_too_many_sessions_the_one_left_for_longest_ends(viewer, drawing, monkeypatch):
    monkeypatch.setattr("airlight.viewer.session.MOST_SESSIONS", 2)
    first, second = viewer.session(), viewer.session()
    watching = Watching(second)
    Watching(first).detach()
    watching.detach()
    third = viewer.session()
    assert set(viewer.sessions) == {second.key, third.key}
    Watching(second), Watching(third)
    with pytest.raises(LimitError, match="2 views open"):
        viewer.session()


def test_a_view_follows_another_that_was_shared_and_changes_nothing(viewer, drawing):
    leader, follower = Watching(viewer.session()), Watching(viewer.session(), size_px=(16, 16))
    follower.session.receive({"type": "follow", "key": leader.session.key})
    assert "shared" in follower.of("error")[-1]["what"]
    leader.session.receive({"type": "share"})
    assert not follower.of("shared")
    follower.session.receive({"type": "follow", "key": leader.of("shared")[0]["key"]})
    leader.turn(0.2)
    leader.session.receive({"type": "edit", "ops": [{"op": "set", "path": ["scene", "layers", 0, "density"], "value": 3.0}]})
    assert follower.session.document == leader.session.document
    assert follower.of("state")[-1]["following"]
    eventually(lambda: follower.of("frame") and follower.last["camera"] == leader.last["camera"])
    assert follower.last["size_px"] == [16, 16]
    errors = len(follower.of("error"))
    follower.turn()
    follower.session.receive({"type": "undo"})
    leader.session.receive({"type": "follow", "key": leader.of("shared")[0]["key"]})
    assert len(follower.of("error")) == errors + 2
    assert leader.of("error")
    assert follower.session.document == leader.session.document
    viewer.end(leader.session)
    assert not follower.of("state")[-1]["following"]
    follower.turn()
    assert follower.session.document != leader.session.document
    assert follower.session.document.scene.layers[0].density == 3.0
