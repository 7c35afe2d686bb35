"""A table of a TOML or JSON file that knows its place, so that errors name file, line and key."""

from __future__ import annotations

import contextlib
import dataclasses
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ..errors import AirlightError, FileError, ValueRangeError
from .values import checked_value

Place = tuple[str | int, ...]
T = TypeVar("T")


# -- from plain data to values


@dataclasses.dataclass
class Table:
    """A table of a TOML file whose keys are taken one by one; what is left in the end is unknown."""

    data: Mapping[str, Any]
    place: Place
    file: str
    text: str = ""
    taken: set[str] = dataclasses.field(default_factory=set)

    def where(self, key: str | None = None) -> str:
        """File, line and key, for messages."""
        place = (*self.place, key) if key is not None else self.place
        name = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in place).removeprefix(".")
        line = _line_of(self.text, place) if self.file else None
        prefix = f"{self.file}:{line}" if line else self.file
        return ": ".join(part for part in (prefix, name) if part)

    def error(self, key: str | None, what: str, remedy: str = "") -> ValueRangeError:
        """Return the error about a key."""
        return ValueRangeError(self.where(key), what, remedy)

    def take(self, key: str, hint: Any, default: Any) -> Any:
        """Return the checked value of a key, or its default."""
        self.taken.add(key)
        if key not in self.data:
            return default
        try:
            return checked_value(self.data[key], hint, key)
        except ValueRangeError as error:
            raise self.error(key, error.what) from None

    def table(self, key: str) -> Table:
        """Return the table under a key; empty where there is none."""
        self.taken.add(key)
        value = self.data.get(key, {})
        if not isinstance(value, dict):
            raise self.error(key, f"is {value!r}, must be a table")
        return Table(value, (*self.place, key), self.file, self.text)

    def tables(self, key: str) -> list[Table]:
        """Return the tables of a list."""
        self.taken.add(key)
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            raise self.error(key, f"is {value!r}, must be a list of tables", f"write [[{key}]] for each")
        return [Table(v, (*self.place, key, n), self.file, self.text) for n, v in enumerate(value)]

    def close(self) -> None:
        """Refuse keys that nobody took."""
        for key in self.data:
            if key not in self.taken:
                raise self.error(key, "is unknown", f"known here: {', '.join(sorted(self.taken)) or 'nothing'}")

    @contextlib.contextmanager
    def located(self, key: str | None = None) -> Iterator[None]:
        """Put file, line and key in front of what a value says of itself."""
        try:
            yield
        except AirlightError as error:
            raise type(error)(f"{self.where(key)}: {error.where}", error.what, error.remedy) from error
        except (TypeError, ValueError, AttributeError) as error:
            raise self.error(key, f"has a wrong value ({error})") from error


def parsed(path: Path) -> Table:
    """Return the whole of a TOML or JSON file as a table."""
    try:
        text = path.read_text(encoding="utf-8")
        if path.suffix.lower() == ".json":
            import json

            data = json.loads(text)
        else:
            import tomllib

            data = tomllib.loads(text)
    except OSError as error:
        raise FileError(str(path), f"cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:  # also what tomllib and json raise, with the line in it
        raise FileError(str(path), f"is no sound file ({error})") from error
    if not isinstance(data, dict):
        raise FileError(str(path), f"holds {type(data).__name__}, must be a table")
    return Table(data, (), str(path), text)


_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]")
_KEY = re.compile(r"\s*([^\s=#\[\]{}][^=#\[\]{}]*)=")


def _line_of(text: str, place: Place) -> int | None:
    """Line of a key, or of the innermost table or key round it that has one; a scan that knows no multi-line strings."""
    counts: dict[tuple[str, ...], int] = {}
    table: Place = ()
    best: tuple[int, int | None] = (0, None)
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            names = _names(header[2])
            if header[1] == "[[":
                counts[names] = counts.get(names, -1) + 1
            table = ()
            for n, name in enumerate(names, start=1):
                table += (name, counts[names[:n]]) if names[:n] in counts else (name,)
            here = table
        elif key := _KEY.match(line):
            here = table + _names(key[1])
        else:
            continue
        if place[: len(here)] == here and len(here) > best[0]:
            best = (len(here), number)
    return best[1]


def _names(dotted: str) -> tuple[str, ...]:
    return tuple(name.strip().strip("\"'") for name in dotted.split("."))
