"""Tables of slabs: time to make them on the device, beside brute force on the same device and the paper's own figures.

airlight's table is made by incremental subrange integration (Lum, Wilson and Ma 2004, section 4): time grows with the number of
its entries. Brute force composites all intervals between the two values of each entry, one thread an entry: over the same
pieces, integrated by the same rule ("pieces"); as in the paper, over homogeneous intervals, with the exponential in the inner
loop ("intervals") or with opacities corrected for all diagonals beforehand ("hoisted", that time included). Allocation of
textures is left out. Bars are for two cores; by the processor's clock twice as much is allowed. Besides: weighted tables and
several lengths, the float64 yardstick on the host, an edit from function to table, and what Engel's fast form, without
attenuation inside a slab, is wrong by.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import wgpu
from common import Measured, arguments, machine, side_by_side, table, write_json

import airlight as al
from airlight.gpu import compute, slab_tables
from airlight.gpu.device import Device, choose
from airlight.shader.layout import fill
from airlight.shader.program import ProgramKey, SlabTableUniforms, Switches, build_program
from airlight.stage import SlabTable
from airlight.transfer.cells import function_texels, integral_to, value_axis
from airlight.transfer.tables import entries_needed, segment_rows, slab_light

BRUTE = Path(__file__).parent / "brute_tables.wgsl"
PAPER = {  # table 1, seconds on an Athlon FX-51 of 2.2 GHz: brute force, incremental
    32: (0.0025, 0.00078),
    64: (0.022, 0.0033),
    128: (0.18, 0.015),
    256: (1.57, 0.057),
    512: (12.4, 0.22),
    1024: (98.0, 0.88),
    2048: (797.0, 3.70),
}
PLAIN_MS = {256: 5, 1024: 60, 2048: 250}
LEAST_RATIO = {1024: 80, 2048: 150}
PIECES, INTERVALS, HOISTED, HOIST = range(4)
# Turns of inner loops in one dispatch, which should take well below a second on two cores.
TURNS = {PIECES: 1 << 24, INTERVALS: 1 << 26, HOISTED: 1 << 26, HOIST: 1 << 26}


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "tables", repeats=9, clock="what decides: cpu where others are busy")
    parser.add_argument("--pictures", type=Path, help="folder for plots of time and the fast form's error (needs matplotlib)")
    options = parser.parse_args(argv)
    sizes = (32, 64) if options.quick else (32, 64, 128, 256, 512, 1024, 2048, 4096)
    device = Device(*choose(), core=False)
    results = machine(device) | {"quick": options.quick, "clock": options.clock, "paper_seconds": PAPER}
    print(f"{device.info.name}, milliseconds by the {options.clock} clock\n")
    rows = [size_row(device, n, options) for n in sizes]
    print(table([shown(row, options.clock) for row in rows]))
    results["sizes"] = rows
    results["lengths"] = lengths(device, 64 if options.quick else 256, options)
    results["edit"] = edit(device, options)
    results["host_float64"] = on_host(32 if options.quick else 128)
    results["fast_form"] = fast_form(options.quick)
    for name in ("lengths", "edit", "host_float64"):
        print(f"\n{name}\n" + table([summary(row, options.clock) for row in results[name]]))
    print("\nfast form: greatest error of a colour\n" + table(results["fast_form"]))
    if options.pictures:
        draw(results, options.pictures)
    missed = [text for row in rows for text in bars(row, options.clock)]
    print("\n" + ("\n".join(missed) or "all bars are met"))
    write_json(options.out, results | {"missed": missed})
    device.close()
    return 0 if options.quick or not missed else 1


def measured(job: Callable[[], Any], repeats: int, warm: int = 1) -> Measured:
    """Repeated runs of a job."""
    return side_by_side({"alone": job}, repeats, warm)["alone"]


def middle(times: dict[str, Any], clock: str) -> float:
    """Median of times in milliseconds."""
    return float(times[f"{clock}_ms"]["median"])


def gentle(seed: float = 0.0) -> al.TransferFunction:
    """Return a function whose control points lie between entries; another one for each seed."""
    points = [(0, (0, 0, 0), 0.0), (300.5 + seed, (1, 0.6, 0.4), 0.3), (710.25, (0.2, 0.9, 0.4), 0.1), (1200, (1, 1, 1), 2.0)]
    return al.TransferFunction(points)


def filled(device: Device, n: int, lengths: int = 1, weighted: bool = False) -> Callable[[], None]:
    """Job that makes a table in a texture that is there already, and waits."""
    asked = SlabTable(gentle(), 1.0, n, lengths, weighted)
    texture = slab_tables.make_slab_table(device, asked)

    def job() -> None:
        slab_tables.fill_slab_table(device, asked, texture)
        device.wait()

    return job


def size_row(device: Device, n: int, options: Any) -> dict[str, Any]:
    """Times of one size."""
    row: dict[str, Any] = {"entries": n}
    for name, weighted in (("plain", False), ("weighted", True)):
        row[name] = measured(filled(device, n, weighted=weighted), options.repeats).summary()
    if n <= 2048:
        repeats = 1 if n >= 512 else 3
        brute = Brute(device, n)
        for name, forms in (("pieces", (PIECES,)), ("intervals", (INTERVALS,)), ("hoisted", (HOIST, HOISTED))):
            row[name] = measured(lambda forms=forms: brute.run(forms), repeats, warm=int(n < 512)).summary()
            row[name]["ratio"] = {c: middle(row[name], c) / middle(row["plain"], c) for c in ("wall", "cpu")}
        row["brute_error"] = brute.error()
    print(f"  {n} done", file=sys.stderr, flush=True)
    return row


class Brute:
    """The brute force at one size: a program, its buffers and texture."""

    def __init__(self, device: Device, n: int) -> None:
        self.device, self.n = device, n
        outputs = ("segments", "waiting", "slab_table_out")
        key = ProgramKey(BRUTE, (), (), outputs, ("slab_table",), Switches(), device.traits)
        self.program = build_program(key)
        self.pipeline = compute.pipeline_of(device, self.program)
        usage = wgpu.TextureUsage
        self.texture = device.gpu.create_texture(
            size=(n, n, 1), format="rgba32float", usage=usage.STORAGE_BINDING | usage.COPY_SRC
        )
        self.record = np.zeros((), dtype=self.program.uniforms.dtype)
        ends = np.linspace(*value_axis(gentle()), n)
        rgb, extinction = gentle()(ends[:-1] + np.diff(ends) / 2)
        intervals = np.zeros((n, 4), dtype=np.float32)
        intervals[:-1, :3], intervals[:-1, 3] = rgb, extinction
        waiting = compute.storage_buffer(device, "brute", 16 * n * (n + 1))
        device.queue.write_buffer(waiting, 0, intervals)
        bound = {
            "uniforms": compute.write_uniforms(device, "uniforms of brute force", self.record.tobytes()),
            "segments": compute.write_records(device, "brute segments", segment_rows(gentle(), n)),
            "waiting": waiting,
            "slab_table_out": self.texture.create_view(dimension="2d-array"),
        }
        self.groups = compute.bind_groups(device, self.pipeline, bound)

    def run(self, forms: tuple[int, ...]) -> None:
        """Fill the table, some rows at a time, and wait."""
        member = next(m for m in self.program.uniforms.members if m.name == "slab_table")
        x, y = self.device.traits.workgroup
        for form in forms:
            at_once = max(1, min(self.n, TURNS[form] // (self.n * self.n // 3)))
            for first in range(0, self.n, at_once):
                count = min(at_once, self.n - first)
                uniforms = SlabTableUniforms(self.n, 1, form, first, count, 1.0, False)
                fill(self.record[member.name], member.struct, uniforms)
                compute.write_uniforms(self.device, "uniforms of brute force", self.record.tobytes())
                compute.dispatch(self.device, self.pipeline, self.groups, (-(-self.n // x), -(-count // y), 1))
        self.device.wait()

    def error(self) -> dict[str, float]:
        """Greatest difference of colours and opacities of each form from the yardstick, at some entries."""
        rng = np.random.default_rng(self.n)
        front, back = rng.integers(0, self.n, (2, 200))
        front, back = front[front != back], back[front != back]
        ends = np.linspace(*value_axis(gentle()), self.n)
        exact, _ = slab_light(gentle(), ends[front], ends[back], 1.0)
        found = {}
        row = -(-16 * self.n // 256) * 256
        for name, forms in (("pieces", (PIECES,)), ("intervals", (INTERVALS,)), ("hoisted", (HOIST, HOISTED))):
            if self.n <= 256:
                self.run(forms)
                layout = {"bytes_per_row": row, "rows_per_image": self.n}
                data = self.device.queue.read_texture({"texture": self.texture}, layout, (self.n, self.n, 1))
                texels = np.frombuffer(data, np.float32).reshape(self.n, row // 16, 4)
                found[name] = float(np.abs(texels[back, front] - exact).max())
        return found


def lengths(device: Device, n: int, options: Any) -> list[dict[str, Any]]:
    """Times of tables of several lengths."""
    one = measured(filled(device, n), options.repeats).summary()
    rows = []
    for count in (1, 2, 4, 8):
        found = measured(filled(device, n, count), options.repeats).summary()
        times = middle(found, options.clock) / middle(one, options.clock) / count
        rows.append({"lengths": count, "entries": n} | found | {"of k times one": times})
    return rows


def edit(device: Device, options: Any) -> list[dict[str, Any]]:
    """Times from a function that nobody has seen to what a frame needs of it: cells, size, error, table and texture."""
    rows, seeds = [], iter(np.linspace(0.01, 50, 1000))
    for weighted in (False, True):

        def job(weighted: bool = weighted) -> None:
            function = gentle(float(next(seeds)))
            function_texels(function)
            entries_needed(function, 1.0)
            slab_tables.make_slab_table(device, SlabTable(function, 1.0, 256, 1, weighted))
            device.wait()

        rows.append({"edit": "weighted, 256" if weighted else "plain, 256"} | measured(job, options.repeats).summary())

    def prepare() -> None:
        function = gentle(float(next(seeds)))
        function_texels(function)
        entries_needed(function, 1.0)
        segment_rows(function, 256)

    return [*rows, {"edit": "of it the host's part"} | measured(prepare, options.repeats).summary()]


def on_host(n: int) -> list[dict[str, Any]]:
    """Times of the yardstick in NumPy, float64, for all pairs of a table."""
    ends = np.linspace(*value_axis(gentle()), n)
    front, back = (a.ravel() for a in np.meshgrid(ends, ends))
    return [{"NumPy float64, entries": n} | measured(lambda: slab_light(gentle(), front, back, 1.0), 3, warm=0).summary()]


def fast_form(quick: bool) -> list[dict[str, float]]:
    """Greatest error of a colour, over all pairs of entries, when light inside a slab is attenuated as in a homogeneous one."""
    n = 17 if quick else 65
    rows = []
    for depth in np.geomspace(0.01, 100, 5 if quick else 17):
        row = {"greatest depth of a slab": float(depth)}
        for name, function in kinds().items():
            deep = function.scaled(float(depth) / float(function.extinctions.max()))
            ends = np.linspace(*value_axis(deep), n)
            front, back = (a.ravel() for a in np.meshgrid(ends, ends))
            front, back = front[front != back], back[front != back]
            exact, _ = slab_light(deep, front, back, 1.0)
            share = (back - front) / (ends[-1] - ends[0])
            mean = (integral_to(deep, back) - integral_to(deep, front)) / share[:, None]
            tau = np.maximum(mean[:, 3:], 1e-12)
            row[name] = float(np.abs(mean[:, :3] * -np.expm1(-tau) / tau - exact[:, :3]).max())
        rows.append(row)
    return rows


def kinds() -> dict[str, al.TransferFunction]:
    """Functions of increasing wildness."""
    rng = np.random.default_rng(4)
    colours = enumerate(("red", "lime", "blue"))
    spikes = [(100 * k + d, colour, e) for k, colour in colours for d, e in ((40, 0), (50, 1), (60, 0))]
    return {
        "one colour": al.TransferFunction([(0, "white", 0), (1, "white", 1)]),
        "smooth": gentle(),
        "spikes": al.TransferFunction(spikes),
        "random": al.TransferFunction([(v, tuple(rng.random(3)), rng.random()) for v in range(24)]),
    }


def bars(row: dict[str, Any], clock: str) -> list[str]:
    """What a row misses. Time by the processor's clock is that of both cores."""
    n, cores = row["entries"], 2 if clock == "cpu" else 1
    taken, allowed = middle(row["plain"], clock), cores * PLAIN_MS.get(n, np.inf)
    missed = [f"{n} entries take {taken:.1f} ms, the bar is {allowed:g}"] if taken > allowed else []
    if n in LEAST_RATIO and (ratio := row["pieces"]["ratio"][clock]) < LEAST_RATIO[n]:
        missed.append(f"{n} entries: {ratio:.0f} times as fast as brute force, the bar is {LEAST_RATIO[n]}")
    return missed


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """One line of the table."""
    n = row["entries"]
    line = {"entries": n} | {name: middle(row[name], clock) for name in ("plain", "weighted")}
    for name in ("pieces", "intervals", "hoisted"):
        line[name] = middle(row[name], clock) if name in row else None
        line[f"{name} / plain"] = row[name]["ratio"][clock] if name in row else None
    paper = PAPER.get(n)
    return line | {"paper": 1e3 * paper[1] if paper else None, "paper's ratio": paper[0] / paper[1] if paper else None}


