"""From the start of ``airlight view`` to the first painted frame, in a browser that is already running.

    python benchmarks/viewer_start.py ct_head.nrrd

It needs playwright and Chromium; the machine should be quiet.
"""

from __future__ import annotations

import argparse
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

FLAGS = "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-sync"
PAINTED = "document.querySelector('canvas.picture')?.width > 300"  # a canvas without a picture has 300
LOADED = "performance.getEntriesByType('navigation')[0].loadEventEnd"


def start_ms(page: object, path: str) -> dict[str, float]:
    """Milliseconds from the start of the process to its address and to the first frame, and of the page itself."""
    begun = time.perf_counter()
    command = [str(Path(sys.executable).with_name("airlight")), "view", path, "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        url = process.stdout.readline().split()[-1]
        address = time.perf_counter()
        page.goto(url)
        while not page.evaluate(PAINTED):
            time.sleep(0.005)
        painted = time.perf_counter()
        own = page.evaluate(LOADED)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(10)
    return {"address": 1e3 * (address - begun), "first frame": 1e3 * (painted - begun), "page": own}


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", nargs="?", default="vortex")
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args(argv)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS.split())
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto("about:blank")
        runs = [start_ms(page, given.path) for _ in range(given.runs)]
        browser.close()
    for name in runs[0]:
        found = [run[name] for run in runs]
        print(f"{name}: median {statistics.median(found):.0f} ms, worst {max(found):.0f} ms")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
