"""Transfer functions as plain data, as Python text and in TOML files::

    # A transfer function: value, [red, green, blue] of linear light, extinction per world unit of each control point.
    points = [
      [0.0, [0.0, 0.0, 0.0], 0.0],
      [300.0, [1.0, 0.6, 0.4], 0.02],
    ]

A file holds numbers and words for colours, never names of code. ``associated = true`` marks associated functions;
``[[surfaces]]`` tables, each with a ``value``, a ``colour`` and an ``opacity``, are surfaces of equal value.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from ..errors import ValueRangeError
from ..files import line_of, place_of, read_table, write_table

if TYPE_CHECKING:
    from .function import TransferFunction

LINEAR = "colours of linear light, extinctions per world unit"
TITLES = {
    "points": ": value, [red, green, blue] of linear light, extinction per world unit of each control point",
    "axes": f" of several variables: axes, and shapes on them; {LINEAR}",
    "channels": f" of several channels: one for each; {LINEAR}",
}
"""What files begin with, by the first entry of each kind of function."""
CLASSES = {"points": "TransferFunction", "axes": "JointFunction", "shapes": "JointFunction", "channels": "Channels"}
"""Which class reads a file, by entries that the others do not have."""


def as_code(function: TransferFunction) -> str:
    """Return Python text that makes an equal function, where airlight is imported as ``al``.

    Examples
    --------
    >>> print(TransferFunction([(0, "black", 0), (1, "white", 0.5)]).as_code())
    al.TransferFunction(
        [
            (0.0, (0.0, 0.0, 0.0), 0.0),
            (1.0, (1.0, 1.0, 1.0), 0.5),
        ],
    )
    """
    lines = ["al.TransferFunction(", "    ["]
    lines += [f"        {point!r}," for point in function.points]
    lines.append("    ],")
    for field in fields(function):
        value = getattr(function, field.name)
        if field.name == "surfaces" and value:
            lines += ["    surfaces=[", *(f"        {surface.as_code()}," for surface in value), "    ],"]
        elif field.name != "points" and (field.default is MISSING or value != field.default):
            lines.append(f"    {field.name}={value!r},")
    return "\n".join([*lines, ")"])


class Kept(ABC):
    """What the kinds of functions have in common: they go into TOML files and come out equal."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Plain data, as scene files keep it."""

    @classmethod
    @abstractmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Return the function that ``to_dict`` wrote."""

    def save(self, path: str | Path) -> None:
        """Write the function to a TOML file, which appears whole or not at all; ``load`` reads an equal one.

        Scene files hold the same text under ``[layers.transfer]``, and ``airlight render --tf FILE`` draws with it.

        Raises
        ------
        FileError
            When the file cannot be written.
        LimitError
            When it would hold more than 32 MiB.
        """
        data = self.to_dict()
        write_table(Path(path), data, f"A transfer function{TITLES[next(iter(data))]}.")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a function from a TOML file that `save` wrote, or a person.

        Raises
        ------
        FileError
            When the file is missing or is no TOML; the message names the line.
        LimitError
            When it holds more than 32 MiB.
        ValueRangeError
            When an entry is unknown or wrong; the message names file, line and entry. When the file holds another kind of
            function; it names the class that reads it.
        """
        data, text = read_table(Path(path))
        right = next((name for entry, name in CLASSES.items() if entry in data), cls.__name__)
        if right != cls.__name__:
            raise ValueRangeError(str(path), f"holds a {right}", f"read it with airlight.{right}.load")
        try:
            return cls.from_dict(data)
        except ValueRangeError as error:
            line = line_of(text, place_of(error.where))
            place = f"{path}:{line}" if line else str(path)
            raise ValueRangeError(f"{place}: {error.where}", error.what, error.remedy) from None


def check_data(data: Mapping[str, Any], known: tuple[str, ...]) -> None:
    """Refuse plain data whose entries are unknown or of wrong types; what numbers may be is checked with the points.

    Raises
    ------
    ValueRangeError
        Names the entry.
    """
    unknown = sorted(set(data) - set(known))
    if unknown:
        raise ValueRangeError("transfer", f"has unknown entries {unknown}", f"use {' and '.join(known)}")
    if not isinstance(data.get("points", []), (list, tuple)):
        raise ValueRangeError("transfer.points", f"is {data['points']!r}", "write [[value, colour, extinction], ...]")
    if not isinstance(data.get("surfaces", []), (list, tuple)):
        raise ValueRangeError("transfer.surfaces", f"is {data['surfaces']!r}", 'write [{value = 1.0, colour = "red"}, ...]')
    if not isinstance(data.get("associated", False), bool):
        raise ValueRangeError("transfer.associated", f"is {data['associated']!r}, must be true or false")
