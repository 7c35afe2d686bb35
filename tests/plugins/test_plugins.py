"""A stage that is defined outside of the package works everywhere by its name, and nothing in the package knows it.

In processes of their own, since a registered stage stays registered.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
PLUGIN = HERE / "steepest.py"

PARITY = """
import sys
sys.path[:0] = [{here!r}, {rendering!r}]
import numpy as np, steepest, airlight as al
from airlight import reference
from scenes import SIZE, scene
for choice in ("steepest", steepest.Steepest(full=5.0)):
    drawn = scene(integrate=choice)
    image, truth = al.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.abs(image.rgba - truth.rgba).max() < 1e-3, np.abs(image.rgba - truth.rgba).max()
    assert image.rgba[..., 3].any()
assert "steepest_params" not in al.explain(drawn) and "uniforms.integrate.full" in al.explain(drawn)
try:
    steepest.Steepest(full=-1)
except al.ValueRangeError as error:
    assert str(error) == "integrate.steepest.full is -1, must lie in (0, inf)", error
else:
    raise AssertionError
"""


def airlight(*arguments: str) -> subprocess.CompletedProcess[str]:
    code = "import sys; from airlight.app.cli import main; sys.exit(main())"
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, timeout=120)


@pytest.fixture
def volume(tmp_path):
    np.save(tmp_path / "v.npy", np.random.default_rng(0).random((8, 9, 10), dtype=np.float32))
    return str(tmp_path / "v.npy")


def test_parity_of_a_stage_from_outside():
    code = PARITY.format(here=str(HERE), rendering=str(HERE.parent / "rendering"))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def test_command_line_knows_it_by_name(volume, tmp_path):
    out = tmp_path / "a.npy"
    done = airlight(
        "render", volume, "-o", str(out), "--size", "16x16", "--plugin", str(PLUGIN), "--integrate", "steepest:full=1"
    )
    assert done.returncode == 0, done.stderr
    assert np.load(out)[..., 3].any()


def test_command_line_tells_its_parameters():
    done = airlight("stages", "integrate", "--plugin", str(PLUGIN))
    assert done.returncode == 0, done.stderr
    assert "steepest" in done.stdout
    assert "rise that is shown as" in " ".join(done.stdout.split())


def test_without_the_plugin_the_name_is_unknown(volume, tmp_path):
    done = airlight("render", volume, "-o", str(tmp_path / "a.png"), "--integrate", "steepest")
    assert done.returncode == 2
    assert "steepest" in done.stderr
    assert "Traceback" not in done.stderr
    assert not os.path.exists(tmp_path / "a.png")


def test_nothing_in_the_package_names_it():
    package = HERE.parent.parent / "src" / "airlight"
    assert not any("steepest" in file.read_text() for file in package.rglob("*.py"))
