"""Frames a second of a turning head, 256 voxels a side, at 640x480, one slice a voxel: each driver, each kind of picture.

The rows of Vollrath, Weiskopf and Ertl (2005, section 6: a GeForce 6800): post-classified 12.5, pre-integrated 7.5, lit with
interpolated pre-integrated lighting 3.2, with shadows 2.7 frames a second, tone mapping one frame less. The camera turns by a
degree from frame to frame; for shadows the light turns as well. Bars, with the function bone: the quickest driver of each row
reaches its rate, and with tones one frame less of it; slice drivers half of it; ``slices`` reach 70 % of the rate of a bare
blended stack of the same size (``bare_stack.py``) where nothing is skipped and no ray ends early; ``stripes`` take at most 1.5
times as long as ``slices``. What tones cost the other drivers stands beside it, and no bar asks for it.
Errors are those of one frame against the same look at 1/8 voxel.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from bare_stack import bare_stack
from common import arguments, errors, machine, parsed, side_by_side, spread, table, write_json
from volumes import bone, cropped, head, real_volume

import airlight as al
from airlight.gpu.device import open_device
from airlight.rendering.frame import Request, prepare

VOXELS = 256
TURN_DEG = 1.0
LIGHT = (-0.6, -0.5, 0.6)
FUNCTIONS = {"bone": bone, "skin and bone": head}
BARS = {"post-classified": 12.5, "pre-integrated": 7.5, "lit": 3.2, "shadows": 2.7}
LOOKS: dict[str, dict[str, Any]] = {
    "post-classified": {"transfer": "postclassified", "shade": "none"},
    "pre-integrated": {"shade": "none"},
    "lit": {"lighting": "interpolated"},
    "shadows": {"lighting": "interpolated"},
}
MOST_OF_STRIPES = 1.5  # times as long as slices take
ADAPTIVE = "march, adaptive"  # slabs are longer behind what hides them
MARCHES = ("march", ADAPTIVE)
DRIVERS = (*MARCHES, "slices", "shells", "object_slices", "interpolated_slices", "stripes")
SHADOWING = ("march", "half_angle")  # by a shadow volume, made anew for each frame; by slices: errors are those of shadows.py


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "frame_rates", repeats=9, step=1.0)
    parser.add_argument("--looks", nargs="*", choices=LOOKS, default=list(LOOKS), help="rows (default: all)")
    options = parsed(parser, argv, repeats=1)
    size = (64, 48) if options.quick else (640, 480)
    volume = head_volume(24 if options.quick else VOXELS)
    about: dict[str, Any] = {"quick": options.quick, "size": size, "voxels": volume.size, "step": options.step}
    rows, bars = [], []
    with al.Renderer(options.device) as renderer:
        for (name, made), look in itertools.product(FUNCTIONS.items(), options.looks):
            found = rates(renderer, volume, made(), look, size, options)
            rows += [{"function": name, "picture": look} | row for row in found]
            if name == "bone":
                bars += [{"picture": look} | bar for bar in judged(found, BARS[look])]
    print(table(rows))
    print("\n" + table(bars))
    passes = all(bar["passes"] for bar in bars)
    device = open_device(options.device)
    try:
        about |= machine(device)
        bare = against_bare(device, volume, size, options)
    finally:
        device.close()
    print("\n" + table([bare]))
    passes &= bare["slices of the bare rate"] >= 0.7
    print(f"\n{'PASS' if passes else 'FAIL'}: the rates with the function bone, and 70 % of the bare stack")
    write_json(options.out, about | {"rows": rows, "bars": bars, "bare": bare, "passes": passes})
    return 0 if passes or options.quick else 1


def judged(rows: list[dict[str, Any]], rate: float) -> list[dict[str, Any]]:
    """Bars of one kind of picture whose rate [frames/s] is to be reached: whom they judge, what is asked, what was found."""
    quickest = max(rows, key=lambda row: row["frames/s"])
    slowest = min((row for row in rows if row["driver"] not in MARCHES), key=lambda row: row["frames/s"])
    found = [
        ("quickest", quickest, rate, quickest["frames/s"]),
        ("quickest, with tones", quickest, min(quickest["frames/s"], rate) - 1, quickest["with tones"]),
        ("slowest slices", slowest, rate / 2, slowest["frames/s"]),
    ]
    ms = {row["driver"]: row["ms"] for row in rows}
    if "stripes" in ms:
        stripes = next(row for row in rows if row["driver"] == "stripes")
        found.append(("stripes, as slices are", stripes, 1 / MOST_OF_STRIPES, ms["slices"] / ms["stripes"]))
    return [
        {"bar": bar, "driver": row["driver"], "asked": round(asked, 2), "found": round(got, 2), "passes": got >= asked}
        for bar, row, asked, got in found
    ]


def head_volume(voxels: int) -> al.Volume:
    """CT head on cubic voxels, so many a side: resampled between its slices, with air above and below."""
    found = cropped(real_volume("ct_head"), voxels)
    array, spacing = found.array.astype(np.float32), found.spacing[0]
    along = np.arange(voxels) * spacing
    along += (found.spacing[2] * (array.shape[0] - 1) - along[-1]) / 2
    place = along / found.spacing[2]
    below = np.clip(np.floor(place).astype(int), 0, array.shape[0] - 2)
    share = np.clip(place - below, 0, 1)[:, None, None].astype(np.float32)
    values = (1 - share) * array[below] + share * array[below + 1]
    values[(place < 0) | (place > array.shape[0] - 1)] = array.min()
    about = {"units": found.units, "modality": found.modality}
    return al.Volume(np.round(values).astype(np.int16), spacing=(spacing,) * 3, name=f"head-{voxels}", **about)


def view(volume: al.Volume, angle_deg: float, size: tuple[int, int]) -> al.Camera:
    """Perspective camera on a circle round the volume, a little above it."""
    corners = volume.corners_world()
    middle = corners.mean(axis=0)
    reach = float(np.linalg.norm(corners - middle, axis=1).max())
    angle = math.radians(angle_deg)
    way = np.array([math.sin(angle), -math.cos(angle), 0.3])
    eye = middle + 2.6 * reach * way / np.linalg.norm(way)
    return al.Camera.perspective(eye=tuple(eye), target=tuple(middle), fov_deg=30)


def turned(volume: al.Volume, function: al.TransferFunction, look: str, size: tuple[int, int]) -> Callable[[int], al.Scene]:
    """Scenes by number: the camera turns; with shadows the light does as well."""

    def scene(number: int) -> al.Scene:
        angle = math.radians(40 + 1.7 * number) if look == "shadows" else 0.0
        x, y, z = LIGHT
        to_light = (x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle), z)
        camera = view(volume, 30 + TURN_DEG * number, size)
        lights = [al.Light.directional(to_light=to_light)]
        return al.Scene(volume, transfer=function, camera=camera, lights=lights, look=al.Look(**LOOKS[look]), background=None)

    return scene


def called(driver: str) -> str | al.driver.March:
    """Return the driver that is called so."""
    return al.driver.March(adaptive=True) if driver == ADAPTIVE else driver


def rates(
    renderer: al.Renderer, volume: al.Volume, function: al.TransferFunction, look: str, size: tuple[int, int], options: Any
) -> list[dict[str, Any]]:
    """Frames a second of each driver, in turns, and the error of one frame."""
    scene = turned(volume, function, look, size)
    drivers = SHADOWING if look == "shadows" else DRIVERS

    def frames(driver: str, tone: str) -> Callable[[], al.Image]:
        numbers = itertools.count()

        def draw() -> al.Image:
            drawn = scene(next(numbers))
            dimmed = {"visibility": "shadow_volume"} if look == "shadows" and driver == "march" else {}
            toned = replace(drawn.layers[0], look=al.Look(**LOOKS[look], **dimmed, tone=tone))
            return renderer.render(replace(drawn, layers=(toned,)), size, step=options.step, driver=called(driver))

        return draw

    jobs = {(driver, tone): frames(driver, tone) for driver in drivers for tone in ("linear", "reinhard")}
    rate = {job: 1 / spread(runs.wall)["median"] for job, runs in side_by_side(jobs, options.repeats, warm=2).items()}
    truth = None if look == "shadows" else renderer.render(scene(0), size, step=1 / 8, skip="none").rgba
    rows = []
    for driver in drivers:
        first = renderer.render(scene(0), size, step=options.step, driver=called(driver))
        rows.append(
            {
                "driver": driver,
                "ms": round(1e3 / rate[driver, "linear"], 1),
                "frames/s": round(rate[driver, "linear"], 2),
                "with tones": round(rate[driver, "reinhard"], 2),
                "tones cost": round(rate[driver, "linear"] - rate[driver, "reinhard"], 2),
                "rmse": "-" if truth is None else f"{errors(first.rgba, truth)['rmse']:.4f}",
                "samples": first.stats["samples"],
            }
        )
    return rows


def against_bare(device: Any, volume: al.Volume, size: tuple[int, int], options: Any) -> dict[str, Any]:
    """Rate of ``slices`` without skipping and early ends over that of the bare stack, of one view."""
    from airlight.rendering.ways import draw_frame

    look = al.Look(transfer="postclassified", shade="none", integrate=al.integrate.EmissionAbsorption(opaque_at=1.0))
    drawn = al.Scene(volume, transfer=bone(), camera=view(volume, 30, size), look=look, background=None)
    request = Request(size, al.driver.Slices(), options.step, "none")
    frame = prepare(device, drawn, request, lambda: None, lambda *_: None)
    stack = bare_stack(frame)
    runs = side_by_side({"bare": stack.draw, "slices": lambda: draw_frame(frame)[0]}, options.repeats, warm=2)
    difference = errors(runs["slices"].result, runs["bare"].result)
    quotient = float(np.median(np.array(runs["bare"].wall) / np.array(runs["slices"].wall)))
    return {
        "bare ms": round(1e3 * spread(runs["bare"].wall)["median"], 1),
        "slices ms": round(1e3 * spread(runs["slices"].wall)["median"], 1),
        "slices of the bare rate": round(quotient, 2),
        "rmse between them": f"{difference['rmse']:.4f}",
    }


if __name__ == "__main__":
    sys.exit(main())
