"""Surfaces as values, and the tables of what runs of them send."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from functions import functions
from hypothesis import given, settings
from hypothesis import strategies as st

import airlight as al
from airlight import Surface
from airlight.errors import ValueRangeError
from airlight.transfer import TransferFunction
from airlight.transfer.crossings import ROWS_ALONE, bin_count, crossing_error, pair_texels, surface_texels

share = st.floats(0, 1, allow_subnormal=False).map(lambda x: round(x, 3))
colour = st.tuples(share, share, share)
surface = st.builds(Surface, st.integers(-30, 30).map(float), colour, share, st.none() | colour, st.none() | share)
surfaces = st.lists(surface, min_size=1, max_size=7, unique_by=lambda s: s.value)
FOG = TransferFunction([(0, "red", 0.1), (50, "blue", 0.4), (50, "lime", 0.1), (120, "white", 0.2)])


@given(functions(), surfaces)
def test_round_trips_are_exact(tmp_path_factory, tf, sheets):
    path = tmp_path_factory.getbasetemp() / "surfaces.toml"
    tf = tf.with_surfaces(sheets)
    assert TransferFunction.from_dict(tf.to_dict()) == tf
    assert eval(tf.as_code(), {"al": al}) == tf
    tf.save(path)
    assert TransferFunction.load(path) == tf
    assert hash(TransferFunction.load(path)) == hash(tf)


def test_they_are_kept_in_order_and_may_be_tuples():
    tf = FOG.with_surfaces([(90, "red"), Surface(10, (0, 0, 1), 0.5, back_opacity=0.2), (40, "lime", 0.3, "white", 0.1)])
    assert [s.value for s in tf.surfaces] == [10, 40, 90]
    assert tf.surfaces[0].back == ((0, 0, 1), 0.2)
    assert tf.surfaces[1].back == ((1, 1, 1), 0.1)
    assert tf.surfaces[2].back == tf.surfaces[2].front == ((1, 0, 0), 1.0)
    assert FOG.with_surfaces(tf.surfaces) == tf
    assert tf.with_surfaces(()) == FOG


@pytest.mark.parametrize(
    ("given_surfaces", "message"),
    [
        ([(1, "red", 2)], r"transfer.surfaces\[0\].opacity is 2, must lie in \[0, 1\]"),
        ([(0,), (1, "red", 1, None, -0.5)], r"transfer.surfaces\[1\].back_opacity is -0.5"),
        ([(float("nan"),)], r"transfer.surfaces\[0\].value is nan, must be a finite number"),
        ([("a",)], r"transfer.surfaces\[0\].value is 'a', must be a finite number"),
        ([(1, "rad")], r"transfer.surfaces\[0\].colour is 'rad'"),
        ([(1,), (2,), (1,)], r"transfer.surfaces has two at the value 1: make them one"),
        ([3], r"transfer.surfaces\[0\] is 3: give a Surface"),
        (
            [{"value": 1, "color": "red"}],
            r"transfer.surfaces\[0\] has the entries \['color', 'value'\]: give value, and of colour",
        ),
        ([{"opacity": 1}], r"transfer.surfaces\[0\] has the entries \['opacity'\]"),
        ([(v,) for v in range(1025)], r"transfer.surfaces are 1025, must be at most 1024"),
    ],
)
def test_bad_surfaces_are_refused(given_surfaces, message):
    with pytest.raises(ValueRangeError, match=message):
        FOG.with_surfaces(given_surfaces)


def test_a_function_of_surfaces_alone():
    tf = TransferFunction.from_surfaces([Surface(5, "red", 0.5), Surface(2, "lime")])
    assert tf.values.tolist() == [2, 5]
    assert not tf.extinctions.any()
    assert tf.colours.tolist() == [[0, 1, 0], [1, 0, 0]]
    with pytest.raises(ValueRangeError, match=r"transfer\.surfaces is empty"):
        TransferFunction.from_surfaces([])


def test_what_moves_a_function_moves_its_surfaces():
    tf = FOG.with_surfaces([Surface(30, "red", 0.5, back_opacity=0.75), Surface(60)])
    assert [s.value for s in tf.shifted(5).surfaces] == [35, 65]
    assert [s.value for s in tf.rescaled((0, 12)).surfaces] == pytest.approx([3, 6])
    assert [s.value for s in tf.clipped(30, 60).surfaces] == [30]
    assert [(s.opacity, s.back_opacity) for s in tf.scaled(2).surfaces] == [(0.75, 0.9375), (1.0, None)]
    assert [s.opacity for s in tf.scaled(0).surfaces] == [0, 0]
    assert tf.with_opacity(0.5, 1.0).surfaces == tf.surfaces
    assert (tf + FOG).surfaces == tf.surfaces == (FOG | tf).surfaces
    with pytest.raises(ValueRangeError, match="has two at the value 30"):
        tf + tf


def test_random_surfaces_are_at_even_distances_in_the_same_colours():
    tf = TransferFunction.random_surfaces(7, (0, 100), 4, 0.2)
    assert [s.value for s in tf.surfaces] == [20, 40, 60, 80]
    assert tf == TransferFunction.random_surfaces(7, (0, 100), 4, 0.2) != TransferFunction.random_surfaces(8, (0, 100), 4, 0.2)
    with pytest.raises(ValueRangeError, match=r"count is 0, must be a whole number in \[1, 1024\]"):
        TransferFunction.random_surfaces(7, (0, 100), 0)
    with pytest.raises(ValueRangeError, match="runs from 5 to 5"):
        TransferFunction.random_surfaces(7, (5, 5))


@given(functions(), surfaces)
def test_no_surface_lies_within_an_empty_stretch(tf, sheets):
    bare, cut = tf.empty_stretches, tf.with_surfaces(sheets).empty_stretches
    for low, high in cut:
        assert not any(low < s.value <= high for s in sheets)
    # Nothing is lost but what lies between a value and the next smaller number of 32 bits.
    values = np.random.default_rng(1).uniform(-35, 35, 50)
    for v in values:
        assert any(a <= v <= b for a, b in bare) == any(a <= v <= b for a, b in cut)


@settings(max_examples=30)
@given(st.lists(st.floats(-1e3, 1e3, width=32), min_size=1, max_size=40, unique=True), st.integers(0, 99))
def test_bins_find_the_number_of_any_value(values, seed):
    """As the device does: a bin, three comparisons, and on from surface to surface."""
    tf = TransferFunction.from_surfaces([Surface(v) for v in values])
    isos = np.sort(np.array(values, dtype=np.float32))
    bins, rows = bin_count(tf), surface_texels(tf, False).reshape(-1, 4)
    per_value = np.float32(1 / (float(isos[-1]) - float(isos[0]))) if len(isos) > 1 else np.float32(0)
    near = np.nextafter(isos, np.float32(-np.inf))
    for s in [*isos, *near, *np.random.default_rng(seed).uniform(-1100, 1100, 50).astype(np.float32)]:
        place = np.clip((s - isos[0]) * per_value, np.float32(0), np.float32(1)) * np.float32(bins)
        row = rows[min(int(place), bins - 1)]
        number = int(row[0] + (s >= row[1:]).sum())
        if s >= row[3]:
            while number < len(isos) and s >= rows[bins + ROWS_ALONE * number, 0]:
                number += 1
        assert number == np.searchsorted(isos, s, side="right")


def by_steps(tf, front, back, length, count=20000):
    """Light and its moment of a slab between two values, piece by tiny piece."""
    ends = np.linspace(front, back, count + 1)
    rgb, tau = tf((ends[1:] + ends[:-1]) / 2)
    rises, through, light, moment = back > front, 1.0, np.zeros(4), np.zeros(4)
    alphas = -np.expm1(-tau * length / count)
    crossed = {int(np.argmax(ends >= s.value if rises else ends < s.value)) - 1: s for s in tf.surfaces}
    for k in range(count):
        parts = [(*rgb[k], 1.0, alphas[k])]
        if k in crossed:
            colour, opacity = crossed[k].front if rises else crossed[k].back
            parts.append((*colour, 1.0, opacity))
        for part in parts:
            seen = through * part[4] * np.array(part[:4])
            light, moment, through = light + seen, moment + seen * (k + 0.5) / count, through * (1 - part[4])
    return light, moment


@pytest.mark.parametrize("associated", [False, True])
@pytest.mark.parametrize("way", [(0, 3), (3, 0), (1, 3), (2, 0), (0, 1), (2, 1), (1, 1)])
def test_entries_are_what_runs_send(way, associated):
    tf = TransferFunction(
        FOG.points, False, [Surface(10, "gold", 0.3, "red", 0.5), Surface(50, "red", 0.2), Surface(90, "blue", 0.6)]
    )
    front, back = way
    texels = pair_texels(tf, 3.0)
    values = [s.value for s in tf.surfaces][min(way) : max(way)][:: 1 if back > front else -1]
    if front == back:
        assert not texels[:, front, back].any()
        return
    assert texels[0, front, back, :2].tolist() == [values[0], values[-1]]
    for layer, length in enumerate((0.0, 1.0, 2.0, 3.0)):
        margin = 1e-6 if back > front else -1e-6
        light, moment = by_steps(tf, values[0] - margin, values[-1] + margin, length if len(values) > 1 else 0.0)
        assert texels[1 + 2 * layer, front, back] == pytest.approx(light, abs=2e-4)
        if len(values) > 1:
            assert texels[2 + 2 * layer, front, back] == pytest.approx(moment, abs=2e-4)
            mean = texels[0, front, back, 2]
            alone = 1 - texels[1, front, back, 3]
            assert 1 - alone * np.exp(-mean * length) == pytest.approx(light[3], abs=2e-4)


def test_the_error_of_the_cubic_is_told():
    tf = FOG.with_surfaces([Surface(v, "white", 0.1) for v in (10, 40, 90)])
    assert crossing_error(tf, 1.0) < 1e-5 < crossing_error(tf, 8.0) < 1e-2 < crossing_error(tf, 100.0)
    ends = [crossing_error(tf, length, of_ends=True) for length in (1.0, 8.0, 100.0)]
    assert ends[0] < 1e-4 < ends[1] < ends[2]
    assert crossing_error(FOG.with_surfaces([Surface(5)]), 100.0) == 0


def test_first_hit_asks_for_its_value_where_there_are_surfaces_alone():
    """Their function has no extinction whose half could be the value: nothing would be drawn."""
    sheets = TransferFunction.from_surfaces([(300, "red"), (500, "blue")])
    with pytest.raises(ValueRangeError, match=r"first_hit\.iso is left to the function, .* FirstHit\(iso=300\)"):
        al.integrate.FirstHit().uniforms(SimpleNamespace(transfer=sheets))
    assert al.integrate.FirstHit(iso=5).uniforms(SimpleNamespace(transfer=sheets)).iso == 5
    fog = TransferFunction([(0, "red", 0), (10, "red", 1)], surfaces=[(300, "red")])
    assert al.integrate.FirstHit().uniforms(SimpleNamespace(transfer=fog)).iso == 5
