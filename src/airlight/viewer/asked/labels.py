"""Labels of a layer, by pages, since there may be hundreds of thousands; and what is hidden of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import ValueRangeError
from ...labels import Labels
from ...labels.ranges import ids_to_text
from ..asking import answers
from ..session import Session
from .probe import layer_numbered

MOST_ROWS = 500


@answers("labels")
def page(session: Session, layer: int = 0, start: int = 0, count: int = 100, search: str = "") -> dict[str, Any]:
    """Some of a layer's labels that a search finds, each with its name and with how it is drawn.

    Labels are text: those of 64 bits are no numbers of JavaScript. A search finds names that hold its words, and numbers that
    begin with it.
    """
    shown = layer_numbered(session, layer)
    labels = _labels(session, layer)
    ids = labels.ids(labels.time_of(shown.time))
    names = labels.name_by_label
    found = ids if not search.strip() else ids[_matches(ids, names, search)]
    start, count = max(0, int(start)), min(max(0, int(count)), MOST_ROWS)
    rows = [_row(labels, names, int(label)) for label in found[start : start + count].tolist()]
    return {"total": len(ids), "found": len(found), "start": start, "rows": rows}


@answers("labels.shown")
def shown(session: Session, change: str, layer: int = 0, labels: list[str] | None = None) -> dict[str, str]:
    """What is hidden and what stands out after a change, as text of ranges.

    ``change`` is ``hide``, ``show``, ``only``, ``highlight`` or ``plain`` (no longer highlighted); without labels all are
    meant.

    Raises
    ------
    ValueRangeError
        For other changes, and what is no label.
    """
    given, time = _labels(session, layer), layer_numbered(session, layer).time
    every = given.ids(given.time_of(time)).tolist()
    try:
        some = frozenset(every if labels is None else map(int, labels))
    except (TypeError, ValueError):
        raise ValueRangeError("labels", f"are {labels!r:.80}", "give whole numbers, as text") from None
    if change == "hide":
        given = given.hide(some)
    elif change == "show":
        given = given.show(None if labels is None else some)
    elif change == "only":
        given = given.only(some, given.time_of(time))
    elif change in ("highlight", "plain"):
        standing_out = given.highlighted | some if change == "highlight" else given.highlighted - some
        given = given.highlight(() if labels is None else standing_out)
    else:
        raise ValueRangeError("labels.change", f"is {change!r:.40}, must be hide, show, only, highlight or plain")
    return {"hidden": ids_to_text(given.hidden), "highlighted": ids_to_text(given.highlighted)}


def _labels(session: Session, layer: int) -> Labels:
    labels = layer_numbered(session, layer).labels
    if labels is None:
        raise ValueRangeError("labels", f"of layer {layer} are not there", "open an image with --labels FILE")
    return labels


def _row(labels: Labels, names: dict[int, str], label: int) -> dict[str, Any]:
    style = labels.style_of(label)
    return {
        "label": str(label),
        "name": names.get(label, ""),
        "colour": list(style.tint(label)),
        "opacity": style.opacity,
        "own": label in labels.by_label,
        "visible": label not in labels.hidden,
        "highlighted": label in labels.highlighted,
        "background": label == labels.background,
    }


def _matches(ids: np.ndarray[Any, Any], names: dict[int, str], search: str) -> np.ndarray[Any, Any]:
    """Whether each label (n,) is found."""
    words = search.casefold().split()
    named = [label for label, name in names.items() if all(word in name.casefold() for word in words)]
    found = np.isin(ids, np.array(named, dtype=ids.dtype)) if named else np.zeros(len(ids), dtype=bool)
    if len(words) == 1 and words[0].lstrip("-").isdecimal():
        found |= np.char.startswith(ids.astype(str), words[0])
    return found
