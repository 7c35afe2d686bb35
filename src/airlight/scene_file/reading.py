"""Scenes out of TOML, transfer functions out of TOML and JSON."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..annotations import KINDS as ANNOTATIONS
from ..annotations import Annotation
from ..annotations import from_dict as annotation_from_dict
from ..clips import Clip
from ..environment import Environment, Opener
from ..errors import FileError
from ..geometry import Lines, Mesh, Points
from ..geometry.saving import from_dict
from ..labels import Labels
from ..scene import VIEWS, Camera, Layer, Light, Look, Scene
from ..transfer import Channels, TransferFunction
from ..transfer.colour import Colour
from ..transfer.joint import JointFunction
from ..transfer.kinds import AnyFunction
from ..volume import Volume
from .options import FORMAT, RenderOptions, checked_options, placed, recipe_of, stage_in
from .table import Table, parsed

# Entries of the kinds of transfer functions; the first tells the kind.
KINDS: dict[Any, tuple[str, ...]] = {
    Channels: ("channels",),
    JointFunction: ("axes", "shapes", "associated"),
    TransferFunction: ("points", "associated", "surfaces"),
}


def load_scene(
    path: str | Path,
    *,
    max_memory: int | None = None,
    untrusted: bool = False,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[Scene, RenderOptions]:
    """Read a scene and the options of its ``[render]`` table; the other arguments are those of ``airlight.open``.

    Raises
    ------
    FileError
        When the file is missing or is no TOML.
    ValueRangeError
        For unknown keys, wrong types, values out of range and unknown stages; the message names file, line and key.
    """
    from ..io import open as open_volume

    path = Path(path)
    root = parsed(path)
    folder = path.absolute().parent
    limits: dict[str, Any] = {"untrusted": untrusted, "progress": progress}
    if max_memory is not None:
        limits["max_memory"] = max_memory
    opened: dict[tuple[Any, ...], Volume] = {}

    def volume(table: Table) -> Volume:
        """One object for one recipe: what lies on the device is found by identity."""
        recipe = {"file": table.take("file", str, None), **recipe_of(table)}
        if not recipe["file"]:
            raise table.error("file", "is missing", "name a file")
        key = tuple(recipe.items())
        if key not in opened:
            file = os.path.abspath(folder / recipe.pop("file"))
            with table.located("file"):
                opened[key] = open_volume(file, **recipe, **limits)
        return opened[key]

    def picture(file: str) -> Environment:
        """Picture of an environment; a scene of unknown origin names none beyond its own folder."""
        if untrusted and not Path(file).resolve().is_relative_to(folder.resolve()):
            raise FileError(file, "lies outside of the folder of an untrusted scene", "move it beside the scene")
        return Environment.open(file, untrusted=untrusted, **({} if max_memory is None else {"max_memory": max_memory}))

    version = root.take("format", int, FORMAT)
    if version != FORMAT:
        raise root.error("format", f"is {version}, this version reads {FORMAT}", "use a newer airlight")
    options = checked_options(root.table("render"), picture)
    root.taken.add("keyframes")  # of the movie that the scene is in: airlight.movies reads them
    beside = _beside(folder, untrusted)
    return read_scene(root, Sources(volume, picture, beside, lambda data: from_dict(data, beside))), options


@dataclass(frozen=True)
class Sources:
    """What makes values of a scene's plain data: of those that only name volumes, pictures, files and meshes, and of others."""

    volume: Callable[[Table], Volume]
    picture: Opener
    file: Callable[[str], str]
    mesh: Callable[[Mapping[str, Any]], Mesh | Lines | Points]
    labels: Callable[[Volume, Mapping[str, Any]], Labels] = Labels.from_dict
    light: Callable[[Mapping[str, Any], Callable[[str], str]], Light] = Light.from_dict
    clip: Callable[[Mapping[str, Any], Callable[[str], str]], Clip] = Clip.from_dict


def read_scene(root: Table, sources: Sources) -> Scene:
    """Return the scene that plain data tell of; entries that nobody took are refused.

    Raises
    ------
    ValueRangeError
        For unknown keys, wrong types, values out of range and unknown stages.
    """
    background = _background(root, sources.picture)
    lights = [_light(table, sources) for table in root.tables("lights")] if "lights" in root.data else None
    clips = _clips(root, sources)
    layers = [_layer(table, sources) for table in root.tables("layers")]
    annotations = [_annotation(table) for table in root.tables("annotations")]
    meshes = [_mesh(table, sources.mesh) for table in root.tables("meshes")]
    camera = _camera(root, sources.picture)
    root.close()
    with root.located():
        values = {"lights": lights, "background": background, "clips": clips, "meshes": meshes, "annotations": annotations}
        return Scene(layers=layers, camera=camera, **values)  # type: ignore[arg-type]


