"""The editor of transfer functions in a browser: a point that is dragged, and all of it by keys alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from in_browser import session_of, until

DRAG_PX = 60
DIGEST = """c => {
  const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
  return data.reduce((sum, byte) => (31 * sum + byte) % 1000003, 0);
}"""


@pytest.fixture(scope="module")
def editor(open_page: Callable[..., Any]) -> Any:
    return open_page((700, 600))


def digest(page: Any) -> int:
    """One number for the picture that a page shows."""
    return int(page.locator("canvas.picture").evaluate(DIGEST))


def layer(showing: Any) -> Any:
    return session_of(showing).document.scene.layers[0]


def test_a_dragged_point_changes_state_and_picture(editor: Any, showing: Any) -> None:
    handles = editor.locator(".tf-handle")
    until(lambda: handles.count() == len(layer(showing).transfer.points))
    before, seen = layer(showing).transfer, digest(editor)
    place = int(np.argmax(before.extinctions))
    handle = handles.nth(place)
    box, words_before = handle.bounding_box(), handle.get_attribute("aria-valuetext")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    editor.mouse.move(x, y)
    editor.mouse.down()
    for n in range(1, 7):
        editor.mouse.move(x, y + n * DRAG_PX / 6)
    editor.mouse.up()

    def is_told() -> bool:
        extinction = layer(showing).transfer.points[place][2]
        words = f"extinction {float(f'{extinction:.3g}'):g} per mm"
        return extinction < 0.6 * before.points[place][2] and words in handle.get_attribute("aria-valuetext")

    until(is_told)  # what the page shows is what the session has, the last move too
    after = layer(showing).transfer
    assert after.values[place] == before.values[place]  # only its height was dragged
    assert [p for n, p in enumerate(after.points) if n != place] == [p for n, p in enumerate(before.points) if n != place]
    until(lambda: digest(editor) != seen)
    session_of(showing).receive({"type": "undo"})
    assert layer(showing).transfer == before  # one step for the whole drag
    until(lambda: handle.get_attribute("aria-valuetext") == words_before)


def test_points_and_presets_by_click_and_by_keys_alone(editor: Any, showing: Any) -> None:
    handles, before = editor.locator(".tf-handle"), layer(showing).transfer
    editor.get_by_role("button", name="Add a point").focus()
    editor.keyboard.press("Enter")
    until(lambda: len(layer(showing).transfer.points) == len(before.points) + 1)
    editor.keyboard.press("ArrowUp")
    editor.keyboard.press("Shift+ArrowRight")
    until(lambda: len(set(layer(showing).transfer.points) - set(before.points)) == 1)
    until(lambda: handles.count() == len(before.points) + 1)
    editor.keyboard.press("Delete")
    until(lambda: layer(showing).transfer.points == before.points)
    assert editor.evaluate("document.activeElement.getAttribute('role')") == "slider"

    presets = editor.locator(".tf-preset")
    preset = presets.filter(has_text="microscopy ice")
    preset.focus()
    editor.keyboard.press("Enter")
    until(lambda: layer(showing).transfer.colours[-1].min() > 0.9 and layer(showing).transfer != before)
    by_keys = layer(showing).transfer
    presets.filter(has_text="glow gray").click()
    until(lambda: layer(showing).transfer != by_keys)
    # Pictures come once nothing moves.
    drawn = "c => c.getContext('2d').getImageData(0, 0, 96, 96).data.some(n => n > 60 && n < 255)"
    until(lambda: presets.first.locator("canvas").evaluate(drawn))
