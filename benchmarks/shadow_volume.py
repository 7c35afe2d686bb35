"""Shadow volumes: what cells cost the picture, and what time they take.

*Errors*, against rays to the light of the reference with a fixed bias: *rms* of the picture over what is covered; *lit*, what
is left of the light where nearly all of it should arrive; *leaked*, what arrives where next to none should. *Times*: *make*,
the first frame of a pixel with another function, less one without shadows; *turn*, the same with another light alone; *draw
ratio*, frames that find it made to frames without it.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import numpy as np
from common import arguments, described, parsed, side_by_side, table, write_json
from volumes import cropped, real_volume

import airlight as al
from airlight import reference
from airlight.gpu.device import open_device
from airlight.reference import half_angle, shadows
from airlight.reference.setup import Setup
from airlight.stages.transport import Opaque

CELLS = (16, 32, 64, 128)
WAYS = ("sweep", "rays")
BIAS = 2.0
TRUTH_PIXELS = 56
LIT, DARK = 0.9, 0.05
SHADE = al.shade.BlinnPhong(ambient=0.0, diffuse=1.0, specular=0.0, two_sided=False)
SKULL = al.TransferFunction([(150, (0.9, 0.85, 0.75), 0.0), (400, (0.9, 0.85, 0.75), 1.0)])


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = arguments(__doc__, "shadow_volume", repeats=5, size=400, step=1.0, clock="what is told: cpu where others are busy")
    parser.add_argument("--only", choices=("errors", "times"), help="leave out the other table")
    options = parsed(parser, argv, size=24, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    volume = real_volume("ct_head")
    volume = cropped(volume, 40) if options.quick else volume
    found: dict[str, Any] = {}
    with al.Renderer(options.device) as renderer:
        if options.only != "times":
            found["errors"] = errors_of(renderer, volume, options)
            print(table(found["errors"]))
        if options.only != "errors":
            found["times"] = times_of(renderer, volume, options)
            print(table(found["times"]))
    write_json(options.out, about | found)
    return 0


def drawn(volume: al.Volume, visibility: Any, density: float = 1.0, turn: float = 0.0) -> al.Scene:
    """Scene of a skull from its face, lit from the side; a turn moves the light a bit."""
    light = al.Light.directional(to_light=(1.0, 0.8 + turn, 0.5))
    layer = al.Layer(volume, SKULL, al.Look(shade=SHADE, visibility=visibility), density=density)
    return al.Scene(layers=[layer], camera="back", lights=[light], background=None)


def errors_of(renderer: al.Renderer, volume: al.Volume, options: Any) -> list[dict[str, Any]]:
    """Rows of ways and resolutions."""
    pixels = min(options.size, TRUTH_PIXELS)
    size = (pixels, pixels)

    def exact(setup: Setup, light_index: int | None, p_world: Any) -> Any:
        if light_index is None:
            return np.ones_like(p_world)
        lamp, spacing = setup.lights[light_index], setup.spacing_world
        return half_angle.transmittance(setup, lamp, shadows.nearer(lamp, p_world, BIAS * spacing), Opaque(), spacing / 2)

    cells = CELLS[:2] if options.quick else CELLS
    ways = [*((way, BIAS) for way in WAYS), ("sweep", None)]
    stages = [al.visibility.ShadowVolume(cells=n, by=way, bias=bias) for way, bias in ways for n in cells]
    found = [renderer.render(drawn(volume, stage), size, step=options.step).rgba for stage in stages]
    plain = renderer.render(drawn(volume, "none"), size, step=options.step).rgba
    reference.register("visibility", "shadow_volume", exact)
    try:
        truth = reference.render(drawn(volume, "shadow_volume"), size, step=options.step).rgba
    finally:
        reference.register("visibility", "shadow_volume", shadows.shadow_volume)
    covered, bright = truth[..., 3] > 0.5, plain[..., 0] > 0.1
    share = truth[..., 0] / np.maximum(plain[..., 0], 1e-6)
    lit, dark = bright & (share > LIT), bright & (share < DARK)

    def row(way: str, cells: int | None, bias: Any, rgba: Any) -> dict[str, Any]:
        part = rgba[..., 0] / np.maximum(plain[..., 0], 1e-6)
        rms = float(np.sqrt(np.mean((rgba - truth)[covered][:, :3] ** 2)))
        told = {"by": way, "cells": cells, "bias": bias, "rms": rms}
        return told | {"lit": float(part[lit].mean()), "leaked": float(part[dark].mean())}

    rows = [row("no shadows", None, None, plain), row("the reference", None, BIAS, truth)]
    return rows + [row(stage.by, stage.cells, stage.bias or "a cell", rgba) for stage, rgba in zip(stages, found, strict=True)]


def times_of(renderer: al.Renderer, volume: al.Volume, options: Any) -> list[dict[str, Any]]:
    """Rows of ways and resolutions."""
    others = iter(np.arange(1.0, 2.0, 1e-4))

    def frame(visibility: Any, pixels: int, what: str) -> Any:
        other = float(next(others)) if what else 1.0
        scene = drawn(volume, visibility, **({what: other} if what else {}))
        return renderer.render(scene, (pixels, pixels), step=options.step)

    def seconds(stage: Any, pixels: int, what: str = "") -> tuple[Any, Any]:
        ways = {"with": stage, "without": "none"}
        runs = side_by_side({n: partial(frame, v, pixels, what) for n, v in ways.items()}, options.repeats)
        with_it, without = (np.array(getattr(runs[n], options.clock)) for n in ways)
        return with_it, without

    rows = []
    for way in WAYS:
        for cells in CELLS[:2] if options.quick else CELLS:
            stage = al.visibility.ShadowVolume(cells=cells, by=way)
            (made, plain), (turned, still) = seconds(stage, 1, "density"), seconds(stage, 1, "turn")
            drawing, bare = seconds(stage, options.size)
            row = {"by": way, "cells": cells, "make ms": 1e3 * float(np.median(made - plain))}
            row |= {"turn ms": 1e3 * float(np.median(turned - still)), "draw ms": 1e3 * float(np.median(drawing))}
            rows.append(row | {"draw ratio": float(np.median(drawing / bare))})
    return rows


if __name__ == "__main__":
    sys.exit(main())
