"""``airlight export``: options become a page, what changed is told, and what goes wrong is said before anything is written."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from fake_renderer import Drawn

from airlight.app import cli


def test_a_page_is_written_and_what_it_changed_is_told(
    volume_file: str, drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "ball.html"
    words = ["export", volume_file, "-o", str(page), "--voxels", "8", "--bits", "8", "--title", "A ball", "--camera", "left"]
    assert cli.main([*words, "--integrate", "mip", "--size", "40x30", "--step", "0.5"]) == 0
    told = capsys.readouterr().err
    assert re.search(r"note: the page holds 6 x 5 x 8 voxels, means of the volume's 16 x 14 x 12", told)
    assert re.search(r"note: values are stored in 8 bits, to within [\d.]+ HU", told)
    (scene, size, arguments) = drawn[0]
    assert (size, arguments["step"]) == ((40, 30), 0.5)
    text = page.read_text(encoding="utf-8")
    data = json.loads(re.findall(r'id="page">(.*?)</script>', text)[0])
    assert "<h1>A ball</h1>" in text
    assert data["camera"]["eye"] == list(scene.camera.eye)
    assert data["size_px"] == [40, 30]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "page.txt"], "let it end in .html"),
        (["-o", "-"], "a page is a file"),
        (["-o", "page.html", "--voxels", "many"], "whole number or all"),
        (["-o", "page.html", "--tolerance", "0.01"], "--tolerance is given"),
        (["-o", "page.html", "--budget", "50"], "--budget is given"),
        (["-o", "page.html", "--stereo"], "camera 'stereo'"),
        (["-o", "page.html", "--driver", "slices"], "driver 'slices'"),
        (["-o", "page.html", "--scale-bar"], "scene.annotations"),
    ],
)
def test_what_is_refused(
    words: list[str],
    said: str,
    volume_file: str,
    drawn: Drawn,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["export", volume_file, *words]) == cli.USAGE_ERROR
    assert said in capsys.readouterr().err
    assert not list(tmp_path.glob("page*"))
