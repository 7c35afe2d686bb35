"""What the benchmarks share: options, repeated side-by-side runs, frames, errors of images, JSON and tables."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import airlight as al
from airlight.benchmark.measure import Measured as Measured
from airlight.benchmark.measure import errors as errors
from airlight.benchmark.measure import psnr as psnr
from airlight.benchmark.measure import ratio as ratio
from airlight.benchmark.measure import side_by_side as side_by_side
from airlight.benchmark.measure import spread as spread
from airlight.benchmark.report import machine as machine
from airlight.benchmark.report import table as table
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


def parsed(parser: argparse.ArgumentParser, argv: list[str] | None, **quick: float) -> Any:
    """Options of the command line; with ``--quick`` these take the place of what it says."""
    options = parser.parse_args(argv)
    if options.quick:
        vars(options).update(quick)
    return options


def described(device: Any, options: Any) -> dict[str, Any]:
    """Print and return what drew: machine, size, step and clock."""
    about = machine(device) | {name: getattr(options, name) for name in ("quick", "size", "step", "clock")}
    print(f"{about['adapter']['name']}, {about['cores']} cores, {options.size}x{options.size}, step {options.step}\n")
    return about


def write_json(path: Path, results: Mapping[str, Any]) -> None:
    """Write results; numbers of NumPy become Python's."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=2, default=_plain) + "\n", encoding="utf-8")
    print(f"\nwritten: {path.name}")


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


# -- time


def by_both_clocks(one: Measured, other: Measured) -> dict[str, dict[str, float]]:
    """Quotients ``one / other`` of the same turns, by the wall's clock and by the processor's."""
    return {"wall": ratio(one.wall, other.wall), "cpu": ratio(one.cpu, other.cpu)}


# -- frames


def from_corner(volume: al.Volume, function: al.TransferFunction, look: Mapping[str, Any]) -> al.Scene:
    """Scene of a volume seen from its corner."""
    camera = al.fit_camera("iso", volume.corners_world(), 1.0)
    return al.Scene(volume, transfer=function, look=al.Look(**look), camera=camera, background=None)


def frame_of(device: Device, drawn: al.Scene, options: Any, skip: str = "auto", **driver: Any) -> MarchFrame:
    """Frame of a scene, ready to be drawn again and again by ``draw_frame``."""
    request = Request((options.size, options.size), al.driver.March(**driver), options.step, skip)
    return prepare(device, drawn, request, lambda: None, lambda *_: None)
