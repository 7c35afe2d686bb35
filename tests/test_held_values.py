"""Scenes as plain data and back within one program: ids, and the very values of what stayed as it was."""

from __future__ import annotations

import dataclasses
import gc
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import airlight as al
from airlight.scene_file.held import FilesByPath, FilesByToken, Held
from airlight.viewer.edits import applied

TF = al.TransferFunction([(0, "black", 0), (1, "orange", 2)])
NAMES = {n: f"region {n}" for n in range(1, 3000)}


def scene() -> al.Scene:
    volume, regions = al.Volume(np.zeros((4, 4, 4), np.float32)), np.arange(64, dtype=np.int16).reshape(4, 4, 4)
    triangle = al.Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), np.array([[0, 1, 2]]), color="red")
    layers = [al.Layer(volume, TF), al.Layer(volume, TF, labels=al.Labels(regions, {7: "red"}, names=NAMES))]
    clips, meshes = [al.Clip.plane(point=(0, 0, 0), normal=(1, 0, 0))], [triangle, al.Lines([(0, 0, 0), (1, 1, 1)])]
    lights = [al.Light.head(intensity=0.5)]
    marks = {"clips": clips, "meshes": meshes, "annotations": [al.ScaleBar()], "lights": lights, "background": "navy"}
    return al.Scene(layers=layers, camera="front", **marks)


EDITS: list[dict[str, Any]] = [
    {"op": "set", "path": ["layers", 1, "density"], "value": 0.5},
    {"op": "set", "path": ["layers", 0, "look", "shade"], "value": "none"},
    {"op": "set", "path": ["layers", 0, "transfer"], "value": {"points": [[0, [0, 0, 0], 0], [2, [1, 1, 1], 1]]}},
    {"op": "remove", "path": ["layers", 0, "transfer"]},
    {"op": "set", "path": ["layers", 1, "labels", "hidden"], "value": "3-9"},
    {"op": "remove", "path": ["layers", 1, "labels", "names"]},
    {"op": "remove", "path": ["layers", 1, "labels"]},
    {"op": "remove", "path": ["layers", 0]},
    {"op": "insert", "path": ["layers", 0], "value": {"volume": "v0", "density": 2.0}},
    {"op": "set", "path": ["meshes", 1, "opacity"], "value": 0.25},
    {"op": "remove", "path": ["meshes"]},
    {"op": "remove", "path": ["clips"]},
    {"op": "remove", "path": ["background"]},
    {"op": "set", "path": ["camera"], "value": "top"},
    {"op": "remove", "path": ["lights"]},
]


@pytest.mark.parametrize("op", EDITS, ids=lambda op: f"{op['op']}-{'.'.join(map(str, op['path']))}")
def test_what_stays_is_the_very_same_and_all_is_as_if_read_anew(op: dict[str, Any]) -> None:
    first = scene()
    held = Held(FilesByToken())
    plain = held.plain(first)
    assert held.scene(plain) == first
    changed = applied(plain, [op])
    found = held.scene(changed, plain, first)
    assert found == held.scene(changed)
    assert found != first
    for entry in ("meshes", "clips", "lights", "annotations"):
        if entry != op["path"][0]:
            assert all(a is b for a, b in zip(getattr(found, entry), getattr(first, entry), strict=True))
    places = {"insert layers 0": [1, 2], "remove layers 0": [None, 0]}
    for before, place in zip(first.layers, places.get(" ".join(map(str, [op["op"], *op["path"]])), [0, 1]), strict=True):
        if place is not None:
            after, is_edited = found.layers[place], op["path"][:2] == ["layers", place] and len(op["path"]) > 2
            assert (after is before) is not is_edited
            for entry in ("look", "transfer", "labels", "volume"):
                assert getattr(after, entry) is getattr(before, entry) or (is_edited and op["path"][2] == entry)


