"""The command line: what reaches the renderer, what comes out, and how errors end it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_renderer import Drawn

from airlight import api
from airlight.app import cli
from airlight.app.info import histogram_lines, orientation
from airlight.scene import Camera
from airlight.scene_file import load_scene
from airlight.stage import STAGES, stage_fields
from airlight.stages.driver import March
from airlight.stages.shade import BlinnPhong
from airlight.transfer import TransferFunction, presets
from airlight.volume import Volume

PLUGIN = '''
from dataclasses import dataclass
from typing import ClassVar
from airlight.stage import F32, Stage, param, register

@register
@dataclass(frozen=True)
class Glow(Stage):
    """Everything glows."""

    slot: ClassVar[str] = "shade"
    name: ClassVar[str] = "test_glow"
    wgsl: ClassVar[str] = "shade/none.wgsl"
    strength: F32 = param(1.0, at_least=0, help="how much it glows")
'''


@pytest.fixture
def plugin(tmp_path: Path) -> Any:
    path = tmp_path / "glow.py"
    path.write_text(PLUGIN)
    yield str(path)
    STAGES["shade"].pop("test_glow", None)
    sys.modules.pop("airlight_plugin_glow", None)


def fails(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert cli.main(words) == cli.USAGE_ERROR
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert "Traceback" not in err
    return err


# -- render


def test_a_first_picture(volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "out.png")]) == 0
    (scene, size, arguments), *others = drawn
    assert (size, arguments, others) == ((512, 512), {"device": None}, [])
    assert scene.layers[0].volume.size == (16, 14, 12)
    assert (tmp_path / "out.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().err == (
        "note: this is channel 0 of 2; --channel N draws another, --channels all draws all in one\n"
    )
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "out.png"), "--channel", "0"]) == 0
    assert capsys.readouterr() == ("", "")


def test_several_channels(volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["render", volume_file, "-o", str(tmp_path / "out.png")]
    assert cli.main([*words, "--channels", "all", "--save-scene", str(tmp_path / "scene.toml")]) == 0
    assert cli.main([*words, "--channels", "out=#ff0000, 0"]) == 0
    assert cli.main(["render", str(tmp_path / "scene.toml"), *words[2:]]) == 0
    assert cli.main(["render", str(tmp_path / "scene.toml"), *words[2:], "--channels", "in"]) == 0
    assert capsys.readouterr().err == ""
    mixtures = [scene.layers[0].transfer for scene, _, _ in drawn]
    assert [[part.channel for part in m.parts] for m in mixtures] == [[0, 1], ["out", 0], [0, 1], ["in"]]
    assert mixtures[2] == mixtures[0]
    red, other = mixtures[1].functions
    assert not red.colours[:, 1:].any()
    assert other.colours.any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--channels", "0=grn"], "--channels 0 is 'grn': use a CSS name"),
        (["--channels", "0="], "--channels is '0=', must be all, or CHANNEL=COLOUR"),
        (["--channels", "0,,1"], "--channels is '0,,1', must be"),
        (["--channels", "0,0=red"], "--channels names 0 twice"),
        (["--channels", "gone"], "channel 'gone' is unknown: choose one of in, out"),
        (["--channels", "all", "--channel", "1"], "--channels and --channel exclude each other"),
        (["--channels", "all", "--preset", "mri"], "--preset and --channels exclude each other"),
    ],
)
def test_channels_that_are_wrong(
    options: list[str], message: str, volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "out.png"), *options]) == 2
    assert message in capsys.readouterr().err
    assert not drawn


def test_all_options_reach_the_renderer(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    words = ["render", volume_file, "-o", str(tmp_path / "out.npy"), "--size", "64x48", "--tf", "0:black:0 9:white:1"]
    words += ["--shade", "blinn_phong:ambient=0.5", "--transfer", "postclassified", "--field", "nearest", "--gradient", "sobel"]
    words += ["--integrate", "first_hit:iso=5", "--tone", "reinhard", "--lighting", "sampled", "--visibility", "none"]
    words += [
        "--camera",
        "-1,-9,1,0,0,0",
        "--background",
        "none",
        "--step",
        "0.5",
        "--skip",
        "none",
        "--offsets",
        "interleaved",
    ]
    words += ["--channel", "out", "--time", "0", "--device", "software", "--max-memory", "1G"]
    assert cli.main(words) == 0
    scene, size, arguments = drawn[0]
    layer = scene.layers[0]
    assert size == (64, 48)
    assert arguments == {"device": "software", "step": 0.5, "skip": "none", "driver": March(offsets="interleaved")}
    assert layer.transfer == TransferFunction([(0, "black", 0), (9, "white", 1)])
    assert layer.look.shade == BlinnPhong(ambient=0.5)
    assert (layer.look.field.name, layer.look.gradient.name, layer.look.tone.name) == ("nearest", "sobel", "reinhard")
    assert (layer.channel, layer.time) == ("out", 0)
    assert scene.camera == Camera.perspective(eye=(-1, -9, 1), target=(0, 0, 0))
    assert scene.background is None


def test_orthographic_views_show_the_same(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), "--camera", "iso", "--orthographic"]) == 0
    camera = drawn[0][0].camera
    assert isinstance(camera, Camera)
    assert camera.name == "orthographic"
    right, up, _ = camera.basis()
    corners = drawn[0][0].layers[0].volume.corners_world() - np.asarray(camera.target)
    assert max(np.abs(corners @ right).max(), np.abs(corners @ up).max()) <= camera.height / 2  # type: ignore[attr-defined]


def test_presets_and_projections(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    for name in presets.names():
        assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), "--preset", name]) == 0
    assert len({scene.layers[0].transfer for scene, _, _ in drawn}) == len(presets.names())
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), "--integrate", "mip", "--channel", "1"]) == 0
    function = drawn[-1][0].layers[0].transfer
    assert function is not None
    assert function.colours.tolist() == [[0, 0, 0], [1, 1, 1]]


def test_scenes_are_saved_and_rendered_again(volume_file: str, drawn: Drawn, tmp_path: Path) -> None:
    scene_file = str(tmp_path / "scene.toml")
    words = ["--camera", "iso", "--size", "32x16", "--step", "2", "--offsets", "interleaved", "--save-scene", scene_file]
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), *words]) == 0
    assert load_scene(scene_file)[0] == drawn[0][0]
    assert cli.main(["render", scene_file, "-o", str(tmp_path / "a.png")]) == 0
    assert drawn[1] == drawn[0]
    assert cli.main(["render", scene_file, "-o", str(tmp_path / "a.png"), "--size", "8", "--shade", "none", "--step", "1"]) == 0
    scene, size, arguments = drawn[2]
    assert (size, arguments["step"], scene.layers[0].look.shade.name) == ((8, 8), 1.0, "none")
    assert scene.layers[0].look.tone == drawn[0][0].layers[0].look.tone


def test_raw_files(drawn: Drawn, tmp_path: Path) -> None:
    path = tmp_path / "a.raw"
    np.arange(24, dtype=">u2").tofile(path)
    words = ["--shape", "2x3x4", "--dtype", "uint16", "--spacing", "1,2,3", "--big-endian"]
    assert cli.main(["render", str(path), "-o", str(tmp_path / "a.png"), *words]) == 0
    volume = drawn[0][0].layers[0].volume
    assert volume.array.ravel().tolist() == list(range(24))
    assert (volume.size, volume.spacing) == ((2, 3, 4), (1.0, 2.0, 3.0))


def test_statistics(volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--channel", "0"]
    assert cli.main([*words, "--stats"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert json.loads(err)["samples"] == 3
    assert cli.main([*words, "--stats", str(tmp_path / "stats.json")]) == 0
    assert json.loads((tmp_path / "stats.json").read_text())["samples"] == 3
    assert cli.main(["render", "--stats", *words[1:]]) == 0
    assert json.loads(capsys.readouterr().err)["samples"] == 3


# -- errors


def test_files_of_light_and_dithered_ones(
    volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    picture, light = str(tmp_path / "a.png"), str(tmp_path / "a.exr")
    assert cli.main(["render", volume_file, "-o", picture, "--dither", "--tone", "reinhard_local:radius=0.1"]) == 0
    assert cli.main(["render", volume_file, "-o", light, "--half"]) == 0
    assert (drawn[0][0].layers[0].look.tone.name, len(drawn)) == ("reinhard_local", 2)
    capsys.readouterr()
    assert "dither is for 8 bits" in fails(capsys, "render", volume_file, "-o", light, "--dither")
    assert "half is for .exr files alone" in fails(capsys, "render", volume_file, "-o", picture, "--half")
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    assert 'pip install "airlight[exr]"' in fails(capsys, "render", volume_file, "-o", light)
    assert len(drawn) == 2  # nothing is drawn that could not be written


def test_errors_are_one_message(volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "a.png")
    assert "nothing.nrrd does not exist" in fails(capsys, "render", str(tmp_path / "nothing.nrrd"), "-o", out)
    assert "use one of .png, .exr, .npy" in fails(capsys, "render", volume_file, "-o", str(tmp_path / "a.bmp"))
    assert "folder is not there" in fails(capsys, "render", volume_file, "-o", str(tmp_path / "no" / "a.png"))
    assert "requires an argument" in fails(capsys, "render", volume_file)
    assert "--shade is 'x'" in fails(capsys, "render", volume_file, "-o", out, "--shade", "x")
    assert "exclude each other" in fails(capsys, "render", volume_file, "-o", out, "--tf", "0:red:1", "--preset", "xray")
    assert "preset is 'x'" in fails(capsys, "render", volume_file, "-o", out, "--preset", "x")
    assert "--step" in fails(capsys, "render", volume_file, "-o", out, "--step", "fast")
    assert "--step is -1.0" in fails(capsys, "render", volume_file, "-o", out, "--step=-1")
    assert "--skip" in fails(capsys, "render", volume_file, "-o", out, "--skip", "all")
    assert "Unknown option" in fails(capsys, "render", volume_file, "-o", out, "--colour", "red")
    assert "channel" in fails(capsys, "render", volume_file, "-o", out, "--channel", "7")
    assert "frobnicate" in fails(capsys, "frobnicate")
    assert drawn == []
    assert not list(tmp_path.glob("*.png"))


def test_scene_files_do_not_take_reading_options(volume_file: str, drawn: Drawn, tmp_path: Path, capsys: Any) -> None:
    scene_file = str(tmp_path / "scene.toml")
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), "--channel", "0", "--save-scene", scene_file]) == 0
    with open(scene_file, "a", encoding="utf-8") as file:
        file.write("tolerance = 0.5\n")
    assert cli.main(["render", scene_file, "-o", str(tmp_path / "b.png")]) == 0
    assert drawn[-1][2]["tolerance"] == 0.5
    assert cli.main(["render", scene_file, "-o", str(tmp_path / "b.png"), "--budget", "40"]) == 0
    assert (drawn[-1][2].get("tolerance"), drawn[-1][2]["budget_ms"]) == (None, 40.0)
    again = str(tmp_path / "again.toml")
    assert cli.main(["render", scene_file, "-o", str(tmp_path / "b.png"), "--tolerance", "0.01", "--save-scene", again]) == 0
    assert load_scene(again)[1]["tolerance"] == 0.01
    assert "--big-endian tells how" in fails(capsys, "render", scene_file, "-o", str(tmp_path / "b.png"), "--big-endian")


def test_debug_shows_where(tmp_path: Path, drawn: Drawn) -> None:
    with pytest.raises(OSError, match="does not exist"):
        cli.main(["render", str(tmp_path / "nothing.nrrd"), "-o", str(tmp_path / "a.png"), "--debug"])


def test_interruption(volume_file: str, tmp_path: Path, drawn: Drawn, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(api, "render", interrupted)
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png")]) == cli.INTERRUPTED
    assert not (tmp_path / "a.png").exists()


def test_a_reader_that_goes_away() -> None:
    command = f"{sys.executable} -m airlight.app.cli stages | true; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode in (0, cli.BROKEN_PIPE)


# -- plugins


def test_plugins_add_stages(volume_file: str, drawn: Drawn, plugin: str, tmp_path: Path, capsys: Any) -> None:
    words = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--shade", "test_glow:strength=2"]
    assert "must be one of" in fails(capsys, *words)
    assert cli.main([*words, "--plugin", plugin, f"--plugin={plugin}"]) == 0
    assert drawn[0][0].layers[0].look.shade.strength == 2.0  # type: ignore[attr-defined]
    assert cli.main(["stages", "shade", "--plugin", plugin]) == 0
    assert "how much it glows" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "is not there"),
        ("1/0", "failed with ZeroDivisionError"),
        ("import nothing_at_all", "failed with|needs the module"),
    ],
)
def test_wrong_plugins(content: str | None, message: str, tmp_path: Path, capsys: Any) -> None:
    import re

    path = tmp_path / "broken.py"
    if content is not None:
        path.write_text(content)
    assert re.search(message, fails(capsys, "stages", "--plugin", str(path)))
    assert "airlight_plugin_broken" not in sys.modules
    assert "no module" in fails(capsys, "stages", "--plugin", "no_such_module_at_all")


# -- other commands


def test_info(volume_file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["info", volume_file]) == 0
    out = capsys.readouterr().out
    for words in ("16 x 14 x 12", "1, 1, 2", "mm", "channel 1: out", "HU", "log scale", "█"):
        assert words in out
    assert cli.main(["info", volume_file, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["dimensions"] == [16, 14, 12]
    assert [c["name"] for c in facts["channels"]] == ["in", "out"]


def test_info_without_unicode(volume_file: str) -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "airlight.app.cli", "info", volume_file]
    done = subprocess.run(command, capture_output=True, check=True, env=environment)
    assert b"#" in done.stdout


def test_histograms() -> None:
    lines = histogram_lines([0, 1, 10, 1000], width=4, rows=2)
    assert len(lines) == 2
    assert [line[0] for line in lines] == [" ", " "]
    assert [line[3] for line in lines] == ["█", "█"]
    assert lines[1][1] in "▁▂▃"
    assert histogram_lines([0, 0], width=4, rows=1) == ["  "]


def test_orientation() -> None:
    array = np.zeros((2, 2, 2))
    assert orientation(Volume(array, anatomical=True)).startswith("LPS (")
    flipped = Volume(array, world_from_index=np.diag([-1.0, 1, 1, 1]))
    assert orientation(flipped) == "-x +y +z (not anatomical), left-handed"
    sheared = np.eye(4)
    sheared[0, 2] = 0.5
    assert orientation(Volume(array, world_from_index=sheared)).endswith("up to 26.6 degrees oblique, sheared")


def test_stages_lists_every_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["stages"]) == 0
    out = capsys.readouterr().out
    for slot, known in STAGES.items():
        assert f"{slot}: " in out
        for cls in known.values():
            assert cls.name in out
            assert all(f.name in out for f in stage_fields(cls))


def test_devices(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(api, "devices", list)
    assert "apt-get install mesa-vulkan-drivers" in fails(capsys, "devices")


@pytest.mark.parametrize("command", ["", *cli.COMMANDS])
def test_help_names_examples(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*command.split(), "--help"]) == 0
    out = capsys.readouterr().out
    assert "Usage: airlight" in out
    assert command in ("devices",) or "For instance" in out


def test_help_of_render_lists_stages(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["render", "--help"]) == 0
    out = capsys.readouterr().out
    for name in STAGES["integrate"]:
        assert name in out


def test_nothing_heavy_is_imported_early() -> None:
    heavy = "('rich', 'wgpu', 'nibabel', 'PIL.Image', 'scipy')"
    code = f"import sys, airlight.app.render; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# -- end to end


def test_a_picture_to_standard_output(volume_file: str) -> None:
    if not api.devices():
        pytest.skip("no adapter answers")
    command = [sys.executable, "-m", "airlight.app.cli", "render", volume_file, "-o", "-", "--size", "32", "--stats"]
    done = subprocess.run(command, capture_output=True, check=True)
    assert done.stdout.startswith(b"\x89PNG")
    assert json.loads(done.stderr)["samples"] > 0


def test_explain(volume_file: str, capsys: pytest.CaptureFixture[str]) -> None:
    if not api.devices():
        pytest.skip("no adapter answers")
    assert cli.main(["explain", volume_file, "--shade", "none"]) == 0
    assert "fn main" in capsys.readouterr().out


def test_demo(tmp_path: Path, capsys: pytest.CaptureFixture[str], drawn: Drawn) -> None:
    path = tmp_path / "demo.png"
    assert cli.main(["demo", "--sample", "marschner-lobb", "-o", str(path), "--size", "16"]) == 0
    out = capsys.readouterr().out
    assert str(path) in out
    assert "licence" in out
    assert path.exists()
