"""Scenes without a volume on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli


@pytest.fixture
def arguments(tmp_path: Path) -> list[str]:
    al.save_scene(al.Scene(meshes=[al.Lines.axes()], camera="iso"), tmp_path / "axes.toml")
    return ["render", str(tmp_path / "axes.toml"), "-o", str(tmp_path / "a.png")]


def test_they_are_drawn(arguments: list[str], drawn: Drawn, tmp_path: Path) -> None:
    assert cli.main(arguments) == 0
    assert (tmp_path / "a.png").exists()
    assert cli.main([*arguments, "--orthographic", "--size", "64"]) == 0
    assert drawn[0][0].camera == "iso"
    assert isinstance(drawn[1][0].camera, al.Camera)
    assert drawn[1][0].camera.name == "orthographic"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--clip", "sphere:radius=1"], "--clip cuts volumes, and the scene has none: leave it out"),
        (["--crop", ":,:,1:"], "--crop cuts volumes, and the scene has none: leave it out"),
        (["--light", "head"], "--light lights nothing, the scene has neither volumes nor meshes that are lit"),
    ],
)
def test_what_means_nothing_there_is_refused(
    words: list[str], message: str, arguments: list[str], drawn: Drawn, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([*arguments, *words]) == cli.USAGE_ERROR
    assert message in capsys.readouterr().err
    assert not drawn
