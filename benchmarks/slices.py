"""Slice drivers and the march side by side: time, error and bytes; what turning does to slices of the grid.

*drivers*: a head of 256 voxels a side, 640 x 480 pixels, steps of a voxel, a camera that turns: each driver with each look
draws the same views in turns. Errors are those of the first view against the march at an eighth of the step with exact weights;
the paper's rates (Vollrath, Weiskopf and Ertl 2005) are to be reached by the quickest driver, half of them by slices alone.
*groups*: slices drawn one by one, and so many in a pass. *bytes*: what each driver keeps of the volume once it has been seen
along all three axes. *turning*: mean opacity of object slices beside the march, with slabs as long as they are and without, and
how far the picture changes within a fifth of a degree.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
from common import arguments, by_both_clocks, errors, machine, parsed, side_by_side, table, write_json
from volumes import cropped, head, real_volume

import airlight as al

LOOKS: dict[str, dict[str, Any]] = {
    "post-classified": {"transfer": "postclassified", "shade": "none"},
    "pre-integrated": {"shade": "none"},
    "pre-integrated, lit": {"lighting": "interpolated", "gradient": "precomputed"},
}
RATES = {"post-classified": 12.5, "pre-integrated": 7.5, "pre-integrated, lit": 3.2}  # frames a second
SLICED = ("slices", "shells", "object_slices", "interpolated_slices", "stripes")
DRIVERS = ("march", *SLICED)
STRIPES_MOST = 1.5  # times slices
TRUE_STEP = 1 / 8
VOXELS = 256


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "slices", repeats=7, clock="what decides: cpu where others are busy")
    parser.add_argument("--width", type=int, default=640, help="width of the picture, 4 to 3 (default: %(default)s)")
    options = parsed(parser, argv, width=64, repeats=1)
    size = (options.width, options.width * 3 // 4)
    volume = cubed(real_volume("ct_head"), 32 if options.quick else VOXELS)
    with al.Renderer() as renderer:
        looks = list(LOOKS)[: 1 if options.quick else None]
        rows = [row for look in looks for row in of_drivers(renderer, volume, look, size, options)]
        print(table(rows))
        groups = of_groups(renderer, volume, size, options)
        print("\n" + table(groups))
        angles = of_angles(renderer, volume, size)
        print("\n" + table(angles))
    held = [of_bytes(volume, driver) for driver in DRIVERS]
    print("\n" + table(held))
    bars = bars_of(rows)
    print("\n" + table(bars))
    passed = all(bar["met"] for bar in bars)
    found = {"drivers": rows, "groups": groups, "turning": angles, "bytes": held, "bars": bars, "passed": passed}
    write_json(options.out, machine() | {"quick": options.quick, "size": size, "clock": options.clock} | found)
    return 0 if passed or options.quick else 1


def cubed(volume: al.Volume, voxels: int) -> al.Volume:
    """Return a volume with so many voxels along each axis, of what is larger the middle, with slices between slices."""
    part = cropped(volume, voxels)
    places = np.linspace(0, part.size[2] - 1, voxels)
    low = np.minimum(places.astype(int), part.size[2] - 2)
    share = (places - low)[:, None, None].astype(np.float32)
    array = (1 - share) * part.array[low] + share * part.array[low + 1]
    matrix = part.world_from_index.copy()
    matrix[:3, 2] *= (part.size[2] - 1) / (voxels - 1)
    return al.Volume(np.round(array).astype(part.array.dtype), world_from_index=matrix, units=part.units)


def view(volume: al.Volume, angle_deg: float, up_deg: float = 20.0) -> al.Camera:
    """Return the camera that has turned by so much round a volume, which fills the picture."""
    corners = volume.corners_world()
    middle, reach = corners.mean(axis=0), float(np.ptp(corners, axis=0).max())
    turn, rise = np.radians(angle_deg), np.radians(up_deg)
    away = np.array([np.sin(turn) * np.cos(rise), -np.cos(turn) * np.cos(rise), np.sin(rise)])
    return al.Camera.perspective(eye=tuple(middle + 3 * reach * away), target=tuple(middle), fov_deg=24)


def scene_of(volume: al.Volume, look: str, camera: al.Camera) -> al.Scene:
    """Return the head with a look."""
    return al.Scene(volume, transfer=head(), look=al.Look(**LOOKS[look]), camera=camera, background=None)


def turning(renderer: al.Renderer, drawn: al.Scene, size: tuple[int, int], driver: Any) -> Callable[[], al.Image]:
    """Return a job that draws the next view each time, the same ones for all drivers."""
    volume, turns = drawn.layers[0].volume, count()
    return lambda: renderer.render(replace(drawn, camera=view(volume, 7.0 * next(turns))), size, driver=driver)


def of_drivers(
    renderer: al.Renderer, volume: al.Volume, look: str, size: tuple[int, int], options: Any
) -> list[dict[str, Any]]:
    """Time and error of each driver with a look."""
    drawn = scene_of(volume, look, view(volume, 0.0))
    measured = side_by_side({driver: turning(renderer, drawn, size, driver) for driver in DRIVERS}, options.repeats)
    exact = replace(drawn.layers[0], look=replace(drawn.layers[0].look, field=al.field.LinearExact()))
    truth = renderer.render(replace(drawn, layers=(exact,)), size, step=TRUE_STEP).rgba
    rows = []
    for driver, found in measured.items():
        off = errors(renderer.render(drawn, size, driver=driver).rgba, truth)
        milliseconds = found.summary()[f"{options.clock}_ms"]["median"]
        rows.append(
            {
                "look": look,
                "driver": driver,
                "ms": milliseconds,
                "frames/s": 1e3 / milliseconds,
                "times slices": by_both_clocks(found, measured["slices"])[options.clock]["median"],
                "Msamples": found.result.stats["samples"] / 1e6,
                "max x255": 255 * off["max"],
                "rmse x255": 255 * off["rmse"],
            }
        )
    return rows


def of_groups(renderer: al.Renderer, volume: al.Volume, size: tuple[int, int], options: Any) -> list[dict[str, Any]]:
    """Time of slices in groups of several sizes, from front to back and from back to front."""
    drawn = scene_of(volume, "post-classified", view(volume, 0.0))
    ways = {
        (group, order): al.driver.Slices(group=group, back_to_front=order)
        for group in (1, 8, 32, 128)
        for order in (False, True)
    }
    jobs = {str(way): turning(renderer, drawn, size, driver) for way, driver in ways.items()}
    measured = side_by_side(jobs, options.repeats)
    return [
        {
            "slices in a pass": group,
            "order": "back to front" if order else "front to back",
            "ms": measured[str((group, order))].summary()[f"{options.clock}_ms"]["median"],
            "Msamples": measured[str((group, order))].result.stats["samples"] / 1e6,
        }
        for group, order in ways
    ]


def of_angles(renderer: al.Renderer, volume: al.Volume, size: tuple[int, int]) -> list[dict[str, Any]]:
    """Mean opacity beside the march, and the change within a fifth of a degree, by the angle from the nearest axis."""

    def drawn(angle_deg: float, driver: Any) -> Any:
        near = view(volume, angle_deg, 0.0)
        reach = float(np.linalg.norm(np.subtract(near.target, near.eye)))
        camera = al.Camera.orthographic(eye=near.eye, target=near.target, height=0.45 * reach)
        return renderer.render(scene_of(volume, "post-classified", camera), size, driver=driver).rgba

    ways = {
        "corrected": "object_slices",
        "not corrected": al.driver.ObjectSlices(corrects=False),
        "interpolated": "interpolated_slices",
        "stripes": "stripes",
    }
    rows = []
    for angle_deg in (0.0, 15.0, 30.0, 44.9, 60.0):
        mean = float(drawn(angle_deg, "march")[..., 3].mean())
        row: dict[str, Any] = {"degrees": angle_deg}
        for name, driver in ways.items():
            before, after = drawn(angle_deg, driver), drawn(angle_deg + 0.2, driver)
            row[f"{name}: opacity"] = float(before[..., 3].mean()) / mean
            row[f"{name}: change x255"] = 255 * errors(before, after)["rmse"]
        rows.append(row)
    return rows


def of_bytes(volume: al.Volume, driver: str) -> dict[str, Any]:
    """What a driver keeps of a volume that was seen along all axes, on a device of its own."""
    with al.Renderer() as alone:
        for angle_deg, up_deg in ((0.0, 5.0), (90.0, 5.0), (0.0, 85.0)):
            drawn = scene_of(volume, "post-classified", view(volume, angle_deg, up_deg))
            layer = alone.render(drawn, (32, 24), driver=driver).stats["layers"][0]
    held = layer["stacks"].get("bytes", {"3-D": layer["textures"][0]["bytes"]})
    format_of = layer["textures"][0]["format"]
    return {"driver": driver, "format": format_of, "textures": ", ".join(held), "MB": sum(held.values()) / 1e6}


def bars_of(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """What is to be reached, and whether it is."""
    bars = []
    for look in dict.fromkeys(row["look"] for row in rows):
        rate = RATES[look]
        mine = {row["driver"]: row for row in rows if row["look"] == look}
        best = max(mine.values(), key=lambda row: row["frames/s"])
        sliced = max((mine[driver] for driver in SLICED), key=lambda row: row["frames/s"])
        bars += [
            bar(f"{look}: frames/s of {best['driver']}", best["frames/s"], "at least", rate),
            bar(f"{look}: frames/s of {sliced['driver']}", sliced["frames/s"], "at least", rate / 2),
            bar(f"{look}: stripes over slices", mine["stripes"]["times slices"], "at most", STRIPES_MOST),
        ]
    return bars


def bar(name: str, found: float, way: str, wanted: float) -> dict[str, Any]:
    """Return a row of what is to be reached."""
    return {"bar": name, "found": found, way: wanted, "met": found >= wanted if way == "at least" else found <= wanted}


if __name__ == "__main__":
    sys.exit(main())
