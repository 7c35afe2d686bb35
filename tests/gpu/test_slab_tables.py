"""Tables made on the device against the float64 yardstick, which the tests of ``transfer`` hold against quadrature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from airlight.errors import LimitError
from airlight.gpu.device import Device
from airlight.gpu.slab_tables import make_slab_table
from airlight.stage import SlabTable
from airlight.transfer import TransferFunction
from airlight.transfer.cells import integral_to, value_axis
from airlight.transfer.tables import LEAST_MOVE, slab_light

NEAR = 1e-5


def texels_of(device: Device, table: SlabTable) -> np.ndarray:
    """Texels (layers, back, front, 4) of a table, read back."""
    n, layers = table.entries, table.lengths * (2 if table.weighted else 1)
    row = -(-16 * n // 256) * 256
    texture = make_slab_table(device, table)
    data = device.queue.read_texture({"texture": texture}, {"bytes_per_row": row, "rows_per_image": n}, (n, n, layers))
    return np.frombuffer(data, np.float32).reshape(layers, n, row // 16, 4)[:, :, :n].astype(np.float64)


def move(depth: np.ndarray) -> np.ndarray:
    """1/2 - [1 - (1 + x) exp(-x)] / [x (1 - exp(-x))], at least what tables are kept by."""
    x = np.maximum(depth, 1e-3)
    through = np.exp(-np.minimum(x, 700.0))
    return np.maximum(0.5 - (1 - (1 + x) * through) / (x * (1 - through)), LEAST_MOVE)


def pairs(n: int, most: int = 3000) -> tuple[np.ndarray, np.ndarray]:
    """Entries at front and back: all pairs of two, or some of them, drawn by lot."""
    front, back = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
    apart = np.nonzero(front != back)[0]
    some = apart if len(apart) <= most else np.random.default_rng(n).choice(apart, most, replace=False)
    return front[some], back[some]


def read(table: SlabTable, texels: np.ndarray, front: np.ndarray, back: np.ndarray, layer: int = 0) -> tuple[np.ndarray, ...]:
    """Light (n, 4) of slabs between entries as readers form it from texels and integral, and the back's shares of it."""
    length = table.length * (layer + 1) / table.lengths
    ends = np.linspace(*value_axis(table.function), table.entries)
    rise = integral_to(table.function, ends[back]) - integral_to(table.function, ends[front])
    mean = np.maximum(rise * ((table.entries - 1) / (back - front))[:, None], 0)
    depth = mean[:, 3:] * length
    weight = np.where(depth > 1e-9, -np.expm1(-depth) / np.maximum(depth, 1e-9), 1.0)
    texel = texels[layer, back, front]
    np.testing.assert_allclose(texel[:, 3], mean[:, 3], rtol=1e-6, atol=1e-9 * mean[:, 3].max() + 1e-30)
    source = np.clip(mean[:, :3] + texel[:, :3] * move(depth), 0, mean[:, :3] / weight)
    light = np.concatenate([source * weight * length, -np.expm1(-depth)], axis=1)
    return light, texels[table.lengths + layer, back, front] if table.weighted else np.zeros_like(light)


def assert_right(device: Device, table: SlabTable, most: int = 3000) -> None:
    """Colours, opacities and back's parts are the integrals; of glowing functions as a share of the brightest."""
    texels = texels_of(device, table)
    assert np.isfinite(texels).all()
    front, back = pairs(table.entries, most)
    ends = np.linspace(*value_axis(table.function), table.entries)
    for layer in range(table.lengths):
        length = table.length * (layer + 1) / table.lengths
        light, shares = read(table, texels, front, back, layer)
        exact, moment = slab_light(table.function, ends[front], ends[back], length)
        unit = max(1.0, exact.max())
        np.testing.assert_allclose(light, exact, atol=NEAR * unit)
        if table.weighted:
            assert shares.min() >= 0
            assert shares.max() <= 1
            np.testing.assert_allclose(exact * shares, moment, atol=NEAR * unit)


