"""The served page: nothing that its policy forbids, files that are dropped and saved, links from elsewhere."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from in_browser import picture_of, until
from PIL import Image as Pillow

import airlight as al


@pytest.fixture(scope="module")
def page(open_page: Callable[..., Any]) -> Any:
    found = open_page((900, 700), accept_downloads=True)
    found.said = []
    found.on("console", lambda message: found.said.append(message.text))
    for panel in found.locator("details.panel").all():
        if panel.get_attribute("open") is None:
            panel.locator("summary").first.click()
    return found


def test_all_panels_open_under_the_strict_policy(page: Any) -> None:
    page.wait_for_timeout(300)
    assert not [text for text in page.said if "Security Policy" in text or "Refused" in text]
    assert page.evaluate("document.cookie") == "", "scripts do not see the token"
    assert "token" not in page.url


def test_what_is_seen_becomes_a_file(page: Any) -> None:
    with page.expect_download(timeout=30_000) as coming:
        page.get_by_role("button", name="Save picture").click()
    assert coming.value.suggested_filename == "picture.png"
    saved = np.asarray(Pillow.open(io.BytesIO(Path(coming.value.path()).read_bytes())))
    size_px = page.evaluate("[document.querySelector('.picture').width, document.querySelector('.picture').height]")
    assert saved.shape[1::-1] == tuple(size_px)
    assert saved.any()
    with page.expect_download(timeout=30_000) as coming:
        page.get_by_role("button", name="Python", exact=True).click()
    assert "al.Scene(" in Path(coming.value.path()).read_text()


def test_a_dropped_file_opens_and_undo_brings_back(page: Any, tmp_path: Path) -> None:
    z, y, x = np.mgrid[-1:1:12j, -1:1:12j, -1:1:12j]
    al.save(al.Volume(((x * x + y * y + z * z) < 0.6).astype(np.uint8) * 200), tmp_path / "dropped.nrrd")
    data = list((tmp_path / "dropped.nrrd").read_bytes())
    before = picture_of(page)
    handed = page.evaluate_handle(
        "bytes => { const all = new DataTransfer();"
        "all.items.add(new File([new Uint8Array(bytes)], 'dropped.nrrd')); return all; }",
        data,
    )
    page.dispatch_event(".airlight", "dragenter", {"dataTransfer": handed})
    assert page.get_by_text("Add as a layer", exact=True).is_visible()
    page.dispatch_event(".airlight", "drop", {"dataTransfer": handed})
    until(lambda: not np.array_equal(picture_of(page), before))
    page.get_by_role("button", name="Undo (Ctrl+Z)").click()


def test_a_link_on_another_site_leads_in(chromium: Any, showing: Any) -> None:
    """Strict cookies are kept back from the redirect that sets them: the page asks again itself."""
    context = chromium.new_context()
    page = context.new_page()
    page.goto(f"data:text/html,<a href='{showing.url}'>look</a>")
    page.get_by_text("look").click()
    page.locator(".airlight").wait_for(timeout=20_000)
    context.close()
