"""The front-end as texts: its ES modules as one script, and its style sheets as one.

They stay apart in the folder ``web`` and are put together when they are asked for. One by one they cost a page some 80 requests
to a server that is reading a volume meanwhile.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from ..bundling import bundled

WEB = Path(__file__).with_name("web")
SHEETS = (
    "airlight.css",
    "picture.css",
    "panels/transfer.css",
    "panels/joint.css",
    "panels/probe.css",
    "panels/slices.css",
    "opening.css",
)
"""Style sheets; where two say something of the same element, the later one holds."""


@cache
def script(entry: str) -> str:
    """One script of a module below ``web`` and all that it imports."""
    return bundled(WEB, entry)


@cache
def styles() -> str:
    """All style sheets, one behind the other."""
    return "\n".join((WEB / name).read_text(encoding="utf-8") for name in SHEETS)
