"""Lights on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli


def render(volume_file: str, folder: Path, *words: str) -> int:
    return cli.main(["render", volume_file, "-o", str(folder / "a.png"), *words])


@pytest.mark.parametrize(
    ("text", "light"),
    [
        ("head", al.Light.head()),
        ("head:color=#ff0000,intensity=.5", al.Light.head(color="#ff0000", intensity=0.5)),
        (
            "directional:to_light=[0,-1,1],color=gold,intensity=0.8",
            al.Light.directional(to_light=(0, -1, 1), color="gold", intensity=0.8),
        ),
        ("point:position=[0,-300,1e2],radius=200", al.Light.point(position=(0, -300, 100), radius=200)),
        ("point:position=[1,2,3],color=[1,0.5,0]", al.Light.point(position=(1, 2, 3), color=(1, 0.5, 0))),
    ],
)
def test_each_kind(text: str, light: al.Light, volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    assert render(volume_file, tmp_path, "--light", text) == 0
    assert drawn[0][0].lights == (light,)


def test_several_take_the_place_of_the_scenes(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    scene = al.Scene(al.open(volume_file), lights=[al.Light.point(position=(1, 2, 3))])
    al.save_scene(scene, tmp_path / "scene.toml")
    assert render(str(tmp_path / "scene.toml"), tmp_path) == 0
    assert drawn[0][0].lights == scene.lights
    lights = ["--light", "head", "--light=directional:to_light=[1,0,0]"]
    assert render(str(tmp_path / "scene.toml"), tmp_path, *lights, "--save-scene", str(tmp_path / "new.toml")) == 0
    assert drawn[1][0].lights == (al.Light.head(), al.Light.directional(to_light=(1, 0, 0)))
    assert al.load_scene(tmp_path / "new.toml")[0].lights == drawn[1][0].lights


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--light", "lamp"], "--light.kind is 'lamp', must be one of head, directional, point"),
        (["--light", "head:radius=3"], "--light.radius is no parameter of head: it has color, intensity"),
        (["--light", "directional"], "--light.to_light is missing"),
        (["--light", "directional:to_light=[0,0,0]"], "--light.to_light is [0, 0, 0], must be a finite direction"),
        (["--light", "directional:to_light=up"], "--light.to_light is 'up': give 3 numbers"),
        (["--light", "point:position=[0,a,1]"], "--light.position is '[0,a,1]': give 3 numbers"),
        (["--light", "point:position=[0,0,1],radius=0"], "--light.radius is 0, must be above 0"),
        (["--light", "head:intensity=-1"], "--light.intensity is -1, must be at least 0"),
        (["--light", "head:color=rad"], "--light.color is 'rad'"),
        (["--light", "head:intensity"], "--light has 'intensity', must be PARAMETER=VALUE"),
    ],
)
def test_mistakes_are_told_before_a_file_is_opened(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render("absent.nrrd", tmp_path, *words) == cli.USAGE_ERROR
    assert message in capsys.readouterr().err


def test_meshes_are_lit_where_the_volume_is_not(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    (tmp_path / "body.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    mesh = f"{tmp_path / 'body.obj'}:lit="
    assert render(volume_file, tmp_path, "--light", "head", "--shade", "none", "--mesh", mesh + "true") == 0
    assert drawn
    for words in (["--shade", "none", "--mesh", mesh + "false"], ["--environment", "studio", "--mesh", mesh + "true"]):
        assert render(volume_file, tmp_path, "--light", "head", *words) == cli.USAGE_ERROR


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        (["--shade", "none"], "--shade none asks no lights"),
        (["--environment", "studio"], "--shade environment asks no lights"),
        (["--integrate", "mip"], "--integrate mip is not lit"),
    ],
)
def test_lights_that_nothing_asks_are_refused(
    words: list[str], cause: str, volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render(volume_file, tmp_path, "--light", "head", *words) == cli.USAGE_ERROR
    assert f"--light lights nothing, {cause}: leave one of them out" in capsys.readouterr().err
    assert not drawn
