"""Scenes as plain data and back within one program, with ids for what such data cannot hold.

Volumes, meshes and long tables of names stay where they are. What plain data left as it was comes back as the very value that
it was, so that nothing is read, checked or uploaded twice.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..environment import Environment
from ..errors import ValueRangeError
from ..geometry import Lines, Mesh, Points
from ..geometry.saving import MARK_ENTRIES, MESH_ENTRIES
from ..labels import Labels
from ..scene import Layer, Scene
from ..volume import Volume
from .reading import Sources, read_scene
from .table import Table
from .writing import plain_scene

Shape = Mesh | Lines | Points
MANY = ("points", "colors", "world_from_mesh")
SCENE_ENTRIES = ("background", "camera", "lights", "clips", "meshes", "annotations")
LAYER_ENTRIES = ("labels", "clips", "transfer", "look")


class Files(Protocol):
    """How plain data name files."""

    def name(self, path: str) -> str:
        """Name of a file."""

    def path(self, name: str) -> str:
        """Return the path of a file by its name, or refuse it."""


@dataclasses.dataclass(frozen=True)
class FilesByPath:
    """Files by their paths; those of others are relative to a folder."""

    folder: str | os.PathLike[str] = "."

    def name(self, path: str) -> str:
        """Absolute path of a file."""
        return os.path.abspath(path)

    def path(self, name: str) -> str:
        """Absolute path of a name in the folder."""
        return os.path.join(os.path.abspath(self.folder), name)


class FilesByToken:
    """Files by words that tell nothing of where they lie; none is opened that was not given."""

    def __init__(self) -> None:
        self._paths: dict[str, str] = {}

    def name(self, path: str) -> str:
        """Word for a file, with its ending."""
        known = next((token for token, other in self._paths.items() if other == path), None)
        if known is None:
            known = f"file{len(self._paths)}{Path(path).suffix.lower()}"
            self._paths[known] = path
        return known

    def path(self, name: str) -> str:
        """Path of a file.

        Raises
        ------
        ValueRangeError
            For words that were not given out.
        """
        if name not in self._paths:
            raise ValueRangeError("file", f"is {name!r:.80}", f"known: {', '.join(self._paths) or 'none, open it first'}")
        return self._paths[name]


class Held:
    """What plain data name by ids: volumes, meshes, and tables of the names of labels.

    Parameters
    ----------
    files
        How they name files.
    remedy
        What to do where they name another volume or mesh.
    """

    def __init__(self, files: Files, remedy: str = "open it first") -> None:
        self.volumes: dict[str, Volume] = {}
        self._files, self._remedy = files, remedy
        self._shapes: dict[str, Shape] = {}
        self._shape_ids: dict[int, str] = {}  # by identity, while they live
        self._named: dict[str, Labels] = {}  # labels by the id of their names
        self._volume_numbers, self._name_numbers = itertools.count(), itertools.count()
        self._sources = Sources(self._volume, self.picture, files.path, self._shape, self._labels)

    # -- from values to plain data

    def plain(self, scene: Scene) -> dict[str, Any]:
        """Return a scene as plain data.

        Raises
        ------
        DataError
            For meshes of clips, and pictures of lights and environments, that came from no file.
        """
        plain = plain_scene(scene, self)
        pairs = zip(plain["layers"], scene.layers, strict=True)
        return plain | {"layers": [_with_names(data, self._id_of_names(layer.labels)) for data, layer in pairs]}

    def volume(self, volume: Volume, where: str = "") -> str:
        """Id of a volume."""
        known = next((key for key, other in self.volumes.items() if other is volume), None)
        if known is None:
            known = f"v{next(self._volume_numbers)}"
            self.volumes = {**self.volumes, known: volume}
        return known

    def keep_only(self, volumes: Iterable[Volume]) -> None:
        """Let go of all volumes but these; their ids are not given again."""
        kept = {id(volume) for volume in volumes}
        self.volumes = {key: volume for key, volume in self.volumes.items() if id(volume) in kept}
        self._named = {key: labels for key, labels in self._named.items() if id(labels.volume) in kept}

    def file(self, path: str) -> str:
        """Name of a file."""
        return self._files.name(path)

    def mesh(self, shape: Shape, where: str = "") -> dict[str, Any]:
        """Plain data of a mesh, lines or points: an id, which shapes share that differ in few numbers, and those numbers."""
        known = self._shape_ids.get(id(shape))
        if known is None:
            known = next((key for key, other in self._shapes.items() if _is_like(other, shape)), None)
            if known is None:
                self._shapes[known := f"m{len(self._shapes)}"] = shape
            self._remember(shape, known)
        data: dict[str, Any] = {"held": known, "kind": _kind(shape)}
        return data | {name: _listed(getattr(shape, name)) for name in _few(shape)}

    def in_full(self, layer: Mapping[str, Any]) -> dict[str, Any]:
        """Plain data of a layer with the names of its labels in place of their id."""
        labels = layer.get("labels")
        held = labels.get("names") if isinstance(labels, dict) else None
        return _with_names(layer, self._named[held].to_dict()["names"] if isinstance(held, str) else None)

    # -- and back

    def scene(self, plain: Mapping[str, Any], known: Mapping[str, Any] | None = None, of: Scene | None = None) -> Scene:
        """Return the scene of plain data; what they share with those of a known scene is that scene's very values.

        Parameters
        ----------
        plain
            What is read.
        known, of
            Plain data of a scene, and the scene.

        Raises
        ------
        AirlightError
            For what is unknown or wrong.
        """
        given = plain.get("layers")
        if known is None or of is None or not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
            return read_scene(Table(plain, (), ""), self._sources)
        before = list(zip(known["layers"], of.layers, strict=True))
        partners = [_partner(layer, n, before) for n, layer in enumerate(given)]
        kept = _shared(plain, known, SCENE_ENTRIES)
        kept_of_layers = [_shared(layer, other, LAYER_ENTRIES) for layer, (other, _) in zip(given, partners, strict=True)]
        changed = {name: value for name, value in plain.items() if name not in kept}
        changed["layers"] = [_without(layer, names) for layer, names in zip(given, kept_of_layers, strict=True)]
        read = read_scene(Table(changed, (), ""), self._sources_beside(known, of))
        layers = []
        for n, (layer, (other, value)) in enumerate(zip(given, partners, strict=True)):
            with Table({}, ("layers", n), "").located():
                layers.append(value if value and layer == other else _taken(read.layers[n], kept_of_layers[n], value))
        return dataclasses.replace(read, layers=tuple(layers), **{name: getattr(of, name) for name in kept})

    def _sources_beside(self, known: Mapping[str, Any], of: Scene) -> Sources:
        """Sources for whom the very plain data of a known light, clip or mesh stand for that one: some are files."""
        pairs = [(known.get(name, ()), getattr(of, name)) for name in ("lights", "clips", "meshes")]
        pairs += [(data.get("clips", ()), layer.clips) for data, layer in zip(known["layers"], of.layers, strict=True)]
        values = {id(data): value for some, made in pairs for data, value in zip(some, made, strict=True)}

        def or_else(make: Callable[..., Any]) -> Callable[..., Any]:
            return lambda data, *more: values[id(data)] if id(data) in values else make(data, *more)

        own = self._sources
        return dataclasses.replace(own, light=or_else(own.light), clip=or_else(own.clip), mesh=or_else(own.mesh))

    def _volume(self, table: Table) -> Volume:
        name = table.take("file", str, "")
        if name not in self.volumes:
            raise table.error("file", f"is {name!r:.80}, must be one of {', '.join(self.volumes)}", self._remedy)
        return self.volumes[name]

    def picture(self, name: str) -> Environment:
        """Open the picture of an environment that plain data name."""
        path = self._files.path(name)
        return _environment(path, os.stat(path).st_mtime_ns if os.path.exists(path) else 0)

    def _shape(self, data: Mapping[str, Any]) -> Shape:
        key = data.get("held")
        if not isinstance(key, str) or key not in self._shapes:
            known = ", ".join(self._shapes) or "none, there are no meshes"
            raise ValueRangeError("mesh.held", f"is {key!r:.80}, must be one of {known}", self._remedy)
        shape = self._shapes[key]
        few = _few(shape)
        for name in data:
            if name not in ("held", "kind", *few):
                raise ValueRangeError(f"mesh.{name}", "is unknown", f"known here: {', '.join(few)}")
        if data.get("kind", _kind(shape)) != _kind(shape):
            raise ValueRangeError("mesh.kind", f"is {data['kind']!r:.80}, and {key} is a {_kind(shape)}", "leave it as it is")
        changes = {name: data[name] for name in few if name in data and data[name] != _listed(getattr(shape, name))}
        if not changes:
            return shape
        changed = dataclasses.replace(shape, **changes)
        self._remember(changed, key)
        return changed

    def _remember(self, shape: Shape, key: str) -> None:
        self._shape_ids[id(shape)] = key
        weakref.finalize(shape, self._shape_ids.pop, id(shape), None)

    # -- names of labels, of which there may be hundreds of thousands

    def _id_of_names(self, labels: Labels | None) -> str | None:
        if labels is None or not labels.names:
            return None
        for key, other in self._named.items():
            if other.names is labels.names or other.names == labels.names:
                self._named[key] = labels  # found at once next time
                return key
        self._named[key := f"names{next(self._name_numbers)}"] = labels
        return key

    def _labels(self, volume: Volume, data: Mapping[str, Any]) -> Labels:
        held = data.get("names")
        if not isinstance(held, str):
            return Labels.from_dict(volume, data)
        if held not in self._named:
            known = ", ".join(self._named) or "there are none"
            raise ValueRangeError("labels.names", f"is {held!r:.40}", f"known: {known}")
        return Labels.from_dict(volume, _without(data, ["names"])).with_names_of(self._named[held])


def _with_names(layer: Mapping[str, Any], names: Any) -> dict[str, Any]:
    """Plain data of a layer with something else for the names of its labels, unless it is None."""
    return {**layer} if names is None else {**layer, "labels": layer["labels"] | {"names": names}}


@lru_cache(maxsize=4)
def _environment(path: str, changed_ns: int) -> Environment:
    return Environment.open(path)


# -- what stays


Partner = tuple[Mapping[str, Any], Layer | None]


def _partner(layer: Mapping[str, Any], n: int, before: Sequence[tuple[Mapping[str, Any], Layer]]) -> Partner:
    """Plain data and value of the layer that one was: the very same data, wherever they were, else what was in its place."""
    same = next((pair for pair in before if pair[0] is layer), None)
    return same or (before[n] if n < len(before) else ({}, None))


def _shared(plain: Mapping[str, Any], known: Mapping[str, Any], entries: Sequence[str]) -> list[str]:
    """Entries that are the same in two tables, or in neither."""
    missing = object()
    return [name for name in entries if plain.get(name, missing) == known.get(name, missing)] if known else []


def _without(plain: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    return {name: value for name, value in plain.items() if name not in names}


def _taken(read: Layer, names: Sequence[str], of: Layer | None) -> Layer:
    """Return a layer with some of another's values."""
    return dataclasses.replace(read, **{name: getattr(of, name) for name in names}) if names else read


# -- shapes


def _kind(shape: Shape) -> str:
    return type(shape).__name__.lower()


def _few(shape: Shape) -> list[str]:
    """Entries of a mesh, lines or points that are few numbers."""
    names = MESH_ENTRIES if isinstance(shape, Mesh) else MARK_ENTRIES
    return [name for name in names if name not in MANY and getattr(shape, name) is not None]


def _is_like(one: Shape, other: Shape) -> bool:
    """Whether two shapes differ in few numbers at most."""
    if one is other or type(one) is not type(other) or _few(one) != _few(other):
        return one is other
    names = [field.name for field in dataclasses.fields(one) if field.name not in _few(one)]
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)


def _listed(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else list(value) if isinstance(value, tuple) else value
