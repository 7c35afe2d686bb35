"""``airlight info``: what a file holds."""

import json
import math
import shutil
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..volume import Volume, statistics
from .build import open_input
from .inputs import INPUT
from .options import ReadOptions
from .progress import ProgressBar

BLOCKS = " ▁▂▃▄▅▆▇█"
HISTOGRAM_ROWS = 6
MOST_CHANNELS = 16


def info(
    input: Annotated[str, Parameter(help=INPUT)],
    /,
    *,
    read: ReadOptions | None = None,
    as_json: Annotated[
        bool, Parameter(name="--json", negative="", help="The same as JSON, without the histogram's picture.")
    ] = False,
) -> None:
    """Tell what a file holds: dimensions, spacing, orientation, units, range, channels, times, empty samples, histogram.

    For instance:

        airlight info head.nii.gz
        airlight info simulation.h5 --dataset /fields/density
    """
    with ProgressBar() as progress:
        volume = open_input(input, read or ReadOptions(), progress)
        facts = describe(volume)
    if as_json:
        print(json.dumps(facts, indent=2))
        return
    print(input)
    for name, value in facts.items():
        if name != "channels":
            print(f"  {name:<12} {_words(value)}")
    for number, channel in enumerate(facts["channels"]):
        _print_channel(volume, number, channel)
    if volume.channel_count > MOST_CHANNELS:
        print(f"  and {volume.channel_count - MOST_CHANNELS} channels more")


def describe(volume: Volume) -> dict[str, Any]:
    """Facts of a volume as plain data."""
    facts: dict[str, Any] = {
        "dimensions": list(volume.size),
        "type": str(volume.dtype),
        "spacing": list(volume.spacing),
        "extent": [n * s for n, s in zip(volume.size, volume.spacing, strict=True)],
        "origin": list(volume.origin),
        "units": volume.units or "unknown",
        "orientation": orientation(volume),
        "values": volume.value_unit or "unknown unit",
        "modality": volume.modality or "unknown",
        "times": {"count": volume.time_count, "unit": volume.time_unit, "at": list(volume.times)},
        "no data": volume.no_data,
        "memory": int(volume.array.nbytes),
    }
    return facts | {"channels": [_channel(volume, n) for n in range(min(volume.channel_count, MOST_CHANNELS))]}


def _channel(volume: Volume, number: int) -> dict[str, Any]:
    known = statistics(volume, number)
    return {
        "name": volume.channel_names[number] if volume.channel_names else str(number),
        "minimum": known.minimum,
        "maximum": known.maximum,
        "percentiles": {f"{p:g}": float(np.clip(known.percentile(p), known.minimum, known.maximum)) for p in (0.5, 50, 99.5)},
        "empty": known.empty,
    }


def orientation(volume: Volume) -> str:
    """Where the axes x, y, z of the grid point: letters of the patient's directions, or of the world's axes."""
    axes = volume.world_from_index[:3, :3] / np.linalg.norm(volume.world_from_index[:3, :3], axis=0)
    words = ("RL", "AP", "IS") if volume.anatomical else (("-x", "+x"), ("-y", "+y"), ("-z", "+z"))
    nearest = np.abs(axes).argmax(axis=0)
    letters = [words[row][int(axes[row, column] > 0)] for column, row in enumerate(nearest)]
    cosines = np.clip(np.abs(axes).max(axis=0), 0, 1)
    tilt = math.degrees(math.acos(float(cosines.min())))
    sheared = np.abs(axes.T @ axes - np.eye(3)).max() > 1e-4
    handed = np.linalg.det(axes) > 0
    text = ("" if volume.anatomical else " ").join(letters)
    text += " (x, y, z point to the patient's sides of these letters)" if volume.anatomical else " (not anatomical)"
    text += f", up to {tilt:.1f} degrees oblique" if tilt > 0.05 else ""
    return text + (", sheared" if sheared else "") + ("" if handed else ", left-handed")


def histogram_lines(counts: Sequence[int], width: int, rows: int = HISTOGRAM_ROWS, blocks: str = BLOCKS) -> list[str]:
    """Draw counts on a logarithmic scale, in ``rows`` lines of block characters from the top."""
    columns = np.array([part.sum() for part in np.array_split(np.asarray(counts), min(width, len(counts)))], dtype=np.float64)
    levels = len(blocks) - 1
    top = math.log1p(columns.max(initial=1))
    # Whatever is not zero shows: one eighth of a block at least.
    heights = np.where(columns > 0, np.maximum(np.rint(np.log1p(columns) / top * rows * levels), 1), 0).astype(int)
    return ["".join(blocks[min(max(h - row * levels, 0), levels)] for h in heights.tolist()) for row in reversed(range(rows))]


def _print_channel(volume: Volume, number: int, facts: dict[str, Any]) -> None:
    known = statistics(volume, number)
    unit = f" {volume.value_unit}" if volume.value_unit else ""
    percentiles = facts["percentiles"]
    if volume.channel_count > 1:
        print(f"\n  channel {number}: {facts['name']}")
    print(f"  {'range':<12} {known.minimum:.6g} to {known.maximum:.6g}{unit}")
    print(f"  {'robust range':<12} {percentiles['0.5']:.6g} to {percentiles['99.5']:.6g}, median {percentiles['50']:.6g}")
    total = int(np.prod(volume.size))
    print(f"  {'empty':<12} {known.empty:,} of {total:,} samples" + (" (first time step)" if volume.time_count > 1 else ""))
    width = max(20, min(shutil.get_terminal_size().columns, 100) - 4)
    for line in histogram_lines(known.histogram.tolist(), width, blocks=_drawable()):
        print(f"  {line}".rstrip())
    first, last = f"{known.edges[0]:.6g}", f"{known.edges[-1]:.6g}"
    print(f"  {first}{last.rjust(min(width, len(known.histogram)) - len(first))}  (count on a log scale)")


def _drawable() -> str:
    try:
        BLOCKS.encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return " #"
    return BLOCKS


def _words(value: Any) -> str:
    if isinstance(value, dict):
        at = value["at"]
        listed = ", ".join(f"{t:.6g}" for t in at[:4]) + (" ..." if len(at) > 4 else "")
        return f"{value['count']}" + (f" at {listed} {value['unit']}".rstrip() if at else "")
    if isinstance(value, list):
        return (
            " x ".join(str(v) for v in value)
            if all(isinstance(v, int) for v in value)
            else ", ".join(f"{v:.6g}" for v in value)
        )
    if isinstance(value, int):
        return f"{value / 2**20:,.1f} MiB"
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
