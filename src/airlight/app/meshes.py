"""``--mesh`` and ``--box``, made into values."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from ..errors import ValueRangeError
from ..geometry import Lines, Mesh
from ..geometry.saving import from_text
from ..scene import Layer
from ..transfer import linear_rgb
from .parse import assignments

OPTION = "--mesh"


def parse_mesh(text: str) -> tuple[str, dict[str, Any]]:
    """File and options of ``skull.stl:color=ivory,opacity=0.5``."""
    return file_and_options(text, OPTION, "skull.stl:color=ivory,opacity=0.5")


def file_and_options(text: str, option: str, example: str) -> tuple[str, dict[str, Any]]:
    """File and options of a text like an example."""
    match = re.fullmatch(r"(.+?)(?::(\w+=.*))?", text.strip())
    if not match:
        raise ValueRangeError(option, f"is {text!r}, must name a file", f"e.g. {option} {example}")
    return match[1], assignments(match[2], option) if match[2] else {}


def open_meshes(parsed: Iterable[tuple[str, dict[str, Any]]]) -> tuple[Mesh, ...]:
    """Meshes of files."""
    return tuple(_opened(*one) for one in parsed)


def _opened(name: str, options: dict[str, Any]) -> Mesh:
    try:
        return from_text(name, options)
    except ValueRangeError as error:
        raise ValueRangeError(OPTION + error.where.removeprefix("mesh"), error.what, error.remedy) from None


def boxes(layers: Sequence[Layer], colour: str) -> tuple[Lines, ...]:
    """Edges of the boxes of visible layers."""
    rgb = linear_rgb(colour, "--box")
    return tuple(
        Lines.box(layer.volume, cells=bool(getattr(layer.look.field, "cells", False)), color=rgb)
        for layer in layers
        if layer.visible
    )
