"""Documents on the wire: plain data and back, edits of them, undo and redo."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

import airlight as al
from airlight.scene_file.held import FilesByToken, Held
from airlight.viewer.document import Document
from airlight.viewer.edits import applied
from airlight.viewer.history import MOST_STEPS, History
from airlight.viewer.wire import plain_document, read_document


def ball(size: int = 8, **given: Any) -> al.Volume:
    z, y, x = np.mgrid[-1 : 1 : size * 1j, -1 : 1 : size * 1j, -1 : 1 : size * 1j]
    return al.Volume(np.exp(-3 * (x * x + y * y + z * z)).astype(np.float32), **given)


def document(**given: Any) -> Document:
    volume = ball()
    triangle = al.Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), np.array([[0, 1, 2]]), color="red")
    options: dict[str, Any] = {"layers": [al.Layer(volume, al.TransferFunction([(0, "black", 0), (1, "orange", 2)]))]}
    options |= {"camera": al.Camera.perspective(eye=(0, -30, 4), target=(3, 3, 3)), "meshes": [triangle]}
    options |= {"clips": [al.Clip.plane(point=(3, 3, 3), normal=(1, 0, 0))], "annotations": [al.ScaleBar()]}
    return Document(al.Scene(**options | given))


def test_plain_data_come_back_equal() -> None:
    held, first = Held(FilesByToken()), document()
    plain = json.loads(json.dumps(plain_document(first, held), allow_nan=False))
    again = read_document(plain, held)
    assert again == first
    assert again.scene.layers[0].volume is first.scene.layers[0].volume


def test_plain_data_name_no_file(tmp_path: Any) -> None:
    secret = tmp_path / "Jane Doe" / "head.nrrd"
    secret.parent.mkdir()
    al.save(ball(), secret)
    held = Held(FilesByToken())
    layer = al.Layer(al.open(secret), al.TransferFunction([(0, "black", 0), (1, "white", 2)]))
    plain = plain_document(document(layers=[layer]), held)
    assert "Jane" not in json.dumps(plain)
    assert plain["scene"]["layers"][0]["volume"] == "v0"


@pytest.mark.parametrize(
    ("path", "value", "named"),
    [
        (["scene", "layers", 0, "volume"], "/etc/passwd", "v0"),
        (["scene", "layers", 0, "volume"], {"file": "../other.nrrd"}, "v0"),
        (["scene", "layers", 0, "density"], -1, "density"),
        (["scene", "layers", 0, "look", "shade"], {"name": "blinn_phong", "ambient": "x"}, "ambient"),
        (["scene", "meshes", 0, "held"], "m7", "m7"),
        (["scene", "meshes", 0, "file"], "/etc/passwd", "unknown"),
        (["scene", "clips", 0], {"kind": "mesh", "file": "/etc/passwd"}, "passwd"),
        (["scene", "background"], {"kind": "picture", "file": "/etc/passwd"}, "passwd"),
        (["render", "step"], 0, "step"),
        (["render", "driver"], "none such", "driver"),
        (["scene", "unknown"], 1, "unknown"),
    ],
)
def test_wrong_edits_say_what_is_wrong(path: list[Any], value: Any, named: str) -> None:
    held = Held(FilesByToken())
    plain = applied(plain_document(document(), held), [{"op": "set", "path": path, "value": value}])
    with pytest.raises(al.AirlightError, match=named):
        read_document(plain, held)


def test_edits_of_meshes_keep_their_id() -> None:
    held, first = Held(FilesByToken()), document()
    for opacity in (0.25, 0.5):
        path = ["scene", "meshes", 0, "opacity"]
        again = read_document(applied(plain_document(first, held), [{"op": "set", "path": path, "value": opacity}]), held)
        assert again.scene.meshes[0].opacity == opacity
        assert plain_document(again, held)["scene"]["meshes"][0]["held"] == "m0"


def test_what_an_edit_leaves_is_the_very_same() -> None:
    held, first = Held(FilesByToken()), document()
    plain = plain_document(first, held)
    edits = [{"op": "set", "path": ["scene", "layers", 0, "density"], "value": 0.5}]
    found = read_document(applied(plain, edits), held, plain, first)
    assert found.scene.layers[0].density == 0.5
    assert found.scene.layers[0].transfer is first.scene.layers[0].transfer
    assert found.scene.meshes[0] is first.scene.meshes[0]
    assert found.scene.clips[0] is first.scene.clips[0]


# -- edits


def test_edits_change_nothing_in_place() -> None:
    data = {"a": [1, {"b": 2}, 3]}
    assert applied(data, [{"op": "set", "path": ["a", 1, "b"], "value": 5}]) == {"a": [1, {"b": 5}, 3]}
    assert applied(data, [{"op": "insert", "path": ["a", 3], "value": 4}]) == {"a": [1, {"b": 2}, 3, 4]}
    assert applied(data, [{"op": "remove", "path": ["a", 0]}]) == {"a": [{"b": 2}, 3]}
    assert applied(data, [{"op": "remove", "path": ["a"]}]) == {}
    assert applied(data, [{"op": "set", "path": ["c", "d"], "value": 1}]) == {**data, "c": {"d": 1}}
    assert data == {"a": [1, {"b": 2}, 3]}


@pytest.mark.parametrize(
    "ops",
    [
        None,
        [],
        "set",
        [3],
        [{"op": "set", "path": []}],
        [{"op": "set", "path": "a"}],
        [{"op": "set", "path": ["a", 9], "value": 1}],
        [{"op": "set", "path": ["a", -1], "value": 1}],
        [{"op": "set", "path": ["a", True], "value": 1}],
        [{"op": "set", "path": ["a", 0, "x"], "value": 1}],
        [{"op": "replace", "path": ["a"]}],
        [{"op": "set", "path": ["a"] * 99}],
        [{"op": "set", "path": ["a"], "value": 1}] * 999,
    ],
)
def test_wrong_paths_are_refused(ops: Any) -> None:
    with pytest.raises(al.ValueRangeError, match=r"edit|a"):
        applied({"a": [1, 2]}, ops)


@given(st.lists(st.integers(), max_size=6), st.data())
def test_removing_what_was_inserted_changes_nothing(numbers: list[int], data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(numbers)))
    more = applied({"a": numbers}, [{"op": "insert", "path": ["a", place], "value": 7}])
    assert more["a"][place] == 7
    assert applied(more, [{"op": "remove", "path": ["a", place]}]) == {"a": numbers}


# -- history


def test_undo_and_redo_keep_the_camera() -> None:
    first = document()
    second = dataclasses.replace(first, step=2.0)
    history = History(first).edited(second)
    seen = al.Camera.perspective(eye=(9, 9, 9), target=(0, 0, 0))
    turned = dataclasses.replace(history, document=history.document.with_camera(seen))
    assert turned.undone().document == first.with_camera(seen)
    assert turned.undone().redone().document == second.with_camera(seen)
    assert History(first).undone() == History(first).redone() == History(first)


def test_edits_that_merge_are_one_step() -> None:
    history = History(document())
    for step in (1.5, 2.0, 2.5):
        history = history.edited(dataclasses.replace(history.document, step=step), "step")
    assert len(history.past) == 1
    assert history.undone().document.step == 1.0
    other = history.edited(dataclasses.replace(history.document, step=3.0), "other")
    assert len(other.past) == 2


def test_a_turn_is_no_step() -> None:
    history = History(document())
    again = history.edited(history.document.with_camera(al.Camera.perspective(eye=(9, 9, 9), target=(0, 0, 0))))
    assert not again.past


def test_histories_have_an_end() -> None:
    history = History(document())
    for n in range(MOST_STEPS + 5):
        history = history.edited(dataclasses.replace(history.document, step=1.0 + n / 7))
    assert len(history.past) == MOST_STEPS


def test_undo_brings_back_as_many_volumes_as_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    first, other, last = (dataclasses.replace(document(), step=step) for step in (1.0, 2.0, 3.0))
    monkeypatch.setattr("airlight.viewer.history.MOST_BYTES", first.volumes[0].array.nbytes)
    history = History(first).edited(dataclasses.replace(first, step=0.5)).edited(other)
    assert len(history.past) == 2, "steps of one volume"
    history = history.edited(last)
    assert history.past == (other,)
    assert len(history.edited(dataclasses.replace(last, step=0.5)).past) == 2, "edits of what is shown cost nothing"


def test_ids_are_given_once() -> None:
    held, volumes = Held(FilesByToken()), [ball(4) for _ in range(3)]
    assert [held.volume(volume) for volume in volumes] == ["v0", "v1", "v2"]
    held.keep_only(volumes[1:])
    assert list(held.volumes) == ["v1", "v2"]
    assert held.volume(volumes[0]) == "v3"
