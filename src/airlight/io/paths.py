"""Paths: files that a header points to."""

from __future__ import annotations

from pathlib import Path

from ..errors import FileError
from .messages import brief, shown


def detached(header: Path, name: str, key: str) -> Path:
    """Path of the file that ``header`` names under ``key``; it must lie in the header's folder or below.

    Raises
    ------
    FileError
        If it lies elsewhere, also by a link, or is not a plain file.
    """
    where = f"{header}: {key}"
    folder = header.parent.resolve()
    try:
        target = (folder / name).resolve()
        inside = bool(name) and target.is_relative_to(folder)
        plain = inside and target.is_file()
    except (OSError, ValueError, RuntimeError) as error:
        raise FileError(where, f"names a file that cannot be ({brief(error)})", "mend the header") from error
    if not inside:
        raise FileError(where, f"points to {shown(name)}, outside of the header's folder", "put both into one folder")
    if not plain:
        raise FileError(where, f"points to {shown(name)}, which is not there", "put it beside the header")
    return target


def numbered(pattern: str, number: int, key: str) -> str:
    """Name of one file out of a pattern with one number in it, like ``slice%03d.raw``."""
    before, _, rest = pattern.partition("%")
    width, letter, after = rest.partition("d")
    if not letter or not (width.isdigit() or not width) or int(width or 0) > 12:
        raise FileError(key, f"is the pattern {shown(pattern)}", "write one number like %03d into it")
    return before + (f"{number:0{int(width)}d}" if width.startswith("0") else f"{number:{int(width or 1)}d}") + after
