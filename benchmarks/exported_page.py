"""Size of an exported page of 128^3 voxels, and the time from navigation to its first picture in headless Chromium.

Needs playwright and Chromium, whose WebGPU is SwiftShader. The time is that of the page's own clock: from the start of
navigation to the first picture of the volume on the canvas. The browser is running.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, parsed, spread, table, write_json
from volumes import real_volume

import airlight as al

FLAGS = (
    "--no-sandbox",
    "--enable-unsafe-webgpu",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
)
WINDOW_PX = {"width": 1280, "height": 800}


def first_pictures(browser: Any, page: Path, repeats: int) -> np.ndarray[Any, Any]:
    """Milliseconds (n, 2) to the first picture, and to the full one at rest; the first run does not count."""
    rows = []
    for _ in range(repeats + 1):
        context = browser.new_context(viewport=WINDOW_PX)
        tab = context.new_page()
        tab.goto(page.as_uri(), wait_until="commit")
        tab.wait_for_selector("[data-drawn=full]", state="attached", timeout=120_000)
        full = tab.evaluate("performance.now()")
        rows.append((tab.evaluate("performance.getEntriesByName('first picture')[0].startTime"), full))
        context.close()
    return np.array(rows[1:])


def cube(n: int) -> al.Volume:
    """The head, resampled to n voxels a side."""
    volume = real_volume("ct_head")
    x, y, z = (np.rint(np.linspace(0, size - 1, n)).astype(int) for size in volume.size)
    values = volume.grid()[np.ix_(z, y, x)]
    return al.Volume(
        values, spacing=tuple(s * size / n for s, size in zip(volume.spacing, volume.size, strict=True)), units="mm"
    )


def main(argv: list[str] | None = None) -> int:
    parser = arguments(__doc__, "exported_page", repeats=5)
    options = parsed(parser, argv, repeats=1)
    from playwright.sync_api import sync_playwright

    n, rows, runs = (24 if options.quick else 128), [], {}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium") or shutil.which("google-chrome"), args=list(FLAGS)
        )
        volume = cube(n)
        for bits in (8, 16):
            told = al.export(volume, Path(folder) / f"head-{bits}.html", bits=bits)
            first, full = first_pictures(browser, told.path, options.repeats).T
            row: dict[str, Any] = {"bits": bits, "MB": told.bytes / 1e6, "error": told.error}
            row |= {"first picture ms": float(np.median(first)), "full ms": float(np.median(full))}
            rows.append(row)
            runs[bits] = {"first": spread(first), "full": spread(full)}
        browser.close()
    print(table(rows))
    write_json(options.out, {"voxels": n, "window_px": WINDOW_PX, "pages": rows, "runs": runs})
    return 0


if __name__ == "__main__":
    sys.exit(main())
