"""A real browser, and the viewer in it: Debian's Chromium without a window."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from in_browser import picture_of, small_volume, until

import airlight as al

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
# For pages that draw by WebGPU themselves, in software.
WEBGPU = (
    *(flag for flag in FLAGS if flag != "--disable-gpu"),
    "--enable-unsafe-webgpu",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
)


@pytest.fixture(scope="module")
def launch() -> Iterator[Callable[..., Any]]:
    """Launch Chromium with flags; it ends with the module, since a running Playwright holds the thread's event loop."""
    if CHROMIUM is None:
        pytest.skip("needs Chromium")
    api = pytest.importorskip("playwright.sync_api")
    with api.sync_playwright() as playwright:
        started: list[Any] = []

        def launched(flags: tuple[str, ...] = FLAGS) -> Any:
            started.append(playwright.chromium.launch(executable_path=CHROMIUM, args=list(flags)))
            return started[-1]

        yield launched
        for browser in started:
            browser.close()


@pytest.fixture(scope="module")
def chromium(launch: Callable[..., Any]) -> Any:
    """Chromium."""
    return launch()


@pytest.fixture(scope="module")
def webgpu(launch: Callable[..., Any]) -> Any:
    """Chromium in which pages draw by WebGPU."""
    return launch(WEBGPU)


@pytest.fixture(scope="module")
def showing() -> Iterator[Any]:
    """The viewer, serving a small volume."""
    pytest.importorskip("starlette")
    pytest.importorskip("uvicorn")
    found = al.view(small_volume(), browser=False, block=False)
    yield found
    found.close()


@pytest.fixture(scope="module")
def open_page(chromium: Any, showing: Any) -> Iterator[Callable[..., Any]]:
    """Open a page on the viewer that nobody else has, once its first picture is there; page errors fail the test."""
    contexts = []

    def opened(size_px: tuple[int, int] = (700, 500), **options: Any) -> Any:
        contexts.append(chromium.new_context(viewport={"width": size_px[0], "height": size_px[1]}, **options))
        page = contexts[-1].new_page()
        page.faults = []
        page.on("pageerror", lambda error: page.faults.append(str(error)))
        page.goto(showing.url)
        page.locator("details.panel").first.wait_for(state="attached", timeout=30_000)
        until(lambda: bool(picture_of(page).any()))
        return page

    yield opened
    faults = [fault for context in contexts for page in context.pages for fault in page.faults]
    for context in contexts:
        context.close()
    assert not faults
