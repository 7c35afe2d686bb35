"""Names and colours of labels from text files, as atlases and segmentation programs write them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import FileError
from .style import LabelStyle
from .value import Labels, replace_labels

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
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

    A line is ``label name``, with ``red green blue`` from 0 to 255 behind (FreeSurfer) or in front of a name in quotes
    (ITK-SNAP); other numbers behind the name do not count. Commas, semicolons and tabs are taken as spaces; lines that do not
    begin with a whole number are left out.

    Raises
    ------
    FileError
        When the file cannot be read, or no line of it names a label.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MOST_BYTES:
            raise FileError(str(path), f"is larger than {MOST_BYTES >> 20} MiB", "is it a table of labels?")
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(str(path), f"cannot be read ({error.strerror})") from error
    table = LabelTable({}, {})
    for line in text.splitlines():
        _read_line(line, table)
    if not table.names:
        raise FileError(str(path), "names no label", "a line is: label name, or: label name red green blue")
    return table


def _read_line(line: str, table: LabelTable) -> None:
    quoted = QUOTED.search(line)
    words = re.split(r"[\s,;]+", (QUOTED.sub("", line) if quoted else line).strip())
    if len(words) < 2 - bool(quoted) or not re.fullmatch(r"-?\d+", words[0]):
        return
    label, rest = int(words[0]), words[1:]
    if quoted:
        name, behind = quoted[1], rest
    else:
        name, behind = rest[0], rest[1:]
        while behind and not NUMBER.fullmatch(behind[0]):  # names of several words
            name, behind = f"{name} {behind[0]}", behind[1:]
    table.names[label] = name
    rgb = behind[:3]
    if len(rgb) == 3 and all(NUMBER.fullmatch(word) and 0 <= float(word) <= 255 for word in rgb):
        red, green, blue = (round(float(word)) for word in rgb)
        colour = LabelStyle(f"#{red:02x}{green:02x}{blue:02x}").colour
        assert colour is not None
        table.colours[label] = colour
