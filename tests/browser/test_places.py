"""Widgets on the joint histogram, the probe and the slices, driven in a real browser."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from in_browser import pixel_within, rested, session_of, until

import airlight as al


@pytest.fixture(scope="module")
def page(open_page: Callable[..., Any]) -> Any:
    return open_page((960, 560))


def panel(page: Any, title: str) -> Any:
    """The panel of a title, alone open."""
    page.evaluate(
        "title => { for (const d of document.querySelectorAll('details.panel')) "
        "d.open = d.querySelector('summary').textContent === title; }",
        title,
    )
    return page.locator("details.panel[open]")


def test_a_widget_changes_the_function_and_the_picture(page: Any, showing: Any) -> None:
    session = session_of(showing)
    first = session.document.scene.layers[0].transfer
    shown = panel(page, "Joint function")
    until(lambda: page.evaluate("document.querySelector('.joint-counts').width === 256"))
    picture = "document.querySelector('canvas.picture').toDataURL()"
    before = page.evaluate(picture)
    shown.get_by_role("button", name="Add a box").click()
    until(lambda: isinstance(session.document.scene.layers[0].transfer, al.JointFunction))
    until(lambda: page.evaluate(picture) != before)
    (box,) = session.document.scene.layers[0].transfer.shapes
    # A corner is dragged in steps, which are one step of undo.
    steps = len(session._history.past)
    corner = page.get_by_role("slider", name="box 1: corner, high and high")
    corner.scroll_into_view_if_needed()
    at = corner.locator(".joint-dot").bounding_box()
    x, y = at["x"] + at["width"] / 2, at["y"] + at["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for n in range(1, 6):
        page.mouse.move(x + 6 * n, y - 4 * n)
    page.mouse.up()
    until(lambda: session.document.scene.layers[0].transfer.shapes[0].high[0] > box.high[0])
    until(lambda: len(session._history.past) == steps + 1)
    moved = session.document.scene.layers[0].transfer.shapes[0]
    assert moved.low == box.low
    assert moved.high[1] > box.high[1]
    # The keyboard does it, too, and says so.
    widget = page.get_by_role("slider", name="box 1 of 1")
    told = widget.get_attribute("aria-valuetext")
    widget.press("ArrowLeft")
    until(lambda: session.document.scene.layers[0].transfer.shapes[0].low[0] < box.low[0])
    assert widget.get_attribute("aria-valuetext") != told
    # Back to the function of one variable that was.
    shown.get_by_label("the layer is drawn by a function of").select_option("plain")
    until(lambda: session.document.scene.layers[0].transfer == first)


def test_the_probe_reads_what_the_volume_holds_and_makes_a_widget(page: Any, showing: Any) -> None:
    shown = panel(page, "Probe")
    session = rested(session_of(showing))

    def whole_picture() -> Any:
        image = session.stream.image
        return image if image.scene == session.document.scene and image.size == tuple(session.size_px) else None

    image = until(whole_picture)
    column, row = pixel_within(image)
    canvas = page.locator("canvas.picture").bounding_box()
    x, y = canvas["x"] + column + 0.5, canvas["y"] + row + 0.5
    page.mouse.move(x - 1, y)
    page.mouse.move(x, y)
    expected = float(image.scene.layers[0].volume.value_at(image.pick(column, row).p_world))
    words = page.locator(".probe-readout")
    until(lambda: words.is_visible() and float(words.inner_text()) == pytest.approx(expected, rel=0.02))
    # A pin, its profile, and a distance between two clicks at one place.
    shown.get_by_role("radio", name="Probe").click()
    page.mouse.click(x, y)
    until(lambda: len(session.document.scene.annotations) == 1)
    page.locator(".profile-plot").wait_for()
    shown.get_by_role("radio", name="Distance").click()
    camera = session.document.camera
    page.mouse.dblclick(x, y)
    page.get_by_text("Distance 1:").wait_for()
    assert rested(session).document.camera == camera  # it turns about a point only where no tool is chosen
    shown.get_by_role("radio", name="Turn").click()
    page.locator("canvas.picture").focus()
    page.keyboard.press("a")
    # The joint function is the one that was, with a widget more, which holds what is there.
    made = until(lambda: found if len(found := getattr(session.document.scene.layers[0].transfer, "shapes", ())) == 2 else None)
    low, high = made[1].bounds(np.array([axis.span for axis in session.document.scene.layers[0].transfer.axes]))[0]
    assert low < expected < high


def test_slices_show_beside_the_volume_and_move_together(page: Any, showing: Any) -> None:
    shown = panel(page, "Slices")
    shown.get_by_role("radio", name="Volume and slices").click()
    pictures = "Array.from(document.querySelectorAll('.slice:not([hidden]) canvas'), c => c.width > 50 ? c.toDataURL() : '')"
    before = until(lambda: found if len(found := page.evaluate(pictures)) == 3 and all(found) else None)
    first = page.locator(".slice-face").first
    first.focus()
    for _ in range(3):
        page.keyboard.press("PageUp")
    until(lambda: page.evaluate(pictures)[0] != before[0])
    place = first.bounding_box()
    page.mouse.click(place["x"] + 0.4 * place["width"], place["y"] + 0.45 * place["height"])
    until(lambda: all(new != old for new, old in zip(page.evaluate(pictures)[1:], before[1:], strict=True)))
    # A corner is cut away at the cross-hair: one clip, and a step of undo for each drag, which the box to tick follows.
    session = session_of(showing)
    box = shown.get_by_label("the volume is cut at the cross-hair")
    steps = len(session._history.past)
    box.check()
    until(lambda: len(session._history.past) == steps + 1)
    for part in (0.45, 0.6):
        clips = session.document.scene.clips
        page.mouse.move(place["x"] + part * place["width"], place["y"] + 0.45 * place["height"])
        page.mouse.down()
        for n in range(8):
            page.mouse.move(place["x"] + (part + 0.01 * n) * place["width"], place["y"] + 0.45 * place["height"])
        page.mouse.up()
        until(lambda clips=clips: session.document.scene.clips != clips)
        rested(session)
    assert len(session._history.past) == steps + 3
    assert len(session.document.scene.clips) == 1
    for _ in range(3):
        session.receive({"type": "undo"})
    until(lambda: not session.document.scene.clips and not box.is_checked())
    shown.get_by_role("radio", name="Volume", exact=True).click()