def kinds() -> dict[str, list[tuple[float, tuple[float, float, float], float]]]:
    """Points of one function of each kind; extinctions up to one. A needle is narrower than an entry."""
    rng = np.random.default_rng(7)
    red, blue, green, white = (1.0, 0.0, 0.0), (0.0, 0.1, 1.0), (0.1, 1.0, 0.1), (1.0, 1.0, 1.0)
    return {
        "smooth": [(0, (0.0, 0.0, 0.0), 0), (3, (1.0, 0.6, 0.4), 0.2), (7, (0.2, 0.9, 0.4), 0.1), (12, white, 1)],
        "needles": [
            (0, red, 0),
            (2.31, red, 0),
            (2.315, blue, 1),
            (2.32, red, 0),
            (7, white, 0),
            (7.01, green, 0.7),
            (12, red, 0),
        ],
        "steps": [(0, red, 0), (3.3, red, 0), (3.3, red, 0.2), (6.1, blue, 0.2), (6.1, white, 1), (10, green, 1)],
        "random": [(float(v), tuple(rng.random(3)), rng.random()) for v in np.sort(rng.random(40)) * 50],
        "thousands": [(float(v), tuple(rng.random(3)), rng.random()) for v in np.sort(rng.random(3000))],
    }


def function(points, depth: float, associated: bool) -> TransferFunction:
    return TransferFunction([(v, rgb, depth * e) for v, rgb, e in points], associated)


@pytest.mark.parametrize("associated", [False, True])
@pytest.mark.parametrize("depth", [1e-6, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e6])
@pytest.mark.parametrize("kind", ["smooth", "needles", "steps", "random"])
def test_entries_are_the_integrals(device, kind, depth, associated):
    assert_right(device, SlabTable(function(kinds()[kind], depth, associated), 1.0, 130, 1, weighted=True))


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("entries", [2, 3, 7, 100, 257])
def test_any_number_of_entries(device, entries, weighted):
    assert_right(device, SlabTable(function(kinds()["steps"], 5.0, False), 0.7, entries, 1, weighted))


@pytest.mark.parametrize(("kind", "depth", "associated"), [("random", 3.0, False), ("even", 3.0, False), ("even", 0.01, True)])
def test_large_tables(device, kind, depth, associated):
    """Dispatched a part at a time. A thousand segments, equal ones too, do not add up what each is rounded by."""
    points = kinds().get(kind, [(0, (1, 1, 1), 1.0), (4, (1, 1, 1), 1.0)])
    assert_right(device, SlabTable(function(points, depth, associated), 1.0, 1030, 1, weighted=True))


@pytest.mark.parametrize("depth", [1.0, 1e6])
def test_thousands_of_control_points(device, depth):
    assert_right(device, SlabTable(function(kinds()["thousands"], depth, False), 1.0, 64, 1, weighted=True), most=40)


def test_core_devices_make_the_same(core_device):
    assert_right(core_device, SlabTable(function(kinds()["steps"], 3.0, True), 1.0, 100, 2, weighted=True))


def test_several_lengths(device):
    """Each layer is the table of its length."""
    table = SlabTable(function(kinds()["smooth"], 20.0, False), 3.0, 50, 3, weighted=True)
    assert_right(device, table)
    texels = texels_of(device, table)
    for layer in range(3):
        alone = texels_of(device, replace(table, length=float(layer + 1), lengths=1))
        np.testing.assert_allclose(texels[[layer, 3 + layer]], alone, rtol=1e-4, atol=1e-5)


numbers = st.floats(0, 1).map(lambda x: round(x, 3))
extinctions = st.sampled_from([0.0, 1e-6, 0.01, 0.3, 3.0, 50.0, 1e6])
colours = st.tuples(numbers, numbers, numbers)
points = st.lists(st.tuples(st.integers(0, 9).map(float), colours, extinctions), min_size=1, max_size=6).map(
    lambda p: sorted(p, key=lambda q: q[0])
)
functions = st.builds(TransferFunction, points, st.booleans())


