"""Slabs and integrals of functions against adaptive quadrature in float64; sizes of tables against the error they leave."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from functions import functions
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from airlight.errors import ValueRangeError
from airlight.transfer import TransferFunction
from airlight.transfer.cells import BINS, ROWS_PER_CELL, cells_of, even_cells, function_texels, integral_to, value_axis
from airlight.transfer.tables import (
    ACCURATE,
    LEAST_MOVE,
    SIZES,
    check_table,
    colour_error,
    entries_needed,
    segment_rows,
    slab_light,
    spread_error,
)

either = st.booleans().flatmap(functions)
depths = st.sampled_from([1e-6, 1e-2, 1.0, 30.0, 1e3, 1e6])


def sources(tf: TransferFunction, value: float) -> np.ndarray:
    """Source and extinction, as integrals have them."""
    return np.append(tf.source(value), tf(value)[1])


def deepened(tf: TransferFunction, by: float) -> TransferFunction:
    """More extinction; colours stay, whatever they mean."""
    return TransferFunction([(v, rgb, by * e) for v, rgb, e in tf.points], tf.associated)


# -- the yardstick


def truth(tf: TransferFunction, front: float, back: float, length: float) -> np.ndarray:
    """Light (4,) of a slab and its first moment (4,): adaptive quadrature between the control points."""
    way, found, before = back - front, np.zeros(8), 0.0
    breaks = sorted({0.0, 1.0, *((v - front) / way for v in tf.values if 0 < (v - front) / way < 1)})
    for a, b in itertools.pairwise(breaks):
        # The line inside of a piece is told by two of its points.
        near, far = (np.append(*tf(front + way * (a + (b - a) * q))) for q in (0.25, 0.75))
        low, rise, run = 1.5 * near - 0.5 * far, 2 * (far - near), length * (b - a)

        def depth(x: float, low=low, rise=rise, run=run, before=before) -> float:
            return before + run * (low[3] * x + rise[3] * x * x / 2)

        def sent(x: float, channel: int, power: int, a=a, b=b, low=low, rise=rise, run=run, depth=depth) -> float:
            medium = low + rise * x
            source = medium[channel] * (medium[3] if channel < 3 and not tf.associated else 1.0)
            return source * run * np.exp(-min(depth(x), 700.0)) * (a + (b - a) * x) ** power

        # Where a decay is steep it is so next to the front.
        cuts = [0.0, *(2.0**-k for k in range(40, 0, -1)), 1.0] if depth(1.0) - before > 3 else [0.0, 1.0]
        if before < 50:
            for number, (power, channel) in enumerate(itertools.product((0, 1), range(4))):
                parts = (quad(sent, u, v, (channel, power), epsabs=1e-12)[0] for u, v in itertools.pairwise(cuts))
                found[number] += sum(parts)
        before = depth(1.0)
    return found


@settings(max_examples=25)
@given(tf=either, depth=depths, ends=st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_slabs_are_the_integrals(tf, depth, ends):
    tf = deepened(tf, depth)
    first, last = value_axis(tf)
    front, back = (first + x * (last - first) for x in ends)
    assume(abs(front - back) > 1e-3 * (last - first))
    light, moment = slab_light(tf, np.array([front]), np.array([back]), 0.7)
    np.testing.assert_allclose(np.append(light, moment), truth(tf, front, back, 0.7), atol=1e-8)


@given(tf=either, depth=depths)
def test_a_slab_of_one_value_is_homogeneous(tf, depth):
    tf = deepened(tf, depth)
    first, last = value_axis(tf)
    values = first + np.array([0.123, 0.57, 0.91]) * (last - first)
    light, moment = slab_light(tf, values, values, 2.0)
    extinction = tf(values)[1]
    x = np.maximum(2.0 * extinction, 1e-9)
    np.testing.assert_allclose(light[:, 3], -np.expm1(-2.0 * extinction), atol=1e-7)
    expected = tf.source(values) * (2.0 * -np.expm1(-x) / x)[:, None]
    np.testing.assert_allclose(light[:, :3], expected, atol=1e-6, rtol=1e-5)
    share = (1 - (1 + x) * np.exp(-np.minimum(x, 700.0))) / (x * -np.expm1(-x))
    np.testing.assert_allclose(moment[:, 3], light[:, 3] * np.where(x > 1e-4, share, 0.5), atol=1e-6)


def test_the_front_is_seen_first():
    """Seen from the clear side a red wall lies behind blue fog; seen from the other side it hides it."""
    tf = TransferFunction([(0, (0, 0, 1), 1.0), (1, (1, 0, 0), 20.0)])
    light, _ = slab_light(tf, np.array([0.0, 1.0]), np.array([1.0, 0.0]), 1.0)
    assert light[0, 2] > 2 * light[1, 2]


@given(tf=either, depth=depths, at=st.floats(0.05, 0.95))
def test_two_parts_of_a_slab_make_the_whole(tf, depth, at):
    tf = deepened(tf, depth)
    first, last = value_axis(tf)
    middle = first + at * (last - first)
    front, back = np.array([first, first, middle]), np.array([last, middle, last])
    whole, near, far = (slab_light(tf, front[k : k + 1], back[k : k + 1], d)[0][0] for k, d in enumerate((1.0, at, 1 - at)))
    np.testing.assert_allclose(whole, near + (1 - near[3]) * far, atol=1e-8)


# -- cells


def integral(tf: TransferFunction, value: float) -> np.ndarray:
    """Source and extinction over the share of the axis up to a value, by quadrature."""
    first, last = value_axis(tf)
    breaks = [first, *(v for v in np.unique(tf.values) if first < v < value), value]
    total = np.zeros(4)
    for a, b in itertools.pairwise(breaks):
        total += [quad(lambda s, c=c: sources(tf, s)[c], a, b, epsabs=1e-12)[0] for c in range(4)]
    return total / (last - first)


@settings(max_examples=30)
@given(tf=either, share=st.floats(0, 1))
def test_integrals_are_the_integrals(tf, share):
    first, last = value_axis(tf)
    value = first + share * (last - first)
    np.testing.assert_allclose(integral_to(tf, value), integral(tf, value), atol=1e-6)


@given(tf=either)
def test_integrals_grow_from_zero_and_are_held_beyond_the_ends(tf):
    first, last = value_axis(tf)
    found = integral_to(tf, np.linspace(first - 1, last + 1, 301))
    assert not found[0].any()
    assert (np.diff(found, axis=0) >= -1e-12).all()
    np.testing.assert_array_equal(found[-1], integral_to(tf, last))


def reached(tf: TransferFunction, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Medium and integral (n, 4) at values inside the axis: what ``wgsl/transfer/cells.wgsl`` makes of the texels."""
    rows = function_texels(tf).reshape(-1, 4)
    first, last = (np.float32(v) for v in value_axis(tf))
    per_value = np.float32(1) / (last - first)
    media, sums = [], []
    for value in values.astype(np.float32):
        place = np.float32(np.clip((value - first) * per_value, 0, 1))
        even = np.float32(even_cells(tf))
        if even:
            cell = min(int(place * even), int(even) - 1)
            row, w, cells = cell * (ROWS_PER_CELL - 1), place * even - np.float32(cell), even
        else:
            bin_row = rows[int(min(place * BINS, BINS - 1))]
            row, head = int(bin_row[0]), bin_row[1:]
            while value >= head[1]:
                row += ROWS_PER_CELL
                head = rows[row, :3]
            w, row, cells = np.clip((value - head[0]) * head[2], 0, 1), row + 1, head[2] / per_value
        start, end = rows[row], rows[row + 1]
        rise = end - start
        part = w * (start + rise * w / 2)
        if not tf.associated:
            cross = (start[:3] * end[3] + end[:3] * start[3]) / 2 - start[:3] * start[3]
            part[:3] = w * (start[:3] * start[3] + w * (cross + w * rise[:3] * rise[3] / 3))
        media.append(start + w * rise)
        sums.append(rows[row + 2].astype(np.float64) + (rows[row + 3] + part / cells))
    return np.array(media), np.array(sums)


