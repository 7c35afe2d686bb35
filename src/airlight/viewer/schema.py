"""What panels are built from: slots, stages and their parameters, presets and bindings, as plain data."""

from __future__ import annotations

import dataclasses
import types
from typing import Annotated, Any, Union, get_args, get_origin

from .. import stages as _stages  # noqa: F401  (makes the names of the stages known)
from ..environment import Environment
from ..scene import VIEWS, Look
from ..stage import SLOTS, STAGES, Stage, stage_fields, summary_of, type_hints
from ..transfer import presets
from .gestures import BINDINGS


def schema() -> dict[str, Any]:
    """Return all slots with their stages, presets by name, views and bindings of gestures."""
    return {
        "slots": {name: {"help": slot.help, "look": name in Look.__dataclass_fields__} for name, slot in SLOTS.items()},
        "stages": {slot: {name: _stage(cls) for name, cls in sorted(found.items())} for slot, found in STAGES.items()},
        "presets": list(presets.names()),
        "views": list(VIEWS),
        "bindings": list(BINDINGS),
    }


def _stage(cls: type[Stage]) -> dict[str, Any]:
    """A stage's meaning and its parameters."""
    hints = type_hints(cls)
    summary = summary_of(cls).replace("``", "")
    return {"help": summary, "parameters": [_parameter(field, hints[field.name]) for field in stage_fields(cls)]}


def _parameter(field: dataclasses.Field[Any], hint: Any) -> dict[str, Any]:
    """Name, kind, default, unit, bounds and meaning of a parameter; no bound is left out."""
    kind, optional = _kind(hint)
    bounds = field.metadata["bounds"]
    told = {name: found for name in ("above", "at_least", "below", "up_to") if (found := getattr(bounds, name)) is not None}
    told |= {"choices": list(bounds.choices)} if bounds.choices else {}
    told |= {"unit": field.metadata["unit"]} if field.metadata["unit"] not in ("", "1") else {}
    default = field.default
    default = default.name if isinstance(default, Stage) else list(default) if isinstance(default, tuple) else default
    plain = default if isinstance(default, (bool, int, float, str, list, type(None))) else None
    return {"name": field.name, "kind": kind, "optional": optional, "default": plain, "help": field.metadata["help"]} | told


def _kind(hint: Any) -> tuple[str, bool]:
    """What a parameter is, and whether it may be none.

    It is one of ``bool``, ``int``, ``float``, ``text``, ``vec2`` to ``vec4``, ``numbers``, ``stage:SLOT``, ``environment``,
    ``value``.
    """
    if get_origin(hint) is Annotated:
        inner, note = get_args(hint)[:2]
        if inner is bool:
            return "bool", False
        if isinstance(note, str) and note.startswith("vec"):
            return note[:4], False
        hint = inner
    if get_origin(hint) in (Union, types.UnionType):
        parts = [part for part in get_args(hint) if part is not type(None)]
        return _kind(parts[0])[0], len(parts) < len(get_args(hint))
    if isinstance(hint, type) and issubclass(hint, Stage):
        return f"stage:{hint.slot}", False
    names = {bool: "bool", int: "int", float: "float", str: "text", Environment: "environment"}
    return names.get(hint, "numbers" if get_origin(hint) is tuple else "value"), False
