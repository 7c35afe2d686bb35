"""What clients are told of errors."""

from __future__ import annotations

import re

from ..errors import AirlightError

_BEGIN = r"(?:/|[A-Za-z]:\\)"
_FOLDERS = re.compile(
    rf"(?:^|(?<=['\"])|(?<=: )){_BEGIN}[^:'\"]*[/\\]"  # at the beginning, behind a place and in quotes they may hold spaces
    rf"|(?<![\w:/.)])(?:/(?:[^/\s]+/)+|[A-Za-z]:\\(?:[^\\\s]+\\)*)"
)


def told(error: AirlightError) -> dict[str, str]:
    """An error as plain data, without the folders of paths: they are nobody's business but the server's."""
    parts = {"where": error.where, "what": error.what, "remedy": error.remedy}
    return {name: _FOLDERS.sub("", part) for name, part in parts.items()}
