"""Functions made of the data, on volumes whose boundaries are known."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erf

import airlight as al
from airlight import Volume
from airlight.errors import DataError, ValueRangeError
from airlight.transfer.arches import arches
from airlight.transfer.automatic import boundary_function, boundary_joint_function, peak_at
from airlight.transfer.boundary import boundaries, profile
from airlight.transfer.colour import PALETTE, linear_rgb

MATERIALS = (10.0, 100.0, 220.0)


def step(x: np.ndarray | float, sigma: float) -> np.ndarray:
    """Ideal boundary: from 1 at negative distances to 0."""
    return 0.5 * (1 - erf(np.asarray(x) / (sigma * np.sqrt(2))))


def nested(sigma: float, noise: float = 0.0, n: int = 56, spacing=(1.0, 1.0, 1.0), materials=MATERIALS) -> Volume:
    """One material in the other in the third, as spheres; sigma in voxels along x, the world a tenth of that."""
    size = 0.1 * np.array(spacing)
    x, y, z = (np.arange(round(n / s)) * d - 0.1 * n / 2 for s, d in zip(spacing, size, strict=True))
    r = np.sqrt(x[None, None, :] ** 2 + y[None, :, None] ** 2 + z[:, None, None] ** 2) / 0.1
    v0, v1, v2 = materials
    values = v0 + (v1 - v0) * step(r - 0.42 * n, sigma) + (v2 - v1) * step(r - 0.21 * n, sigma)
    values += noise * np.random.default_rng(1).normal(size=values.shape)
    return Volume(values, spacing=size)


@pytest.mark.parametrize("sigma", [1.0, 1.5, 2.0, 2.5])
@pytest.mark.parametrize("noise", [0.0, 2.0])
@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (0.8, 1.0, 1.25)])
def test_boundaries_lie_in_the_middle_and_are_as_wide_as_they_are(sigma, noise, spacing):
    found = boundaries(nested(sigma, noise, spacing=spacing))
    assert len(found) == 2
    for boundary, low, high in zip(found, MATERIALS, MATERIALS[1:], strict=False):
        assert boundary.value == pytest.approx((low + high) / 2, abs=0.03 * (high - low))
        assert boundary.sigma == pytest.approx(0.1 * sigma, rel=0.15)
        assert boundary.low == pytest.approx(low, abs=0.06 * (high - low))
        assert boundary.high == pytest.approx(high, abs=0.06 * (high - low))
        assert boundary.gradient == pytest.approx((high - low) / (0.1 * sigma * np.sqrt(2 * np.pi)), rel=0.2)


@given(st.floats(1e-3, 1e3), st.floats(-1e3, 1e3), st.floats(1e-2, 1e2))
@settings(max_examples=8)
def test_units_of_values_and_of_lengths_do_not_matter(scale, offset, length):
    plain = nested(1.5, n=32)
    known = boundaries(plain)
    moved = boundaries(Volume(plain.array * scale + offset, spacing=np.array(plain.spacing) * length))
    assert [b.value for b in moved] == pytest.approx([b.value * scale + offset for b in known], abs=1e-3 * scale * 200)
    assert [b.sigma for b in moved] == pytest.approx([b.sigma * length for b in known], rel=1e-2)


def test_whole_numbers_have_the_same_boundaries():
    exact = nested(2.0)
    rounded = boundaries(Volume(np.rint(exact.array).astype(np.uint8), spacing=exact.spacing))
    for a, b in zip(rounded, boundaries(exact), strict=True):
        assert a.value == pytest.approx(b.value, abs=3)
        assert a.sigma == pytest.approx(b.sigma, rel=0.1)


def test_empty_samples_stay_out():
    volume = nested(1.5)
    values = volume.array.copy()
    values[:8] = np.nan
    for a, b in zip(boundaries(Volume(values, spacing=volume.spacing)), boundaries(volume), strict=True):
        assert a.value == pytest.approx(b.value, abs=2)
        assert a.sigma == pytest.approx(b.sigma, rel=0.05)


def test_positions_are_distances_from_the_middle():
    """Along an ideal boundary p(v) is where the step has the value v, in world units."""
    volume = nested(2.0)
    known = profile(volume)
    first = boundaries(known)[0]
    p = known.position(first.sigma)
    for x in (-0.2, -0.1, 0.0, 0.1, 0.2):
        value = 10 + 90 * float(step(-x, 0.2))
        assert float(np.interp(value, known.values, p)) == pytest.approx(x, abs=0.04)


@pytest.mark.parametrize(
    "array",
    [
        np.random.default_rng(1).normal(size=(40, 40, 40)),
        np.random.default_rng(1).integers(0, 256, (40, 40, 40)).astype(np.uint8),
        np.full((5, 5, 5), 3.0),
        np.full((5, 5, 5), np.nan),
        np.mgrid[:24, :24, :24][0].astype(float),
        np.zeros((3, 3, 3), bool),
    ],
    ids=["noise", "bytes", "constant", "empty", "ramp", "bool"],
)
def test_no_boundary_is_found_where_there_is_none(array):
    assert boundaries(Volume(array)) == []
    for make in (boundary_function, boundary_joint_function):
        with pytest.raises(DataError, match="shows no boundary between materials"):
            make(Volume(array))


def crossing(sigma: float, low: float, high: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distances, values and gradients along a ray through an ideal boundary."""
    x = np.linspace(-5 * sigma, 5 * sigma, 4001)
    bell = np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    return x, low + (high - low) * step(-x, sigma), (high - low) * bell


