"""Time of each reconstruction filter relative to linear, its error against the float64 reference, and its frequency response.

Frames are unshaded and post-classified, without skipping, all filters in turns, so that ratios come from one run. Errors are
those of some hundred pixels: of the picture, and of the mean value along each ray in units of the data's range. The bar: the
cubic B-spline by eight fetches takes at most six times the time of linear. ``--docs`` writes the guide's plot and table.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from common import (
    ROOT,
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
from volumes import cropped, haze, real_volume

import airlight as al
from airlight import reference
from airlight.gpu.device import Device, open_device
from airlight.reconstruction import kernels
from airlight.rendering.march import MarchFrame
from airlight.rendering.ways import draw_frame

MOST = 6.0
BRUTE = {"transfer": "postclassified", "shade": "none"}
FIELDS: dict[str, Any] = {
    "nearest": al.field.Nearest(),
    "linear": al.field.Linear(),
    "linear exact": al.field.LinearExact(),
    "B-spline": al.field.BSpline(),
    "B-spline, prefiltered": al.field.BSpline(prefilter=True),
    "B-spline exact": al.field.BSplineExact(),
    "Catmull-Rom": al.field.CatmullRom(),
    "Mitchell": al.field.Mitchell(),
    "Lanczos, radius 3": al.field.WindowedSinc(),
    "Kaiser, radius 3": al.field.WindowedSinc("kaiser"),
    "Gaussian kernel, radius 2": al.field.Kernel(),
    "kernel in a cube, radius 2": al.field.KernelBody(),
    "levels": al.field.Levels(),
}
FREQUENCIES = (0.1, 0.25, 0.5, 0.75)  # cycles a voxel; what lies beyond 0.5 is not in the samples
PIXELS = 300
SHARES = (np.arange(512) + 0.5) / 512


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when the B-spline takes more than six times the time of linear."""
    parser = arguments(__doc__, "filters", repeats=5, size=256, step=1.0, clock="what decides: cpu where others are busy")
    parser.add_argument("--docs", action="store_true", help="write docs/guide/filters/response.svg (matplotlib)")
    options = parsed(parser, argv, size=32, repeats=1)
    device = open_device(options.device)
    try:
        about = described(device, options)
        volume = real_volume("ct_head")
        volume = cropped(volume, 20) if options.quick else volume
        rows = measured_rows(device, volume, options)
    finally:
        device.close()
    print(table([shown(row, options.clock) for row in rows]))
    found = next(row for row in rows if row["filter"] == "B-spline")["relative"][options.clock]["median"]
    print(f"\n{'PASS' if found <= MOST else 'FAIL'}: B-spline by eight fetches {found:.2f} times linear, at most {MOST}")
    if options.docs:
        plot(ROOT / "docs" / "guide" / "filters" / "response.svg")
    write_json(options.out, about | {"most": MOST, "rows": rows, "passes": found <= MOST})
    return 0 if found <= MOST or options.quick else 1


def measured_rows(device: Device, volume: al.Volume, options: Any) -> list[dict[str, Any]]:
    """Draw with all filters in turns."""
    frames = {
        name: frame_of(device, from_corner(volume, haze(volume), BRUTE | {"field": field}), options, "none")
        for name, field in FIELDS.items()
    }
    jobs = {name: (lambda frame=frame: draw_frame(frame)) for name, frame in frames.items()}
    measured = side_by_side(jobs, options.repeats)
    return [
        {
            "filter": name,
            "reads": reads(field),
            "samples": float(measured[name].result[2].sum()),
            "relative": by_both_clocks(measured[name], measured["linear"]),
            "times": measured[name].summary(),
            "picture error": picture_error(measured[name], frames[name], options),
            "value error": value_error(device, volume, field, options),
            "response": response_of(field),
        }
        for name, field in FIELDS.items()
    ]


def reads(field: Any) -> int:
    """Voxels, or fetches of the texture unit, for one value."""
    fetches = {"nearest": 1, "linear": 1, "levels": 2, "linear_exact": 8, "bspline": 8}
    return fetches[field.name] if field.name in fetches else round((2 * field.support_voxels) ** 3)


def some_pixels(size: int) -> np.ndarray:
    """Pixels, drawn by lot, the same ones each time."""
    return np.random.default_rng(1).integers(0, size, (PIXELS, 2))


