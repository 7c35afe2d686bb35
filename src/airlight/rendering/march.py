"""The march driver: its passes, and the bands and tiles in which they run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from weakref import proxy

import numpy as np

from ..clips import Clip, Solid
from ..environment import Environment
from ..errors import StageError
from ..gpu import compute
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..gpu.tiles import Pace, Tile, run_tiles, tiles
from ..scene import Scene
from ..shader.link import parse, stage_source
from ..shader.program import (
    CHOSEN_WIDTH,
    LUMINANCE_SUMS,
    FrameUniforms,
    LuminanceUniforms,
    Program,
    ProgramKey,
    Switches,
    build_program,
    stage_key,
)
from ..stage import BlockLeaps, Resource, Stage
from ..stages import tone as tones
from ..stages.driver import gains_from_curvature
from ..stages.field import Linear, LinearExact
from ..stages.lighting import Quantised
from ..stages.transfer import Transfer
from ..transfer import TransferFunction
from ..volume import FloatArray
from .background import put_behind
from .clips import pack_clips
from .covers import Covers
from .directions import light_directions
from .hits import HIT_BYTES, Hits, light_again
from .layers import check_layers, check_textures
from .outlines import Outlines
from .plan import Pass, check_plan
from .resources import DrawnLayer, bound_resources, light_count, pack_uniforms, uniform_values, write_lights
from .shown import IntArray, shown_columns

BYTES_PER_PIXEL = 16
TRILINEAR = (Linear, LinearExact)
SKIN_VOXELS = 4.0  # of what lies behind the face of a cut and is lit as that is
FAR = 3.4e38  # as devices hold it, where nothing is met
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
    """What the passes of one frame share. ``chosen`` are pixels (n, 2), x and y: no others are drawn; None is all."""

    device: Device
    scene: Scene
    given: Scene
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
    keeps_hits: bool = False
    found: Hits | None = None
    clips: tuple[Clip, ...] = ()
    chosen: IntArray | None = None
    kept_hits: list[np.ndarray[Any, Any]] = field(default_factory=list)

    @property
    def scene_resources(self) -> dict[str, Mapping[str, Resource]]:
        """Resources of the stages that belong to no layer."""
        return {slot: stage.resources(self.layers[0].context) for slot, stage in self.scene_stages.items()}

    @cached_property
    def covers(self) -> Covers:
        """Meshes, and what rays meet of them."""
        return Covers(proxy(self))  # no ring, which would keep volumes until garbage is collected

    @cached_property
    def outlines(self) -> Outlines:
        """Closed meshes that clip."""
        return Outlines(proxy(self))

    @property
    def shows_environment(self) -> bool:
        """Whether an environment is seen behind the layers."""
        return isinstance(self.scene.background, Environment)

    @property
    def tones_late(self) -> bool:
        """Whether tones are mapped in a pass of their own, once the whole scene is there."""
        return self.shows_environment or bool(self.scene_stages["tone"].reads)

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
    groups = tuple(layer.field.groups(layer.context) for layer in frame.layers)
    lights = light_count(frame.scene.lights)
    several = groups if len(groups) > 1 else ()
    switches = switches_of(frame)
    return ProgramKey(root, scene, layers, outputs, extra, switches, frame.device.traits, max(groups), lights, several)


def has_empty(layer: DrawnLayer) -> bool:
    """Whether the layer's function leaves some slabs empty."""
    transfer = layer.stages["transfer"]
    return isinstance(transfer, Transfer) and transfer.has_empty(layer.context)


def switches_of(frame: MarchFrame) -> Switches:
    """What the stages and the data say of each other, and a driver can make use of."""
    integrate = frame.scene_stages["integrate"]
    classifies = bool(getattr(integrate, "classifies", True))
    leaps = [layer.resources["field"].get("leaps") for layer in frame.layers]
    has_stretches = any(has_empty(layer) and not layer.is_full for layer in frame.layers) or any(leaps)
    skips_empty = bool(getattr(integrate, "skips_empty", False)) and frame.skip != "none" and has_stretches
    return Switches(
        has_empty=any(layer.field.masked for layer in frame.layers),
        skips_empty=skips_empty,
        surfaces_only=bool(getattr(integrate, "surfaces_only", False)),
        classifies=classifies,
        curved=is_curved(frame),
        lights_ends=any(getattr(layer.stages["lighting"], "lights_ends", False) for layer in frame.layers),
        skips_blocks=any(leaps),
        fills=bool(getattr(integrate, "fills", False)),
        blocks_know_more=any(isinstance(one, BlockLeaps) and not one.known_to_slabs for one in leaps),
        walks_blocks=walks_blocks(frame),
        walks_cells=walks_blocks(frame) and is_exact(frame),
        looks_for_extremes=len(frame.layers) == 1 and "bounds" in frame.layers[0].resources["field"],
        has_crossings=classifies and any(offers_crossings(layer) for layer in frame.layers),
        lights_faces=bool(frame.clips) and any(layer.stages["lighting"].name != "unlit" for layer in frame.layers),
        draws_caps=draws_caps(frame),
        adaptive=is_adaptive(frame),
        cuts_at_covers=frame.covers.cut_slabs,
    )


