"""Joint functions and histograms on the command line, and functions made of the data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fake_renderer import Drawn
from PIL import Image

import airlight as al
from airlight.app import cli

FUNCTION = al.JointFunction(
    (al.joint.Axis("value", 0, 1000), al.joint.Axis("gradient", 0, 400)),
    [al.joint.Triangle(500, 200, 390, 20, colour="gold", extinction=0.5)],
)


def pixels(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def test_a_histogram_is_drawn(volume_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain, second, over = (tmp_path / f"{name}.png" for name in ("plain", "second", "over"))
    assert cli.main(["histogram", volume_file, "-o", str(plain)]) == 0
    told = capsys.readouterr().out
    assert f"{12 * 14 * 16:,} samples; 0 lie beyond" in told or "samples; 1 lie" in told or "samples; 2 lie" in told
    assert "gradient" in told
    assert cli.main(["histogram", volume_file, "-o", str(second), "--variables", "in,out", "--bins", "32"]) == 0
    FUNCTION.save(tmp_path / "function.toml")
    assert cli.main(["histogram", volume_file, "-o", str(over), "--tf", str(tmp_path / "function.toml")]) == 0
    sizes = {path: pixels(path).shape for path in (plain, second, over)}
    assert len(set(sizes.values())) == 1
    # The two channels add up to 1000: the histogram is a line that falls, and the triangle is golden, not blue.
    plot = pixels(second)[18:530, 76:588].sum(axis=-1)
    bright = np.argwhere(plot > plot.min() + 60)
    assert np.abs(bright[:, 0] - bright[:, 1]).max() < 64
    golden = pixels(over)[18:530, 76:588]
    assert (golden[..., 0] > golden[..., 2] + 60).mean() > 0.1
    assert not (pixels(plain)[18:530, 76:588, 0] > pixels(plain)[18:530, 76:588, 2] + 60).any()


def test_one_variable_is_drawn_as_bars_with_a_function_over_them(volume_file: str, tmp_path: Path) -> None:
    bars, over = tmp_path / "bars.png", tmp_path / "over.png"
    assert cli.main(["histogram", volume_file, "-o", str(bars), "--variables", "value"]) == 0
    assert cli.main(["histogram", volume_file, "-o", str(over), "--tf", "0:red:0 1000:red:1"]) == 0
    assert ((pixels(over) != pixels(bars)).any(axis=-1)).mean() > 0.1


def test_functions_that_do_not_go_with_the_data_or_the_option_are_told(
    volume_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "a.png")
    axes = [al.joint.Axis(n, 0, 100) for n in (0, 1, 2)]
    al.JointFunction(axes, [al.joint.Box((1, 1, 1), (9, 9, 9))]).save(tmp_path / "three.toml")
    assert cli.main(["render", volume_file, "-o", out, "--tf", str(tmp_path / "three.toml")]) == cli.USAGE_ERROR
    assert "transfer.axes[2] is channel 2; the volume has 2 channels, 0 to 1 (in, out)" in capsys.readouterr().err
    al.save(al.Volume(np.zeros((4, 4, 4), dtype=np.uint8), modality="labels"), tmp_path / "flat.nrrd")
    assert cli.main(["render", str(tmp_path / "flat.nrrd"), "-o", out, "--auto", "boundaries"]) == cli.USAGE_ERROR
    told = capsys.readouterr().err
    assert "--auto boundaries finds nothing: volume 'flat.nrrd' shows no boundary between materials" in told
    assert "threshold" not in told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.jpg"], "a.jpg is no PNG file"),
        (["-o", "absent/a.png"], "its folder is not there"),
        (["-o", "a.png", "--variables", "value,1,in,out"], "give one, two or three"),
        (
            ["-o", "a.png", "--variables", "value,secnd"],
            "the volume has 2 channels, 0 to 1 (in, out): use value, gradient, second or one of its channels",
        ),
        (["-o", "a.png", "--variables", "value,"], "--variables is 'value,'"),
        (["-o", "a.png", "--variables", "value,flair"], "flair"),
        (["-o", "a.png", "--bins", "1"], "bins is 1, must lie in [2, 4096]"),
        (["-o", "a.png", "--variables", "value,7"], "--variables is channel 7; the volume has 2 channels"),
    ],
)
def test_mistakes(
    words: list[str],
    message: str,
    volume_file: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["histogram", volume_file, *words]) == cli.USAGE_ERROR
    assert message in capsys.readouterr().err
    assert not list(tmp_path.glob("*.png"))


def test_joint_functions_are_drawn_and_kept_in_scenes(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    file, scene = tmp_path / "function.toml", tmp_path / "scene.toml"
    FUNCTION.save(file)
    words = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--tf", str(file), "--save-scene", str(scene)]
    assert cli.main(words) == 0
    assert drawn[0][0].layers[0].transfer == FUNCTION
    assert cli.main(["render", str(scene), "-o", str(tmp_path / "b.png")]) == 0
    assert drawn[1][0].layers[0].transfer == FUNCTION


@pytest.mark.parametrize(
    ("kind", "make"),
    [("boundaries", al.automatic.boundary_function), ("boundaries2d", al.automatic.boundary_joint_function)],
)
def test_functions_made_of_the_data(kind: str, make, tmp_path: Path, drawn: Drawn) -> None:
    z, y, x = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
    ball = al.Volume((200 / (1 + np.exp((np.sqrt(x * x + y * y + z * z) - 0.6) / 0.1))).astype(np.float32))
    al.save(ball, tmp_path / "ball.nrrd")
    words = ["render", str(tmp_path / "ball.nrrd"), "-o", str(tmp_path / "a.png"), "--auto", kind]
    assert cli.main(words) == 0
    assert drawn[0][0].layers[0].transfer == make(ball, depth=(0.12, 0.4, 1.2))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--auto", "boundaries", "--preset", "xray"], "--preset and --auto exclude each other"),
        (["--auto", "boundaries", "--integrate", "mip"], "--auto is for opacity, and projections show values"),
        (["--auto", "arches"], "arches"),
    ],
)
def test_functions_made_of_the_data_and_others(
    words: list[str], message: str, volume_file: str, tmp_path: Path, drawn: Drawn, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), *words]) == cli.USAGE_ERROR
    assert message in capsys.readouterr().err
    assert not drawn
