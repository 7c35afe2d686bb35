"""What a scene file may say of how it is drawn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, TypedDict, get_args, get_origin

from ..environment import Environment, Opener
from ..environment.reading import ENDINGS
from ..stage import Stage
from .table import Table
from .values import stage_from_values

FORMAT = 1
SKIP = ("auto", "none", "blocks", "geometry")
RECIPE: dict[str, Any] = {
    "dataset": str,
    "level": int,
    "shape": tuple[int, ...],
    "dtype": str,
    "spacing": tuple[float, float, float],
    "offset": int,
    "big_endian": bool,
}


class RenderOptions(TypedDict, total=False):
    """What the optional table ``[render]`` holds; the keyword arguments of ``airlight.render``."""

    size: tuple[int, int]
    driver: str | Stage
    step: float
    tolerance: float
    skip: str
    passes: tuple[Stage, ...]


def checked_options(table: Table, opened: Opener = Environment.open) -> RenderOptions:
    """Options of the ``[render]`` table, checked; ``opened`` opens pictures of environments."""
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
        driver = stage_in(table, "driver", "driver", opened)
        name = table.data["driver"]
        options["driver"] = name if isinstance(name, str) else driver
    if "passes" in table.data:
        options["passes"] = passes_in(table, opened)
    table.taken |= {*hints, "driver", "passes"}
    table.close()
    return options


def passes_in(table: Table, opened: Opener = Environment.open) -> tuple[Stage, ...]:
    """Passes over the finished picture, each a name or a table."""
    given = table.data["passes"]
    if not isinstance(given, list):
        raise table.error("passes", f"is {given!r}, must be a list of names and tables", 'e.g. ["bounding_box"]')
    alone = (Table({"passes": one}, table.place, table.file, table.text) for one in given)
    return tuple(stage_in(one, "passes", "passes", opened) for one in alone)


def recipe_of(table: Table) -> dict[str, Any]:
    """What a table says of how its file is to be read."""
    return {key: table.take(key, hint, None) for key, hint in RECIPE.items() if key in table.data}


def recipe_value(key: str, text: str) -> Any:
    """Value of what a reader noted as text."""
    hint = RECIPE.get(key, str)
    if get_origin(hint) is tuple:
        return [get_args(hint)[0](word) for word in text.split()]
    return text == "true" if hint is bool else hint(text)


def placed(value: Any, table: Table) -> Any:
    """Return a value with the picture that it names, if it is a name or a table that does, relative to the scene's folder.

    In plain data of no file it stays, for whoever opens it.
    """
    if not table.file:
        return value
    if isinstance(value, dict) and isinstance(value.get("file"), str):
        return value | {"file": str(Path(table.file).absolute().parent / value["file"])}
    if isinstance(value, str) and value.lower().endswith(ENDINGS):
        return str(Path(table.file).absolute().parent / value)
    return value


def stage_in(table: Table, key: str, slot: str, opened: Opener = Environment.open) -> Stage:
    """Stage that a table names, with its parameters; ``opened`` opens pictures of environments."""
    table.taken.add(key)
    value = table.data[key]
    if not isinstance(value, (str, dict)) or (isinstance(value, dict) and not isinstance(value.get("name"), str)):
        raise table.error(
            key, f"is {value!r}, must be a name or a table with a name", 'e.g. { name = "blinn_phong", ambient = 0.2 }'
        )
    name, values = (value, {}) if isinstance(value, str) else (value["name"], {k: v for k, v in value.items() if k != "name"})
    values = {key: placed(value, table) for key, value in values.items()}
    with table.located(key):
        return stage_from_values(slot, name, values, slot, opened)
