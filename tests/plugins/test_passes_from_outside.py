"""Passes over finished pictures in files of their own, as a stranger uses them; nothing in the package knows them.

In processes of their own where that matters, since a registered stage stays registered.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from test_plugins import airlight

import airlight as al
from airlight.app import cli
from airlight.app.parse import parse_stage
from airlight.app.plugin import load_plugins
from airlight.stage import STAGES

ROOT = Path(__file__).parents[2]
EDGES, BLUR = (str(ROOT / "examples" / f"{name}.py") for name in ("edge_overlay", "depth_of_field"))


@pytest.fixture
def ball(tmp_path):
    z, y, x = np.mgrid[-1:1:24j, -1:1:24j, -1:1:24j]
    np.save(tmp_path / "ball.npy", (100 * np.exp(-3 * (x * x + y * y + z * z))).astype(np.float32))
    return str(tmp_path / "ball.npy")


def drawn(ball: str, out: Path, *options: str) -> np.ndarray:
    done = airlight("render", ball, "-o", str(out), "--size", "48x40", *options)
    assert done.returncode == 0, done.stderr
    return np.load(out)


def test_as_a_stranger_uses_them(ball, tmp_path, capsys):
    """A file given, a name chosen, a scene saved and drawn again: it names the pass, not the file it came from."""
    look = ("--tf", "30:black:0 40:white:3", "--shade", "none")
    scene, out = tmp_path / "scene.toml", tmp_path / "plain.npy"
    own = ("--plugin", EDGES, "--pass", "edge_overlay:bend=0.5", "--save-scene", str(scene))
    assert cli.main(["render", ball, "-o", str(out), "--size", "48x40", *look]) == 0
    plain, inked = np.load(out), drawn(ball, tmp_path / "inked.npy", *look, *own)
    ink = (inked[..., :3].max(axis=-1) < 0.05) & (inked[..., 3] == 1)
    assert 40 < ink.sum() < 200  # a ring round the ball
    assert (inked[~ink] == plain[~ink]).mean() > 0.8
    assert "edge_overlay" in scene.read_text()
    assert ".py" not in scene.read_text()
    assert (drawn(str(scene), tmp_path / "again.npy", "--plugin", EDGES) == inked).all()
    assert cli.main(["render", str(scene), "-o", str(tmp_path / "refused.npy")]) == 2
    told = capsys.readouterr().err
    assert "edge_overlay" in told
    assert "--plugin" in told
    assert "Traceback" not in told


@pytest.fixture
def known():
    """Both passes, in this process; forgotten afterwards."""
    before = dict(STAGES["passes"])
    load_plugins([EDGES, BLUR])
    yield STAGES["passes"]
    STAGES["passes"].clear()
    STAGES["passes"].update(before)
    for name in ("edge_overlay", "depth_of_field"):
        sys.modules.pop(f"airlight_plugin_{name}", None)


def test_blur_by_depth(known, ball):
    """In focus nothing changes; off the focus light spreads, and none is lost."""
    camera = al.Camera.orthographic(eye=(11.5, -500, 11.5), target=(11.5, 11.5, 11.5), height=40)
    function = al.TransferFunction([(30, "black", 0), (40, "white", 3)])
    scene = al.Scene(al.open(ball), transfer=function, camera=camera, look=al.Look(shade="none"))
    blur = known["depth_of_field"]
    plain, sharp, soft = (
        al.render(scene, (48, 40), passes=passes).rgba[..., 3]
        for passes in ((), [blur(aperture=0.0)], [blur(focus=1000.0, aperture=4.0)])
    )
    assert np.abs(sharp - plain).max() < 1e-6
    assert plain.sum() == pytest.approx(soft.sum(), rel=0.05)
    assert ((soft > 0.1) & (soft < 0.9)).sum() > 2 * ((plain > 0.1) & (plain < 0.9)).sum()


def test_help_and_parameters_follow_from_the_class(known):
    done = airlight("stages", "passes", "--plugin", EDGES)
    assert done.returncode == 0, done.stderr
    assert "edge_overlay" in done.stdout
    assert "bounding_box" in done.stdout
    with pytest.raises(al.ValueRangeError, match=r"passes.edge_overlay.bend is 0.0, must lie in \(0, inf\)"):
        parse_stage("passes", "edge_overlay:bend=0", "pass")
    with pytest.raises(
        al.ValueRangeError, match="--pass is 'edges', must be one of bounding_box, depth_of_field, edge_overlay"
    ):
        parse_stage("passes", "edges", "pass")


def test_nothing_in_the_package_names_them():
    package = ROOT / "src" / "airlight"
    files = [file for kind in ("*.py", "*.wgsl") for file in package.rglob(kind)]
    assert not any(name in file.read_text() for file in files for name in ("edge_overlay", "depth_of_field"))
