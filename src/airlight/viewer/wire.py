"""Documents as plain data, and back: what a scene file holds, with ids instead of files.

Clients never see a path, and what they send names nothing that was not given to them.
"""

from __future__ import annotations

import dataclasses
import os
import weakref
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..environment import Environment
from ..errors import ValueRangeError
from ..geometry import Lines, Mesh, Points
from ..geometry.saving import MARK_ENTRIES, MESH_ENTRIES
from ..scene_file.options import checked_options
from ..scene_file.reading import Sources, read_scene
from ..scene_file.table import Table
from ..scene_file.writing import plain_scene, plain_stage
from ..stage import make_stage
from ..volume import Volume
from .document import Document

Shape = Mesh | Lines | Points


class Held:
    """What plain data cannot hold, by ids: volumes, meshes, and the files of pictures and meshes."""

    def __init__(self) -> None:
        self.volumes: dict[str, Volume] = {}
        self._shapes: dict[str, Shape] = {}
        self._ids: dict[int, str] = {}  # of meshes that were made of held ones, while they live
        self._files: dict[str, str] = {}

    # -- from values to plain data

    def plain(self, document: Document) -> dict[str, Any]:
        """Return a document as plain data: ``{"scene": ..., "render": ...}``."""
        render: dict[str, Any] = {"driver": plain_stage(document.driver), "step": document.step, "skip": document.skip}
        if document.tolerance is not None:
            render["tolerance"] = document.tolerance
        if document.passes:
            render["passes"] = [plain_stage(stage) for stage in document.passes]
        return {"scene": plain_scene(document.scene, self), "render": render}

    def volume(self, volume: Volume, where: str = "") -> str:
        """Id of a volume."""
        return _id_of(self.volumes, volume, "v")

    def file(self, path: str) -> str:
        """Id of a file."""
        known = next((key for key, other in self._files.items() if other == path), None)
        if known is None:
            known = f"file{len(self._files)}{os.path.splitext(path)[1].lower()}"
            self._files[known] = path
        return known

    def mesh(self, shape: Shape, where: str = "") -> dict[str, Any]:
        """Plain data of a mesh, lines or points: its id, and what may be changed of it."""
        held = self._ids.get(id(shape)) or _id_of(self._shapes, shape, "m")
        data: dict[str, Any] = {"held": held, "kind": type(shape).__name__.lower()}
        return data | {name: _listed(getattr(shape, name)) for name in _changeable(shape)}

    # -- and back

    def document(self, plain: Mapping[str, Any]) -> Document:
        """Return the document of plain data.

        Raises
        ------
        AirlightError
            When something in them is unknown or wrong; the message names it.
        """
        if not isinstance(plain.get("scene"), Mapping) or not isinstance(plain.get("render"), Mapping):
            raise ValueRangeError("document", "must hold a scene and render")
        scene = read_scene(Table(plain["scene"], (), ""), Sources(self._volume, self._picture, self._path, self._mesh))
        options: dict[str, Any] = {**checked_options(Table(plain["render"], ("render",), ""))}
        driver = make_stage("driver", options.pop("driver", "march"), "render.driver")
        options.pop("size", None)
        return Document(scene, driver, **{"tolerance": None, **options})

    def _volume(self, table: Table) -> Volume:
        name = table.take("file", str, None)
        if name not in self.volumes:
            raise table.error("file", f"is {name!r}, must be one of {', '.join(self.volumes)}")
        return self.volumes[name]

    def _path(self, name: str) -> str:
        known = Path(name).name
        if known not in self._files:
            raise ValueRangeError("file", f"is {known!r}", "open it first")
        return self._files[known]

    def _picture(self, name: str) -> Environment:
        return _environment(self._path(name))

    def _mesh(self, data: Mapping[str, Any]) -> Shape:
        shape = self._shapes.get(str(data.get("held")))
        if shape is None:
            raise ValueRangeError("held", f"is {data.get('held')!r}, must be one of {', '.join(self._shapes)}")
        known = _changeable(shape)
        for name in data:
            if name not in ("held", "kind", *known):
                raise ValueRangeError(name, "is unknown", f"known here: {', '.join(known)}")
        changes = {name: data[name] for name in known if name in data and data[name] != _listed(getattr(shape, name))}
        if not changes:
            return shape
        changed = dataclasses.replace(shape, **changes)
        self._ids[id(changed)] = str(data["held"])
        weakref.finalize(changed, self._ids.pop, id(changed), None)
        return changed


@lru_cache(maxsize=4)
def _environment(path: str) -> Environment:
    return Environment.open(path)


def _changeable(shape: Shape) -> list[str]:
    """Entries of a mesh, lines or points that are few numbers."""
    names = MESH_ENTRIES if isinstance(shape, Mesh) else MARK_ENTRIES
    return [n for n in names if n not in ("points", "colors", "world_from_mesh") and getattr(shape, n) is not None]


def _listed(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else list(value) if isinstance(value, tuple) else value


def _id_of(table: dict[str, Any], value: Any, prefix: str) -> str:
    for key, held in table.items():
        if held is value:
            return key
    table[f"{prefix}{len(table)}"] = value
    return f"{prefix}{len(table) - 1}"