@pytest.mark.parametrize("depth", [0.5, 2.0])
@pytest.mark.parametrize("sigma", [1.5, 2.5])
def test_boundaries_have_the_optical_depth_that_was_asked_for(sigma, depth):
    volume = nested(sigma)
    function, joint = boundary_function(volume, depth=depth), boundary_joint_function(volume, depth=depth)
    assert not function.associated
    for low, high in itertools.pairwise(MATERIALS):
        x, values, gradients = crossing(0.1 * sigma, low, high)
        extinction = function(values)[1]
        assert np.sum(extinction) * (x[1] - x[0]) == pytest.approx(depth, rel=0.15)
        assert abs(float(x[np.argmax(extinction)])) < 0.2 * 0.1 * sigma
        extinction = joint(np.stack([values, gradients], axis=-1))[1]
        assert np.sum(extinction) * (x[1] - x[0]) == pytest.approx(depth, rel=0.2)
        assert extinction[np.abs(x) > 1.5 * 0.1 * sigma].max() == 0
    assert not function(np.array(MATERIALS))[1].any()
    assert not joint([[v, 0.0] for v in MATERIALS])[1].any()


def test_emphasis_moves_the_opacity():
    """An emphasis on the outer side of the boundary shows lower values than one on the inner side."""
    volume = nested(2.0)
    outer = boundary_function(volume, emphasis=((-1.5, 0), (-1, 1), (-0.5, 0)))
    inner = boundary_function(volume, emphasis=((0.5, 1), (1, 1)))
    assert outer(float(10 + 90 * step(1.0 * 0.2, 0.2)))[1] > 0
    assert outer(55.0)[1] == 0
    assert inner(55.0)[1] == 0
    assert inner(float(10 + 90 * step(-0.75 * 0.2, 0.2)))[1] > 0


def test_boundaries_have_different_colours_in_turn():
    volume = nested(2.0)
    function = boundary_function(volume)
    rgb, _ = function([55.0, 160.0])
    assert rgb[0] == pytest.approx(linear_rgb(PALETTE[0]))
    assert rgb[1] == pytest.approx(linear_rgb(PALETTE[1]))
    one = boundary_joint_function(volume, colours=["red"])
    assert {shape.colour for shape in one.shapes} == {linear_rgb("red")}


def three_pairs(sigma: float, noise: float = 0.0) -> Volume:
    """Half of a sphere of the third material lies in the second, half in the first: all three pairs have a boundary."""
    z, y, x = np.mgrid[:48, :48, :64].astype(float)
    r = np.sqrt((x - 31.5) ** 2 + (y - 23.5) ** 2 + (z - 23.5) ** 2)
    around = 10 + 90 * step(x - 31.5, sigma)
    values = around + (220 - around) * step(r - 15, sigma)
    return Volume(values + noise * np.random.default_rng(2).normal(size=r.shape))


@pytest.mark.parametrize("noise", [0.0, 1.5])
def test_boundaries_that_share_values_are_told_apart_by_gradient(noise):
    volume = three_pairs(2.0, noise)
    found = arches(volume, profile(volume))
    for low, high in ((10, 100), (10, 220), (100, 220)):
        gradient = (high - low) / (2 * np.sqrt(2 * np.pi))
        matches = [b for b in found if abs(b.value - (low + high) / 2) < 8 and b.gradient == pytest.approx(gradient, rel=0.15)]
        assert len(matches) == 1
    assert len(found) == 3


# -- a picked point


def test_a_peak_stands_at_the_value_under_the_point():
    matrix = np.array([[0.5, 0.1, 0, 3], [0, 0.4, 0, -2], [0, 0, 2.0, 1], [0, 0, 0, 1]])
    z, y, x = np.mgrid[:6, :7, :8].astype(float)
    volume = Volume(3 * x + 5 * y + 7 * z, world_from_index=matrix)
    p_index = np.array([2.25, 3.5, 4.75])
    function = peak_at(volume, matrix[:3, :3] @ p_index + matrix[:3, 3], width=4.0, colour="red")
    value = float(p_index @ [3, 5, 7])
    assert function.points[1][0] == pytest.approx(value)
    assert function.domain == pytest.approx((value - 2, value + 2))
    assert function.extinctions.tolist()[::2] == [0, 0]
    assert function.points[1][1] == linear_rgb("red")


