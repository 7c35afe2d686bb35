"""Python that draws a view again, and its scene file: both name files without their folders, which clients do not learn."""

from __future__ import annotations

import keyword
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np

from .. import stages
from ..annotations import Annotation
from ..clips import Clip, Solid
from ..environment import Environment
from ..errors import DataError
from ..files import write_table
from ..geometry import Lines, Mesh, Points
from ..geometry.saving import MARK_ENTRIES, MESH_ENTRIES, to_dict
from ..labels import Labels
from ..light import Light
from ..movies.keys import Keyframes
from ..scene import Layer, Look, Scene
from ..scene_file.options import FORMAT, recipe_value
from ..scene_file.writing import plain_scene, plain_stage
from ..stage import Stage, stage_fields
from ..volume import Source, Volume
from .document import Document
from .shelf import name_of

WIDTH = 100


# -- Python


def script(document: Document, size_px: tuple[int, int]) -> str:
    """Return a script that draws a document, as the viewer does before it refines it.

    Raises
    ------
    DataError
        For stages of a plugin, and meshes that came from no file.
    """
    volumes = _Volumes()
    scene = _scene(document.scene, volumes)
    given = {"size": repr(tuple(size_px))} | _drawing(document)
    head = [f"# Run it in the folder of {_in_line(volumes.files)}."] if volumes.files else []
    head += [f'# {name}.nrrd is not there yet: al.save({name}, "{name}.nrrd") writes it.' for name in volumes.without_file]
    rest = document.tolerance
    slow = (
        []
        if rest is None
        else [f"# With tolerance={rest:g} it is refined to that error, as the viewer does at rest, and takes longer."]
    )
    lines = [
        *head,
        "import airlight as al",
        "",
        *volumes.lines,
        f"scene = {scene}",
        "",
        *slow,
        f"image = {_call('al.render', ['scene'], given)}",
    ]
    return "\n".join([*lines, 'image.save("picture.png")', ""])


@dataclass
class _Volumes:
    """Names of variables for volumes, and the lines that open them."""

    lines: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    without_file: list[str] = field(default_factory=list)
    _known: list[Volume] = field(default_factory=list)

    def name(self, volume: Volume) -> str:
        """Variable of a volume."""
        number = next((n for n, known in enumerate(self._known) if known is volume), len(self._known))
        name = "volume" if number == 0 else f"volume_{number + 1}"
        if number == len(self._known):
            self._known.append(volume)
            self.lines.append(f"{name} = {self._opening(volume, name)}")
        return name

    def _opening(self, volume: Volume, variable: str) -> str:
        from ..samples.analytic import COMPUTED

        name = name_of(volume)
        if name and name == volume.name and name_is_sample(name):
            computed = name in COMPUTED and volume.size[0] != COMPUTED[name].size
            return _call("al.samples.load", [repr(name)], {"size": repr(volume.size[0])} if computed else {})
        self.without_file += [] if name else [variable]
        source = volume.source or Source("")
        told: dict[str, Any] = {"dataset": source.dataset} if source.dataset else {}
        told |= {"level": source.level} if source.level else {}
        told |= {key: recipe_value(key, text) for key, text in source.options}
        self.files += [name] if name and name not in self.files else []
        return _call("al.open", [repr(name or f"{variable}.nrrd")], {key: repr(value) for key, value in told.items()})


def name_is_sample(name: str) -> bool:
    """Whether a sample is called so."""
    from ..samples import names

    return name in names()


def _scene(scene: Scene, volumes: _Volumes) -> str:
    parts = {"layers": _list([_layer(layer, volumes) for layer in scene.layers])} if scene.layers else {}
    parts |= {"camera": repr(scene.camera) if isinstance(scene.camera, str) else _stage(scene.camera)}
    parts |= {"lights": _list([_of_kind("al.Light", light) for light in scene.lights])}
    if isinstance(scene.background, Environment):
        parts["background"] = _environment(scene.background)
    else:
        parts["background"] = _value(scene.background)
    parts |= {"clips": _list([_clip(clip) for clip in scene.clips])} if scene.clips else {}
    parts |= {"meshes": _list([_shape(shape) for shape in scene.meshes])} if scene.meshes else {}
    parts |= {"annotations": _list([_annotation(one) for one in scene.annotations])} if scene.annotations else {}
    return _call("al.Scene", [], parts)


