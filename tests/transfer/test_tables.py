"""Tables against adaptive quadrature in float64, entry by entry, and the laws they keep."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from airlight.errors import ValueRangeError
from airlight.transfer import TransferFunction
from airlight.transfer.tables import LENGTHS, function_table, opacity_error, slab_table

points = st.lists(
    st.tuples(
        st.integers(0, 40).map(float),
        st.tuples(*[st.floats(0, 1)] * 3),
        st.one_of(st.just(0.0), st.floats(1e-6, 5.0), st.floats(5.0, 60.0)),
    ),
    min_size=1,
    max_size=6,
).map(lambda p: sorted(p, key=lambda q: q[0]))
functions = st.builds(TransferFunction, points, st.booleans())


def truth(tf: TransferFunction, front: float, back: float, length: float) -> tuple[float, float]:
    """Red and opacity of a slab, by quadrature between the control points."""
    way = back - front
    breaks = sorted({0.0, 1.0, *((v - front) / way for v in tf.values if 0 < (v - front) / way < 1)}) if way else [0.0, 1.0]

    def depth_to(x: float) -> float:
        """Extinction integrated to x: trapezoids between control points, whose ends are taken from the inside."""
        total = 0.0
        for a, b in itertools.pairwise(breaks):
            b = min(b, x)
            if b <= a:
                break
            middle = tf(front + way * (a + b) / 2)[1]
            total += float(middle) * (b - a) * length
        return total

    def red(x: float) -> float:
        return float(tf.source(front + way * x)[0]) * np.exp(-depth_to(x)) * length

    parts = [quad(red, a, b, epsabs=1e-10, limit=200)[0] for a, b in itertools.pairwise(breaks)]
    return sum(parts), -np.expm1(-depth_to(1.0))


@settings(max_examples=25)
@given(tf=functions, seed=st.integers(0, 1000), length=st.sampled_from([0.01, 1.0, 3.0]))
def test_entries_are_the_integrals(tf, seed, length):
    n = 24
    table = slab_table(tf, length, n)
    values = np.linspace(table.first_value, table.last_value, n)
    rng = np.random.default_rng(seed)
    for _ in range(4):
        i, j = rng.integers(0, n, 2)
        if i == j:
            continue
        for layer in range(1, LENGTHS):
            d = length * layer / (LENGTHS - 1)
            *source, extinction = table.texels[layer, j, i].astype(np.float64)
            depth = extinction * d
            share = -np.expm1(-depth) / depth if depth > 1e-12 else 1.0
            red, alpha = truth(tf, values[i], values[j], d)
            assert -np.expm1(-depth) == pytest.approx(alpha, abs=2e-6)
            # A decay that is steep within one segment is met by four nodes to a thousandth of the colour.
            assert source[0] * d * share == pytest.approx(red, abs=2e-3 if depth > 1 else 2e-5)


def test_constant_functions_are_exact_at_any_depth():
    for extinction in (1e-6, 1.0, 100.0):
        tf = TransferFunction([(0, (0.5, 0.2, 1), extinction), (1, (0.5, 0.2, 1), extinction)])
        texels = slab_table(tf, 2.0, 16).texels
        assert texels[..., 3] == pytest.approx(extinction, rel=1e-6)
        assert texels[..., :3] == pytest.approx(
            np.broadcast_to(np.array([0.5, 0.2, 1]) * extinction, (LENGTHS, 16, 16, 3)), rel=1e-5
        )


def test_a_step_at_the_first_value_leaves_what_lies_before_it():
    tf = TransferFunction([(1, "black", 0), (1, "white", 5), (2, "white", 5)])
    assert function_table(tf).texels[0, 0, 0].tolist() == [0, 0, 0, 0]
    assert slab_table(tf, 1.0, 8).texels[:, 0, 0].any() == False  # noqa: E712


def test_the_front_is_the_column():
    """Seen from the clear side a red wall lies behind blue fog; seen from the other side it hides it."""
    tf = TransferFunction([(0, (0, 0, 1), 1.0), (1, (1, 0, 0), 20.0)])
    texels = slab_table(tf, 1.0, 16).texels[-1]
    assert texels[15, 0, 2] > texels[0, 15, 2]


@given(functions)
def test_empty_stretches_are_empty_and_maximal(tf):
    for low, high in tf.empty_stretches:
        a, b = max(low, -100.0), min(high, 200.0)
        inside = np.linspace(a, b, 11)[1:-1]
        assert not tf(inside)[1].any()
        assert not tf.source(inside).any()
    for value, extinction in zip(tf.values, tf.extinctions, strict=True):
        if extinction > 0:
            assert not any(low < value < high for low, high in tf.empty_stretches)


def test_wrong_sizes_are_refused():
    tf = TransferFunction([(0, "black", 0), (1, "white", 1)])
    with pytest.raises(ValueRangeError, match=r"entries is 1, must lie in \[2, 4096\]"):
        slab_table(tf, 1.0, 1)
    with pytest.raises(ValueRangeError, match="slabs of length"):
        slab_table(tf, 0.0)


def test_the_error_of_interpolation_is_told():
    """None for straight functions, small for control points on entries, and what it is for a step and a needle."""
    assert opacity_error(TransferFunction([(0, "black", 0), (100, "white", 1)]), 1.0) < 1e-6
    assert opacity_error(TransferFunction([(0, "black", 0), (40, "white", 1), (100, "white", 0)]), 1.0) < 1 / 255
    assert (
        opacity_error(TransferFunction([(0, "black", 0), (50.03, "black", 0), (50.03, "white", 3), (100, "white", 3)]), 1.0)
        > 0.1
    )
    assert (
        opacity_error(
            TransferFunction([(0, "red", 1), (50.03, "red", 1), (50.1, "red", 9), (50.13, "red", 1), (99, "red", 1)]), 1.0
        )
        > 0.01
    )
