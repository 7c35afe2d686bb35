"""``airlight bench`` at tiny sizes: what it measures, writes and refuses."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import airlight as al
from airlight import api
from airlight.app import bench, cli
from airlight.benchmark import measure, peers, plots, suite

TINY = suite.Plan((24, 20), (12, 10), voxels=16, repeats=2, seconds=0.0)


def silent(what: str, done: int, total: int) -> None:
    pass


def test_turns_end_when_time_is_up_but_one_counts() -> None:
    now = [0.0]

    def job() -> None:
        now[0] += 4.0

    for seconds, counted in ((0.0, 1), (9.0, 2), (13.0, 3), (1e9, 5)):
        now[0] = 0.0
        found = measure.side_by_side({"a": job, "b": lambda: None}, 5, seconds=seconds, clock=lambda: now[0])
        assert [len(found[name].wall) for name in "ab"] == [counted, counted]


def test_each_scene_has_time_samples_and_error_at_each_step(renderer: al.Renderer) -> None:
    told: list[tuple[str, int, int]] = []
    adapter, rows = suite.measured(renderer, TINY, lambda *report: told.append(report))
    assert adapter["name"]
    assert told[0] == ("scenes", 0, 6)
    assert told[-1] == ("scenes", 6, 6)
    assert len(rows) == 30  # four scenes are drawn in two ways
    for row in rows:
        assert row["milliseconds"]["total"]["n"] == 1
        assert row["milliseconds"]["total"]["median"] > 0
        assert row["samples_a_pixel"] == pytest.approx(row["samples"] / 480)
    for name in ("bone, unlit", "cloud, nowhere empty", "shells, maximum"):
        coarse, _, fine = (row["error"]["rmse"] for row in rows if (row["scene"], row["renderer"]) == (name, suite.OURS))
        assert fine < coarse < 0.2


def test_the_scenes_show_something(renderer: al.Renderer) -> None:
    for case in suite.cases(24).values():
        assert (renderer.render(case.scene, (24, 24)).rgba[..., 3] > 0.1).mean() > 0.15


def test_a_scene_that_fails_does_not_take_the_others_with_it(renderer: al.Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = dataclasses.replace(
        suite.cases(8)["shells, maximum"].scene, camera=al.Camera.perspective(eye=(0, -1e9, 0), target=(0, 0, 0))
    )
    known = {"broken": suite.Case(broken), "whole": suite.cases(16)["shells, maximum"]}
    monkeypatch.setattr(suite, "cases", lambda voxels: known)
    adapter, rows = suite.measured(renderer, TINY, silent)
    assert "steps away" in rows[0]["failed"]
    assert [row["scene"] for row in rows[1:]] == ["whole"] * 3
    text = bench.report({"plan": vars(TINY), "adapter": adapter, "cores": 2, "rows": rows})
    assert "airlight, broken: camera is" in text
    assert text.count("| whole ") == 3
    monkeypatch.setattr(suite, "cases", lambda voxels: {"broken": suite.Case(broken)})
    with pytest.raises(al.ValueRangeError, match="steps away"):
        suite.measured(renderer, TINY, silent)


def test_tables_and_numbers_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if not api.devices():
        pytest.skip("no adapter answers")
    numbers, tables = tmp_path / "bench.json", tmp_path / "bench.md"
    options = ["--quick", "--size", "16", "--voxels", "16", "--seconds", "0", "--vtk", "no"]
    assert cli.main(["bench", *options, "-o", str(numbers), "-o", str(tables)]) == 0
    found = json.loads(numbers.read_text())
    assert found["plan"]["size_px"] == [16, 16]
    assert len(found["rows"]) == 30
    printed = capsys.readouterr().out
    assert tables.read_text() == printed
    assert printed.count("| head, lit ") == 6
    assert "psnr dB" in printed


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "bench.csv"], "has no ending that says what to write: use one of .json, .md, .png, .svg"),
        (["-o", "-"], "is where the tables go anyway"),
        (["-o", "nowhere/bench.json"], "its folder is not there"),
        (["--voxels", "4"], r"--voxels is 4, must lie in [8, 1024]"),
        (["--seconds", "-1"], r"--seconds is -1, must lie in [0, 3600]"),
        (["--size", "big"], "--size is 'big', must be WIDTHxHEIGHT"),
    ],
)
def test_slips_show_before_anything_is_measured(
    options: list[str], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def measures(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(bench, "run", measures)
    assert cli.main(["bench", *options]) == 2
    assert message in capsys.readouterr().err


def test_without_vtk_it_cannot_be_asked_for(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(bench, "vtk_is_there", lambda: False)
    assert cli.main(["bench", "--vtk", "yes"]) == 2
    assert "--vtk yes needs VTK: pip install vtk" in capsys.readouterr().err


def some_results() -> dict[str, Any]:
    def row(scene: str, renderer: str, step: float, rmse: float) -> dict[str, Any]:
        about = {"scene": scene, "renderer": renderer, "step": step}
        return about | {"milliseconds": {"total": {"median": 9 / step}}, "error": {"rmse": rmse}}

    rows = [row(scene, who, step, 0.01 * step**2) for scene in "abcd" for who in ("airlight", "VTK") for step in suite.STEPS]
    rows += [row("d", "exact", 1.0, 0.0), {"scene": "e", "renderer": "airlight", "failed": "is too large"}]
    return {"plan": vars(TINY), "adapter": {"name": "any"}, "cores": 2, "rows": rows}


@pytest.mark.parametrize("ending", [".png", ".svg"])
def test_plots_of_time_against_error(tmp_path: Path, ending: str) -> None:
    pytest.importorskip("matplotlib")
    target = tmp_path / f"bench{ending}"
    plots.write_plots(some_results(), target)
    if ending == ".png":
        picture = np.asarray(Image.open(target).convert("RGB"))
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 20
    else:
        text = target.read_text()
        assert all(f"<!-- {word} -->" in text for word in ("a", "d", "airlight", "VTK", "exact", "frame [ms]"))
        assert "<!-- e -->" not in text


def test_without_matplotlib_nothing_is_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.setattr(bench, "run", lambda *_: pytest.fail("measured"))
    assert cli.main(["bench", "-o", "bench.png"]) == 2
    assert 'plots need matplotlib: pip install "airlight[plots]"' in capsys.readouterr().err


def test_vtk_beside_it() -> None:
    pytest.importorskip("vtkmodules")
    rows = peers.vtk_rows(TINY)
    assert {row["renderer"] for row in rows} == {"VTK GPU mapper", "VTK CPU mapper"}
    assert len(rows) == 18
    assert all(0 < row["error"]["psnr_db"] < 100 for row in rows)


def test_a_renderer_that_ends_its_process_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "__name__", "airlight.benchmark.nothing")
    (row,) = peers.vtk_rows(TINY)
    assert "ended with code 1" in row["failed"]
