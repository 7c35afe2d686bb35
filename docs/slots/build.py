"""Write what follows from the code into the slot pages: signatures from ``SLOTS``, tables of stages from their classes.

Usage: python docs/slots/build.py [--check]

Text between ``<!-- made by build.py: NAME -->`` and ``<!-- end -->`` is replaced; the rest of a page is written by hand.
With ``--check`` nothing is written, and pages that are out of date are named.
"""

from __future__ import annotations

import dataclasses
import re
import sys
from pathlib import Path
from typing import Any

from airlight import stages as _stages  # noqa: F401  (makes the names of the stages known)
from airlight.stage import SLOTS, STAGES, Stage, stage_fields, summary_of

FOLDER = Path(__file__).parent
MADE = re.compile(r"(<!-- made by build\.py: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def main(argv: list[str]) -> int:
    """Bring the pages up to date; returns 1 where ``--check`` finds one that is not."""
    stale = []
    for slot in SLOTS:
        page = FOLDER / f"{slot}.md"
        before = page.read_text(encoding="utf-8")
        after = built(slot, before)
        if before != after:
            stale.append(page.name)
            if "--check" not in argv:
                page.write_text(after, encoding="utf-8")
    if "--check" in argv and stale:
        sys.stderr.write(f"out of date: {', '.join(stale)}; run python docs/slots/build.py\n")
        return 1
    return 0


def built(slot: str, page: str) -> str:
    """Return the page of a slot with its made parts renewed."""
    parts = {"signature": signature(slot), "stages": stage_table(slot)}
    return MADE.sub(lambda match: f"{match[1]}{parts[match[2]]}\n{match[3]}", page)


def signature(slot: str) -> str:
    """WGSL functions of a slot, the optional ones marked."""
    known = SLOTS[slot]
    kind = "One for each layer." if known.per_layer else "One for the whole scene."
    lines = [f"{name}: {text}" for name, text in known.functions.items()]
    lines += [f"{name}: {text}    // may be left out" for name, text in known.optional.items()]
    return "\n".join([f"{known.help} {kind}", "", "```wgsl", *lines, "```"])


def stage_table(slot: str) -> str:
    """Table of the package's own stages of a slot with their parameters."""
    rows = ["| stage | class | parameter | default | range, unit | meaning |", "| --- | --- | --- | --- | --- | --- |"]
    for name, cls in sorted(STAGES[slot].items()):
        if cls.__module__.startswith("airlight."):
            rows += ["| " + " | ".join(cells) + " |" for cells in stage_rows(name, cls)]
    return "\n".join(rows)


def stage_rows(name: str, cls: type[Stage]) -> list[tuple[str, ...]]:
    """Cells of the row of a stage and of the rows of its parameters."""
    summary = summary_of(cls)
    rows: list[tuple[str, ...]] = [(f"`{name}`", f"`{cls.__name__}`", "", "", "", summary)]
    for field in stage_fields(cls):
        changes = "" if field.metadata["kind"] != "static" else " (links another program)"
        meaning = field.metadata["help"] + changes
        rows.append(("", "", f"`{field.name}`", f"`{field.default!r}`", _allowed(field), meaning))
    return rows


def _allowed(field: dataclasses.Field[Any]) -> str:
    kind = type(field.default)
    if isinstance(field.default, Stage):
        return f"a stage of [{kind.slot}]({kind.slot}.md)"
    if field.metadata["kind"] == "value" and kind not in (int, float, str):
        return f"`al.{kind.__name__}`"
    if kind is str and not field.metadata["bounds"].choices:
        return "a name"
    bounds, unit = field.metadata["bounds"], field.metadata["unit"]
    if bounds.choices:
        return ", ".join(f"`{choice}`" for choice in bounds.choices)
    if isinstance(field.default, bool):
        return "`True`, `False`"
    allowed = str(bounds).removeprefix("must lie in ").removeprefix("must be ")
    return allowed if unit in ("", "1") else f"{allowed}, {unit}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
