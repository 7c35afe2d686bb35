"""A native window: events of rendercanvas become gestures of a session, its pictures come back; without a display."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import airlight as al
from airlight.viewer.document import Document
from airlight.viewer.gestures import moving, turning
from airlight.viewer.session import Viewer
from airlight.viewer.window import Window, help_text, key_name

offscreen = pytest.importorskip("rendercanvas.offscreen")
SIZE = (60, 40)


class Later:
    """A loop whose calls wait until they are made."""

    def __init__(self) -> None:
        self.calls: list[Callable[[], Any]] = []

    def call_later(self, delay: float, callback: Callable[[], Any]) -> None:
        self.calls.append(callback)

    def call_soon_threadsafe(self, callback: Callable[[], Any]) -> None:
        self.calls.append(callback)

    def run(self) -> None:
        calls, self.calls = self.calls, []
        for call in calls:
            call()


@pytest.fixture(scope="module")
def joined(renderer: al.Renderer) -> Iterator[tuple[Window, Any, Later]]:
    volume = al.Volume(np.linspace(0, 1, 8**3, dtype=np.float32).reshape(8, 8, 8))
    function = al.TransferFunction([(0, "black", 0.1), (1, "orange", 2)])
    camera = al.Camera.perspective(eye=(3.5, -20, 3.5), target=(3.5, 3.5, 3.5))
    scene = al.Scene(volume, transfer=function, camera=camera, look=al.Look(shade="none"))
    viewer = Viewer(Document(scene, tolerance=None), "ramp", renderer)
    loop, canvas = Later(), offscreen.RenderCanvas(size=SIZE)
    window = Window(viewer, canvas, loop)
    yield window, canvas, loop
    window.close()
    viewer.close()
    canvas.close()


def happened(canvas: Any, *events: dict[str, Any]) -> None:
    for event in events:
        canvas.submit_event({"modifiers": (), "x": 0.0, "y": 0.0, "buttons": (), **event})
        canvas._process_events()  # what its scheduler would do


def drag(dx: float, dy: float, button: int = 1, modifiers: tuple[str, ...] = ()) -> list[dict[str, Any]]:
    more = {"modifiers": modifiers, "button": button}
    return [
        {"event_type": "pointer_down", "x": 30.0, "y": 20.0, **more},
        {"event_type": "pointer_move", "x": 30.0 + dx, "y": 20.0 + dy, **more},
        {"event_type": "pointer_up", "x": 30.0 + dx, "y": 20.0 + dy, **more},
    ]


def key(name: str, *modifiers: str) -> list[dict[str, Any]]:
    return [{"event_type": kind, "key": name, "modifiers": modifiers} for kind in ("key_down", "key_up")]


def test_pointers_and_wheels_make_the_gestures_of_the_page(joined: Any) -> None:
    window, canvas, _ = joined
    camera = window.session.camera
    happened(canvas, *drag(4, 2))
    expected = turning.turntable(camera, 0.1, 0.05)
    np.testing.assert_allclose(window.session.camera.eye, expected.eye)
    happened(canvas, *drag(4, 2, button=1, modifiers=("Shift",)), *drag(0, 2, button=2))
    expected = moving.dolly(moving.pan(expected, 0.1, 0.05), 0.05, None, 12, 30)
    np.testing.assert_allclose(window.session.camera.eye, expected.eye)
    happened(canvas, {"event_type": "wheel", "dx": 0.0, "dy": -100.0, "x": 30.0, "y": 20.0})
    np.testing.assert_allclose(window.session.camera.eye, moving.dolly(expected, -0.06, None, 12, 30).eye)
    happened(canvas, {"event_type": "pointer_move", "x": 50.0, "y": 30.0})  # with nothing pressed
    np.testing.assert_allclose(window.session.camera.eye, moving.dolly(expected, -0.06, None, 12, 30).eye)
    happened(canvas, *drag(8, 0, modifiers=("Control",)))
    low, high = window.session.document.scene.layers[0].transfer.domain
    assert high - low > 1.2
    happened(canvas, *key("z", "Control"))
    assert window.session.document.scene.layers[0].transfer.domain == (0, 1)


def test_keys_that_are_held_go_on_until_they_are_released(joined: Any) -> None:
    window, canvas, loop = joined
    happened(canvas, *key("Home"), *key("f"))
    assert window.session.habits.turning == "fly"
    press, release = key("W", "Shift")
    happened(canvas, press)
    eyes = [window.session.camera.eye[1]]
    for _ in range(3):
        time.sleep(0.01)
        loop.run()
        eyes.append(window.session.camera.eye[1])
    assert all(np.diff(eyes) > 0)
    happened(canvas, release)
    loop.run()
    loop.run()
    assert window.session.camera.eye[1] == eyes[-1]
    happened(canvas, *key("f"))
    assert window.session.habits.turning == "turntable"


def test_pictures_come_to_the_window_as_they_were_drawn(joined: Any, renderer: al.Renderer) -> None:
    window, canvas, loop = joined

    def shown() -> bool:
        loop.run()
        scene = window.session.document.scene
        expected = renderer.render(scene, SIZE).picture()[..., :3].astype(int)
        found = canvas.draw()[..., :3].astype(int)
        return found.shape == expected.shape and np.abs(found - expected).max() <= 1

    deadline = time.monotonic() + 20
    while not shown():
        assert time.monotonic() < deadline
        time.sleep(0.1)
    happened(canvas, *key("/", "Shift"))
    assert canvas.draw()[..., :3].max() == 255
    happened(canvas, *key("Escape"))
    canvas.set_physical_size(30, 20)
    canvas._process_events()
    assert window.session.size_px == (30, 20)


def test_names_of_keys_are_those_of_the_table() -> None:
    assert key_name({"key": "=", "modifiers": ()}) == "+"
    assert key_name({"key": "/", "modifiers": ("Shift",)}) == "?"
    assert key_name({"key": "W", "modifiers": ("Shift",)}) == "w"
    assert "ArrowLeft" not in help_text()
    assert "double click:  turn about" in help_text()
