"""Samples a second of the march, beside the plainest possible march on the same device.

Brute force (no skipping, unshaded, post-classified) must reach 80 % of the plainest march (see ``plain_march.py``) of the same
adapter and texture format. Both draw in turns, so that ratios come from one run, and their pictures must agree within 2/255.
Functions without an empty stretch are the honest case: with the function "bone" airlight passes by empty slabs, which the
plainest march does not. A second table gives the rates of other looks.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from common import (
    Measured,
    arguments,
    by_both_clocks,
    described,
    frame_of,
    from_corner,
    parsed,
    side_by_side,
    table,
    write_json,
)
from plain_march import plain_march
from volumes import bone, cropped, haze, noisy_cloud, real_volume

import airlight as al
from airlight.gpu.device import Device, open_device
from airlight.rendering.march import MarchFrame
from airlight.rendering.ways import draw_frame

LEAST_RATIO = 0.8
AGREE = 2 / 255
BRUTE = {"transfer": "postclassified", "shade": "none"}
LOOKS: dict[str, dict[str, Any]] = {
    "post-classified, unshaded": BRUTE,
    "pre-integrated, unshaded": {"shade": "none"},
    "post-classified, shaded": {"transfer": "postclassified"},
    "pre-integrated, shaded": {},
    "pre-integrated, shaded, sobel": {"gradient": "sobel"},
    "pre-integrated, shaded, precomputed gradients": {"gradient": "precomputed"},
    "linear exact, post-classified, unshaded": BRUTE | {"field": "linear_exact"},
    "maximum intensity": {"integrate": "mip"},
    "mean": {"integrate": "mean"},
    "first hit": {"integrate": "first_hit"},
}


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when the pictures differ or the ratio is missed."""
    parser = arguments(__doc__, "throughput", repeats=7, size=512, step=0.5, clock="what decides: cpu where others are busy")
    options = parsed(parser, argv, size=48, repeats=1)
    device = open_device(options.device)
    try:
        about = described(device, options)
        volumes = drawn_volumes(options.quick)
        beside = [against_plain(device, *case, options) for case in cases(volumes)]
        print(table([shown(row, options.clock) for row in beside]))
        looks = breakdown(device, volumes, options)
        print("\n" + table(looks))
    finally:
        device.close()
    passed = all(row["agrees"] and (row[options.clock]["median"] >= LEAST_RATIO or not row["counts"]) for row in beside)
    print(f"\n{'PASS' if passed else 'FAIL'}: at least {LEAST_RATIO} of the plainest march wherever nothing is empty")
    write_json(options.out, about | {"least_ratio": LEAST_RATIO, "against_plainest": beside, "looks": looks, "passes": passed})
    return 0 if passed or options.quick else 1


def drawn_volumes(quick: bool) -> dict[str, al.Volume]:
    """Volumes by name: a CT head of 16 bits, and a noisy cloud of 8 bits."""
    if quick:
        return {"ct_head": cropped(real_volume("ct_head"), 24), "cloud": noisy_cloud(24)}
    return {"ct_head": real_volume("ct_head"), "cloud": noisy_cloud(256)}


def cases(volumes: dict[str, al.Volume]) -> list[tuple[str, al.Scene, bool]]:
    """Name, scene, and whether the bar counts: where no value is empty both marches do the same work."""
    mip = {"integrate": "mip", "shade": "none"}
    return [
        *((f"{name}, haze", from_corner(volume, haze(volume), BRUTE), True) for name, volume in volumes.items()),
        ("ct_head, haze, orthographic", orthographic(from_corner(volumes["ct_head"], haze(volumes["ct_head"]), BRUTE)), True),
        ("ct_head, bone (empty space)", from_corner(volumes["ct_head"], bone(), BRUTE), False),
        *((f"{name}, MIP", from_corner(volume, haze(volume), mip), False) for name, volume in volumes.items()),
    ]


def orthographic(drawn: al.Scene) -> al.Scene:
    """Return the same scene with parallel rays."""
    near = drawn.camera
    assert isinstance(near, al.Camera)
    height = 0.55 * float(np.linalg.norm(np.subtract(near.target, near.eye)))
    camera = al.Camera.orthographic(eye=near.eye, target=near.target, up=near.up, height=height)
    return al.Scene(layers=drawn.layers, camera=camera, lights=drawn.lights, background=None)


def against_plain(device: Device, name: str, drawn: al.Scene, counts: bool, options: Any) -> dict[str, Any]:
    """Draw one scene in turns by airlight and by the plainest march."""
    frame = frame_of(device, drawn, options, "none")
    plain = plain_march(frame)
    measured = side_by_side({"airlight": lambda: draw_frame(frame), "plainest": plain.draw}, options.repeats)
    ours, theirs = measured["airlight"], measured["plainest"]
    samples = {"airlight": float(ours.result[2].sum()), "plainest": theirs.result[1]}
    difference = float(np.abs(ours.result[0] - theirs.result[0]).max())
    # Rates, not times: rays that end early may end one sample apart.
    share = samples["airlight"] / samples["plainest"]
    return {
        "case": name,
        "counts": counts,
        "format": frame_format(frame),
        "samples": samples,
        "difference_max": difference,
        "agrees": difference <= AGREE,
        **{clock: found | {"median": share * found["median"]} for clock, found in by_both_clocks(theirs, ours).items()},
        "times": {name: m.summary() for name, m in measured.items()},
        "rates": {name: rate(m, samples[name]) for name, m in measured.items()},
    }


def rate(measured: Measured, samples: float) -> dict[str, float]:
    """Millions of samples a second, by the wall's clock and a second of one core."""
    return {"wall": samples / float(np.median(measured.wall)) / 1e6, "cpu": samples / float(np.median(measured.cpu)) / 1e6}


def frame_format(frame: MarchFrame) -> str:
    """Texture format of the volume."""
    from airlight.rendering.resources import grid_texture

    return str(grid_texture(frame.device, frame.layers[0].resources["field"]["grid"], frame.progress).encoding.format)


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """One row of the printed table."""
    return {
        "case": row["case"],
        "format": row["format"],
        "Msamples": row["samples"]["airlight"] / 1e6,
        f"airlight [M/s {clock}]": row["rates"]["airlight"][clock],
        f"plainest [M/s {clock}]": row["rates"]["plainest"][clock],
        "ratio": row[clock]["median"],
        "ratio min": row[clock]["min"],
        "ratio max": row[clock]["max"],
        "apart [1/255]": 255 * row["difference_max"],
        "bar": (row[clock]["median"] >= LEAST_RATIO) if row["counts"] else "-",
    }


def breakdown(device: Device, volumes: dict[str, al.Volume], options: Any) -> list[dict[str, Any]]:
    """Rates of all looks, in turns, on the CT head."""
    volume = volumes["ct_head"]
    functions = {"haze": haze(volume), "bone": bone()}
    rows = []
    for name, function in functions.items():
        frames = {
            look: frame_of(device, from_corner(volume, function, stages), options, "none") for look, stages in LOOKS.items()
        }
        jobs = {look: (lambda frame=frame: draw_frame(frame)) for look, frame in frames.items()}
        for look, measured in side_by_side(jobs, max(1, options.repeats // 2)).items():
            found = rate(measured, float(measured.result[2].sum()))
            rows.append(
                {
                    "function": name,
                    "look": look,
                    "Msamples": float(measured.result[2].sum()) / 1e6,
                    "ms": 1e3 * float(np.median(measured.wall)),
                    "M/s wall": found["wall"],
                    "M/s cpu": found["cpu"],
                }
            )
    return rows


if __name__ == "__main__":
    sys.exit(main())
