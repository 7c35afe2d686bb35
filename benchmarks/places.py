"""What questions about places cost a session at rest: probe, profile, joint histogram, slices.

    python benchmarks/places.py ct_head.nrrd

Milliseconds of the answer alone, without the way to the browser; the machine should be quiet.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np

import airlight as al
from airlight.viewer.asking import answer
from airlight.viewer.document import Document
from airlight.viewer.session import Session, Viewer

BARS = {"probe": 100.0, "slices, one of 512x512": 40.0}
"""Most that the 95th percentile may be."""
SLANTED = {"right": [0.8, 0.6, 0.0], "up": [0.0, 0.0, 1.0]}


def timed(session: Session, runs: int, what: str, given: Callable[[int], dict[str, object]]) -> list[float]:
    """Milliseconds of each answer, the first left out."""
    spent = []
    for run in range(runs + 1):
        begun = time.perf_counter()
        answer(session, what, given(run))
        spent.append(1e3 * (time.perf_counter() - begun))
    return spent[1:]


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", nargs="?", default="fly", help="file or sample (default: fly)")
    parser.add_argument("--runs", type=int, default=60)
    given = parser.parse_args(argv)
    is_sample = given.path in al.samples.names()
    volume = al.samples.load(given.path) if is_sample else al.open(given.path)
    viewer = Viewer(Document(al.first_picture(volume)), given.path)
    session = viewer.session()
    session.listen(lambda message, buffers: None)
    session.receive({"type": "hello", "size_px": [512, 512]})
    time.sleep(5)
    across = np.linspace(0.3, 0.7, given.runs + 1).tolist()
    middle = volume.corners_world().mean(axis=0)
    size = float(np.ptp(volume.corners_world(), axis=0).max())
    plane = SLANTED | {"centre_world": middle.tolist(), "pixel_world": size / 512, "size_px": [512, 512]}
    low, high = (float(volume.grid().min()), float(volume.grid().max()))
    axes = [{name: axis[name] for name in ("variable", "low", "high")} for axis in answer(session, "joint", {})[0]["axes"]]
    questions: dict[str, tuple[str, Callable[[int], dict[str, object]]]] = {
        "probe": ("probe", lambda run: {"x": across[run], "y": 0.5}),
        "profile": ("profile", lambda run: {"x": across[run], "y": 0.5}),
        "neighbours in the histogram": ("joint.here", lambda run: {"p_world": middle.tolist(), "axes": axes}),
        "slices, one of 512x512": ("slices", lambda run: {"planes": [plane], "window": [low, high]}),
    }
    for name, (what, arguments) in questions.items():
        spent = timed(session, given.runs, what, arguments)
        p95 = statistics.quantiles(spent, n=20)[-1]
        bar = f" (at most {BARS[name]:.0f})" if name in BARS else ""
        print(f"{name}: median {statistics.median(spent):.1f} ms, 95 % {p95:.1f} ms{bar}")
    viewer.close()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
