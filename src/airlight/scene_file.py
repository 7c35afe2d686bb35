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

import contextlib
import dataclasses
import math
import os
import re
import types
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, TypedDict, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from .errors import AirlightError, DataError, FileError, ValueRangeError
from .scene import VIEWS, Camera, Layer, Light, Look, Scene
from .stage import STAGES, Stage, stage_fields
from .transfer import TransferFunction
from .volume import Volume

__all__ = ["RenderOptions", "load_scene", "load_transfer", "save_scene", "stage_from_values"]

FORMAT = 1
SKIP = ("auto", "none", "blocks", "geometry")
Place = tuple[str | int, ...]
T = TypeVar("T")


class RenderOptions(TypedDict, total=False):
    """What the optional table ``[render]`` holds; the keyword arguments of ``airlight.render``."""

    size: tuple[int, int]
    driver: str | Stage
    step: float
    tolerance: float
    skip: str


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
        Options for the table ``[render]``: size, driver, step, tolerance, skip.
    embed
        Where volumes that came from no file are written, as NRRD; the second gets ``-2`` behind its name, and so on.

    Raises
    ------
    DataError
        When a volume came from no file and ``embed`` is not given, or a parameter is nothing that TOML can hold.
    ValueRangeError
        When ``render`` holds unknown options or wrong values.
    """
    import tomli_w

    from .io.paths import replacing

    path = Path(path)
    options = _plain(dict(render or {}), "render")
    _render_options(_Table(options, ("render",), ""))
    namer = _VolumeNamer(path.absolute().parent, None if embed is None else Path(embed))
    data: dict[str, Any] = {
        "format": FORMAT,
        "background": "none" if scene.background is None else list(scene.background),
        "camera": scene.camera if isinstance(scene.camera, str) else _stage_data(scene.camera),
        "lights": [_light_data(light) for light in scene.lights],
        "layers": [_layer_data(layer, f"layers[{n}]", namer) for n, layer in enumerate(scene.layers)],
    }
    if options:
        data["render"] = options
    with replacing(path) as temporary:
        temporary.write_text(_short_lists_in_line(tomli_w.dumps(data)), encoding="utf-8")


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
    from .io import open as open_volume

    path = Path(path)
    root = _parsed(path)
    folder = path.absolute().parent
    limits: dict[str, Any] = {"untrusted": untrusted, "progress": progress}
    if max_memory is not None:
        limits["max_memory"] = max_memory
    opened: dict[tuple[Any, ...], Volume] = {}

    def volume(table: _Table) -> Volume:
        """One object for one recipe: what lies on the device is found by identity."""
        recipe = {"file": table.take("file", str, None), **_recipe(table)}
        if not recipe["file"]:
            raise table.error("file", "is missing", "name a file")
        key = tuple(recipe.items())
        if key not in opened:
            file = os.path.abspath(folder / recipe.pop("file"))
            with table.located("file"):
                opened[key] = open_volume(file, **recipe, **limits)
        return opened[key]

    version = root.take("format", int, FORMAT)
    if version != FORMAT:
        raise root.error("format", f"is {version}, this version reads {FORMAT}", "use a newer airlight")
    background = root.take("background", str | tuple[float, float, float], (0.0, 0.0, 0.0))
    lights = [_light(table) for table in root.tables("lights")] if "lights" in root.data else None
    layers = [_layer(table, volume) for table in root.tables("layers")]
    camera = _camera(root)
    options = _render_options(root.table("render"))
    root.close()
    with root.located():
        none = background == "none"
        return Scene(layers=layers, camera=camera, lights=lights, background=None if none else background), options


def load_transfer(path: str | Path) -> TransferFunction:
    """Transfer function in a TOML or JSON file with ``points`` and, optionally, ``associated``."""
    path = Path(path)
    return _transfer(_parsed(path))


# -- stages by name, with values for their parameters


def stage_from_values(slot: str, name: str, values: Mapping[str, Any], where: str) -> Stage:
    """Return a stage made of plain values, each checked against the type of its parameter.

    ``where`` is the prefix of parameter names in messages. None, or ``"none"`` where no word is allowed, leaves a parameter
    to the stage.
    """
    if name not in STAGES[slot]:
        known = ", ".join(sorted(STAGES[slot]))
        raise ValueRangeError(
            where, f"is {name!r}, must be one of {known}", "stages of other packages need --plugin (al.register)"
        )
    cls: Any = STAGES[slot][name]
    hints = _hints(cls)
    fields = [f.name for f in stage_fields(cls)]
    checked = {}
    for key, value in values.items():
        if key not in fields:
            allowed = "it has " + (", ".join(fields) or "no parameters")
            raise ValueRangeError(f"{where}.{key}", f"is no parameter of {name}", allowed)
        checked[key] = checked_value(value, hints[key], f"{where}.{key}")
    stage: Stage = cls(**checked)
    return stage


def checked_value(value: Any, hint: Any, where: str) -> Any:
    """``value`` as the type of an annotation; whole numbers pass as floats, lists as tuples, ``"none"`` as None."""
    kinds = _alternatives(hint)
    if type(None) in kinds and (value is None or (value == "none" and str not in kinds)):
        return None
    for kind in kinds:
        try:
            return _as_kind(value, kind)
        except TypeError:
            continue
    raise ValueRangeError(where, f"is {value!r}, must be {' or '.join(describe_type(k) for k in kinds)}")


def describe_type(hint: Any) -> str:
    """Words for an annotation."""
    kinds = _alternatives(hint)
    if len(kinds) > 1:
        return " or ".join(describe_type(k) for k in kinds)
    kind = kinds[0]
    if get_origin(kind) is tuple:
        parts = get_args(kind)
        return "a list" if parts[-1] is Ellipsis else f"a list of {len(parts)}, each {describe_type(parts[0])}"
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "text", type(None): "none"}
    return words.get(kind, "a list of numbers" if kind is np.ndarray else getattr(kind, "__name__", str(kind)))


def _alternatives(hint: Any) -> tuple[Any, ...]:
    origin = get_origin(hint)
    if origin is Annotated:
        return _alternatives(get_args(hint)[0])
    if origin in (Union, types.UnionType):
        return tuple(kind for part in get_args(hint) for kind in _alternatives(part))
    return (np.ndarray if origin is np.ndarray else hint,)


def _as_kind(value: Any, kind: Any) -> Any:
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if kind is np.ndarray and isinstance(value, (list, tuple)):
        with contextlib.suppress(ValueError):
            return np.array(value, dtype=np.float64)
    if get_origin(kind) is tuple and isinstance(value, (list, tuple)):
        parts = get_args(kind)
        parts = parts[:1] * len(value) if parts[-1] is Ellipsis else parts
        if len(parts) == len(value):
            with contextlib.suppress(ValueRangeError):
                return tuple(checked_value(v, p, "") for v, p in zip(value, parts, strict=True))
    if (
        isinstance(kind, type)
        and kind is not float
        and isinstance(value, kind)
        and (kind is bool or not isinstance(value, bool))
    ):
        return value
    raise TypeError


@lru_cache(maxsize=256)
def _hints(cls: Any) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)


# -- from values to plain data


@dataclasses.dataclass
class _VolumeNamer:
    """Names volumes by file, relative to the scene's folder; writes those that have none."""

    folder: Path
    embed: Path | None
    written: dict[int, dict[str, Any]] = dataclasses.field(default_factory=dict)

    def __call__(self, volume: Volume, where: str) -> str | dict[str, Any]:
        data = self._embedded(volume, where) if volume.source is None else self._named(volume)
        return data["file"] if len(data) == 1 else data

    def _named(self, volume: Volume) -> dict[str, Any]:
        source = volume.source
        assert source is not None
        data: dict[str, Any] = {"file": self._relative(source.path)}
        data |= {"dataset": source.dataset} if source.dataset else {}
        data |= {"level": source.level} if source.level else {}
        return data | {key: _recipe_value(key, text) for key, text in source.options}

    def _embedded(self, volume: Volume, where: str) -> dict[str, Any]:
        from .io import save

        if id(volume) not in self.written:
            if self.embed is None:
                raise DataError(f"{where} came", "from no file", "give embed=PATH.nrrd to write it beside the scene")
            number = len(self.written) + 1
            path = self.embed.with_suffix(".nrrd")
            path = path if number == 1 else path.with_stem(f"{path.stem}-{number}")
            save(volume, path)
            self.written[id(volume)] = {"file": self._relative(str(path))}
        return self.written[id(volume)]

    def _relative(self, path: str) -> str:
        try:
            return Path(os.path.relpath(os.path.abspath(path), self.folder)).as_posix()
        except ValueError:  # another drive
            return Path(path).absolute().as_posix()


