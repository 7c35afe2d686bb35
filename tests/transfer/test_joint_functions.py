"""Functions of two and three variables: shapes, sums, tables, emptiness, plain data, and errors that name the shape."""

from __future__ import annotations

import dataclasses
import itertools
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import airlight as al
from airlight.errors import FileError, ValueRangeError
from airlight.scene_file import load_transfer
from airlight.transfer import linear_rgb
from airlight.transfer.joint import JointFunction
from airlight.transfer.joint_axes import Axis, Ramp
from airlight.transfer.joint_shapes import SHAPES, Box, Ellipse, Polygon, Triangle

AXES = (Axis("value", 0.0, 100.0), Axis("gradient", 0.0, 20.0), Axis("second", -8.0, 8.0))
RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def within(axis: Axis, low: float = 0.0, high: float = 1.0):
    return st.floats(low, high).map(lambda share: axis.low + share * axis.span)


def pairs(axis: Axis):
    """Intervals of an axis that are not too narrow."""
    return st.tuples(within(axis, 0, 0.45), within(axis, 0.5, 1))


colours = st.tuples(*[st.floats(0, 1)] * 3)
media = st.fixed_dictionaries(
    {"colour": colours, "extinction": st.one_of(st.just(0.0), st.floats(1e-3, 10))},
    optional={"ramp": st.builds(lambda a, b: Ramp(0, ((20.0, a), (60.0, b))), colours, colours)},
)


def shapes(k: int):
    """Shapes of k variables within the axes."""
    third = pairs(AXES[2]) if k == 3 else st.none()
    edge = st.one_of(st.just(0.0), st.floats(0.01, 1))
    corners = st.tuples(*[pairs(axis) for axis in AXES[:k]]).map(lambda p: tuple(zip(*p, strict=True)))
    middle = st.tuples(*[within(axis, 0.4, 0.6) for axis in AXES[:k]])
    radii = st.tuples(*[st.floats(0.05, 0.25).map(lambda r, axis=axis: r * axis.span) for axis in AXES[:k]])
    vertices = st.lists(st.tuples(within(AXES[0]), within(AXES[1])), min_size=3, max_size=6).filter(
        lambda v: np.ptp(np.array(v), axis=0).min() > 0.5
    )
    return st.one_of(
        st.builds(lambda c, e, m: Box(*c, e, **m), corners, edge, media),
        st.builds(
            lambda v, w, g, e, t, m: Triangle(v, w, g[1], g[0], edge=e, third=t, **m),
            within(AXES[0], 0.4, 0.6),
            st.floats(1, 40),
            pairs(AXES[1]),
            edge,
            third,
            media,
        ),
        st.builds(lambda c, r, a, m: Ellipse(c, r, a, **m), middle, radii, st.floats(-3, 3), media),
        st.builds(lambda v, e, t, m: Polygon(tuple(v), e, t, **m), vertices, edge, third, media),
    )


def functions(k: int):
    return st.builds(JointFunction, st.just(AXES[:k]), st.lists(shapes(k), max_size=4), st.booleans())


both = st.integers(2, 3).flatmap(functions)


def places(function: JointFunction, count: int = 200, beyond: float = 0.3) -> np.ndarray:
    rng = np.random.default_rng(7)
    low, high = (np.array([getattr(a, end) for a in function.axes]) for end in ("low", "high"))
    return low + (high - low) * rng.uniform(-beyond, 1 + beyond, (count, len(function.axes)))


# -- laws of all functions


@given(both)
def test_round_trips_as_plain_data_and_as_code(function):
    again = JointFunction.from_dict(function.to_dict())
    assert again == function
    assert hash(again) == hash(function)
    assert eval(function.as_code(), {"al": al}) == function


@given(both)
@settings(max_examples=25)
def test_round_trips_through_files(function):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "function.toml"
        function.save(path)
        assert JointFunction.load(path) == function
        assert load_transfer(path) == function
        assert [file.name for file in Path(folder).iterdir()] == ["function.toml"]


def test_channels_of_any_name_round_trip(tmp_path):
    function = JointFunction([Axis('\U0001f52c \x7f\n"', 0, 1), AXES[1]])
    function.save(tmp_path / "tf.toml")
    assert JointFunction.load(tmp_path / "tf.toml") == function