@settings(max_examples=30)
@given(tf=either)
def test_texels_hold_the_function_and_its_integral(tf):
    first, last = value_axis(tf)
    values = (np.linspace(first, last, 103)[1:-1] + 0.00123 * (last - first)).astype(np.float32)
    media, sums = reached(tf, values)
    np.testing.assert_allclose(media, np.append(tf(values)[0], tf(values)[1][:, None], axis=1), atol=1e-5)
    if tf.domain[0] < tf.domain[1]:  # on the narrow axis of one value alone 32 bits tell few places apart
        np.testing.assert_allclose(sums, integral_to(tf, values), atol=3e-7)


def test_texels_of_thousands_of_control_points(rng):
    spread = np.sort(rng.random(3000))
    tf = TransferFunction([(v, tuple(rng.random(3)), e) for v, e in zip(spread, rng.random(3000), strict=True)])
    assert even_cells(tf) == 0
    media, sums = reached(tf, spread[10:-10:97])
    np.testing.assert_allclose(sums, integral_to(tf, spread[10:-10:97].astype(np.float32)), atol=1e-6)
    assert len(media) > 20


@pytest.mark.parametrize(
    ("values", "cells"),
    [((0, 1), 64), ((0, 1, 2), 64), ((0, 1, 3), 66), ((0, 1, 1, 2), 0), ((5,), 64), (range(256), 255), ((0, 2**-0.5, 1), 0)],
)
def test_cells_are_equally_wide_where_they_can_be(values, cells):
    tf = TransferFunction([(v, "white", k) for k, v in enumerate(values)])
    assert even_cells(tf) == cells
    known = cells_of(tf)
    apart = np.abs(known.borders[:, None] - tf.values).min(axis=0)
    assert (apart < 1e-3 * (known.axis[1] - known.axis[0])).all()


