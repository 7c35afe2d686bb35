"""Scenes to plain data and TOML."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..clips import Clip
from ..environment import Environment
from ..errors import DataError
from ..files import write_table
from ..geometry import Lines, Mesh, Points
from ..geometry.saving import to_dict
from ..scene import Layer, Look, Scene
from ..stage import STAGES, Stage, stage_fields
from ..volume import Volume
from .options import FORMAT, checked_options, recipe_value
from .table import Table


def save_scene(
    scene: Scene, path: str | Path, *, render: Mapping[str, Any] | None = None, embed: str | Path | None = None
) -> None:
    """Write a scene to a TOML file; volumes are named by their paths, relative to it.

    Parameters
    ----------
    scene
        What to write.
    path
        The file; it appears whole or not at all.
    render
        Options for the table ``[render]``: size, driver, step, tolerance, skip, passes.
    embed
        Where volumes that came from no file are written, as NRRD; the second gets ``-2`` behind its name, and so on.

    Raises
    ------
    DataError
        When a volume came from no file and ``embed`` is not given, or a parameter is nothing that TOML can hold.
    ValueRangeError
        When ``render`` holds unknown options or wrong values.
    """
    path = Path(path)
    options = _plain(dict(render or {}), "render")
    checked_options(Table(options, ("render",), ""))
    namer = _FileNamer(path.absolute().parent, None if embed is None else Path(embed))
    write_table(path, {"format": FORMAT} | plain_scene(scene, namer) | ({"render": options} if options else {}))


# -- from values to plain data


class Namer(Protocol):
    """How plain data name what they cannot hold."""

    def volume(self, volume: Volume, where: str) -> str | dict[str, Any]:
        """Name of a volume, or a table of a name and of how its file is read."""

    def mesh(self, shape: Mesh | Lines | Points, where: str) -> dict[str, Any]:
        """Plain data of what shares its depth with the layers, files by their paths."""

    def file(self, path: str) -> str:
        """Name of a file."""


def plain_scene(scene: Scene, namer: Namer) -> dict[str, Any]:
    """Return a scene as the plain data of a scene file, with what only files can hold named by ``namer``.

    Raises
    ------
    DataError
        When a parameter is nothing that TOML can hold, or a stage is not registered.
    """
    data: dict[str, Any] = {
        "background": "none" if scene.background is None else _plain(scene.background, "background"),
        "camera": scene.camera if isinstance(scene.camera, str) else plain_stage(scene.camera),
        "lights": [light.to_dict() for light in scene.lights],
        **_clip_data(scene.clips, namer),
        "layers": [_layer_data(layer, f"layers[{n}]", namer) for n, layer in enumerate(scene.layers)],
    }
    if scene.meshes:
        meshes = (namer.mesh(shape, f"meshes[{n}]") for n, shape in enumerate(scene.meshes))
        data["meshes"] = [_named(mesh, namer) for mesh in meshes]
    if scene.annotations:
        data["annotations"] = [annotation.to_dict() for annotation in scene.annotations]
    named: dict[str, Any] = _named_pictures(data, namer)
    return named


def plain_stage(stage: Stage) -> dict[str, Any] | str:
    """Name and all parameters, so that the picture stays the same when a default changes; a name alone where there is none.

    Raises
    ------
    DataError
        When the stage is not registered, or a parameter is nothing that TOML can hold.
    """
    known = STAGES[stage.slot].get(stage.name)
    if known is not type(stage):
        raise DataError(f"{stage.slot}.{stage.name}", "is no registered stage", "al.register its class, then save")
    data: dict[str, Any] = {}
    for field in stage_fields(type(stage)):
        value = getattr(stage, field.name)
        if value is not None:
            data[field.name] = _plain(value, f"{stage.slot}.{stage.name}.{field.name}")
        elif field.default is not None:
            data[field.name] = "none"
    return {"name": stage.name} | data if data or stage.slot == "camera" else stage.name


@dataclasses.dataclass
class _FileNamer:
    """Names volumes by file, relative to the scene's folder; writes those that have none."""

    folder: Path
    embed: Path | None
    written: dict[int, dict[str, Any]] = dataclasses.field(default_factory=dict)

    def volume(self, volume: Volume, where: str) -> str | dict[str, Any]:
        data = self._embedded(volume, where) if volume.source is None else self._named(volume)
        return data["file"] if len(data) == 1 else data

    def _named(self, volume: Volume) -> dict[str, Any]:
        source = volume.source
        assert source is not None
        data: dict[str, Any] = {"file": self.file(source.path)}
        data |= {"dataset": source.dataset} if source.dataset else {}
        data |= {"level": source.level} if source.level else {}
        return data | {key: recipe_value(key, text) for key, text in source.options}

    def _embedded(self, volume: Volume, where: str) -> dict[str, Any]:
        from ..io import save

        if id(volume) not in self.written:
            if self.embed is None:
                raise DataError(f"{where} came", "from no file", "give embed=PATH.nrrd to write it beside the scene")
            number = len(self.written) + 1
            path = self.embed.with_suffix(".nrrd")
            path = path if number == 1 else path.with_stem(f"{path.stem}-{number}")
            save(volume, path)
            self.written[id(volume)] = {"file": self.file(str(path))}
        return self.written[id(volume)]

    def mesh(self, shape: Mesh | Lines | Points, where: str) -> dict[str, Any]:
        return to_dict(shape, where)

    def file(self, path: str) -> str:
        try:
            return Path(os.path.relpath(os.path.abspath(path), self.folder)).as_posix()
        except ValueError:  # another drive
            return Path(path).absolute().as_posix()


