"""Translucent surfaces found where the field has their value (`refine`), or by straight lines: error beside time.

Errors are those of pixels that show anything (the greatest channel) against the converged float64 reference: the
root mean square, which chords shorter than a step make, and quantiles, which the places of surfaces and the light there make.
Times are relative to straight lines at the same step.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import Any

import numpy as np
from common import arguments, described, frame_of, parsed, ratio, side_by_side, table, write_json
from volumes import cropped, real_volume

import airlight as al
from airlight import reference
from airlight.gpu.device import Device, open_device
from airlight.rendering.ways import draw_frame

STEPS = (1.0, 2.5, 5.0)
REFINES = ("none", "bisection", "secant", "exact")
SHEETS = (al.Surface(1.2, "steelblue", 0.3), al.Surface(2.0, "gold", 0.3, "purple"), al.Surface(2.8, "red", 0.8))
TRUTH_PIXELS = 48


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = arguments(__doc__, "crossings", repeats=7, size=256, step=1.0, clock="what is printed: cpu where others are busy")
    options = parsed(parser, argv, size=20, repeats=1)
    options.steps = STEPS[-1:] if options.quick else STEPS
    device = open_device(options.device)
    try:
        about = described(device, options)
        vortex = al.samples.load("vortex", size=24 if options.quick else 64)
        engine = real_volume("engine")
        engine = cropped(engine, 24) if options.quick else engine
        errors = [row for name, tf in functions(1.0).items() for row in errors_of(device, vortex, name, tf, options)]
        print(table(errors))
        times = [row for name, tf in functions(60.0).items() for row in times_of(device, engine, name, tf, options)]
        print("\n" + table(times))
    finally:
        device.close()
    write_json(options.out, about | {"errors": errors, "times": times})
    return 0


def functions(scale: float) -> dict[str, al.TransferFunction]:
    """Three surfaces with nothing between them, and in fog."""
    alone = al.TransferFunction.from_surfaces(al.Surface(s.value * scale, *s.front, *s.back) for s in SHEETS)
    fog = al.TransferFunction([(0.5 * scale, "steelblue", 0.0), (3.4 * scale, "white", 0.4 / scale)])
    return {"alone": alone, "in fog": fog.with_surfaces(alone.surfaces)}


def drawn_of(volume: al.Volume, tf: al.TransferFunction) -> al.Scene:
    """The same look for all: `exact` is for trilinear fields."""
    camera = al.fit_camera("iso", volume.corners_world(), 1.0)
    return al.Scene(volume, transfer=tf, look=al.Look(field="linear_exact"), camera=camera, background=None)


def errors_of(device: Device, volume: al.Volume, name: str, tf: al.TransferFunction, options: Any) -> list[dict[str, Any]]:
    """Errors of every way at every step."""
    scene, pixels = drawn_of(volume, tf), min(options.size, TRUTH_PIXELS)
    truth = reference.converged(scene, (pixels, pixels), step=1 / 4 if options.quick else 1 / 16).rgba
    seen = truth[..., 3] > 0
    rows = []
    for step in options.steps:
        for refine in REFINES:
            frame = frame_of(device, scene, Namespace(size=pixels, step=step), refine=refine)
            error = np.abs(draw_frame(frame)[0] - truth).max(axis=-1)[seen]
            quantiles = {f"q{100 * q:.0f} x255": 255 * float(np.quantile(error, q)) for q in (0.5, 0.75, 0.9)}
            rms = {"rms x255": 255 * float(np.sqrt(np.mean(error**2)))}
            rows.append({"surfaces": name, "step": step, "refine": refine} | rms | quantiles)
    return rows


def times_of(device: Device, volume: al.Volume, name: str, tf: al.TransferFunction, options: Any) -> list[dict[str, Any]]:
    """Time of every way relative to straight lines, in turns."""
    scene, rows = drawn_of(volume, tf), []
    for step in options.steps:
        shown = Namespace(size=options.size, step=step)
        frames = {refine: frame_of(device, scene, shown, refine=refine) for refine in REFINES}
        measured = side_by_side({n: (lambda f=f: draw_frame(f)) for n, f in frames.items()}, options.repeats, warm=2)
        for refine in REFINES:
            one, other = (getattr(measured[n], options.clock) for n in (refine, "none"))
            row = {"surfaces": name, "step": step, "refine": refine, f"ms {options.clock}": 1e3 * float(np.median(one))}
            rows.append(row | {"to none": ratio(one, other)["median"]})
    return rows


if __name__ == "__main__":
    sys.exit(main())