def offers_crossings(layer: DrawnLayer) -> bool:
    """Whether the layer's transfer stage tells surfaces at which slabs are cut."""
    return declares(layer.stages["transfer"], "next_crossing")


def declares(stage: Stage, function: str) -> bool:
    """Whether a stage has an optional part of its slot."""
    return function in parse(stage_source(stage.wgsl, stage.name)).declared


def draws_caps(frame: MarchFrame) -> bool:
    """Whether some cut is drawn as a solid face: what attenuates nothing has none."""
    integrate = frame.scene_stages["integrate"]
    attenuates = getattr(integrate, "uses_slabs", True) and getattr(integrate, "classifies", True)
    return attenuates and any(clip.capped for clip in frame.clips)


def is_adaptive(frame: MarchFrame) -> bool:
    """Whether slabs get longer where little gets through: of one layer, of which samples tell what is empty at any step."""
    asked = bool(getattr(frame.scene_stages["driver"], "adaptive", False)) and len(frame.layers) == 1
    stage, context = frame.layers[0].stages["transfer"], frame.layers[0].context
    told = context.labels is None and isinstance(context.transfer, TransferFunction)
    attenuates = hasattr(frame.scene_stages["integrate"], "opaque_at")
    return asked and attenuates and told and not getattr(stage, "has_surfaces", False)


def is_curved(frame: MarchFrame) -> bool:
    """Whether values are put right for curvature: asked of the driver, and of use to all layers."""
    asked = bool(getattr(frame.scene_stages["driver"], "curved", False))
    return asked and all(gains_from_curvature({**frame.scene_stages, **layer.stages}) for layer in frame.layers)


def walks_blocks(frame: MarchFrame) -> bool:
    """Whether surfaces are looked for block by block; those of several layers are on the lattice that they share."""
    if len(frame.layers) > 1:
        return False
    asked = bool(getattr(frame.scene_stages["driver"], "blocks", False))
    return asked and bool(getattr(frame.scene_stages["integrate"], "surfaces_only", False))


def is_exact(frame: MarchFrame) -> bool:
    """Whether surfaces are the roots of cubics, of which none is left out."""
    return bool(getattr(frame.scene_stages["driver"], "refine", "none") == "exact")


def check_refines(frame: MarchFrame) -> None:
    """Refuse the roots of cubics where the field is no cubic along a ray.

    Raises
    ------
    StageError
        For fields that are not trilinear.
    """
    switches = switches_of(frame)
    exact = is_exact(frame)
    for layer in frame.layers:
        if exact and (switches.surfaces_only or switches.has_crossings) and not isinstance(layer.field, TRILINEAR):
            raise StageError('driver.refine "exact"', f"is for trilinear fields, and {layer.field.name} is none", "use secant")


def march_program(frame: MarchFrame) -> Program:
    """Program of the march; a tone stage that looks at the whole image first gets a pass of its own."""
    check_refines(frame)
    check_layers(frame)
    root = frame.scene_stages["driver"].wgsl
    wanted = {"hits": frame.keeps_hits, "covers": frame.covers.meshes, "clips": frame.clips}
    wanted["changes"] = any(isinstance(clip, Solid) for clip in frame.clips)
    wanted["chosen"] = frame.chosen is not None
    outputs = ("radiance", "depth", *(name for name, is_wanted in wanted.items() if is_wanted))
    instead: dict[str, Stage] = {"tone": tones.Linear()} if frame.tones_late else {}
    program = frame.program(root, outputs, (), **instead)
    check_textures(frame, program)
    return program