def load_transfer(path: str | Path) -> AnyFunction:
    """Transfer function in a TOML or JSON file: of one value (``points``), several (``axes``), or of ``channels``."""
    path = Path(path)
    return _transfer(parsed(path))


def _layer(table: Table, sources: Sources) -> Layer:
    image, labels = _volume(table, "volume", sources.volume), _labels(table, sources)
    look = table.table("look")
    chosen = {slot: stage_in(look, slot, slot, sources.picture) for slot in Look.__dataclass_fields__ if slot in look.data}
    look.taken |= set(Look.__dataclass_fields__)
    look.close()
    function = _transfer(table.table("transfer")) if "transfer" in table.data else None
    visible, density = table.take("visible", bool, True), table.take("density", float, 1.0)
    channel, time = table.take("channel", int | str, 0), table.take("time", int, 0)
    clips = _clips(table, sources)
    table.taken |= {"volume", "labels", "transfer"}
    table.close()
    with table.located():
        return Layer(image, function, Look(**chosen), labels, visible, density, channel, time, clips)


def _volume(table: Table, key: str, volume: Callable[[Table], Volume]) -> Volume:
    """Volume that a key names: a file, or a table that says how it is to be read."""
    if key not in table.data:
        raise table.error(key, "is missing", "name a file")
    if isinstance(table.data[key], str):
        table.taken.add(key)
        return volume(Table({"file": table.data[key]}, (*table.place, key), table.file, table.text))
    inner = table.table(key)
    found = volume(inner)
    inner.close()
    return found


def _labels(table: Table, sources: Sources) -> Labels | None:
    """Labels of a layer: a volume, or a table with a volume and styles."""
    if "labels" not in table.data:
        return None
    if not isinstance(table.data["labels"], dict) or "volume" not in table.data["labels"]:
        found = _volume(table, "labels", sources.volume)
        with table.located("labels"):
            return sources.labels(found, {})
    inner = table.table("labels")
    found = _volume(inner, "volume", sources.volume)
    with inner.located():
        return sources.labels(found, {key: value for key, value in inner.data.items() if key != "volume"})


def _transfer(table: Table) -> AnyFunction:
    """Transfer function of the kind that has one of the table's entries."""
    kind = next((kind for kind, entries in KINDS.items() if entries[0] in table.data), TransferFunction)
    table.taken |= set(KINDS[kind])
    table.close()
    with table.located_inside("transfer"):
        function: AnyFunction = kind.from_dict(table.data)
        return function


def _background(root: Table, picture: Opener) -> Environment | Colour | None:
    """Colour, an environment in a table, or none."""
    if isinstance(root.data.get("background"), dict):
        root.taken.add("background")
        with root.located("background"):
            return Environment.from_dict(placed(root.data["background"], root), picture)
    colour: Colour = root.take("background", str | tuple[float, float, float], (0.0, 0.0, 0.0))
    return None if colour == "none" else colour


def _camera(root: Table, picture: Opener) -> Camera | str:
    root.taken.add("camera")
    value = root.data.get("camera", "front")
    if isinstance(value, str):
        if value not in VIEWS:
            raise root.error("camera", f"is {value!r}, must be a table or one of {', '.join(VIEWS)}")
        return value
    camera = stage_in(root, "camera", "camera", picture)
    assert isinstance(camera, Camera)
    return camera


def _clips(table: Table, sources: Sources) -> tuple[Clip, ...]:
    return tuple(_clip(inner, sources) for inner in table.tables("clips"))


def _clip(table: Table, sources: Sources) -> Clip:
    with table.located_inside("clip"):
        return sources.clip(table.data, sources.file)


def _mesh(table: Table, made: Callable[[Mapping[str, Any]], Mesh | Lines | Points]) -> Mesh | Lines | Points:
    with table.located():
        return made(table.data)


def _beside(folder: Path, untrusted: bool) -> Callable[[str], str]:
    """Find files of meshes, named relative to a scene; one of unknown origin names none beyond its own folder."""

    def place(name: str) -> str:
        file = os.path.abspath(folder / name)
        if untrusted and not Path(file).resolve().is_relative_to(folder.resolve()):
            raise FileError(file, "lies outside of the folder of an untrusted scene", "move it beside the scene")
        return file

    return place


def _annotation(table: Table) -> Annotation:
    kind = table.data.get("kind")
    with table.located_inside(kind if isinstance(kind, str) and kind in ANNOTATIONS else "annotation"):
        return annotation_from_dict(table.data)


def _light(table: Table, sources: Sources) -> Light:
    with table.located_inside("light"):
        return sources.light(table.data, sources.file)
