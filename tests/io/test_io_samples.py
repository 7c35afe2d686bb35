"""Scaling and text: the arithmetic of readers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from airlight.errors import FileError, LimitError
from airlight.io.options import ReadOptions
from airlight.io.samples import parse_text, scaled
from airlight.io.units import unit_name

INTEGERS = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"]


@settings(max_examples=200, deadline=None)
@given(
    array=st.sampled_from(INTEGERS).flatmap(lambda dtype: hnp.arrays(dtype, (2, 3, 4))),
    slope=st.integers(-300, 300),
    intercept=st.integers(-70000, 70000),
)
def test_whole_scaling_is_exact(array: np.ndarray, slope: int, intercept: int) -> None:
    exact = array.astype(object) * slope + intercept
    result = scaled(array.copy(), float(slope), float(intercept), "a", ReadOptions())
    if exact.min() >= -(1 << 63) and exact.max() < 1 << 63:
        assert result.dtype.kind in "iu"
        assert (result.astype(object) == exact).all()
    else:
        np.testing.assert_allclose(result.astype(float), exact.astype(float), rtol=1e-6, atol=1e5)


def test_scaling_keeps_within_the_limit_and_finite() -> None:
    array = np.zeros((4, 4, 4), np.int16)
    with pytest.raises(LimitError):
        scaled(array, 0.5, 0, "a", ReadOptions(max_bytes=200))
    with pytest.raises(FileError, match="nan"):
        scaled(array, float("nan"), 0, "a", ReadOptions())


@settings(max_examples=100, deadline=None)
@given(array=st.sampled_from([*INTEGERS, "float32", "float64"]).flatmap(lambda d: hnp.arrays(d, (2, 3, 4))))
def test_text_of_any_piece_size(array: np.ndarray) -> None:
    text = " \n".join(repr(n) for n in array.ravel().tolist()).encode()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("airlight.io.samples.TEXT_PIECE_BYTES", 7)
        np.testing.assert_array_equal(parse_text(text, array.dtype, array.shape, "a"), array)


@pytest.mark.parametrize("text", [b"1 2", b"1 2 3 4", b"1 2 x", b"1 2 999", b"", b"1 2 3.5"])
def test_wrong_text_is_refused(text: bytes) -> None:
    with pytest.raises(FileError):
        parse_text(text, np.dtype("u1"), (3,), "a")


def test_units_have_one_name() -> None:
    assert [unit_name(u) for u in ("Micron", "µm", "mm", " sec ", "parsec", "")] == ["um", "um", "mm", "s", "parsec", ""]
