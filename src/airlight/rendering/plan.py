"""Passes of a frame: what each reads and writes by name, checked before the first draw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..errors import StageError


@dataclass(frozen=True)
class Pass:
    """A step of a frame. ``run`` does it; names are those of ``shader.program.PASS_RESOURCES`` and of measured values."""

    name: str
    reads: tuple[str, ...]
    writes: tuple[str, ...]
    run: Callable[[], None]


def check_plan(passes: Sequence[Pass], wanted: Sequence[str]) -> None:
    """Check that whatever is read was written before, and that each name has one owner.

    Raises
    ------
    StageError
        Names the pass and what it misses, or the two passes that own one name.
    """
    owners: dict[str, str] = {}
    for step in passes:
        for name in step.reads:
            if name not in owners:
                raise StageError(f"pass {step.name!r}", f"reads {name!r}, which no pass before it writes")
        for name in step.writes:
            if name in owners and name not in step.reads:
                raise StageError(f"pass {step.name!r}", f"writes {name!r}, which belongs to pass {owners[name]!r}")
            owners[name] = step.name
    for name in wanted:
        if name not in owners:
            raise StageError("frame", f"needs {name!r}, which no pass writes")
