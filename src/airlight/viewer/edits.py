"""Edits of plain data: set, insert and remove what a path of keys and numbers names; nothing is changed in place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import ValueRangeError

MOST_OPS = 256
MOST_DEPTH = 16


def applied(data: Any, ops: Any) -> Any:
    """Return plain data after edits.

    Parameters
    ----------
    data
        Tables, lists, numbers and words.
    ops
        Edits, each ``{"op": "set" | "insert" | "remove", "path": [key or number, ...], "value": ...}``. In a list ``set``
        takes the place of an entry, ``insert`` goes before it, at the end too; in a table ``set`` makes missing keys.

    Raises
    ------
    ValueRangeError
        Names the path that is not there, or what is wrong with the edit.
    """
    if not isinstance(ops, Sequence) or isinstance(ops, (str, bytes)) or not 0 < len(ops) <= MOST_OPS:
        raise ValueRangeError("edit.ops", f"must be a list of 1 to {MOST_OPS} edits")
    for op in ops:
        if not isinstance(op, Mapping) or op.get("op") not in ("set", "insert", "remove"):
            raise ValueRangeError("edit.op", f"is {op!r:.80}", "must be set, insert or remove, with a path")
        path = op.get("path")
        if not isinstance(path, Sequence) or isinstance(path, (str, bytes)) or not 0 < len(path) <= MOST_DEPTH:
            raise ValueRangeError("edit.path", f"must be a list of 1 to {MOST_DEPTH} keys and numbers")
        data = _changed(data, tuple(path), op, ())
    return data


def _changed(data: Any, path: tuple[Any, ...], op: Mapping[str, Any], before: tuple[Any, ...]) -> Any:
    key, rest = path[0], path[1:]
    if isinstance(data, Mapping) and isinstance(key, str):
        return _in_table(data, key, rest, op, before)
    if isinstance(data, Sequence) and not isinstance(data, str) and isinstance(key, int) and not isinstance(key, bool):
        return _in_list(data, key, rest, op, before)
    raise ValueRangeError(_named((*before, key)), "is not there")


def _in_table(data: Mapping[str, Any], key: str, rest: tuple[Any, ...], op: Mapping[str, Any], before: tuple[Any, ...]) -> Any:
    if rest:
        if key not in data and not isinstance(rest[0], str):
            raise ValueRangeError(_named((*before, key)), "is not there")
        return {**data, key: _changed(data.get(key, {}), rest, op, (*before, key))}
    if op["op"] == "remove":
        return {name: value for name, value in data.items() if name != key}
    return {**data, key: op.get("value")}


def _in_list(data: Sequence[Any], place: int, rest: tuple[Any, ...], op: Mapping[str, Any], before: tuple[Any, ...]) -> Any:
    end = len(data) if op["op"] == "insert" and not rest else len(data) - 1
    if not 0 <= place <= end:
        raise ValueRangeError(_named((*before, place)), "is not there", f"the list has {len(data)} entries")
    if rest:
        return [*data[:place], _changed(data[place], rest, op, (*before, place)), *data[place + 1 :]]
    value = [] if op["op"] == "remove" else [op.get("value")]
    return [*data[:place], *value, *data[place + (op["op"] != "insert") :]]


def _named(path: tuple[Any, ...]) -> str:
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path).removeprefix(".")
