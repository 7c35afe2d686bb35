"""How far the device's images are from the float64 reference; not a matter of time.

At steps of 1/8 voxel, perspective and orthographic, on the CT head and on an analytic field: unshaded at most 1/255 anywhere
from the converged reference; shaded a root mean square error of at most 0.0025 from the converged one, and at most 1/255
anywhere from the reference with the same steps and stages. Compared are linear, premultiplied colours and opacity of pixels
drawn by lot among those that show something. The last column of numbers is what the method itself is off at these steps,
whoever computes it.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from common import arguments, errors, machine, parsed, table, write_json
from volumes import bone, cropped, flow, head, real_volume

import airlight as al
from airlight import reference

STEP = 1 / 8
ANYWHERE = 1 / 255
SHADED_RMSE = 0.0025
LIGHTS = (al.Light.head(intensity=0.7), al.Light.directional(to_light=(1, -1, 1), color=(1, 0.9, 0.8), intensity=0.5))


def main(argv: list[str] | None = None) -> int:
    """Compare, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "accuracy", size=256, step=STEP)
    parser.add_argument("--pixels", type=int, default=2000, help="pixels of each picture that are compared (default: 2000)")
    parser.add_argument("--only", default="", help="only the cases whose name contains this")
    options = parsed(parser, argv, size=48, pixels=60, step=0.5)
    started, rows, adapter = time.time(), [], None
    with al.Renderer(device=options.device) as renderer:
        for name, scene in list(cases(options.quick))[:: 3 if options.quick else 1]:
            if options.only in name and shows_something(renderer, scene, (options.size, options.size)):
                found, adapter = compare(renderer, scene, (options.size, options.size), options.pixels, options.step)
                for transfer, row in found.items():
                    rows.append({"case": f"{name}, {transfer}"} | row)
                    print(line(rows[-1]), flush=True)
    print("\n" + table([shown(row) for row in rows]))
    for transfer in ("preintegrated", "postclassified"):
        of_stage = [row["passes"] for row in rows if row["case"].endswith(transfer)]
        print(f"\n{transfer}: {sum(of_stage)} of {len(of_stage)} within the bars", end="")
    passed = all(r["passes"] for r in rows)
    print(f"\n\n{'PASS' if passed else 'FAIL'} in {time.time() - started:.0f} s")
    bars = {"step": options.step, "unshaded_max": ANYWHERE, "shaded_rmse": SHADED_RMSE, "shaded_max_same_steps": ANYWHERE}
    write_json(options.out, machine() | {"adapter": adapter, "quick": options.quick, "bars": bars, "cases": rows})
    return 0 if passed or options.quick else 1


def cases(quick: bool = False) -> Iterator[tuple[str, al.Scene]]:
    """Scenes by name: volumes with functions, both kinds of cameras, lit or not."""
    ct = real_volume("ct_head")
    field = al.samples.load("vortex", size=24 if quick else 64)
    if quick:
        ct = cropped(ct, 32)
    drawn = {
        "CT head, gentle": (ct, gentle()),
        "CT head, bone": (ct, bone()),
        "CT head, skin and bone": (ct, head()),
        "CT head, automatic": (ct, al.first_picture(ct).layers[0].transfer),
        "vortex": (field, flow()),
    }
    for name, (volume, function) in list(drawn.items())[:: 3 if quick else 1]:
        for kind, camera in cameras(volume).items():
            for shade in ("none", "blinn_phong"):
                look = al.Look(shade=shade)
                scene = al.Scene(volume, transfer=function, camera=camera, look=look, lights=LIGHTS, background=None)
                yield f"{name}, {kind}, {'unshaded' if shade == 'none' else 'shaded'}", scene


def gentle() -> al.TransferFunction:
    """Return the function of the guide's first example."""
    return al.TransferFunction([(0, (0, 0, 0), 0.0), (300, (1, 0.6, 0.4), 0.02), (1200, (1, 1, 1), 0.5)])


def cameras(volume: al.Volume) -> dict[str, al.Camera]:
    """Return a perspective camera and an orthographic one in its place."""
    near = al.fit_camera("iso", volume.corners_world(), 1.0)
    distance = float(np.linalg.norm(np.subtract(near.target, near.eye)))
    height = 2 * distance * float(np.tan(np.radians(near.fov_deg) / 2))
    return {
        "perspective": near,
        "orthographic": al.Camera.orthographic(eye=near.eye, target=near.target, up=near.up, height=height),
    }