def test_files_that_are_wrong_name_the_place(tmp_path):
    path = tmp_path / "function.toml"
    JointFunction(AXES[:2], [Box((0, 0), (9, 9)), Box((0, 0), (8, 8))]).save(path)
    path.write_text(path.read_text().replace("high = [8.0, 8.0]", "high = [8.0, 88.0]"))
    with pytest.raises(ValueRangeError, match=r"function.toml:11: transfer.shapes\[1\] \(box\) reaches from 0 to 88"):
        JointFunction.load(path)
    axes = "axes = [\n  { variable = 'value', low = 0, high = 1 },\n  { variable = 'gradient', low = 0, high = 0 },\n]\n"
    path.write_text(axes)
    with pytest.raises(ValueRangeError, match=r"function.toml:3: transfer.axes\[1\] axis 'gradient' reaches from 0 to 0"):
        load_transfer(path)
    path.write_text(axes.replace("high = 0", "high = 1") + "[[shapes]]\nkind = 'box'\nlow = [0, 0]\nhigh = [1, 'a']\n")
    for load in (load_transfer, JointFunction.load):
        with pytest.raises(
            ValueRangeError, match=r"function.toml:8: transfer.shapes\[0\] box.high\[1\] is 'a', must be a finite"
        ):
            load(path)
    path.write_text("axes = [[]")
    with pytest.raises(FileError, match="is no sound TOML"):
        JointFunction.load(path)
    with pytest.raises(FileError, match="cannot be written"):
        JointFunction(AXES[:2]).save(tmp_path / "absent" / "function.toml")
    names = Axis('a "b" \\ c', 0, 1), Axis(3, 0, 1)
    JointFunction(names).save(path)
    assert JointFunction.load(path).axes == names


@given(both)
def test_media_add(function):
    """Sources and extinctions of a function are the sums of those of its shapes alone."""
    at = places(function)
    alone = [JointFunction(function.axes, [shape], function.associated) for shape in function.shapes]
    assert function.source(at) == pytest.approx(sum((f.source(at) for f in alone), np.zeros((len(at), 3))), abs=1e-12)
    assert function(at)[1] == pytest.approx(sum((f(at)[1] for f in alone), np.zeros(len(at))), abs=1e-12)


@given(both)
def test_colour_times_extinction_is_the_source(function):
    at = places(function)
    rgb, extinction = function(at)
    source = rgb if function.associated else rgb * extinction[:, None]
    assert source == pytest.approx(function.source(at), abs=1e-12)


@given(both, st.floats(0, 5))
def test_density_scales_sources_and_extinctions(function, density):
    at = places(function)
    scaled = function.scaled(density)
    assert scaled.source(at) == pytest.approx(density * function.source(at), rel=1e-9, abs=1e-12)
    assert scaled(at)[1] == pytest.approx(density * function(at)[1], rel=1e-9, abs=1e-12)


@given(both)
def test_nothing_outside_of_bounds_and_weights_are_shares(function):
    at = places(function, beyond=0)
    spans = np.array([axis.span for axis in function.axes])
    for shape in function.shapes:
        weight = shape.weight(at, spans)
        assert weight.min() >= 0
        assert weight.max() <= 1
        low, high = shape.bounds(spans).T
        outside = ((at < low - 1e-9 * spans) | (at > high + 1e-9 * spans)).any(axis=1)
        assert not weight[outside].any()


@given(both)
def test_empty_values_are_empty_and_nothing_is_forgotten(function):
    at = places(function, 400)
    stretches = function.empty_values
    assert stretches[0][0] == -np.inf
    assert stretches[-1][1] == np.inf
    assert all(a[0] <= a[1] < b[0] <= b[1] for a, b in itertools.pairwise(stretches))
    empty = np.logical_or.reduce([(at[:, 0] >= low) & (at[:, 0] <= high) for low, high in stretches])
    assert not function(at)[1][empty].any()
    assert not function.source(at)[empty].any()
    seen = [s for s in function.shapes if s.extinction > 0 or (function.associated and not s.is_black)]
    assert (len(stretches) == 1) == (not seen)


@given(both)
@settings(max_examples=25)
def test_tables_hold_the_function_at_their_entries(function):
    n, k = 9, len(function.axes)
    table = function.table(n)
    assert table.dtype == np.float32
    assert table.shape == ((1, n, n, 4) if k == 2 else (n, n, n, 4))
    lines = [np.linspace(axis.low, axis.high, n) for axis in function.axes]
    rng = np.random.default_rng(1)
    for _ in range(20):
        index = rng.integers(0, n, k)
        at = np.array([line[i] for line, i in zip(lines, index, strict=True)])
        texel = table[tuple(index[::-1])] if k == 3 else table[0, index[1], index[0]]
        assert texel[:3] == pytest.approx(function.source(at), rel=1e-6)
        assert texel[3] == pytest.approx(float(function(at)[1]), rel=1e-6)


