"""Gradients: time beside error of each way to find them, what formats and quantised normals cost, and sets of directions.

The CT head's bone in an orthographic view, shaded at both ends of slabs. Errors are those of linear colours against the
float64 reference with central differences at every sample, at the same step, over pixels drawn by lot among those that show
something. Times are of frames whose textures are made; the first frame links, uploads and makes them. Angles are those between
normals of steep voxels, others than those that sets are fitted to, and the nearest direction.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from common import ROOT, arguments, by_both_clocks, described, errors, frame_of, parsed, side_by_side, table, write_json
from volumes import bone, real_volume, stand_in

import airlight as al
from airlight import reference
from airlight.gpu.device import Device, open_device
from airlight.rendering.ways import draw_frame
from airlight.stages.directions import angles_to, annealed, dodecahedron, spiral, volume_normals

Precomputed, Quantised = al.gradient.Precomputed, al.lighting.Quantised
WAYS: dict[str, dict[str, Any]] = {
    "central": {"gradient": "central"},
    "sobel": {"gradient": "sobel"},
    "precomputed, float16": {"gradient": Precomputed()},
    "precomputed, snorm8": {"gradient": Precomputed(format="snorm8")},
    "precomputed, float16, with value": {"gradient": Precomputed(with_value=True)},
    "precomputed, snorm8, with value": {"gradient": Precomputed(format="snorm8", with_value=True)},
    "quantised, dodecahedron 240": {"lighting": Quantised()},
    "quantised, spiral 255": {"lighting": Quantised("spiral", 255)},
    "quantised, annealed 240": {"lighting": Quantised("annealed", 240)},
    "quantised, annealed 255": {"lighting": Quantised("annealed", 255)},
}
BASE = "precomputed, float16"
ANNEALED = tuple(name for name in WAYS if "annealed" in name)  # fitted for seconds: quick runs do without
SHADE = al.shade.BlinnPhong(ambient=0.1, diffuse=0.7, specular=0.25, shininess=30)
LIGHTS = (al.Light.head(intensity=0.5), al.Light.directional(to_light=(0.9, 0.7, 0.8)))


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = arguments(__doc__, "gradients", repeats=7, size=512, step=1.0, clock="what is shown: cpu on a busy machine")
    parser.add_argument("--pixels", type=int, default=2000, help="pixels compared with the reference (default: 2000)")
    parser.add_argument("--docs", action="store_true", help="also write the pictures of docs/guide/quantised")
    options = parsed(parser, argv, size=24, repeats=1, pixels=30)
    volume = stand_in(24) if options.quick else real_volume("ct_head")
    device = open_device(options.device)
    try:
        about = described(device, options)
        ways = measured(device, volume, options)
        print(table(ways))
    finally:
        device.close()
    sets = directions(volume, 2000, (240,)) if options.quick else directions(volume, 200_000, (64, 240, 256, 1024))
    print("\n" + table(sets))
    if options.docs:
        write_pictures(volume, ROOT / "docs" / "guide" / "quantised")
    write_json(options.out, about | {"ways": ways, "directions": sets})
    return 0


def scene_of(volume: al.Volume, look: dict[str, Any]) -> al.Scene:
    """Shaded bone, obliquely from the front and above."""
    corners = volume.corners_world()
    middle, reach = corners.mean(axis=0), np.linalg.norm(corners - corners.mean(axis=0), axis=1).max()
    eye = middle + 3 * reach * np.array([0.4, 0.85, 0.25])
    camera = al.Camera.orthographic(eye=tuple(eye), target=tuple(middle), height=1.2 * reach)
    stages = {"shade": SHADE, "lighting": "interpolated"} | look
    return al.Scene(volume, transfer=bone(), look=al.Look(**stages), camera=camera, lights=LIGHTS, background=None)


# -- time and error


def measured(device: Device, volume: al.Volume, options: Any) -> list[dict[str, Any]]:
    """One row for each way: time, its ratio to the base, errors, bytes a voxel."""
    ways = {name: look for name, look in WAYS.items() if not (options.quick and name in ANNEALED)}
    frames = {name: frame_of(device, scene_of(volume, look), options, "auto") for name, look in ways.items()}
    made = {}
    for name, frame in frames.items():
        start = time.process_time()
        draw_frame(frame)  # links, uploads, computes
        made[name] = time.process_time() - start
    jobs: dict[str, Callable[[], Any]] = {name: (lambda f=frame: draw_frame(f)) for name, frame in frames.items()}  # type: ignore[misc]
    runs = side_by_side(jobs, options.repeats)
    truth, pixels = reference_of(volume, runs["central"].result[0], options)
    rows = []
    for name, run in runs.items():
        found = errors(run.result[0][pixels[:, 1], pixels[:, 0]], truth)
        rows.append(
            {
                "way": name,
                "ms": run.summary()[f"{options.clock}_ms"]["median"],
                "to base": by_both_clocks(run, runs[BASE])[options.clock]["median"],
                "first frame s": made[name],
                "rmse x255": 255 * found["rmse"],
                "max x255": 255 * found["max"],
                "bytes a voxel": bytes_a_voxel(frames[name]),
            }
        )
    return rows


def reference_of(volume: al.Volume, image: Any, options: Any) -> tuple[Any, Any]:
    """Colours (n, 4) by the reference with central differences, and their pixels (n, 2)."""
    shown = np.argwhere(image[..., 3] > 0.02)[:, ::-1]
    pixels = np.random.default_rng(1).permutation(shown)[: options.pixels]
    scene = scene_of(volume, {"gradient": "central"})
    return reference.render(scene, (options.size, options.size), step=options.step, pixels=pixels).rgba, pixels


def bytes_a_voxel(frame: Any) -> float:
    """Bytes of the textures that are computed at the voxels."""
    from airlight.rendering.stats import frame_statistics

    (layer,) = frame_statistics(frame, 1.0)["layers"]
    return float(sum(made["bytes"] for made in layer["voxels"].values()) / np.prod(frame.layers[0].context.volume.size))


# -- sets of directions


def directions(volume: al.Volume, count: int, sizes: tuple[int, ...]) -> list[dict[str, Any]]:
    """Angles of each set: to steep voxels that it was not fitted to, and to directions from everywhere."""
    fitted_to = volume_normals(volume, (0,), 0, seed=0)
    others = np.concatenate([volume_normals(volume, (0,), 0, seed=s) for s in range(1, 1 + max(1, count // len(fitted_to)))])
    everywhere = np.random.default_rng(2).normal(size=(len(others), 3))
    everywhere /= np.linalg.norm(everywhere, axis=1)[:, None]
    rows = []
    makers: dict[str, Callable[[], Any]] = {"dodecahedron 240": dodecahedron}
    makers |= {f"spiral {n}": (lambda n=n: spiral(n)) for n in (240, 256)}  # type: ignore[misc]
    makers |= {f"annealed {n}": (lambda n=n: annealed(fitted_to, n)) for n in sizes}  # type: ignore[misc]
    for name, make in makers.items():
        start = time.process_time()
        found = make()
        seconds = time.process_time() - start
        angles, even = angles_to(found, others), angles_to(found, everywhere)
        rows.append(
            {
                "set": name,
                "made in s": seconds,
                "mean deg": float(angles.mean()),
                "rms deg": float(np.sqrt((angles**2).mean())),
                "max deg": float(angles.max()),
                "even: mean deg": float(even.mean()),
                "even: max deg": float(even.max()),
            }
        )
    return rows


# -- pictures


def write_pictures(volume: al.Volume, folder: Path) -> None:
    """Pictures of the guide: float normals, two sets of directions, and eight times their differences."""
    folder.mkdir(parents=True, exist_ok=True)
    with al.Renderer() as renderer:

        def picture(name: str, look: dict[str, Any]) -> Any:
            image = renderer.render(on_black(scene_of(volume, look)), (420, 420), step=0.5)
            image.save(folder / f"{name}.png")
            return image

        exact = picture("exact", {})
        for name, lighting in (("dodecahedron-240", Quantised()), ("annealed-255", Quantised("annealed", 255))):
            image = picture(name, {"lighting": lighting})
            difference = 8 * np.abs(image.rgba - exact.rgba)
            difference[..., 3] = 1
            al.Image(difference.astype(np.float32), image.depth, (0.0, 0.0, 0.0), {}).save(folder / f"{name}-difference.png")


def on_black(scene: al.Scene) -> al.Scene:
    """Return the scene over black."""
    return al.Scene(layers=scene.layers, camera=scene.camera, lights=scene.lights, background=(0, 0, 0))


if __name__ == "__main__":
    sys.exit(main())
