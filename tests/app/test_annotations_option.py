"""Annotations on the command line."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.annotations.base import View
from airlight.app import cli
from airlight.app.annotations import parse_pointer
from airlight.errors import ValueRangeError


def test_options(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    out = ["render", volume_file, "-o", str(tmp_path / "a.png")]
    flags = ["--scale-bar", "--color-bar", "--grid", "--axes", "--orientation"]
    assert cli.main([*out, *flags, "--pointer", "-1,2,3:shape=arrow,label=tip", "--pointer", "4,5,6"]) == 0
    scene = drawn[0][0]
    assert scene.annotations == (
        *(al.ScaleBar(), al.ColorBar(), al.Grid(), al.Axes(), al.Orientation()),
        *(al.Pointer((-1, 2, 3), shape="arrow", label="tip"), al.Pointer((4, 5, 6))),
    )
    # The view is from so far that the whole grid is seen.
    corners = scene.layers[0].volume.corners_world()
    placed = View(scene.camera, (512, 512), corners, 1, "", False, ()).placed(corners)
    assert placed[:, :2].min() > 512 * 0.05
    assert placed[:, :2].max() < 512 * 0.95
    al.save_scene(dataclasses.replace(scene, annotations=[al.Grid(step=3), al.Pointer((1, 1, 1))]), tmp_path / "s.toml")
    assert cli.main(["render", str(tmp_path / "s.toml"), *out[2:], "--grid", "--pointer", "4,5,6"]) == 0
    assert drawn[1][0].annotations == (al.Pointer((1, 1, 1)), al.Grid(), al.Pointer((4, 5, 6)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2", "--pointer is '1,2', must be 3 numbers"),
        ("1,2,3:shape=ring", "--pointer.shape is 'ring'"),
        ("1,2,3:size=4", "--pointer.size is no parameter of pointer"),
        ("1,2,3:kind=grid", "--pointer.kind is told already"),
        ("1,2,3:color", "--pointer has 'color', must be PARAMETER=VALUE"),
    ],
)
def test_slips(text: str, message: str) -> None:
    with pytest.raises(ValueRangeError, match=message):
        parse_pointer(text)


def test_labels_may_be_numbers() -> None:
    assert parse_pointer("1,2,3:label=7") == al.Pointer((1, 2, 3), label="7")