def picture_error(measured: Measured, frame: MarchFrame, options: Any) -> float:
    """Greatest difference from the reference of some pixels."""
    at = some_pixels(options.size)
    truth = reference.render(frame.scene, (options.size, options.size), step=options.step, pixels=at)
    return float(np.abs(measured.result[0][at[:, 1], at[:, 0]] - truth.rgba).max())


def value_error(device: Device, volume: al.Volume, field: Any, options: Any) -> float:
    """Greatest difference from the reference of the mean value along a ray, as a share of the data's range."""
    known = al.statistics(volume)
    ramp = al.TransferFunction([(known.minimum, (0, 0, 0), 0.0), (known.maximum, (1, 1, 1), 0.0)])
    drawn = from_corner(volume, ramp, {"field": field, "integrate": "mean", "shade": "none"})
    at = some_pixels(options.size)
    image = draw_frame(frame_of(device, drawn, options, "none"))[0][at[:, 1], at[:, 0]]
    truth = reference.render(drawn, (options.size, options.size), step=options.step, pixels=at)
    return float(np.abs(image - truth.rgba)[:, 0].max())


def weights_of(field: Any) -> np.ndarray | None:
    """Weights (512, taps) of a separable filter at places spread over a cell."""
    if field.name == "nearest":
        return np.stack([SHARES < 0.5, SHARES >= 0.5], axis=1).astype(np.float64)
    if field.name in ("linear", "linear_exact", "levels"):
        return np.stack([1 - SHARES, SHARES], axis=1)
    if field.name in ("bspline", "bspline_exact"):
        return kernels.cubic_weights(1.0, 0.0, SHARES)
    if field.name in ("catmull_rom", "mitchell"):
        return kernels.cubic_weights(*field.family, SHARES)
    if field.name == "windowed_sinc":
        return kernels.tap_weights(kernels.windowed_sinc(field.window, field.radius), field.radius, SHARES, 1e-5)[0]
    if field.name == "kernel":
        return kernels.tap_weights(kernels.tabulated(field.samples, field.radius), field.radius, SHARES, 1e-5)[0]
    return None


def response_at(field: Any, frequency: np.ndarray) -> np.ndarray | None:
    """Magnitude of a filter's Fourier transform along an axis; a spline's prefilter divides it by that of its samples."""
    weights = weights_of(field)
    if weights is None:
        return None
    found = kernels.response(weights, frequency)
    return found * 3 / (2 + np.cos(2 * np.pi * frequency)) if getattr(field, "prefilter", False) else found


def response_of(field: Any) -> dict[str, float]:
    """Response at a few frequencies."""
    found = response_at(field, np.array(FREQUENCIES))
    return {} if found is None else {str(f): float(r) for f, r in zip(FREQUENCIES, found, strict=True)}


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """One row of the printed table."""
    return {
        "filter": row["filter"],
        "reads": row["reads"],
        "time": row["relative"][clock]["median"],
        "ms": row["times"][f"{clock}_ms"]["median"],
        "picture [1/255]": 255 * row["picture error"],
        "value [1e-6 of range]": 1e6 * row["value error"],
        **{f"at {f}": row["response"].get(str(f)) for f in FREQUENCIES},
    }


def plot(path: Path) -> None:
    """Draw the responses along an axis."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "airlight"
    from matplotlib import pyplot

    frequency = np.linspace(0, 1.5, 301)
    names = ("linear", "B-spline", "B-spline, prefiltered", "Catmull-Rom", "Mitchell", "Lanczos, radius 3")
    figure, axes = pyplot.subplots(figsize=(7, 3.6), layout="constrained")
    axes.axvspan(0, 0.5, color="0.94")
    for name in names:
        axes.plot(frequency, response_at(FIELDS[name], frequency), label=name, linewidth=1.5)
    axes.set(xlabel="frequency [cycles a voxel]", ylabel="response", xlim=(0, 1.5), ylim=(0, 1.2))
    axes.text(0.25, 1.12, "in the samples", ha="center")
    axes.text(1.0, 1.12, "copies, to be kept out", ha="center")
    axes.legend(frameon=False, fontsize="small")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)


if __name__ == "__main__":
    sys.exit(main())
