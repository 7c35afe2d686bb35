"""Screenshots of the viewer for the docs, docs/gallery/viewer, taken in Chromium; or of every panel, to look at.

Usage: ``screenshots.py [--only NAME ...]``, or ``screenshots.py --panels FOLDER``. Volumes are those of the data folder
(``AIRLIGHT_DATA``, else ``../shared/data``).
"""
# ruff: noqa: T201

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image as Pillow
from playwright.sync_api import Browser, Page, sync_playwright

import airlight as al

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "gallery" / "viewer"
DATA = Path(os.environ.get("AIRLIGHT_DATA", ROOT.parent / "shared" / "data"))
DESKTOP, PHONE = (1280, 800), (390, 844)
CHROMIUM = next((path for path in ("/usr/bin/chromium", "/usr/bin/google-chrome") if Path(path).exists()), None)
FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking")
SETTLED_MS = 4000


@dataclass(frozen=True)
class Shot:
    """A screenshot: of which volume, how large, which panels are open, and what is done before."""

    name: str
    file: str
    panels: tuple[str, ...] = ()
    size_px: tuple[int, int] = DESKTOP
    dark: bool = True
    act: Callable[[Page], None] = lambda page: None


def drag(page: Page, dx: float, dy: float) -> None:
    """Drag the middle of the picture by parts of its height."""
    box = page.locator(".stage").first.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx * box["height"], y + dy * box["height"], steps=8)
    page.mouse.up()


def with_panels(page: Page) -> None:
    """Show the panels, which a phone keeps closed at first."""
    page.get_by_role("button", name="Panels (P)").click()


def clipped(page: Page) -> None:
    """Put a plane through the volume."""
    drag(page, 0.25, 0.1)
    page.get_by_role("button", name="Plane", exact=True).click()


SHOTS = (
    Shot("overview", "ct_head.nrrd", ("Transfer function",), act=lambda page: drag(page, 0.2, 0.08)),
    Shot("clips", "ct_head.nrrd", ("Clips",), act=clipped),
    Shot("phone", "ct_head.nrrd", ("Transfer function",), size_px=PHONE, act=with_panels),
    Shot("light", "engine.nii.gz", ("Lights",), dark=False),
)


@contextmanager
def opened(browser: Browser, file: str, size_px: tuple[int, int], dark: bool) -> Iterator[Page]:
    """A page on a volume, once its picture has settled."""
    showing = al.view(DATA / file, browser=False, block=False)
    width, height = size_px
    look: Any = {"color_scheme": "dark" if dark else "light", "has_touch": width < 700}
    context = browser.new_context(viewport={"width": width, "height": height}, **look)
    page = context.new_page()
    page.on("pageerror", lambda error: print(f"{file}: {error}", file=sys.stderr))
    try:
        page.goto(showing.url)
        page.locator("details.panel").first.wait_for(state="attached", timeout=60_000)
        page.wait_for_timeout(SETTLED_MS)
        yield page
    finally:
        context.close()
        showing.close()


def only(page: Page, panels: tuple[str, ...]) -> None:
    """Open these panels and no other."""
    page.locator("details.panel").evaluate_all(
        "(all, titles) => all.forEach(one => one.open = titles.includes(one.firstElementChild.textContent))", list(panels)
    )


def taken(page: Page, path: Path) -> None:
    """Write what is seen. Few colours would band surfaces and take the hue of what is small."""
    page.wait_for_timeout(SETTLED_MS)
    picture = Pillow.open(io.BytesIO(page.screenshot())).convert("RGB")
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(path, optimize=True)
    print(f"{path} {path.stat().st_size // 1024} KB")


def every_panel(browser: Browser, folder: Path) -> None:
    """Each panel alone, large and small, dark and light."""
    for size, size_px in (("desktop", DESKTOP), ("phone", PHONE)):
        for scheme in ("dark", "light"):
            with opened(browser, "ct_head.nrrd", size_px, scheme == "dark") as page:
                taken(page, folder / f"{size}-{scheme}-at-first.png")
                if size_px == PHONE:
                    with_panels(page)
                found = page.locator("details.panel:not([hidden]) > summary").all_inner_texts()
                for title in map(str.strip, found):
                    only(page, (title,))
                    page.locator("details.panel[open]").first.scroll_into_view_if_needed()
                    taken(page, folder / f"{size}-{scheme}-{title.lower().replace(' ', '-')}.png")


def main(argv: list[str] | None = None) -> int:
    """Take what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", choices=[shot.name for shot in SHOTS])
    parser.add_argument("--panels", type=Path, metavar="FOLDER")
    options: Any = parser.parse_args(argv)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        if options.panels is not None:
            every_panel(browser, options.panels)
            return 0
        for shot in SHOTS:
            if options.only and shot.name not in options.only:
                continue
            with opened(browser, shot.file, shot.size_px, shot.dark) as page:
                only(page, shot.panels)
                shot.act(page)
                taken(page, FOLDER / f"{shot.name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
