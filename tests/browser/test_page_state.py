"""Pages and their sessions: clips with handles, a reload, two clients, one that follows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from in_browser import picture_of, rested, session_of, until


@pytest.fixture(scope="module")
def page(open_page: Callable[..., Any]) -> Any:
    return open_page()


@pytest.fixture(scope="module")
def session(page: Any, showing: Any) -> Any:
    return session_of(showing)


def show(page: Any, title: str) -> Any:
    """Open one panel alone, and return it."""
    page.locator("details.panel").evaluate_all(
        "(all, title) => all.forEach(one => one.open = one.firstElementChild.textContent === title)", title
    )
    return page.locator("details.panel[open]")


def drag(page: Any, box: dict[str, float], dx: float, dy: float) -> None:
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx, y + dy, steps=5)
    page.mouse.up()


def test_a_clip_is_placed_dragged_and_undone(page: Any, session: Any) -> None:
    whole = picture_of(page)
    show(page, "Clips").get_by_role("button", name="Plane", exact=True).click()
    (clip,) = until(lambda: session.document.scene.clips or None)
    until(lambda: not np.array_equal(picture_of(page), whole))
    handle = page.get_by_role("slider", name="plane 1: direction")
    until(lambda: handle.bounding_box() and handle.bounding_box()["width"] > 0)
    drag(page, handle.bounding_box(), 70, 0)
    turned = until(lambda: session.document.scene.clips[0].normal != clip.normal and session.document.scene.clips[0])
    assert turned.point == clip.point
    rested(session)
    page.get_by_role("button", name="Undo").first.click()
    until(lambda: session.document.scene.clips == (clip,))  # one step for the whole drag
    show(page, "Clips").get_by_role("button", name="remove clip 1").click()
    until(lambda: not session.document.scene.clips)
    assert not page.faults


def test_a_wrong_number_is_refused_in_words_and_changes_nothing(page: Any, session: Any) -> None:
    before = session.document
    field = show(page, "Quality").get_by_role("spinbutton", name="step in voxel")
    field.fill("-3")
    field.press("Enter")
    words = page.get_by_text("render.step")
    words.first.wait_for(timeout=10_000)
    assert session.document == before


def test_a_reload_keeps_the_state(page: Any, session: Any, showing: Any) -> None:
    drag(page, page.locator(".stage").bounding_box(), 60, 20)
    density = ["scene", "layers", 0, "density"]
    session.receive({"type": "edit", "ops": [{"op": "set", "path": density, "value": 2.5}]})
    until(lambda: session.document.scene.layers[0].density == 2.5)
    camera, count = rested(session).document.camera, len(showing.viewer.sessions)
    page.reload()
    page.locator("details.panel").first.wait_for(state="attached")
    until(lambda: bool(picture_of(page).any()))
    assert len(showing.viewer.sessions) == count
    assert session.document.camera == camera
    assert session.document.scene.layers[0].density == 2.5
    assert page.get_by_role("button", name="Undo").first.is_enabled()


def test_each_client_has_a_view_and_may_follow(page: Any, session: Any, open_page: Callable[..., Any], showing: Any) -> None:
    other = open_page()
    theirs = session_of(showing)
    assert theirs is not session
    before = theirs.document.camera
    drag(page, page.locator(".stage").bounding_box(), -50, 30)
    until(lambda: session.document.camera != before)
    assert theirs.document.camera == before

    show(page, "Share").get_by_role("button", name="Let others follow").click()
    key = until(lambda: session.share_key or None)
    panel = show(other, "Share")
    panel.get_by_label("key of another view").fill(key)
    panel.get_by_role("button", name="Follow", exact=True).click()
    until(lambda: theirs.document.camera == session.document.camera)
    drag(page, page.locator(".stage").bounding_box(), 40, 0)
    until(lambda: theirs.document.camera == session.document.camera != before)
    panel.get_by_role("button", name="Stop following").click()
    until(lambda: theirs.leader is None)
    other.close()