@settings(max_examples=40)
@given(tf=functions, length=st.sampled_from([0.01, 1.0]))
def test_any_function(device, tf, length):
    """A single point, steps anywhere, several of them at one value."""
    assert_right(device, SlabTable(tf, length, 23, 1, weighted=True))


@given(rgb=colours, extinction=extinctions, length=st.sampled_from([0.1, 2.0]))
def test_homogeneous_functions_are_not_shifted(device, rgb, extinction, length):
    table = SlabTable(TransferFunction([(0, rgb, extinction), (4, rgb, extinction)]), length, 24, 1, weighted=True)
    texels = texels_of(device, table)
    assert np.abs(texels[0, ..., :3] * move(np.array(extinction * length))).max() <= NEAR * extinction
    # [1 - (1 + x) exp(-x)] / [x (1 - exp(-x))] of the light lies towards the back.
    x = max(extinction * length, 1e-6)
    share = 0.5 - x / 12 if x < 1e-3 else (1 - (1 + x) * np.exp(-min(x, 700.0))) / (x * -np.expm1(-x))
    seen = np.append(np.array(rgb) > 0, True) & (extinction > 0)
    np.testing.assert_allclose(texels[1][..., seen], share, atol=1e-4)


@given(tf=functions)
def test_slabs_of_one_value_are_homogeneous(device, tf):
    texels = texels_of(device, SlabTable(tf, 1.0, 17, 1, weighted=True))
    i = np.arange(17)
    x = np.linspace(*value_axis(tf), 17)
    assert not texels[0, i, i, :3].any()
    depth = np.maximum(tf(x)[1], 1e-3)
    share = (1 - (1 + depth) * np.exp(-np.minimum(depth, 700.0))) / (depth * -np.expm1(-depth))
    np.testing.assert_allclose(texels[1, i, i], np.repeat(share[:, None], 4, axis=1), atol=1e-3)


@given(tf=functions)
def test_weighted_tables_hold_the_same_light(device, tf):
    plain, weighted = (texels_of(device, SlabTable(tf, 1.0, 20, 1, w)) for w in (False, True))
    np.testing.assert_allclose(plain[0], weighted[0], rtol=1e-5, atol=1e-4 * max(1.0, np.abs(plain[0]).max()))


@given(tf=functions)
def test_white_light_comes_from_where_highlights_do(device, tf):
    white = TransferFunction([(v, "white", e) for v, _, e in tf.points])
    shares = texels_of(device, SlabTable(white, 1.0, 20, 1, weighted=True))[1]
    np.testing.assert_allclose(shares[..., :3], np.repeat(shares[..., 3:], 3, axis=-1), atol=1e-4)


@given(tf=functions)
def test_a_reversed_function_has_the_table_reversed(device, tf):
    back = TransferFunction([(-v, rgb, e) for v, rgb, e in reversed(tf.points)], tf.associated)
    one, other = (SlabTable(f, 1.0, 20, 1, weighted=True) for f in (tf, back))
    front, behind = pairs(20)
    light, shares = read(one, texels_of(device, one), front, behind)
    turned, turned_shares = read(other, texels_of(device, other), 19 - front, 19 - behind)
    np.testing.assert_allclose(turned, light, atol=NEAR)
    np.testing.assert_allclose(turned * turned_shares, light * shares, atol=NEAR)


def test_symmetric_functions_have_symmetric_tables(device):
    tf = TransferFunction([(0, "red", 0.5), (2, "blue", 3), (4, "red", 0.5)])
    table = SlabTable(tf, 1.0, 21, 1)
    front, back = pairs(21)
    texels = texels_of(device, table)
    np.testing.assert_allclose(read(table, texels, front, back)[0], read(table, texels, 20 - front, 20 - back)[0], atol=NEAR)


def test_limits_are_told(device):
    tf = TransferFunction([(0, "black", 0), (1, "white", 1)])
    with pytest.raises(LimitError, match="too large together: at most 8 fit"):
        make_slab_table(device, SlabTable(tf, 1.0, 4096, 64, weighted=True))