def _layer_data(layer: Layer, where: str, namer: _VolumeNamer) -> dict[str, Any]:
    data: dict[str, Any] = {"volume": namer(layer.volume, f"{where}.volume")}
    if layer.labels is not None:
        data["labels"] = namer(layer.labels, f"{where}.labels")
    data |= {"visible": layer.visible, "density": float(layer.density), "channel": layer.channel, "time": layer.time}
    if layer.transfer is not None:
        data["transfer"] = layer.transfer.to_dict()
    data["look"] = {slot: _stage_data(getattr(layer.look, slot)) for slot in Look.__dataclass_fields__}
    return data


def _stage_data(stage: Stage) -> dict[str, Any] | str:
    """Name and all parameters, so that the picture stays the same when a default changes; a name alone where there is none."""
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


def _light_data(light: Light) -> dict[str, Any]:
    data: dict[str, Any] = {"kind": light.kind}
    if light.kind != "head":
        data["to_light" if light.kind == "directional" else "position"] = _plain(light.vector, "light")
    data |= {"color": _plain(light.colour, "light"), "intensity": float(light.intensity)}
    return data | ({} if light.radius is None else {"radius": float(light.radius)})


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
        return _stage_data(value)
    raise DataError(where, f"is {value!r}", "a scene file holds numbers, words and lists")


