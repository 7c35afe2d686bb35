"""What the benchmarks share: volumes and functions, repeated side-by-side runs, errors of images, JSON and tables."""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

import airlight as al

ROOT = Path(__file__).parent.parent
FILES = {"ct_head": "ct_head.nrrd", "ch2": "ch2.nii.gz", "engine": "engine.nii.gz", "bonsai": "bonsai.nii.gz"}


# -- command line and results


def arguments(description: str | None, name: str, repeats: int | None = None) -> argparse.ArgumentParser:
    """Return a parser with the options that all benchmarks have."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    target = ROOT / "out" / f"{name}.json"
    parser.add_argument("--out", type=Path, default=target, help=f"JSON file with all numbers (default: out/{name}.json)")
    parser.add_argument("--quick", action="store_true", help="tiny sizes: shows that it works, its numbers mean nothing")
    if repeats is not None:
        parser.add_argument("--repeats", type=int, default=repeats, help="counted runs of each (default: %(default)s)")
    return parser


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


# -- volumes


def data_folder() -> Path:
    """Folder of the real volumes: ``AIRLIGHT_DATA``, else ``shared/data`` beside the project."""
    return Path(os.environ.get("AIRLIGHT_DATA") or ROOT.parent / "shared" / "data")


def real_path(name: str) -> Path | None:
    """File of a real volume, None where it is not there."""
    path = data_folder() / FILES[name]
    return path if path.is_file() else None


def real_volume(name: str, voxels: int = 96) -> al.Volume:
    """Return a real volume, or a computed head-like one in its place, which says so in its name."""
    path = real_path(name)
    if path is not None:
        return al.open(path)
    where = "AIRLIGHT_DATA names the folder of real volumes"
    print(f"{FILES[name]} is not there ({where}); a computed volume stands in", file=sys.stderr)
    return stand_in(voxels)


def stand_in(voxels: int = 96) -> al.Volume:
    """Nested ellipsoids with the values of air, skin, tissue and bone in Hounsfield units."""
    axis = np.linspace(-1, 1, voxels)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    radius = np.sqrt((x / 0.8) ** 2 + (y / 0.9) ** 2 + (z / 0.85) ** 2) + 0.03 * np.sin(9 * x) * np.cos(8 * y) * np.sin(7 * z)
    values = np.interp(radius, [0, 0.7, 0.75, 0.85, 0.9, 1.0, 1.05], [40, 40, 1200, 1200, 60, 60, -1000])
    spacing = (200 / voxels,) * 3
    return al.Volume(np.round(values).astype(np.int16), spacing=spacing, units="mm", modality="CT", name="computed stand-in")


def cropped(volume: al.Volume, size: int) -> al.Volume:
    """Return the middle of a volume, at most so many voxels along each axis, for quick runs."""
    starts = [(n - min(n, size)) // 2 for n in volume.array.shape]
    part = volume.array[tuple(slice(a, a + min(n, size)) for a, n in zip(starts, volume.array.shape, strict=True))]
    matrix = volume.world_from_index.copy()
    matrix[:3, 3] = (volume.world_from_index @ [*starts[::-1], 1])[:3]
    about = {"units": volume.units, "modality": volume.modality, "anatomical": volume.anatomical}
    return al.Volume(np.ascontiguousarray(part), world_from_index=matrix, name=f"{volume.name} (cropped)", **about)


def noisy_cloud(voxels: int = 256, seed: int = 1) -> al.Volume:
    """A smooth cloud with noise on it, whole numbers of 8 bits, nowhere empty."""
    axis = np.linspace(-1, 1, voxels, dtype=np.float32)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    smooth = 90 * np.exp(-1.5 * (x * x + y * y + z * z)) + 30 * np.sin(7 * x) * np.cos(6 * y) * np.sin(5 * z) + 80
    noise = np.random.default_rng(seed).normal(0, 12, (voxels,) * 3).astype(np.float32)
    return al.Volume(np.clip(smooth + noise, 1, 255).astype(np.uint8), name=f"cloud-{voxels}")


def bone() -> al.TransferFunction:
    """Bone of a CT: opaque from 600 HU on, all below 150 HU empty."""
    return al.TransferFunction(
        [(150, (0.26, 0.1, 0.04), 0), (280, (0.7, 0.45, 0.26), 0.05), (600, (0.9, 0.8, 0.63), 0.6), (1600, (1, 1, 1), 1.6)]
    )


def head() -> al.TransferFunction:
    """Translucent skin and tissue over bone of a CT."""
    return al.TransferFunction(
        [
            (-600, (0.5, 0.25, 0.15), 0),
            (-300, (0.7, 0.4, 0.28), 0.02),
            (60, (0.6, 0.1, 0.08), 0.01),
            (250, (0.8, 0.6, 0.4), 0.06),
            (900, (1, 0.95, 0.85), 0.9),
        ]
    )


def brain() -> al.TransferFunction:
    """Skin and brain of an MRI of 8 bits."""
    return al.TransferFunction(
        [(30, (0.3, 0.15, 0.1), 0), (70, (0.7, 0.45, 0.3), 0.03), (110, (0.8, 0.75, 0.7), 0.1), (200, (1, 1, 1), 0.5)]
    )


def haze(volume: al.Volume, depth: float = 1.5) -> al.TransferFunction:
    """Return a function without an empty value: the whole volume is a haze of about this optical depth."""
    known = al.statistics(volume)
    low, high = float(known.minimum), float(known.maximum)
    extent = max(n * s for n, s in zip(volume.size, volume.spacing, strict=True))
    e = depth / extent
    middle = (low + high) / 2
    return al.TransferFunction([(low, (0.2, 0.3, 0.6), 0.3 * e), (middle, (0.9, 0.6, 0.3), e), (high, (1, 1, 1), 2 * e)])


# -- errors of images


def errors(image: Any, truth: Any) -> dict[str, float]:
    """Greatest and root mean square difference of linear, premultiplied colours and opacity, and PSNR for a peak of one."""
    difference = np.asarray(image, dtype=np.float64) - np.asarray(truth, dtype=np.float64)
    rmse = float(np.sqrt(np.mean(difference**2)))
    return {"max": float(np.abs(difference).max()), "rmse": rmse, "psnr_db": psnr(rmse)}


def psnr(rmse: float) -> float:
    """Peak signal to noise ratio in decibel for a peak of one; 200 where the images are equal."""
    return float(-20 * np.log10(max(rmse, 1e-10)))
