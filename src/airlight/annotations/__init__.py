"""What is drawn beside the data so that a picture can be read: scale bar, colour bar, grid, axes, letters, pointers."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from ..errors import ValueRangeError
from ..transfer.given import check_names, kind_of, listed_values
from .axes import Axes as Axes
from .axes import Orientation as Orientation
from .base import Annotation as Annotation
from .color_bar import ColorBar as ColorBar
from .grid import Grid as Grid
from .pointer import Pointer as Pointer
from .scale_bar import ScaleBar as ScaleBar

KINDS: dict[str, type[Annotation]] = {cls.kind: cls for cls in (ScaleBar, ColorBar, Grid, Axes, Orientation, Pointer)}


def from_dict(data: Mapping[str, Any]) -> Annotation:
    """Return the annotation that ``to_dict`` wrote, or a person.

    Raises
    ------
    ValueRangeError
        For entries that are unknown, missing or not legal; it names them.
    """
    kind = kind_of(data, KINDS, "annotation")
    known = {field.name: field for field in dataclasses.fields(KINDS[kind])}
    check_names(data, known, kind, kind)
    for name, field in known.items():
        if field.default is dataclasses.MISSING and name not in data:
            raise ValueRangeError(f"{kind}.{name}", "is missing", f"a {kind} needs it")
    return KINDS[kind](**{name: value for name, value in data.items() if name != "kind"})


def checked_annotations(given: Iterable[Annotation], where: str) -> tuple[Annotation, ...]:
    """Return annotations as a tuple.

    Raises
    ------
    DataError
        When something else is among them.
    """
    making = f"make annotations with {', '.join(cls.__name__ for cls in KINDS.values())}"
    return listed_values(given, Annotation, where, "pass a list: annotations=[airlight.ScaleBar()]", making)