def _short_lists_in_line(text: str) -> str:
    """Write vectors and control points on one line each; tomli_w gives every number a line of its own."""
    scalar = r"[^\[\]\n]*"
    for item in (scalar, rf"{scalar}(?:\[{scalar}\]{scalar})*"):
        text = re.sub(rf"\[\n(?: {item},\n)+ *\]", _in_line, text)
    return text


def _in_line(match: re.Match[str]) -> str:
    return "[" + ", ".join(re.split(r",\n *", match[0][1:-1].strip().removesuffix(","))) + "]"


# -- from plain data to values


@dataclasses.dataclass
class _Table:
    """A table of a TOML file whose keys are taken one by one; what is left in the end is unknown."""

    data: Mapping[str, Any]
    place: Place
    file: str
    text: str = ""
    taken: set[str] = dataclasses.field(default_factory=set)

    def where(self, key: str | None = None) -> str:
        place = (*self.place, key) if key is not None else self.place
        name = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in place).removeprefix(".")
        line = _line_of(self.text, place) if self.file else None
        prefix = f"{self.file}:{line}" if line else self.file
        return ": ".join(part for part in (prefix, name) if part)

    def error(self, key: str | None, what: str, remedy: str = "") -> ValueRangeError:
        return ValueRangeError(self.where(key), what, remedy)

    def take(self, key: str, hint: Any, default: Any) -> Any:
        self.taken.add(key)
        if key not in self.data:
            return default
        try:
            return checked_value(self.data[key], hint, key)
        except ValueRangeError as error:
            raise self.error(key, error.what) from None

    def table(self, key: str) -> _Table:
        self.taken.add(key)
        value = self.data.get(key, {})
        if not isinstance(value, dict):
            raise self.error(key, f"is {value!r}, must be a table")
        return _Table(value, (*self.place, key), self.file, self.text)

    def tables(self, key: str) -> list[_Table]:
        self.taken.add(key)
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            raise self.error(key, f"is {value!r}, must be a list of tables", f"write [[{key}]] for each")
        return [_Table(v, (*self.place, key, n), self.file, self.text) for n, v in enumerate(value)]

    def close(self) -> None:
        for key in self.data:
            if key not in self.taken:
                raise self.error(key, "is unknown", f"known here: {', '.join(sorted(self.taken)) or 'nothing'}")

    @contextlib.contextmanager
    def located(self, key: str | None = None) -> Iterator[None]:
        """Put file, line and key in front of what a value says of itself."""
        try:
            yield
        except AirlightError as error:
            raise type(error)(f"{self.where(key)}: {error.where}", error.what, error.remedy) from error
        except (TypeError, ValueError, AttributeError) as error:
            raise self.error(key, f"has a wrong value ({error})") from error


