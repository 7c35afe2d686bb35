"""Keyframes: what differs from a scene at some times, and the scenes between them."""

from __future__ import annotations

import dataclasses
import itertools
import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import AirlightError, DataError, ValueRangeError
from ..first_picture import resolve, resolved_camera
from ..scene import Scene
from ..scene_file.held import FilesByPath, Held
from ..stage import Stage
from ..stages.camera import Camera
from ..transfer.given import listed, not_negative, set_fields
from .between import EASINGS, between, camera_between
from .turning import check_easing

OWN = ("time_s", "easing")
PATH = re.compile(r"\w+(?:\.\w+|\[\d+\])*")
LAYER = re.compile(r"layers\[\d+\]")
PART = re.compile(r"\[(\d+)\]|(\w+)")


@dataclass(frozen=True)
class Keyframe:
    """What differs from the scene at one time.

    Parameters
    ----------
    time_s
        Seconds from the beginning of the movie.
    changes
        Values by their path in a scene file: ``{"layers[0].density": 0.5, "camera": "iso"}``, as plain data or as values of
        airlight. Each takes the place of what the scene has; a table of a camera without its name keeps the rest of it. What
        is not named is as in the scene, whatever other keys say.
    easing
        How the way to the next key is gone: ``"smooth"``, beginning and ending at rest, or ``"linear"``.
    """

    time_s: float
    changes: Mapping[str, Any] = field(default_factory=dict)
    easing: str = "smooth"

    def __post_init__(self) -> None:
        """Check the values."""
        set_fields(self, time_s=not_negative(self.time_s, "keyframe.time_s"))
        check_easing(self.easing, "keyframe.easing")
        if not isinstance(self.changes, Mapping):
            raise ValueRangeError("keyframe.changes", f"is {self.changes!r}", 'give a table, e.g. {"camera": "iso"}')
        for path in self.changes:
            if not PATH.fullmatch(str(path)):
                raise ValueRangeError("keyframe", f"names {path!r}", 'write paths as in "layers[0].look.shade.ambient"')
        set_fields(self, changes={str(path): _plain(value) for path, value in self.changes.items()})

    def to_dict(self) -> dict[str, Any]:
        """Return plain data: the time, the easing, and the changes by their paths."""
        return {"time_s": self.time_s, "easing": self.easing, **self.changes}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Keyframe:
        """Return the key that ``to_dict`` wrote, or a person.

        Raises
        ------
        ValueRangeError
            Without a time, and for what is wrong in it.
        """
        if "time_s" not in data:
            raise ValueRangeError("keyframe.time_s", "is missing", "give seconds from the beginning")
        own = {name: data[name] for name in OWN if name in data}
        return Keyframe(changes={path: value for path, value in data.items() if path not in OWN}, **own)


@dataclass(frozen=True)
class Keyframes:
    """Keys in the order of their times; also given as pairs of a time and changes."""

    keys: tuple[Keyframe, ...]

    def __post_init__(self) -> None:
        """Make keys of pairs, and check that their times rise."""
        given = listed(self.keys, "keyframes", 'pass a list, e.g. [(0, {}), (2, {"camera": "iso"})]')
        keys = tuple(_key(key, n) for n, key in enumerate(given))
        if not keys:
            raise ValueRangeError("keyframes", "has no keys", 'pass a list, e.g. [(0, {}), (2, {"camera": "iso"})]')
        for n, (before, after) in enumerate(itertools.pairwise(keys), start=1):
            if after.time_s <= before.time_s:
                what = f"is {after.time_s:g}, and the key before it has {before.time_s:g}"
                raise ValueRangeError(f"keyframes[{n}].time_s", what, "put keys in the order of their times")
        set_fields(self, keys=keys)

    @property
    def duration_s(self) -> float:
        """Time of the last key."""
        return self.keys[-1].time_s

    def of(self, scene: Scene, size_px: tuple[int, int] = (512, 512), folder: str | Path = ".") -> Course:
        """Return what the keys make of a scene.

        Parameters
        ----------
        scene
            What the keys change.
        size_px
            Size for which the cameras of named views are fitted.
        folder
            Where files that keys name lie.

        Raises
        ------
        AirlightError
            For changes that the scene does not have or that are out of range, and for neighbours between which there is no
            way; it names the key and the path.
        """
        held = _held(folder)
        base = resolve(scene, size_px)
        plain = _whole(held.plain(base))
        stops = []
        for n, key in enumerate(self.keys):
            with _located(f"keyframes[{n}]"):
                changed = held.scene(_with_changes(plain, key.changes), plain, base)
                changed = dataclasses.replace(changed, camera=resolved_camera(changed, size_px))
                stops.append(Stop(key, changed, _whole(held.plain(changed))))
        course = Course(tuple(stops), held)
        for n, (before, after) in enumerate(itertools.pairwise(stops)):
            with _located(f"keyframes[{n}] to keyframes[{n + 1}]"):
                course.at((before.key.time_s + after.key.time_s) / 2)
        return course


