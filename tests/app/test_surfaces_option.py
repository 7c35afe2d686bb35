"""Surfaces of equal value on the command line and in scene files."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight import Surface
from airlight.app import cli
from airlight.app.parse import parse_iso
from airlight.transfer import TransferFunction, presets
from airlight.transfer.colour import PALETTE


def render(volume_file: str, folder: Path, *words: str) -> int:
    return cli.main(["render", volume_file, "-o", str(folder / "a.png"), *words])


def test_alone_they_take_the_place_of_the_chosen_function(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    assert render(volume_file, tmp_path, "--iso", "700:1,0.5,0:0.25:maroon:1", "--iso", "-20:gold") == 0
    expected = [Surface(700, (1, 0.5, 0), 0.25, "maroon", 1.0), Surface(-20, "gold")]
    assert drawn[0][0].layers[0].transfer == TransferFunction.from_surfaces(expected)


def test_beside_a_function_they_are_added_to_it(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    assert render(volume_file, tmp_path, "--iso=300", "--tf", "0:black:0 900:white:1") == 0
    function = TransferFunction([(0, "black", 0), (900, "white", 1)])
    assert drawn[0][0].layers[0].transfer == function.with_surfaces([Surface(300, PALETTE[0])])
    assert render(volume_file, tmp_path, "--iso=300::0.5", "--preset", "xray") == 0
    xray = presets.get("xray", al.open(volume_file))
    assert drawn[1][0].layers[0].transfer == xray.with_surfaces([Surface(300, PALETTE[0], 0.5)])


def test_a_scene_keeps_its_function_and_its_surfaces(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    function = TransferFunction([(0, "black", 0), (900, "white", 1)], surfaces=[Surface(5, "red", 0.5, back_opacity=0.1)])
    scene = al.Scene(al.open(volume_file), transfer=function)
    al.save_scene(scene, tmp_path / "scene.toml")
    loaded, _ = al.load_scene(tmp_path / "scene.toml")
    assert loaded.layers[0].transfer == function
    assert render(str(tmp_path / "scene.toml"), tmp_path) == 0
    assert drawn[0][0].layers[0].transfer == function
    assert render(str(tmp_path / "scene.toml"), tmp_path, "--iso", "40:blue") == 0
    assert drawn[1][0].layers[0].transfer == dataclasses.replace(function, surfaces=(Surface(40, "blue"),))


def test_colours_that_are_not_told_differ() -> None:
    assert len({surface.colour for surface in parse_iso([str(n) for n in range(7)])}) == 7


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--iso", "bone"], "--iso is 'bone', whose value and opacities must be numbers"),
        (["--iso", "3:red:x"], "--iso is '3:red:x', whose value and opacities must be numbers"),
        (["--iso", "3:red:1:blue:1:2"], "must be VALUE:COLOUR:OPACITY:BACK-COLOUR:BACK-OPACITY: e.g."),
        (["--iso", "3:rad"], "--iso 3:rad is 'rad': use a CSS name"),
        (["--iso", "3:red:7"], "--iso 3:red:7 is 7.0, must lie in [0, 1]"),
        (["--iso", "nan"], "--iso nan is nan, must be a finite number"),
        (["--iso", "3", "--iso", "3.0:red"], "--iso has two at the value 3"),
    ],
)
def test_mistakes_are_told_before_a_file_is_opened(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render("absent.nrrd", tmp_path, *words) == cli.USAGE_ERROR
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("way", ["xray", "weighted_sum"])
def test_surfaces_attenuate_in_sums(way: str, volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    assert render(volume_file, tmp_path, "--iso", "300:gold:0.5", "--integrate", way) == 0
    layer = drawn[0][0].layers[0]
    assert layer.look.integrate.name == way
    assert layer.transfer.surfaces == (Surface(300, "gold", 0.5),)


@pytest.mark.parametrize("beside", [[], ["--colormap", "magma"]])
@pytest.mark.parametrize("way", ["mip", "mean", "first_hit"])
def test_what_draws_no_surfaces_is_told(
    way: str, beside: list[str], volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render(volume_file, tmp_path, "--iso", "300", "--integrate", way, *beside) == cli.USAGE_ERROR
    told = capsys.readouterr().err
    assert f"--iso is given, and --integrate {way} draws no surfaces" in told
    assert ("first_hit:iso=300" in told) == (way == "first_hit")
    assert not drawn
