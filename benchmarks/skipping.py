"""Empty space: what passing over blocks saves, on scenes made for it, and what the blocks themselves cost.

*scenes*: a tree of vessels that fills 1 % of its volume, a volume that is full though its function is empty at other values,
and, where the file is, projections of the CT head: samples and time without skipping (``skip="none"``) over those with it, and
the greatest difference of the two pictures. *steps*: of every fourth ray of the tree, in float64: look-ups of blocks that are
passed over, and the frame's samples over those of slabs that hold something. *iso*: bone of the CT head against the basic
caster (steps of a voxel to the hit, no blocks, no sharper hits), by blocks alone and at steps of 5 voxels with sharper hits.
*blocks*: ranges of a volume of 16 bits, occupancy for another function with the leaps that are made of it, and their bytes.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from common import arguments, by_both_clocks, described, frame_of, from_corner, parsed, side_by_side, table, write_json
from volumes import cropped, noisy_cloud, real_volume

import airlight as al
from airlight.gpu import blocks, ranges
from airlight.gpu.device import Device, open_device
from airlight.reference import prepare as prepare_reference
from airlight.reference.camera import CAMERAS
from airlight.reference.field import field_value
from airlight.reference.march import span
from airlight.rendering.march import MarchFrame
from airlight.rendering.ways import draw_frame
from airlight.stage import BLOCK_VOXELS, BlockRanges, Grid, Within

BONE = 300.0  # HU
EVERY = 4
BARS = {
    "tree: steps a ray": ("at most", 15.0),
    "tree: samples over those that count": ("at most", 2.0),
    "tree: times faster": ("at least", 8.0),
    "full: time of skipping": ("at most", 1.03),
    "iso, blocks: fewer samples": ("at least", 10.0),
    "iso, blocks: times faster": ("at least", 4.0),
    "iso, steps of 5: fewer samples": ("at least", 30.0),
    "iso, steps of 5: times faster": ("at least", 6.0),
    "ranges [s]": ("at most", 0.25),
    "occupancy [ms]": ("at most", 15.0),
    "bytes over the volume's": ("at most", 0.05),
}


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "skipping", repeats=7, size=512, step=1.0, clock="what decides: cpu where others are busy")
    options = parsed(parser, argv, size=48, repeats=1)
    device = open_device(options.device)
    try:
        about = described(device, options)
        voxels = 64 if options.quick else 256
        vessels, head = tree(voxels), real_volume("ct_head")
        head = cropped(head, 48) if options.quick else head
        red = al.TransferFunction([(40, "firebrick", 0.0), (120, "red", 0.3)])
        scenes = {
            "tree": from_corner(vessels, red, {}),
            "tree, unlit": from_corner(vessels, red, {"shade": "none"}),
            "full": from_corner(noisy_cloud(voxels), full_function(), {"shade": "none"}),
        }
        scenes |= {name: from_corner(head, grey(head), {"integrate": name, "shade": "none"}) for name in ("mip", "minip")}
        rows = [compared(device, name, scene, options) for name, scene in scenes.items()]
        print(table(rows))
        steps = steps_of(device, scenes["tree"], options)
        print("\n" + table([steps]))
        iso = [against_caster(device, head, view, options) for view in ("front", "left", "iso")]
        print("\n" + table(iso))
        made = block_costs(device, 64 if options.quick else 512, options)
        print("\n" + table([made]))
    finally:
        device.close()
    times = {row["scene"]: row[f"times faster {options.clock}"] for row in rows}
    found = {
        "tree: steps a ray": steps["steps a ray"],
        "tree: samples over those that count": steps["samples over those that count"],
        "tree: times faster": times["tree"],
        "full: time of skipping": 1 / times["full"],
        **{f"iso, {way}: {what}": min(row[f"{way}: {what}"] for row in iso) for way in WAYS for what in GAINS},
        "ranges [s]": made[f"ranges [s] {options.clock}"],
        "occupancy [ms]": made[f"occupancy [ms] {options.clock}"],
        "bytes over the volume's": made["bytes over the volume's"],
    }
    bars = [
        {"bar": name, "wanted": f"{kind} {bar:g}", "found": found[name], "met": (found[name] <= bar) == (kind == "at most")}
        for name, (kind, bar) in BARS.items()
    ]
    print("\n" + table(bars))
    write_json(options.out, about | {"scenes": rows, "steps": steps, "iso": iso, "blocks": made, "bars": bars})
    return 0 if all(row["met"] for row in bars) or options.quick else 1


# -- scenes


def tree(voxels: int, seed: int = 4) -> al.Volume:
    """Vessels that branch, of 8 bits, in a volume that is otherwise zero."""
    rng = np.random.default_rng(seed)
    values = np.zeros((voxels,) * 3, dtype=np.uint8)

    def grow(place: Any, way: Any, radius: float, length: float, depth: int) -> None:
        for _ in range(int(length)):
            way = way + rng.normal(0, 0.12, 3)
            way /= np.linalg.norm(way)
            place = place + way
            low = np.maximum(np.floor(place - radius - 1), 0).astype(int)
            high = np.minimum(np.ceil(place + radius + 2), voxels).astype(int)
            if (high <= low).any():
                return
            part = values[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
            axes = np.ogrid[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
            away = np.sqrt(sum((axis - p) ** 2 for axis, p in zip(axes, place, strict=True)))
            np.maximum(part, (200 * np.clip(radius + 0.5 - away, 0, 1)).astype(np.uint8), out=part)
        for _ in range(2 if depth else 0):
            grow(place, way + rng.normal(0, 0.6, 3), 0.75 * radius, 0.85 * length, depth - 1)

    grow(np.array([0.02, 0.5, 0.5]) * voxels, np.array([1.0, 0.0, 0.0]), voxels / 25, voxels / 4.5, 6)
    return al.Volume(values, name="vessels")


def full_function() -> al.TransferFunction:
    """Return a function that is empty, but not at the values of the cloud."""
    return al.TransferFunction([(-40, "blue", 0.0), (0, (0.2, 0.3, 0.6), 0.002), (255, "white", 0.008)])


def grey(volume: al.Volume) -> al.TransferFunction:
    """From black to white over the volume's range."""
    known = al.statistics(volume)
    return al.TransferFunction([(known.minimum, "black", 0.0), (known.maximum, "white", 1.0)])


