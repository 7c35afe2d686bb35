"""Slabs that go through blocks of one medium: the image stays as it is, with fewer samples."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, cameras, rotation

import airlight as al
from airlight import reference
from airlight.gpu import blocks
from airlight.gpu.ranges import block_ranges

CLOSE = 1e-3
FOG = al.TransferFunction([(20, "teal", 0.01), (60, "orange", 0.2), (90, "white", 0.05)])
ISLANDS = al.TransferFunction([(25, "red", 0), (40, "gold", 0.1), (80, "white", 0.3)])
STEPS = al.TransferFunction(
    [
        (15, "teal", 0.02),
        (35, "teal", 0.02),
        (35, "red", 0.2),
        (55, "red", 0.2),
        (55, "gold", 0),
        (70, "gold", 0),
        (75, "white", 2),
    ]
)
GLOW = al.TransferFunction([(15, (0.02, 0, 0.01), 0), (45, (0.02, 0, 0.01), 0), (60, (0, 0.1, 0), 0)], associated=True)
FUNCTIONS = {"fog": FOG, "islands": ISLANDS, "steps": STEPS, "glow": GLOW}
UNLIT = {"shade": "none"}
LOOKS = {
    "unlit": UNLIT,
    "exact": UNLIT | {"transfer": "preintegrated_exact", "field": "linear_exact"},
    "post-classified": UNLIT | {"transfer": "postclassified", "field": "nearest"},
    "spline": UNLIT | {"transfer": "preintegrated_fast", "field": "bspline"},
    "lit": {"lighting": "interpolated"},
    "lit, kept gradients": {"gradient": "precomputed", "transfer": "postclassified"},
}


def regions(seed: int, side: int = 13, noise: float = 0.0) -> al.Volume:
    """Boxes of one value each, of which a share is rough, in a world that is turned."""
    rng = np.random.default_rng(seed)
    cells = rng.choice([10, 30, 50, 65, 85], (4, 4, 4))
    rough = rng.random(cells.shape) < noise
    for axis in range(3):
        cells, rough = np.repeat(cells, side, axis), np.repeat(rough, side, axis)
    values = cells + rough * rng.normal(0, 2, cells.shape)
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 2, 3), 0.4) * (1.0, 1.2, 0.9)
    return al.Volume(values[:45, :50].astype(np.float32), world_from_index=matrix)


def drawn(volume, function=FOG, camera="perspective", lights=(), clips=(), **look):
    return al.Scene(
        volume,
        transfer=function,
        camera=cameras(volume)[camera],
        look=al.Look(**look),
        lights=lights or (al.Light.head(),),
        clips=clips,
        background=None,
    )


@pytest.mark.parametrize("look", LOOKS)
@settings(max_examples=5)
@given(
    name=st.sampled_from(list(FUNCTIONS)),
    seed=st.integers(0, 10_000),
    camera=st.sampled_from(["perspective", "inside", "orthographic", "cut"]),
    step=st.sampled_from([0.7, 1.0, 1.7]),
    noise=st.sampled_from([0.0, 0.3]),
)
def test_the_image_is_the_same(renderer, look, name, seed, camera, step, noise):
    scene = drawn(regions(seed, noise=noise), FUNCTIONS[name], camera, **LOOKS[look])
    crossed, whole = (renderer.render(scene, SIZE, step=step, skip=skip) for skip in ("auto", "none"))
    assert np.abs(crossed.rgba - whole.rgba).max() < CLOSE
    assert np.mean(np.isfinite(whole.depth) != np.isfinite(crossed.depth)) < 2e-3
    met = np.isfinite(whole.depth) & np.isfinite(crossed.depth)
    off = np.abs(crossed.depth[met] - whole.depth[met])
    assert not off.size or np.quantile(off, 0.995) < 0.05


@pytest.mark.parametrize("look", ["exact", "lit"])
def test_fewer_samples_for_the_same_error(renderer, look):
    scene = drawn(regions(3, side=20), FOG, **LOOKS[look])
    crossed, whole = (renderer.render(scene, SIZE, skip=skip) for skip in ("auto", "none"))
    assert crossed.stats["skip"]["even"] > 0.4
    assert crossed.stats["samples"] < 0.8 * whole.stats["samples"]
    truth = reference.render(scene, SIZE).rgba
    errors = [np.abs(image.rgba - truth).max() for image in (crossed, whole)]
    assert errors[0] < errors[1] + 1e-4


def test_plateaus_of_noisy_data(renderer):
    rng = np.random.default_rng(1)
    values = np.where(np.arange(48) < 30, 10, 60) + rng.normal(0, 1.5, (40, 44, 48))
    scene = drawn(al.Volume(values.astype(np.float32)), FOG, **UNLIT)
    crossed, whole = (renderer.render(scene, SIZE, skip=skip) for skip in ("auto", "none"))
    assert crossed.stats["skip"]["even"] > 0.4
    assert crossed.stats["samples"] < 0.8 * whole.stats["samples"]
    assert np.abs(crossed.rgba - whole.rgba).max() < CLOSE


def test_an_error_that_is_asked_for(renderer):
    scene = drawn(regions(5, side=20), FOG, **UNLIT)
    image = renderer.render(scene, (24, 20), tolerance=0.004)
    truth = reference.converged(scene, (24, 20), step=1 / 32).rgba
    assert np.abs(image.rgba - truth).max() < 0.004


POINT = al.Light.point(position=(50, -40, 60), radius=50)
OFF = {
    "light from a place": {"lights": (POINT,)},
    "lit cuts": {"clips": (al.Clip.plane(point=(20, 20, 20), normal=(1, 0, 0)),)},
    "weighted by gradients": {"modulation": "gradient_magnitude"},
    "a projection": {"integrate": "mip"},
    "surfaces": {"function": al.TransferFunction(FOG.points, surfaces=[al.Surface(40.0, "gold", opacity=0.4)])},
}


@pytest.mark.parametrize("why", OFF)
def test_not_where_places_differ(renderer, why):
    image = renderer.render(drawn(regions(3, side=20), **OFF[why]), (8, 6))
    assert "even" not in image.stats["skip"]


def test_not_where_few_blocks_are_even(renderer):
    image = renderer.render(drawn(regions(3, noise=1.0), **UNLIT), (8, 6))
    assert image.stats["skip"] == {"asked": "auto", "done": "none", "reason": image.stats["skip"]["reason"]}


def test_numbers_of_blocks_reach_over_one_medium(monkeypatch):
    monkeypatch.setattr(blocks, "upload_blocks", lambda device, texels, kind: texels)
    ranges = block_ranges(regions(7, side=20).array)
    even, near = ranges.least == ranges.greatest, ranges.greatest > 25
    made = blocks.make_leaps(None, near, even)
    told = made.texture
    assert made.even == pytest.approx((even & near).sum() / near.sum())
    assert np.array_equal(told > blocks.MOST_LEAP, even & near)
    assert np.array_equal(told == 0, near & ~even)
    for place in np.argwhere(told > blocks.MOST_LEAP):
        reach = int(told[tuple(place)]) - blocks.MOST_LEAP
        part = tuple(slice(max(n - reach + 1, 0), n + reach) for n in place)
        assert even[part].all()
        assert np.ptp(ranges.least[part]) == 0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_plateaus_hold_one_medium(name):
    function = FUNCTIONS[name]
    values = np.linspace(0, 100, 4001)
    colours, extinctions = function(values)
    media = np.column_stack([colours, extinctions])
    inside = np.zeros(len(values), dtype=bool)
    for low, high in function.plateaus:
        on = (values >= low) & (values <= high)
        assert np.ptp(media[on], axis=0).max() < 1e-12
        inside |= on
    for low, high in function.empty_stretches:
        inside |= (values >= low) & (values <= high)
    still = np.abs(np.diff(media, axis=0)).max(axis=1) < 1e-12
    assert inside[1:-1][still[1:] & still[:-1]].all()