def _parsed(path: Path) -> _Table:
    try:
        text = path.read_text(encoding="utf-8")
        if path.suffix.lower() == ".json":
            import json

            data = json.loads(text)
        else:
            import tomllib

            data = tomllib.loads(text)
    except OSError as error:
        raise FileError(str(path), f"cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:  # also what tomllib and json raise, with the line in it
        raise FileError(str(path), f"is no sound file ({error})") from error
    if not isinstance(data, dict):
        raise FileError(str(path), f"holds {type(data).__name__}, must be a table")
    return _Table(data, (), str(path), text)


def _layer(table: _Table, volume: Callable[[_Table], Volume]) -> Layer:
    volumes = {}
    for key in ("volume", "labels"):
        if isinstance(table.data.get(key), str):
            table.taken.add(key)
            volumes[key] = volume(_Table({"file": table.data[key]}, (*table.place, key), table.file, table.text))
        elif key in table.data:
            inner = table.table(key)
            volumes[key] = volume(inner)
            inner.close()
    if "volume" not in volumes:
        raise table.error("volume", "is missing", "name a file")
    look = table.table("look")
    chosen = {slot: _stage(look, slot, slot) for slot in Look.__dataclass_fields__ if slot in look.data}
    look.taken |= set(Look.__dataclass_fields__)
    look.close()
    function = _transfer(table.table("transfer")) if "transfer" in table.data else None
    visible, density = table.take("visible", bool, True), table.take("density", float, 1.0)
    channel, time = table.take("channel", int | str, 0), table.take("time", int, 0)
    table.taken |= {"volume", "labels", "transfer"}
    table.close()
    with table.located():
        return Layer(volumes["volume"], function, Look(**chosen), volumes.get("labels"), visible, density, channel, time)


def _transfer(table: _Table) -> TransferFunction:
    table.taken |= {"points", "associated"}
    table.close()
    associated = table.take("associated", bool, False)
    points = table.data.get("points", [])
    if not isinstance(points, list) or not all(isinstance(p, list) for p in points):
        raise table.error("points", f"is {points!r}", "write [[value, colour, extinction], ...]")
    with table.located("points"):
        return TransferFunction([tuple(p) for p in points], associated)


def _stage(table: _Table, key: str, slot: str) -> Stage:
    table.taken.add(key)
    value = table.data[key]
    if not isinstance(value, (str, dict)) or (isinstance(value, dict) and not isinstance(value.get("name"), str)):
        raise table.error(
            key, f"is {value!r}, must be a name or a table with a name", 'e.g. { name = "blinn_phong", ambient = 0.2 }'
        )
    name, values = (value, {}) if isinstance(value, str) else (value["name"], {k: v for k, v in value.items() if k != "name"})
    with table.located(key):
        return stage_from_values(slot, name, values, slot)


def _camera(root: _Table) -> Camera | str:
    root.taken.add("camera")
    value = root.data.get("camera", "front")
    if isinstance(value, str):
        if value not in VIEWS:
            raise root.error("camera", f"is {value!r}, must be a table or one of {', '.join(VIEWS)}")
        return value
    camera = _stage(root, "camera", "camera")
    assert isinstance(camera, Camera)
    return camera


def _light(table: _Table) -> Light:
    kind = table.take("kind", str, None)
    if kind not in ("head", "directional", "point"):
        raise table.error("kind", f"is {kind!r}, must be one of head, directional, point")
    common: dict[str, Any] = {
        "color": table.take("color", str | tuple[float, float, float], (1.0, 1.0, 1.0)),
        "intensity": table.take("intensity", float, 1.0),
    }
    vector = tuple[float, float, float]
    with table.located():
        if kind == "head":
            light = Light.head(**common)
        elif kind == "point":
            position, radius = table.take("position", vector, None), table.take("radius", float | None, None)
            light = Light.point(position=position, radius=radius, **common)
        else:
            to_light = table.take("to_light", vector, None)
            light = Light.directional(to_light=to_light, **common)
            if abs(math.hypot(*to_light) - 1) < 1e-14:  # so that a saved light loads back equal
                light = dataclasses.replace(light, vector=to_light)
    table.close()
    return light


def _render_options(table: _Table) -> RenderOptions:
    options = RenderOptions()
    hints: dict[str, Any] = {"size": tuple[int, int], "step": float, "tolerance": float, "skip": str}
    for key, hint in hints.items():
        if key not in table.data:
            continue
        value = table.take(key, hint, None)
        if key == "skip" and value not in SKIP:
            raise table.error(key, f"is {value!r}, must be one of {', '.join(SKIP)}")
        if key == "size" and min(value) < 1:
            raise table.error(key, f"is {value}, must be two whole numbers of at least 1")
        if key in ("step", "tolerance") and not (math.isfinite(value) and value > 0):
            raise table.error(key, f"is {value}, must be finite and above 0")
        options[key] = value  # type: ignore[literal-required]
    if "driver" in table.data:
        driver = _stage(table, "driver", "driver")
        name = table.data["driver"]
        options["driver"] = name if isinstance(name, str) else driver
    table.taken |= {*hints, "driver"}
    table.close()
    return options


# -- how raw files are read: text in Source.options, typed in TOML

RECIPE: dict[str, Any] = {
    "dataset": str,
    "level": int,
    "shape": tuple[int, ...],
    "dtype": str,
    "spacing": tuple[float, float, float],
    "offset": int,
    "big_endian": bool,
}


def _recipe(table: _Table) -> dict[str, Any]:
    return {key: table.take(key, hint, None) for key, hint in RECIPE.items() if key in table.data}


def _recipe_value(key: str, text: str) -> Any:
    hint = RECIPE.get(key, str)
    if get_origin(hint) is tuple:
        return [get_args(hint)[0](word) for word in text.split()]
    return text == "true" if hint is bool else hint(text)


# -- lines, for messages

_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]")
_KEY = re.compile(r"\s*([^\s=#\[\]{}][^=#\[\]{}]*)=")


def _line_of(text: str, place: Place) -> int | None:
    """Line of a key, or of the innermost table or key round it that has one; a scan that knows no multi-line strings."""
    counts: dict[tuple[str, ...], int] = {}
    table: Place = ()
    best: tuple[int, int | None] = (0, None)
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            names = _names(header[2])
            if header[1] == "[[":
                counts[names] = counts.get(names, -1) + 1
            table = ()
            for n, name in enumerate(names, start=1):
                table += (name, counts[names[:n]]) if names[:n] in counts else (name,)
            here = table
        elif key := _KEY.match(line):
            here = table + _names(key[1])
        else:
            continue
        if place[: len(here)] == here and len(here) > best[0]:
            best = (len(here), number)
    return best[1]


def _names(dotted: str) -> tuple[str, ...]:
    return tuple(name.strip().strip("\"'") for name in dotted.split("."))
