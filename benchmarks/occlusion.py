"""Ambient occlusion: time to make openness and to draw with it, and what fewer directions cost.

*make*: the first frame of a pixel with another function, less one without occlusion: gathering cells, and looking round from
them. *draw*: frames that find it made, relative to the same frames without it. *error*: root mean square difference of the
picture from that with 1,024 directions, over what is covered.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import numpy as np
from common import arguments, described, errors, parsed, side_by_side, table, write_json
from volumes import bone, cropped, real_volume

import airlight as al
from airlight.gpu.device import open_device

SETTINGS: tuple[dict[str, int], ...] = (
    {"directions": 16},
    {"directions": 32},
    {},
    {"directions": 128},
    {"cells": 32},
    {"cells": 96},
)
LIGHT = al.shade.BlinnPhong(ambient=1.2, diffuse=0.35, specular=0.1)


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = arguments(__doc__, "occlusion", repeats=5, size=400, step=1.0, clock="what is told: cpu where others are busy")
    options = parsed(parser, argv, size=32, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    rows: list[dict[str, Any]] = []
    metal = al.TransferFunction([(100, (0.8, 0.75, 0.65), 0), (130, (0.8, 0.75, 0.65), 2.0)])
    for name, function in (("engine", metal), ("ct_head", bone()))[: 1 if options.quick else 2]:
        volume = real_volume(name)
        volume = cropped(volume, 32) if options.quick else volume
        with al.Renderer(options.device) as renderer:
            rows += measured_volume(renderer, name, volume, function, options)
    print(table(rows))
    write_json(options.out, about | {"rows": rows})
    return 0


def measured_volume(
    renderer: al.Renderer, name: str, volume: al.Volume, function: al.TransferFunction, options: Any
) -> list[dict[str, Any]]:
    """Rows of a volume: a setting each."""
    size = (options.size, options.size)
    densities = iter(np.arange(1.0, 2.0, 1e-4))

    def drawn(visibility: Any) -> Any:
        look = al.Look(shade=LIGHT, visibility=visibility)
        scene = al.Scene(volume, transfer=function, look=look, camera="iso", background=None)
        return renderer.render(scene, size, step=options.step)

    def with_another_function(visibility: Any) -> Any:
        look = al.Look(shade=LIGHT, visibility=visibility)
        layer = al.Layer(volume, function, look, density=float(next(densities)))
        return renderer.render(al.Scene(layers=[layer], camera="iso"), (1, 1), step=options.step)

    def measured(setting: dict[str, int]) -> dict[str, Any]:
        stage = al.visibility.AmbientOcclusion(**setting)  # type: ignore[arg-type]
        ways = {"with": stage, "without": "none"}
        made = side_by_side({way: partial(with_another_function, given) for way, given in ways.items()}, options.repeats)
        frames = side_by_side({way: partial(drawn, given) for way, given in ways.items()}, options.repeats)
        first, plain, drawing, bare = (
            np.array(getattr(runs[way], options.clock)) for runs in (made, frames) for way in ("with", "without")
        )
        image = frames["with"].result
        return {
            "volume": name,
            "directions": stage.directions,
            "cells": " x ".join(str(n) for n in image.stats["tables"]["visibility.openness"][2::-1]),
            "make ms": 1e3 * float(np.median(first - plain)),
            "draw ms": 1e3 * float(np.median(drawing)),
            "draw ratio": float(np.median(drawing / bare)),
            "error": errors(image.rgba[covered], best[covered])["rmse"] if stage.cells == 64 else None,
            "mean": float(image.rgba[covered, :3].mean()),
        }

    best = drawn(al.visibility.AmbientOcclusion(directions=128 if options.quick else 1024)).rgba
    covered = best[..., 3] > 0.5
    return [measured(setting) for setting in (SETTINGS[:3] if options.quick else SETTINGS)]


if __name__ == "__main__":
    sys.exit(main())
