"""Clips: what they cost beside the same picture without them, or of a volume that is masked instead.

*nothing*: planes that cut nothing, left out by the host. *union*: outside of a wedge, three boxes and a closed mesh, a ball of
2,000 triangles, beside the volume with air there; *union without mesh* leaves the ball out of both. All ratios are medians over
frames that are drawn in turns.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from typing import Any

import numpy as np
from common import arguments, described, parsed, side_by_side, table, write_json
from meshes import sphere
from volumes import bone, cropped, real_volume

import airlight as al
from airlight.clips import Solid
from airlight.gpu.device import open_device
from airlight.volume import FloatArray

PLANES = 20
TRIANGLES = 2000
BALL = (0.7, 0.15, 0.75)
BAR = {"nothing": 1.03, "union": 1.2}


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = arguments(__doc__, "clips", repeats=9, size=400, step=1.0, clock="what is told: cpu where others are busy")
    options = parsed(parser, argv, size=32, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    volume = real_volume("ct_head")
    volume = cropped(volume, 32) if options.quick else volume
    scene = al.Scene(volume, transfer=bone(), camera="iso", background=None)
    with al.Renderer(options.device) as renderer:
        rows = measured(renderer, scene, options)
    print(table(rows))
    write_json(options.out, about | {"rows": rows})
    return 0


def measured(renderer: al.Renderer, scene: al.Scene, options: Any) -> list[dict[str, Any]]:
    """Rows of ways to cut: each beside the picture that it is compared with."""
    volume = scene.layers[0].volume
    shapes = union(volume)
    masked, unmeshed = (
        dataclasses.replace(scene, layers=[dataclasses.replace(scene.layers[0], volume=without(volume, cut))])
        for cut in (shapes, shapes[:-1])
    )
    ways = {
        "nothing": (around(volume), scene),
        "one plane": ([al.Clip.plane(point=place(volume, 0.5, 0.5, 0.5), normal=(0, 1, 0))], scene),
        "planes that cut": (edges(volume), scene),
        "union without mesh": (shapes[:-1], unmeshed),
        "union": (shapes, masked),
    }
    rows = []
    for name, (clips, beside) in ways.items():
        pair = {"with": dataclasses.replace(scene, clips=clips), "beside": beside}
        jobs = {which: partial(renderer.render, drawn, (options.size,) * 2, step=options.step) for which, drawn in pair.items()}
        runs = side_by_side(jobs, options.repeats)
        one, other = (np.array(getattr(runs[which], options.clock)) for which in pair)
        samples = [runs[which].result.stats["samples"] for which in pair]
        rows.append(
            {
                "clips": name,
                "cutting": runs["with"].result.stats["clips"]["cutting"],
                "ms": 1e3 * float(np.median(one)),
                "ratio": float(np.median(one / other)),
                "bar": BAR.get(name),
                "samples": samples[0] / samples[1],
            }
        )
    return rows


def place(volume: al.Volume, *shares: float) -> tuple[float, float, float]:
    """Point at these shares of the volume's bounds."""
    low, high = bounds(volume)
    x, y, z = low + np.array(shares) * (high - low)
    return float(x), float(y), float(z)


def bounds(volume: al.Volume) -> tuple[FloatArray, FloatArray]:
    """Least and greatest corner in the world."""
    corners = volume.corners_world()
    return corners.min(axis=0), corners.max(axis=0)


def around(volume: al.Volume) -> list[al.Clip]:
    """Planes round a volume, all of which keep it."""
    low, high = bounds(volume)
    reach = float(np.linalg.norm(high - low))
    angles = np.arange(PLANES) * 2 * np.pi / PLANES
    middle = np.array(place(volume, 0.5, 0.5, 0.5))
    normals = [np.array([np.cos(a), np.sin(a), 0.3]) for a in angles]
    return [al.Clip.plane(point=tuple(middle - reach * n), normal=tuple(n)) for n in normals]


def edges(volume: al.Volume) -> list[al.Clip]:
    """Planes that cut the volume to a rod."""
    low, high = bounds(volume)
    return [
        al.Clip.plane(point=tuple((low + high) / 2 - 0.48 * float((high - low).min()) * n), normal=tuple(n))
        for n in (np.array([np.cos(a), np.sin(a), 0.0]) for a in np.arange(PLANES) * 2 * np.pi / PLANES)
    ]


def union(volume: al.Volume) -> list[al.Clip]:
    """Outside of a wedge, of three boxes, and of a ball that is a closed mesh."""
    low, high = bounds(volume)
    x, y, z = high - low
    wedge = np.eye(4)
    wedge[:3, :3] = [[x, 0.25 * x, 0], [0, 0.5 * y, 0], [0, 0, 0.6 * z]]
    wedge[:3, 3] = place(volume, 0.4, -0.01, 0.5)
    boxes = [((0.1, 0.2, 0.6), (0.3, 0.7, 1.1)), ((0.5, 0.6, 0.7), (0.9, 1.1, 1.1)), ((-0.1, -0.1, 0.1), (0.25, 0.4, 0.3))]
    return [
        al.Clip.box(low=(0, 0, 0), high=(1, 1, 1), world_from_box=wedge, keep="outside"),
        *(al.Clip.box(low=place(volume, *a), high=place(volume, *b), keep="outside") for a, b in boxes),
        al.Clip.mesh(sphere(TRIANGLES, np.array(place(volume, *BALL)), ball_radius(volume)), keep="outside"),
    ]


def ball_radius(volume: al.Volume) -> float:
    """Radius of the ball that is cut away."""
    low, high = bounds(volume)
    return 0.2 * float((high - low).min())


def without(volume: al.Volume, shapes: list[al.Clip]) -> al.Volume:
    """Return the volume with its least value where shapes are."""
    index = np.stack(np.indices(volume.array.shape)[::-1], axis=-1) @ volume.world_from_index[:3, :3].T
    p_world = index + volume.world_from_index[:3, 3]
    inside = np.zeros(volume.array.shape, dtype=bool)
    for clip in shapes:
        if isinstance(clip, Solid):
            inside |= np.linalg.norm(p_world - np.array(place(volume, *BALL)), axis=-1) <= ball_radius(volume)
            continue
        unit = p_world @ clip.unit_from_world[:, :3].T + clip.unit_from_world[:, 3]
        inside |= (np.abs(unit) <= 1).all(axis=-1)
    array = np.where(inside, volume.array.min(), volume.array)
    return al.Volume(array, world_from_index=volume.world_from_index, units=volume.units, value_unit=volume.value_unit)


if __name__ == "__main__":
    sys.exit(main())
