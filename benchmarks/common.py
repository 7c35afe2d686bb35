"""What the benchmarks share: options, repeated side-by-side runs, frames, errors of images, JSON and tables."""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

import airlight as al
from airlight.gpu.device import Device
from airlight.rendering.frame import Request, prepare
from airlight.rendering.march import MarchFrame

ROOT = Path(__file__).parent.parent


# -- command line and results


def arguments(
    description: str | None,
    name: str,
    repeats: int | None = None,
    size: int | None = None,
    step: float | None = None,
    clock: str | None = None,
) -> argparse.ArgumentParser:
    """Return a parser with the options that all benchmarks have, and with those for which something is given.

    ``step`` comes with the device that draws; ``clock`` says what the chosen clock is for.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    target = ROOT / "out" / f"{name}.json"
    parser.add_argument("--out", type=Path, default=target, help=f"JSON file with all numbers (default: out/{name}.json)")
    parser.add_argument("--quick", action="store_true", help="tiny sizes: shows that it works, its numbers mean nothing")
    if repeats is not None:
        parser.add_argument("--repeats", type=int, default=repeats, help="counted runs of each (default: %(default)s)")
    if size is not None:
        parser.add_argument("--size", type=int, default=size, help="width and height of the picture (default: %(default)s)")
    if step is not None:
        parser.add_argument("--step", type=float, default=step, help="distance of samples in voxels (default: %(default)s)")
        parser.add_argument("--device", default=None, help="adapter, by number, kind or part of its name")
    if clock is not None:
        parser.add_argument("--clock", choices=("wall", "cpu"), default="wall", help=clock)
    return parser


def parsed(parser: argparse.ArgumentParser, argv: list[str] | None, **quick: int) -> Any:
    """Options of the command line; with ``--quick`` these take the place of what it says."""
    options = parser.parse_args(argv)
    if options.quick:
        vars(options).update(quick)
    return options


def machine(device: Any = None) -> dict[str, Any]:
    """What the numbers depend on: processor, versions, adapter, load at the start."""
    found = {
        "when": datetime.now(UTC).isoformat(timespec="seconds"),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "versions": {"python": platform.python_version(), "airlight": al.__version__}
        | {name: _version(name) for name in ("numpy", "wgpu", "vtk")},
    }
    if hasattr(os, "getloadavg"):
        found["load_average"] = round(os.getloadavg()[0], 2)
    if device is not None:
        info = device.info
        found["adapter"] = {"name": info.name, "kind": info.kind, "backend": info.backend, "driver": info.driver}
    return found


def described(device: Any, options: Any) -> dict[str, Any]:
    """Print and return what drew: machine, size, step and clock."""
    about = machine(device) | {name: getattr(options, name) for name in ("quick", "size", "step", "clock")}
    print(f"{about['adapter']['name']}, {about['cores']} cores, {options.size}x{options.size}, step {options.step}\n")
    return about


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.processor())


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def write_json(path: Path, results: Mapping[str, Any]) -> None:
    """Write results; numbers of NumPy become Python's."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=2, default=_plain) + "\n", encoding="utf-8")
    print(f"\nwritten: {path.name}")


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


def table(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> str:
    """Markdown table of rows; floats are given with three significant digits."""
    names = list(columns or rows[0])
    cells = [[_cell(row.get(name, "")) for name in names] for row in rows]
    widths = [max(len(name), *(len(line[i]) for line in cells)) for i, name in enumerate(names)]
    numeric = [all(isinstance(row.get(name), (int, float, type(None))) for row in rows) for name in names]

    def line(values: Iterable[str]) -> str:
        padded = (v.rjust(w) if n else v.ljust(w) for v, w, n in zip(values, widths, numeric, strict=True))
        return "| " + " | ".join(padded) + " |"

    rule = "|" + "|".join("-" * (w + 1) + (":" if n else "-") for w, n in zip(widths, numeric, strict=True)) + "|"
    return "\n".join([line(names), rule, *(line(row) for row in cells)])


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return str(value)


# -- time


@dataclass
class Measured:
    """Repeated runs of one job: seconds of wall and of all this process's cores, and what the last run returned."""

    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    result: Any = None

    def run(self, job: Callable[[], Any], counted: bool = True) -> None:
        """Run a job once."""
        wall, cpu = time.perf_counter(), time.process_time()
        self.result = job()
        if counted:
            self.wall.append(time.perf_counter() - wall)
            self.cpu.append(time.process_time() - cpu)

    def summary(self) -> dict[str, Any]:
        """Median, least and greatest in milliseconds."""
        return {"wall_ms": spread(1e3 * np.array(self.wall)), "cpu_ms": spread(1e3 * np.array(self.cpu))}


def spread(values: Any) -> dict[str, float]:
    """Median, minimum and maximum."""
    values = np.asarray(values, dtype=np.float64)
    return {"median": float(np.median(values)), "min": float(values.min()), "max": float(values.max()), "n": int(values.size)}


def side_by_side(jobs: Mapping[str, Callable[[], Any]], repeats: int, warm: int = 1) -> dict[str, Measured]:
    """Run jobs in turns, A B A B, so that whatever slows the machine down meets all of them; the first turns do not count."""
    measured = {name: Measured() for name in jobs}
    for turn in range(warm + repeats):
        for name, job in jobs.items():
            measured[name].run(job, counted=turn >= warm)
    return measured


def ratio(one: Sequence[float], other: Sequence[float]) -> dict[str, float]:
    """Quotients ``one / other`` of the same turns."""
    return spread(np.asarray(one) / np.asarray(other))


def by_both_clocks(one: Measured, other: Measured) -> dict[str, dict[str, float]]:
    """Quotients ``one / other`` of the same turns, by the wall's clock and by the processor's."""
    return {"wall": ratio(one.wall, other.wall), "cpu": ratio(one.cpu, other.cpu)}


# -- frames


def from_corner(volume: al.Volume, function: al.TransferFunction, look: Mapping[str, Any]) -> al.Scene:
    """Scene of a volume seen from its corner."""
    camera = al.fit_camera("iso", volume.corners_world(), 1.0)
    return al.Scene(volume, transfer=function, look=al.Look(**look), camera=camera, background=None)


def frame_of(device: Device, drawn: al.Scene, options: Any, skip: str) -> MarchFrame:
    """Frame of a scene, ready to be drawn again and again by ``draw_march``."""
    request = Request((options.size, options.size), al.driver.March(), options.step, skip)
    return prepare(device, drawn, request, lambda: None, lambda *_: None)


# -- errors of images


def errors(image: Any, truth: Any) -> dict[str, float]:
    """Greatest and root mean square difference of linear, premultiplied colours and opacity, and PSNR for a peak of one."""
    difference = np.asarray(image, dtype=np.float64) - np.asarray(truth, dtype=np.float64)
    rmse = float(np.sqrt(np.mean(difference**2)))
    return {"max": float(np.abs(difference).max()), "rmse": rmse, "psnr_db": psnr(rmse)}


def psnr(rmse: float) -> float:
    """Peak signal to noise ratio in decibel for a peak of one; 200 where the images are equal."""
    return float(-20 * np.log10(max(rmse, 1e-10)))
