"""Time and error side by side with VTK: same volume, camera, function, size and steps, drawn in turns.

The same picture without light is compared with airlight's converged float64 reference. With light the models differ, so each
renderer is compared with its own picture at 1/8 voxel, and so it is without light, too. Surfaces of equal value are drawn by
VTK's GPU mapper alone; here steps may be larger, since hits are refined. Time without error is no figure.
VTK draws 8 bits, so its errors have a floor near 0.3/255 RMSE. Needs VTK (dependency group ``bench``), no display.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from common import arguments, errors, machine, parsed, ratio, side_by_side, table, write_json
from volumes import bone, brain, cropped, real_volume

import airlight as al
from airlight import reference
from airlight.benchmark.vtk_side import load_vtk, mappers_of, vtk_picture

STEPS = (2.0, 1.0, 0.5)
SURFACE_STEPS = (5.0, 1.0, 0.25)
BONE_HU, IVORY = 300.0, (0.9, 0.8, 0.65)
CONVERGED_STEP = 1 / 8
GPU_MAPPER = "VTK GPU mapper"
TINY = 1e-12
ADAPTIVE = {"driver": al.driver.March(adaptive=True)}
OURS: dict[str, dict[str, Any]] = {
    "airlight, pre-integrated": {},
    "airlight, post-classified": {"transfer": "postclassified"},
    "airlight, post-classified, adaptive": {"transfer": "postclassified", **ADAPTIVE},
}
# Gradients kept in a texture; light at both ends of slabs (Lum, Wilson and Ma), or at two places in them.
KEPT = {"gradient": "precomputed"}
LIT: dict[str, dict[str, Any]] = {
    "airlight, gradients kept, interpolated": {"lighting": "interpolated", **KEPT},
    "airlight, gradients kept, supersampled": {"lighting": "supersampled", **KEPT},
    "airlight, gradients kept, supersampled, adaptive": {"lighting": "supersampled", **KEPT, **ADAPTIVE},
}
SURFACES: dict[str, dict[str, Any]] = {
    f"airlight, {refine}": {"driver": al.driver.March(refine=refine)} for refine in ("bisection", "exact")
}

Draw = Callable[[float], np.ndarray[Any, Any]]


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when pictures do not show the same thing."""
    parser = arguments(__doc__, "against_vtk", repeats=5, size=512, clock="what the table shows: cpu on a busy machine")
    parser.add_argument("--pixels", type=int, default=4000, help="pixels compared with the reference (default: 4000)")
    parser.add_argument("--pictures", action="store_true", help="also write the pictures beside the JSON")
    options = parsed(parser, argv, size=64, repeats=1, pixels=200)
    try:
        load_vtk()
    except ImportError:
        print('VTK is not installed: pip install "vtk>=9.4" (dependency group bench)', file=sys.stderr)
        return 2
    rows: list[dict[str, Any]] = []
    checks: list[dict[str, Any]] = []
    with al.Renderer() as renderer:
        for name, drawn in cases(options.quick).items():
            found, check, adapter = compare(renderer, name, drawn, options)
            rows += found
            checks += check
            print(table([shown(row, options.clock) for row in found]) + "\n", flush=True)
    faster = [at_equal_error(rows, name, options.clock) for name in dict.fromkeys(row["scene"] for row in rows)]
    print("Times faster than VTK's GPU mapper at the error that it has at a step, each against its own picture at 1/8 voxel:\n")
    print("\n\n".join(table(of_scene) for of_scene in faster) + "\n")
    print("Do they show the same thing? Against airlight's picture at 1/8 voxel:\n")
    print(table(checks))
    # With light the models differ by more than a shift of half a pixel changes; the view is the same as without.
    alike = all(check["same view"] for check in checks if "unshaded" in check["scene"])
    results = {"quick": options.quick, "size": options.size, "clock": options.clock, "rows": rows, "checks": checks}
    results["times_faster"] = [row for of_scene in faster for row in of_scene]
    write_json(options.out, machine() | {"adapter": adapter} | results)
    return 0 if alike or options.quick else 1