def test_a_peak_on_a_slope_has_the_optical_depth_that_was_asked_for():
    volume = Volume(np.mgrid[:9, :9, :40][2] * 5.0, spacing=(0.5, 0.5, 0.5))
    function = peak_at(volume, (10, 2, 2), depth=1.5)
    x = np.linspace(0, 19.5, 20001)
    assert np.sum(function(10 * x)[1]) * (x[1] - x[0]) == pytest.approx(1.5, rel=1e-2)


def test_the_width_holds_the_noise_and_the_slope():
    rng = np.random.default_rng(0)
    flat = Volume(50 + 2 * rng.normal(size=(9, 9, 9)))
    low, high = peak_at(flat, (4, 4, 4)).domain
    assert 6 < high - low < 11
    steep = Volume(np.mgrid[:9, :9, :9][2] * 20.0)
    low, high = peak_at(steep, (4, 4, 4)).domain
    assert high - low == pytest.approx(40)


@given(st.tuples(*[st.floats(0, 1)] * 3))
def test_every_point_of_the_domain_can_be_picked(share):
    volume = Volume(np.arange(60, dtype=np.uint8).reshape(3, 4, 5), spacing=(0.3, 1, 2), origin=(5, -6, 7))
    corners = volume.corners_world()
    function = peak_at(volume, corners.min(axis=0) + np.array(share) * np.ptp(corners, axis=0))
    assert 0 <= function.points[1][0] <= 59


def test_a_slice_can_be_picked_from():
    assert peak_at(Volume(np.arange(12.0).reshape(1, 3, 4)), (1, 1, 0.4)).points[1][0] == 5
    assert peak_at(Volume(np.full((1, 1, 1), 3.0)), (0, 0, 0)).points[1][0] == 3


def test_points_outside_or_empty_are_refused():
    values = np.zeros((4, 4, 4))
    values[1, 1, 1] = np.nan
    volume = Volume(values)
    with pytest.raises(DataError, match=r"outside of the volume: it reaches from \[0.0, 0.0, 0.0\] to \[3.0, 3.0, 3.0\]"):
        peak_at(volume, (0, 0, 3.5))
    with pytest.raises(DataError, match="beside an empty sample"):
        peak_at(volume, (0.5, 0.5, 0.5))
    assert peak_at(volume, (2.5, 2.5, 2.5)).points[1][0] == 0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda v: peak_at(v, (1, 1)), "p_world is"),
        (lambda v: peak_at(v, (1, 1, np.nan)), "give three finite numbers"),
        (lambda v: peak_at(v, (1, 1, 1), width=0), "width is 0, must be positive"),
        (lambda v: peak_at(v, (1, 1, 1), depth=-1), "depth is -1, must be at least 0"),
        (lambda v: boundary_function(v, depth=np.inf), "depth is inf"),
        (lambda v: boundary_function(v, emphasis=((0, 1),)), "emphasis is"),
        (lambda v: boundary_function(v, emphasis=((0, 0), (1, 0))), "shares must be at least 0, and some above"),
        (lambda v: boundary_function(v, emphasis=((0, 1), (0, 1))), "positions rising"),
        (lambda v: boundary_joint_function(v, thickness=0), "thickness is 0, must be positive"),
        (lambda v: arches(v, profile(v), sigma=0), "sigma is 0, must be positive"),
        (lambda v: boundaries(v, threshold=-1), "threshold is -1, must be at least 0"),
    ],
)
def test_mistakes_are_named(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make(Volume(np.zeros((4, 4, 4))))


@pytest.mark.data
def test_the_arches_of_the_tooth(data_dir):
    """Values of its materials: pulp 77, dentin 160, enamel 235. By value alone their boundaries are one hump."""
    volume = al.open(data_dir / "tooth.nrrd")
    assert any(b.value == pytest.approx((77 + 235) / 2, abs=15) for b in boundaries(volume))
    shapes = boundary_joint_function(volume).shapes
    middles = [shape.value for shape in shapes]
    for low, high in ((77, 160), (77, 235), (160, 235)):
        assert any(m == pytest.approx((low + high) / 2, abs=15) for m in middles)


@pytest.mark.parametrize("make", [boundary_function, boundary_joint_function])
def test_boundaries_may_have_depths_of_their_own(make):
    """In turn by rising value; the last holds for those that are left. Extinctions are proportional to them."""
    volume = nested(1.5)

    def greatest(depth) -> list[float]:
        function = make(volume, depth=depth)
        if isinstance(function, al.JointFunction):
            return [shape.extinction for shape in function.shapes]
        return [function.extinctions[function.values < 100].max(), function.extinctions[function.values > 100].max()]

    once = greatest(1.0)
    assert greatest((0.2, 3.0)) == pytest.approx([0.2 * once[0], 3 * once[1]])
    assert greatest([0.5]) == pytest.approx([0.5 * e for e in once])
    for wrong in ((), (1, -1), [[1.0]]):
        with pytest.raises(ValueRangeError, match="depth"):
            make(volume, depth=wrong)
