"""The march driver: its passes, and the bands and tiles in which they run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import LimitError, StageError
from ..gpu import compute
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..gpu.tiles import Pace, Tile, run_tiles, tiles
from ..scene import Scene
from ..shader.link import parse, stage_source
from ..shader.program import (
    LUMINANCE_SUMS,
    FrameUniforms,
    LuminanceUniforms,
    Program,
    ProgramKey,
    Switches,
    build_program,
    stage_key,
)
from ..stage import Resource, Stage
from ..stages import tone as tones
from ..stages.transfer import Transfer
from ..volume import FloatArray
from .plan import Pass, check_plan
from .resources import DrawnLayer, bound_resources, pack_lights, pack_uniforms, uniform_values

BYTES_PER_PIXEL = 16
MOST_ROWS = 32768  # of one band: a dispatch has at most 65535 groups of rows


class Clock:
    """Milliseconds by name; what runs inside another block counts for itself alone, so that the parts add up."""

    def __init__(self) -> None:
        self.milliseconds: dict[str, float] = {}
        self._inner: list[float] = []

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time a block."""
        start = time.perf_counter()
        self._inner.append(0.0)
        try:
            yield
        finally:
            spent = 1e3 * (time.perf_counter() - start)
            self.milliseconds[name] = self.milliseconds.get(name, 0.0) + spent - self._inner.pop()
            if self._inner:
                self._inner[-1] += spent


@dataclass(frozen=True, eq=False)
class MarchFrame:
    """What the passes of one frame share."""

    device: Device
    scene: Scene
    scene_stages: Mapping[str, Stage]
    layers: tuple[DrawnLayer, ...]
    size_px: tuple[int, int]
    step_world: float
    t_offset_world: float
    anchor_world: FloatArray
    skip: str
    check: Callable[[], None]
    progress: Progress
    clock: Clock = field(default_factory=Clock)
    measured: dict[str, float] = field(default_factory=dict)

    @property
    def scene_resources(self) -> dict[str, Mapping[str, Resource]]:
        """Resources of the stages that belong to no layer."""
        return {slot: stage.resources(self.layers[0].context) for slot, stage in self.scene_stages.items()}

    def program(self, root: str | Path, outputs: tuple[str, ...], extra: tuple[str, ...] = (), **instead: Stage) -> Program:
        """Program of a root with the frame's stages, some replaced."""
        return build_program(program_key(self, root, outputs, extra, **instead))


def program_key(
    frame: MarchFrame, root: str | Path, outputs: tuple[str, ...], extra: tuple[str, ...] = (), **instead: Stage
) -> ProgramKey:
    """Key of the program for a frame."""
    resources = frame.scene_resources
    scene = tuple((slot, stage_key(instead.get(slot, stage), resources[slot])) for slot, stage in frame.scene_stages.items())
    layers = tuple(
        tuple((slot, stage_key(s, layer.resources[slot], s.variant(layer.context))) for slot, s in layer.stages.items())
        for layer in frame.layers
    )
    groups = max(layer.field.groups(layer.context) for layer in frame.layers)
    return ProgramKey(root, scene, layers, outputs, extra, switches_of(frame), frame.device.traits, groups)


def has_empty(layer: DrawnLayer) -> bool:
    """Whether the layer's function leaves some slabs empty."""
    transfer = layer.stages["transfer"]
    return isinstance(transfer, Transfer) and transfer.has_empty(layer.context)


def switches_of(frame: MarchFrame) -> Switches:
    """What the stages and the data say of each other, and a driver can make use of."""
    integrate = frame.scene_stages["integrate"]
    classifies = bool(getattr(integrate, "classifies", True))
    has_stretches = any(has_empty(layer) for layer in frame.layers)
    skips_empty = bool(getattr(integrate, "skips_empty", False)) and frame.skip != "none" and has_stretches
    return Switches(
        has_empty=any(layer.field.masked for layer in frame.layers),
        skips_empty=skips_empty,
        surfaces_only=bool(getattr(integrate, "surfaces_only", False)),
        classifies=classifies,
        curved=classifies and is_curved(frame),
    )


