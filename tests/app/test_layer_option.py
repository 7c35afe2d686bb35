"""``--layer``: another volume in the scene."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli


def render(volume_file: str, folder: Path, *words: str) -> int:
    return cli.main(["render", volume_file, "-o", str(folder / "a.png"), *words])


def test_layers_have_functions_of_their_own_and_the_look_of_the_first(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    function = "100:#ff0000:0 900:#ffffff:0.5"
    others = "--layer", f"{volume_file}:tf={function},density=0.5", "--layer", f"{volume_file}:colormap=magma,channel=1"
    assert render(volume_file, tmp_path, "--preset", "xray", "--shade", "none", *others) == 0
    first, second, third = drawn[0][0].layers
    assert first.transfer == al.transfer.presets.get("xray", first.volume)
    assert second.density == 0.5
    assert len(second.transfer.points) == 2
    assert third.transfer == al.transfer.presets.glowing("magma", third.volume, 1)
    assert first.look == second.look == third.look


def test_a_scene_of_meshes_takes_layers(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    al.save_scene(al.Scene(meshes=[al.Lines.axes()], camera="iso"), tmp_path / "meshes.toml")
    assert render(str(tmp_path / "meshes.toml"), tmp_path, "--layer", volume_file) == 0
    assert [layer.look for layer in drawn[0][0].layers] == [al.Look()]


@pytest.mark.parametrize(
    ("option", "told"),
    [
        ("{}:colour=red", "--layer.colour is unknown"),
        ("{}:tf=0:red:1,preset=xray", "--layer.tf and preset exclude each other"),
        ("nowhere.nrrd", "nowhere.nrrd does not exist"),
    ],
)
def test_slips_are_told(option: str, told: str, volume_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert render(volume_file, tmp_path, "--layer", option.format(volume_file)) != 0
    assert told in capsys.readouterr().err
