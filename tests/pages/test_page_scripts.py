"""The page's JavaScript under node: its own tests, and what it makes of functions and cameras beside what Python does."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import airlight as al
from airlight.pages.carried import carried
from airlight.pages.stored import store
from airlight.shader.layout import Struct
from airlight.stage import make_stage
from airlight.transfer.cells import even_cells, function_texels, piece_texels
from airlight.transfer.tables import segment_rows

HERE = Path(__file__).parent / "js"
NODE = shutil.which("node")
ENTRIES = 64

pytestmark = pytest.mark.skipif(NODE is None, reason="needs node")


def run(*words: str, text: str = "") -> str:
    assert NODE is not None
    done = subprocess.run([NODE, "--no-warnings", *words], input=text, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_pure_functions() -> None:
    run("--test", str(HERE / "page.test.mjs"))


def functions() -> list[al.TransferFunction]:
    """Steps, one value, empty stretches, uneven and even points, sources without extinction, and random ones."""
    white = (1.0, 1.0, 1.0)
    chosen = [
        al.TransferFunction([(0, white, 0.0), (10, (0.5, 0.2, 0.1), 0.3), (10, white, 0.0), (77.7, white, 2.0)]),
        al.TransferFunction([(5, white, 1.0)]),
        al.TransferFunction([(-3.5, white, 0.0), (-1, white, 0.0), (0, white, 0.7), (1.2, white, 0.0), (9, white, 0.0)]),
        al.TransferFunction([(0, white, 0.0), (1, (0.1, 0.2, 0.3), 1.0)]),
        al.TransferFunction([(0, (0, 0, 0), 0.0), (0.3, (2, 1, 0), 0.0), (2, white, 0.5), (2, white, 1.5)], associated=True),
    ]
    rng = np.random.default_rng(5)
    for count in (2, 3, 7, 40):
        values = np.sort(rng.uniform(-1000, 3000, count))
        extinctions = rng.uniform(0, 2, count) * (rng.uniform(size=count) > 0.3)
        chosen.append(
            al.TransferFunction([(v, tuple(rng.uniform(0, 1, 3)), e) for v, e in zip(values, extinctions, strict=True)])
        )
    return chosen


def page_of(function: al.TransferFunction, camera: Any, transfer: str, origin: float = 0.0) -> tuple[Any, dict[str, Any]]:
    axis = np.linspace(-1, 1, 8)
    blob = (2000 * np.exp(-(axis[:, None, None] ** 2) - axis[:, None] ** 2 - axis**2)).astype(np.float32)
    volume = al.Volume(blob, spacing=(1, 1, 1.5), origin=(origin, 0, 0))
    scene = al.Scene(volume, transfer=function, camera=camera, look=al.Look(transfer=transfer))
    stored = store(scene.layers[0], None, None, lambda *_: None)
    scene = replace(scene, layers=(replace(scene.layers[0], volume=stored.volume),))
    found = carried(scene, stored, (40, 30), make_stage("driver", "march"), 1.0)
    return found, found.plain


def test_what_scripts_make_is_what_python_makes() -> None:
    known = functions()
    cameras = [
        al.Camera.perspective(eye=(20, -30, 9), target=(3, 4, 5), up=(0, 0.3, 1), fov_deg=40),
        al.Camera.orthographic(eye=(-200, -300, 9), target=(3, 4, 5), height=12),
    ]
    far = al.Camera.perspective(eye=(1e5 + 20, -30, 9), target=(1e5 + 3, 4, 5))
    pages = [
        page_of(known[0], cameras[0], "preintegrated_fast"),
        page_of(known[2], cameras[1], "postclassified"),
        page_of(known[-1], far, "preintegrated_exact", origin=1e5),
        page_of(known[-2], cameras[1], "preintegrated"),
    ]
    rng = np.random.default_rng(7)
    texels = [rng.integers(0, 256, (3, 4, 5)).astype(np.uint8), rng.normal(size=(2, 5, 3)).astype(np.float16)]
    stored = [replace(pages[0][0].stored, texels=one) for one in texels]
    told = json.loads(
        run(
            str(HERE / "told.mjs"),
            text=json.dumps(
                {
                    "functions": [
                        {"points": [[v, list(c), e] for v, c, e in f.points], "associated": f.associated} for f in known
                    ],
                    "entries": ENTRIES,
                    "pages": [{"page": plain, "sizePx": [40, 30]} for _, plain in pages],
                    "volumes": [
                        {"bytes": base64.b64encode(one.packed()).decode(), "size": one.texels.shape[::-1], "bits": one.bits}
                        for one in stored
                    ],
                }
            ),
        )
    )
    for function, made in zip(known, told["functions"], strict=True):
        assert_rows(made["pieces"], piece_texels(function))
        assert_rows(made["segments"], segment_rows(function, ENTRIES))
        if not even_cells(function):  # which the page does without
            assert_rows(made["cells"], function_texels(function))
    for (page, _), made in zip(pages, told["packed"], strict=True):
        dtype = page.program.uniforms.dtype
        mine, its = (np.frombuffer(data, dtype) for data in (page.uniform_bytes(), bytes.fromhex(made)))
        for member in page.program.uniforms.members:
            assert_members(mine[member.name], its[member.name], member.struct, member.name)
    for one, made in zip(texels, told["volumes"], strict=True):
        assert made == one.tobytes().hex()


def assert_rows(made: str, wanted: np.ndarray[Any, Any]) -> None:
    its = np.frombuffer(bytes.fromhex(made), np.float32).reshape(-1, 4)
    np.testing.assert_allclose(its, wanted.reshape(-1, 4), rtol=1e-6, atol=1e-6)


def assert_members(mine: Any, its: Any, struct: Struct | None, where: str) -> None:
    assert struct is not None
    for member in struct.members:
        # Cells of a function for any edit are not equally wide, and 32 bits of sums of 32 bits are the smaller part.
        if member.name in ("even_cells", "empty_integral_low"):
            continue
        np.testing.assert_allclose(its[member.name], mine[member.name], rtol=2e-6, atol=1e-6, err_msg=f"{where}.{member.name}")
