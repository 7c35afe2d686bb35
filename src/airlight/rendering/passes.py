"""What follows the drawing of a frame, whatever the driver: background, passes of users, luminance, tones, and reading back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import LimitError, StageError
from ..gpu import compute
from ..gpu.tiles import Pace, Tile, run_tiles, tiles
from ..handed import COLOUR, DEPTH, DOMAINS, NUMBER, PIXEL_BYTES, Kind, Measured, PerPixel, Prepared, Rows
from ..shader.program import LuminanceUniforms, PictureUniforms, ProgramKey, Switches, build_program, stage_key
from ..stage import Stage
from ..stages.passes import OVER, WHOLE_PX, Backdrop, Pass
from ..volume import domain_index
from .background import put_behind
from .plan import Step, in_order, planned
from .resources import bound_resources, pack_uniforms, uniform_values
from .tones import map_tones, measure_luminance, measure_surround

if TYPE_CHECKING:
    from .march import MarchFrame

WANTED: Mapping[str, Kind] = {"radiance": COLOUR, "depth": DEPTH}

FloatArrays = tuple[np.ndarray[Any, Any], np.ndarray[Any, Any], np.ndarray[Any, Any]]


def finish(frame: MarchFrame, bands: Sequence[Any], drawing: Sequence[Step]) -> FloatArrays:
    """Draw a frame by a driver's steps and those that follow them.

    Returns rgba (h, w, 4), depth (h, w), and samples (h, w), negative where the device ended the ray.

    Raises
    ------
    StageError
        Before anything is drawn, when passes do not fit together; see ``plan.check_plan``.
    """
    steps = [*drawing, *following(frame, bands)]
    plan = planned(steps, WANTED)
    frame.ran.extend(step.name for step in plan)
    frame.left_out.extend(one.name for one in frame.passes if one.name not in frame.ran)
    for step in plan:
        with frame.clock(step.name):
            step.run()
    width, height = frame.size_px
    rgba = np.empty((height, width, 4), dtype=np.float32)
    depth = np.empty((height, width, 2), dtype=np.float32)
    with frame.clock("read back"):
        for band in bands:
            band.read(rgba, depth)
        if frame.keeps_hits:
            frame.kept_hits.append(np.concatenate([band.read_hits() for band in bands]))
    return rgba, np.where(depth[..., 0] < 3e38, depth[..., 0], np.float32(np.inf)), depth[..., 1]


def following(frame: MarchFrame, bands: Sequence[Any]) -> list[Step]:
    """Return the steps behind those of a driver, in order; which of them are needed, ``planned`` finds out."""
    tone, changed = frame.scene_stages["tone"], {"radiance": COLOUR}
    own = {what: in_order(step_of(frame, bands, one) for one in frame.passes if one.over == what) for what in OVER}
    seen = frame.shows_environment
    behind = [Step("background", changed, changed, lambda: put_behind(frame, bands))] if seen else []
    mapped = [Step("tone", changed | dict(tone.reads), changed, lambda: map_tones(frame, bands))] if frame.tones_late else []
    return [
        Step("domains", {}, {"domains": DOMAINS}, lambda: frame.shared.update(domains=domains_of(frame))),
        step_of(frame, bands, Backdrop(seen=float(seen))),
        *behind,
        *own["scene"],
        Step("luminance", changed, {"luminance": NUMBER}, lambda: measure_luminance(frame, bands)),
        Step("surround", changed | {"luminance": NUMBER}, {"surround": Prepared()}, lambda: measure_surround(frame, bands)),
        *mapped,
        *own["display"],
    ]


def step_of(frame: MarchFrame, bands: Sequence[Any], stage: Pass) -> Step:
    """Return the step of a user's pass.

    Raises
    ------
    LimitError
        When it reads more lists than the device's shaders may.
    """
    lists = [name for name, kind in stage.reads.items() if isinstance(kind, PerPixel | Rows)]
    most = frame.device.limits["max-storage-buffers-per-shader-stage"] - 1
    if len(lists) > most:
        raise LimitError(f"pass {stage.name!r}", f"reads {len(lists)} lists, at most {most} here", "make two passes of it")
    return Step(stage.name, stage.reads, stage.writes, lambda: make_picture(frame, bands, stage))


def rows_for_passes(frame: MarchFrame, rows: int) -> int:
    """Return how many rows a band has of which so many fit into a binding: fewer where passes look beyond its first and last.

    Raises
    ------
    LimitError
        When a pass looks too far, or does not tell how far.
    """
    height = frame.size_px[1]
    if rows >= height:
        return rows
    for stage in frame.passes:
        if stage.reach_px() is None:
            what = f"looks at the image in one piece, and {frame.device.info.name} holds {rows} of its {height} rows in one"
            raise LimitError(f"pass {stage.name!r}", what, "let its reach_px() tell how far it looks, or draw a smaller image")
    reach = max((stage.reach_px() or 0 for stage in frame.passes), default=0)
    if rows <= 2 * reach:
        what = f"look {reach} rows up and down, and {frame.device.info.name} holds {rows} of the image's in one piece"
        raise LimitError("passes", what, "draw a smaller image")
    return rows - 2 * reach


def make_picture(frame: MarchFrame, bands: Sequence[Any], stage: Pass) -> None:
    """Run a user's pass over bands of rows, each from what all of them had before."""
    device = frame.device
    stages: dict[str, Stage] = {"camera": frame.scene_stages["camera"], "passes": stage}
    resources = {slot: one.resources(frame.layers[0].context) for slot, one in stages.items()}
    keys = tuple((slot, stage_key(one, resources[slot])) for slot, one in stages.items())
    measured = tuple(name for name, kind in stage.reads.items() if isinstance(kind, Measured))
    lists = {name: kind.wgsl for name, kind in stage.reads.items() if isinstance(kind, PerPixel | Rows)}
    (name, written), extra = next(iter(stage.writes.items())), ("picture", *measured)
    assert isinstance(written, PerPixel)
    key = ProgramKey(
        "passes/picture.wgsl", keys, (), (), extra, Switches(), device.traits, reads=tuple(lists.items()), written=written.wgsl
    )
    with frame.clock("link and compile"):
        program = build_program(key)
        pipeline = compute.pipeline_of(device, program)
    values = uniform_values(device, stages, frame.layers, frame.anchor_world, frame.progress)
    values |= {one: LuminanceUniforms(frame.measured[one]) for one in measured}
    views = bound_resources(device, program, frame.layers, resources, frame.anchor_world, frame.progress)
    looks_px = stage.reach_px()
    reach = WHOLE_PX if looks_px is None else looks_px
    pace: Pace = device.kept.get(("pace", key), Pace)
    made = []
    for band in bands:
        first_row, pictures = seen_from(
            frame, bands, band, {n: k for n, k in stage.reads.items() if isinstance(k, PerPixel)}, reach
        )
        made.append(band.other(name, PIXEL_BYTES[written.wgsl]))
        told = values | {"picture": PictureUniforms(first_row, reach)}
        bound = {f"read_{n}": pictures.get(n, frame.shared.get(n)) for n in lists} | {"written": made[-1]}
        target = compute.write_uniforms(device, "uniforms of a pass", pack_uniforms(program, band.uniforms(), told))
        groups = compute.bind_groups(device, pipeline, {**views, **bound, "uniforms": target})

        def submit(tile: Tile, band: Any = band, groups: list[Any] = groups, target: Any = target, told: Any = told) -> None:
            part = band.uniforms(tile)
            device.queue.write_buffer(target, 0, pack_uniforms(program, part, told))
            compute.dispatch_pixels(device, pipeline, groups, tile.width, tile.height)

        parts = tiles(frame.size_px[0], band.first_row, band.rows, pace, device.traits.workgroup[1])
        run_tiles(device, parts, submit, pace, frame.check, lambda _: None)
    for band, picture in zip(bands, made, strict=True):
        band.put(name, picture)


