"""The passes that map tones: what they measure of the whole image, and the tone stage over it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..gpu import compute, gradients
from ..gpu.tiles import Tile
from ..shader.program import (
    LUMINANCE_SUMS,
    SURROUND_STEPS,
    LuminanceUniforms,
    Program,
    ProgramKey,
    SurroundUniforms,
    Switches,
    build_program,
    stage_key,
)
from ..stages.tone import EDGE_STOPS, RADIUS
from .resources import bound_resources, pack_uniforms

if TYPE_CHECKING:
    from .march import MarchFrame

# Deviations of what averages round a pixel. In space [cells]: a cell's width, a binomial of three, and linear interpolation.
# In luminance [steps]: a cubic B-spline, and linear interpolation.
CELLS = math.sqrt(1 / 12 + 1 / 2 + 1 / 6)
STEPS = math.sqrt(1 / 3 + 1 / 6)
LUMINANCE_GROUP = 32  # threads of a workgroup of that pass
MOST_TURNS = 49152  # of a thread: software devices end loops after 65536


def measure_luminance(frame: MarchFrame, bands: Sequence[Any]) -> None:
    """Measure the log-average luminance of bands of rows; their sums are joined on the host in float64."""
    program = _program(frame, "luminance", ("radiance", "sums"))
    total = np.zeros(2)
    for band in bands:
        sums = compute.storage_buffer(frame.device, "luminance sums", LUMINANCE_SUMS * 8)
        _run(
            frame,
            program,
            {"radiance": band.radiance, "sums": sums},
            band.uniforms(),
            {},
            (LUMINANCE_SUMS // LUMINANCE_GROUP, 1, 1),
        )
        read = np.frombuffer(frame.device.queue.read_buffer(sums, 0, LUMINANCE_SUMS * 8), dtype=np.float32)
        total += read.reshape(-1, 2).sum(axis=0, dtype=np.float64)
    frame.measured["luminance"] = math.exp(total[0] / total[1]) if total[1] > 0 else 0.0


def measure_surround(frame: MarchFrame, bands: Sequence[Any]) -> None:
    """Average luminance round pixels: sums over cells of all bands, and the texture that is made of them."""
    device, told = frame.device, surround_of(frame)
    columns, rows = told.cells
    sums = compute.storage_buffer(device, "surround sums", columns * rows * SURROUND_STEPS * 8)
    compute.clear(device, sums)
    program = _program(frame, "surround_sums", ("radiance", "surround_sums"), ("surround",))
    for band in bands:
        most = band.rows if told.cell_px**2 <= MOST_TURNS else max(1, MOST_TURNS // told.cell_px)
        for first in range(band.first_row, band.first_row + band.rows, most):
            height = min(most, band.first_row + band.rows - first)
            part = band.uniforms(Tile(0, first, frame.size_px[0], height))
            counts = compute.workgroups(device, columns, height // told.cell_px + 2)
            _run(frame, program, {"radiance": band.radiance, "surround_sums": sums}, part, {"surround": told}, counts)
    program = _program(frame, "surround", ("surround_sums", "surround_out"), ("surround",))
    size = (columns, rows, SURROUND_STEPS)
    texture = device.kept.get(("surround", size), lambda: gradients.written_texture(device, size, "rg32float"))
    bound = {"surround_sums": sums, "surround_out": texture.create_view()}
    _run(frame, program, bound, bands[0].uniforms(), {"surround": told}, compute.workgroups(device, *size))
    frame.shared["surround"] = texture


def surround_of(frame: MarchFrame) -> SurroundUniforms:
    """Return cells and steps in which the frame's tone stage has luminance averaged, round that of the whole image."""
    stage = frame.scene_stages["tone"]
    cell_px = max(1, round(getattr(stage, "radius", RADIUS) * max(frame.size_px) / CELLS))
    width, height = frame.size_px
    cells = -(-width // cell_px), -(-height // cell_px)
    middle = math.log2(max(frame.measured["luminance"], 1e-30))
    return SurroundUniforms(cells, cell_px, middle, getattr(stage, "edge", EDGE_STOPS) / STEPS)


def map_tones(frame: MarchFrame, bands: Sequence[Any]) -> None:
    """Run the tone stage over bands of rows."""
    device, stages = frame.device, {"tone": frame.scene_stages["tone"]}
    resources = {"tone": stages["tone"].resources(frame.layers[0].context)}
    keys = (("tone", stage_key(stages["tone"], resources["tone"])),)
    has_surround = "surround" in stages["tone"].reads
    outputs, extra = (("radiance", "surround"), ("luminance", "surround")) if has_surround else (("radiance",), ("luminance",))
    program = build_program(ProgramKey("passes/tone.wgsl", keys, (), outputs, extra, Switches(), device.traits))
    luminance = LuminanceUniforms(frame.measured.get("luminance", 0.0))
    values: dict[str, Any] = {"tone": stages["tone"].uniforms(frame.layers[0].context), "luminance": luminance}
    bound = bound_resources(device, program, frame.layers, resources, frame.anchor_world, frame.progress)
    if has_surround:
        values["surround"] = surround_of(frame)
        bound |= {"surround": frame.shared["surround"].create_view(), "surround_sampler": compute.linear_sampler(device)}
    for band in bands:
        counts = compute.workgroups(device, frame.size_px[0], band.rows)
        _run(frame, program, {**bound, "radiance": band.radiance}, band.uniforms(), values, counts)


def _program(frame: MarchFrame, root: str, outputs: tuple[str, ...], extra: tuple[str, ...] = ()) -> Program:
    return build_program(ProgramKey(f"passes/{root}.wgsl", (), (), outputs, extra, Switches(), frame.device.traits))


def _run(
    frame: MarchFrame,
    program: Program,
    bound: Mapping[str, Any],
    part: Any,
    values: Mapping[str, Any],
    counts: tuple[int, int, int],
) -> None:
    device, pipeline = frame.device, compute.pipeline_of(frame.device, program)
    data = pack_uniforms(program, part, values)
    uniforms = compute.write_uniforms(device, f"uniforms of {program.key.root}", data)
    compute.dispatch(device, pipeline, compute.bind_groups(device, pipeline, {**bound, "uniforms": uniforms}), counts)