@given(both)
def test_nan_and_infinity_are_empty(function):
    k = len(function.axes)
    at = np.full((3, k), 50.0)
    at[0, 0], at[1, 1], at[2, 0] = np.nan, np.inf, -np.inf
    assert not function(at)[1].any()
    assert np.isfinite(function.source(at)).all()


# -- the shapes


@given(pairs(AXES[0]), pairs(AXES[1]), st.floats(0.01, 1))
def test_a_rectangular_polygon_is_a_box(x, y, edge):
    box = JointFunction(AXES[:2], [Box((x[0], y[0]), (x[1], y[1]), edge)])
    polygon = JointFunction(AXES[:2], [Polygon(((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])), edge)])
    at = places(box)
    assert polygon(at)[1] == pytest.approx(box(at)[1], abs=1e-9)


def test_a_box_has_its_sides_and_rises_from_them():
    hard = JointFunction(AXES[:2], [Box((20, 5), (40, 15), extinction=3)])
    assert hard([[20, 5], [40, 15], [30, 10], [19.99, 10], [30, 15.01]])[1].tolist() == [3, 3, 3, 0, 0]
    soft = JointFunction(AXES[:2], [Box((20, 5), (40, 15), edge=0.5, extinction=2)])
    assert soft([[20, 10], [22.5, 10], [25, 10], [30, 10], [30, 6.25]])[1].tolist() == pytest.approx([0, 1, 2, 2, 1])


def test_a_triangle_is_a_surface_of_constant_thickness():
    """Levoy: with the gradient g the half width is r g, and at the middle of the side the weight is one half."""
    r = 2.0
    shape = Triangle(50, r * 10, 10, 1)
    f = JointFunction(AXES[:2], [shape])
    for g in (1.0, 2.0, 5.0, 10.0):
        assert f([[50, g], [50 + r * g / 2, g], [50 - r * g, g]])[1].tolist() == pytest.approx([1, 0.5, 0])
    assert f([[50, 0.99], [50, 10.01], [50, 0]])[1].tolist() == [0, 0, 0]
    assert JointFunction(AXES[:2], [Triangle(50, 20, 10)])([[50, 0], [50, 1e-3]])[1].tolist() == [0, 1]
    assert JointFunction(AXES[:2], [Triangle(50, 20, 10, edge=0)])([50 + 9.99, 5])[1] == 1


def test_an_ellipse_is_a_gaussian_of_three_deviations():
    f = JointFunction(AXES[:2], [Ellipse((50, 10), (30, 6))])
    assert f([[50, 10], [80, 10], [50, 16], [50, 4]])[1].tolist() == pytest.approx([1, 0, 0, 0], abs=1e-12)
    assert float(f([60, 10])[1]) == pytest.approx((np.exp(-0.5) - np.exp(-4.5)) / (1 - np.exp(-4.5)))


def test_a_turned_ellipse_is_turned_as_seen_on_a_square():
    """By a quarter turn the radii change places, as shares of the axes."""
    turned = JointFunction(AXES[:2], [Ellipse((50, 10), (40, 2), np.pi / 2)])
    other = JointFunction(AXES[:2], [Ellipse((50, 10), (10, 8))])
    at = places(turned)
    assert turned(at)[1] == pytest.approx(other(at)[1], abs=1e-9)
    diagonal = JointFunction(AXES[:2], [Ellipse((50, 10), (40, 1), np.pi / 4)])
    assert diagonal([60, 12])[1] > 0.3
    assert diagonal([60, 8])[1] == 0


def test_a_polygon_that_crosses_itself_is_what_is_enclosed_an_odd_number_of_times():
    star = [(50 + 40 * np.sin(a), 10 + 8 * np.cos(a)) for a in 4 * np.pi / 5 * np.arange(5)]
    f = JointFunction(AXES[:2], [Polygon(tuple(star))])
    assert f([[50, 10], [50, 16]])[1].tolist() == [0, 1]


def test_shapes_of_the_plane_reach_over_an_interval_of_the_third_variable():
    f = JointFunction(AXES, [Triangle(50, 20, 10, third=(-1, 2)), Polygon(((0, 12), (100, 12), (50, 20)))])
    assert f([[50, 5, -1], [50, 5, 2], [50, 5, 2.01], [50, 13, -8], [50, 13, 8]])[1].tolist() == [1, 1, 0, 1, 1]