def test_neighbours_in_a_list_are_not_made_anew(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box().export(tmp_path / "box.stl")
    solid = al.Clip.mesh(al.Mesh.open(tmp_path / "box.stl"))
    first = dataclasses.replace(scene(), clips=(*scene().clips, solid))
    held = Held(FilesByToken())
    plain = held.plain(first)
    (tmp_path / "box.stl").unlink()
    found = held.scene(applied(plain, [{"op": "set", "path": ["clips", 0, "point"], "value": [1, 0, 0]}]), plain, first)
    assert found.clips[0].point == (1, 0, 0)
    assert found.clips[1] is solid
    without = held.scene(applied(plain, [{"op": "remove", "path": ["clips", 0]}]), plain, first)
    assert without.clips[0] is solid


def test_tables_of_names_stay_behind() -> None:
    held, first = Held(FilesByToken()), scene()
    plain = held.plain(first)
    assert "region" not in json.dumps(plain)
    hidden = held.scene(applied(plain, [{"op": "set", "path": ["layers", 1, "labels", "hidden"], "value": "5"}]), plain, first)
    labels, before = hidden.layers[1].labels, first.layers[1].labels
    assert labels is not None
    assert before is not None
    assert labels == before.hide(5)
    assert labels.names is before.names
    assert labels.to_dict() == before.hide(5).to_dict()
    assert held.plain(hidden)["layers"][1]["labels"]["names"] == plain["layers"][1]["labels"]["names"]
    assert held.in_full(plain["layers"][1])["labels"] == {"volume": "v1"} | before.to_dict()
    with pytest.raises(al.ValueRangeError, match=r"names9.*known: names0"):
        held.scene(applied(plain, [{"op": "set", "path": ["layers", 1, "labels", "names"], "value": "names9"}]))


def test_shapes_that_differ_in_few_numbers_share_an_id_while_they_live() -> None:
    held = Held(FilesByToken())
    lines = al.Lines([(0, 0, 0), (1, 1, 1)])
    for opacity in (1.0, 0.5, 0.25):
        assert held.mesh(dataclasses.replace(lines, opacity=opacity))["held"] == "m0"
    assert held.mesh(al.Lines([(0, 0, 0), (1, 1, 2)]))["held"] == "m1"
    gc.collect()
    assert len(held._shape_ids) == 2, "of shapes that are gone nothing is kept"


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        (["layers"], 3, r"layers is 3, must be a list"),
        (["layers"], [3], r"layers is \[3\], must be a list of tables"),
        (["layers", 0, "volume"], "/etc/passwd", r"layers\[0\].volume.* is '/etc/passwd', must be one of v0, v1"),
        (["layers", 1, "channel"], 3, r"layers\[1\]: .*channel"),
        (["meshes", 0, "held"], 5, r"meshes\[0\]: mesh.held is 5, must be one of m0, m1"),
        (["meshes", 0, "kind"], "lines", "mesh.kind is 'lines', and m0 is a mesh"),
        (["meshes", 0, "vertices"], [], "mesh.vertices is unknown"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(path: list[Any], value: Any, told: str) -> None:
    held, first = Held(FilesByToken()), scene()
    plain = held.plain(first)
    with pytest.raises(al.AirlightError, match=told):
        held.scene(applied(plain, [{"op": "set", "path": path, "value": value}]), plain, first)


def test_files_by_token_and_by_path(tmp_path: Path) -> None:
    tokens = FilesByToken()
    secret = str(tmp_path / "Jane Doe.HDR")
    assert tokens.name(secret) == tokens.name(secret) == "file0.hdr"
    assert tokens.path("file0.hdr") == secret
    for wrong in (secret, "file1.hdr", "x/file0.hdr", ""):
        with pytest.raises(al.ValueRangeError, match=r"known: file0\.hdr"):
            tokens.path(wrong)
    assert FilesByPath(tmp_path).path("sky.hdr") == str(tmp_path / "sky.hdr")
    assert FilesByPath(tmp_path).path("/a/sky.hdr") == "/a/sky.hdr"
    assert Path(FilesByPath().name("sky.hdr")).is_absolute()
