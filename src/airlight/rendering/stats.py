"""What ``image.stats`` says of a frame beside times and counts."""

from __future__ import annotations

from typing import Any

from ..stage import ClassifiedGrid, Grid, LabelCells, Resource, SlabTable, Table
from .march import MarchFrame, switches_of
from .resources import grid_texture, label_texture


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
                "textures": [{"format": t.encoding.format, "error": t.encoding.error, "bytes": t.bytes} for t in textures],
                "tables": tables,
                "errors": {
                    f"{slot}: {what}": error
                    for slot, stage in layer.stages.items()
                    for what, error in stage.errors(layer.context).items()
                },
                "level": 0,
            }
        )
    return {
        "adapter": {"name": info.name, "kind": info.kind, "backend": info.backend, "driver": info.driver},
        "core": frame.device.core,
        "driver": frame.scene_stages["driver"].name,
        "size": list(frame.size_px),
        "step": step,
        "step_world": frame.step_world,
        "curved": switches_of(frame).curved,
        "skip": {"asked": frame.skip, "done": "none"},
        "layers": layers,
    }


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
    return []
