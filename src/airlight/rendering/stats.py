"""What ``image.stats`` says of a frame beside times and counts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..stage import (
    ClassifiedGrid,
    DirectionGrid,
    Estimate,
    GradientGrid,
    Grid,
    LabelCells,
    OpennessGrid,
    Resource,
    ShadowGrid,
    SlabTable,
    Stack,
    Table,
)
from .disagreement import disagreement_of
from .march import MarchFrame, switches_of
from .resources import FULL, DrawnLayer, grid_texture, held_axes, label_texture, layer_leaps


class Estimates(Mapping[str, float]):
    """Numbers by name; what takes time is computed when it is first read, not in every frame of an edit."""

    def __init__(self, estimates: Mapping[str, Estimate]) -> None:
        self._found = dict(estimates)

    def __getitem__(self, name: str) -> float:
        found = self._found[name]
        if callable(found):
            self._found[name] = found = found()
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def __repr__(self) -> str:
        return repr(dict(self))


def frame_statistics(frame: MarchFrame, step: float) -> dict[str, Any]:
    """What ``image.stats`` says of a frame beside times and counts."""
    info = frame.device.info
    layers = []
    for layer in frame.layers:
        grids = [r for r in layer.resources["field"].values() if isinstance(r, Grid)]
        textures = [grid_texture(frame.device, grid, frame.progress) for grid in grids]
        cells = [r for r in layer.resources["region"].values() if isinstance(r, LabelCells)]
        textures += [label_texture(frame.device, labels, frame.progress) for labels in cells]
        tables = {
            f"{slot}.{name}": shape
            for slot, resources in layer.resources.items()
            for name, r in resources.items()
            if (shape := _shape(r))
        }
        layers.append(
            {
                "stages": {slot: stage.name for slot, stage in layer.stages.items()},
                "textures": [
                    {
                        "format": t.encoding.format,
                        "error": t.encoding.error,
                        "channel_errors": [encoding.error for encoding in t.encodings],
                        "bytes": t.bytes,
                    }
                    for t in textures
                ],
                "stacks": _stacks(frame, layer),
                "tables": tables,
                "voxels": {
                    f"{slot}.{name}": made
                    for slot, resources in layer.resources.items()
                    for name, r in resources.items()
                    if (made := _made(r, layer.context.volume.size))
                },
                "errors": Estimates(
                    {
                        f"{slot}: {what}": error
                        for slot, stage in layer.stages.items()
                        for what, error in stage.errors(layer.context).items()
                    }
                ),
                "level": 0,
            }
        )
    return {
        "adapter": {"name": info.name, "kind": info.kind, "backend": info.backend, "driver": info.driver},
        "core": frame.device.core,
        "kept": {"bytes": frame.device.kept.bytes, "limit": frame.device.kept.limit_bytes},
        "driver": frame.scene_stages["driver"].name,
        "size": list(frame.size_px),
        "step": step,
        "offsets": getattr(frame.scene_stages["driver"], "offsets", "none"),
        "step_world": frame.step_world,
        "curved": frame.once(switches_of).curved,
        "adaptive": frame.once(switches_of).adaptive,
        "skip": skip_statistics(frame),
        "layers": layers,
        "tables": {
            f"{slot}.{name}": _shape(r) for slot, resources in frame.scene_resources.items() for name, r in resources.items()
        },
    }


def disagreement_statistics(frame: MarchFrame, rgba: npt.NDArray[np.float32]) -> dict[str, Any]:
    """How far neighbouring offsets disagree where they are interleaved; nothing elsewhere."""
    if getattr(frame.scene_stages["driver"], "offsets", "none") != "interleaved":
        return {}
    found = cache(partial(disagreement_of, rgba))
    numbers = {"maximum": lambda: float(found().max()), "rms": lambda: float(np.sqrt(np.mean(found() ** 2)))}
    return {"disagreement": Estimates(numbers)}


def skip_statistics(frame: MarchFrame) -> dict[str, Any]:
    """Whether blocks are passed over, why not where it was asked for, and which share of the others one slab goes through."""
    layer = frame.layers[0]
    return done_of_skipping(frame) | ({"even": layer_leaps(frame.device, layer).even} if layer.is_even else {})


def done_of_skipping(frame: MarchFrame) -> dict[str, Any]:
    """Whether blocks are passed over, and why not where it was asked for."""
    switches = frame.once(switches_of)
    if switches.skips_blocks or any("bounds" in layer.resources["field"] for layer in frame.layers):
        return {"asked": frame.skip, "done": "geometry" if frame.skip == "geometry" else "blocks"}
    if frame.skip == "none":
        return {"asked": "none", "done": "none"}
    full = any(layer.is_full for layer in frame.layers)
    why = f"at least {FULL:.0%} of the blocks hold something" if full else "the look does not tell which blocks change nothing"
    return {"asked": frame.skip, "done": "none", "reason": why}


def _stacks(frame: MarchFrame, layer: DrawnLayer) -> dict[str, Any]:
    """Axis of the stack that is drawn, and bytes of those that are on the device, by axis, also from frames before."""
    found = layer.resources["field"].get("grid")
    if not isinstance(found, Stack):
        return {}
    count = grid_texture(frame.device, found, frame.progress).bytes  # the same for each axis: all hold all voxels
    return {"drawn": "xyz"[found.axis], "bytes": {"xyz"[axis]: count for axis in sorted(held_axes(frame.device, found))}}


def _shape(resource: Resource) -> list[int]:
    """Shape of a table, empty for what is none."""
    match resource:
        case Table():
            return list(resource.texels.shape)
        case SlabTable():
            return [resource.lengths * (2 if resource.weighted else 1), resource.entries, resource.entries, 4]
        case ClassifiedGrid():
            x, y, z = resource.grid.volume.size
            return [z, y, x, 4]
        case OpennessGrid():
            x, y, z = resource.occluders.cells
            return [z, y, x, 4]
        case ShadowGrid():
            x, y, z = resource.size
            return [z, y, x, 4]
    return []


def _made(resource: Resource, size: tuple[int, int, int]) -> dict[str, Any]:
    """Format and bytes of a texture that is computed at the voxels, empty for what is none."""
    x, y, z = size
    match resource:
        case GradientGrid():
            return {"format": resource.texel_format, "bytes": x * y * z * (8 if resource.format == "float16" else 4)}
        case DirectionGrid():
            return {"format": f"rgba{resource.bits}uint", "bytes": -(-x // 4) * y * z * resource.bits // 2}
    return {}
