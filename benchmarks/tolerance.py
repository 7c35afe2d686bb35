"""Pictures of a known error: how far they are off, beside what they promise and what they cost.

Each scene is drawn within several tolerances, and at a step of a voxel. *true* is the greatest difference of chosen pixels
from the float64 reference at 1/64 of a voxel; pixels that ``image.stats`` says are still over the tolerance are counted as
*open* and left out. A row is wrong where *true* exceeds the tolerance.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from common import arguments, machine, parsed, table, write_json
from volumes import cropped, real_volume

import airlight as al
from airlight import reference
from airlight.benchmark.scenes import bone, head, noisy_cloud, shells
from airlight.gpu.device import open_device

FINE = 1 / 64
TOLERANCES = (0.05, 0.02, 0.01)


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a picture is farther off than it says."""
    parser = arguments(__doc__, "tolerance", size=96)
    parser.add_argument("--pixels", type=int, default=300, help="pixels that are compared (default: %(default)s)")
    parser.add_argument("--device", default=None, help="adapter, by number, kind or part of its name")
    options = parsed(parser, argv, size=24, pixels=20)
    device = open_device(options.device)
    about = machine(device) | {"quick": options.quick, "size": options.size, "pixels": options.pixels}
    device.close()
    shown = list(scenes(options.quick).items())[:: 2 if options.quick else 1]
    with al.Renderer(options.device) as renderer:
        rows = [row for name, scene in shown for row in of_scene(renderer, name, scene, options)]
    print(table(rows))
    passed = all(row["true"] <= row["tolerance"] for row in rows if row["tolerance"] is not None)
    print("\n" + ("PASS" if passed else "FAIL"))
    write_json(options.out, about | {"rows": rows, "passed": passed})
    return 0 if passed else 1


def scenes(quick: bool) -> dict[str, al.Scene]:
    """Real and computed volumes, with light and without."""
    ct = real_volume("ct_head")
    ct = cropped(ct, 32) if quick else ct
    spiky = [(v + d, rgb, t) for v, rgb in ((-300, "tan"), (50, "red"), (700, "white")) for d, t in ((-30, 0), (0, 1), (30, 0))]
    cloud, shell = noisy_cloud(16 if quick else 64), shells(24 if quick else 64)
    haze = al.TransferFunction([(60, "blue", 0.005), (140, "orange", 0.02), (220, "white", 0.08)])
    thin = al.TransferFunction([(120, "gold", 0), (128, "gold", 0.8), (136, "gold", 0)])
    looks = {"lit": al.Look(), "unlit": al.Look(shade="none")}
    return {
        "CT head, bone, lit": al.Scene(ct, transfer=bone(), look=looks["lit"]),
        "CT head, skin and bone, unlit": al.Scene(ct, transfer=head(), look=looks["unlit"]),
        "CT head, three peaks, unlit": al.Scene(ct, transfer=al.TransferFunction(spiky), look=looks["unlit"]),
        "noisy cloud, unlit": al.Scene(cloud, transfer=haze, look=looks["unlit"], camera="iso"),
        "thin shells, lit": al.Scene(shell, transfer=thin, look=looks["lit"], camera="iso"),
        "CT head, maximum": al.Scene(ct, transfer=bone(), look=al.Look(shade="none", integrate="mip")),
    }


def of_scene(renderer: al.Renderer, name: str, scene: al.Scene, options: Any) -> list[dict[str, Any]]:
    """Rows of one scene: a plain picture, then those within the tolerances."""
    size = (options.size, options.size)
    pixels = np.random.default_rng(1).integers(0, options.size, (options.pixels, 2))
    plain = renderer.render(scene, size)
    right = reference.converged(plain.scene, size, pixels=pixels, step=1 / 16 if options.quick else FINE).rgba
    return [row(renderer, name, scene, size, pixels, right, tolerance) for tolerance in (None, *TOLERANCES)]


def row(
    renderer: al.Renderer, name: str, scene: al.Scene, size: tuple[int, int], pixels: Any, right: Any, tolerance: float | None
) -> dict[str, Any]:
    """One picture: what it promises, what is true of chosen pixels, what it took."""
    begin = time.process_time()
    image = renderer.render(scene, size, tolerance=tolerance)
    spent_ms = 1e3 * (time.process_time() - begin)
    told = image.stats.get("tolerance", {})
    x, y = pixels.T
    off = np.abs(image.rgba[y, x] - right).max(axis=1)
    held = off if image.estimate is None else off[image.estimate[y, x] <= tolerance]
    return {
        "scene": name,
        "tolerance": tolerance,
        "estimate": told.get("maximum"),
        "true": float(held.max(initial=0.0)),
        "open": told.get("pixels_over", 0),
        "samples": image.stats["samples"],
        "ms (cpu)": spent_ms,
    }


if __name__ == "__main__":
    sys.exit(main())