def compared(device: Device, name: str, scene: al.Scene, options: Any) -> dict[str, Any]:
    """Time and samples of a scene with and without skipping."""
    frames = {skip: frame_of(device, scene, options, skip) for skip in ("auto", "none")}
    measured = side_by_side({n: (lambda f=f: draw_frame(f)) for n, f in frames.items()}, options.repeats, warm=2)
    auto, none = measured["auto"], measured["none"]
    faster = by_both_clocks(none, auto)
    volume = scene.layers[0].volume
    return {
        "scene": name,
        "not zero %": 100 * float(np.count_nonzero(volume.array) / volume.array.size),
        "ms cpu": 1e3 * float(np.median(auto.cpu)),
        "ms wall": 1e3 * float(np.median(auto.wall)),
        "fewer samples": float(none.result[2].sum() / auto.result[2].sum()),
        "times faster cpu": faster["cpu"]["median"],
        "times faster wall": faster["wall"]["median"],
        "apart x255": 255 * float(np.abs(auto.result[0] - none.result[0]).max()),
    }


# -- steps, counted on the host: frames are not burdened with it


def steps_of(device: Device, scene: al.Scene, options: Any) -> dict[str, Any]:
    """Look-ups of blocks of the mean ray, and samples over those of slabs that hold something."""
    frame = frame_of(device, scene, options)
    samples = float(draw_frame(frame)[2].sum(dtype=np.float64))
    distance = leaps_of(device, frame)
    setup = prepare_reference(scene)
    y, x = np.mgrid[: options.size : EVERY, : options.size : EVERY].reshape(2, -1)
    origin, direction = CAMERAS[scene.camera.name](scene.camera, (options.size, options.size), x, y)
    begin, end = span(setup, origin, direction)
    met = end > begin
    origin_index, direction_index = (
        setup.index_of(origin)[met],
        (direction @ setup.layer.volume.index_from_world[:3, :3].T)[met],
    )
    begin, end = begin[met], end[met]
    steps = look_ups(distance, origin_index, direction_index, begin, end)
    h = options.step * setup.spacing_world
    first = scene.layers[0].transfer.empty_stretches[0][1]
    counting, k = 0, np.ceil(begin / h)
    front = np.full(len(begin), -np.inf)
    while (k * h < end).any():
        value = np.where(k * h < end, field_value(setup, origin_index + (k * h)[:, None] * direction_index)[0], -np.inf)
        counting += int(np.count_nonzero(np.maximum(front, value) > first))
        front, k = value, k + 1
    return {
        "rays": int(met.sum()),
        "steps a ray": float(steps.mean()),
        "most steps": int(steps.max()),
        "samples": samples,
        "samples over those that count": samples / (EVERY**2 * counting),
    }