@dataclass(frozen=True)
class Stop:
    """A key with its whole scene, as a value and as plain data."""

    key: Keyframe
    scene: Scene
    plain: Mapping[str, Any]

    @property
    def camera(self) -> Camera:
        """The scene's camera; the names of views are resolved here."""
        assert isinstance(self.scene.camera, Camera)
        return self.scene.camera


@dataclass(frozen=True)
class Course:
    """Scenes at all times, between the stops of keys."""

    stops: tuple[Stop, ...]
    held: Held

    def at(self, time_s: float) -> Scene:
        """Return the scene at a time: a key's own at its time, the first's before it and the last's behind it."""
        n = bisect_right(self.stops, time_s, key=lambda stop: stop.key.time_s)
        before = self.stops[max(n - 1, 0)]
        if n in (0, len(self.stops)) or before.key.time_s == time_s:
            return before.scene
        after = self.stops[n]
        share = EASINGS[before.key.easing]((time_s - before.key.time_s) / (after.key.time_s - before.key.time_s))
        # Cameras are blended below, as values.
        plain = between(before.plain, {**after.plain, "camera": before.plain["camera"]}, share)
        scene = self.held.scene(plain, before.plain, before.scene)
        return dataclasses.replace(scene, camera=camera_between(before.camera, after.camera, share))


def changes_of(scene: Scene, base: Scene, size_px: tuple[int, int] = (512, 512)) -> dict[str, Any]:
    """Return the changes that make one scene of another: what a key of it holds.

    Parameters
    ----------
    scene
        What a key is to show.
    base
        What it is a change of; both must have the same volumes.
    size_px
        Size for which the cameras of named views are fitted.

    Raises
    ------
    DataError
        When the scenes have other volumes, labels or meshes.
    """
    held = _held()
    first, second = (_whole(held.plain(resolve(one, size_px)), held) for one in (base, scene))
    return dict(_differences(first, second, ""))


def _held(folder: str | Path = ".") -> Held:
    return Held(FilesByPath(folder), "keys change what the scene has; make two movies")


def _whole(plain: dict[str, Any], held: Held | None = None) -> dict[str, Any]:
    """Plain data with empty lists where they may be left out, so that all scenes have them; with names where all are held."""
    layers = plain["layers"] if held is None else [held.in_full(layer) for layer in plain["layers"]]
    return {"clips": [], "annotations": [], **plain, "layers": [{"clips": [], **layer} for layer in layers]}