def seen_from(
    frame: MarchFrame, bands: Sequence[Any], band: Any, kinds: Mapping[str, PerPixel], reach: int
) -> tuple[int, dict[str, Any]]:
    """Return the first row, and buffers by name, of what a pass sees from a band: its rows, and so many before and behind."""
    if len(bands) == 1:
        return 0, {name: band.pictures[name] for name in kinds}
    width, height = frame.size_px
    first, last = max(band.first_row - reach, 0), min(band.first_row + band.rows + reach, height)
    found, encoder = {}, frame.device.gpu.create_command_encoder()
    for name, kind in kinds.items():
        row_bytes = width * PIXEL_BYTES[kind.wgsl]
        found[name] = compute.storage_buffer(frame.device, ("rows of a pass", name), (last - first) * row_bytes)
        for other in bands:
            low, high = max(first, other.first_row), min(last, other.first_row + other.rows)
            if low < high:
                source, place = (low - other.first_row) * row_bytes, (low - first) * row_bytes
                encoder.copy_buffer_to_buffer(other.pictures[name], source, found[name], place, (high - low) * row_bytes)
    frame.device.queue.submit([encoder.finish()])
    return first, found


def domains_of(frame: MarchFrame) -> Any:
    """Buffer of matrices, column by column, from the unit cube to the domain of each layer in the world of the device."""
    rows = np.zeros((len(frame.layers), 4, 4), dtype=np.float32)
    for n, layer in enumerate(frame.layers):
        volume = layer.context.volume
        low, high = domain_index(volume.size, layer.field.cells)
        index_from_unit = np.diag([*(high - low), 1.0])
        index_from_unit[:3, 3] = low
        device_from_unit = volume.world_from_index @ index_from_unit
        device_from_unit[:3, 3] -= frame.anchor_world
        rows[n] = device_from_unit.T
    # By their number: shaders ask how many there are by the length of the buffer.
    return compute.write_records(frame.device, ("domains", len(rows)), rows.reshape(-1, 4))


def check_reads(passes: Sequence[Pass], name: str, why: str, remedy: str) -> None:
    """Refuse passes that read what a frame does not have.

    Raises
    ------
    StageError
        Names the pass, and why that is so.
    """
    for stage in passes:
        if name in stage.reads:
            raise StageError(f"pass {stage.name!r}", f"reads {name!r}, and {why}", remedy)


def check_bounds(passes: Sequence[Stage]) -> None:
    """Refuse passes where each pixel is drawn until its own error is known.

    Raises
    ------
    StageError
        Names the first pass.
    """
    if passes:
        what = "changes finished pictures, and a tolerance bounds the error of their pixels before that"
        raise StageError(f"pass {passes[0].name!r}", what, "leave the pass or the tolerance out")
