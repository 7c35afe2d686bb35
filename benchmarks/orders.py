"""Orders of classification and interpolation: error beside samples and time, and how little the step matters.

Pre-classified, post-classified and pre-integrated pictures (fast, with attenuation, and with values put right for curvature) at
steps from 4 voxels to 1/4, unlit. Errors are root mean squares of linear, premultiplied colours and opacity against the
converged float64 reference of the interpolated samples, over pixels drawn by lot among those that show something. A function is
*spiky* with three peaks, each a hundredth of its range wide; *random* as in figures 3 and 39 of Engel and Ertl (2002).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import ROOT, arguments, errors, from_corner, machine, parsed, side_by_side, table, write_json
from volumes import cropped, flow, head, real_volume

import airlight as al
from airlight import reference

ORDERS: dict[str, tuple[dict[str, Any], bool]] = {
    "pre-classified": ({"field": "preclassified"}, False),
    "post-classified": ({"transfer": "postclassified"}, False),
    "pre-integrated, fast": ({"transfer": "preintegrated_fast"}, False),
    "pre-integrated, plain": ({"transfer": "preintegrated"}, False),
    "pre-integrated, curved": ({"transfer": "preintegrated"}, True),
}
STEPS = (4.0, 2.0, 1.0, 0.5, 0.25)
CONVERGED_STEP = 1 / 32
SMOOTH, SPIKY, RANDOM, BAND_LIMITED = "smooth", "spiky", "random", "band-limited"
PLAIN, BEST = "pre-integrated, plain", "pre-integrated, curved"  # without and, as by default, with curvature
BARS = {BAND_LIMITED: (4.0, 0.01), SMOOTH: (1.0, 0.015)}  # greatest step, and by how much the mean colour may change


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "orders", repeats=5, size=256, clock="what tables and plots show: cpu on a busy machine")
    parser.add_argument("--pixels", type=int, default=2000, help="pixels compared with the reference (default: 2000)")
    parser.add_argument("--only", default="", help="only the cases whose name contains this")
    parser.add_argument("--docs", action="store_true", help="also write the plots and pictures of docs/guide/orders")
    options = parsed(parser, argv, size=24, repeats=1, pixels=20)
    started, found = time.time(), []
    with al.Renderer() as renderer:
        for name, kind, scene in cases(options.quick)[:: 3 if options.quick else 1]:
            if options.only in name:
                found.append({"case": name, "kind": kind} | measure(renderer, scene, options))
                print(f"\n{name} ({kind})\n\n{table(rows(found[-1], options.clock))}", flush=True)
        adapter = renderer.render(scene, (8, 8)).stats["adapter"]
        if options.docs:
            from orders_docs import write_docs

            write_docs(renderer, found, options.clock, ROOT / "docs" / "guide" / "orders")
    bars = [bar for case in found for bar in check(case, options.clock)]
    print("\n" + table(bars) if bars else "")
    passed = all(bar["passes"] for bar in bars if bar["order"] == BEST)
    print(f"\n{'PASS' if passed else 'FAIL'} in {time.time() - started:.0f} s")
    write_json(options.out, machine() | {"adapter": adapter, "quick": options.quick, "bars": bars, "cases": found})
    return 0 if passed or options.quick else 1


# -- scenes


def cases(quick: bool = False) -> list[tuple[str, str, al.Scene]]:
    """Name, kind and scene of each case; all are unlit and seen from a corner."""
    ct = cropped(real_volume("ct_head"), 32) if quick else real_volume("ct_head")
    lobes = al.samples.load("marschner-lobb")
    vortex, hydrogen = (al.samples.load(name, size=24 if quick else 96) for name in ("vortex", "hydrogen"))
    return [
        ("CT head, spiky", SPIKY, scene_of(ct, spiky(ct, (0.3, 0.36, 0.5), 1.0))),
        ("Marschner-Lobb, spiky", SPIKY, scene_of(lobes, spiky(lobes, (0.3, 0.5, 0.7), 40.0))),
        ("orbital, random", RANDOM, scene_of(orbital(), random_green(orbital()))),
        ("CT head, skin and bone", SMOOTH, scene_of(ct, head())),
        ("vortex, smooth", BAND_LIMITED, scene_of(vortex, flow())),
        ("hydrogen, smooth", BAND_LIMITED, scene_of(hydrogen, lobes_of(hydrogen))),
    ]


def scene_of(volume: al.Volume, function: al.TransferFunction) -> al.Scene:
    """Unlit scene of a volume seen from a corner."""
    return from_corner(volume, function, {"shade": "none"})


def in_order(scene: al.Scene, order: str) -> tuple[al.Scene, Any]:
    """Scene with the stages of an order, and the driver for it."""
    stages, curved = ORDERS[order]
    (layer,) = scene.layers
    look = al.Look(shade="none", **stages)
    staged = al.Scene(layer.volume, transfer=layer.transfer, camera=scene.camera, look=look, background=None)
    return staged, al.driver.March(curved=curved)


def spiky(volume: al.Volume, places: tuple[float, float, float], extinction: float) -> al.TransferFunction:
    """Three peaks, each a hundredth of the range of the data wide, at these shares of it."""
    known = al.statistics(volume)
    low, rise = known.minimum, known.maximum - known.minimum
    colours = ((1, 0.3, 0.1), (0.2, 1, 0.3), (0.3, 0.4, 1))
    peaks = [al.TransferFunction.peak(low + p * rise, rise / 100, c, extinction) for p, c in zip(places, colours, strict=True)]
    return peaks[0] | peaks[1] | peaks[2]


def orbital(size: int = 16) -> al.Volume:
    """Magnitude of the wave function of a hydrogen atom (4d) on few samples, as in the figures of Engel and Ertl."""
    wave = al.samples.load("hydrogen", size=size)
    return al.Volume(np.abs(wave.array), world_from_index=wave.world_from_index, name="orbital")


def random_green(volume: al.Volume, seed: int = 3) -> al.TransferFunction:
    """Green by chance, the other channels piecewise linear."""
    greatest = float(al.statistics(volume).maximum)
    shares = ((0, (0.0, 0, 0.4), 0.0), (0.04, (0.0, 0, 0.7), 0.05), (0.4, (0.6, 0, 0.1), 0.4), (1, (1, 0, 0), 0.8))
    base = al.TransferFunction([(share * greatest, rgb, extinction) for share, rgb, extinction in shares])
    return al.TransferFunction.random(seed, (0, greatest), entries=48, channels="g", base=base)


def lobes_of(volume: al.Volume) -> al.TransferFunction:
    """Function of a wave with both signs."""
    greatest = float(al.statistics(volume).maximum)
    return al.TransferFunction([(-greatest, (0.2, 0.4, 1), 1.0), (0, (0, 0, 0), 0.0), (greatest, (1, 0.5, 0.1), 1.0)])


# -- measuring


def measure(renderer: al.Renderer, scene: al.Scene, options: Any) -> dict[str, Any]:
    """Errors, samples, times and mean colours of a scene, by order and step."""
    size = (options.size, options.size)
    fine = renderer.render(scene, size, step=STEPS[-1], driver=al.driver.March(curved=True))
    y, x = np.nonzero(fine.rgba[..., 3] > 0)
    taken = np.random.default_rng(7).permutation(len(x))[: options.pixels]
    x, y = x[taken], y[taken]
    truth = reference.converged(scene, size, pixels=np.stack([x, y], axis=1), step=CONVERGED_STEP).rgba
    found: dict[str, Any] = {order: [] for order in ORDERS}
    for step in STEPS:

        def job(order: str, step: float = step) -> Any:
            staged, driver = in_order(scene, order)
            return lambda: renderer.render(staged, size, step=step, driver=driver)

        for order, measured in side_by_side({order: job(order) for order in ORDERS}, options.repeats).items():
            image = measured.result
            row = {
                "step": step,
                "samples_a_ray": image.stats["samples"] / (options.size**2),
                "rmse": errors(image.rgba[y, x], truth)["rmse"],
                "mean_rgb": image.rgba[..., :3].mean(axis=(0, 1), dtype=np.float64).tolist(),
            }
            found[order].append(row | measured.summary())
    for order_rows in found.values():
        finest = np.array(order_rows[-1]["mean_rgb"])
        for row in order_rows:
            row["change"] = float(np.linalg.norm(np.array(row["mean_rgb"]) - finest) / max(np.linalg.norm(finest), 1e-12))
    return {"pixels": len(x), "orders": found}


def rows(case: dict[str, Any], clock: str) -> list[dict[str, Any]]:
    """Rows of the printed table."""
    return [
        {
            "order": order,
            "step [voxel]": row["step"],
            "RMSE": row["rmse"],
            f"{clock} [ms]": row[f"{clock}_ms"]["median"],
            "change of mean colour [%]": 100 * row["change"],
        }
        for order, order_rows in case["orders"].items()
        for row in order_rows
    ]


# -- bars


def check(case: dict[str, Any], clock: str) -> list[dict[str, Any]]:
    """What is asked of pre-integration with and without curvature, and whether it holds; the better of them counts."""
    post, found = case["orders"]["post-classified"], []
    for order in (PLAIN, BEST):
        pre = case["orders"][order]
        bars: list[tuple[str, float, float]] = []
        if case["kind"] in (SPIKY, RANDOM):
            bars.append(("RMSE at 1 voxel, post-classified at 1/2", at(pre, 1.0)["rmse"], at(post, 0.5)["rmse"]))
        if case["kind"] == SPIKY:
            bars.append(("RMSE at equal time, by the best of the others", at_equal_time(case, pre, clock), 1.0))
            fifth = at(post, 1.0)["change"] / 5
            bars.append(("change of mean colour at 1 voxel, a fifth of post-classified", at(pre, 1.0)["change"], fifth))
        elif case["kind"] in BARS:
            greatest, most = BARS[case["kind"]]
            change = max(row["change"] for row in pre if row["step"] <= greatest)
            bars.append((f"change of mean colour up to {greatest:g} voxels", change, most))
        for what, value, most in bars:
            row = {"case": case["case"], "order": order, "bar": what, "value": value, "at most": most}
            found.append(row | {"passes": bool(value <= most)})
    return found


def at_equal_time(case: dict[str, Any], pre: list[dict[str, Any]], clock: str) -> float:
    """Greatest quotient of errors, of an order and of any that does not pre-integrate, at the times of the latter."""
    key = f"{clock}_ms"
    times = np.array([row[key]["median"] for row in pre])
    order = np.argsort(times)
    quotients = []
    for other in ("pre-classified", "post-classified"):
        for row in case["orders"][other]:
            if times.min() <= row[key]["median"] <= times.max():
                logs = np.interp(np.log(row[key]["median"]), np.log(times[order]), np.log([pre[i]["rmse"] for i in order]))
                quotients.append(float(np.exp(logs) / row["rmse"]))
    return max(quotients, default=0.0)


def at(order_rows: list[dict[str, Any]], step: float) -> dict[str, Any]:
    """Row of a step."""
    return next(row for row in order_rows if row["step"] == step)


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
    sys.exit(main())
