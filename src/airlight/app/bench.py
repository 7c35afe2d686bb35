"""``airlight bench``: times of a small, fixed set of scenes."""

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..scene import Look, Scene
from ..stage import Stage
from ..stages.shade import BlinnPhong
from ..transfer import TransferFunction
from ..volume import Volume
from .parse import parse_size
from .render import plain

REPEATS = 3
LOOKS: dict[str, dict[str, str | Stage]] = {
    "post-classified, unshaded": {"transfer": "postclassified", "shade": "none"},
    "pre-integrated, unshaded": {"transfer": "preintegrated", "shade": "none"},
    "pre-integrated, shaded": {"transfer": "preintegrated", "shade": BlinnPhong()},
    "pre-integrated, shaded, precomputed gradients": {"shade": BlinnPhong(), "gradient": "precomputed"},
    "maximum intensity": {"integrate": "mip"},
    "first hit": {"integrate": "first_hit"},
}


def bench(
    *,
    size: Annotated[str, Parameter(metavar="WxH", help="Width and height in pixels; 512x512 unless told.")] = "512x512",
    voxels: Annotated[int, Parameter(help="Voxels along each axis of the computed volume; 128 unless told.")] = 128,
    output: Annotated[
        str | None, Parameter(name=["--json", "-o"], metavar="FILE.json", help="Also write the JSON to a file.")
    ] = None,
    device: Annotated[str | None, Parameter(metavar="NAME", help="Adapter, by a part of its name or kind.")] = None,
) -> None:
    """Time a fixed set of scenes of a computed volume; the first frame of each is not counted. Prints a table, then JSON.

    For instance:

        airlight bench
        airlight bench --size 1024x1024 --voxels 256 -o bench.json
    """
    results = run(parse_size(size), voxels, device)
    _print_table(results)
    text = json.dumps(results, indent=2, default=plain)
    print(text)
    if output is not None:
        Path(output).write_text(text + "\n", encoding="utf-8")


def run(size: tuple[int, int] = (512, 512), voxels: int = 128, device: str | None = None) -> dict[str, Any]:
    """Render each scene ``1 + REPEATS`` times and return the fastest frame of each, with its statistics."""
    from ..rendering.renderer import Renderer

    volume = shells(voxels)
    rows = []
    adapter: Any = None
    with Renderer(device=device) as renderer:
        for name, look in LOOKS.items():
            scene = Scene(volume, transfer=FUNCTION, look=Look(**look), camera="iso")
            frames = [renderer.render(scene, size).stats for _ in range(1 + REPEATS)]
            best = min(frames[1:], key=lambda stats: stats["milliseconds"]["total"])
            first = frames[0]["milliseconds"]["total"]
            adapter = best["adapter"]
            rows.append({"scene": name, "first": first, "milliseconds": best["milliseconds"], "samples": best["samples"]})
    return {"adapter": adapter, "size": list(size), "voxels": voxels, "repeats": REPEATS, "scenes": rows}


def shells(voxels: int) -> Volume:
    """Nested shells in a ball: some space is empty, some is dense."""
    axis = np.linspace(-1, 1, voxels, dtype=np.float32)
    radius = np.sqrt(axis[:, None, None] ** 2 + axis[None, :, None] ** 2 + axis[None, None, :] ** 2)
    values = np.where(radius < 1, 0.5 + 0.5 * np.cos(12 * np.pi * radius), 0) * 255
    return Volume(values.astype(np.uint8), name="shells")


FUNCTION = TransferFunction([(100, "#204060", 0.0), (180, "#e08040", 0.02), (255, "white", 0.3)])


def _print_table(results: dict[str, Any]) -> None:
    width, height = results["size"]
    print(f"{results['adapter']['name']}, {width}x{height}, {results['voxels']}^3 voxels, best of {results['repeats']}")
    print(f"{'scene':<46} {'samples':>12} {'Msamples/s':>11} {'ms':>8}  of which")
    for row in results["scenes"]:
        times = dict(row["milliseconds"])
        total = times.pop("total")
        passes = ", ".join(f"{name} {ms:.1f}" for name, ms in times.items())
        print(f"{row['scene']:<46} {row['samples']:>12,} {row['samples'] / total / 1e3:>11.1f} {total:>8.1f}  {passes}")
