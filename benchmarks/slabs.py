"""Functions that bend sharply: tables of slabs beside slabs that are cut at control points, error and time of pictures.

The CT head, unlit or lit (``--lit``), seen from a corner; a depth is that of a voxel where a function is densest. Errors are
greatest differences of linear, premultiplied colours from the float64 reference at the same step, over pixels drawn by lot;
single slabs, which are worse, are in ``tests/rendering/test_slabs.py``. Then what an edit costs, from a new function to the
finished frame, beyond a repeated frame.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from common import arguments, errors, from_corner, machine, parsed, side_by_side, table, write_json
from volumes import cropped, real_volume

import airlight as al
from airlight import reference
from airlight.transfer.tables import ACCURATE

DEPTHS = (0.3, 3.0, 10.0, 40.0)
STAGES = {
    "table, 256": al.transfer.PreIntegrated(entries=256),
    "table, 1024": al.transfer.PreIntegrated(entries=1024),
    "cut": al.transfer.ExactPreIntegrated(),
    "chosen": al.transfer.PreIntegrated(),
}
VALUES = (-500.0, 1500.0)
MOST_EDIT_MS = 15


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a slab of the chosen stage may be off by more than 1/512, or an edit takes too long."""
    parser = arguments(__doc__, "slabs", repeats=5, size=256)
    parser.add_argument("--lit", action="store_true", help="with light, for which each end of a slab counts")
    parser.add_argument("--pixels", type=int, default=400, help="pixels compared with the reference (default: 400)")
    options = parsed(parser, argv, size=24, repeats=1, pixels=20)
    volume = real_volume("ct_head")
    volume = cropped(volume, 24) if options.quick else volume
    with al.Renderer() as renderer:
        rows = [
            row(renderer, volume, name, depth, options) for name in kinds() for depth in DEPTHS[: 1 if options.quick else None]
        ]
        print(table(rows))
        edits = [edit(renderer, volume, name, options) for name in ("gentle", "steps")]
        print("\n" + table(edits))
    bars = {
        "slabs of the chosen stage are off by at most 1/512": all(row["told"] <= ACCURATE for row in rows),
        f"edits take at most {MOST_EDIT_MS} ms beyond a repeated frame": all(e["beyond [ms]"] <= MOST_EDIT_MS for e in edits),
    }
    print("\n" + "\n".join(f"{'PASS' if met else 'FAIL'}: {bar}" for bar, met in bars.items()))
    passed = all(bars.values())
    write_json(options.out, machine() | {"quick": options.quick, "rows": rows, "edits": edits, "bars": bars})
    return 0 if passed or options.quick else 1


def kinds() -> dict[str, list[tuple[float, Any, float]]]:
    """Points of functions; values from 0 to 1, extinctions up to one."""
    rng = np.random.default_rng(7)
    steps = [(0, "red", 0.05), (0.33, "red", 0.05), (0.33, "red", 0.2), (0.61, "blue", 0.2), (0.61, "white", 1), (1, "lime", 1)]
    peaks: list[tuple[float, Any, float]] = [(0, "red", 0), (1, "red", 0)]
    for place, colour in ((0.27, "lime"), (0.36, "blue"), (0.5, "white")):
        peaks += [(place - 0.005, "red", 0), (place, colour, 1), (place + 0.005, "red", 0)]
    found = {"steps": steps, "peaks": sorted(peaks, key=lambda p: p[0])}
    for count in (12, 48, 300):
        found[f"random, {count}"] = [(float(v), tuple(rng.random(3)), rng.random()) for v in np.sort(rng.random(count))]
    return found


def function(volume: al.Volume, points: list[tuple[float, Any, float]], depth: float) -> al.TransferFunction:
    """Points over the values of bone and tissue; the greatest extinction makes a voxel this deep."""
    (low, high), voxel = VALUES, min(volume.spacing)
    return al.TransferFunction([(low + v * (high - low), colour, depth / voxel * e) for v, colour, e in points])


def row(renderer: al.Renderer, volume: al.Volume, name: str, depth: float, options: Any) -> dict[str, Any]:
    """Times and errors of a function by stage."""
    size, tf = (options.size, options.size), function(volume, kinds()[name], depth)

    def scene(stage: al.transfer.Transfer) -> al.Scene:
        return from_corner(volume, tf, {"shade": "blinn_phong" if options.lit else "none", "transfer": stage})

    runs = side_by_side(
        {way: lambda stage=stage: renderer.render(scene(stage), size) for way, stage in STAGES.items()}, options.repeats
    )
    y, x = np.nonzero(runs["chosen"].result.rgba[..., 3] > 0)
    taken = np.random.default_rng(5).permutation(len(x))[: options.pixels]
    x, y = x[taken], y[taken]
    truth = reference.render(scene(STAGES["cut"]), size, pixels=np.stack([x, y], axis=1)).rgba
    found: dict[str, Any] = {"function": name, "depth": depth}
    for way, run in runs.items():
        found[f"{way} [ms]"] = float(1e3 * np.median(run.cpu))
        found[f"{way}, error"] = errors(run.result.rgba[y, x], truth)["max"]
    layer = runs["chosen"].result.stats["layers"][0]
    return found | {"chosen": layer["stages"]["transfer"], "told": layer["errors"]["transfer: colour of a slab"]}


def edit(renderer: al.Renderer, volume: al.Volume, name: str, options: Any) -> dict[str, Any]:
    """Milliseconds of a frame with a function never seen before, and of the same frame again; the wall clock decides."""
    gentle = [(0, "black", 0), (0.3, "red", 0.2), (0.7, "lime", 0.1), (1, "white", 0.3)]
    points = gentle if name == "gentle" else kinds()[name]
    size, seeds = (options.size, options.size), iter(range(1, 1000))
    look = {"shade": "blinn_phong" if options.lit else "none"}

    def drawn(seed: float) -> al.Image:
        moved = [(v + 1e-5 * seed * (v > 0), colour, e) for v, colour, e in points[:-1]]
        return renderer.render(from_corner(volume, function(volume, [*moved, points[-1]], 1.0), look), size)

    # What is repeated is moved, too: cells of points that lie evenly need no search, and are drawn quicker.
    runs = side_by_side({"edited": lambda: drawn(next(seeds)), "repeated": lambda: drawn(0.5)}, 3 * options.repeats)
    edited, repeated = runs["edited"], runs["repeated"]
    told = {"edit": name, "stage": edited.result.stats["layers"][0]["stages"]["transfer"]}
    told |= {f"{way} [ms]": float(1e3 * np.median(run.wall)) for way, run in runs.items()}
    # Frames drift by more than an edit takes: each is compared with its neighbour.
    told["beyond [ms]"] = float(1e3 * np.median(np.subtract(edited.wall, repeated.wall)))
    return told | {"beyond, processor [ms]": float(1e3 * np.median(np.subtract(edited.cpu, repeated.cpu)))}


if __name__ == "__main__":
    sys.exit(main())
