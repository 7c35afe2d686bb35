"""The examples for notebooks, in JupyterLab and in marimo, in a browser."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from in_browser import picture_of, small_volume, until

import airlight as al

EXAMPLES = Path(__file__).parents[2] / "examples"
READY_MS = 60_000


@contextmanager
def served(folder: Path, port: int, *words: str) -> Iterator[None]:
    """A notebook server whose settings and files lie in a folder."""
    homes = {"HOME": folder, "XDG_CONFIG_HOME": folder, "JUPYTER_CONFIG_DIR": folder, "JUPYTER_DATA_DIR": folder}
    environment = os.environ | {name: str(path) for name, path in homes.items()}
    with (folder / "log.txt").open("w") as log:
        process = subprocess.Popen([sys.executable, "-m", *words], cwd=folder, env=environment, stdout=log, stderr=log)
        try:
            until(lambda: answers(port) or process.poll() is not None, READY_MS / 1000)
            yield
        finally:
            process.terminate()
            process.wait(20)


def answers(port: int) -> bool:
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def turned(page: Any) -> None:
    """Wait for the picture, drag it, and see it change."""
    canvas = page.locator("canvas.picture").first
    canvas.wait_for(timeout=READY_MS)
    before = until(lambda: picture if (picture := picture_of(page)).any() else None, 30)
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 80, box["y"] + 80)
    page.mouse.down()
    page.mouse.move(box["x"] + 160, box["y"] + 100, steps=4)
    page.mouse.up()
    until(lambda: not np.array_equal(picture_of(page), before))


@pytest.mark.skipif(find_spec("jupyterlab") is None, reason="needs jupyterlab")
def test_the_notebook_runs_in_jupyterlab(chromium: Any, tmp_path: Path) -> None:
    shutil.copy(EXAMPLES / "viewer.ipynb", tmp_path)
    port = free_port()
    words = ["jupyterlab", "--no-browser", "--allow-root", f"--port={port}", "--ServerApp.token=", "--ServerApp.password="]
    words += ["--LabApp.news_url=None", "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate"]
    with served(tmp_path, port, *words):
        page = chromium.new_page(viewport={"width": 1200, "height": 1000})
        page.goto(f"http://127.0.0.1:{port}/lab/tree/viewer.ipynb")
        page.get_by_text("| Idle").wait_for(timeout=READY_MS)
        page.get_by_text("Run", exact=True).first.click()
        page.get_by_text("Run All Cells", exact=True).click()
        turned(page)
        page.close()


@pytest.mark.skipif(find_spec("marimo") is None, reason="needs marimo")
def test_the_notebook_runs_in_marimo(chromium: Any, tmp_path: Path) -> None:
    shutil.copy(EXAMPLES / "viewer_marimo.py", tmp_path)
    port = free_port()
    with served(tmp_path, port, "marimo", "run", "viewer_marimo.py", "--headless", f"--port={port}", "--no-token"):
        page = chromium.new_page(viewport={"width": 1200, "height": 1000})
        page.goto(f"http://127.0.0.1:{port}/")
        turned(page)
        page.close()


def test_the_widget_gives_and_takes_scenes() -> None:
    pytest.importorskip("anywidget")
    from airlight.viewer.document import Document
    from airlight.viewer.notebook import widget
    from airlight.viewer.session import Viewer

    viewer = Viewer(Document(al.Scene(small_volume(), transfer=al.TransferFunction([(0, "black", 0), (100, "white", 1)]))))
    shown = widget(viewer)
    shown.scene = al.Scene(shown.scene.layers[0].volume, transfer=shown.scene.layers[0].transfer, density=2.0, camera="left")
    assert shown.scene.layers[0].density == 2.0
    assert shown.scene.camera.eye[0] > 100
    with pytest.raises(al.DataError, match="scene"):
        shown.scene = "head.nii.gz"
    viewer.close()
