"""Formats: chosen by type, range and adapter; what they cost is known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import airlight as al
from airlight.gpu.textures import choose_encoding, encode, encode_masked, encodings_of
from airlight.stage import Grid


def device(kind="discrete", unorm16=True, float32=True):
    features = frozenset({"texture-format16bit-norm"} if unorm16 else ())
    return SimpleNamespace(info=SimpleNamespace(kind=kind), features=features, traits=SimpleNamespace(filters_float32=float32))


@pytest.mark.parametrize(
    ("dtype", "where", "expected"),
    [
        ("u1", device(), "r8unorm"),
        ("u1", device("software"), "r16float"),
        ("i2", device(), "r16unorm"),
        ("i2", device("software"), "r16float"),
        ("i2", device(unorm16=False), "r32float"),
        ("i2", device(unorm16=False, float32=False), "r16float"),
        ("f2", device(), "r16float"),
        ("f4", device(), "r32float"),
        ("f4", device(float32=False), "r16float"),
    ],
)
def test_choice(dtype, where, expected):
    assert choose_encoding(np.dtype(dtype), 0, 200, filtered=True, device=where).format == expected


@pytest.mark.parametrize(
    ("low", "high", "expected"), [(-1024, 3071, "r16float"), (-1024, 3073, "r16unorm"), (0, 65535, "r16unorm")]
)
@pytest.mark.parametrize("dtype", ["i2", "u2"])
def test_software_samples_16_bits_as_half_floats_where_these_are_exact(dtype, low, high, expected):
    encoding = choose_encoding(np.dtype(dtype), low, high, filtered=True, device=device("software"))
    assert (encoding.format, encoding.error) == (expected, 0.0)
    if expected == "r16float":
        values = np.arange(max(low, 0) if dtype == "u2" else low, high + 1).astype(dtype)
        np.testing.assert_array_equal(encode(values, encoding).astype(float) * encoding.scale + encoding.offset, values)


def test_values_that_a_grid_does_not_have_may_be_beyond_half_floats():
    """The table of a type holds them all: 65535 - 10 is no half float, and nothing is said of it."""
    encoding = choose_encoding(np.dtype("u2"), 0, 20, filtered=True, device=device("software"))
    np.testing.assert_array_equal(
        encode(np.arange(21, dtype=np.uint16), encoding).astype(float) + encoding.offset, np.arange(21)
    )


@pytest.mark.parametrize(
    ("dtype", "where", "pair", "four"),
    [
        ("u1", device(), "rg8unorm", "rgba8unorm"),
        ("u1", device("software"), "rg16float", "rgba16float"),
        ("i2", device(), "rg16unorm", "rgba16unorm"),
        ("i2", device(unorm16=False, float32=False), "rg16float", "rgba16float"),
        ("f4", device(), "rg32float", "rgba32float"),
    ],
)
def test_several_samples_to_a_texel_are_held_as_one_is(dtype, where, pair, four):
    one, two, all_four = (
        choose_encoding(np.dtype(dtype), 0, 9000, filtered=True, device=where, width=width) for width in (1, 2, 4)
    )
    assert (two.format, all_four.format) == (pair, four)
    assert (one.dtype, one.scale, one.offset, one.error) == (two.dtype, two.scale, two.offset, two.error)
    assert (one.scale, one.error) == (all_four.scale, all_four.error)


def test_what_is_not_filtered_keeps_full_floats():
    where = device(unorm16=False, float32=False)
    assert choose_encoding(np.dtype("f4"), 0, 1, filtered=False, device=where).format == "r32float"


DEVICES = st.builds(device, st.sampled_from(["software", "discrete"]), st.booleans(), st.booleans())
DTYPES = st.sampled_from(["?", "u1", "i1", "u2", "i2", "u4", "i4", "f2", "f4", "f8"])


@given(data=st.data(), where=DEVICES, dtype=DTYPES, filtered=st.booleans())
def test_decoded_texels_are_the_samples_within_the_error(data, where, dtype, filtered):
    kind = np.dtype(dtype)
    elements = st.floats(-1000, 1000, width=16 if dtype == "f2" else 32) if kind.kind == "f" else None
    samples = data.draw(hnp.arrays(kind, (2, 3, 4), elements=elements))
    low, high = float(samples.min()), float(samples.max())
    encoding = choose_encoding(kind, low, high, filtered=filtered, device=where)
    texels = encode(samples, encoding)
    unorm = {"r8unorm": 255.0, "r16unorm": 65535.0}.get(encoding.format, 1.0)
    decoded = texels.astype(np.float64) / unorm * encoding.scale + encoding.offset
    error = np.abs(decoded - samples.astype(np.float64)).max()
    assert error <= encoding.error + 1e-9 * max(abs(low), abs(high))


def test_ct_as_half_floats_keeps_every_level():
    """4,096 levels, centred: whole numbers up to 2048 are exact in half floats."""
    samples = np.arange(-1024, 3072, dtype=np.int16).reshape(1, 1, -1)
    where = device(unorm16=False, float32=False)
    encoding = choose_encoding(samples.dtype, -1024, 3071, filtered=True, device=where)
    assert encoding.error == 0
    assert np.array_equal(encode(samples, encoding).astype(np.float64) + encoding.offset, samples)


@pytest.mark.parametrize(
    ("dtype", "high"), [("f4", 1e6), ("f8", 3e6), ("i4", 1 << 24), ("i4", (1 << 28) + 1), ("u2", 65535), ("u8", 1 << 40)]
)
def test_what_is_lost_beside_empty_samples_is_in_data_units(dtype, high):
    array = (np.linspace(0, 1, 27) * float(high)).astype(dtype).reshape(3, 3, 3)
    volume = al.Volume(array, no_data=0)
    (encoding,) = encodings_of(device(), Grid(volume, (0,), 0, filtered=False, masked=True))
    decoded = encode_masked(array, 0).astype(np.float64)[array != 0]
    lost = np.abs(decoded - array[array != 0].astype(np.float64)).max()
    assert lost <= encoding.error
    assert (encoding.error == 0) == (dtype in ("f4", "u2") or (high <= 1 << 24 and dtype == "i4"))
    assert encoding.error <= high * 2.0**-24


def test_each_channel_has_its_own_range():
    array = np.stack([np.linspace(0, 1, 27), np.linspace(9e5, 1e6, 27)]).astype("f4").reshape(2, 3, 3, 3)
    one, two = encodings_of(device(unorm16=False, float32=False), Grid(al.Volume(array), (0, 1), 0, filtered=True))
    assert one.format == two.format == "rg16float"
    assert (one.offset, one.scale) == (0.5, 0.5)
    assert two.scale == pytest.approx(5e4)
    assert one.error == 2.0**-13
