"""Where within a slab light is evaluated: error against the float64 reference at 1/32 voxel, and time.

*facets*: a field that runs straight along the rays, so that slabs of one voxel are classified exactly and light alone is off;
its normals turn from sample to sample. Functions soft and sharp, as in Lum, Wilson and Ma, section 5. The bars: over all
functions ``interpolated`` has at most a third of the error of ``averaged`` and a fifth of that of one sample at the front, and
it costs at most 15 % more time than that. *failures*: what Lum et al. report of their own method: two surfaces that part into
two slabs (figure 2), and a boundary so sharp that the ends of slabs have no normal (figure 8 d).
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from common import arguments, by_both_clocks, described, frame_of, parsed, side_by_side, table, write_json
from volumes import bone, cropped, real_volume

import airlight as al
from airlight import reference
from airlight.gpu.device import Device, open_device
from airlight.rendering.ways import draw_frame

FINE = 32
WAYS: dict[str, al.Stage] = {
    "one sample, front": al.lighting.Sampled(at="front"),
    "one sample, middle": al.lighting.Sampled(at="middle"),
    "one sample, light": al.lighting.Sampled(at="light"),
    "averaged": al.lighting.Averaged(),
    "interpolated": al.lighting.Interpolated(),
    "supersampled": al.lighting.Supersampled(),
}
TO_AVERAGED, TO_SINGLE, MOST_TIME = 1 / 3, 1 / 5, 1.15
SHADE = al.shade.BlinnPhong(ambient=0.1, diffuse=0.6, specular=0.3, shininess=40)
LIGHTS = (al.Light.directional(to_light=(-1, -1, 1.5)), al.Light.directional(to_light=(-0.5, -0.7, -1)))


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "lighting", repeats=9, size=512, step=1.0, clock="what decides: cpu where others are busy")
    options = parsed(parser, argv, size=24, repeats=1)
    device = open_device(options.device)
    try:
        about = described(device, options)
        with al.Renderer(device=options.device) as renderer:
            rows = accuracy(renderer, 12 if options.quick else 48)
        print(table(rows) + "\n")
        print(table([by_function(row) for row in rows]) + "\n")
        times = timed(device, options)
        print(
            table(
                [{"lighting": t["lighting"], "ms": t[f"{options.clock}_ms"]["median"]} | shown(t, options.clock) for t in times]
            )
        )
    finally:
        device.close()
    checks = judged(rows, times, options.clock)
    print("\n" + table(checks))
    write_json(options.out, about | {"errors": rows, "times": times, "checks": checks})
    return 0 if options.quick or all(check["passes"] for check in checks) else 1


# -- error


def accuracy(renderer: al.Renderer, size: int) -> list[dict[str, Any]]:
    """Root mean square error of linear colours, times 10^4, by scene and way."""
    rows = []
    for name, scene in scenes().items():
        truth = reference.render(with_lighting(scene, WAYS["one sample, middle"]), (size, size), step=1 / FINE, curved=False)
        row: dict[str, Any] = {"scene": name}
        for way, stage in WAYS.items():
            rgba = renderer.render(with_lighting(scene, stage), (size, size), step=1.0).rgba
            row[way] = 1e4 * light_error(rgba, truth.rgba)
        rows.append(row)
        print(f"  {name}", file=sys.stderr, flush=True)
    return rows


def light_error(rgba: Any, truth: Any) -> float:
    """Root mean square difference of light per opacity, weighted by the true opacity: classification has no part in it."""
    seen = (truth[..., 3] > 0.02) & (rgba[..., 3] > 0.02)
    mine, right = (image[seen][:, :3] / image[seen][:, 3:] for image in (np.asarray(rgba, np.float64), truth))
    return float(np.sqrt(np.mean((truth[seen][:, 3:] * (mine - right)) ** 2)))


def scenes() -> dict[str, al.Scene]:
    """Scenes by name, in white, seen along z."""
    middle = 50.0
    facets = field(lambda x, y, z: middle + z * (5 + 2 * np.sin(x / 3) * np.sin(y / 3)) + 12 * np.cos(x / 4) * np.cos(y / 5))
    edge = field(lambda x, y, z: middle - 50 * np.tanh((np.sqrt(x * x + y * y + z * z) - 11.3) / 0.5))
    found = {f"facets, {name}": seen_along_z(facets, tf) for name, tf in functions(middle).items()}
    found["failures, parting surfaces"] = seen_along_z(facets, functions(middle)["two peaks"], turned=True)
    found["failures, sharp boundary"] = seen_along_z(edge, functions(middle)["opaque"], turned=True)
    return found


def functions(middle: float) -> dict[str, al.TransferFunction]:
    """Functions round a value, sharp and soft."""

    def peak(at: float, height: float) -> al.TransferFunction:
        return al.TransferFunction([(at - 1, "white", 0.0), (at, "white", height), (at + 1, "white", 0.0)])

    return {
        "opaque": al.TransferFunction([(middle, "white", 0.0), (middle, "white", 20.0)]),
        "step": al.TransferFunction([(middle, "white", 0.0), (middle, "white", 1.0)]),
        "peak": peak(middle, 2.0),
        "two peaks": peak(middle, 0.7) + peak(middle + 2.5, 2.0),
        "soft": al.TransferFunction([(middle - 25, "white", 0.0), (middle, "white", 0.3), (middle + 25, "white", 0.0)]),
    }


def field(values: Any, n: int = 32) -> al.Volume:
    """Volume of a function of coordinates [voxel] from its middle."""
    z, y, x = np.mgrid[:n, :n, :n].astype(np.float64) - (n - 1) / 2
    return al.Volume(values(x, y, z).astype(np.float32))


def seen_along_z(volume: al.Volume, function: al.TransferFunction, turned: bool = False) -> al.Scene:
    """Scene seen along an axis of the grid, or across it."""
    middle = np.full(3, (volume.size[0] - 1) / 2)
    eye = middle + (np.array([21.0, 17.0, -29.0]) if turned else np.array([0.0, 0.0, -35.8]))
    camera = al.Camera.orthographic(eye=tuple(eye), target=tuple(middle), up=(0, 1, 0), height=28)
    return al.Scene(volume, transfer=function, camera=camera, lights=LIGHTS, background=None)


def with_lighting(scene: al.Scene, lighting: al.Stage) -> al.Scene:
    """Return the scene lit in another way."""
    (layer,) = scene.layers
    look = al.Look(field="linear_exact", gradient="central", shade=SHADE, lighting=lighting)
    return al.Scene(layer.volume, transfer=layer.transfer, camera=scene.camera, look=look, lights=scene.lights, background=None)


# -- time


def timed(device: Device, options: Any) -> list[dict[str, Any]]:
    """Frames of the CT head's bone, gradients from a texture, in turns."""
    volume = real_volume("ct_head")
    volume = cropped(volume, 24) if options.quick else volume
    camera = al.fit_camera("iso", volume.corners_world(), 1.0)
    jobs = {}
    for way, stage in WAYS.items():
        look = al.Look(gradient="precomputed", lighting=stage)
        scene = al.Scene(volume, transfer=bone(), camera=camera, look=look, background=None)
        frame = frame_of(device, scene, options, "auto")
        jobs[way] = lambda frame=frame: draw_frame(frame)
    measured = side_by_side(jobs, options.repeats, warm=2)
    base = measured["one sample, front"]
    return [{"lighting": way, "relative": by_both_clocks(measured[way], base)} | measured[way].summary() for way in WAYS]


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """Columns of the printed table."""
    relative = row["relative"][clock]
    return {"to one sample": relative["median"], "min": relative["min"], "max": relative["max"]}


def by_function(row: dict[str, Any]) -> dict[str, Any]:
    """Errors of ``interpolated`` to those of other ways in one scene: what the bars over all functions are made of."""
    others = ("averaged", "one sample, front", "one sample, middle", "one sample, light")
    return {"scene": row["scene"]} | {f"interpolated to {way}": row["interpolated"] / row[way] for way in others}


def judged(rows: list[dict[str, Any]], times: list[dict[str, Any]], clock: str) -> list[dict[str, Any]]:
    """The bars, each with what was measured."""
    smooth = [row for row in rows if row["scene"].startswith("facets")]

    def over_all(way: str) -> float:
        return float(np.sqrt(np.mean([row[way] ** 2 for row in smooth])))

    mine = over_all("interpolated")
    time = next(t["relative"][clock]["median"] for t in times if t["lighting"] == "interpolated")
    found = (
        ("error to averaged", mine / over_all("averaged"), TO_AVERAGED),
        ("error to one sample, front", mine / over_all("one sample, front"), TO_SINGLE),
        ("time to one sample, front", time, MOST_TIME),
    )
    return [{"what": what, "measured": value, "at most": bar, "passes": value <= bar} for what, value, bar in found]


if __name__ == "__main__":
    sys.exit(main())
