"""Several channels in one march: parity with the reference, and laws of mixtures."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, lights

import airlight as al
from airlight import reference

LEVEL = 1 / 255
COLOURS = ["red", "lime", "blue", "yellow", "magenta", "cyan", "white", "orange"]
COUNTS = [1, 2, 4, 5, 16]


@cache
def channels(count: int, dtype: str = "float32") -> al.Volume:
    """Smooth fields that overlap, each with another range of values."""
    z, y, x = np.mgrid[-1:1:20j, -1:1:24j, -1:1:22j]
    fields = []
    for c in range(count):
        turn = 2.4 * c
        blob = np.exp(-3 * ((x - 0.4 * np.cos(turn)) ** 2 + (y - 0.4 * np.sin(turn)) ** 2 + (z + 0.1 * c % 1 - 0.4) ** 2))
        fields.append((100 + 15 * c) * blob + 5 * np.sin(4 * x + c) * np.cos(3 * y) + 6)
    return al.Volume(np.stack(fields).astype(dtype), world_from_index=blobs().world_from_index)


def function(c: int, steps: bool = False) -> al.TransferFunction:
    """Rising ones and bands; with steps, also at the very ends."""
    colour, top = COLOURS[c % len(COLOURS)], 100.0 + 15 * c
    if steps and c % 2:
        return al.TransferFunction(
            [(0.3 * top, colour, 0), (0.3 * top, colour, 0.4), (0.6 * top, "white", 0.4), (0.6 * top, colour, 0)]
        )
    if c % 3 == 2:
        return al.TransferFunction([(0.3 * top, colour, 0), (0.45 * top, colour, 0.6), (0.7 * top, "white", 0)])
    return al.TransferFunction([(0.3 * top, colour, 0.0), (0.57 * top, colour, 0.2), (0.9 * top, "white", 1.1)])


def mixture(count: int, steps: bool = False) -> al.Channels:
    return al.Channels([al.Channel(c, function(c, steps)) for c in range(count)])


def scene(volume: al.Volume, transfer, /, camera: str = "perspective", density: float = 1.0, **look) -> al.Scene:
    layer = al.Layer(volume, transfer, al.Look(**look), density=density)
    return al.Scene(layers=[layer], camera=cameras(volume)[camera], lights=lights(), background=None)


def compare(renderer: al.Renderer, drawn: al.Scene, step: float = 1.0, most: float = LEVEL) -> None:
    image, truth = renderer.render(drawn, SIZE, step=step), reference.render(drawn, SIZE, step=step)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    if drawn.layers[0].look.field.name == "nearest":
        # A sample on the border of two voxels may fall to either.
        assert error[-1] <= 10 * most
        error = error[: -max(1, error.size // 200)]
    assert truth.rgba[..., 3].max() > 0.2
    assert error[-1] <= most


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("shade", ["none", "blinn_phong"])
@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
def test_parity(either_renderer, count, shade, transfer):
    compare(either_renderer, scene(channels(count), mixture(count), transfer=transfer, shade=shade))


@pytest.mark.parametrize("field", ["nearest", "linear", "linear_exact"])
@pytest.mark.parametrize("gradient", ["central", "sobel", "precomputed"])
def test_parity_of_fields_and_gradients(either_renderer, field, gradient):
    compare(either_renderer, scene(channels(5), mixture(5), field=field, gradient=gradient))


@pytest.mark.parametrize("camera", ["orthographic", "inside", "cut"])
@pytest.mark.parametrize("step", [0.4, 2.5])
def test_parity_of_cameras_and_steps(renderer, camera, step):
    compare(renderer, scene(channels(5), mixture(5), camera, shade="none"), step)


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
def test_parity_with_steps_even_at_the_ends(any_renderer, transfer):
    compare(any_renderer, scene(channels(4), mixture(4, steps=True), field="linear_exact", transfer=transfer, shade="none"))


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
def test_parity_of_associated_functions(any_renderer, transfer):
    glow = [
        al.TransferFunction([(30, (0, 0, 0), 0), (60, (0.03, 0.02, 0), 0), (95, (0.1, 0, 0), 0.3)], associated=True),
        al.TransferFunction([(30, (0, 0, 0.02), 0.1), (95, (0, 0.1, 0.1), 0)], associated=True),
    ]
    drawn = scene(channels(2), glow, transfer=transfer, shade="none")
    compare(any_renderer, drawn)


@pytest.mark.parametrize("dtype", ["uint8", "int8", "int16", "uint16", "int32", "float16", "float64"])
@pytest.mark.parametrize("count", [2, 5])
def test_sample_types(either_renderer, dtype, count):
    volume = (
        channels(count, "int8" if dtype == "int8" else dtype)
        if dtype != "int8"
        else al.Volume(
            np.minimum(channels(count).array, 127).astype(np.int8), world_from_index=channels(count).world_from_index
        )
    )
    compare(either_renderer, scene(volume, mixture(count), shade="none"))


def holed(count: int) -> al.Volume:
    """Each channel with a hole of its own, and one place where all are empty."""
    data = channels(count).array.copy()
    for c in range(count):
        data[c, 6 : 10 + c % 3, 4 + 2 * (c % 5) : 12 + 2 * (c % 5), 5:14] = np.nan
    data[:, 13:17, 8:16, 8:16] = np.nan
    return al.Volume(data, world_from_index=channels(count).world_from_index)


@pytest.mark.parametrize("field", ["nearest", "linear"])
@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
@pytest.mark.parametrize("shade", ["none", "blinn_phong"])
def test_empty_samples_are_nothing_of_their_channel(either_renderer, field, transfer, shade):
    compare(either_renderer, scene(holed(5), mixture(5), field=field, transfer=transfer, shade=shade))


@pytest.mark.parametrize("shape", [(1, 20, 30), (20, 1, 30), (12, 13, 1), (2, 2, 2)])
def test_groups_do_not_bleed_into_each_other(renderer, shape):
    """Thin volumes, in which the first and the last slice of a group are all there is."""
    rng = np.random.default_rng(3)
    volume = al.Volume(rng.uniform(0, 200, (9, *shape)).astype(np.float32), spacing=(1, 1.5, 2))
    for field in ("linear", "linear_exact", "nearest"):
        compare(renderer, scene(volume, mixture(9), field=field, shade="none"))


# -- laws


def draw(renderer, volume, transfer, /, **look) -> np.ndarray:
    return renderer.render(scene(volume, transfer, **look), SIZE).rgba


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
def test_the_order_of_channels_does_not_matter(renderer, transfer):
    parts = mixture(6).parts
    one = draw(renderer, channels(6), al.Channels(parts), transfer=transfer)
    other = draw(renderer, channels(6), al.Channels(parts[::-1]), transfer=transfer)
    assert np.abs(one - other).max() < 1e-5


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated", "preintegrated_fast"])
def test_one_channel_is_the_plain_function(renderer, transfer):
    """The same picture to the last bit, with light, and whichever channel it is."""
    alone = al.Volume(channels(4).array[2], world_from_index=channels(4).world_from_index)
    plain = draw(renderer, alone, function(2), transfer=transfer)
    assert plain[..., 3].max() > 0.2
    assert np.array_equal(plain, draw(renderer, channels(4), al.Channels({2: function(2)}), transfer=transfer))


@pytest.mark.parametrize(
    ("transfer", "same_as"), [("postclassified", "postclassified"), ("preintegrated", "preintegrated_fast")]
)
def test_a_channel_beside_an_empty_one_is_the_plain_function(renderer, transfer, same_as):
    """By way of the sums over channels. Pre-integrated they attenuate as ``preintegrated_fast`` does, but slabs that reach
    beyond the function's ends as a whole.
    """
    nothing = al.TransferFunction([(0, "white", 0.0)])
    alone = al.Volume(channels(4).array[0], world_from_index=channels(4).world_from_index)
    plain = draw(renderer, alone, function(0), transfer=same_as, shade="none")
    both = draw(renderer, channels(4), al.Channels({0: function(0), 3: nothing}), transfer=transfer, shade="none")
    assert np.abs(plain - both)[..., 3].max() < 2e-6
    assert np.abs(plain - both).max() < (2e-6 if transfer == "postclassified" else LEVEL / 2)


def test_a_hidden_channel_is_absent_and_nothing_is_uploaded_again(renderer):
    parts = mixture(6).parts
    hidden = [al.Channel(p.channel, p.transfer, visible=p.channel in (0, 5)) for p in parts]
    assert (
        np.abs(
            draw(renderer, channels(6), al.Channels(hidden)) - draw(renderer, channels(6), al.Channels([parts[0], parts[5]]))
        ).max()
        < 1e-5
    )
    volume = al.Volume(channels(6).array, world_from_index=channels(6).world_from_index)
    uploads: list[int] = []

    def progress(what, done, total):
        uploads.extend([done] if what == "upload" else [])

    renderer.render(scene(volume, al.Channels(parts)), SIZE, progress=progress)
    assert uploads
    uploads.clear()
    renderer.render(scene(volume, al.Channels(hidden)), SIZE, progress=progress)
    assert not uploads


def test_density_multiplies_extinction(renderer):
    thick = al.Channels([al.Channel(c, function(c), density=1.5 + c) for c in range(3)])
    by_hand = al.Channels({c: function(c).scaled(1.5 + c) for c in range(3)})
    assert np.array_equal(draw(renderer, channels(3), thick), draw(renderer, channels(3), by_hand))
    of_layer = renderer.render(scene(channels(3), mixture(3), density=2.5), SIZE).rgba
    assert np.array_equal(of_layer, draw(renderer, channels(3), mixture(3).scaled(2.5)))


@pytest.mark.parametrize(
    ("transfer", "same_as"), [("postclassified", "postclassified"), ("preintegrated", "preintegrated_fast")]
)
def test_the_same_data_twice_is_twice_the_density(renderer, transfer, same_as):
    alone = al.Volume(channels(1).array[0], world_from_index=channels(1).world_from_index)
    twice = al.Volume(np.stack([alone.array] * 2), world_from_index=alone.world_from_index)
    once = renderer.render(scene(alone, function(0), density=2, transfer=same_as), SIZE).rgba
    both = draw(renderer, twice, [function(0), function(0)], transfer=transfer)
    assert np.abs(once - both)[..., 3].max() < 1e-5
    unlit = renderer.render(scene(alone, function(0), density=2, transfer=same_as, shade="none"), SIZE).rgba
    both = draw(renderer, twice, [function(0), function(0)], transfer=transfer, shade="none")
    assert np.abs(unlit - both).max() < (1e-5 if transfer == "postclassified" else LEVEL / 2)


def test_white_channels_are_lit_as_their_sum_is(renderer):
    """Two channels, each half of the data: normals are those of the whole."""
    whole = channels(1).array[0]
    halves = al.Volume(np.stack([whole / 2, whole / 2]), world_from_index=channels(1).world_from_index)
    rising = al.TransferFunction([(20, "white", 0), (100, "white", 0.8)])
    of_half = al.TransferFunction([(10, "white", 0), (50, "white", 0.4)])
    shade = al.shade.BlinnPhong(gradient_threshold=0.0)
    one = draw(
        renderer, al.Volume(whole, world_from_index=halves.world_from_index), rising, transfer="postclassified", shade=shade
    )
    two = draw(renderer, halves, [of_half, of_half], transfer="postclassified", shade=shade)
    # Below the value at which it is seen, a channel has no gradient: normals next to there differ by the cut difference.
    assert np.abs(one - two)[..., 3].max() < 1e-5
    assert np.quantile(np.abs(one - two).max(axis=-1), 0.95) < 3 * LEVEL


# -- what is said of it


def test_time_steps(renderer):
    data = np.stack([channels(2).array, channels(2).array[:, ::-1]])
    volume = al.Volume(data, world_from_index=channels(2).world_from_index)
    for time in (0, 1):
        alone = al.Volume(data[time], world_from_index=channels(2).world_from_index)
        layer = al.Layer(volume, mixture(2), al.Look(), time=time)
        drawn = al.Scene(layers=[layer], camera=cameras(alone)["perspective"], lights=lights(), background=None)
        assert np.array_equal(renderer.render(drawn, SIZE).rgba, draw(renderer, alone, mixture(2)))


def test_statistics_name_the_format_and_the_approximation(renderer):
    image = renderer.render(scene(channels(5), mixture(5)), SIZE)
    (layer,) = image.stats["layers"]
    assert layer["stages"]["transfer"] == "preintegrated_channels"
    assert layer["textures"][0]["format"] == "rgba32float"
    slab, end = (
        layer["errors"][f"transfer: colour of {what}, its channels spread evenly"] for what in ("a slab", "a slab's end")
    )
    assert 0 < slab < end < 1
    post = renderer.render(scene(channels(2, "uint16"), mixture(2), transfer="postclassified"), SIZE).stats["layers"][0]
    assert post["errors"] == {}
    assert post["textures"][0]["format"].startswith("rg")


def test_projections_of_several_channels_are_refused(renderer):
    for integrate in ("mip", "minip", "mean", "first_hit"):
        with pytest.raises(al.StageError, match="channel=number"):
            draw(renderer, channels(3), mixture(3), integrate=integrate)
        alone = draw(renderer, channels(3), al.Channels({1: function(1)}), integrate=integrate)
        assert alone[..., 3].max() > 0.5


def test_a_stack_that_is_too_deep_is_refused(core_renderer):
    """Groups lie behind each other: 5 channels of 1,100 slices are 2,200, and core devices hold 2,048."""
    volume = al.Volume(np.zeros((5, 1100, 2, 2), dtype=np.uint8))
    with pytest.raises(al.LimitError, match="draw 4 channels at a time"):
        core_renderer.render(al.Scene(volume, transfer=mixture(5)), (8, 8))


def test_channels_that_are_not_there_are_named(renderer):
    with pytest.raises(al.DataError, match="channel"):
        draw(renderer, channels(2), mixture(3))
    named = al.Volume(channels(2).array, channel_names=["DAPI", "GFP"])
    with pytest.raises(al.ValueRangeError, match="once"):
        draw(renderer, named, al.Channels({"DAPI": function(0), 0: function(1)}))


def test_change_is_refused_for_a_mixture(renderer):
    volume = al.Volume(np.random.default_rng(1).uniform(0, 1, (2, 6, 7, 8)).astype(np.float32))
    ramp = al.TransferFunction([(0, "red", 0), (1, "red", 1)])
    drawn = al.Scene(volume, transfer=[ramp, ramp], look=al.Look(modulation="change"))
    with pytest.raises(al.StageError, match=r"look.modulation 'change'.*use gradient_magnitude"):
        renderer.render(drawn, (8, 8))
    renderer.render(al.Scene(volume, transfer=[ramp, ramp], look=al.Look(modulation="gradient_magnitude")), (8, 8))


def test_precomputed_gradients_follow_the_channels_that_are_shown(renderer):
    """Eight channels with equal functions: showing two of the second group must not be lit by gradients of the first."""
    rng = np.random.default_rng(2)
    volume = al.Volume(rng.uniform(0, 1, (8, 10, 11, 12)).astype(np.float32))
    ramp = al.TransferFunction([(0, "white", 0), (1, "white", 0.5)])
    look = al.Look(gradient="precomputed", field="linear_exact")

    def shown(*numbers):
        parts = [al.Channel(i, ramp, visible=i in numbers) for i in range(8)]
        return al.Scene(volume, transfer=al.Channels(parts), look=look)

    first = renderer.render(shown(0, 1), (32, 32)).rgba
    second = renderer.render(shown(4, 5), (32, 32)).rgba
    with al.Renderer() as fresh:
        assert np.array_equal(second, fresh.render(shown(4, 5), (32, 32)).rgba)
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("count", [2, 5])
@pytest.mark.parametrize("field", ["linear", "linear_exact"])
def test_channels_of_very_different_ranges(either_renderer, field, count):
    """A channel whose values differ by thousandths beside one with thousands: half floats hold each in its own range."""
    scales, base = np.array([1e-3, 1e4, 1.0, 1e-2, 1e-3][:count]), channels(count)
    shifts = np.array([7.0, 0.0, -3.0, 0.0, 2.0][:count])
    array = base.array * scales[:, None, None, None] + shifts[:, None, None, None]
    volume = al.Volume(array.astype(np.float32), world_from_index=base.world_from_index)
    moved = [
        al.TransferFunction([(v * scale + shift, rgb, tau) for v, rgb, tau in function(c).points])
        for c, (scale, shift) in enumerate(zip(scales, shifts, strict=True))
    ]
    drawn = scene(volume, al.Channels([al.Channel(c, tf) for c, tf in enumerate(moved)]), field=field)
    compare(either_renderer, drawn)
    texture = either_renderer.render(drawn, SIZE).stats["layers"][0]["textures"][0]
    assert texture["error"] == max(texture["channel_errors"])
    for error, scale in zip(texture["channel_errors"], scales, strict=True):
        assert error <= 2.0**-12 * 100 * scale


@pytest.mark.parametrize(("asked", "told"), [({"entries": 256}, "entries=256"), ({"lengths": 4}, "lengths=4")])
def test_a_table_that_there_is_not_is_refused(renderer, asked, told):
    stage = al.transfer.PreIntegrated(**asked)
    with pytest.raises(al.StageError, match=f"'preintegrated' asks for {told}, and several channels have no table"):
        renderer.render(scene(channels(2), mixture(2), transfer=stage), SIZE)
    parts = al.Volume(np.ones((24, 24, 24), np.uint8))
    labels = al.Labels(parts, {1: al.LabelStyle(transfer=function(0))})
    with pytest.raises(al.StageError, match=f"'preintegrated' asks for {told}, and functions of labels have no table"):
        renderer.render(al.Scene(blobs(), transfer=function(1), look=al.Look(transfer=stage), labels=labels), SIZE)
