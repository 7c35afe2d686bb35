"""How drivers draw: by rays, slice by slice, or light by light; and frames as steps of their driver and those behind them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..gpu import compute
from ..handed import SLICES, Prepared
from ..scene import Layer, Scene
from ..shader.program import Program
from ..stage import Stage
from ..stages.driver_half_angle import HalfAngle
from ..stages.driver_slices import Planes, SliceDriver
from ..stages.lighting import Quantised
from .directions import light_directions
from .half_angle import draw_lights, first_planes, light_statistics, lights_program, longest_way
from .hits import HIT_BYTES, light_again
from .march import Band, MarchFrame, march_program, march_rays
from .passes import WANTED, FloatArrays, check_reads, finish, rows_for_passes
from .plan import Step
from .sweep import draw_groups, longest_slab, planes_of, slice_statistics, sweep_program

BYTES_PER_PIXEL = 16
MOST_ROWS = 32768  # of one band: a dispatch has at most 65535 groups of rows


@dataclass(frozen=True)
class Way:
    """What a frame asks its driver.

    ``draw`` draws bands of rows by a ``program``, of which ``statistics`` tell. ``longest`` is the length of the longest slab
    [world] of layers, for the driver and the step. ``planes`` are told to passes; None where there are no slices.
    """

    draw: Callable[[MarchFrame, list[Band]], None]
    program: Callable[[MarchFrame], Program]
    statistics: Callable[[MarchFrame], dict[str, Any]]
    longest: Callable[[Stage, Sequence[Layer], Scene, tuple[int, int], float], float]
    planes: Callable[[MarchFrame], Planes | None] | None = None


RAYS = Way(march_rays, march_program, lambda frame: {}, lambda driver, layers, scene, size_px, step_world: step_world)
SLICE_BY_SLICE = Way(draw_groups, sweep_program, slice_statistics, longest_slab, planes_of)
LIGHT_BY_LIGHT = Way(draw_lights, lights_program, light_statistics, longest_way, first_planes)


def way_of(driver: Stage) -> Way:
    """Return the way in which a driver draws."""
    if isinstance(driver, HalfAngle):
        return LIGHT_BY_LIGHT
    return SLICE_BY_SLICE if isinstance(driver, SliceDriver) else RAYS


def draw_frame(frame: MarchFrame) -> FloatArrays:
    """Draw a frame, or light the surfaces that were found; returns rgba (h, w, 4), depth (h, w), and samples (h, w).

    Samples are negative where the device ended the ray.
    """
    width, height = frame.size_px
    most = frame.device.limits["max-storage-buffer-binding-size"]
    with_hits = frame.keeps_hits or frame.found is not None
    widest = max(HIT_BYTES if with_hits else BYTES_PER_PIXEL, frame.covers.bytes_per_pixel, frame.outlines.bytes_per_pixel)
    rows = rows_for_passes(frame, min(height, max(1, most // (widest * width)), MOST_ROWS))
    bands = [Band(frame, n, first, min(rows, height - first)) for n, first in enumerate(range(0, height, rows))]
    driver = frame.scene_stages["driver"]
    way = way_of(driver)
    lit = {"lit_directions": Prepared()} if any(isinstance(x.stages["lighting"], Quantised) for x in frame.layers) else {}
    if frame.found is not None:
        drawing = Step("relight", lit, WANTED, lambda: light_again(frame, bands))
    else:
        drawing = Step(driver.name, lit, WANTED, lambda: way.draw(frame, bands))
    lighting = Step("directions", {}, {"lit_directions": Prepared()}, lambda: light_directions(frame))
    return finish(frame, bands, [lighting, drawing, *told_slices(frame, way)])


def told_slices(frame: MarchFrame, way: Way) -> list[Step]:
    """Return the step that tells passes of slices, where there are some.

    Raises
    ------
    StageError
        Where there are none, and a pass reads them.
    """
    planes = way.planes
    if planes is None:
        name = frame.scene_stages["driver"].name
        check_reads(frame.passes, "slices", f"the driver {name!r} draws none here", 'use driver="slices"')
        return []
    return [Step("slices told", {}, {"slices": SLICES}, lambda: frame.shared.update(slices=slices_of(frame, planes(frame))))]


def slices_of(frame: MarchFrame, planes: Planes | None) -> Any:
    """Buffer that tells the slices of a driver: planes, or shells round the eye without a normal."""
    rows = np.zeros((2, 4), dtype=np.float32)
    if planes is None:
        rows[1, :2] = frame.step_world, round(frame.t_offset_world / frame.step_world)
    else:
        rows[0, :3], rows[0, 3], rows[1, 0] = planes.normal, planes.first, planes.spacing_world
    return compute.write_records(frame.device, "slices", rows)
