"""Ranges of blocks of voxels: against a plain look at each block."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import airlight as al
from airlight.gpu import blocks, ranges
from airlight.labels import drawn_labels, label_numbers
from airlight.stage import BLOCK_VOXELS, BlockRanges, Grid, Within


def plainly(samples, reach: int):
    """Least and greatest of each block, one by one; NaN is left out."""
    counts = [ranges.block_count(n) for n in samples.shape]
    least, greatest = np.empty(counts), np.empty(counts)
    for block in np.ndindex(*counts):
        part = samples[tuple(slice(max(b * BLOCK_VOXELS - reach, 0), (b + 1) * BLOCK_VOXELS + reach + 1) for b in block)]
        known = part[np.isfinite(part)].astype(np.float64)
        least[block], greatest[block] = known.min(initial=np.inf), known.max(initial=-np.inf)
    return least, greatest


@given(
    seed=st.integers(0, 10_000),
    shape=st.tuples(*[st.integers(1, 14)] * 3),
    kind=st.sampled_from(["?", "u1", "i2", "u2", "i4", "f2", "f4", "f8"]),
    reach=st.integers(0, 6),
    chunk=st.sampled_from([1, 1 << 20]),
    gaps=st.booleans(),
)
def test_ranges_are_those_of_each_block(seed, shape, kind, reach, chunk, gaps):
    rng = np.random.default_rng(seed)
    samples = rng.integers(0, 2 if kind == "?" else 100, shape).astype(kind)
    has_gaps = gaps and samples.dtype.kind == "f"
    if has_gaps:
        samples[rng.random(shape) < 0.3] = np.nan
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ranges, "CHUNK_BYTES", chunk)
        found = ranges.block_ranges(samples, reach, None, has_gaps)
    assert np.array_equal([found.least, found.greatest], plainly(samples, reach))


def test_samples_without_data_are_left_out():
    samples = np.full((6, 5, 5), 7, np.int16)
    samples[2:] = -1000
    samples[:2, 0, 0] = 3
    found = ranges.block_ranges(samples, 0, -1000.0, True)
    assert found.least.ravel().tolist() == [3, 32767]
    assert found.greatest.ravel().tolist() == [7, -32768]


def test_few_bytes(device):
    """Ranges keep the type of the samples; with leaps they are at most a twentieth of the volume."""
    volume = al.Volume(np.zeros((65, 65, 65), np.uint16))
    asked = BlockRanges(Grid(volume, (0,), 0, True))
    found = blocks.known_ranges(device, asked)
    assert found.least.dtype == np.uint16
    made = blocks.make_leaps(device, blocks.occupied(((Within(asked, -np.inf, 5.0),),), lambda _: found, found.least.shape))
    assert found.bytes + made.bytes <= 0.05 * volume.array.nbytes


@given(seed=st.integers(0, 10_000), of_least=st.booleans())
def test_half_floats_are_not_rounded_inwards(seed, of_least):
    ends = np.random.default_rng(seed).normal(0, 3000, 50).astype(np.float32)
    halves = blocks.outwards(ends, of_least).astype(np.float32)
    assert (halves <= ends).all() if of_least else (halves >= ends).all()
    assert np.abs(halves - ends).max() <= 8


@given(seed=st.integers(0, 10_000), reach=st.integers(0, 5), background=st.sampled_from([0, 3, 9]))
def test_regions_that_are_not_drawn(seed, reach, background):
    """Blocks whose labels, and the background round all, are hidden have no share; those whose are all drawn have all of it."""
    rng = np.random.default_rng(seed)
    cells = rng.choice([0, 2, 3, 9, 40], (3, 4, 3)).repeat(4, 0).repeat(4, 1).repeat(4, 2).astype(np.int16)
    hidden = {int(label) for label in (0, 2, 3, 9, 40) if rng.random() < 0.5}
    labels = al.Labels(al.Volume(cells), background=background, hidden=hidden)
    numbers = label_numbers(labels.volume, 0, background)
    shares = ranges.label_shares(ranges.label_ranges(numbers, reach), drawn_labels(labels))
    drawn = np.pad(~np.isin(cells, list(hidden)), 1 + reach, constant_values=background not in hidden)
    for block in np.ndindex(*shares.least.shape):
        part = drawn[tuple(slice(b * BLOCK_VOXELS, (b + 1) * BLOCK_VOXELS + 2 * reach + 3) for b in block)]
        inner = drawn[tuple(slice(b * BLOCK_VOXELS + 1, (b + 1) * BLOCK_VOXELS + 2 * reach + 2) for b in block)]
        assert shares.greatest[block] >= inner.any()
        assert shares.least[block] <= inner.all()
        if not part.any() and len(hidden) == 5:
            assert shares.greatest[block] == 0
