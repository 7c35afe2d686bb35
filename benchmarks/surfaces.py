"""Time of 1, 10 and 100 surfaces of equal value in one look, relative to one (Engel and Ertl 2002, section 8.3).

*crowded*: all lie so near to each other that the same slabs cross them, many at once, with the opacity of the one together:
what the table costs, and nothing else (found by straight lines: sharp surfaces are looked for one by one). The bar: within 5 %
of one surface. *spread*: at even distances over the data's range, so that more slabs are lit and fewer skipped: what a picture
costs; once without skipping or light, where the bar holds, too.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from common import arguments, by_both_clocks, described, frame_of, from_corner, parsed, side_by_side, table, write_json
from volumes import cropped, real_volume

import airlight as al
from airlight.gpu.device import Device, open_device
from airlight.rendering.ways import draw_frame

COUNTS = (1, 10, 100)
MOST = 1.05
OPACITY = 0.3
LOOKS: dict[str, dict[str, Any]] = {"unlit": {"shade": "none"}, "lit": {}}


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when many surfaces take more than 5 % longer than one where the same slabs are drawn."""
    parser = arguments(__doc__, "surfaces", repeats=15, size=384, step=1.0, clock="what decides: cpu where others are busy")
    options = parsed(parser, argv, size=48, repeats=1)
    device = open_device(options.device)
    try:
        about = described(device, options)
        volume = real_volume("engine")
        volume = cropped(volume, 24) if options.quick else volume
        rows = [row for case in cases(volume) for row in measured_case(device, volume, *case, options)]
        print(table([shown(row, options.clock) for row in rows]))
    finally:
        device.close()
    passed = all(row["relative"][options.clock]["median"] <= MOST for row in rows if row["counts"])
    print(f"\n{'PASS' if passed else 'FAIL'}: where the same slabs are drawn, at most {MOST} times the time of one surface")
    write_json(options.out, about | {"most": MOST, "rows": rows, "passes": passed})
    return 0 if passed or options.quick else 1


def cases(volume: al.Volume) -> list[tuple[str, str, dict[int, al.TransferFunction], bool]]:
    """Name, look, function by number of surfaces, and whether the bar counts."""
    known = al.statistics(volume)
    low, high = float(known.minimum), float(known.maximum)
    extent = max(n * s for n, s in zip(volume.size, volume.spacing, strict=True))
    fog = al.TransferFunction([(low, (0.2, 0.3, 0.6), 0.0), (high, (1, 0.9, 0.8), 1.5 / extent)])
    middle, width = low + 0.4012 * (high - low), 1e-5 * (high - low)
    crowded = {n: sheets(np.linspace(middle, middle + width, n) if n > 1 else np.array([middle])) for n in COUNTS}
    spread = {n: sheets(np.linspace(low, high, n + 2)[1:-1]) for n in COUNTS}
    found = []
    for name, chosen in (("crowded", crowded), ("spread", spread)):
        for look in LOOKS:
            alone = {n: al.TransferFunction.from_surfaces(surfaces) for n, surfaces in chosen.items()}
            found.append((name, look, alone, name == "crowded"))
            in_fog = {n: fog.with_surfaces(surfaces) for n, surfaces in chosen.items()}
            found.append((f"{name}, in a medium", look, in_fog, name == "crowded"))
    found.append(
        ("spread, nothing skipped", "unlit", {n: al.TransferFunction.from_surfaces(s) for n, s in spread.items()}, True)
    )
    return found


def sheets(values: np.ndarray[Any, Any]) -> list[al.Surface]:
    """Surfaces whose opacities together are that of one."""
    opacity = 1 - (1 - OPACITY) ** (1 / len(values))
    return [al.Surface(float(v), (1, 0.8, n / len(values)), opacity, (0.3, 0.5, 1)) for n, v in enumerate(values)]


def measured_case(
    device: Device,
    volume: al.Volume,
    name: str,
    look: str,
    functions: dict[int, al.TransferFunction],
    counts: bool,
    options: Any,
) -> list[dict[str, Any]]:
    """Draw all numbers of surfaces in turns."""
    skip = "none" if "nothing skipped" in name else "auto"
    scenes = {n: from_corner(volume, function, LOOKS[look]) for n, function in functions.items()}
    frames = {n: frame_of(device, scene, options, skip, refine="none") for n, scene in scenes.items()}
    jobs = {str(n): (lambda frame=frame: draw_frame(frame)) for n, frame in frames.items()}
    measured = side_by_side(jobs, options.repeats, warm=2)
    return [
        {
            "case": name,
            "look": look,
            "surfaces": n,
            "counts": counts,
            "samples": float(measured[str(n)].result[2].sum()),
            "alpha_mean": float(measured[str(n)].result[0][..., 3].mean()),
            "times": measured[str(n)].summary(),
            "relative": by_both_clocks(measured[str(n)], measured["1"]),
        }
        for n in functions
    ]


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """One row of the printed table."""
    return {
        "case": row["case"],
        "look": row["look"],
        "surfaces": row["surfaces"],
        "Msamples": row["samples"] / 1e6,
        "mean alpha": row["alpha_mean"],
        f"ms {clock}": row["times"][f"{clock}_ms"]["median"],
        "to one": row["relative"][clock]["median"],
        "min": row["relative"][clock]["min"],
        "max": row["relative"][clock]["max"],
    }


if __name__ == "__main__":
    sys.exit(main())
