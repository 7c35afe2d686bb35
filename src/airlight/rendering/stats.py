"""What ``image.stats`` says of a frame beside times and counts."""

from __future__ import annotations

from typing import Any

from ..stage import Grid, Table
from .march import MarchFrame
from .resources import grid_texture


def frame_statistics(frame: MarchFrame, step: float) -> dict[str, Any]:
    """What ``image.stats`` says of a frame beside times and counts."""
    info = frame.device.info
    layers = []
    for layer in frame.layers:
        grids = [r for r in layer.resources["field"].values() if isinstance(r, Grid)]
        textures = [grid_texture(frame.device, grid, frame.progress) for grid in grids]
        tables = {
            f"{slot}.{name}": list(r.texels.shape)
            for slot, resources in layer.resources.items()
            for name, r in resources.items()
            if isinstance(r, Table)
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
        "skip": {"asked": frame.skip, "done": "none"},
        "layers": layers,
    }
