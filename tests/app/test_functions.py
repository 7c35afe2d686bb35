"""Transfer functions on the command line: colour maps, saved functions, and lists of names."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli
from airlight.transfer import TransferFunction, presets


def render(volume_file: str, folder: Path, *words: str) -> int:
    return cli.main(["render", volume_file, "-o", str(folder / "a.png"), *words])


def test_colour_maps(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    assert render(volume_file, tmp_path, "--colormap", "viridis", "--channel", "out") == 0
    function = drawn[0][0].layers[0].transfer
    assert function == presets.glowing("viridis", al.open(volume_file), "out")
    assert function is not None
    assert function.extinctions[0] == 0
    assert function.extinctions.max() == pytest.approx(60 / 24)
    assert render(volume_file, tmp_path, "--colormap", "magma_r", "--integrate", "mip") == 0
    assert drawn[1][0].layers[0].transfer == presets.glowing("magma_r", al.open(volume_file))


def test_saved_functions(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    function = TransferFunction.gaussian(300, 50, "gold", 0.2) + TransferFunction.ramp(500, 900)
    function.save(tmp_path / "tf.toml")
    assert render(volume_file, tmp_path, "--tf", str(tmp_path / "tf.toml")) == 0
    assert drawn[0][0].layers[0].transfer == function


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--colormap", "viridsi"], "colormap 'viridsi' is unknown: did you mean viridis"),
        (["--colormap", "gray", "--preset", "xray"], "--preset and --colormap exclude each other"),
        (["--colormap", "gray", "--tf", "0:red:1"], "--tf and --colormap exclude each other"),
    ],
)
def test_mistakes_are_told_before_a_file_is_opened(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert render("absent.nrrd", tmp_path, *words) == cli.USAGE_ERROR
    assert message in capsys.readouterr().err


def test_names_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["presets"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(presets.names())
    assert "Hounsfield units" in lines[0]
    assert cli.main(["presets", "ct-bone"]) == 0
    assert capsys.readouterr().out.startswith("ct_bone  bones alone")
    assert cli.main(["presets", "--colormaps", "virid"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("sequential:\n")
    assert "viridis" in out
    assert cli.main(["presets", "nosuch"]) == cli.USAGE_ERROR