def summary(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """One line of a smaller table."""
    return {k: v for k, v in row.items() if not k.endswith("_ms")} | {f"ms ({clock})": middle(row, clock)}


def draw(results: dict[str, Any], folder: Path) -> None:
    """Plot time over entries beside the paper's, and the fast form's error over the depth of slabs."""
    try:
        from matplotlib import pyplot
    except ImportError:
        print("no pictures: matplotlib is not installed", file=sys.stderr)
        return
    folder.mkdir(parents=True, exist_ok=True)
    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    clock, sizes = results["clock"], results["sizes"]
    for name, label in (("plain", "plain"), ("weighted", "weighted"), ("pieces", "brute force")):
        known = [row for row in sizes if name in row]
        axes.loglog([row["entries"] for row in known], [middle(row[name], clock) for row in known], marker=".", label=label)
    for number, label in enumerate(("brute force", "incremental")):
        times = [1e3 * seconds[number] for seconds in PAPER.values()]
        axes.loglog(list(PAPER), times, color="grey", linestyle=("--", ":")[number], label=f"{label}, Lum et al. 2004")
    axes.set(xlabel="entries a side", ylabel=f"{clock} [ms]", title="Making a table")
    axes.legend()
    figure.savefig(folder / "cost.png", dpi=80)

    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    rows = results["fast_form"]
    depth, *names = rows[0]
    for name in names:
        axes.loglog([row[depth] for row in rows], [max(row[name], 1e-7) for row in rows], label=name)
    axes.axhline(1 / 512, color="grey", linestyle=":", label="1/512")
    axes.set(xlabel=depth, ylabel="greatest error of a colour", title="Without attenuation inside slabs")
    axes.legend()
    figure.savefig(folder / "fast-form.png", dpi=80)


if __name__ == "__main__":
    sys.exit(main())
