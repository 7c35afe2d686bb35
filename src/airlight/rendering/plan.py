"""Steps of a frame: what each reads and writes by name and type, put in order and checked before the first draw."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from ..errors import StageError
from ..handed import Kind


@dataclass(frozen=True)
class Step:
    """A pass of a frame: ``run`` does it. Whoever writes a name without reading it owns it; others may change it."""

    name: str
    reads: Mapping[str, Kind]
    writes: Mapping[str, Kind]
    run: Callable[[], None] = field(compare=False)

    @property
    def owned(self) -> frozenset[str]:
        """Names that begin here."""
        return frozenset(self.writes) - frozenset(self.reads)


def planned(steps: Sequence[Step], wanted: Mapping[str, Kind]) -> tuple[Step, ...]:
    """Return the steps that are needed, in an order in which they may run; see ``check_plan`` for what is refused."""
    check_plan(steps, wanted)
    return needed(steps, wanted)


def in_order(steps: Iterable[Step]) -> list[Step]:
    """Return steps as they are given, but each behind those that own what it reads.

    Raises
    ------
    StageError
        When they wait for each other.
    """
    waiting, ordered = list(steps), []
    while waiting:
        owned = {name: step for step in waiting for name in step.owned}
        ready = next((step for step in waiting if not owned.keys() & step.reads.keys()), None)
        if ready is None:
            ring = ", ".join(f"{step.name!r} for {', '.join(sorted(owned.keys() & step.reads.keys()))}" for step in waiting)
            raise StageError("passes", f"wait for each other: {ring}", "let one of them read less")
        waiting.remove(ready)
        ordered.append(ready)
    return ordered


def check_plan(steps: Sequence[Step], wanted: Mapping[str, Kind]) -> None:
    """Check that whatever is read was written before, as the type that is asked for, and that each name has one owner.

    Raises
    ------
    StageError
        Names the pass and what it misses, or the two passes that do not agree.
    """
    writers: dict[str, tuple[str, Kind]] = {}

    def check(reader: str, name: str, kind: Kind) -> None:
        if name not in writers:
            later = next((step.name for step in steps if name in step.owned), None)
            what = "which no pass writes" if later is None else f"which only pass {later!r} writes, behind it"
            raise StageError(reader, f"reads {name!r}, {what}", "known here: " + (", ".join(writers) or "nothing"))
        writer, written = writers[name]
        if written != kind:
            raise StageError(reader, f"reads {name!r} as {kind}, and pass {writer!r} writes it as {written}")

    for step in steps:
        where = f"pass {step.name!r}"
        for name, kind in step.reads.items():
            check(where, name, kind)
        for name, kind in step.writes.items():
            if name in writers and name not in step.reads:
                raise StageError(
                    where, f"writes {name!r}, which belongs to pass {writers[name][0]!r}", "read it, too, or rename it"
                )
            if name in writers and writers[name][1] != kind:
                writer, written = writers[name]
                raise StageError(where, f"writes {name!r} as {kind}, and pass {writer!r} as {written}")
            writers[name] = (writers[name][0] if name in step.reads else step.name), kind
    for name, kind in wanted.items():
        check("frame", name, kind)


def needed(steps: Sequence[Step], wanted: Iterable[str]) -> tuple[Step, ...]:
    """Return the steps on which the wanted names depend."""
    alive, kept = set(wanted), []
    for step in reversed(steps):
        if alive & step.writes.keys():
            alive = (alive - step.owned) | step.reads.keys()
            kept.append(step)
    return tuple(reversed(kept))
