"""Two layers in one march, beside each of them drawn alone.

*overlapping*: a volume of another spacing, turned, lies inside of a head. *beside*: next to it. *twice*: the same layer two
times, at half of its density. All ratios are medians over frames that are drawn in turns, of the frame to the sum of its parts.
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


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = arguments(__doc__, "layers", repeats=7, size=400, step=1.0, clock="what is told: cpu where others are busy")
    options = parsed(parser, argv, size=32, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    volume = real_volume("ct_head")
    volume = cropped(volume, 32) if options.quick else volume
    with al.Renderer(options.device) as renderer:
        rows = [row for shade in ("none", "blinn_phong") for row in measured(renderer, volume, shade, options)]
    print(table(rows))
    write_json(options.out, about | {"rows": rows})
    return 0


def measured(renderer: al.Renderer, volume: al.Volume, shade: str, options: Any) -> list[dict[str, Any]]:
    """Rows of pairs of layers: the frame of both, and of each alone."""
    look = al.Look(shade=shade)
    head = al.Layer(volume, bone(), look)
    function = al.TransferFunction([(0.2, (0.2, 0.5, 1), 0.0), (1.0, (0.4, 0.9, 1), 0.3)])
    half = al.Layer(volume, bone(), look, density=0.5)
    pairs = {
        "overlapping": (head, al.Layer(ball(volume, (0.5, 0.5, 0.6)), function, look)),
        "beside": (head, al.Layer(ball(volume, (1.3, 0.5, 0.5)), function, look)),
        "twice": (half, half),
    }
    rows = []
    for name, layers in pairs.items():
        drawn = {"both": layers, "first": layers[:1], "second": layers[1:]}
        camera = al.fit_camera("iso", np.concatenate([layer.volume.corners_world() for layer in layers]))
        jobs = {
            which: partial(
                renderer.render,
                al.Scene(layers=some, camera=camera, background=None),
                (options.size,) * 2,
                step=step_of(some, layers, options),
            )
            for which, some in drawn.items()
        }
        runs = side_by_side(jobs, options.repeats)
        both, first, second = (np.array(getattr(runs[which], options.clock)) for which in drawn)
        rows.append(
            {
                "layers": name,
                "shade": shade,
                "ms": 1e3 * float(np.median(both)),
                "first ms": 1e3 * float(np.median(first)),
                "second ms": 1e3 * float(np.median(second)),
                "to their sum": float(np.median(both / (first + second))),
            }
        )
    return rows


def step_of(some: tuple[al.Layer, ...], layers: tuple[al.Layer, ...], options: Any) -> float:
    """The step in voxels at which some of the layers are sampled as far apart as all of them are."""
    least, own = (min(min(layer.volume.spacing) for layer in part) for part in (layers, some))
    return float(options.step * least / own)


def ball(volume: al.Volume, shares: tuple[float, float, float]) -> al.Volume:
    """A ball at these shares of the volume's bounds, a quarter as wide, on a grid of its own that is turned."""
    z, y, x = np.mgrid[-1:1:96j, -1:1:96j, -1:1:96j]
    field = np.clip(1.2 - np.sqrt(x * x + y * y + z * z), 0, 1).astype(np.float32)
    corners = volume.corners_world()
    low, high = corners.min(axis=0), corners.max(axis=0)
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * float((high - low).min()) / 4 / 48
    matrix[:3, 3] = low + np.array(shares) * (high - low) - matrix[:3, :3] @ np.full(3, 47.5)
    return al.Volume(field, world_from_index=matrix)


if __name__ == "__main__":
    sys.exit(main())
