"""``airlight bench``: time and error of a small, fixed set of scenes on this machine."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from ..benchmark.peers import vtk_is_there, vtk_rows
from ..benchmark.plots import load_matplotlib, write_plots
from ..benchmark.report import machine, table
from ..benchmark.suite import Plan, measured
from ..errors import FileError, MissingExtraError, ValueRangeError
from ..files import write_text
from .parse import parse_size
from .progress import ProgressBar
from .render import check_output, plain

PLOTS = (".png", ".svg")
ENDINGS = (".json", ".md", *PLOTS)
QUICK = Plan((128, 128), (48, 48), voxels=48, repeats=1, seconds=1.0)
MOST_VOXELS = 1024


def bench(
    *,
    size: Annotated[str | None, Parameter(metavar="WxH", help="Width and height in pixels; 512x512 unless told.")] = None,
    voxels: Annotated[int | None, Parameter(help="Voxels along each axis of the computed volumes; 128 unless told.")] = None,
    quick: Annotated[bool, Parameter(negative="", help="Small pictures of small volumes: does it work?")] = False,
    seconds: Annotated[
        float | None,
        Parameter(help="About how long pictures are timed, 30 unless told; comparing and VTK take as much again."),
    ] = None,
    vtk: Annotated[
        Literal["auto", "yes", "no"],
        Parameter(help="Also time VTK's mappers on the scenes that it has; auto: where VTK is installed."),
    ] = "auto",
    output: Annotated[
        tuple[str, ...],
        Parameter(
            name=["--output", "-o", "--json"],
            metavar="FILE",
            negative="",
            consume_multiple=False,
            allow_leading_hyphen=True,
            help="Also write the results: numbers (.json), tables (.md), plots of time against error (.png, .svg); repeatable.",
        ),
    ] = (),
    device: Annotated[str | None, Parameter(metavar="NAME", help="Adapter, by a part of its name or kind.")] = None,
) -> None:
    """Measure how long a fixed set of scenes takes on this machine, and how far each picture is from the converged one.

    The scenes are computed; nothing is fetched. For instance:

        airlight bench
        airlight bench --quick
        airlight bench --size 1024x1024 --voxels 256 -o bench.json -o bench.md -o bench.png
    """
    for target in output:
        if target == "-":
            raise FileError("-o -", "is where the tables go anyway", "name a file")
        check_output(target, ENDINGS)
        if is_plot(target):
            load_matplotlib()
    if vtk == "yes" and not vtk_is_there():
        raise MissingExtraError("--vtk yes", "needs VTK", "pip install vtk")
    plan = make_plan(size, voxels, quick, seconds)
    with ProgressBar() as progress:
        results = run(plan, device, vtk != "no" and vtk_is_there(), progress)
    text = report(results)
    print(text)
    for target in output:
        if is_plot(target):
            write_plots(results, Path(target))
            continue
        as_json = target.lower().endswith(".json")
        write_text(Path(target), (json.dumps(results, indent=2, default=plain) if as_json else text) + "\n")


def is_plot(target: str) -> bool:
    """Whether a file is a picture by its name."""
    return target.lower().endswith(PLOTS)


def make_plan(size: str | None, voxels: int | None, quick: bool, seconds: float | None) -> Plan:
    """How much is measured, of what was typed."""
    base = QUICK if quick else Plan()
    size_px = base.size_px if size is None else parse_size(size)
    voxels = base.voxels if voxels is None else voxels
    if not 8 <= voxels <= MOST_VOXELS:
        raise ValueRangeError("--voxels", f"is {voxels}, must lie in [8, {MOST_VOXELS}]")
    seconds = base.seconds if seconds is None else seconds
    if not 0 <= seconds <= 3600:
        raise ValueRangeError("--seconds", f"is {seconds:g}, must lie in [0, 3600]")
    width, height = (min(n, most) for n, most in zip(size_px, base.error_size_px, strict=True))
    return Plan(size_px, (width, height), voxels, base.repeats, seconds)


def run(plan: Plan, device: str | None, with_vtk: bool, progress: Any) -> dict[str, Any]:
    """Measure all scenes, in airlight and, if asked, in VTK."""
    from ..rendering.renderer import Renderer

    with Renderer(device=device) as renderer:
        adapter, rows = measured(renderer, plan, progress)
    if with_vtk:
        progress("VTK", 0, 0)
        rows += vtk_rows(plan)
    return machine() | {"adapter": adapter, "plan": vars(plan), "rows": rows}


def report(results: dict[str, Any]) -> str:
    """Markdown of what was measured."""
    plan, adapter = results["plan"], results["adapter"]
    width, height = plan["size_px"]
    small_width, small_height = plan["error_size_px"]
    drawn = [row for row in results["rows"] if "failed" not in row]
    lines = [
        f"{adapter.get('name', 'no adapter')} ({adapter.get('kind', '')}), {results['cores']} cores, {width}x{height} pixels, "
        f"{plan['voxels']}^3 voxels.",
        f"Medians; errors at {small_width}x{small_height} against the renderer's own picture at 1/8 voxel, in levels of 255.",
        "",
        table([_shown(row) for row in drawn]) if drawn else "Nothing could be drawn.",
    ]
    lines += [f"{row['renderer']}, {row['scene']}: {row['failed']}" for row in results["rows"] if "failed" in row]
    return "\n".join(lines)


def _shown(row: dict[str, Any]) -> dict[str, Any]:
    times = dict(row["milliseconds"])
    total = times.pop("total")
    passes = ", ".join(f"{name} {ms['median']:.1f}" for name, ms in times.items())
    samples = row.get("samples")
    return {
        "scene": row["scene"],
        "renderer": row["renderer"],
        "step": row["step"],
        "ms": total["median"],
        "least": total["min"],
        "samples/pixel": row.get("samples_a_pixel"),
        "Msamples/s": None if samples is None else samples / total["median"] / 1e3,
        "rmse": 255 * row["error"]["rmse"],
        "max": 255 * row["error"]["max"],
        "psnr dB": row["error"]["psnr_db"],
        "passes": passes,
    }
