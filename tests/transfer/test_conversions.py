"""Functions of VTK, OSPRay and ANARI draw the same slabs here, and go back as they came."""

from __future__ import annotations

import numpy as np
import pytest
from functions import functions
from hypothesis import given
from hypothesis import strategies as st

from airlight.errors import ValueRangeError
from airlight.transfer import (
    TransferFunction,
    extinction_from_opacity,
    linear_to_srgb,
    opacity_from_extinction,
    srgb_to_linear,
)
from airlight.transfer.opacity import OPAQUE

T = TransferFunction
LENGTHS = (0.01, 0.3, 1.0, 2.5, 40.0)  # in unit distances
shares = st.floats(0, 1).map(lambda x: round(x, 3))


def slab(tf: TransferFunction, values: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Colour and opacity of a slab of one value, by the optical model."""
    rgb, tau = tf(values)
    alpha = -np.expm1(-np.minimum(tau * length, 700))
    return rgb * alpha[:, None], alpha


def accumulated(alpha: np.ndarray, length: float, unit: float) -> np.ndarray:
    """Opacity of a slab in the other worlds."""
    return 1 - (1 - alpha) ** (length / unit)


@st.composite
def tracks(draw: st.DrawFn, width: int) -> np.ndarray:
    """Points (n, 1 + width) at whole values from 0 to 10."""
    places = sorted(draw(st.sets(st.integers(0, 10), min_size=1, max_size=5)))
    return np.array([[v, *(draw(shares) for _ in range(width))] for v in places])


def interpolated(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(values, points[:, 0], column) for column in points[:, 1:].T], axis=1)


# -- opacity


@given(st.floats(0, 1), st.floats(1e-3, 1e3), st.sampled_from(LENGTHS))
def test_opacity_and_extinction(alpha, unit, length):
    tau = extinction_from_opacity(alpha, unit)
    assert opacity_from_extinction(tau, length * unit) == pytest.approx(accumulated(np.float64(alpha), length, 1.0), abs=1e-12)
    assert opacity_from_extinction(tau, unit) == pytest.approx(alpha, abs=1e-12)


def test_opacity_of_one_is_opaque_at_any_length():
    tau = extinction_from_opacity(1.0, 0.5)
    assert tau == OPAQUE / 0.5
    assert np.float32(tau) == tau
    assert opacity_from_extinction(tau, 1e-4) == 1.0


# -- VTK


@given(tracks(1), tracks(3), st.floats(0.1, 10))
def test_vtk_draws_the_same_slabs(opacity, colour, unit):
    tf = T.from_vtk(opacity, colour, unit)
    at = np.linspace(-1, 11, 241)
    alpha, rgb = interpolated(opacity, at)[:, 0], srgb_to_linear(interpolated(colour, at))
    # Next to an opacity of 1 lengths of less than a unit are followed up to an opacity of 1 - 1/4096.
    for length in LENGTHS:
        expected = accumulated(alpha, length * unit, unit)
        _, drawn = slab(tf, at, length * unit)
        followed = (alpha < 0.999) | (alpha == 1) | (length >= 1)
        assert np.abs(drawn - expected)[followed].max(initial=0) < 1.2e-3
    assert np.abs(linear_to_srgb(tf(at)[0]) - linear_to_srgb(rgb)).max() < 1.1e-3


@given(tracks(1), tracks(3), st.floats(0.1, 10))
def test_vtk_points_themselves_are_exact(opacity, colour, unit):
    tf = T.from_vtk(opacity, colour, unit)
    np.testing.assert_allclose(opacity_from_extinction(tf(opacity[:, 0])[1], unit), opacity[:, 1], atol=1e-12)
    np.testing.assert_allclose(linear_to_srgb(tf(colour[:, 0])[0]), colour[:, 1:], atol=1e-9)


@given(functions(), st.floats(0.1, 10))
def test_vtk_and_back(tf, unit):
    opacity, colour = tf.to_vtk(unit)
    for points in (opacity, colour):
        assert (np.diff([p[0] for p in points]) > 0).all()
    back = T.from_vtk(opacity, colour, unit)
    at = np.setdiff1d(np.linspace(-22, 22, 331), tf.values)
    for length in (0.3 * unit, unit, 20 * unit):
        assert np.abs(slab(back, at, length)[1] - slab(tf, at, length)[1]).max() < 2.5e-3
    assert np.abs(linear_to_srgb(back(at)[0]) - linear_to_srgb(tf(at)[0])).max() < 2.5e-3


def test_vtk_linear_colours():
    opacity, colour = [(0, 0.2), (1, 0.2)], [(0, 0, 0, 0), (1, 1, 0.5, 0.2)]
    tf = T.from_vtk(opacity, colour, encoding="linear")
    assert tf.points[1][1] == (1, 0.5, 0.2)
    assert len(tf.points) == 2
    assert tf.to_vtk(encoding="linear")[1] == colour


def test_opaque_surfaces_of_vtk():
    tf = T.from_vtk([(0, 0), (5, 0), (5, 1), (9, 1)], [(0, 1, 1, 1)], 2.0)
    assert tf([4.99, 5])[1].tolist() == [0, OPAQUE / 2]
    assert [p[1] for p in tf.to_vtk(2.0)[0]] == [0, 0, 1, 1]


def test_objects_of_vtk():
    """Midpoints, sharpness, steps, clamping and colour spaces: as VTK itself evaluates them."""
    vtk = pytest.importorskip("vtk")
    opacity = vtk.vtkPiecewiseFunction()
    nodes = [(0, 0.1), (10, 0.9, 0.3, 0.4), (20, 0.2), (30, 0.6, 0.4, 1.0), (40, 0.3, 0.8, 0.0), (50, 0.5)]
    for node in nodes:
        opacity.AddPoint(*node)
    for space in ("RGB", "HSV", "Lab", "Diverging", "Step"):
        colour = vtk.vtkColorTransferFunction()
        getattr(colour, f"SetColorSpaceTo{space}")()
        for point in ((0, 0, 0, 0.2), (20, 0.9, 0.2, 0.1), (50, 1, 1, 0.8)):
            colour.AddRGBPoint(*point)
        tf = T.from_vtk(opacity, colour, 2.0)
        at = np.linspace(-5, 55, 997) + 1e-3
        expected = np.array([opacity.GetValue(x) for x in at])
        assert np.abs(opacity_from_extinction(tf(at)[1], 2.0) - expected).max() < 2.5e-3
        rgb = np.array([colour.GetColor(x) for x in at])
        assert np.abs(linear_to_srgb(tf(at)[0]) - rgb).max() < (0.02 if space in ("HSV", "Diverging") else 4e-3), space
    opacity.ClampingOff()
    assert T.from_vtk(opacity, colour)([-1, 0.5, 49.5, 51])[1].astype(bool).tolist() == [False, True, True, False]
    again, _ = T.from_vtk(opacity, colour).to_vtk()
    filled = vtk.vtkPiecewiseFunction()
    for point in again:
        filled.AddPoint(*point)
    assert filled.GetSize() == len(again)


# -- OSPRay


@given(tracks(3), tracks(1), st.floats(0.1, 50))
def test_ospray_draws_the_same_slabs(color, opacity, scale):
    tf = T.from_ospray(color[:, 1:], opacity[:, 1], (-3, 7), scale)
    at = np.linspace(-4, 8, 193)
    even = [np.column_stack([np.linspace(-3, 7, len(t)) if len(t) > 1 else [-3], t[:, 1:]]) for t in (color, opacity)]
    rgb, own = interpolated(even[0], at), interpolated(even[1], at)[:, 0]
    for length in LENGTHS:
        drawn, alpha = slab(tf, at, length)
        np.testing.assert_allclose(alpha, 1 - np.exp(-own * length * scale), atol=1e-9)
        np.testing.assert_allclose(drawn, rgb * alpha[:, None], atol=1e-9)


def test_ospray_and_back():
    tf = T([(0, "red", 0.0), (4, "gold", 3.0), (10, "white", 1.0)])
    told = tf.to_ospray(entries=11)
    assert told["opacity"].max() == 1
    assert told["densityScale"] == 3
    back = T.from_ospray(told["color"], told["opacity"], told["value"], told["densityScale"])
    at = np.linspace(-1, 11, 97)
    for a, b in zip(back(at), tf(at), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


# -- ANARI


@given(tracks(4) | tracks(3), tracks(1), st.floats(0.1, 10))
def test_anari_draws_the_same_slabs(color, opacity, unit):
    tf = T.from_anari(color[:, 1:], opacity[:, 1], (-3, 7), unit)
    at = np.linspace(-4, 8, 193)
    even = [np.column_stack([np.linspace(-3, 7, len(t)) if len(t) > 1 else [-3], t[:, 1:]]) for t in (color, opacity)]
    rgba, own = interpolated(even[0], at), interpolated(even[1], at)[:, 0]
    alpha = own * (rgba[:, 3] if rgba.shape[1] == 4 else 1.0)
    for length in LENGTHS:
        drawn, total = slab(tf, at, length * unit)
        followed = (alpha < 0.999) | (alpha == 1) | (length >= 1)
        assert np.abs(total - accumulated(alpha, length, 1.0))[followed].max(initial=0) < 1.5e-3
        np.testing.assert_allclose(drawn, rgba[:, :3] * total[:, None], atol=1e-9)


def test_anari_and_back():
    tf = T([(0, "red", 0.0), (4, "gold", 3.0), (10, "white", 1.0)])
    told = tf.to_anari(unit_distance=0.5, entries=101)
    back = T.from_anari(told["color"], told["opacity"], told["valueRange"], told["unitDistance"])
    at = np.linspace(-1, 11, 97)
    for length in LENGTHS:
        assert np.abs(slab(back, at, length)[1] - slab(tf, at, length)[1]).max() < 2e-3
    np.testing.assert_allclose(back(at)[0], tf(at)[0], atol=1e-9)


def test_anari_defaults():
    tf = T.from_anari((1, 0.5, 0.2, 0.75))
    assert tf([0.3])[0].tolist() == [[1, 0.5, 0.2]]
    assert opacity_from_extinction(tf([0.3])[1]) == pytest.approx(0.75)


# -- tables


def test_nearest_tables_are_exact_steps():
    rng = np.random.default_rng(3)
    table = rng.random((8, 4))
    table[2, 3], table[5, 3] = 0, 1
    tf = T.from_table(table, (0, 16), unit_distance=2.0)
    at = np.array([-5, *np.arange(0, 16, 0.25), 99])
    entry = np.clip(at // 2, 0, 7).astype(int)
    for length in LENGTHS:
        drawn, alpha = slab(tf, at, length * 2.0)
        np.testing.assert_allclose(alpha, accumulated(table[entry, 3], length, 1.0), atol=1e-12)
        np.testing.assert_allclose(drawn, table[entry, :3] * alpha[:, None], atol=1e-12)
    srgb = T.from_table(table, (0, 16), encoding="srgb")
    np.testing.assert_allclose(linear_to_srgb(srgb(at)[0]), table[entry, :3], atol=1e-7)


# -- errors

GLOW = T([(0, "red", 0)], associated=True)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: T.from_vtk([(0, 0), (1, 1.5)], [(0, 1, 1, 1)]), r"vtk.opacity\[1\] is \[1.5\]: give numbers in \[0, 1\]"),
        (lambda: T.from_vtk([(0, np.nan)], [(0, 1, 1, 1)]), r"vtk.opacity\[0\] is \[nan\]"),
        (lambda: T.from_vtk([(1, 0), (0, 1)], [(0, 1, 1, 1)]), "vtk.opacity has values that are not finite or out of order"),
        (lambda: T.from_vtk([(0, 0, 0.5, 0)], [(0, 1, 1, 1)]), r"vtk.opacity has shape \(1, 4\): give 2 numbers a point"),
        (lambda: T.from_vtk([(0, 0)], [(0, 255, 0, 0)]), r"vtk.colour\[0\] is \[255.0"),
        (lambda: T.from_vtk([(0, 0)], [(0, 1, 1, 1)], 0), "vtk.unit_distance is 0, must be finite and above 0"),
        (lambda: T.from_vtk([(0, 0)], [(0, 1, 1, 1)], encoding="lab"), "encoding is 'lab', must be srgb or linear"),
        (lambda: GLOW.to_vtk(), "transfer is associated, and VTK knows no glow without extinction"),
        (lambda: T([(0, (2, 0, 0), 1)]).to_vtk(), "has colours brighter than 1"),
        (lambda: T.from_ospray([[0, 0]], [1], (0, 1)), r"ospray.color has shape \(1, 2\), must be \(n, 3\)"),
        (lambda: T.from_ospray([[0, 0, 0]], [1], (1, 0)), "ospray.value runs from 1 to 0"),
        (lambda: GLOW.to_ospray(), "OSPRay knows no glow"),
        (lambda: T([(0, "red", 1)]).to_ospray(), "has the one value 0, and OSPRay needs a range"),
        (lambda: T.ramp(0, 1).to_anari(entries=1), "entries is 1, must be a whole number of at least 2"),
        (lambda: T.from_anari([[1, 1, 1]], -1), r"anari.opacity\[0\] is \[-1.0\]"),
        (lambda: T.from_anari([[1, 1, 1]], 1, unit_distance=-1), "anari.unitDistance is -1"),
        (lambda: T.from_table([[1, 1, 1]], (0, 1)), r"table has shape \(1, 3\), must be \(n, 4\)"),
        (lambda: T.from_table([[1, 1, 1, 2]], (0, 1)), r"table\[0\] is"),
        (lambda: extinction_from_opacity([0.5, 1.1]), "opacity runs from 0.5 to 1.1"),
        (lambda: opacity_from_extinction(1, -1), "length is -1"),
    ],
)
def test_mistakes_are_told(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make()
