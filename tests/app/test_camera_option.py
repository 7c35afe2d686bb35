"""Kinds of cameras on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli


def test_both_eyes_see_what_one_would_see_in_half_of_the_picture(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    arguments = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--camera", "iso"]
    assert cli.main([*arguments, "--size", "64x32", "--stereo"]) == 0
    assert cli.main([*arguments, "--size", "32x32"]) == 0
    (both, *_), (one, *_) = drawn
    perspective = al.fit_camera("iso", one.layers[0].volume.corners_world(), 1.0)
    told = {"eye": perspective.eye, "target": perspective.target, "up": perspective.up, "fov_deg": perspective.fov_deg}
    assert both.camera == al.Camera.stereo(**told)


def test_first_pictures_fit_into_each_half(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    for options in (["--size", "64x64", "--stereo"], ["--size", "32x64"]):
        assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), *options]) == 0
    (both, *_), (one, *_) = drawn
    assert (both.camera.name, both.camera.eye) == ("stereo", one.camera.eye)


def test_a_camera_of_another_kind(volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--camera"]
    assert cli.main([*arguments, "panorama:eye=[7,6,5],target=[9,6,5],width_deg=180"]) == 0
    assert drawn[0][0].camera == al.Camera.panorama(eye=(7, 6, 5), target=(9, 6, 5), width_deg=180)
    for option in ("--stereo", "--orthographic"):
        assert cli.main([*arguments, "panorama:eye=[7,6,5],target=[9,6,5]", option]) == 2
        assert f"error: {option} does not go with the camera panorama: leave it out" in capsys.readouterr().err
