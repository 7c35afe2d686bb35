"""What light costs: lit frames of the CT head beside the same frames without light, in turns, with error beside time.

Scharsach (2005, section 8) draws lit volumes in 1.5 to 2.9 times the time of unlit ones. Errors are those of each look against
itself at 1/8 voxel. The bar is that of bone with gradients from a texture, for pre- and post-classified looks each against its
own unlit frames.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from common import arguments, described, errors, parsed, side_by_side, table, write_json
from volumes import bone, cropped, head, real_volume

import airlight as al
from airlight.gpu.device import open_device

BAR = 1.5
CONVERGED_STEP = 1 / 8
FUNCTIONS: dict[str, Callable[[], al.TransferFunction]] = {"bone": bone, "skin and bone": head}
LIGHTINGS = ("sampled", "averaged", "interpolated")


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when the bar is missed."""
    parser = arguments(__doc__, "shaded", repeats=7, size=512, step=1.0, clock="what is told: cpu where others are busy")
    options = parsed(parser, argv, size=32, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    volume = real_volume("ct_head")
    volume = cropped(volume, 32) if options.quick else volume
    rows: list[dict[str, Any]] = []
    with al.Renderer(options.device) as renderer:
        for name, made in FUNCTIONS.items():
            for transfer in ("preintegrated", "postclassified"):
                found = measured(renderer, volume, made(), transfer, options)
                rows += [{"function": name, "transfer": transfer} | row for row in found]
    print(table(rows))
    worst = max(least_kept(rows, transfer) for transfer in ("preintegrated", "postclassified"))
    print(f"\n{'PASS' if worst <= BAR else 'FAIL'}: bone lit by kept gradients takes {worst:.2f} times unlit, at most {BAR}")
    write_json(options.out, about | {"rows": rows, "worst": worst, "passes": worst <= BAR})
    return 0 if worst <= BAR or options.quick else 1


def measured(
    renderer: al.Renderer, volume: al.Volume, function: al.TransferFunction, transfer: str, options: Any
) -> list[dict[str, Any]]:
    """Rows of a way to classify: unlit, and each lighting with gradients computed on the way and kept."""
    size = (options.size, options.size)

    def draw(step: float, **look: Any) -> al.Image:
        asked = al.Look(transfer=transfer, **look)
        return renderer.render(al.Scene(volume, transfer=function, look=asked, camera="iso", background=None), size, step=step)

    looks: dict[tuple[str, str], dict[str, Any]] = {("none", "-"): {"shade": "none"}}
    looks |= {(way, of): {"lighting": way, "gradient": of} for way in LIGHTINGS for of in ("central", "precomputed")}
    runs = side_by_side({key: partial(draw, options.step, **look) for key, look in looks.items()}, options.repeats, warm=2)
    unlit = np.array(getattr(runs["none", "-"], options.clock))
    rows = []
    for (lighting, gradient), run in runs.items():
        times = np.array(getattr(run, options.clock))
        truth = draw(CONVERGED_STEP, **looks[lighting, gradient])
        rows.append(
            {
                "lighting": lighting,
                "gradient": gradient,
                "ms": round(1e3 * float(np.median(times)), 1),
                "times unlit": round(float(np.median(times / unlit)), 2),
                "rmse": f"{errors(run.result.rgba, truth.rgba)['rmse']:.4f}",
            }
        )
    return rows


def least_kept(rows: list[dict[str, Any]], transfer: str) -> float:
    """Least of the times of bone with kept gradients, relative to unlit."""
    asked = {"function": "bone", "transfer": transfer, "gradient": "precomputed"}
    return min(float(row["times unlit"]) for row in rows if asked.items() <= row.items())


if __name__ == "__main__":
    sys.exit(main())