def test_a_ramp_colours_along_an_axis():
    ramp = Ramp(1, ((5, "black"), (15, "white")))
    rgb, _ = JointFunction(AXES[:2], [Box((0, 0), (100, 20), ramp=ramp)])([[50, 2], [50, 10], [50, 19]])
    assert rgb.tolist() == [[0, 0, 0], [0.5, 0.5, 0.5], [1, 1, 1]]


def test_overlapping_colours_are_weighted_by_extinction():
    f = JointFunction(AXES[:2], [Box((0, 0), (60, 20), colour=RED, extinction=3), Box((40, 0), (99, 20), colour=GREEN)])
    rgb, extinction = f([50, 10])
    assert rgb.tolist() == [0.75, 0.25, 0]
    assert float(extinction) == 4


def test_associated_colours_glow_where_extinction_is_zero():
    f = JointFunction(AXES[:2], [Box((10, 0), (20, 20), colour=RED, extinction=0)], associated=True)
    assert f([15, 1])[0].tolist() == [1, 0, 0]
    assert len(f.empty_values) == 2
    assert len(dataclasses.replace(f, associated=False).empty_values) == 1


def test_words_are_srgb_and_stored_linear():
    assert Box((0, 0), (1, 1), colour="#808080").colour == linear_rgb("#808080")
    assert Box((0, 0), (1, 1), colour="#808080") == Box((0, 0), (1, 1), colour=linear_rgb("#808080"))


def test_interpolated_texels_keep_the_colour():
    """Halfway out of a shape the colour is that of the shape, not darkened by what is beside it."""
    table = JointFunction(AXES[:2], [Box((20, 0), (60, 20), colour=RED, extinction=2)]).table(11)[0, 5]
    mixed = (table[6] + table[7]) / 2
    assert mixed.tolist() == [1, 0, 0, 1]


def test_a_widened_function_is_empty_on_less_but_not_beyond_its_axes():
    f = JointFunction(AXES[:2], [Box((0, 0), (40, 20)), Box((60, 0), (70, 20))])
    (_, first), (second, third), (fourth, _) = f.empty_values_widened(5)
    assert first == pytest.approx(0)
    assert (second, third, fourth) == pytest.approx((45, 55, 75))
    assert f.empty_values[1] == pytest.approx((40, 60))


