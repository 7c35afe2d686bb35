"""Sums and maxima: their laws, their points, and what they refuse."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from functions import functions
from hypothesis import given, settings
from hypothesis import strategies as st

from airlight.errors import ValueRangeError
from airlight.transfer import TransferFunction

NOTHING = TransferFunction([(0, "red", 0.0)])


def places(*some: TransferFunction) -> np.ndarray:
    """Values at, just below and between all control points, and beyond them."""
    knots = np.unique(np.concatenate([f.values for f in some]))
    between = np.linspace(knots[0] - 3, knots[-1] + 3, 501)
    return np.concatenate([knots, np.nextafter(knots, -np.inf), between])


def assert_alike(a: TransferFunction, b: TransferFunction, tolerance: float = 1e-9) -> None:
    """What can be seen is the same: extinction, and colour where there is extinction."""
    at = places(a, b)
    (a_rgb, a_tau), (b_rgb, b_tau) = a(at), b(at)
    np.testing.assert_allclose(a_tau, b_tau, rtol=1e-9, atol=1e-12)
    # Next to a step the last bit of a value decides.
    seen = (a_tau > 1e-9) & (b_tau > 1e-9)
    np.testing.assert_allclose(a_rgb[seen], b_rgb[seen], rtol=0, atol=tolerance)


@given(functions(), functions())
def test_sums_add_extinctions_and_sources(a, b):
    total = a + b
    at = places(a, b)
    rgb, tau = total(at)
    np.testing.assert_allclose(tau, a(at)[1] + b(at)[1], rtol=1e-9, atol=1e-12)
    source = a.source(at) + b.source(at)
    assert np.abs(rgb * tau[:, None] - source).max() <= 1.001e-3 * tau.max()
    seen = tau > 1e-9
    assert np.abs(rgb - source / np.where(seen, tau, 1.0)[:, None])[seen].max(initial=0) <= 1.01e-3


@given(functions(), functions())
def test_sums_keep_all_control_points(a, b):
    total = a + b
    parts = [f.values for f in (a, b) if f.extinctions.any()] or [a.values]
    assert set(np.concatenate(parts)) <= set(total.values)
    assert total.domain == (min(p[0] for p in parts), max(p[-1] for p in parts))


@given(functions(), functions())
def test_both_are_commutative(a, b):
    assert_alike(a + b, b + a)
    assert_alike(a | b, b | a)


@settings(max_examples=50)
@given(functions(), functions(), functions())
def test_sums_are_associative(a, b, c):
    assert_alike((a + b) + c, a + (b + c), 5e-3)


@given(functions(), functions(), functions())
def test_maxima_are_associative_in_extinction(a, b, c):
    left, right = (a | b) | c, a | (b | c)
    at = places(left, right)
    greatest = np.max([f(at)[1] for f in (a, b, c)], axis=0)
    # Crossings carry the rounding of their place.
    for function in (left, right):
        np.testing.assert_allclose(function(at)[1], greatest, rtol=0, atol=1e-9)


@given(functions(), functions())
def test_the_greater_one_wins(a, b):
    most = a | b
    at = places(a, b)
    (a_rgb, a_tau), (b_rgb, b_tau), (rgb, tau) = a(at), b(at), most(at)
    np.testing.assert_allclose(tau, np.maximum(a_tau, b_tau), rtol=0, atol=1e-9)
    for wins, own in ((a_tau > b_tau + 1e-6, a_rgb), (b_tau > a_tau + 1e-6, b_rgb)):
        np.testing.assert_allclose(rgb[wins], own[wins], atol=1e-6)


@given(functions(), st.floats(0.01, 100))
def test_sums_scale(a, factor):
    b = TransferFunction.peak(3, 8, "orange", 0.4)
    assert_alike((a + b).scaled(factor), a.scaled(factor) + b.scaled(factor))
    assert_alike(a + a, a.scaled(2))


@given(functions())
def test_nothing_adds_nothing(a):
    assert a + NOTHING == a
    if a.extinctions.any():
        assert NOTHING + a == a
    assert_alike(a | NOTHING, a)
    assert_alike(a | a, a)


@given(functions(associated=True), functions(associated=True))
def test_associated_sums_are_exact(a, b):
    total = a + b
    at = places(a, b)
    np.testing.assert_allclose(total(at)[1], a(at)[1] + b(at)[1], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(total.source(at), a.source(at) + b.source(at), rtol=1e-12, atol=1e-15)
    assert total.associated


def test_faint_haze_before_a_solid_is_followed():
    haze = TransferFunction([(0, "blue", 1e-6), (10, "blue", 1e-6)])
    solid = TransferFunction.ramp(0, 10, "red", 1.0)
    total = haze + solid
    at = np.concatenate([10.0 ** np.arange(-8, 1), np.linspace(0, 10, 97)])
    expected = (haze.source(at) + solid.source(at)) / (haze(at)[1] + solid(at)[1])[:, None]
    assert np.abs(total(at)[0] - expected).max() < 1e-3
    assert len(total.points) < 60


def test_steps_stay_exact():
    total = TransferFunction.box(0, 1, "red", 1.0) + TransferFunction.box(1, 2, "blue", 3.0)
    assert [p[0] for p in total.points] == [0, 0, 1, 1, 2, 2]
    assert total.extinctions.tolist() == [0, 1, 1, 3, 3, 0]


def test_peaks_side_by_side_keep_their_colours():
    a, b, c = TransferFunction.peak(1, 2, "red"), TransferFunction.peak(3, 2, "lime"), TransferFunction.peak(9, 2, "blue")
    for total in (a + b + c, a | b | c):
        rgb, tau = total([0.5, 1.9, 2.1, 3, 8.1, 9.9])
        assert tau.tolist() == pytest.approx([0.5, 0.1, 0.1, 1, 0.1, 0.1])
        np.testing.assert_allclose(rgb, [[1, 0, 0]] * 2 + [[0, 1, 0]] * 2 + [[0, 0, 1]] * 2, atol=1e-12)
        # A step in colour only where the red one ends and the green one begins.
        assert np.diff(total.values).tolist().count(0) == 1


def test_crossings_become_points():
    a, b = TransferFunction.ramp(0, 4, "red"), TransferFunction([(0, "blue", 0.5)])
    most = a | b
    assert set(most.values) == {0, 2, 4}
    assert most([1.999, 2.001])[0].tolist() == [[0, 0, 1], [1, 0, 0]]


def test_three_in_any_order():
    some = [TransferFunction.gaussian(0, 2, "red", 0.2), TransferFunction.box(1, 3, "gold"), TransferFunction.ramp(2, 5)]
    first, *others = [a + b + c for a, b, c in permutations(some)]
    for other in others:
        assert_alike(first, other, 3e-3)


@pytest.mark.parametrize("sign", ["+", "|"])
def test_associated_and_not_are_refused(sign):
    glow = TransferFunction([(0, "red", 0)], associated=True)
    with pytest.raises(ValueRangeError, match=r"joins an associated function with one that is not: draw them as two layers"):
        _ = glow + NOTHING if sign == "+" else glow | NOTHING


def test_other_things_are_refused():
    with pytest.raises(TypeError):
        NOTHING + 1
    with pytest.raises(TypeError):
        NOTHING | "red"


# -- moved and clipped


@given(functions(), st.integers(-30, 30), st.integers(1, 30))
def test_clipped_leaves_a_range(a, low, width):
    left = a.clipped(low, low + width)
    at = places(a, left)
    inside = (at >= low) & (at < low + width)
    np.testing.assert_allclose(left(at)[1], np.where(inside, a(at)[1], 0), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(left(at)[0][inside], a(at)[0][inside], rtol=1e-9, atol=1e-12)
    assert_alike(left.clipped(low, low + width), left)


def test_clipped_associated_glows_no_more():
    left = TransferFunction([(0, (1, 1, 1), 0)], associated=True).clipped(1, 2)
    assert left.source([0.5, 1.5, 2.5])[:, 0].tolist() == [0, 1, 0]


@given(functions())
def test_reversed_colours(a):
    turned = a.with_reversed_colours()
    assert turned.domain == a.domain
    assert turned.with_reversed_colours()(a.values)[1].tolist() == pytest.approx(a(a.values)[1].tolist())
    low, high = a.domain
    at = np.setdiff1d(np.linspace(low - 1, high + 1, 97), np.concatenate([a.values, low + high - a.values]))
    np.testing.assert_allclose(turned(at)[0], a(low + high - at)[0], atol=1e-9)
    np.testing.assert_allclose(turned(at)[1], a(at)[1], atol=1e-9)


def test_shifted_and_rescaled():
    a = TransferFunction([(0, "red", 0.0), (5, "red", 1.0), (5, "blue", 2.0), (10, "blue", 3.0)])
    assert a.shifted(2.5).values.tolist() == [2.5, 7.5, 7.5, 12.5]
    moved = a.rescaled(to=(-1, 1))
    assert moved.values.tolist() == [-1, 0, 0, 1]
    assert moved.extinctions.tolist() == a.extinctions.tolist()
    assert moved.rescaled(to=(0, 10)) == a
    assert a.rescaled(to=(0.1, 0.7)).domain == (0.1, 0.7)


def test_with_opacity():
    a = TransferFunction.ramp(0, 1, extinction=7).with_opacity(0.75, length=2)
    assert 1 - np.exp(-a.extinctions.max() * 2) == pytest.approx(0.75)
    with pytest.raises(ValueRangeError, match="has no extinction"):
        NOTHING.with_opacity(0.5, 1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda f: f.clipped(2, 1), "transfer.clipped runs from 2 to 1"),
        (lambda f: f.clipped(0, np.nan), "transfer.clipped is nan, must be a finite number"),
        (lambda f: f.rescaled(to=(1, 1)), "transfer.rescaled.to runs from 1 to 1"),
        (lambda f: f.clipped(0, 1) and NOTHING.rescaled(to=(0, 1)), "one value 0"),
        (lambda f: f.shifted(np.inf), "transfer.shifted.by is inf"),
        (lambda f: f.with_opacity(1.5, 1), "opacity runs from 1.5 to 1.5"),
        (lambda f: f.with_opacity(0.5, 0), "length is 0, must be finite and above 0"),
    ],
)
def test_mistakes_are_told(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make(TransferFunction.ramp(0, 1))
