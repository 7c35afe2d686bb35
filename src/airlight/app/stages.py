"""``airlight stages``: slots, stages and their parameters, out of the classes themselves."""

import dataclasses
import io
import shutil
from typing import Annotated, Any

from cyclopts import Parameter

from .. import stages as _stages  # noqa: F401  (makes the names of the stages known)
from ..errors import ValueRangeError
from ..stage import SLOTS, STAGES, Stage, stage_fields, summary_of


def stages(
    slot: Annotated[str | None, Parameter(help="Only this slot.")] = None,
    *,
    plugin: Annotated[
        tuple[str, ...], Parameter(negative="", metavar="FILE_OR_MODULE", help="Python code that registers stages; repeatable.")
    ] = (),
) -> None:
    """List the slots, the stages that fill them, and their parameters with type, default, unit, range and meaning.

    For instance:

        airlight stages
        airlight stages shade
    """
    if slot is not None and slot not in SLOTS:
        raise ValueRangeError("slot", f"is {slot!r}, must be one of {', '.join(SLOTS)}")
    for name in SLOTS if slot is None else (slot,):
        _print_slot(name)


def _print_slot(slot: str) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    title = f"{slot}: {SLOTS[slot].help}"
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("stage, parameter", no_wrap=True)
    table.add_column("default", max_width=12, overflow="fold")
    table.add_column("range and unit", max_width=18)
    table.add_column("meaning")
    for _, cls in sorted(STAGES[slot].items()):
        for row in stage_rows(cls):
            table.add_row(*row)
    # Not to standard output itself: rich would end the program when nobody reads.
    text = io.StringIO()
    Console(file=text, width=shutil.get_terminal_size().columns, markup=False, highlight=False).print(table)
    print(text.getvalue(), end="")


def stage_rows(cls: type[Stage]) -> list[tuple[str, str, str, str]]:
    """Rows of (name, default, range and unit, meaning): the stage itself, then each of its parameters, indented."""
    summary = summary_of(cls)
    rows = [(cls.name, "", "", summary)]
    rows += [(f"  {f.name}", _word(f.default), _range(f), f.metadata["help"]) for f in stage_fields(cls)]
    return rows


def _range(field: dataclasses.Field[Any]) -> str:
    if field.metadata["kind"] == "value":
        return type(field.default).__name__.lower()
    bounds = field.metadata["bounds"]
    if bounds.choices:
        return ", ".join(bounds.choices)
    if isinstance(field.default, bool):
        return "true, false"
    unit = field.metadata["unit"]
    allowed = str(bounds).removeprefix("must lie in ").removeprefix("must be ")
    return f"{allowed} {unit}" if unit not in ("", "1") else allowed


def _word(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(_word(part) for part in value)
    if isinstance(value, float):
        return f"{value:g}"
    return "auto" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