def is_curved(frame: MarchFrame) -> bool:
    """Whether values are put right for curvature: asked of the driver, and made use of by all layers.

    Raises
    ------
    StageError
        When the field of a layer jumps from voxel to voxel.
    """
    asked = bool(getattr(frame.scene_stages["driver"], "curved", False))
    for layer in frame.layers if asked else ():
        if layer.field.cells:
            raise StageError("driver.curved", f"is for smooth fields, and {layer.field.name} jumps", "use the field linear")
    return asked and all(getattr(layer.stages["transfer"], "integrates", False) for layer in frame.layers)


def march_program(frame: MarchFrame) -> Program:
    """Program of the march; a tone stage that looks at the whole image first gets a pass of its own."""
    for layer in frame.layers:
        stage = layer.stages["transfer"]
        if "next_crossing" in parse(stage_source(stage.wgsl, stage.name)).declared:
            raise StageError(f"look.transfer {stage.name!r}", "offers next_crossing, which no driver asks yet", "leave it out")
    root = frame.scene_stages["driver"].wgsl
    if frame.scene_stages["tone"].reads:
        return frame.program(root, ("radiance", "depth"), tone=tones.Linear())
    return frame.program(root, ("radiance", "depth"))


def draw_march(frame: MarchFrame) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any], float]:
    """Draw a frame; returns rgba (h, w, 4), depth (h, w), and the number of samples."""
    width, height = frame.size_px
    most = frame.device.limits["max-storage-buffer-binding-size"]
    rows = min(height, max(1, most // (BYTES_PER_PIXEL * width)), MOST_ROWS)
    bands = [_Band(frame, n, first, min(rows, height - first)) for n, first in enumerate(range(0, height, rows))]
    tone = frame.scene_stages["tone"]
    passes = [Pass("march", (), ("radiance", "depth"), lambda: _march(frame, bands))]
    if "luminance" in tone.reads:
        passes.append(Pass("luminance", ("radiance",), ("luminance",), lambda: _luminance(frame, bands)))
    if tone.reads:
        passes.append(Pass("tone", ("radiance", *tone.reads), ("radiance",), lambda: _tone(frame, bands)))
    check_plan(passes, ("radiance", "depth"))
    for step in passes:
        with frame.clock(step.name):
            step.run()
    rgba = np.empty((height, width, 4), dtype=np.float32)
    depth = np.empty((height, width, 2), dtype=np.float32)
    with frame.clock("read back"):
        for band in bands:
            band.read(rgba, depth)
    drop_buffers(frame.device, len(bands))
    if (depth[..., 1] < 0).any():
        raise LimitError(
            f"device {frame.device.info.name!r}",
            f"ended rays before they were through, after {int(-depth[..., 1].min())} samples: its driver bounds loops",
            "draw with a larger step, central instead of Sobel gradients, or fewer lights",
        )
    return rgba, np.where(depth[..., 0] < 3e38, depth[..., 0], np.float32(np.inf)), float(depth[..., 1].sum(dtype=np.float64))


def drop_buffers(device: Device, bands: int) -> None:
    """Free what an image of more bands has left behind."""
    for key in [k for k in device.kept if k[0] == "band" and k[2] >= bands]:
        del device.kept[key]


class _Band:
    """Rows of an image whose pixels fit into one binding."""

    def __init__(self, frame: MarchFrame, number: int, first_row: int, rows: int) -> None:
        width = frame.size_px[0]
        self.first_row, self.rows, self.pixels = first_row, rows, rows * width
        self.radiance = compute.storage_buffer(frame.device, ("band", "radiance", number), self.pixels * 16)
        self.depth = compute.storage_buffer(frame.device, ("band", "depth", number), self.pixels * 8)
        self.frame = frame

    def uniforms(self) -> FrameUniforms:
        return FrameUniforms(
            size_px=self.frame.size_px,
            band_first_row=self.first_row,
            band_rows=self.rows,
            step_world=self.frame.step_world,
            t_offset_world=self.frame.t_offset_world,
            light_count=len(self.frame.scene.lights),
        )

    def read(self, rgba: np.ndarray[Any, Any], depth: np.ndarray[Any, Any]) -> None:
        part = slice(self.first_row, self.first_row + self.rows)
        width = self.frame.size_px[0]
        for source, target, channels in ((self.radiance, rgba, 4), (self.depth, depth, 2)):
            data = self.frame.device.queue.read_buffer(source, 0, self.pixels * channels * 4)
            target[part] = np.frombuffer(data, dtype=np.float32).reshape(self.rows, width, channels)


def _bind(frame: MarchFrame, program: Program, buffers: Mapping[str, Any], name: str, data: bytes) -> list[Any]:
    device = frame.device
    resources = {
        **bound_resources(device, program, frame.layers, frame.scene_resources, frame.anchor_world, frame.progress),
        **buffers,
        "uniforms": compute.write_uniforms(device, f"uniforms of {name}", data),
        "lights": compute.write_storage(device, "lights", pack_lights(frame.scene.lights)),
    }
    return compute.bind_groups(device, compute.pipeline_of(device, program), resources)


def _march(frame: MarchFrame, bands: list[_Band]) -> None:
    device = frame.device
    with frame.clock("link and compile"):
        program = march_program(frame)
        pipeline = compute.pipeline_of(device, program)
    with frame.clock("upload"):
        values = uniform_values(device, frame.scene_stages, frame.layers, frame.anchor_world, frame.progress)
        if frame.scene_stages["tone"].reads:
            values["tone"] = tones.Linear()
        bound_resources(device, program, frame.layers, frame.scene_resources, frame.anchor_world, frame.progress)
    x, y = device.traits.workgroup
    sizes = tuple(layer.context.volume.size for layer in frame.layers)
    pace: Pace = device.kept.setdefault(("pace", program.key, frame.step_world, sizes), Pace())
    total = frame.size_px[0] * frame.size_px[1]
    before = 0
    for band in bands:
        groups = _bind(
            frame,
            program,
            {"radiance": band.radiance, "depth": band.depth},
            "march",
            pack_uniforms(program, band.uniforms(), values),
        )
        target = device.kept["uniforms of march"]

        def submit(tile: Tile, band: _Band = band, groups: list[Any] = groups, target: Any = target) -> None:
            part = replace(band.uniforms(), tile_origin_px=(tile.x, tile.y), tile_size_px=(tile.width, tile.height))
            device.queue.write_buffer(target, 0, pack_uniforms(program, part, values))
            compute.dispatch(device, pipeline, groups, (-(-tile.width // x), -(-tile.height // y), 1))

        def done(pixels: int, before: int = before) -> None:
            frame.progress("render", before + pixels, total)

        run_tiles(device, tiles(frame.size_px[0], band.first_row, band.rows, pace), submit, pace, frame.check, done)
        before += band.pixels


def _luminance(frame: MarchFrame, bands: list[_Band]) -> None:
    """Measure the log-average luminance; the sums of all bands are joined on the host in float64."""
    device = frame.device
    program = build_program(ProgramKey("passes/luminance.wgsl", (), (), ("radiance", "sums"), (), Switches(), device.traits))
    total = np.zeros(2)
    for band in bands:
        sums = compute.storage_buffer(device, "luminance sums", LUMINANCE_SUMS * 8)
        data = pack_uniforms(program, band.uniforms(), {})
        groups = _bind(frame, program, {"radiance": band.radiance, "sums": sums}, "luminance", data)
        compute.dispatch(device, compute.pipeline_of(device, program), groups, (LUMINANCE_SUMS // 64, 1, 1))
        read = np.frombuffer(device.queue.read_buffer(sums, 0, LUMINANCE_SUMS * 8), dtype=np.float32)
        total += read.reshape(-1, 2).sum(axis=0, dtype=np.float64)
    frame.measured["luminance"] = math.exp(total[0] / total[1]) if total[1] > 0 else 0.0


def _tone(frame: MarchFrame, bands: list[_Band]) -> None:
    device = frame.device
    program = frame.program("passes/tone.wgsl", ("radiance",), ("luminance",))
    values = uniform_values(device, frame.scene_stages, frame.layers, frame.anchor_world, frame.progress)
    values["luminance"] = LuminanceUniforms(frame.measured["luminance"])
    x, y = device.traits.workgroup
    for band in bands:
        data = pack_uniforms(program, band.uniforms(), values)
        groups = _bind(frame, program, {"radiance": band.radiance}, "tone", data)
        counts = (-(-frame.size_px[0] // x), -(-band.rows // y), 1)
        compute.dispatch(device, compute.pipeline_of(device, program), groups, counts)
