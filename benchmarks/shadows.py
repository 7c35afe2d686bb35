"""Half-angle slices beside the same slices without shadows, and frames a second of a head whose light and camera turn.

A head of 256 voxels a side, 640 x 480 pixels, steps of a voxel, pre-integrated and lit at both ends of slabs. *Ratios*: one
light, the same view with ``half_angle`` and with ``slices``, by angle between eye and light: at most 2.5 times as long.
*Rates*: light and camera turn by a degree each frame (Vollrath, Weiskopf and Ertl 2005: 2.7 frames a second), by the driver
``half_angle`` and by the march with a shadow volume that is made anew for each. *Buffers*: sizes of the light's buffer and of
groups, and transports. Errors are those of one view against half-angle slices with a buffer of 1536 texels.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from common import arguments, errors, machine, parsed, side_by_side, table, write_json
from frame_rates import head_volume
from volumes import bone, head

import airlight as al

ANGLES_DEG = (20, 60, 120, 160)
FUNCTIONS = {"bone": bone, "skin and bone": head}
VIEW_DEG = (30.0, 60.0)  # of the camera, and of the light from there
MOST, RATE = 2.5, 2.7
TRUE_SIZE = 1536


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "shadows", repeats=7, step=1.0)
    options = parsed(parser, argv, repeats=1)
    size = (64, 48) if options.quick else (640, 480)
    volume = head_volume(24 if options.quick else 256)
    found: dict[str, Any] = {}
    functions = list(FUNCTIONS)[: 1 if options.quick else None]
    with al.Renderer(options.device) as renderer:
        ratios = [of_angle(renderer, volume, name, angle, size, options) for name in functions for angle in ANGLES_DEG]
        found["ratios"] = [row for row, _ in ratios]
        print(table(found["ratios"]))
        found["rates"] = [row for name in functions for row in of_turning(renderer, volume, name, size, options)]
        print("\n" + table(found["rates"]))
        found["buffers"] = of_buffers(renderer, volume, size, options)
        print("\n" + table(found["buffers"]))
    slow, rate = max(times for _, times in ratios), found["rates"][0]["frames/s"]
    passed = slow <= MOST and rate >= RATE
    print(
        f"\n{'PASS' if passed else 'FAIL'}: at most {slow:.2f} times the slices ({MOST}), {rate:.2f} frames a second ({RATE})"
    )
    write_json(options.out, machine() | {"quick": options.quick, "size": size, "step": options.step, "passed": passed} | found)
    return 0 if passed or options.quick else 1


def scene_of(volume: al.Volume, name: str, turn_deg: float, light_deg: float, visibility: Any = "none") -> al.Scene:
    """Head seen from an angle round its axis, lit from another one, counted from the eye, and a little from above."""
    corners = volume.corners_world()
    middle, reach = corners.mean(axis=0), float(np.ptp(corners, axis=0).max())
    a, b = np.radians(turn_deg), np.radians(turn_deg + light_deg)
    eye = tuple(middle + 2.4 * reach * np.array([np.sin(a), np.cos(a), 0.15]))
    camera = al.Camera.perspective(eye=eye, target=tuple(middle), fov_deg=25)
    light = al.Light.directional(to_light=(np.sin(b), np.cos(b), 0.3))
    look = al.Look(lighting="interpolated", visibility=visibility)
    return al.Scene(volume, transfer=FUNCTIONS[name](), camera=camera, lights=[light], look=look, background=None)


def plain_driver(options: Any) -> al.driver.HalfAngle:
    """Driver as it is unless told."""
    return al.driver.HalfAngle(light_size=32) if options.quick else al.driver.HalfAngle()


def of_angle(
    renderer: al.Renderer, volume: al.Volume, name: str, angle: float, size: tuple[int, int], options: Any
) -> tuple[dict[str, Any], float]:
    """Time of shadows beside that of slices, from the same eye with the same light."""
    drawn = scene_of(volume, name, 30.0, angle)

    def job(driver: Any) -> Callable[[], al.Image]:
        return lambda: renderer.render(drawn, size, driver=driver, step=options.step)

    measured = side_by_side({"slices": job("slices"), "half_angle": job(plain_driver(options))}, options.repeats)
    plain, shadowed = (measured[driver].wall for driver in ("slices", "half_angle"))
    times = float(np.median(np.divide(shadowed, plain)))
    row = {
        "function": name,
        "light at [degrees]": angle,
        "slices [ms]": 1e3 * float(np.median(plain)),
        "half_angle [ms]": 1e3 * float(np.median(shadowed)),
        "times": times,
    }
    return row, times


def true_driver(options: Any) -> al.driver.HalfAngle:
    """Driver whose light is as fine as it can be told apart."""
    return replace(plain_driver(options), light_size=64 if options.quick else TRUE_SIZE, group=4)


def of_turning(
    renderer: al.Renderer, volume: al.Volume, name: str, size: tuple[int, int], options: Any
) -> list[dict[str, Any]]:
    """Frames a second where the camera turns one way and the light another, by a degree each frame; with errors of one view."""
    ways: dict[str, tuple[Any, Any]] = {"half_angle": (plain_driver(options), "none")}
    for cells in (8, 16) if options.quick else (64, 96):
        ways[f"march, shadow volume of {cells} cells"] = ("march", al.visibility.ShadowVolume(cells=cells))

    def drawn(way: str, turn_deg: float, light_deg: float) -> al.Image:
        driver, visibility = ways[way]
        lit = scene_of(volume, name, turn_deg, light_deg, visibility)
        return renderer.render(lit, size, driver=driver, step=options.step)

    def frames(way: str) -> Callable[[], al.Image]:
        turns = itertools.count()

        def frame() -> al.Image:
            n = float(next(turns))
            return drawn(way, n, 50.0 - 2 * n)

        return frame

    measured = side_by_side({way: frames(way) for way in ways}, options.repeats)
    truth = renderer.render(scene_of(volume, name, *VIEW_DEG), size, driver=true_driver(options), step=options.step)
    rows = []
    for way, times in measured.items():
        seconds = float(np.median(times.wall))
        error = errors(drawn(way, *VIEW_DEG).rgba, truth.rgba)
        rows.append({"function": name, "by": way, "ms": 1e3 * seconds, "frames/s": 1 / seconds, **error})
    return rows


def of_buffers(renderer: al.Renderer, volume: al.Volume, size: tuple[int, int], options: Any) -> list[dict[str, Any]]:
    """Time and error by texels of the light's buffer, slices of a group and transport."""
    drawn, plain = scene_of(volume, "bone", *VIEW_DEG), plain_driver(options)
    chosen = {
        f"light_size={n}": replace(plain, light_size=n) for n in ((16, 32) if options.quick else (256, 320, 384, 512, 1024))
    }
    chosen |= {f"group={n}": replace(plain, group=n) for n in (1, 8, 16, 64, 256)}
    chosen |= {name: replace(plain, transport=name) for name in ("coloured", "translucent")}

    def job(driver: Any) -> Callable[[], al.Image]:
        return lambda: renderer.render(drawn, size, driver=driver, step=options.step)

    measured = side_by_side({name: job(driver) for name, driver in chosen.items()}, options.repeats)
    truths: dict[Any, al.Image] = {}
    rows = []
    for name, driver in chosen.items():
        best = replace(true_driver(options), transport=driver.transport)
        if driver.transport not in truths:
            truths[driver.transport] = job(best)()
        image = job(driver)()
        rows.append(
            {
                "driver": name,
                "ms": 1e3 * float(np.median(measured[name].wall)),
                "MB": image.stats["lights"]["buffers"]["bytes"] / 1e6,
                **errors(image.rgba, truths[driver.transport].rgba),
            }
        )
    return rows


if __name__ == "__main__":
    sys.exit(main())