def draw_march(frame: MarchFrame) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Draw a frame; returns rgba (h, w, 4), depth (h, w), and samples (h, w), negative where the device ended the ray."""
    width, height = frame.size_px
    most = frame.device.limits["max-storage-buffer-binding-size"]
    with_hits = frame.keeps_hits or frame.found is not None
    widest = max(HIT_BYTES if with_hits else BYTES_PER_PIXEL, frame.covers.bytes_per_pixel, frame.outlines.bytes_per_pixel)
    rows = min(height, max(1, most // (widest * width)), MOST_ROWS)
    bands = [_Band(frame, n, first, min(rows, height - first)) for n, first in enumerate(range(0, height, rows))]
    tone = frame.scene_stages["tone"]
    passes = [Pass("march", (), ("radiance", "depth"), lambda: _march(frame, bands))]
    if frame.found is not None:
        passes = [Pass("relight", (), ("radiance", "depth"), lambda: light_again(frame, bands))]
    if any(isinstance(layer.stages["lighting"], Quantised) for layer in frame.layers):
        passes.insert(0, Pass("directions", (), ("lit_directions",), lambda: light_directions(frame)))
    if frame.shows_environment:
        passes.append(Pass("background", ("radiance",), ("radiance",), lambda: put_behind(frame, bands)))
    if "luminance" in tone.reads:
        passes.append(Pass("luminance", ("radiance",), ("luminance",), lambda: _luminance(frame, bands)))
    if frame.tones_late:
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
        if frame.keeps_hits:
            frame.kept_hits.append(np.concatenate([band.read_hits() for band in bands]))
    return rgba, np.where(depth[..., 0] < 3e38, depth[..., 0], np.float32(np.inf)), depth[..., 1]


class _Band:
    """Rows of an image whose pixels fit into one binding."""

    def __init__(self, frame: MarchFrame, number: int, first_row: int, rows: int) -> None:
        width = frame.size_px[0]
        self.first_row, self.rows, self.pixels = first_row, rows, rows * width
        self.radiance = compute.storage_buffer(frame.device, ("band", "radiance", number), self.pixels * 16)
        self.depth = compute.storage_buffer(frame.device, ("band", "depth", number), self.pixels * 8)
        if frame.keeps_hits or frame.found is not None:
            self.hits = compute.storage_buffer(frame.device, ("band", "hits", number), self.pixels * HIT_BYTES)
        self.frame = frame

    def uniforms(self) -> FrameUniforms:
        return FrameUniforms(
            size_px=self.frame.size_px,
            band_first_row=self.first_row,
            band_rows=self.rows,
            step_world=self.frame.step_world,
            t_offset_world=self.frame.t_offset_world,
            strands=self.frame.device.strands,
            skin_world=SKIN_VOXELS * min(min(layer.context.volume.spacing) for layer in self.frame.layers),
            cover_count=self.frame.covers.layers * self.frame.covers.see_through,
            change_slots=self.frame.outlines.slots + 1,
        )

    def chosen_rows(self) -> np.ndarray[Any, Any]:
        """Return the chosen pixels of these rows, uint32 (n, CHOSEN_WIDTH), x below y; the last one fills the rest."""
        assert self.frame.chosen is not None
        x, y = self.frame.chosen.T
        inside = (y >= self.first_row) & (y < self.first_row + self.rows)
        packed = (x[inside] | y[inside] << 16).astype(np.uint32)
        rest = -len(packed) % CHOSEN_WIDTH if len(packed) else 0
        return np.pad(packed, (0, rest), mode="edge" if len(packed) else "constant").reshape(-1, CHOSEN_WIDTH)

    def clear(self) -> None:
        """Fill it as pixels are that show nothing."""
        compute.clear(self.frame.device, self.radiance)
        nowhere = np.tile(np.array([FAR, 0.0], dtype=np.float32), self.pixels)
        self.frame.device.queue.write_buffer(self.depth, 0, nowhere)

    def read(self, rgba: np.ndarray[Any, Any], depth: np.ndarray[Any, Any]) -> None:
        part = slice(self.first_row, self.first_row + self.rows)
        width = self.frame.size_px[0]
        for source, target, channels in ((self.radiance, rgba, 4), (self.depth, depth, 2)):
            data = self.frame.device.queue.read_buffer(source, 0, self.pixels * channels * 4)
            target[part] = np.frombuffer(data, dtype=np.float32).reshape(self.rows, width, channels)

    def read_hits(self) -> np.ndarray[Any, Any]:
        data = self.frame.device.queue.read_buffer(self.hits, 0, self.pixels * HIT_BYTES)
        return np.frombuffer(data, dtype=np.float32).reshape(self.rows, self.frame.size_px[0], HIT_BYTES // 4)


def _bind(frame: MarchFrame, program: Program, buffers: Mapping[str, Any], name: str, data: bytes) -> list[Any]:
    device = frame.device
    resources = {
        **bound_resources(device, program, frame.layers, frame.scene_resources, frame.anchor_world, frame.progress),
        **buffers,
        "uniforms": compute.write_uniforms(device, f"uniforms of {name}", data),
        "lights": write_lights(device, frame.scene.lights),
    }
    return compute.bind_groups(device, compute.pipeline_of(device, program), resources)


def _march(frame: MarchFrame, bands: list[_Band]) -> None:
    device = frame.device
    with frame.clock("link and compile"):
        program = march_program(frame)
        pipeline = compute.pipeline_of(device, program)
    with frame.clock("upload"):
        values = uniform_values(device, frame.scene_stages, frame.layers, frame.anchor_world, frame.progress)
        if frame.tones_late:
            values["tone"] = tones.Linear()
        bound_resources(device, program, frame.layers, frame.scene_resources, frame.anchor_world, frame.progress)
    x, y = program.key.group_px
    sizes = tuple(layer.context.volume.size for layer in frame.layers)
    pace: Pace = device.kept.get(("pace", program.key, frame.step_world, sizes), Pace)
    total = frame.size_px[0] * frame.size_px[1] if frame.chosen is None else len(frame.chosen)
    before = 0
    shown = shown_columns(frame) if frame.chosen is None else None
    extra: dict[str, Any] = {}
    if frame.clips:
        world_from_device = np.eye(4)
        world_from_device[:3, 3] = frame.anchor_world
        packed = pack_clips(frame.clips, world_from_device, frame.outlines.solids)
        extra["clips"] = compute.write_storage(device, "clips", packed)
    for band in bands:
        if shown is not None or frame.chosen is not None:
            band.clear()
        rows = band.chosen_rows() if frame.chosen is not None else None
        if rows is not None and not rows.size:
            continue
        if rows is not None:
            extra["chosen"] = compute.write_storage(device, "chosen", rows.tobytes())
        covers = {}
        if frame.outlines.solids:
            with frame.clock("clips"):
                covers = {"changes": frame.outlines.draw(band)}
        if frame.covers.meshes:
            with frame.clock("meshes"):
                covers |= {"covers": frame.covers.draw(band, covers)}
        groups = _bind(
            frame,
            program,
            {"radiance": band.radiance, "depth": band.depth}
            | extra
            | covers
            | ({"hits": band.hits} if frame.keeps_hits else {}),
            "march",
            pack_uniforms(program, band.uniforms(), values),
        )
        target = device.kept.find(("buffer", "uniforms of march"))

        def submit(tile: Tile, band: _Band = band, groups: list[Any] = groups, target: Any = target) -> None:
            part = replace(band.uniforms(), tile_origin_px=(tile.x, tile.y), tile_size_px=(tile.width, tile.height))
            device.queue.write_buffer(target, 0, pack_uniforms(program, part, values))
            rows = device.strands * -(-tile.height // (y * device.strands))
            compute.dispatch(device, pipeline, groups, (-(-tile.width // x), rows, 1))

        def done(pixels: int, before: int = before) -> None:
            frame.progress("render", min(before + pixels, total), total)

        parts = tiles(shown.width if shown else frame.size_px[0], band.first_row, band.rows, pace, y)
        if rows is not None:
            parts = tiles(CHOSEN_WIDTH, 0, len(rows), pace, y)
        if shown is not None:
            parts = shown.trimmed(parts)
        run_tiles(device, parts, submit, pace, frame.check, done)
        before += band.pixels if rows is None else min(rows.size, total - before)
        frame.progress("render", before, total)


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
    values["luminance"] = LuminanceUniforms(frame.measured.get("luminance", 0.0))
    x, y = device.traits.workgroup
    for band in bands:
        data = pack_uniforms(program, band.uniforms(), values)
        groups = _bind(frame, program, {"radiance": band.radiance}, "tone", data)
        counts = (-(-frame.size_px[0] // x), -(-band.rows // y), 1)
        compute.dispatch(device, compute.pipeline_of(device, program), groups, counts)
