"""What the commands draw or look at: a file, a folder, or a sample by its name."""

from __future__ import annotations

import difflib
import os
from typing import Any

from ..errors import FileError, ValueRangeError
from ..volume import Volume
from .progress import ProgressBar

INPUT = "A volume: file or folder, or the name of a sample (see airlight demo --help)."
SCENE_INPUT = "A volume (file or folder), a scene (.toml), or the name of a sample (see airlight demo --help)."
EMPTY_OPTIONS = ("", 0, False, None)


def open_named(path: str, progress: ProgressBar | None = None, **options: Any) -> Volume:
    """Open a file, or the sample of this name where no such file is there.

    Parameters
    ----------
    path
        Path of a file or a folder, which always wins, or name of a sample.
    options
        Those of ``airlight.open``; samples take none that tell how to read.

    Raises
    ------
    FileError
        Where there is neither; it names files and samples whose names are near.
    ValueRangeError
        For options that a sample does not take.
    """
    from .. import io, samples

    if os.path.lexists(os.path.expanduser(path)):
        return io.open(path, progress=progress, **options)
    check_named(path)
    for name, value in options.items():
        if name != "max_memory" and value not in EMPTY_OPTIONS:
            what = f"tells how to read a file, and {path} is a sample"
            raise ValueRangeError(f"--{name.replace('_', '-')}", what, "leave it out")
    return samples.load(path, progress=progress)


def check_named(path: str) -> None:
    """Refuse a path where no file or folder is, and no sample has this name.

    Raises
    ------
    FileError
        It names files and samples whose names are near.
    """
    from .. import samples

    if not os.path.lexists(os.path.expanduser(path)) and path not in samples.names():
        near = _near(path, samples.names())
        raise FileError(path, "does not exist", f"is it {' or '.join(near)}?" if near else "check the path")


def _near(path: str, samples: tuple[str, ...]) -> list[str]:
    """Paths beside a path, and samples, whose names are like its own."""
    folder, name = os.path.split(path)
    try:
        beside = os.listdir(os.path.expanduser(folder) or ".")
    except OSError:
        beside = []
    known = {other: os.path.join(folder, other) for other in beside}
    if not folder:
        known = {sample: f"the sample {sample}" for sample in samples} | known
    return [known[other] for other in difflib.get_close_matches(name, known, n=3, cutoff=0.7)]
