"""Damaging files: what a reader must survive with a volume or one of our errors, in little time and memory."""

from __future__ import annotations

import itertools
import resource
import time
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from airlight import io
from airlight.errors import AirlightError

MAX_MEMORY = 32 << 20
MOST_SECONDS = 10.0
MOST_GROWTH = 2 * MAX_MEMORY
FUZZ_EXAMPLES = 10_000
ORDINARY_EXAMPLES = 60

HOSTILE = [b"0", b"-1", b"1", b"2", b"3", b"7", b"255", b"65536", b"2147483647", b"4294967296", b"18446744073709551616"]
HOSTILE += [b"9" * 400, b"nan", b"inf", b"1e999", b"-1e-999", b"none", b"", b"\0", b"()", b"(1,2)", b"../x", b"/dev/zero"]
HOSTILE += [b"LIST", b"%d", b"%s", b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"(" * 500, b"<a>" * 500]
HOSTILE += [b"x" * 5000, b"\n\n", b"\r\n", b":", b"=", b" "]


@st.composite
def damaged(draw: st.DrawFn, seeds: list[bytes]) -> bytes:
    """One of the seeds with some of its bytes cut, flipped, exchanged or replaced by what readers stumble over."""
    data = bytearray(draw(st.sampled_from(seeds)))
    for _ in range(draw(st.integers(1, 4))):
        reach = draw(st.sampled_from([64, 400, 1 << 30]))  # headers are where the harm is
        at = draw(st.integers(0, max(0, min(len(data), reach) - 1)))
        deed = draw(st.sampled_from(["flip", "hostile", "number", "cut", "drop", "repeat", "bytes"]))
        if deed == "flip" and data:
            data[at] ^= 1 << draw(st.integers(0, 7))
        elif deed == "hostile":
            data[at : at + draw(st.integers(0, 8))] = draw(st.sampled_from(HOSTILE))
        elif deed == "number":
            start = next((i for i in range(at, len(data)) if 48 <= data[i] <= 57), at)
            end = next((i for i in range(start, len(data)) if not 48 <= data[i] <= 57), len(data))
            data[start:end] = draw(st.sampled_from(HOSTILE))
        elif deed == "cut":
            del data[at:]
        elif deed == "drop":
            del data[at : at + draw(st.integers(1, 64))]
        elif deed == "repeat":
            data[at:at] = data[at : at + draw(st.integers(1, 200))]
        else:
            data[at : at + 4] = draw(st.binary(min_size=1, max_size=8))
    return bytes(data)


def survive(folder: Path, suffix: str, seeds: list[bytes], examples: int) -> dict[str, int]:
    """Open ``examples`` damaged files; returns how many read well, how many were refused, and the growth in memory."""
    tally = {"read": 0, "refused": 0, "growth": 0}
    numbers = itertools.count()
    for seed in seeds:
        path = folder / f"sound{next(numbers)}{suffix}"
        path.write_bytes(seed)
        io.open(path)  # also warms up: imports do not count as growth

    @settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(data=st.one_of(damaged(seeds), damaged(seeds), damaged(seeds), st.binary(max_size=2000)))
    def open_one(data: bytes) -> None:
        path = folder / f"damaged{suffix}"
        path.write_bytes(data)
        before, start = _peak_bytes(), time.perf_counter()
        try:
            volume = io.open(path, max_memory=MAX_MEMORY)
            volume.array.max()
            tally["read"] += 1
            message = ""
        except AirlightError as error:
            message = str(error)
            tally["refused"] += 1
        assert "\n" not in message
        assert len(message) < 2000
        assert time.perf_counter() - start < MOST_SECONDS
        growth = _peak_bytes() - before  # of one reading, since hypothesis remembers its examples
        assert growth < MOST_GROWTH
        tally["growth"] = max(tally["growth"], growth)

    open_one()
    return tally


def _peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