def cases(quick: bool = False) -> dict[str, al.Scene]:
    """Scenes by name, in a world without turns: spacing alone."""
    found = {}
    for name, function in (("ct_head", bone()), ("ch2", brain())):
        volume = real_volume(name)
        if quick:
            volume = cropped(volume, 32)
        volume = al.Volume(np.ascontiguousarray(volume.array), spacing=volume.spacing, units=volume.units, name=name)
        camera = al.fit_camera("iso", volume.corners_world(), 1.0)
        # VTK's head light shines along the view, airlight's along each ray.
        to_light = tuple(np.subtract(camera.eye, camera.target))
        lights = (al.Light.directional(to_light=to_light),)
        for shade in ("none", "blinn_phong"):
            look = al.Look(shade=shade)
            scene = al.Scene(volume, transfer=function, camera=camera, look=look, lights=lights)
            found[f"{name}, {'unshaded' if shade == 'none' else 'shaded'}"] = scene
        if name == "ct_head":
            ivory = al.TransferFunction([(0.0, IVORY, 1.0), (BONE_HU, IVORY, 1.0)])
            look = al.Look(integrate=al.integrate.FirstHit(iso=BONE_HU))
            found[f"{name}, surface"] = al.Scene(volume, transfer=ivory, camera=camera, look=look, lights=lights)
    return found


def compare(renderer: al.Renderer, name: str, scene: al.Scene, options: Any) -> tuple[list[Any], list[Any], dict[str, str]]:
    """Draw one scene with all renderers at all steps, in turns."""
    size = (options.size, options.size)
    pictures = {label: vtk_picture(scene, size, mapper) for label, mapper in mappers_of(scene).items()}
    unlit = scene.layers[0].look.shade.name == "none"
    is_surface = isinstance(scene.layers[0].look.integrate, al.integrate.FirstHit)
    ways = SURFACES if is_surface else OURS if unlit else OURS | LIT
    draws: dict[str, Draw] = {label: ours(renderer, scene, size, **way) for label, way in ways.items()}
    draws |= {label: picture.draw for label, picture in pictures.items()}
    converged = {label: draw(CONVERGED_STEP) for label, draw in draws.items()}
    first = converged[next(iter(ways))]
    pixels, truth = None, None
    if unlit:
        pixels = some_pixels(first, options.pixels)
        truth = reference.converged(scene, size, pixels=pixels).rgba[:, :3]
    rows = []
    for step in SURFACE_STEPS if is_surface else STEPS:
        jobs = {label: (lambda draw=draw, step=step: draw(step)) for label, draw in draws.items()}
        measured = side_by_side(jobs, options.repeats)
        base = measured[next(iter(ways))]
        for label, run in measured.items():
            row = {"scene": name, "renderer": label, "step": step} | run.summary()
            row["own"] = errors(run.result, converged[label])
            if pixels is not None:
                row["reference"] = errors(run.result[pixels[:, 1], pixels[:, 0]], truth)
            row["times_airlight"] = {"wall": ratio(run.wall, base.wall), "cpu": ratio(run.cpu, base.cpu)}
            rows.append(row)
    checks = [{"scene": name, "renderer": label} | view_check(converged[label], first) for label in pictures]
    if options.pictures:
        save(converged, options.out.parent, name)
    for picture in pictures.values():
        picture.close()
    return rows, checks, renderer.render(scene, (16, 16)).stats["adapter"]


def ours(renderer: al.Renderer, scene: al.Scene, size: tuple[int, int], driver: Any = "march", **stages: Any) -> Draw:
    """Return what draws the scene in airlight with some stages, linear colours over black."""
    (layer,) = scene.layers
    look = al.Look(shade=layer.look.shade, integrate=layer.look.integrate, **stages)
    staged = al.Scene(layer.volume, transfer=layer.transfer, camera=scene.camera, look=look, lights=scene.lights)
    return lambda step: renderer.render(staged, size, step=step, driver=driver).rgb


