"""Names and colours of labels from text files, as atlases and segmentation programs write them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import FileError
from .style import LabelStyle
from .value import Labels, replace_labels

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
BYTE = re.compile(r"0*(?:\d{1,2}|1\d\d|2[0-4]\d|25[0-5])", re.ASCII)
QUOTED = re.compile(r'"([^"]*)"')
MOST_BYTES = 64 << 20


@dataclass(frozen=True)
class LabelTable:
    """What a file says of labels: ``names`` and linear ``colours`` by label."""

    names: dict[int, str]
    colours: dict[int, tuple[float, float, float]]

    def applied_to(self, labels: Labels) -> Labels:
        """Return labels with these names, and these colours where they have no style yet."""
        styles = {label: LabelStyle(colour) for label, colour in self.colours.items()} | dict(labels.styles)
        return replace_labels(labels, styles=styles, names=dict(labels.names) | self.names)


def read_label_table(path: str | Path) -> LabelTable:
    """Read names of labels, and colours where there are some, from a text file.

    A line is ``label name``, with ``red green blue``, or ``red green blue alpha`` on all lines, from 0 to 255 behind
    (FreeSurfer) or in front of a name in quotes (ITK-SNAP). One or two such numbers belong to the name (``Area 4``); others
    behind the name do not count. Commas, semicolons and tabs are taken as spaces; lines that do not
    begin with a whole number are left out.

    Raises
    ------
    FileError
        When the file cannot be read, or no line of it names a label.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise FileError(str(path), "is no regular file", "name a text file")
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise FileError(str(path), f"is larger than {MOST_BYTES >> 20} MiB", "is it a table of labels?")
        text = data.decode("utf-8", errors="replace")
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(str(path), f"cannot be read ({error.strerror})") from error
    table = LabelTable({}, {})
    lines = [found for line in text.splitlines() if (found := _split(line)) is not None]
    # Where some line has three numbers there is no alpha: what comes before three is the name's own.
    count = 3 if any(_trailing(behind, BYTE) == 3 for *_, behind, in_quotes in lines if not in_quotes) else 4
    for label, name, behind, in_quotes in lines:
        words, rgb = (name, behind[:3]) if in_quotes else _name_and_colour(name, behind, count)
        table.names[label] = words
        if len(rgb) == 3 and all(NUMBER.fullmatch(word) and 0 <= float(word) <= 255 for word in rgb):
            red, green, blue = (round(float(word)) for word in rgb)
            colour = LabelStyle(f"#{red:02x}{green:02x}{blue:02x}").colour
            assert colour is not None
            table.colours[label] = colour
    if not table.names:
        raise FileError(str(path), "names no label", "a line is: label name, or: label name red green blue")
    return table


def _split(line: str) -> tuple[int, str, list[str], bool] | None:
    """Label, name, numbers behind it, and whether the name is in quotes; None for lines that name no label."""
    quoted = QUOTED.search(line)
    words = re.split(r"[\s,;]+", (QUOTED.sub("", line) if quoted else line).strip(" \t,;"))
    if len(words) < 2 - bool(quoted) or not re.fullmatch(r"-?\d{1,20}", words[0]):
        return None
    if quoted:
        return int(words[0]), quoted[1], words[1:], True
    numbers = _trailing(words[2:], NUMBER)
    end = len(words) - numbers
    return int(words[0]), " ".join(words[1:end]), words[end:], False


def _name_and_colour(name: str, behind: list[str], count: int) -> tuple[str, list[str]]:
    """Name, with the numbers that it ends with, and red, green and blue, which are first of the last ``count`` numbers."""
    while behind and not BYTE.fullmatch(behind[-1]):
        behind = behind[:-1]
    run = _trailing(behind, BYTE)
    if run >= count:
        return " ".join([name, *behind[:-count]]), behind[-count:][:3]
    return " ".join([name, *behind]) if run == len(behind) else name, []


def _trailing(words: list[str], pattern: re.Pattern[str]) -> int:
    """How many of the last words are of a pattern."""
    return next((n for n, word in enumerate(reversed(words)) if not pattern.fullmatch(word)), len(words))
