"""An exported page in Chromium: its picture beside the one drawn here, turned and edited, without WebGPU, after a loss."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

import airlight as al
from airlight.pages.stored import store

SIZE_PX = (240, 160)  # of the still picture
WINDOW_PX = {"width": 240, "height": 420}
WITHIN = 3
POINTS = [(150.0, (0.9, 0.3, 0.1), 0.0), (400.0, (1.0, 0.6, 0.2), 0.15), (401.0, (0.1, 0.2, 0.9), 0.4), (900.0, (1, 1, 1), 2.0)]
CATCH_DEVICE = """
  window.devices = [];
  const request = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function (...given) {
    const device = await request.apply(this, given);
    window.devices.push(device);
    return device;
  };
"""


@pytest.fixture(scope="module")
def scene() -> al.Scene:
    """The stored volume of the page, lit and pre-integrated; no symmetry hides a turn."""
    z, y, x = np.mgrid[-1:1:24j, -1:1:28j, -1:1:32j]
    values = 1000 * np.exp(-2 * (x**2 + 2 * y**2 + z**2)) + 500 * np.exp(-20 * ((x - 0.6) ** 2 + (z - 0.5) ** 2))
    volume = al.Volume(values.astype(np.float32), spacing=(1, 1, 1.2), origin=(5, -3, 2), units="mm", value_unit="HU")
    camera = al.Camera.perspective(eye=(70, -60, 40), target=(20, 10, 16), fov_deg=32)
    whole = al.Scene(volume, transfer=al.TransferFunction(POINTS), camera=camera, background=(0.02, 0.03, 0.05))
    stored = store(whole.layers[0], None, None, lambda *_: None)
    return replace(whole, layers=(replace(whole.layers[0], volume=stored.volume),))


@pytest.fixture(scope="module")
def file(scene: al.Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return al.export(scene, tmp_path_factory.mktemp("page") / "page.html", size=SIZE_PX, title="A blob").path


@pytest.fixture
def opened(webgpu: Any, file: Path) -> Iterator[Callable[..., Any]]:
    """Opens the page, with a script before its own; nothing may be said on the console."""
    said: list[str] = []
    context = webgpu.new_context(viewport=WINDOW_PX)

    def open_page(script: str = "") -> Any:
        page = context.new_page()
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        if script:
            page.add_init_script(script)
        page.goto(file.as_uri(), wait_until="commit")
        return page

    yield open_page
    context.close()
    assert not said


def finished(page: Any) -> np.ndarray[Any, Any]:
    """The canvas at rest, int (h, w, 3)."""
    page.wait_for_selector("[data-drawn=full]", state="attached")
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    shot = Pillow.open(io.BytesIO(page.locator("#canvas").screenshot()))
    return np.asarray(shot.convert("RGB")).astype(int)


def changed(page: Any, act: Callable[[], None]) -> np.ndarray[Any, Any]:
    """The canvas at rest after something was done."""
    act()
    return finished(page)


def drawn_here(scene: al.Scene, picture: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The same view, drawn here: as wide as the still picture, or as high, whichever needs more room."""
    height, width = picture.shape[:2]
    camera: Any = scene.camera
    room = max(1.0, SIZE_PX[0] / SIZE_PX[1] / (width / height))
    fov_deg = math.degrees(2 * math.atan(room * math.tan(math.radians(camera.fov_deg) / 2)))
    image = al.render(replace(scene, camera=replace(camera, fov_deg=fov_deg)), (width, height))
    return image.picture()[..., :3].astype(int)


def test_the_page_draws_what_is_drawn_here_turned_and_edited(opened: Callable[..., Any], scene: al.Scene) -> None:
    page = opened()
    first = finished(page)
    assert page.locator("#still").is_hidden()
    assert first.max() > 100
    assert np.abs(first - drawn_here(scene, first)).max() <= WITHIN

    height = page.locator("#canvas").bounding_box()["height"]
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + 60, box["y"] + 30

    def drag() -> None:
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 40, y, steps=4)
        page.mouse.up()

    turned = changed(page, drag)
    camera: Any = scene.camera
    way = np.subtract(camera.eye, camera.target)
    angle = -math.pi * 40 / height
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    there = replace(scene, camera=replace(camera, eye=tuple(camera.target + turn @ way)))
    assert np.abs(turned - first).max() > 30
    assert np.abs(turned - drawn_here(there, turned)).max() <= WITHIN

    def move() -> None:
        page.locator("[data-point='1']").focus()
        page.get_by_label("Extinction of the point").fill("0.9")
        page.get_by_label("Extinction of the point").press("Enter")

    edited = changed(page, move)
    layer = scene.layers[0]
    points = [p if n != 1 else (p[0], p[1], 0.9) for n, p in enumerate(POINTS)]
    other = replace(there, layers=(replace(layer, transfer=al.TransferFunction(points)),))
    assert np.abs(edited - turned).max() > 30
    assert np.abs(edited - drawn_here(other, edited)).max() <= WITHIN

    reset = changed(page, lambda: (page.locator(".tools").get_by_text("Reset").click(), page.locator("#canvas").press("Home")))
    assert (reset == first).all()


def test_points_are_moved_by_pointer_and_keys_alone(opened: Callable[..., Any]) -> None:
    page = opened()
    first = finished(page)
    point = page.locator("[data-point='3']")
    box = point.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

    def drag() -> None:
        page.mouse.down()
        page.mouse.move(box["x"] - 40, box["y"] + 20, steps=3)
        page.mouse.up()

    dragged = changed(page, drag)
    assert np.abs(dragged - first).max() > 3
    assert float(point.get_attribute("aria-valuenow")) < 900
    before = float(point.get_attribute("aria-valuenow"))
    changed(page, lambda: point.press("ArrowRight"))
    assert float(point.get_attribute("aria-valuenow")) > before
    assert "HU, extinction" in point.get_attribute("aria-valuetext")
    assert page.evaluate("() => document.activeElement.dataset.point") == "3"
    changed(page, lambda: point.press("Delete"))
    assert page.locator("circle").count() == 3
    changed(page, lambda: page.get_by_text("Add point").click())
    assert page.locator("circle").count() == 4


def test_without_webgpu_there_are_words_and_a_picture(opened: Callable[..., Any]) -> None:
    page = opened("delete Navigator.prototype.gpu;")
    page.wait_for_selector("[data-drawn=still]", state="attached")
    assert "no WebGPU" in page.locator("[role=status]").inner_text()
    assert page.locator("#canvas").is_hidden()
    assert page.locator("#still").is_visible()
    assert page.locator("#still").evaluate("(still) => still.naturalWidth") == SIZE_PX[0]
    assert page.locator(".editor").count() == 0


def test_a_lost_device_is_replaced_once(opened: Callable[..., Any]) -> None:
    page = opened(CATCH_DEVICE)
    first = finished(page)
    turned = changed(page, lambda: page.locator("#canvas").press("ArrowLeft"))
    page.evaluate("() => { document.documentElement.dataset.drawn = ''; window.devices[0].destroy(); }")
    again = finished(page)
    assert np.abs(turned - first).max() > 3
    assert (again == turned).all()
    page.evaluate("() => window.devices[1].destroy()")
    page.wait_for_selector("[data-drawn=still]", state="attached")
    assert "was lost" in page.locator("[role=status]").inner_text()