def _layer(layer: Layer, volumes: _Volumes) -> str:
    volume, look, plain = volumes.name(layer.volume), layer.look, Look()
    chosen = {
        slot: _stage(getattr(look, slot)) for slot in Look.__dataclass_fields__ if getattr(look, slot) != getattr(plain, slot)
    }
    parts: dict[str, str] = {} if layer.transfer is None else {"transfer": layer.transfer.as_code()}
    parts |= {"look": _call("al.Look", [], chosen)} if chosen else {}
    parts |= {} if layer.labels is None else {"labels": _labels(layer.labels, volumes)}
    usual = {"visible": True, "density": 1.0, "channel": 0, "time": 0}
    parts |= {name: repr(getattr(layer, name)) for name, value in usual.items() if getattr(layer, name) != value}
    parts |= {"clips": _list([_clip(clip) for clip in layer.clips])} if layer.clips else {}
    return _call("al.Layer", [volume], parts)


def _labels(labels: Labels, volumes: _Volumes) -> str:
    volume, told = volumes.name(labels.volume), labels.to_dict()
    return _call("al.Labels.from_dict", [volume, _value(told)], {}) if told else _call("al.Labels", [volume], {})


def _stage(stage: Stage) -> str:
    """Name of a stage where all is as it comes, else the call of its class with what is not."""
    plain_stage(stage)  # refuses those that are not registered
    own = {f.name: getattr(stage, f.name) for f in stage_fields(type(stage))}
    told = {f.name: own[f.name] for f in stage_fields(type(stage)) if own[f.name] is not None and own[f.name] != f.default}
    if not told and stage.slot != "camera":
        return repr(stage.name)
    module = getattr(stages, stage.slot, None)
    if getattr(module, type(stage).__name__, None) is not type(stage):
        raise DataError(f"{stage.slot}.{stage.name}", "comes from a plugin", "save the scene instead")
    return _call(f"al.{stage.slot}.{type(stage).__name__}", [], {name: _value(value) for name, value in told.items()})


def _drawing(document: Document) -> dict[str, str]:
    driver = _stage(document.driver)
    told = {} if driver == "'march'" else {"driver": driver}
    told |= {} if document.step == 1.0 else {"step": repr(document.step)}
    told |= {} if document.skip == "auto" else {"skip": repr(document.skip)}
    return told | ({"passes": _list([_stage(one) for one in document.passes])} if document.passes else {})


def _of_kind(name: str, value: Light | Clip) -> str:
    """Call of the function that is named as the kind of what plain data tell."""
    data = value.to_dict()
    if "image" in data:
        return _call(f"{name}.from_dict", [_value(_nameless(data))], {})
    return _call(f"{name}.{data['kind']}", [], {key: _value(part) for key, part in data.items() if key != "kind"})


def _clip(clip: Clip) -> str:
    if not isinstance(clip, Solid):
        return _of_kind("al.Clip", clip)
    return _call("al.Clip.from_dict", [_value(_nameless(clip.to_dict()))], {})


def _shape(shape: Mesh | Lines | Points) -> str:
    data = _nameless(to_dict(shape, "meshes"))
    if isinstance(shape, Mesh):
        told = {key: _value(data[key]) for key in MESH_ENTRIES if key in data}
        return _call("al.Mesh.open", [_value(data["file"])], told)
    told = {key: _value(data[key]) for key in MARK_ENTRIES[1:] if key in data}
    return _call(f"al.{type(shape).__name__}", [_value(data["points"])], told)


def _annotation(annotation: Annotation) -> str:
    values = {f.name: getattr(annotation, f.name) for f in fields(annotation)}
    told = {f.name: _value(values[f.name]) for f in fields(annotation) if values[f.name] != f.default}
    return _call(f"al.{type(annotation).__name__}", [], told)