def leaps_of(device: Device, frame: MarchFrame) -> npt.NDArray[np.uint8]:
    """Leaps from blocks (z, y, x), as the device has them."""
    asked = frame.layers[0].resources["field"]["leaps"]
    shape = tuple(ranges.block_count(n) for n in reversed(frame.layers[0].context.volume.size))
    return blocks.leaps(blocks.occupied(asked.empty, partial(blocks.known_ranges, device), shape))


def look_ups(distance: Any, origin: Any, direction: Any, begin: Any, end: Any) -> npt.NDArray[np.int64]:
    """How many times each ray (n,) looks up a block that it leaps from; those that hold something are walked through."""
    t, count = begin.copy(), np.zeros(len(begin), dtype=np.int64)
    rate = 1 / np.where(direction == 0, 1e-30, direction)
    last = np.array(distance.shape[::-1]) - 1
    while (going := t < end).any():
        place = (origin + (t + 1e-6)[:, None] * direction) / BLOCK_VOXELS
        block = np.clip(np.floor(place), 0, last)
        x, y, z = block.astype(int).T
        reach = distance[z, y, x]
        count += going & (reach > 0)
        left = np.maximum(reach, 1.0)[:, None]
        face = (block + np.where(direction > 0, left, 1 - left)) * BLOCK_VOXELS
        t = np.where(going, np.maximum(((face - origin) * rate).min(axis=1), t) + 1e-6, t)
    return count


# -- surfaces

WAYS = {"blocks": {"blocks": True, "refine": "none"}, "steps of 5": {"blocks": True, "refine": "bisection"}}
GAINS = ("fewer samples", "times faster")


def against_caster(device: Device, head: al.Volume, view: str, options: Any) -> dict[str, Any]:
    """Samples and time of the basic caster over those of the ways."""
    scene = al.Scene(
        head,
        transfer=grey(head),
        look=al.Look(integrate=al.integrate.FirstHit(iso=BONE), gradient="precomputed"),
        camera=al.fit_camera(view, head.corners_world(), 1.0),
        background=None,
    )
    frames = {"basic": frame_of(device, scene, options, "none", blocks=False, refine="none")}
    for name, driver in WAYS.items():
        large = type(options)(**{**vars(options), "step": 5.0}) if name == "steps of 5" else options
        frames[name] = frame_of(device, scene, large, **driver)
    measured = side_by_side({n: (lambda f=f: draw_frame(f)) for n, f in frames.items()}, options.repeats, warm=2)
    basic, row = measured["basic"], {"view": view, "basic ms": 1e3 * float(np.median(measured["basic"].wall))}
    for name in WAYS:
        one = measured[name]
        row[f"{name}: fewer samples"] = float(basic.result[2].sum() / one.result[2].sum())
        row[f"{name}: times faster"] = by_both_clocks(basic, one)[options.clock]["median"]
        row[f"{name}: rmse x255"] = 255 * float(np.sqrt(np.mean((one.result[0] - basic.result[0]) ** 2)))
    return row


# -- blocks


def block_costs(device: Device, voxels: int, options: Any) -> dict[str, Any]:
    """Seconds to find the ranges of blocks, milliseconds to find leaps for a function, and bytes of both."""
    samples = np.random.default_rng(0).integers(0, 4096, (voxels // 2, voxels, voxels), dtype=np.uint16)
    volume = al.Volume(np.concatenate([samples // 8, samples]))
    del samples
    asked = BlockRanges(Grid(volume, (0,), 0, True))
    known = blocks.known_ranges(device, asked)
    empty = (tuple(Within(asked, low, high) for low, high in ((-np.inf, 600.0), (4000.0, 5000.0))),)
    jobs = {
        "ranges": lambda: ranges.block_ranges(volume.array),
        "occupancy": lambda: blocks.make_leaps(device, blocks.occupied(empty, lambda _: known, known.least.shape)),
    }
    measured = side_by_side(jobs, options.repeats)
    leaps = measured["occupancy"].result
    row: dict[str, Any] = {"voxels a side": voxels}
    for clock in ("wall", "cpu"):
        row[f"ranges [s] {clock}"] = float(np.median(getattr(measured["ranges"], clock)))
        row[f"occupancy [ms] {clock}"] = 1e3 * float(np.median(getattr(measured["occupancy"], clock)))
    return row | {"bytes over the volume's": (known.bytes + leaps.bytes) / volume.array.nbytes}


if __name__ == "__main__":
    sys.exit(main())