@given(tf=either)
def test_empty_stretches_are_empty_and_maximal(tf):
    for low, high in tf.empty_stretches:
        inside = np.linspace(max(low, -100.0), min(high, 200.0), 11)[1:-1]
        assert not tf(inside)[1].any()
        assert not tf.source(inside).any()
    for value, extinction in zip(tf.values, tf.extinctions, strict=True):
        if extinction > 0:
            assert not any(low < value < high for low, high in tf.empty_stretches)


# -- what the device is fed


@given(tf=either, entries=st.integers(2, 40))
def test_rows_hold_entries_and_pieces(tf, entries):
    rows = segment_rows(tf, entries)
    entry, piece = rows[: 3 * entries], rows[3 * entries :]
    first, last = value_axis(tf)
    begins = entry[0::3, 0].astype(int)
    assert begins[-1] == len(piece) // 3
    inside = np.unique(tf.values[(tf.values > first) & (tf.values < last)])
    assert len(piece) // 3 <= entries - 1 + len(inside)
    # Pieces of a segment make it up, and name the entries at its ends.
    np.testing.assert_allclose(np.add.reduceat(piece[0::3, 0], begins[:-1]), 1, atol=1e-5)
    np.testing.assert_array_equal(piece[begins[:-1] * 3, 1], np.arange(entries - 1))
    np.testing.assert_array_equal(piece[begins[1:] * 3 - 3, 2], np.arange(1, entries))
    depth = np.add.reduceat(piece[0::3, 3], begins[:-1])
    exact = np.diff(integral_to(tf, np.linspace(first, last, entries))[:, 3]) * (entries - 1)
    np.testing.assert_allclose(depth, exact, atol=1e-5)


def test_wrong_sizes_are_refused():
    with pytest.raises(ValueRangeError, match=r"entries is 1, must lie in \[2, 4096\]"):
        check_table(1.0, 1)
    with pytest.raises(ValueRangeError, match=r"lengths is 65, must lie in \[1, 64\]"):
        check_table(1.0, 16, 65)
    with pytest.raises(ValueRangeError, match="slabs of length"):
        check_table(0.0, 16)


# -- what interpolation between entries costs


