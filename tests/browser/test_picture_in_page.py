"""The picture in a real browser: drags, keys and the cube turn it; habits outlive a reload."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from in_browser import picture_of, pixel_within, rested, session_of, until

from airlight.scene import VIEWS
from airlight.stages.camera import Orthographic


@pytest.fixture(scope="module")
def page(open_page: Any) -> Any:
    return open_page((760, 440), reduced_motion="reduce")


@pytest.fixture(scope="module")
def session(page: Any, showing: Any) -> Any:
    return session_of(showing)


def towards_eye(session: Any) -> np.ndarray[Any, Any]:
    return -session.camera.basis()[2]


def test_a_drag_turns_the_picture_and_the_wheel_comes_nearer(page: Any, session: Any) -> None:
    canvas, before, first = page.locator("canvas.picture"), session.camera, picture_of(page)
    box = canvas.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + box["height"] / 4, y, steps=4)
    page.mouse.up()
    # A quarter of the height is an eighth of a turn about what is up.
    until(lambda: abs(session.camera.basis()[0] @ before.basis()[0] - np.sqrt(0.5)) < 1e-3)
    assert session.camera.up == before.up
    until(lambda: not np.array_equal(picture_of(page), first))
    distance = np.linalg.norm(np.subtract(session.camera.eye, session.camera.target))
    page.mouse.wheel(0, -240)
    until(lambda: np.linalg.norm(np.subtract(session.camera.eye, session.camera.target)) < 0.9 * distance)


def test_two_fingers_come_nearer_and_turn_about_the_view(page: Any, session: Any) -> None:
    """Real touches of the browser, as a phone makes them."""
    box, wire = page.locator("canvas.picture").bounding_box(), page.context.new_cdp_session(page)
    middle, reach = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]), box["height"] / 6

    def touch(kind: str, apart: float = 0.0, angle_rad: float = 0.0) -> None:
        aside = apart * np.array([np.cos(angle_rad), np.sin(angle_rad)])
        places = [] if kind == "touchEnd" else [middle - aside, middle + aside]
        points = [{"x": float(x), "y": float(y), "id": n} for n, (x, y) in enumerate(places)]
        wire.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = rested(session).camera
    distance = np.linalg.norm(np.subtract(before.eye, before.target))
    touch("touchStart", reach)
    for n in range(1, 9):
        touch("touchMove", reach * (1 + n / 8))
    touch("touchEnd")
    until(lambda: np.linalg.norm(np.subtract(session.camera.eye, session.camera.target)) < 0.8 * distance)
    near = rested(session).camera
    assert np.allclose(near.basis(), before.basis(), atol=1e-6)
    touch("touchStart", reach)
    for n in range(1, 9):
        touch("touchMove", reach, n * np.pi / 16)
    touch("touchEnd")
    turned = rested(session).camera
    assert turned.basis()[0] @ near.basis()[0] < 0.6  # a quarter, without what fingers turn by chance
    assert np.allclose(turned.basis()[2], near.basis()[2], atol=1e-3)


def test_a_double_click_makes_the_view_turn_about_what_is_there(page: Any, session: Any) -> None:
    box = page.locator("canvas.picture").bounding_box()
    image = until(lambda: found if (found := session.stream.image).scene.camera == session.camera else None)
    column, row = pixel_within(image)
    scale = box["width"] / image.size[0]
    place = box["x"] + (column + 0.5) * scale, box["y"] + (row + 0.5) * scale
    there = image.pick(column, row).p_world
    page.mouse.dblclick(*place)
    until(lambda: np.linalg.norm(np.subtract(session.camera.target, there)) < 1.0, 20.0)


def test_keys_alone_turn_show_help_and_keep_a_bookmark(page: Any, session: Any) -> None:
    page.locator("canvas.picture").focus()
    page.keyboard.press("1")
    until(lambda: np.allclose(towards_eye(session), VIEWS["front"][0]))
    page.keyboard.press("ArrowRight", delay=50)
    until(lambda: not np.allclose(towards_eye(session), VIEWS["front"][0], atol=1e-2))
    page.keyboard.press("o")
    until(lambda: isinstance(session.camera, Orthographic))
    label = page.locator("canvas.picture")
    until(lambda: "parallel rays" in label.get_attribute("aria-label"))
    assert "from the front" in label.get_attribute("aria-label")
    page.keyboard.press("?")
    page.get_by_role("dialog", name="Gestures and keys").wait_for()
    page.keyboard.press("Escape")
    page.locator("canvas.picture").focus()
    page.keyboard.press("b")
    page.keyboard.press("t")
    until(lambda: session.habits.turning == "trackball")
    page.reload()
    trackball = page.get_by_role("button", name="Trackball")
    until(lambda: trackball.count() > 0 and trackball.get_attribute("aria-pressed") == "true")
    page.get_by_role("button", name="Bookmarks", exact=True).press("Enter")
    page.get_by_role("menuitem", name="View 1", exact=True).wait_for()
    page.keyboard.press("Escape")


def test_the_cube_looks_from_its_faces_and_corners(page: Any, session: Any) -> None:
    cube = page.locator("svg.cube")
    page.get_by_role("button", name="View from left").focus()
    page.keyboard.press("Enter")
    until(lambda: np.allclose(towards_eye(session), (1, 0, 0)))
    box = cube.bounding_box()
    # From the left, the upper right corner of the face is that towards anterior or posterior and superior.
    until(lambda: "the left" in (page.locator("canvas.picture").get_attribute("aria-label") or ""))
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] * 76 / 176
    page.mouse.click(middle[0] + 0.2 * box["width"], middle[1] - 0.2 * box["width"])
    until(lambda: np.allclose(np.abs(towards_eye(session)), np.sqrt(1 / 3)))
    assert towards_eye(session)[0] > 0
    assert towards_eye(session)[2] > 0
