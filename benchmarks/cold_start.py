"""Cold start: one command from process start to file, beside a VTK script that does the same.

``airlight render ct_head.nrrd -o head.png --size 512x512`` as a whole process with a warm file cache, pre-integrated, shaded,
automatic function included: at most 1.5 s on two cores without a GPU (median of 5), and at most three times the volume's bytes
plus 400 MB of memory. A breakdown follows from ``--stats`` and ``python -X importtime``.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, machine, spread, table, write_json
from volumes import real_path, stand_in

import airlight as al

MOST_SECONDS = 1.5
FIXED_BYTES = 400e6
COMMAND = "import sys; from airlight.app.cli import main; sys.exit(main())"
LAUNCHER = """
import os, sys, time
start = time.perf_counter()
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)
_, status, used = os.wait4(child, 0)
print("", time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss)
sys.exit(os.waitstatus_to_exitcode(status))
"""
HERE = Path(__file__).parent
SUMMED = ("numpy", "wgpu", "airlight", "cyclopts", "rich", "PIL", "nrrd", "nibabel", "pydicom", "tifffile", "cffi")


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a limit is missed."""
    parser = arguments(__doc__, "cold_start", repeats=5)
    parser.add_argument("--size", default="512x512", help="size of the picture (default: 512x512)")
    parser.add_argument("--volume", type=Path, default=None, help="a volume's file (default: the CT head)")
    options = parser.parse_args(argv)
    if options.quick:
        options.repeats, options.size = 1, "64x64"
    with tempfile.TemporaryDirectory() as folder:
        volume = options.volume or input_file(Path(folder), options.quick)
        results = measure(volume, Path(folder), options)
    report(results)
    passed = results["seconds"]["median"] <= MOST_SECONDS and results["peak_bytes"] <= results["most_bytes"]
    results["passes"] = passed
    print(f"\n{'PASS' if passed else 'FAIL'}")
    write_json(options.out, machine() | {"quick": options.quick} | results)
    return 0 if passed or options.quick else 1


def input_file(folder: Path, quick: bool) -> Path:
    """Return the CT head's file, or that of a computed volume in its place."""
    path = None if quick else real_path("ct_head")
    if path is not None:
        return path
    if not quick:
        print("ct_head.nrrd is not there (AIRLIGHT_DATA names the folder); a computed volume stands in", file=sys.stderr)
    al.save(stand_in(32 if quick else 192), folder / "computed.nrrd")
    return folder / "computed.nrrd"


def measure(volume: Path, folder: Path, options: Any) -> dict[str, Any]:
    """Run both programs in turns; the first turn warms the caches of files and shaders."""
    picture, stats = folder / "head.png", folder / "stats.json"
    ours = [sys.executable, "-c", COMMAND, "render", str(volume), "-o", str(picture), "--size", options.size]
    theirs = [sys.executable, str(HERE / "vtk_script.py"), str(volume), str(folder / "vtk.png"), options.size]
    has_vtk = subprocess.run([sys.executable, "-c", "import vtkmodules"], capture_output=True).returncode == 0
    programs = {"airlight": ours} | ({"VTK": theirs} if has_vtk and volume.suffix in (".nrrd", ".nhdr") else {})
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in programs}
    for turn in range(1 + options.repeats):
        for name, command in programs.items():
            found = process(command)
            if turn:
                runs[name].append(found)
    process([*ours, "--stats", str(stats)])
    frame = json.loads(stats.read_text(encoding="utf-8"))
    voxel_bytes = int(al.open(volume).array.nbytes)
    return {
        "size": options.size,
        "volume": volume.name,
        "volume_bytes": voxel_bytes,
        "most_seconds": MOST_SECONDS,
        "most_bytes": 3 * voxel_bytes + FIXED_BYTES,
        "seconds": spread([r["seconds"] for r in runs["airlight"]]),
        "peak_bytes": float(np.median([r["peak_bytes"] for r in runs["airlight"]])),
        "programs": {name: {key: spread([r[key] for r in found]) for key in found[0]} for name, found in runs.items()},
        "adapter": frame["adapter"],
        "frame_milliseconds": frame["milliseconds"],
        "imports_milliseconds": imports(ours),
    }


def process(command: list[str]) -> dict[str, float]:
    """Run a program: seconds from start to end, seconds of its cores, and its peak memory.

    A small process starts it: what a child's peak tells begins with the memory of the process that it was split off from.
    """
    done = subprocess.run([sys.executable, "-I", "-S", "-c", LAUNCHER, *command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"a program failed: {' '.join(Path(word).name for word in command[:4])}\n{done.stderr}")
    seconds, cpu_seconds, peak = (float(word) for word in done.stdout.split()[-3:])
    return {"seconds": seconds, "cpu_seconds": cpu_seconds, "peak_bytes": peak * (1 if sys.platform == "darwin" else 1024)}


def imports(command: list[str]) -> dict[str, float]:
    """Milliseconds that imports take, by package: each module counts for the package that it is in."""
    timed = [command[0], "-X", "importtime", *command[1:]]
    lines = subprocess.run(timed, capture_output=True, text=True, check=True).stderr.splitlines()
    found: dict[str, float] = {}
    for text in lines:
        parts = text.removeprefix("import time:").split("|")
        if not text.startswith("import time:") or len(parts) != 3 or not parts[0].strip().isdigit():
            continue
        package = parts[2].strip().partition(".")[0]
        key = package if package in SUMMED else "other"
        found[key] = found.get(key, 0.0) + int(parts[0]) / 1e3
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def report(results: dict[str, Any]) -> None:
    """Print tables."""
    rows = [
        {
            "program": name,
            "seconds": found["seconds"]["median"],
            "least": found["seconds"]["min"],
            "most": found["seconds"]["max"],
            "cpu seconds": found["cpu_seconds"]["median"],
            "peak MB": found["peak_bytes"]["median"] / 1e6,
        }
        for name, found in results["programs"].items()
    ]
    print(f"{results['volume']}, {results['size']}, {results['adapter']['name']}\n\n" + table(rows))
    print(f"\nlimits: {results['most_seconds']} s, {results['most_bytes'] / 1e6:.0f} MB\n")
    print(table([{"of the frame": name, "ms": ms} for name, ms in results["frame_milliseconds"].items()]))
    print("\n" + table([{"imports of": name, "ms": ms} for name, ms in results["imports_milliseconds"].items()]))


if __name__ == "__main__":
    sys.exit(main())