def drawn_error(
    tf: TransferFunction, length: float, entries: int, front: np.ndarray, back: np.ndarray, weighted: bool = False
) -> np.ndarray:
    """Errors of slabs, or of their ends, between places [entries] whose shift is interpolated between entries, in float64."""
    first, last = value_axis(tf)
    step = (last - first) / (entries - 1)

    def known(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
        values = first + step * x, first + step * y
        light, moment = slab_light(tf, *values, length)
        way = np.where(x == y, 1.0, (y - x) / (entries - 1))[:, None]
        mean = np.maximum((integral_to(tf, values[1]) - integral_to(tf, values[0])) / way, 0)
        depth = np.maximum(mean[:, 3:] * length, 1e-9)
        weight = length * -np.expm1(-depth) / depth
        through = np.exp(-np.minimum(depth, 700.0))
        exact = 0.5 - (1 - through * (1 + depth)) / (depth * (1 - through))
        move = np.maximum(np.where(depth > 1e-3, exact, depth / 12), LEAST_MOVE)
        shift = np.where((x == y)[:, None], 0.0, (light[:, :3] / weight - mean[:, :3]) / move)
        part = np.where(light > 1e-30, moment / np.maximum(light, 1e-30), 0.5 - move)
        return light, mean[:, :3], weight, move, np.append(shift, part, axis=1), moment

    low = [np.minimum(np.floor(p), entries - 2) for p in (front, back)]
    share = [p - a for p, a in zip((front, back), low, strict=True)]
    texel = np.zeros((len(front), 7))
    for i, j in itertools.product((0, 1), (0, 1)):
        weight = (share[0] if i else 1 - share[0]) * (share[1] if j else 1 - share[1])
        texel += weight[:, None] * known(low[0] + i, low[1] + j)[4]
    light, mean, weight, move, _, moment = known(front, back)
    drawn = np.append(np.clip((mean + texel[:, :3] * move) * weight, 0, mean * length), light[:, 3:], axis=1)
    off = np.abs(drawn - light)
    if weighted:
        off = np.append(off, np.abs(drawn * texel[:, 3:] - moment), axis=1)
        off = np.append(off, np.abs(drawn * (1 - texel[:, 3:]) - (light - moment)), axis=1)
    return off.max(axis=1)


def slabs_near(tf: TransferFunction, entries: int, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Places [entries] of both ends: anywhere, near each other, and near control points."""
    first, last = value_axis(tf)
    points = (tf.values - first) / (last - first) * (entries - 1)
    gap = np.minimum(np.diff(np.unique(points)).min(), 1.0)
    front = rng.choice(points, count) + rng.choice([gap, 1.0], count) * rng.uniform(-1.5, 1.5, count)
    near = front + rng.normal(0, 1.5, count)
    pair = rng.choice(points, count) + rng.choice([gap, 1.0], count) * rng.uniform(-1.5, 1.5, count)
    anywhere = rng.uniform(0, entries - 1, count)
    back = np.choose(rng.integers(0, 3, count), [near, pair, anywhere])
    front, back = (np.clip(p, 0, entries - 1 - 1e-9) for p in (front, back))
    kept = np.abs(front - back) > 0.01
    turned = rng.random(count)[kept] < 0.5
    return np.where(turned, back[kept], front[kept]), np.where(turned, front[kept], back[kept])


def kinds(rng: np.random.Generator) -> dict[str, TransferFunction]:
    """One function of each kind; extinctions up to one."""
    lots = np.sort(rng.random(12)) * 50
    return {
        "smooth": TransferFunction([(0, (0, 0, 0), 0), (3, (1, 0.6, 0.4), 0.2), (7, (0.2, 0.9, 0.4), 0.1), (12, (1, 1, 1), 1)]),
        "spiky": TransferFunction(
            [
                (0, "red", 0),
                (2, "red", 0),
                (2.3, "blue", 1),
                (2.6, "red", 0),
                (7, "red", 0),
                (7.2, "lime", 0.7),
                (7.4, "red", 0),
            ]
        ),
        "random": TransferFunction([(v, tuple(rng.random(3)), rng.random()) for v in lots]),
        "step": TransferFunction([(0, "red", 0.1), (5.03, "red", 0.1), (5.03, "red", 1), (10, "blue", 1)]),
        "steps": TransferFunction([(0, "red", 1), (5.03, "red", 1), (5.03, "blue", 1), (10, "blue", 1)]),
        "needle": TransferFunction([(0, "red", 0.1), (5.03, "red", 0.1), (5.04, "blue", 1), (5.05, "red", 0.1), (9, "red", 1)]),
    }


@pytest.mark.parametrize("kind", ["smooth", "spiky", "random", "step", "steps", "needle"])
@pytest.mark.parametrize("depth", [0.05, 0.5, 3.0, 20.0])
@pytest.mark.parametrize("weighted", [False, True])
def test_the_error_of_interpolation_is_told(kind, depth, weighted, rng):
    """The estimate is within a factor of two of what thousands of slabs show."""
    tf = deepened(kinds(rng)[kind], depth)
    for entries in (128, 512):
        seen = drawn_error(tf, 1.0, entries, *slabs_near(tf, entries, 3000, rng), weighted).max()
        assert seen / 2 < colour_error(tf, 1.0, entries, weighted) < 2 * seen or seen < 1e-4


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize(("kind", "depth"), [("smooth", 0.5), ("smooth", 10.0), ("spiky", 0.2), ("random", 0.05)])
def test_the_chosen_size_is_accurate(kind, depth, weighted, rng):
    tf = deepened(kinds(rng)[kind], depth)
    entries = entries_needed(tf, 1.0, weighted)
    assert drawn_error(tf, 1.0, entries, *slabs_near(tf, entries, 2000, rng), weighted).max() < 1.2 * ACCURATE
    assert entries == SIZES[0] or colour_error(tf, 1.0, entries // 2, weighted) > ACCURATE


@pytest.mark.parametrize("of_ends", [False, True])
@pytest.mark.parametrize("kind", ["smooth", "spiky", "random", "step", "steps", "needle"])
def test_the_error_of_an_even_spread_is_told(kind, of_ends, rng):
    """What the fast form leaves, and its even split between the ends of a slab, by thousands of slabs."""
    for depth in (0.05, 0.5, 3.0, 20.0):
        tf = deepened(kinds(rng)[kind], depth)
        first, last = value_axis(tf)
        front, back = (first + place * (last - first) / 63 for place in slabs_near(tf, 64, 3000, rng))
        light, moment = slab_light(tf, front, back, 1.0)
        mean = (integral_to(tf, back) - integral_to(tf, front)) / ((back - front) / (last - first))[:, None]
        x = np.maximum(mean[:, 3:], 1e-4)
        even = mean * -np.expm1(-x) / x
        share = (1 - (1 + x) * np.exp(-x)) / (x * -np.expm1(-x))
        ends = np.maximum(np.abs(even * share - moment), np.abs(even * (1 - share) - (light - moment)))
        seen = (ends if of_ends else np.abs(even - light)).max()
        assert seen / 1.5 - 1e-5 < spread_error(tf, 1.0, of_ends) < 1.5 * seen + 1e-5


def test_what_no_size_mends_gets_the_greatest():
    """Two opaque colours side by side are smeared over an entry, however narrow."""
    tf = TransferFunction([(0, "red", 20), (5.03, "red", 20), (5.03, "blue", 20), (10, "blue", 20)])
    assert entries_needed(tf, 1.0) == SIZES[-1]
    assert colour_error(tf, 1.0, SIZES[-1]) > 0.1


@given(tf=either, depth=depths, entries=st.integers(2, 300))
def test_an_error_is_told_of_any_function(tf, depth, entries):
    of_colour, of_ends = (colour_error(deepened(tf, depth), 1.0, entries, weighted) for weighted in (False, True))
    assert 0 <= of_colour <= of_ends < np.inf


def test_tables_of_functions_keep_the_kind_of_their_size():
    """A power of two, with few or many cells: software adapters compile anew where a texture's size stops being one."""
    for middle in (0.5, 0.51, 0.77, 0.123456):
        lines = function_texels(TransferFunction([(0, "black", 0), (middle, "red", 1), (1, "white", 2)])).shape[1]
        assert lines == 1 << (lines.bit_length() - 1)
