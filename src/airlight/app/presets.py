"""``airlight presets``: transfer functions and colour maps by name."""

import shutil
import textwrap
from typing import Annotated

from cyclopts import Parameter

from ..errors import ValueRangeError
from ..transfer import colormap_names
from ..transfer import presets as made_ready


def presets(
    word: Annotated[str, Parameter(help="Only names with this in them.")] = "",
    *,
    colormaps: Annotated[bool, Parameter(negative="", help="List the colour maps for --colormap instead.")] = False,
) -> None:
    """List the transfer functions for --preset, and what each shows.

    For instance:

        airlight presets
        airlight presets ct
        airlight presets --colormaps cmocean
    """
    found = list(_colormaps(word) if colormaps else _presets(word))
    if not found:
        raise ValueRangeError("word", f"is {word!r}, and no name has it", "leave it out to see all")
    print("\n".join(found))


def _presets(word: str) -> list[str]:
    names = [name for name in made_ready.names() if word.replace("-", "_") in name]
    width = max(map(len, names), default=0)
    return [f"{name:{width}}  {made_ready.describe(name)}" for name in names]


def _colormaps(word: str) -> list[str]:
    lines = []
    for category, names in colormap_names().items():
        chosen = [name for name in names if word.lower() in name.lower()]
        if chosen:
            lines += [
                f"{category}:",
                *textwrap.wrap(" ".join(chosen), shutil.get_terminal_size().columns - 2, break_long_words=False),
            ]
    return lines