def _layer_data(layer: Layer, where: str, namer: Namer) -> dict[str, Any]:
    data: dict[str, Any] = {"volume": namer.volume(layer.volume, f"{where}.volume")}
    if layer.labels is not None:
        named, styles = namer.volume(layer.labels.volume, f"{where}.labels"), layer.labels.to_dict()
        data["labels"] = {"volume": named} | styles if styles else named
    data |= {"visible": layer.visible, "density": float(layer.density), "channel": layer.channel, "time": layer.time}
    data |= _clip_data(layer.clips, namer)
    if layer.transfer is not None:
        data["transfer"] = layer.transfer.to_dict()
    data["look"] = {slot: plain_stage(getattr(layer.look, slot)) for slot in Look.__dataclass_fields__}
    return data


def _clip_data(clips: tuple[Clip, ...], namer: Namer) -> dict[str, Any]:
    return {"clips": [_named(clip.to_dict(), namer) for clip in clips]} if clips else {}


def _named(data: dict[str, Any], namer: Namer) -> dict[str, Any]:
    """Plain data with a file named relative to the scene's folder."""
    return data | {"file": namer.file(data["file"])} if "file" in data else data


def _named_pictures(data: Any, namer: Namer) -> Any:
    """Plain data with the pictures of environments named relative to the scene's folder."""
    if isinstance(data, list):
        return [_named_pictures(part, namer) for part in data]
    if not isinstance(data, dict):
        return data
    if data.get("kind") == "picture":
        return data | {"file": namer.file(data["file"])}
    # Labels hold no pictures, and may be many.
    return {key: part if key == "labels" else _named_pictures(part, namer) for key, part in data.items()}


def _plain(value: Any, where: str) -> Any:
    """What TOML can hold."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (bool, int, str, float)):
        return value
    if isinstance(value, (list, tuple)):
        return [_plain(v, where) for v in value]
    if isinstance(value, Mapping):
        return {str(k): _plain(v, where) for k, v in value.items()}
    if isinstance(value, Stage):
        return plain_stage(value)
    if isinstance(value, Environment):
        return value.to_dict()
    raise DataError(where, f"is {value!r}", "a scene file holds numbers, words and lists")
