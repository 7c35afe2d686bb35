"""Files that appear whole or not at all, tables in TOML and JSON, and the lines on which their entries stand."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .errors import FileError, LimitError

Place = tuple[str | int, ...]
"""Keys of tables and numbers in lists, from the outermost to the innermost."""

MOST_TEXT_BYTES = 32 << 20
"""Room for the names and colours of half a million labels, or four functions of 65,536 points."""


# -- writing


@contextlib.contextmanager
def replacing(path: Path, suffix: str = "") -> Iterator[Path]:
    """A new name beside ``path`` to write to; it takes the place of ``path`` once the block ends without an error."""
    if not path.absolute().parent.is_dir():
        raise FileError(str(path), "cannot be written, its folder is not there", f"make {path.parent}")
    temporary = path.with_name(f".airlight-{secrets.token_hex(8)}{suffix or path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def written(path: Path) -> Iterator[Path]:
    """Like ``replacing``, with an error that names ``path`` where the system refuses.

    Raises
    ------
    FileError
        When it cannot be written.
    """
    try:
        with replacing(path) as temporary:
            yield temporary
    except FileError:
        raise
    except OSError as error:
        raise FileError(str(path), f"cannot be written ({error.strerror})") from error


def write_text(path: Path, text: str) -> None:
    """Write a text file that appears whole or not at all.

    Raises
    ------
    FileError
        When it cannot be written.
    """
    with written(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_table(path: Path, data: dict[str, Any], title: str = "") -> None:
    """Write plain data to a TOML file that appears whole or not at all, behind a comment.

    Raises
    ------
    FileError
        When it cannot be written.
    LimitError
        When it is larger than what is read again.
    """
    import tomli_w

    text = tomli_w.dumps(data, indent=2)
    # Vectors and control points on one line each: tomli_w gives every number a line of its own.
    scalar = r"[^\[\]\n]*"
    for item in (scalar, rf"{scalar}(?:\[{scalar}\]{scalar})*"):
        text = re.sub(rf"\[\n(?: {item},\n)+ *\]", _in_line, text)
    text = f"# {title}\n{text}" if title else text
    if len(text.encode()) > MOST_TEXT_BYTES:
        raise LimitError(str(path), f"would hold more than {MOST_TEXT_BYTES:,} bytes of text", "use less points or labels")
    write_text(path, text)


def _in_line(match: re.Match[str]) -> str:
    return "[" + ", ".join(re.split(r",\n *", match[0][1:-1].strip().removesuffix(","))) + "]"


# -- reading


def read_table(path: Path) -> tuple[dict[str, Any], str]:
    """Return the table that a TOML or JSON file holds, and its text.

    Raises
    ------
    FileError
        When the file is missing or not sound; the message names the line.
    LimitError
        When it is larger than any that a person or airlight writes.
    """
    kind = "JSON" if path.suffix.lower() == ".json" else "TOML"
    try:
        with path.open("rb") as file:
            content = file.read(MOST_TEXT_BYTES + 1)
        if len(content) > MOST_TEXT_BYTES:
            raise LimitError(str(path), f"holds more than {MOST_TEXT_BYTES:,} bytes of text", "keep data in files of volumes")
        text = content.decode("utf-8").replace("\r\n", "\n")
        if kind == "JSON":
            import json

            data = json.loads(text)
        else:
            import tomllib

            data = tomllib.loads(text)
    except OSError as error:
        raise FileError(str(path), f"cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:  # also what tomllib and json raise, with the line in it
        raise FileError(str(path), f"is no sound {kind} ({error})") from error
    if not isinstance(data, dict):
        raise FileError(str(path), f"holds {type(data).__name__}, must be a table")
    return data, text


# -- lines


_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]")
_KEY = re.compile(r"\s*([^\s=#\[\]{}][^=#\[\]{}]*)=")
_TOKEN = re.compile(r'#[^\n]*|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|[\[\]{}]')
_PART = re.compile(r"\.?(\w+)|\[(\d+)\]")


def place_of(where: str) -> Place:
    """Place below its root of what an error names: ``("shapes", 1, "low")`` of ``transfer.shapes[1] box.low``."""
    path = re.sub(r" \(?\w+\)?", "", where.replace(": ", "."))
    place: list[str | int] = []
    end = 0
    while part := _PART.match(path, end):
        place.append(part[1] or int(part[2]))
        end = part.end()
    return tuple(place[1:])


def line_of(text: str, place: Place) -> int | None:
    """Line of an entry, or of the innermost table, list or key round it that has one; it knows no multi-line strings."""
    counts: dict[tuple[str, ...], int] = {}
    table: Place = ()
    best: tuple[int, int | None, int] = (0, None, 0)
    begin = 0
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _HEADER.match(line):
            names = _names(header[2])
            if header[1] == "[[":
                counts[names] = counts.get(names, -1) + 1
            table = ()
            for n, name in enumerate(names, start=1):
                table += (name, counts[names[:n]]) if names[:n] in counts else (name,)
            here, end = table, begin + len(line)
        elif key := _KEY.match(line):
            here, end = table + _names(key[1]), begin + key.end()
        else:
            here, end = (), 0
        if place[: len(here)] == here and len(here) > best[0]:
            best = (len(here), number, end)
        begin += len(line) + 1
    depth, line_number, end = best
    item = place[depth] if depth < len(place) else None
    return (_line_of_item(text, end, item) if isinstance(item, int) else None) or line_number


def _line_of_item(text: str, begin: int, number: int) -> int | None:
    """Line on which a list or table begins that is so many items behind the first of a list, whose ``[`` comes next."""
    depth, count = 0, -1
    for token in _TOKEN.finditer(text, begin):
        if token[0] in "[{":
            depth += 1
            count += depth == 2
            if depth == 2 and count == number:
                return text.count("\n", 0, token.start()) + 1
        elif token[0] in "]}":
            depth -= 1
            if depth <= 0:
                return None
    return None


def _names(dotted: str) -> tuple[str, ...]:
    return tuple(name.strip().strip("\"'") for name in dotted.split("."))