def _environment(environment: Environment) -> str:
    return _call("al.Environment.from_dict", [_value(_nameless(environment.to_dict()))], {})


def _value(value: Any) -> str:
    """Python of plain values, stages and environments."""
    if isinstance(value, Stage):
        return _stage(value)
    if isinstance(value, Environment):
        return _environment(value)
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, dict):
        return _bracketed("{", [f"{key!r}: {_value(part)}" for key, part in value.items()], "}")
    if isinstance(value, tuple):
        return _bracketed("(", [_value(part) for part in value], ",)" if len(value) == 1 else ")")
    if isinstance(value, list):
        return _list([_value(part) for part in value])
    return repr(value)


def _call(name: str, parts: list[str], named: dict[str, str]) -> str:
    assert not any(keyword.iskeyword(key) for key in named)
    return _bracketed(f"{name}(", [*parts, *(f"{key}={part}" for key, part in named.items())], ")")


def _list(parts: list[str]) -> str:
    return _bracketed("[", parts, "]")


def _bracketed(begin: str, parts: list[str], end: str) -> str:
    """On one line where there is room, else a line for each part."""
    line = f"{begin}{', '.join(parts)}{end}"
    if len(line) <= WIDTH and "\n" not in line:
        return line
    return "\n".join([begin, *(indent(part, "    ") + "," for part in parts), end.lstrip(",")])


# -- scene files


def scene_text(document: Document, size_px: tuple[int, int], keyframes: Keyframes | None = None) -> str:
    """Return the scene file of a document, with keyframes beside it where there are some.

    Raises
    ------
    DataError
        For volumes and meshes that came from no file, and stages of a plugin.
    """
    names = _Bare()
    render: dict[str, Any] = {"size": list(size_px), "driver": plain_stage(document.driver), "step": document.step}
    render |= {"skip": document.skip} | ({} if document.tolerance is None else {"tolerance": document.tolerance})
    render |= {"passes": [plain_stage(one) for one in document.passes]} if document.passes else {}
    data = {"format": FORMAT} | plain_scene(document.scene, names) | {"render": render}
    data |= {} if keyframes is None else {"keyframes": [_nameless(key.to_dict(), names.file) for key in keyframes.keys]}
    with tempfile.TemporaryDirectory(prefix="airlight-") as folder:
        path = Path(folder) / "scene.toml"
        write_table(path, data, f"To be put beside {_in_line(names.files)}." if names.files else "")
        return path.read_text(encoding="utf-8")


@dataclass
class _Bare:
    """Names volumes, meshes and pictures by their files, without folders."""

    files: list[str] = field(default_factory=list)

    def volume(self, volume: Volume, where: str) -> str | dict[str, Any]:
        name, source = name_of(volume), volume.source
        if source is None or not name:
            remedy = "take the Python script, or save the volume (al.save) and open that"
            raise DataError(where, "came from no file", remedy)
        data: dict[str, Any] = {"file": self.file(source.path)}
        data |= {"dataset": source.dataset} if source.dataset else {}
        data |= {"level": source.level} if source.level else {}
        data |= {key: recipe_value(key, text) for key, text in source.options}
        return data["file"] if len(data) == 1 else data

    def mesh(self, shape: Mesh | Lines | Points, where: str) -> dict[str, Any]:
        return to_dict(shape, where)

    def file(self, path: str) -> str:
        name = Path(path).name
        if name not in self.files:
            self.files.append(name)
        return name


def _in_line(names: list[str]) -> str:
    """Names of files for a comment, which a line feed in one of them must not end."""
    return ", ".join(name if name.isprintable() else repr(name) for name in names)


def _nameless(data: Any, name: Callable[[str], str] = lambda path: Path(path).name) -> Any:
    """Plain data with files named without their folders."""
    if isinstance(data, list):
        return [_nameless(part, name) for part in data]
    if not isinstance(data, dict):
        return data
    return {key: name(part) if key == "file" else _nameless(part, name) for key, part in data.items()}
