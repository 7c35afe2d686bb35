"""Shadow volumes: closed forms and laws of the reference, parity with it, and what is made anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, cameras, function, lights, rotation

import airlight as al
from airlight import reference
from airlight.errors import LimitError, StageError
from airlight.reference import half_angle
from airlight.reference import shadows as truth
from airlight.rendering import occluders, shadows
from airlight.stages.transport import Coloured

LEVEL = 1 / 255
WAYS = ["sweep", "rays"]
SIDE = al.Light.directional(to_light=(1, -0.4, 0.7))
EVEN = al.TransferFunction([(0, "white", 0.05), (100, "white", 0.05)])


def shaded(
    volume: al.Volume, tf: al.TransferFunction, *lamps: al.Light, camera="iso", clips=(), look=None, **stage
) -> al.Scene:
    drawn = al.Look(visibility=al.visibility.ShadowVolume(**{"cells": 12, **stage}), **(look or {}))
    return al.Scene(volume, transfer=tf, look=drawn, camera=camera, lights=lamps or (SIDE,), clips=clips, background=None)


def reached(drawn: al.Scene) -> np.ndarray:
    """What comes through to cells from the first light, without those around the volume: (z, y, x)."""
    setup = reference.prepare(drawn)
    return truth.cells_reached(setup, setup.lights[0])[1:-1, 1:-1, 1:-1, 0]


def exact(setup, lamp: al.Light, p_world: np.ndarray, tint: float = 0.0) -> np.ndarray:
    """What comes through (n, 3) from a light to points."""
    return half_angle.transmittance(setup, lamp, p_world, Coloured(tint=tint), 0.25 * setup.spacing_world)


# -- closed forms and laws, of the reference


@pytest.mark.parametrize("to_light", [(0, 0, 1), (0, -1, 0), (1, -0.4, 0.7), (-0.2, 1, 0.9)])
def test_a_homogeneous_block(to_light):
    """What comes through falls with the way to the face, exactly; what a sweep interpolates again and again leaks a bit."""
    volume = al.Volume(np.full((12, 14, 16), 50.0), spacing=(1, 1.5, 0.8))
    lamp = al.Light.directional(to_light=to_light)
    z, y, x = np.indices((12, 14, 16)).reshape(3, -1)
    p_world = np.stack([x, 1.5 * y, 0.8 * z], axis=1)
    high, direction = np.array([15, 1.5 * 13, 0.8 * 11]), np.array(lamp.vector)
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(direction > 0, (high - p_world) / direction, np.where(direction < 0, -p_world / direction, np.inf))
    expected = np.exp(-0.05 * ways.min(axis=1))
    setup = reference.prepare(shaded(volume, EVEN, lamp))
    assert exact(setup, lamp, p_world)[:, 0] == pytest.approx(expected, rel=1e-6)
    for by in WAYS:
        found = reached(shaded(volume, EVEN, lamp, by=by, cells=64)).ravel()
        if by == "rays" or (direction == 0).sum() == 2:
            assert found == pytest.approx(expected, rel=1e-6)
        assert (found - expected).min() > -1e-6
        assert (found - expected).max() < 0.12
        assert (found - expected).std() < 0.02


@pytest.mark.parametrize("side", [-1, 1])
def test_cells_that_end_with_the_volume(side):
    """The last of eight cells has one voxel, the others three: light from either side comes as far."""
    volume, lamp = al.Volume(np.full((9, 9, 22), 50.0)), al.Light.directional(to_light=(side, 0, 0))
    setup = reference.prepare(shaded(volume, EVEN, lamp, cells=8, bias=0.0))
    x = np.arange(4.0, 18.0)
    found = truth.shadow_volume(setup, 0, np.stack([x, 0 * x + 4, 0 * x + 4], axis=1))[:, 0]
    assert found == pytest.approx(np.exp(-0.05 * (21 - x if side > 0 else x)), abs=3e-3)


@pytest.mark.parametrize("by", WAYS)
def test_a_near_light_above_a_block(by):
    volume, lamp = al.Volume(np.full((9, 11, 11), 50.0)), al.Light.point(position=(5, 5, 20))
    setup = reference.prepare(shaded(volume, EVEN, lamp))
    place = np.array([[5.0, 5.0, 0.0], [8.0, 3.0, 4.0], [5.0, 5.0, 12.0]])
    share = np.array([8 / 20, 4 / 16, 0.0])  # of the ways lie in the block
    expected = np.exp(-0.05 * share * np.linalg.norm(np.array(lamp.vector) - place, axis=1))
    assert exact(setup, lamp, place)[:, 0] == pytest.approx(expected, rel=1e-6)
    found = reached(shaded(volume, EVEN, lamp, by=by, cells=64))
    assert [found[0, 5, 5], found[4, 3, 8]] == pytest.approx(expected[:2], rel=1e-2)


@pytest.mark.parametrize("by", WAYS)
def test_a_wall(by):
    """It lies in front of one half: no light leaks through it, and the other half is fully lit."""
    values = np.zeros((16, 16, 16), dtype=np.float32)
    values[12:14, :, 8:] = 1
    tf = al.TransferFunction([(0.2, "white", 0), (1, "white", 50.0)])
    found = reached(shaded(al.Volume(values), tf, al.Light.directional(to_light=(0, 0, 1)), by=by, cells=16))
    assert found[:11, :, 9:].max() < 2e-4
    assert (found[:, :, :6] == 1).all()
    assert (found[15] == 1).all()


def test_colours_pass_their_own_medium():
    red = al.TransferFunction([(0, (1, 0.5, 0), 0.05), (100, (1, 0.5, 0), 0.05)])
    volume = al.Volume(np.full((12, 12, 12), 50.0))
    setup = reference.prepare(shaded(volume, red, al.Light.directional(to_light=(0, 0, 1)), tint=0.8, cells=12))
    for found in (
        truth.cells_reached(setup, setup.lights[0])[1, 6, 6],
        exact(setup, setup.lights[0], np.array([[6.0, 6, 0]]), tint=0.8)[0],
    ):
        assert found == pytest.approx(np.exp(-0.55 * np.array([0.2, 0.6, 1.0])), rel=1e-6)


@settings(max_examples=12)
@given(
    seed=st.integers(0, 2**16),
    density=st.floats(0.0, 3.0),
    to_light=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    angle=st.floats(-3, 3),
    by=st.sampled_from(WAYS),
)
def test_a_share_that_falls_with_density_and_turns_with_the_world(seed, density, to_light, angle, by):
    values = np.random.default_rng(seed).uniform(0, 1, (7, 8, 9)).astype(np.float32)
    tf = al.TransferFunction([(0.3, "white", 0), (1, "white", density)])
    thin = reached(shaded(al.Volume(values), tf, al.Light.directional(to_light=to_light), by=by))
    thick = reached(shaded(al.Volume(values), tf.scaled(2), al.Light.directional(to_light=to_light), by=by))
    assert thin.min() >= 0
    assert thin.max() <= 1
    assert (thick <= thin + 1e-9).all()
    turn = rotation((1, 2, 3), angle)
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    turned = al.Light.directional(to_light=tuple(turn @ np.array(to_light)))
    again = reached(shaded(al.Volume(values, world_from_index=matrix), tf, turned, by=by))
    assert np.abs(again - thin).max() < 1e-6


@pytest.mark.parametrize("by", WAYS)
def test_errors_fall_as_the_resolution_grows(by, rng):
    place = cameras(blobs())["perspective"].target + rng.uniform(-10, 10, (300, 3))
    found = []
    for cells in (8, 16, 40):
        setup = reference.prepare(shaded(blobs(), function(), SIDE, by=by, cells=cells, bias=1.5))
        expected = exact(setup, SIDE, truth.nearer(SIDE, place, 1.5 * setup.spacing_world))
        found.append(np.sqrt(np.mean((truth.shadow_volume(setup, 0, place) - expected) ** 2)))
    assert found[1] < 0.6 * found[0]
    assert found[2] < 0.6 * found[1]
    assert found[2] < 0.03


# -- the device


def compare(renderer, drawn: al.Scene, tolerance: float = LEVEL / 2) -> np.ndarray:
    image, expected = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.abs(image.rgba - expected.rgba).max() <= tolerance
    return image.rgba


@pytest.mark.parametrize("by", WAYS)
def test_parity(any_renderer, by):
    """With lights of each kind, one as far away along two axes; coarse and fine cells, looked up nearer and further."""
    turn = blobs().world_from_index[:3, :3] * (4, 3, 4)  # voxels of a cell, of 12 along the longest side
    both = al.Light.directional(to_light=tuple(turn @ (-1, 1, 0.2)))
    for stage in ({"cells": 36, "bias": 0.0}, {"tint": 1.0, "bias": 3.0}, {}):
        drawn = shaded(blobs(), function(), *lights(), both, by=by, **stage)
        lit = compare(any_renderer, drawn)
    plain = any_renderer.render(with_visibility(drawn, "none"), SIZE).rgba
    assert np.allclose(lit[..., 3], plain[..., 3], atol=1e-6)
    assert (lit[..., :3] <= plain[..., :3] + 1e-6).all()
    assert lit[..., :3].sum() < 0.95 * plain[..., :3].sum()


def with_visibility(drawn: al.Scene, visibility) -> al.Scene:
    layer = drawn.layers[0]
    return replace(drawn, layers=(replace(layer, look=replace(layer.look, visibility=visibility)),))


def test_no_unit_of_the_world_is_too_large(renderer):
    scaling = np.diag([1e12, 1e12, 1e12, 1.0])
    large = al.Volume(blobs().array, world_from_index=scaling @ blobs().world_from_index)
    thin = function().scaled(1e-12)
    here = compare(renderer, shaded(blobs(), function(), SIDE))
    assert np.abs(compare(renderer, shaded(large, thin, SIDE)) - here).max() < LEVEL


def test_parity_with_other_functions_samples_and_clips(renderer):
    """Mixtures, empty samples, labels, post-classified slabs; what clips cut away casts no shadow."""
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    place = {"world_from_index": blobs().world_from_index}
    two = al.Volume(np.stack([blobs().array, 130 - blobs().array]), **place)
    thin = al.TransferFunction([(40, "red", 0.0), (110, "blue", 0.3)])
    labels = np.zeros(blobs().array.shape, dtype=np.uint8)
    labels[:, :18] = 1
    named = al.Labels(al.Volume(labels, **place), {1: al.LabelStyle("red", opacity=0.1)})
    corners = blobs().corners_world()
    middle = tuple(corners.mean(axis=0))
    whole = shaded(blobs(), function(), tint=0.5)
    whole_rgba = compare(renderer, whole)
    cut = al.Clip.plane(point=middle, normal=(1, 0.3, 0))
    for drawn in (
        shaded(two, al.Channels([al.Channel(0, thin), al.Channel(1, thin.with_reversed_colours())])),
        shaded(al.Volume(holed, **place), function(), clips=[cut], look={"transfer": "postclassified"}),
        replace(whole, layers=(replace(whole.layers[0], labels=named),)),
    ):
        rgba = compare(renderer, drawn)
        assert rgba.any()
        assert np.abs(rgba - whole_rgba).max() > 0.05


def test_lights_share_a_texture(renderer):
    """Two of half the intensity are one, whatever stands between them; and so are far volumes and near ones."""
    one = renderer.render(shaded(blobs(), function(), SIDE), SIZE)
    half, other = replace(SIDE, intensity=0.5), al.Light.point(position=(50, -40, 60), intensity=0.0)
    two = renderer.render(shaded(blobs(), function(), half, al.Light.head(intensity=0.0), other, half), SIZE)
    assert np.abs(one.rgba - two.rgba).max() < 1e-5
    assert one.stats["tables"]["visibility.shadows"] == [12, 14, 10, 4]
    assert two.stats["tables"]["visibility.shadows"] == [36, 14, 10, 4]
    moved = blobs().world_from_index.copy()
    moved[:3, 3] += 1e6
    far = renderer.render(shaded(al.Volume(blobs().array, world_from_index=moved), function(), SIDE), SIZE)
    assert np.abs(far.rgba - one.rgba).max() < LEVEL


def test_made_anew_for_another_light_only(monkeypatch):
    made, gathered = [], []
    make, gather = shadows._made, occluders._gathered
    monkeypatch.setattr(shadows, "_made", lambda *given: made.append(1) or make(*given))
    monkeypatch.setattr(occluders, "_gathered", lambda *given: gathered.append(1) or gather(*given))
    with al.Renderer() as renderer:
        base = shaded(blobs(), function(), SIDE)
        renderer.render(base, SIZE)
        renderer.render(replace(base, camera="front"), SIZE)
        renderer.render(replace(base, lights=[replace(SIDE, intensity=0.3), al.Light.head()]), SIZE)
        assert (len(made), len(gathered)) == (1, 1)
        renderer.render(replace(base, lights=[al.Light.directional(to_light=(0, 0, 1))]), SIZE)
        assert (len(made), len(gathered)) == (2, 1)
        renderer.render(shaded(blobs(), function().scaled(2), SIDE), SIZE)
        renderer.render(base, SIZE)
        assert (len(made), len(gathered)) == (3, 2)


def test_surfaces_are_lit_again_in_another_shadow(renderer):
    first = shaded(blobs(), function(), SIDE, look={"integrate": al.integrate.FirstHit(iso=70.0)})
    turned = replace(first, lights=[al.Light.directional(to_light=(0, -1, 0.3))])
    image = renderer.render(first, SIZE, keep_hits=True)
    assert np.abs(renderer.relight(image, turned).rgba - renderer.render(turned, SIZE).rgba).max() < LEVEL


def test_what_is_refused(renderer):
    middle = tuple(blobs().corners_world().mean(axis=0))
    inside = al.Light.point(position=middle)
    with pytest.raises(StageError, match=r"'sweep' runs away from a light.* use by='rays'"):
        renderer.render(shaded(blobs(), function(), inside), SIZE)
    compare(renderer, shaded(blobs(), function(), inside, by="rays"))
    with pytest.raises(StageError, match="there are head lights alone: add lights"):
        renderer.render(shaded(blobs(), function(), al.Light.head()), SIZE)
    with pytest.raises(LimitError, match="are 33, and shadows know 32"):
        renderer.render(shaded(blobs(), function(), *[SIDE] * 33), SIZE)
    long = al.Volume(np.zeros((256, 4, 4), np.uint8))
    with pytest.raises(LimitError, match=r"for 32 lights.* take fewer cells or lights"):
        renderer.render(shaded(long, function(), *[SIDE] * 32, cells=256), SIZE)
    with pytest.raises(StageError, match="nothing is lit"):
        renderer.render(shaded(blobs(), function(), look={"shade": "none"}), SIZE)
    with pytest.raises(StageError, match="dims lights, and shade 'environment' asks none"):
        renderer.render(shaded(blobs(), function(), look={"shade": "environment"}), SIZE)
