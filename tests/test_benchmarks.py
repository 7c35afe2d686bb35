"""Benchmarks run, with tiny sizes; what they measure is not asserted."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import numpy as np
import pytest

import airlight as al

ROOT = Path(__file__).parent.parent


class Lent:
    """The renderer of all tests, which knows their programs already, in the place of a benchmark's own."""

    def __init__(self, renderer: al.Renderer) -> None:
        self.renderer = renderer

    def __enter__(self) -> al.Renderer:
        return self.renderer

    def __exit__(self, *_: object) -> None:
        pass


@pytest.fixture
def fresh_benchmark(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))
    return importlib.import_module


@pytest.fixture
def benchmark_named(fresh_benchmark, monkeypatch, renderer):
    monkeypatch.setattr(al, "Renderer", lambda *_, **__: Lent(renderer))
    return fresh_benchmark


def run(module, path) -> dict:
    with np.errstate(all="warn", under="ignore"):
        assert module.main(["--quick", "--out", str(path)]) == 0
    return json.loads(path.read_text())


def test_accuracy(benchmark_named, tmp_path):
    found = run(benchmark_named("accuracy"), tmp_path / "out.json")
    assert {"adapter", "versions", "cases"} <= set(found)
    assert all(case["same"]["max"] < 0.1 for case in found["cases"])


def test_orders(benchmark_named, tmp_path):
    found = run(benchmark_named("orders"), tmp_path / "out.json")
    spiky = found["cases"][0]["orders"]
    for rows in spiky.values():
        assert [row["step"] for row in rows] == [4, 2, 1, 0.5, 0.25]
        assert all(row["cpu_ms"]["median"] > 0 for row in rows)
    assert spiky["pre-integrated, plain"][2]["rmse"] < spiky["post-classified"][2]["rmse"]


def test_throughput(benchmark_named, tmp_path):
    found = run(benchmark_named("throughput"), tmp_path / "out.json")
    assert all(row["agrees"] for row in found["against_plainest"])
    samples = [row["samples"] for row in found["against_plainest"]]
    assert all(abs(s["airlight"] / s["plainest"] - 1) < 0.01 for s in samples)


def test_labels(benchmark_named, tmp_path):
    found = run(benchmark_named("labels"), tmp_path / "out.json")
    assert found["costs"]
    assert all(row["opacities differ by"] < 1e-4 and row["labels"] > 1 for row in found["costs"])


def test_gradients(benchmark_named, tmp_path):
    found = run(benchmark_named("gradients"), tmp_path / "out.json")
    ways = {row["way"]: row for row in found["ways"]}
    assert ways["central"]["rmse x255"] < 0.5
    assert ways["precomputed, float16"]["rmse x255"] < ways["quantised, dodecahedron 240"]["rmse x255"]
    sets = {row["set"]: row["mean deg"] for row in found["directions"]}
    assert sets["annealed 240"] < sets["spiral 240"] < sets["dodecahedron 240"]


def test_slabs(benchmark_named, tmp_path):
    found = run(benchmark_named("slabs"), tmp_path / "out.json")
    assert found["bars"]["slabs of the chosen stage are off by at most 1/512"]
    assert all(row["cut, error"] < 1e-3 for row in found["rows"])
    assert {row["stage"] for row in found["edits"]} == {"preintegrated", "preintegrated_exact"}


def test_surfaces(benchmark_named, tmp_path):
    found = run(benchmark_named("surfaces"), tmp_path / "out.json")
    assert {row["surfaces"] for row in found["rows"]} == {1, 10, 100}
    assert all(row["alpha_mean"] > 0 for row in found["rows"])


def test_filters(benchmark_named, tmp_path):
    found = run(benchmark_named("filters"), tmp_path / "out.json")
    assert all(row["picture error"] < 1e-3 and row["value error"] < 1e-3 for row in found["rows"] if row["filter"] != "nearest")
    spline = next(row for row in found["rows"] if row["filter"] == "B-spline, prefiltered")
    assert spline["response"]["0.1"] > 0.99


def test_cold_start(benchmark_named, tmp_path):
    found = run(benchmark_named("cold_start"), tmp_path / "out.json")
    assert found["programs"]["airlight"]["peak_bytes"]["median"] > 0
    assert found["imports_milliseconds"]["airlight"] > 0


def test_against_vtk(benchmark_named, tmp_path):
    pytest.importorskip("vtkmodules")
    found = run(benchmark_named("against_vtk"), tmp_path / "out.json")
    assert {row["renderer"] for row in found["rows"]} >= {"VTK GPU mapper", "airlight, pre-integrated"}
    assert all(row["same view"] for row in found["checks"] if "GPU" in row["renderer"])


def test_table(benchmark_named):
    rows = [{"a": "x", "b": 1.5, "c": True}, {"a": "long", "b": None, "c": False}]
    lines = benchmark_named("common").table(rows).splitlines()
    assert lines == ["| a    |   b |   c |", "|------|----:|----:|", "| x    | 1.5 | yes |", "| long |   - |  no |"]


def test_occlusion(benchmark_named, tmp_path):
    found = run(benchmark_named("occlusion"), tmp_path / "out.json")
    assert len(found["rows"]) == 3
    assert all(0 < row["mean"] < 1.5 for row in found["rows"])
    fewest, default = (next(row["error"] for row in found["rows"] if row["directions"] == n) for n in (16, 64))
    assert default < fewest < 0.1


