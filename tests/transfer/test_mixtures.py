"""Mixtures of channels: values, plain data, lines for normals, and the bound of their slabs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from functions import functions
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import airlight as al
from airlight.scene_file import load_transfer
from airlight.stages.transfer_channels import end_error, evenness_error
from airlight.transfer.cells import end_media, function_texels, stacked_texels
from airlight.transfer.channels import slope_of

RED = al.TransferFunction([(10, "red", 0.0), (20, "red", 2.0)])
BLUE = al.TransferFunction([(0, "blue", 1.0), (5, "blue", 0.0)])


def volume(count: int = 6) -> al.Volume:
    return al.Volume(np.zeros((count, 2, 2, 2)), channel_names=[f"c{n}" for n in range(count)])


def test_channels_keep_hidden_ones_and_know_their_places():
    mixture = al.Channels([al.Channel("c5", RED), al.Channel(0, BLUE, visible=False), al.Channel("c2", RED, density=3)])
    assert mixture.channels(volume()) == (0, 2, 5)
    assert mixture.places(volume()) == (2, 1)
    assert mixture.functions == (RED, RED.scaled(3))
    assert al.Layer(volume(), mixture).channels == (0, 2, 5)
    alone = al.Channels([al.Channel("c5", RED, visible=False), al.Channel(2, BLUE)])
    assert al.Layer(volume(), alone, density=2).function == BLUE.scaled(2)
    assert al.Layer(volume(), alone).channels == (2,)


def test_where_all_are_hidden_nothing_is_drawn():
    hidden = al.Channels([al.Channel(0, RED, visible=False), al.Channel(1, BLUE, visible=False)])
    (function,) = hidden.functions
    assert not function.extinctions.any()


def test_plain_data_make_the_same_mixture():
    mixture = al.Channels([al.Channel("c5", RED), al.Channel(0, BLUE, visible=False, density=0.25)])
    assert al.Channels.from_dict(mixture.to_dict()) == mixture
    assert mixture.scaled(2) == al.Channels([al.Channel("c5", RED, density=2), al.Channel(0, BLUE, visible=False, density=0.5)])


NAMES = st.text(st.characters(exclude_categories=["Cs"]))
PARTS = st.builds(al.Channel, NAMES | st.integers(0, 99), functions(), st.booleans(), st.floats(0, 1e9))


@given(st.lists(PARTS, min_size=1, max_size=4, unique_by=lambda part: part.channel))
def test_files_and_text_make_the_same_mixture(tmp_path_factory, parts):
    mixture, path = al.Channels(parts), tmp_path_factory.getbasetemp() / "mixture.toml"
    assert eval(mixture.as_code(), {"al": al}) == mixture
    mixture.save(path)
    assert al.Channels.load(path) == mixture
    assert load_transfer(path) == mixture


def test_files_that_are_wrong_name_the_place(tmp_path):
    path = tmp_path / "mixture.toml"
    al.Channels({"DAPI": RED, "GFP": BLUE}).save(path)
    path.write_text(path.read_text().replace('"GFP"', '"DAPI"'))
    with pytest.raises(al.ValueRangeError, match=r"mixture.toml: transfer.channels name 'DAPI' twice"):
        al.Channels.load(path)
    path.write_text(path.read_text().replace('channel = "DAPI"', "channel = -0.5"))
    with pytest.raises(al.ValueRangeError, match=r"mixture.toml:3: transfer.channels\[0\]: channel is -0.5"):
        al.Channels.load(path)


GLOW = al.TransferFunction([(0, "red", 0.0)], associated=True)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: al.Channels([]), "are 0, must be 1 to 16"),
        (lambda: al.Channels(dict.fromkeys(range(17), RED)), "are 17, must be 1 to 16"),
        (lambda: al.Channels([al.Channel(0, RED), al.Channel(0, BLUE)]), "0 twice"),
        (lambda: al.Channels({0: RED, 1: GLOW}), "mix associated and other"),
        (lambda: al.Channels([RED]), "give Channel"),
        (lambda: al.Channel(True, RED), "must be a number or a name"),
        (lambda: al.Channel(0, al.TransferFunction(RED.points, surfaces=[al.Surface(15)])), "has surfaces of equal value"),
        (lambda: al.Channel(0, "red"), "give it a TransferFunction"),
        (lambda: al.Channel(0, RED, density=-1), "density is -1, must be at least 0"),
        (lambda: al.Channel(0, RED, density="1"), "density is '1', must be a finite"),
        (lambda: al.Channel(0, RED, visible=1), "visible is 1, must be true or false"),
        (lambda: al.Channels.from_dict({"channels": {"channel": 0}}), "list of tables"),
        (lambda: al.Channels.from_dict({"channels": [{"channel": 0, "transfer": 3}]}), r"channels\[0\].transfer is 3"),
        (lambda: al.Channels.from_dict({"channels": [{"channel": 0}]}), r"channels\[0\] has the entries \['channel'\]"),
        (lambda: al.Channels(None), "transfer.channels is None, must be a list"),
        (lambda: al.Channels.from_dict({"channels": [], "points": []}), r"unknown entries \['points'\]: use channels"),
        (lambda: al.automatic_channels(volume(20)), "are 20; a mixture holds at most 16"),
    ],
)
def test_errors(make, message):
    with pytest.raises(al.ValueRangeError, match=message):
        make()


# -- lines for normals


def test_lines_follow_the_extinction():
    rising, falling = slope_of(RED), slope_of(BLUE)
    assert (rising.weight, rising.low, rising.nothing) == (0.2, 10.0, 10.0)
    assert (falling.weight, falling.high, falling.nothing) == (-0.2, 5.0, 5.0)
    band = slope_of(al.TransferFunction([(0, "red", 0), (3, "red", 0), (4, "red", 2), (9, "red", 0)]))
    assert (band.weight, band.low) == (2.0, 3.0)
    step = slope_of(al.TransferFunction([(3, "red", 0), (3, "red", 2), (5, "red", 2)]))
    assert (step.weight, step.low) == (1.0, 3.0)
    assert slope_of(RED.scaled(0)).weight == 0
    assert slope_of(al.TransferFunction([(0, "red", 1), (4, "red", 2)])).weight == 0.5


@given(function=functions())
def test_lines_of_any_function_are_finite(function):
    line = slope_of(function)
    assert math.isfinite(line.weight)
    assert line.low <= line.high
    assert (line.weight != 0) == bool(function.extinctions.max() > 0)


# -- tables


@given(found=st.lists(functions(), min_size=1, max_size=4))
def test_stacked_texels_hold_each_function(found):
    texels = stacked_texels(tuple(found))
    for layer, function in zip(texels, found, strict=True):
        binned = [function_texels(function, binned)[0] for binned in (False, True)]
        assert any(np.array_equal(layer[: len(rows)], rows) for rows in binned)
        assert np.array_equal(layer[-1, :2], end_media(function).astype(np.float32))


# -- the bound


@settings(max_examples=60)
@given(found=st.lists(functions(), min_size=2, max_size=4), data=st.data(), length=st.floats(0.1, 8))
def test_no_slab_errs_more_than_the_bound(found, data, length):
    """Slabs between any values, cut into 256 pieces, against the even spread of exact means."""
    mixture = al.Channels(dict(enumerate(found)))
    assume(any(f.extinctions.max() > 0 for f in found))
    ends = data.draw(st.lists(st.tuples(st.floats(-25, 25), st.floats(-25, 25)), min_size=len(found), max_size=len(found)))
    at = (np.arange(256) + 0.5) / 256
    source, extinction = np.zeros((256, 3)), np.zeros(256)
    for function, (a, b) in zip(found, ends, strict=True):
        source += function.source(a + (b - a) * at)
        extinction += function(a + (b - a) * at)[1]
    before = np.concatenate([[0.0], np.cumsum(extinction)[:-1]]) * length / 256
    part = extinction * length / 256
    seen = np.where(part > 1e-12, -np.expm1(-part) / np.maximum(part, 1e-12), 1.0)
    sent = (np.exp(-before) * seen * length / 256)[:, None] * np.append(source, extinction[:, None], axis=1)
    exact, at_back = sent.sum(axis=0), at @ sent
    depth = extinction.mean() * length
    even = sent * 0 + np.append(source, extinction[:, None], axis=1).mean(axis=0) * length / 256
    even *= np.exp(-depth * at[:, None]) / np.exp(-depth * at).mean() * (-math.expm1(-depth) / depth if depth > 1e-12 else 1.0)
    assert np.abs(exact - even.sum(axis=0))[:3].max() <= evenness_error(mixture, length) + 1e-9
    bound = end_error(mixture, length) + 1e-4
    assert np.abs(at_back - at @ even).max() <= bound
    assert np.abs((1 - at) @ (sent - even)).max() <= bound


def test_the_bound_is_reached():
    """One channel in front, the other behind, in the shares that are worst."""
    depth = 3.0
    mean = -math.expm1(-depth) / depth
    share = -math.log(mean) / depth
    lit = 1 - math.exp(-share * depth)
    even = share * -math.expm1(-depth)
    mixture = al.Channels({0: al.TransferFunction([(0, "white", 1.0)]), 1: al.TransferFunction([(0, "black", 2.0)])})
    assert abs(lit - even - evenness_error(mixture, 1.0)) < 1e-12


@pytest.mark.parametrize("depth", [1e-3, 0.3, 3.0, 30.0])
def test_the_bound_of_the_ends_is_reached(depth):
    """What glows lies at the back, with nothing in front: thin slabs get half of their light wrong, opaque ones all of it."""
    x = depth
    back = -math.expm1(-x) / x - math.exp(-x)
    share = min(1.0, -math.log(back / x) / x)
    white, black = (al.TransferFunction([(0, colour, e)]) for colour, e in (("white", share * x), ("black", (1 - share) * x)))
    found = end_error(al.Channels({0: white, 1: black}), 1.0)
    assert found == pytest.approx(-math.expm1(-share * x) - share * back)
    assert found == pytest.approx(x / 2, rel=1e-2) if depth < 0.01 else found > 0.1
    assert end_error(al.Channels({0: al.TransferFunction([(0, "white", 0.0)])}), 1.0) < 1e-6


# -- functions chosen from the data


def test_automatic_channels_are_thin_where_they_are_everywhere():
    rng = np.random.default_rng(3)
    z, y, x = np.mgrid[-1:1:24j, -1:1:24j, -1:1:24j]
    spots = 900 * np.exp(-60 * ((x - 0.3) ** 2 + y * y + z * z)) + rng.normal(20, 3, x.shape)
    everywhere = 500 + rng.normal(0, 60, x.shape)
    data = al.Volume(np.clip([spots, everywhere], 0, None).astype(np.uint16), channel_names=["spots", "tissue"])
    mixture = al.automatic_channels(data, {"tissue": "#ff0000", "spots": None})
    assert [part.channel for part in mixture.parts] == ["tissue", "spots"]
    for number, part in ((1, mixture.parts[0]), (0, mixture.parts[1])):
        _, extinction = part.transfer(data.grid(number).astype(np.float64))
        assert 0 < extinction.mean() * 24 <= 0.6
        assert part.transfer.extinctions[0] == 0
    assert mixture.parts[1].transfer.extinctions.max() > 5 * mixture.parts[0].transfer.extinctions.max()
    assert tuple(mixture.parts[0].transfer.colours[-1]) == (1.0, 0.0, 0.0)
