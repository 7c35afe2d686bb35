"""A table of a TOML or JSON file that knows its place, so that errors name file, line and key."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ..errors import AirlightError, ValueRangeError
from ..files import Place, line_of, place_of, read_table
from .values import checked_value

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
        return self._located(place, _dotted(place))

    def _located(self, place: Place, name: str) -> str:
        line = line_of(self.text, place) if self.file else None
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
            where = ": ".join(part for part in (self.where(key), error.where) if part)
            raise type(error)(where, error.what, error.remedy) from error
        except (TypeError, ValueError, AttributeError) as error:
            raise self.error(key, f"has a wrong value ({error})") from error

    @contextlib.contextmanager
    def located_inside(self, root: str) -> Iterator[None]:
        """Put file and line in front of what a value says of one of its entries, which it calls ``root.entry``."""
        try:
            yield
        except AirlightError as error:
            own = _dotted(self.place) or root
            if error.where.startswith(root):
                where = self._located((*self.place, *place_of(error.where)), own + error.where.removeprefix(root))
            else:
                where = self._located(self.place, f"{own}: {error.where}")
            raise type(error)(where, error.what, error.remedy) from error


def _dotted(place: Place) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).removeprefix(".")


def parsed(path: Path) -> Table:
    """Return the whole of a TOML or JSON file as a table."""
    data, text = read_table(path)
    return Table(data, (), str(path), text)