def test_shaded(benchmark_named, tmp_path):
    found = run(benchmark_named("shaded"), tmp_path / "out.json")
    assert len(found["rows"]) == 2 * 2 * 7
    assert all(0 < float(row["rmse"]) < 0.2 for row in found["rows"])
    assert {row["times unlit"] for row in found["rows"] if row["lighting"] == "none"} == {1.0}


def test_shadow_volume(benchmark_named, tmp_path):
    found = run(benchmark_named("shadow_volume"), tmp_path / "out.json")
    error = {(row["by"], row["cells"]): row["rms"] for row in found["errors"] if row["bias"] != "a cell"}
    assert error["sweep", 32] < error["sweep", 16] < error["no shadows", None]
    assert {row["by"] for row in found["times"]} == {"sweep", "rays"}


def test_shadows(benchmark_named, tmp_path):
    found = run(benchmark_named("shadows"), tmp_path / "out.json")
    assert {row["light at [degrees]"] for row in found["ratios"]} == {20, 60, 120, 160}
    assert all(row["MB"] > 0 and row["ms"] > 0 for row in found["buffers"])


def test_environments(benchmark_named, tmp_path):
    found = run(benchmark_named("environments"), tmp_path / "out.json")
    assert found["furnace"] <= 1e-3
    assert all(row["max %"] < 20 for row in found["maps"])


def test_crossings(benchmark_named, tmp_path):
    found = run(benchmark_named("crossings"), tmp_path / "out.json")
    error = {(row["surfaces"], row["step"], row["refine"]): row["q75 x255"] for row in found["errors"]}
    assert error["alone", 5.0, "secant"] < 0.2 * error["alone", 5.0, "none"]
    assert {row["refine"] for row in found["times"]} == {"none", "bisection", "secant", "exact"}


def test_layers(benchmark_named, tmp_path):
    found = run(benchmark_named("layers"), tmp_path / "out.json")
    assert {row["layers"] for row in found["rows"]} == {"overlapping", "beside", "twice"}
    assert all(row["ms"] > 0 for row in found["rows"])


def test_clips(benchmark_named, tmp_path):
    found = run(benchmark_named("clips"), tmp_path / "out.json")
    assert [row["cutting"] for row in found["rows"]] == [0, 1, 20, 4, 5]
    assert found["rows"][0]["samples"] == pytest.approx(1, abs=0.01)
    assert all(row["samples"] < 1 for row in found["rows"][1:3])


def test_tolerance(benchmark_named, tmp_path):
    found = run(benchmark_named("tolerance"), tmp_path / "out.json")
    assert found["passed"]
    assert any(row["tolerance"] is None and row["true"] > 0.01 for row in found["rows"])


def test_skipping(benchmark_named, tmp_path):
    found = run(benchmark_named("skipping"), tmp_path / "out.json")
    assert all(row["apart x255"] <= 1 for row in found["scenes"])
    assert next(bar for bar in found["bars"] if bar["bar"] == "tree: steps a ray")["met"]


def test_tones(benchmark_named, tmp_path):
    rows = run(benchmark_named("tones"), tmp_path / "out.json")["rows"]
    assert [row["tone"] for row in rows] == 2 * ["linear", "reinhard", "reinhard_local", "filmic"]
    assert all((row["surround ms"] > 0) == (row["tone"] == "reinhard_local") for row in rows)


def test_proxies(benchmark_named, tmp_path):
    made = {row["geometry"]: row["made of it"] for row in run(benchmark_named("proxies"), tmp_path / "out.json")["rows"]}
    assert made["slices"] == made["slices by plain clipping"]


def test_slices(fresh_benchmark, tmp_path):
    found = run(fresh_benchmark("slices"), tmp_path / "out.json")
    drivers = {row["driver"]: row for row in found["drivers"]}
    assert all(row["rmse x255"] < 1 for row in drivers.values())
    assert drivers["object_slices"]["Msamples"] < drivers["interpolated_slices"]["Msamples"]
    held = {row["driver"]: row["MB"] for row in found["bytes"]}
    assert held["object_slices"] == 3 * held["stripes"] == 3 * held["march"]
    oblique = next(row for row in found["turning"] if row["degrees"] == 44.9)
    assert oblique["not corrected: opacity"] < 0.9 < oblique["corrected: opacity"]
    assert oblique["corrected: change x255"] > 2 * oblique["stripes: change x255"]


def test_viewer(benchmark_named, tmp_path):
    bars = {bar["what"]: bar["found"] for bar in run(benchmark_named("viewer"), tmp_path / "out.json")["bars"]}
    assert bars["errors"] == bars["four clients: errors"] == 0
    assert bars["four clients: came back to their state, of 3"] == 3
    assert bars["dragging: least scale"] >= 0.5
    assert bars["dragging: greatest step [voxels]"] <= 2
    assert bars["dragging: PSNR of a moving picture, least [dB]"] > 20


def test_the_quickest_driver_of_a_row_is_judged(fresh_benchmark):
    """Tones may cost the others more than a frame; slices are held to half of the rate."""
    rows = [
        {"driver": "march", "ms": 50, "frames/s": 20.0, "with tones": 12.0},
        {"driver": "slices", "ms": 100, "frames/s": 10.0, "with tones": 1.0},
    ]
    judged = fresh_benchmark("frame_rates").judged
    assert [(bar["driver"], bar["passes"]) for bar in judged(rows, 12.5)] == [("march", True)] * 2 + [("slices", True)]
    assert [bar["passes"] for bar in judged(rows, 13.5)] == [True, False, True]
    assert [bar["passes"] for bar in judged(rows, 21.0)] == [False, False, False]
