"""What tones cost: frames with each of them beside frames without, in turns.

*covered*: two voxels that cover all pixels, of which the march takes next to nothing: what is more than the frame with
``linear`` is the cost of the tone, also in a quick frame. *head*: a CT head as the paper drew it, one sample a voxel. Vollrath,
Weiskopf and Ertl lost about one frame a second of 12.5 (section 7): 7 ms of 80. Pictures are three quarters as high as wide.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import numpy as np
from common import arguments, described, parsed, side_by_side, table, write_json
from volumes import bone, cropped, real_volume

import airlight as al
from airlight.gpu.device import open_device

TONES = ("linear", "reinhard", "reinhard_local", "filmic")
PAPER_HZ = 12.5
MOST_MS = 1e3 / (PAPER_HZ - 1) - 1e3 / PAPER_HZ  # a frame a second less


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 where the global operator takes more than a frame a second of the paper's rate."""
    parser = arguments(__doc__, "tones", repeats=15, size=640, step=1.0, clock="what is told: cpu where others are busy")
    options = parsed(parser, argv, size=32, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    volume = real_volume("ct_head")
    volume = cropped(volume, 32) if options.quick else volume
    scenes = {"covered": covering, "head": partial(head, volume)}
    with al.Renderer(options.device) as renderer:
        rows = [row for name, scene in scenes.items() for row in measured(renderer, name, scene, options)]
    cost = next(row["more ms"] for row in rows if row["tone"] == "reinhard")
    passes = options.quick or cost <= MOST_MS
    print(table(rows), f"reinhard: {cost:.1f} ms, at most {MOST_MS:.1f}", "PASS" if passes else "FAIL", sep="\n\n")
    write_json(options.out, about | {"rows": rows, "passes": passes})
    return 0 if passes else 1


def covering(tone: str) -> al.Scene:
    """Scene of which each pixel sees as much."""
    look = al.Look(shade="none", tone=tone)
    camera = al.Camera.orthographic(eye=(0.5, -9, 0.5), target=(0.5, 0, 0.5), height=0.5)
    function = al.TransferFunction([(0, "#806040", 0.5), (1, "#ffe0c0", 5.0)])
    return al.Scene(al.Volume(np.eye(4, dtype=np.float32).reshape(4, 2, 2)), transfer=function, look=look, camera=camera)


def head(volume: al.Volume, tone: str) -> al.Scene:
    """Scene of a head, lit."""
    return al.Scene(volume, transfer=bone(), look=al.Look(shade="blinn_phong", tone=tone), camera="back")


def measured(renderer: al.Renderer, name: str, scene: Any, options: Any) -> list[dict[str, Any]]:
    """Rows of one kind of scene."""
    size = (options.size, options.size * 3 // 4)
    jobs = {tone: partial(renderer.render, scene(tone), size, step=options.step) for tone in TONES}
    runs = {tone: 1e3 * np.array(getattr(run, options.clock)) for tone, run in side_by_side(jobs, options.repeats).items()}
    rows = []
    for tone in TONES:
        told = jobs[tone]().stats["milliseconds"]
        ms, more = float(np.median(runs[tone])), float(np.median(runs[tone] - runs["linear"]))
        parts = {f"{part} ms": told.get(part, 0.0) for part in ("luminance", "surround", "tone")}
        lost = 1e3 / max(ms - more, 1e-3) - 1e3 / ms
        rows.append({"scene": name, "tone": tone, "ms": ms, "more ms": more, "frames a second lost": lost} | parts)
    return rows


if __name__ == "__main__":
    sys.exit(main())
