"""Transfer functions as plain data, as Python text and in TOML files::

    # Control points of a transfer function: value, [red, green, blue] of linear light, extinction per world unit.
    points = [
      [0.0, [0.0, 0.0, 0.0], 0.0],
      [300.0, [1.0, 0.6, 0.4], 0.02],
    ]

A file holds numbers and words for colours, never names of code. ``associated = true`` marks associated functions;
``[[surfaces]]`` tables, each with a ``value``, a ``colour`` and an ``opacity``, are surfaces of equal value.
"""

from __future__ import annotations

import os
import re
from dataclasses import MISSING, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FileError, ValueRangeError

if TYPE_CHECKING:
    from .function import TransferFunction

HEADER = "# Control points of a transfer function: value, [red, green, blue] of linear light, extinction per world unit."
POINT = re.compile(r"transfer\.points\[(\d+)\]")
TOKEN = re.compile(r'#[^\n]*|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|[\[\]\n]')


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


def save(function: TransferFunction, path: str | Path) -> None:
    """Write the function to a TOML file, which appears whole or not at all; ``TransferFunction.load`` reads an equal one.

    Scene files hold the same text under ``[layers.transfer]``, and ``airlight render --tf FILE`` draws with it.

    Raises
    ------
    FileError
        When the file cannot be written.
    """
    import tomli_w

    data = function.to_dict()
    lines = [HEADER, "points = ["]
    # Lists of finite numbers are written alike in Python and in TOML.
    lines += [f"  {point!r}," for point in data.pop("points")]
    write_whole(Path(path), "\n".join([*lines, "]", tomli_w.dumps(data)]))


def write_whole(path: Path, text: str) -> None:
    """Write a text file that appears whole or not at all.

    Raises
    ------
    FileError
        When it cannot be written.
    """
    import secrets

    # Not by airlight.io, which knows volumes only: the reference may not see it.
    temporary = path.with_name(f".airlight-{secrets.token_hex(8)}.toml")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise FileError(str(path), f"cannot be written ({error.strerror})") from error
    finally:
        temporary.unlink(missing_ok=True)


def load(cls: type[TransferFunction], path: str | Path) -> TransferFunction:
    """Read a function from a TOML file that `save` wrote, or a person.

    Raises
    ------
    FileError
        When the file is missing or is no TOML; the message names the line.
    ValueRangeError
        When an entry is unknown or wrong; the message names file, line and entry.
    """
    import tomllib

    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except OSError as error:
        raise FileError(str(path), f"cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:  # also what tomllib raises, with the line in it
        raise FileError(str(path), f"is no sound TOML ({error})") from error
    try:
        return cls.from_dict(data)
    except ValueRangeError as error:
        found = POINT.match(error.where)
        line = _line_of_point(text, int(found[1])) if found else None
        place = f"{path}:{line}" if line else str(path)
        raise ValueRangeError(f"{place}: {error.where}", error.what, error.remedy) from None


def check_data(data: dict[str, Any], known: tuple[str, ...]) -> None:
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


def _line_of_point(text: str, number: int) -> int | None:
    """Line on which the point of a number begins: the brackets inside of ``points = [...]`` are counted."""
    start = re.search(r"^[ \t]*points[ \t]*=", text, re.MULTILINE)
    if start is None:
        return None
    depth, count = 0, -1
    for token in TOKEN.finditer(text, start.end()):
        depth += {"[": 1, "]": -1}.get(token[0], 0)
        if token[0] == "[" and depth == 2:
            count += 1
            if count == number:
                return text.count("\n", 0, token.start()) + 1
    return None