def _differences(first: Any, second: Any, path: str) -> Iterator[tuple[str, Any]]:
    if first == second:
        return
    tables, lists = (all(isinstance(one, kind) for one in (first, second)) for kind in (dict, list))
    alike = tables and list(first) == list(second) and all(first[name] == second[name] for name in _kinds(second))
    if path.endswith(".labels") and _volume_of(first) == _volume_of(second):
        yield path, second
        return
    whole = path in ("", "layers", "meshes") or LAYER.fullmatch(path)
    if path.endswith((".volume", ".labels")) or (whole and not (alike or _as_many(first, second))):
        raise DataError(path or "scene", "holds other volumes or meshes", "keys change how they are shown; make two movies")
    if tables and "held" in second and not alike:
        raise DataError(path, "is another mesh", "keys change how meshes are shown; make two movies")
    if alike and path != "camera":
        for name in second:
            yield from _differences(first[name], second[name], f"{path}.{name}".removeprefix("."))
    elif lists and len(first) == len(second) and any(isinstance(part, dict) for part in second):
        for n, parts in enumerate(zip(first, second, strict=True)):
            yield from _differences(*parts, f"{path}[{n}]")
    else:
        yield path, second


def _volume_of(labels: Any) -> Any:
    return labels["volume"] if isinstance(labels, Mapping) else labels


def _as_many(first: Any, second: Any) -> bool:
    return isinstance(first, list) and isinstance(second, list) and len(first) == len(second)


def _kinds(table: Mapping[str, Any]) -> list[str]:
    return [name for name in ("name", "kind", "held") if name in table]


def _key(given: Any, n: int) -> Keyframe:
    """Return a key, or one of a pair."""
    if isinstance(given, Keyframe):
        return given
    with _located(f"keyframes[{n}]"):
        if not isinstance(given, (tuple, list)) or not 1 <= len(given) <= 3:
            raise ValueRangeError("keyframe", f"is {given!r}", "give a Keyframe, or its time and changes")
        return Keyframe(*given)


def checked_keyframes(given: Any) -> Keyframes:
    """Return keyframes as they are, or those of a list."""
    return given if isinstance(given, Keyframes) else Keyframes(given)


def keyframes_from(tables: Iterable[Mapping[str, Any]]) -> Keyframes:
    """Return the keyframes of the tables of a file."""
    keys = []
    for n, table in enumerate(tables):
        with _located(f"keyframes[{n}]"):
            keys.append(Keyframe.from_dict(table))
    return Keyframes(tuple(keys))


@contextmanager
def _located(where: str) -> Iterator[None]:
    """Put the key in front of what is wrong with it."""
    try:
        yield
    except AirlightError as error:
        raise type(error)(f"{where}: {error.where}", error.what, error.remedy) from error


# -- plain data


def _with_changes(plain: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    for path, value in changes.items():
        parts = [int(number) if number else name for number, name in PART.findall(path)]
        if parts[-1] in ("layers", "volume"):
            raise ValueRangeError(path, "holds data, which keys do not change", "make two movies")
        plain = _with(plain, parts, value, path)
    return dict(plain)


def _with(plain: Any, parts: list[str | int], value: Any, path: str) -> Any:
    """Return plain data with one entry changed; a table may get a new one, and whoever reads it will know its name."""
    part, rest = parts[0], parts[1:]
    if isinstance(part, int) and isinstance(plain, list) and part < len(plain):
        return [*plain[:part], _with(plain[part], rest, value, path) if rest else value, *plain[part + 1 :]]
    if isinstance(part, str) and isinstance(plain, Mapping) and (part in plain or not rest):
        if not rest and path == "camera" and isinstance(value, Mapping) and "name" not in value:
            value = {**plain[part], **value}
        return {**plain, part: _with(plain[part], rest, value, path) if rest else value}
    known = f"known here: {', '.join(plain)}" if isinstance(plain, Mapping) else ""
    if isinstance(plain, list):
        known = f"there are {len(plain)}, counted from 0"
    raise ValueRangeError(path, "is not in the scene", known)


def _plain(value: Any) -> Any:
    """Plain data of a value of airlight, of arrays and tuples."""
    from ..scene_file.writing import plain_stage

    if isinstance(value, Stage):
        return plain_stage(value)
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(name): _plain(part) for name, part in value.items()}
    return [_plain(part) for part in value] if isinstance(value, (list, tuple)) else value