# -- mistakes


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Axis("value", 1, 1), r"axis 'value' reaches from 1 to 1"),
        (lambda: Axis("value", 0, np.nan), r"axis 'value' is nan, must be a finite number"),
        (lambda: Axis(-1, 0, 1), r"axis.variable is -1"),
        (lambda: Axis(True, 0, 1), r"axis.variable is True"),
        (lambda: JointFunction(AXES[:1]), r"transfer.axes are of \['value'\]: give two or three different"),
        (lambda: JointFunction([AXES[0], AXES[0]]), "give two or three different variables"),
        (lambda: JointFunction([(0, 1), (0, 1)]), r"transfer.axes\[0\] is \(0, 1\): pass an Axis"),
        (lambda: JointFunction(AXES[:2], ["box"]), r"transfer.shapes\[0\] is a str"),
        (
            lambda: JointFunction(AXES[:2], [Box((0, 0), (9, 9)), Box((0, 0), (200, 9))]),
            r"shapes\[1\] \(box\) reaches from 0 to 200 along 'value': shape outside the histogram: must lie in \[0, 100\]",
        ),
        (lambda: JointFunction(AXES[:2], [Ellipse((50, 10), (20, 11))]), r"\(ellipse\) reaches from -1 to 21 along 'gradient'"),
        (lambda: JointFunction(AXES, [Box((0, 0), (9, 9))]), r"shapes\[0\] \(box\) is for 2 variables, the function has 3"),
        (lambda: JointFunction(AXES[:2], [Triangle(50, 20, 10, third=(0, 1))]), r"is for 3 variables, the function has 2"),
        (
            lambda: JointFunction(AXES[:2], [Box((0, 0), (9, 9), ramp=Ramp(2, ((0, RED), (1, RED))))]),
            r"shapes\[0\] \(box\).ramp.axis is 2, must be less than 2",
        ),
        (lambda: Box((0, 0), (0, 1)), r"box.high is \(0.0, 1.0\), must be above low"),
        (lambda: Box((0, 0), (1, 1, 1)), r"box.high is \(1, 1, 1\): give 2 numbers"),
        (lambda: Box((0, "a"), (1, 1)), r"box.low\[1\] is 'a', must be a finite number"),
        (lambda: Box((0, 0), (1, 1), 2), r"box.edge is 2, must lie in \[0, 1\]"),
        (lambda: Box((0, 0), (1, 1), extinction=-1), r"box.extinction is -1, must be at least 0"),
        (lambda: Box((0, 0), (1, 1), colour="blak"), r"box.colour is 'blak'"),
        (lambda: Box((0, 0), (1, 1), ramp="red"), r"box.ramp is 'red': pass a Ramp"),
        (lambda: Triangle(0, 0, 1), r"triangle.half_width is 0, must be positive"),
        (lambda: Triangle(0, 1, 1, 2), r"triangle.low is 2, must lie from the tip 0 to below the top 1"),
        (lambda: Triangle(0, 1, -1), r"triangle.top is -1, must be above the tip 0"),
        (lambda: Triangle(0, 1, 1, third=(1, 0)), r"triangle.third is \(1, 0\), must rise"),
        (lambda: Ellipse((0, 0), (1, 0)), r"ellipse.radii are \(1.0, 0.0\), must be positive"),
        (lambda: Polygon(((0, 0), (1, 1))), "give three or more"),
        (lambda: Polygon(((0, 0), (1, 0), (2, 0))), "not on one line along an axis"),
        (lambda: Ramp(3, ((0, RED), (1, RED))), "ramp.axis is 3, must be 0, 1 or 2"),
        (lambda: Ramp(0, ((0, RED), (0, RED))), r"ramp.points have coordinates \[0.0, 0.0\]: give two or more, rising"),
        (lambda: JointFunction(AXES[:2], Box((0, 0), (1, 1))), "transfer.shapes is Box.*, must be a list"),
        (lambda: JointFunction(AXES[:2]).table(64.5), "entries is 64.5"),
        (lambda: JointFunction(AXES[:2]).scaled("2"), "density is '2', must be a finite number"),
        (lambda: Ramp(0, 3), "ramp.points is 3, must be a list"),
        (lambda: Ramp(0, (1, 2)), r"ramp.points\[0\] is 1: give \(coordinate, colour\)"),
        (lambda: JointFunction(AXES[:2]).table(1), r"entries is 1, must lie in \[2, 2048\] for 2 variables"),
        (lambda: JointFunction(AXES[:2]).scaled(-1), "density is -1, must be at least 0"),
        (lambda: JointFunction(AXES[:2])([1.0, 2, 3]), r"coordinates have shape \(3,\), must end in 2"),
    ],
)
def test_mistakes_name_the_shape_and_the_entry(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": []}, r"transfer has unknown entries \['points'\]"),
        ({"shapes": [{"kind": "circle"}]}, r"transfer.shapes\[0\] kind is 'circle', must be one of box, triangle"),
        ({"shapes": [{"kind": ["box"]}]}, r"transfer.shapes\[0\] kind is \['box'\]"),
        ({"shapes": [{"kind": "box", "low": [0, 0]}]}, r"transfer.shapes\[0\] box lacks high"),
        ({"shapes": [{"kind": "box", "low": [0, 0], "high": [1, 1], "x": 1}]}, r"shapes\[0\] box has unknown entries \['x'\]"),
        ({"shapes": ["box"]}, r"transfer.shapes\[0\] is 'box', must be a table"),
        ({"axes": 5}, "transfer.axes is 5, must be a list"),
        ({"shapes": 5}, "transfer.shapes is 5, must be a list"),
        ({"shapes": [{"kind": "polygon", "vertices": 5}]}, "polygon.vertices is 5, must be a list"),
        ({"associated": "false"}, "transfer.associated is 'false', must be true or false"),
        ({"axes": [{"variable": "value"}]}, r"transfer.axes\[0\] axis has entries \['variable'\]"),
        ({"shapes": [{"kind": "box", "low": [0, 0], "high": [1, 1], "ramp": {}}]}, r"box.ramp has entries \[\]"),
    ],
)
def test_plain_data_that_is_not_legal_is_named(change, message):
    with pytest.raises(ValueRangeError, match=message):
        JointFunction.from_dict(JointFunction(AXES[:2]).to_dict() | change)


def test_every_shape_is_in_the_laws():
    assert set(SHAPES) == {"box", "triangle", "ellipse", "polygon"}
