"""Iso-surfaces at large steps: where rays hit them, what sharper hits cost, and what blocks of voxels are worth.

*hits*: a sphere, a torus and the field of Marschner and Lobb at 5-voxel steps. Errors are distances along the ray to the
nearest root of the reconstructed (trilinear) field, in voxels, of all hits at more than 2 degrees; the truth is computed in
float64 with eigenvalues of the cubics along rays. Of the rays whose first surface is met at more than 2 degrees, *lost* ones
hit nothing and *later* ones a surface behind it: none where all cells are looked through. *refining*: the time of frames
relative to those without refinement; the bar is for what sharpens places in blocks, as frames have them unless told. *steps*:
bone of the CT head at steps of 5 voxels in blocks against 1.0 and 0.5 with the same refinement: structural similarity (SSIM,
Wang et al. 2004) and speed. *plain*: nothing is skipped, as the bar has it; *leaps*: a march that passes over blocks in which
nothing is; *blocks*: sampled block by block, too. *fixed*: of the time at 5 voxels, what rays take that end where they enter
the volume.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
from common import arguments, machine, ratio, side_by_side, table, write_json
from volumes import cropped, real_volume

import airlight as al
from airlight.gpu.device import Device, open_device
from airlight.reference import prepare as prepare_reference
from airlight.reference.camera import CAMERAS
from airlight.reference.field import field_value
from airlight.reference.march import span
from airlight.reference.refine import crossings
from airlight.rendering.frame import Request, prepare
from airlight.rendering.march import MarchFrame
from airlight.rendering.ways import draw_frame

STEP = 5.0
GRAZING_DEG = 2.0
LATER = 0.02  # voxels; roots of two surfaces lie further apart than any of them is wrong
LIMITS = {"bisection": STEP / 64, "secant": 1e-2, "exact": 1e-3, "cells": 1e-3}
MOST_COST = 1.25
LEAST_SSIM = 0.98
LEAST_SPEED = {1.0: 2.8, 0.5: 5.0}
BONE = 300.0  # HU
NOWHERE_BELOW = -1e5  # HU
WAYS = {"plain": ("none", False), "leaps": ("auto", False), "blocks": ("auto", True)}  # skip, blocks


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "iso", repeats=7)
    parser.add_argument("--size", type=int, default=512, help="width and height of the picture (default: 512)")
    parser.add_argument("--device", default=None, help="adapter, by number, kind or part of its name")
    parser.add_argument("--clock", choices=("wall", "cpu"), default="cpu", help="what decides: cpu where others are busy")
    options = parser.parse_args(argv)
    if options.quick:
        options.size, options.repeats = 64, 1
    device = open_device(options.device)
    try:
        about = machine(device) | {"quick": options.quick, "size": options.size, "clock": options.clock}
        hits = [row for name, scene in analytic_scenes().items() for row in hit_errors(device, name, scene, options)]
        print(table(hits))
        head = real_volume("ct_head")
        head = cropped(head, 48) if options.quick else head
        costs = [row for view in ("left", "top") for row in refining(device, head, view, options)]
        print("\n" + table(costs))
        steps = [row for view in ("front", "left", "top", "iso") for row in larger_steps(device, head, view, options)]
        print("\n" + table(steps))
    finally:
        device.close()
    passed = {
        "hits": all(row["worst [voxel]"] <= row["limit"] for row in hits),
        "none left out": all(row["lost"] + row["later"] == 0 for row in hits if row["refine"] == "cells"),
        "refining": all(row["to none"] <= MOST_COST for row in costs if row["blocks"] == "yes" and row["refine"] != "cells"),
        "ssim": all(row["SSIM"] >= LEAST_SSIM for row in steps),
        "speed": all(row["speed"] >= LEAST_SPEED[row["against"]] for row in steps if row["way"] == "plain"),
    }
    print("\n" + ", ".join(f"{name}: {'PASS' if good else 'FAIL'}" for name, good in passed.items()))
    write_json(options.out, about | {"hits": hits, "refining": costs, "steps": steps, "passed": passed})
    return 0 if all(passed.values()) or options.quick else 1


def analytic_scenes(voxels: int = 64) -> dict[str, al.Scene]:
    """Distance fields of a sphere and a torus, and the test signal of Marschner and Lobb, seen from a corner."""
    z, y, x = np.mgrid[-1 : 1 : voxels * 1j, -1 : 1 : voxels * 1j, -1 : 1 : voxels * 1j]
    around = np.hypot(x, y) - 0.55
    fields = {
        "sphere": (al.Volume((0.8 - np.sqrt(x * x + y * y + z * z)).astype(np.float32)), 0.0),
        "torus": (al.Volume((0.3 - np.sqrt(around * around + z * z)).astype(np.float32)), 0.0),
        "marschner-lobb": (al.samples.load("marschner-lobb"), 0.5),
    }
    return {name: iso_scene(volume, iso, "iso", field="linear_exact") for name, (volume, iso) in fields.items()}


def iso_scene(volume: al.Volume, iso: float, view: str, zoom: float = 1.0, **look: Any) -> al.Scene:
    """Scene of one surface; ``zoom`` narrows the angle of the camera."""
    known = al.statistics(volume)
    tf = al.TransferFunction([(float(known.minimum), (0.9, 0.8, 0.65), 0.0), (float(known.maximum), (0.9, 0.8, 0.65), 1.0)])
    camera = al.fit_camera(view, volume.corners_world(), 1.0)
    camera = replace(camera, fov_deg=camera.fov_deg * zoom)
    drawn = al.Look(integrate=al.integrate.FirstHit(iso=iso), **look)
    return al.Scene(volume, transfer=tf, camera=camera, look=drawn, background=(0, 0, 0))


def frame_of(device: Device, scene: al.Scene, size: int, step: float, skip: str = "auto", **driver: Any) -> MarchFrame:
    """Frame that can be drawn again and again."""
    request = Request((size, size), al.driver.March(**driver), step, skip)
    return prepare(device, scene, request, lambda: None, lambda *_: None)


# -- hits


def hit_errors(device: Device, name: str, scene: al.Scene, options: Any) -> list[dict[str, Any]]:
    """Greatest distance of hits from the nearest root along the ray, for each refinement."""
    size = min(options.size, 256)
    first = first_surfaces(scene, size)
    rows = []
    for refine in ("none", *LIMITS):
        depth = draw_frame(frame_of(device, scene, size, STEP, refine=refine))[1]
        error, root, degrees, begins_outside = distances(scene, depth)
        error = error[(degrees > GRAZING_DEG) & begins_outside]
        met = np.isfinite(depth)
        behind = root > first[met] + LATER * prepare_reference(scene).spacing_world
        rows.append(
            {
                "field": name,
                "refine": refine,
                "rays": int(np.isfinite(first).sum()),
                "lost": int((np.isfinite(first) & ~met).sum()),
                "later": int((behind & np.isfinite(first[met])).sum()),
                "hits": int(error.size),
                "mean [voxel]": float(error.mean()),
                "worst [voxel]": float(error.max()),
                "limit": LIMITS.get(refine, float("inf")),
            }
        )
    return rows


class Rays:
    """Rays of pixels through the reconstructed field of a scene."""

    def __init__(self, scene: al.Scene, size: int, x: Any, y: Any) -> None:
        self.setup = prepare_reference(scene)
        self.voxel = self.setup.spacing_world
        self.iso = scene.layers[0].look.integrate.iso
        self.origin, self.direction = CAMERAS[scene.camera.name](scene.camera, (size, size), x, y)
        self.index_from_world = self.setup.layer.volume.index_from_world[:3, :3]
        self.line = self.setup.index_of(self.origin), self.direction @ self.index_from_world.T
        self.enters, self.leaves = span(self.setup, self.origin, self.direction)

    def field(self, rows: Any, t_world: Any) -> Any:
        """Values along some of the rays."""
        return field_value(self.setup, self.line[0][rows] + t_world[:, None] * self.line[1][rows])[0]

    def degrees(self, t_world: Any) -> Any:
        """Angles between rays and surfaces at places on the rays, from differences of the field inside of a voxel."""
        h = 1e-6 * self.voxel
        place = self.line[0] + t_world[:, None] * self.line[1]
        slope = [
            (field_value(self.setup, place + h * axis)[0] - field_value(self.setup, place - h * axis)[0]) / (2 * h)
            for axis in np.eye(3)
        ]
        gradient = np.stack(slope, axis=1) @ self.index_from_world
        cosine = np.abs((gradient * self.direction).sum(axis=1)) / np.maximum(np.linalg.norm(gradient, axis=1), 1e-30)
        return np.degrees(np.arcsin(np.clip(cosine, 0, 1)))


def first_surfaces(scene: al.Scene, size: int) -> np.ndarray[Any, Any]:
    """Distance (size, size) at which rays first pass the value on the way up; inf where they do not, graze, or begin beyond."""
    y, x = np.mgrid[:size, :size].reshape(2, -1)
    rays = Rays(scene, size, x, y)
    first = np.full(y.size, np.inf)
    crosses = np.nonzero(rays.leaves > rays.enters)[0]
    searched = crosses[rays.field(crosses, rays.enters[crosses] + 1e-9 * rays.voxel) < rays.iso]
    begin = rays.enters.copy()
    while searched.size:
        ends = np.stack([begin[searched], np.minimum(begin[searched] + 2 * rays.voxel, rays.leaves[searched])], axis=1)
        line = rays.line[0][searched], rays.line[1][searched]

        def along(rows: Any, t_world: Any, searched: Any = searched) -> Any:
            return rays.field(searched[rows], t_world)

        first[searched] = crossings(along, line, ends, rays.iso, np.ones(searched.size))
        begin[searched] = ends[:, 1]
        searched = searched[np.isinf(first[searched]) & (begin[searched] < rays.leaves[searched])]
    met = np.isfinite(first)
    first[met & (rays.degrees(np.where(met, first, 0.0)) <= GRAZING_DEG)] = np.inf
    return first.reshape(size, size)


def distances(scene: al.Scene, depth: np.ndarray[Any, Any]) -> tuple[Any, Any, Any, Any]:
    """Distance of hits from the nearest root of the field along their rays [voxel], roots, angles [degree], who has a root.

    A ray that begins at values beyond the surface hits the border of the volume, and has none.
    """
    y, x = np.nonzero(np.isfinite(depth))
    t_hit = depth[y, x].astype(np.float64)
    rays = Rays(scene, len(depth), x, y)

    def first(sign: int) -> Any:
        """First root before or behind the hit, as a distance from it."""
        ends = np.stack([np.zeros_like(t_hit), np.full_like(t_hit, STEP * rays.voxel)], axis=1)
        turned = rays.line[0] + t_hit[:, None] * rays.line[1], sign * rays.line[1]

        def along(rows: Any, t_world: Any) -> Any:
            return rays.field(rows, t_hit[rows] + sign * t_world)

        return crossings(along, turned, ends, rays.iso)

    both = np.stack([first(-1), first(1)])
    error = both.min(axis=0)
    t_root = t_hit + np.where(both[0] < both[1], -error, error)
    degrees = rays.degrees(np.where(np.isfinite(t_root), t_root, t_hit))
    return error / rays.voxel, t_root, degrees, t_hit > rays.enters + 1e-3 * rays.voxel


# -- time


def refining(device: Device, head: al.Volume, view: str, options: Any) -> list[dict[str, Any]]:
    """Time of each refinement relative to none, at the same step and with the same blocks."""
    scene = iso_scene(head, BONE, view, zoom=0.6)
    rows = []
    for blocks in (True, False):
        # Cells are those of blocks; they do more than to refine what was found.
        ways = [name for name in LIMITS if blocks or name != "cells"]
        frames = {r: frame_of(device, scene, options.size, STEP, refine=r, blocks=blocks) for r in ("none", *ways)}
        measured = side_by_side({n: (lambda f=f: draw_frame(f)) for n, f in frames.items()}, options.repeats, warm=2)
        for name in ways:
            one, other = (getattr(measured[n], options.clock) for n in (name, "none"))
            rows.append(
                {
                    "view": view,
                    "blocks": "yes" if blocks else "no",
                    "refine": name,
                    f"ms {options.clock}": 1e3 * float(np.median(one)),
                    "to none": ratio(one, other)["median"],
                }
            )
    return rows


def larger_steps(device: Device, head: al.Volume, view: str, options: Any) -> list[dict[str, Any]]:
    """Steps of 5 voxels in blocks against smaller ones, in three ways."""
    scene = iso_scene(head, BONE, view, zoom=0.6)
    cases = {f"{step} {way}": (scene, step, way) for step in LEAST_SPEED for way in WAYS} | {"large": (scene, STEP, "blocks")}
    cases["fixed"] = iso_scene(head, NOWHERE_BELOW, view, zoom=0.6), STEP, "blocks"
    frames = {
        name: frame_of(device, drawn, options.size, step, WAYS[way][0], blocks=WAYS[way][1])
        for name, (drawn, step, way) in cases.items()
    }
    measured = side_by_side({n: (lambda f=f: draw_frame(f)) for n, f in frames.items()}, options.repeats, warm=2)
    large, large_time = measured["large"].result, getattr(measured["large"], options.clock)
    rows = []
    for step in LEAST_SPEED:
        for way in WAYS:
            other = measured[f"{step} {way}"]
            rows.append(
                {
                    "view": view,
                    "against": step,
                    "way": way,
                    "samples": float(other.result[2].sum() / large[2].sum()),
                    f"ms at 5 {options.clock}": 1e3 * float(np.median(large_time)),
                    "fixed": 1e3 * float(np.median(getattr(measured["fixed"], options.clock))),
                    "ms": 1e3 * float(np.median(getattr(other, options.clock))),
                    "speed": ratio(getattr(other, options.clock), large_time)["median"],
                    "SSIM": ssim(grey(large[0]), grey(other.result[0])),
                }
            )
    return rows


def grey(rgba: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Luminance of a picture as it is shown."""
    return al.Image(rgba, rgba[..., 3], (0.0, 0.0, 0.0)).picture() @ np.array([0.2126, 0.7152, 0.0722]) / 255


def ssim(one: np.ndarray[Any, Any], other: np.ndarray[Any, Any]) -> float:
    """Structural similarity with a Gaussian window of 11 pixels (sigma 1.5), for a range of one (Wang et al. 2004)."""
    window = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 1.5**2))
    window /= window.sum()

    def mean(image: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        for axis in (0, 1):
            image = np.apply_along_axis(np.convolve, axis, image, window, "valid")
        return image

    a, b = mean(one), mean(other)
    variance = mean(one * one) - a * a + mean(other * other) - b * b
    both = mean(one * other) - a * b
    return float(np.mean((2 * a * b + 1e-4) * (2 * both + 9e-4) / ((a * a + b * b + 1e-4) * (variance + 9e-4))))


if __name__ == "__main__":
    sys.exit(main())
