"""Environments: the furnace, errors of their maps, and what light and background of one cost.

*furnace*: greatest deviation of opaque surfaces in white light from their albedo, over roughnesses and shares of metal without
a coat, and from white under coats. *maps*: what a frame reads of them against sums over the pixels of the picture, at random
directions and round the brightest one, relative to the greatest. *cost*: frames lit by an environment, and with it seen behind,
relative to ``blinn_phong``; time to make all maps.
"""

from __future__ import annotations

import itertools
import sys
import time
from functools import partial
from typing import Any

import numpy as np
from common import arguments, by_both_clocks, described, parsed, side_by_side, table, write_json
from volumes import bone, cropped, real_volume, stand_in

import airlight as al
from airlight.environment import maps
from airlight.gpu.device import open_device
from airlight.reference.environment import directions_and_areas, radiance

MOST_IN_FURNACE = 1e-3
ROUGHNESSES = (0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 where the furnace does not give back the albedo."""
    parser = arguments(__doc__, "environments", repeats=7, size=512, step=1.0, clock="what is told: cpu where others are busy")
    options = parsed(parser, argv, size=40, repeats=1)
    device = open_device(options.device)
    about = described(device, options)
    device.close()
    with al.Renderer(options.device) as renderer:
        deviation = furnace(renderer, options)
        shown, count = (("studio",), 40) if options.quick else (("studio", "sky"), 600)
        rows = [row for name in shown for row in map_errors(name, count)]
        costs = cost(renderer, options)
    print(f"furnace: {deviation:.1e} from the albedo, at most {MOST_IN_FURNACE:g}\n")
    print(table(rows), table([costs["shown"]]), sep="\n\n")
    passes = deviation <= MOST_IN_FURNACE
    print(f"\n{'PASS' if passes else 'FAIL'}")
    write_json(options.out, about | {"furnace": deviation, "maps": rows, "cost": costs, "passes": passes})
    return 0 if passes else 1


def furnace(renderer: al.Renderer, options: Any) -> float:
    """Greatest deviation from what a white environment must give back."""
    volume = stand_in(24 if options.quick else 96)
    deviations = []
    albedo = np.array([0.9, 0.5, 0.2])
    cases = [(tuple(albedo), r, m, 0.0) for r, m in itertools.product((0.0, 0.3, 0.6, 1.0), (0.0, 0.5, 1.0))]
    cases += [((1.0, 1.0, 1.0), r, 0.0, f) for r, f in itertools.product((0.0, 0.3, 0.6, 1.0), (0.04, 0.5, 1.0))]
    for rgb, roughness, metallic, reflectance in cases[:: 4 if options.quick else 1]:
        white = al.Environment.white()
        shade = al.shade.Environment(white, roughness=roughness, metallic=metallic, reflectance=reflectance)
        opaque = al.TransferFunction([(-300, rgb, 0.0), (-300, rgb, 1e3)])
        made = al.Scene(volume, transfer=opaque, look=al.Look(shade=shade), background=None)
        rgba = renderer.render(made, (options.size // 4, options.size // 4), step=options.step).rgba
        covered = rgba[..., 3] > 0.5
        assert covered.any()
        deviations.append(float(np.abs(rgba[covered, :3] / rgba[covered, 3:] - rgb).max()))
    return max(deviations)


def map_errors(name: str, count: int) -> list[dict[str, Any]]:
    """Rows of a built-in environment, one a roughness."""
    environment = al.Environment.named(name)
    picture = np.asarray(environment.source.picture(), dtype=np.float64)
    stored = maps.light_maps(environment.source)
    rng = np.random.default_rng(1)
    to_light, _ = directions_and_areas(*picture.shape[:2])
    brightest = to_light.reshape(-1, 3)[picture.sum(axis=2).argmax()]
    directions = np.concatenate([rng.normal(size=(count, 3)), brightest + 0.05 * rng.normal(size=(count // 3, 3))])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rows = []
    for roughness in ROUGHNESSES:
        layer = maps.layer_of(roughness)
        low = min(int(layer), maps.LAYERS - 2)
        found = (1 - layer + low) * octahedral_at(stored[low], directions)
        found += (layer - low) * octahedral_at(stored[low + 1], directions)
        truth = radiance(environment, directions, roughness**2)
        error = np.abs(found - truth).max(axis=1) / truth.max()
        rms = float(np.sqrt(np.mean(error**2)))
        rows.append({"environment": name, "roughness": roughness, "max %": 100 * float(error.max()), "rms %": 100 * rms})
    return rows


def octahedral_at(texels: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Map (n, n, 4) at directions (m, 3), bilinear, with the outermost texels on the edge of the square."""
    n = len(texels)
    p = directions / np.abs(directions).sum(axis=1, keepdims=True)
    folded = (1 - np.abs(p[:, 1::-1])) * np.where(p[:, :2] >= 0, 1, -1)
    place = (np.where(p[:, 2:] >= 0, p[:, :2], folded) + 1) / 2 * (n - 1)
    column, row = np.clip(place.astype(int), 0, n - 2).T
    a, b = (place - np.stack([column, row], axis=1)).T[..., None]
    rgb = texels[..., :3].astype(np.float64)
    upper = rgb[row, column] * (1 - a) + rgb[row, column + 1] * a
    return np.asarray(upper * (1 - b) + (rgb[row + 1, column] * (1 - a) + rgb[row + 1, column + 1] * a) * b)


def cost(renderer: al.Renderer, options: Any) -> dict[str, Any]:
    """Time of frames relative to ``blinn_phong``, and of all maps of an environment that is new."""
    volume = real_volume("ct_head")
    volume = cropped(volume, 32) if options.quick else volume
    studio = al.Environment.studio()

    def drawn(shade: Any, background: Any) -> Any:
        look = al.Look(gradient="precomputed", shade=shade)
        scene = al.Scene(volume, transfer=bone(), look=look, camera="back", background=background)
        return renderer.render(scene, (options.size, options.size), step=options.step)

    jobs = {
        "blinn_phong": partial(drawn, "blinn_phong", None),
        "environment": partial(drawn, al.shade.Environment(studio), None),
        "background": partial(drawn, al.shade.Environment(studio), studio),
    }
    measured = side_by_side(jobs, options.repeats)
    begin = time.process_time()
    fresh = 1.0 + 1e-6 * (time.time() % 1)
    maps.light_maps((al.Environment.white((fresh,) * 3) if options.quick else al.Environment.studio(key=fresh)).source)
    seconds = time.process_time() - begin
    relative = {name: by_both_clocks(measured[name], measured["blinn_phong"]) for name in ("environment", "background")}
    shown = {f"{name}, over blinn_phong": both[options.clock]["median"] for name, both in relative.items()}
    return {"relative": relative, "maps_cpu_s": seconds, "shown": shown | {"all maps, s": seconds}}


if __name__ == "__main__":
    sys.exit(main())
