"""Scenes as TOML files: values only. A scene file names stages, never code to import.

Paths are relative to the file. Keys that are left out keep their defaults; unknown keys, wrong types and values out of range
are errors that name the file, the line and the key::

    background = "none"
    camera = "front"

    [[layers]]
    volume = "head.nrrd"
    transfer.points = [[300, "#ffaa88", 0.0], [1200, "white", 0.5]]
    look.shade = { name = "blinn_phong", ambient = 0.2 }

    [render]
    size = [640, 480]
"""

from __future__ import annotations

from .options import RenderOptions
from .reading import load_scene, load_transfer
from .values import stage_from_values
from .writing import save_scene

__all__ = ["RenderOptions", "load_scene", "load_transfer", "save_scene", "stage_from_values"]
