"""Values of plain data, checked against the types of what they are for."""

from __future__ import annotations

import contextlib
import types
from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from ..environment import Environment, Opener
from ..errors import ValueRangeError
from ..stage import STAGES, Stage, stage_fields

ENVIRONMENT = 'studio, sky, white, the name of a picture, or a table like { kind = "sky", turbidity = 4 }'

# -- stages by name, with values for their parameters


def stage_from_values(slot: str, name: str, values: Mapping[str, Any], where: str, opened: Opener = Environment.open) -> Stage:
    """Return a stage made of plain values, each checked against the type of its parameter.

    ``where`` is the prefix of parameter names in messages; ``opened`` opens pictures of environments. None, or ``"none"``
    where no word is allowed, leaves a parameter to the stage.
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
        checked[key] = checked_value(value, hints[key], f"{where}.{key}", opened)
    stage: Stage = cls(**checked)
    return stage


def checked_value(value: Any, hint: Any, where: str, opened: Opener = Environment.open) -> Any:
    """``value`` as the type of an annotation; whole numbers pass as floats, lists as tuples, ``"none"`` as None."""
    kinds = _alternatives(hint)
    if type(None) in kinds and (value is None or (value == "none" and str not in kinds)):
        return None
    for kind in kinds:
        try:
            return _as_kind(value, kind, opened)
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
    if kind is Environment:
        return ENVIRONMENT
    if isinstance(kind, type) and issubclass(kind, Stage):
        return f"one of {', '.join(sorted(STAGES[kind.slot]))}, with parameters in a table"
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "text", type(None): "none"}
    return words.get(kind, "a list of numbers" if kind is np.ndarray else getattr(kind, "__name__", str(kind)))


def _alternatives(hint: Any) -> tuple[Any, ...]:
    origin = get_origin(hint)
    if origin is Annotated:
        return _alternatives(get_args(hint)[0])
    if origin in (Union, types.UnionType):
        return tuple(kind for part in get_args(hint) for kind in _alternatives(part))
    return (np.ndarray if origin is np.ndarray else hint,)


def _as_kind(value: Any, kind: Any, opened: Opener) -> Any:
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if kind is Environment and isinstance(value, (str, dict)):
        return Environment.named(value, opened) if isinstance(value, str) else Environment.from_dict(value, opened)
    if isinstance(kind, type) and issubclass(kind, Stage) and isinstance(value, (str, dict)):
        given = {"name": value} if isinstance(value, str) else dict(value)
        return stage_from_values(kind.slot, given.pop("name", ""), given, kind.slot, opened)
    if kind is np.ndarray and isinstance(value, (list, tuple)):
        with contextlib.suppress(ValueError):
            return np.array(value, dtype=np.float64)
    if get_origin(kind) is tuple and isinstance(value, (list, tuple)):
        parts = get_args(kind)
        parts = parts[:1] * len(value) if parts[-1] is Ellipsis else parts
        if len(parts) == len(value):
            with contextlib.suppress(ValueRangeError):
                return tuple(checked_value(v, p, "", opened) for v, p in zip(value, parts, strict=True))
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
