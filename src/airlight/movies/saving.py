"""Keyframes in TOML and JSON: a list beside a scene, or a file of its own that names one."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ..errors import AirlightError, FileError, ValueRangeError
from ..files import line_of, place_of, read_table, write_table, write_text
from .keys import Keyframes, keyframes_from

OWN = {"format", "scene", "keyframes"}


def load_keyframes(path: str | os.PathLike[str]) -> Keyframes:
    """Read the list ``keyframes`` of a TOML or JSON file, whatever else is in it.

    Raises
    ------
    FileError
        When the file is missing, not sound, or has no such list.
    ValueRangeError
        For what is wrong in it; the message names the line.
    """
    found, _ = scene_beside(path)
    if found is None:
        raise FileError(os.fspath(path), "has no keyframes", "write [[keyframes]] for each, with time_s and what differs")
    return found


def scene_beside(path: str | os.PathLike[str]) -> tuple[Keyframes | None, str]:
    """Return the keyframes of a file, None where there are none, and the path of their scene: the file itself, or another.

    Raises
    ------
    FileError, ValueRangeError
        As ``load_keyframes``.
    """
    file = Path(path)
    data, text = read_table(file)
    scene = str(file)
    if isinstance(data.get("scene"), str):
        for name in data:
            if name not in OWN:
                raise ValueRangeError(f"{file}: {name}", "is unknown beside scene", f"known here: {', '.join(sorted(OWN))}")
        scene = os.path.join(file.absolute().parent, data["scene"])
    if "keyframes" not in data:
        return None, scene
    tables = data["keyframes"]
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise ValueRangeError(f"{file}: keyframes", "must be a list of tables", "write [[keyframes]] for each")
    try:
        return keyframes_from(tables), scene
    except AirlightError as error:
        line = line_of(text, place_of("file." + error.where.replace("]: keyframe.", "].")))
        raise type(error)(
            f"{file}:{line}: {error.where}" if line else f"{file}: {error.where}", error.what, error.remedy
        ) from None


def keyframes_and_scene(what: Any, keyframes: Any, *, alone: bool) -> tuple[Any, str, Any]:
    """Return keyframes, the folder in which files that they name lie, and what they change.

    Parameters
    ----------
    what
        What a movie is made of. A file with keyframes stands for its scene, and has a say where nothing else is asked for.
    keyframes
        Keyframes, a file of them, or None.
    alone
        Whether nothing but keyframes was asked for.
    """
    folder = "."
    if isinstance(keyframes, (str, os.PathLike)):
        folder, keyframes = os.path.dirname(os.path.abspath(keyframes)), load_keyframes(keyframes)
    if isinstance(what, (str, os.PathLike)) and os.fspath(what).lower().endswith((".toml", ".json")):
        own, scene = scene_beside(what)
        if own is not None and keyframes is None and alone:
            folder, keyframes = os.path.dirname(os.path.abspath(what)), own
        what = scene
    return keyframes, folder, what


def save_keyframes(keyframes: Keyframes, path: str | os.PathLike[str], *, scene: str | os.PathLike[str] | None = None) -> None:
    """Write keyframes to a ``.toml`` or ``.json`` file that appears whole or not at all.

    Parameters
    ----------
    keyframes
        What is written.
    path
        The file.
    scene
        Scene file, or volume, that they are keys of; the file names it, relative to itself, and ``airlight movie`` takes it.

    Raises
    ------
    FileError
        For other endings, and when it cannot be written.
    """
    file = Path(path)
    data: dict[str, Any] = {"format": 1}
    if scene is not None:
        data["scene"] = Path(os.path.relpath(os.path.abspath(scene), file.absolute().parent)).as_posix()
    data["keyframes"] = [key.to_dict() for key in keyframes.keys]
    if file.suffix.lower() == ".toml":
        write_table(file, data)
    elif file.suffix.lower() == ".json":
        write_text(file, json.dumps(data, indent=1) + "\n")
    else:
        raise FileError(str(file), "has no ending that says what to write", "use .toml or .json")