def at_equal_error(rows: list[dict[str, Any]], scene: str, clock: str) -> list[dict[str, Any]]:
    """How many times faster each of our ways is than VTK's GPU mapper, at each of the steps that it took.

    Our times lie between steps on straight lines of the logarithms of error and time; where even the largest step has less
    error, its time counts. None where the smallest step has more.
    """
    of_scene = [row for row in rows if row["scene"] == scene]
    theirs = [row for row in of_scene if row["renderer"] == GPU_MAPPER]
    found = []
    for way in dict.fromkeys(row["renderer"] for row in of_scene if "airlight" in row["renderer"]):
        taken = [row for row in of_scene if row["renderer"] == way]
        known = sorted((max(row["own"]["rmse"], TINY), row[f"{clock}_ms"]["median"]) for row in taken)
        error, ms = np.log(np.array(known)).T
        speeds = {}
        for row in theirs:
            asked = np.log(max(row["own"]["rmse"], TINY))
            speed = row[f"{clock}_ms"]["median"] / float(np.exp(np.interp(asked, error, ms)))
            speeds[f"step {row['step']:g}"] = speed if asked >= error[0] else None
        found.append({"scene": scene, "renderer": way} | speeds)
    return found


def some_pixels(picture: Any, count: int) -> Any:
    """Pixels (n, 2), x and y, drawn by lot among those that show something."""
    y, x = np.nonzero(picture.max(axis=-1) > 0.01)
    taken = np.random.default_rng(7).permutation(len(x))[:count]
    return np.stack([x[taken], y[taken]], axis=1)


def view_check(picture: Any, first: Any) -> dict[str, Any]:
    """Whether a picture is nearer to airlight's as it is than mirrored or shifted by half a pixel or more."""
    picture, first = picture.astype(np.float64), first.astype(np.float64)
    half = (first + np.roll(first, 1, axis=1)) / 2, (first + np.roll(first, 1, axis=0)) / 2
    others = {
        "mirrored left and right": first[:, ::-1],
        "mirrored up and down": first[::-1],
        "right by half a pixel": half[0],
        "left by half a pixel": np.roll(half[0], -1, axis=1),
        "down by half a pixel": half[1],
        "up by half a pixel": np.roll(half[1], -1, axis=0),
    }
    here = errors(picture, first)
    found = {name: errors(picture, other)["rmse"] for name, other in others.items()}
    nearest = min(found, key=lambda name: found[name])
    return {"rmse": here["rmse"], "max": here["max"], "next best": nearest, "its rmse": found[nearest]} | {
        "same view": here["rmse"] < found[nearest]
    }


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """One row of the printed table."""
    return {
        "scene": row["scene"],
        "renderer": row["renderer"],
        "step": row["step"],
        f"ms ({clock})": row[f"{clock}_ms"]["median"],
        "least": row[f"{clock}_ms"]["min"],
        "time / airlight's": row["times_airlight"][clock]["median"],
        "rmse, own": row["own"]["rmse"],
        "psnr, own": row["own"]["psnr_db"],
        "rmse, reference": row.get("reference", {}).get("rmse"),
        "psnr, reference": row.get("reference", {}).get("psnr_db"),
    }


def save(pictures: dict[str, Any], folder: Any, name: str) -> None:
    """Write pictures as PNG files."""
    from PIL import Image

    from airlight.transfer.colour import linear_to_srgb

    folder.mkdir(parents=True, exist_ok=True)
    strip = np.concatenate([linear_to_srgb(np.clip(p, 0, 1)) for p in pictures.values()], axis=1)
    Image.fromarray((255 * strip + 0.5).astype(np.uint8)).save(folder / f"against_vtk {name}.png")


if __name__ == "__main__":
    sys.exit(main())