def shows_something(renderer: al.Renderer, scene: al.Scene, size: tuple[int, int]) -> bool:
    """Whether there is anything to compare: a cropped or computed volume may hold nothing of what a function shows."""
    return bool((renderer.render(scene, size).rgba[..., 3] > 0).any())


def compare(
    renderer: al.Renderer, scene: al.Scene, size: tuple[int, int], count: int, step: float
) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
    """Errors of one scene by its stages, and the adapter. All of them converge to the same picture."""
    image = renderer.render(scene, size, step=step)
    pixels = chosen_pixels(image, count)
    converged = reference.converged(scene, size, pixels=pixels, step=step / 4).rgba
    shaded = scene.layers[0].look.shade.name != "none"
    covered = float((image.rgba[..., 3] > 0).mean())
    found = {}
    kinds = [("preintegrated", "sampled"), ("postclassified", "sampled")]
    for transfer, lighting in [*kinds, ("preintegrated", "supersampled")] if shaded else kinds:
        staged = with_stages(scene, transfer=transfer, lighting=lighting)
        drawn = renderer.render(staged, size, step=step).rgba[pixels[:, 1], pixels[:, 0]]
        same = reference.render(staged, size, step=step, pixels=pixels).rgba
        to_same, to_converged = errors(drawn, same), errors(drawn, converged)
        # Pixels that show nothing have no error at all: over the whole picture it is less than over those that are compared.
        to_converged["rmse_of_picture"] = to_converged["rmse"] * covered**0.5
        lit_well = to_converged["rmse_of_picture"] <= SHADED_RMSE and to_same["max"] <= ANYWHERE
        found[f"{transfer}, {lighting}" if shaded else transfer] = {
            "covered": covered,
            "shaded": shaded,
            "pixels": len(pixels),
            "same": to_same | worst(drawn, same, pixels),
            "converged": to_converged | worst(drawn, converged, pixels),
            "reference_same_to_converged": errors(same, converged),
            "passes": lit_well if shaded else to_converged["max"] <= ANYWHERE,
        }
    return found, image.stats["adapter"]


def with_stages(scene: al.Scene, **names: str) -> al.Scene:
    """Return a scene with other stages, by slot and name."""
    (layer,) = scene.layers
    look = layer.look
    for slot, name in names.items():
        look = al.edit(look, slot, getattr(al.Look(**{slot: name}), slot))
    return al.Scene(layer.volume, transfer=layer.transfer, camera=scene.camera, look=look, lights=scene.lights, background=None)


def chosen_pixels(image: al.Image, count: int) -> np.ndarray[Any, Any]:
    """Pixels (n, 2), x and y, drawn by lot among those that show something."""
    y, x = np.nonzero(image.rgba[..., 3] > 0)
    taken = np.random.default_rng(7).permutation(len(x))[:count]
    return np.stack([x[taken], y[taken]], axis=1)


def worst(drawn: Any, truth: Any, pixels: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Where the greatest error lies, and which share of the pixels misses 1/255."""
    error = np.abs(drawn - truth).max(axis=1)
    return {"worst_pixel": pixels[int(error.argmax())].tolist(), "share_above": float((error > ANYWHERE).mean())}


def shown(row: dict[str, Any]) -> dict[str, Any]:
    """One row of the printed table."""
    return {
        "case": row["case"],
        "to converged: max [1/255]": 255 * row["converged"]["max"],
        "rmse": row["converged"]["rmse"],
        "rmse of picture": row["converged"]["rmse_of_picture"],
        "to same steps: max [1/255]": 255 * row["same"]["max"],
        "reference with same steps to converged: max [1/255]": 255 * row["reference_same_to_converged"]["max"],
        "passes": row["passes"],
    }


def line(row: dict[str, Any]) -> str:
    """One case on a line."""
    found, same = row["converged"], row["same"]
    parts = (
        f"{'PASS' if row['passes'] else 'FAIL'}  {row['case']}: converged max {255 * found['max']:.3f}/255",
        f"rmse {found['rmse']:.5f} (of the picture {found['rmse_of_picture']:.5f}),",
        f"same steps max {255 * same['max']:.3f}/255 rmse {same['rmse']:.5f} at {same['worst_pixel']}",
    )
    return " ".join(parts)


if __name__ == "__main__":
    sys.exit(main())
