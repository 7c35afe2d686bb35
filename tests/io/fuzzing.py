"""Damaged copies of good files; readers must answer each with a volume or one clear error."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from airlight import io
from airlight.errors import AirlightError

COUNTS = [200, pytest.param(12_000, marks=[pytest.mark.fuzz, pytest.mark.timeout(1800)])]
"""Inputs of an ordinary run, and of a marked one."""


def damaged(whole: bytes, rng: np.random.Generator) -> bytes:
    """A copy that is cut, shortened, lengthened or overwritten at one to four places, mostly near its begin."""
    data = bytearray(whole)
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(0, len(data))) if rng.random() < 0.6 else int(rng.integers(0, min(len(data), 600)))
        length = int(rng.integers(1, 9))
        kind = int(rng.integers(0, 9))
        if kind == 0:
            del data[max(1, at) :]
        elif kind == 1:
            del data[at : at + length]
            data = data or bytearray(b"x")
        elif kind == 2:
            data[at:at] = rng.bytes(length)
        elif kind <= 4:
            data[at : at + length] = bytes([int(rng.choice([0, 255, 127, 128]))]) * length
        elif kind <= 6:
            data[at] = int(rng.integers(0, 256))
        else:
            data[at : at + length] = rng.bytes(length)
    return bytes(data)


def open_damaged(seeds: list[bytes], target: Path, count: int, seed: int = 5) -> int:
    """Open ``count`` damaged files; returns how many were refused. Anything but our own errors goes through."""
    rng = np.random.default_rng(seed)
    refused = 0
    for number in range(count):
        target.write_bytes(damaged(seeds[number % len(seeds)], rng))
        try:
            io.open(target, max_memory=1 << 26)
        except AirlightError:
            refused += 1
    return refused


def open_damaged_elsewhere(seeds: list[Path], target: Path, count: int) -> None:
    """The same in processes of their own, for parsers in C that may crash: this one would go with them."""
    step = 2000
    for start in range(0, count, step):
        command = [sys.executable, __file__, str(target), str(min(step, count - start)), str(start), *map(str, seeds)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
        assert done.returncode == 0, f"seed {start}: exit {done.returncode}\n{done.stderr[-3000:]}"


if __name__ == "__main__":
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
    _, place, number_of_files, first, *files = sys.argv
    open_damaged([Path(f).read_bytes() for f in files], Path(place), int(number_of_files), int(first))
