"""Sets of labels as text: ``"3,5-9"``."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ..errors import ValueRangeError

MOST_IN_TEXT = 1 << 22
ONE_OR_RANGE = re.compile(r"(-?\d{1,20})(?:\s*-\s*(-?\d{1,20}))?")


def text_to_ids(text: str, where: str = "labels") -> frozenset[int]:
    """Labels of a text such as ``"3,5-9,-2"``.

    Raises
    ------
    ValueRangeError
        For what is no whole number or range, for ranges that run backwards, and for more than four million labels.
    """
    found: set[int] = set()
    for part in filter(None, (piece.strip() for piece in text.split(","))):
        match = ONE_OR_RANGE.fullmatch(part)
        if match is None:
            raise ValueRangeError(where, f"holds {part!r}", "give labels and ranges, such as 3,5-9")
        first = int(match[1])
        last = first if match[2] is None else int(match[2])
        if last < first:
            raise ValueRangeError(where, f"holds {part!r}, which runs backwards", f"write {last}-{first}")
        if last - first + len(found) >= MOST_IN_TEXT:
            raise ValueRangeError(where, f"holds {part!r}", f"name at most {MOST_IN_TEXT:,} labels")
        found.update(range(first, last + 1))
    return frozenset(found)


def ids_to_text(ids: Iterable[int]) -> str:
    """Text of a set of labels, increasing, neighbours in number joined to ranges."""
    parts: list[str] = []
    ordered = sorted(ids)
    begin = 0
    for place, label in enumerate(ordered, start=1):
        if place == len(ordered) or ordered[place] != label + 1:
            first = ordered[begin]
            parts.append(f"{first}" if first == label else f"{first}-{label}")
            begin = place
    return ",".join(parts)
