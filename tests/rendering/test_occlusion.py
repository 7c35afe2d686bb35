"""Ambient occlusion: closed forms and laws of the reference, parity with it, and what is made anew."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, function, scene

import airlight as al
from airlight import reference
from airlight.errors import LimitError, ValueRangeError
from airlight.reference import occlusion as truth
from airlight.rendering import occlusion

LEVEL = 1 / 255
AMBIENT = al.shade.BlinnPhong(ambient=1.0, diffuse=0.0, specular=0.0)
COARSE = al.visibility.AmbientOcclusion(cells=12, directions=24)


def occluded(volume: al.Volume, tf: al.TransferFunction, stage=COARSE, **changes) -> al.Scene:
    look = al.Look(shade=AMBIENT, visibility=stage, **changes)
    return al.Scene(volume, transfer=tf, look=look, camera="iso", background=None)


def openness(volume: al.Volume, tf: al.TransferFunction, stage, *places) -> np.ndarray:
    """Openness of chosen cells (x, y, z), or of all."""
    setup = reference.prepare(occluded(volume, tf, stage))
    if not places:
        return truth.openness(setup)
    return truth.seen_from(setup, truth.occluders(setup), np.array(places, dtype=np.float64))


def ball(n: int, radius: float) -> np.ndarray:
    axis = np.arange(n) - (n - 1) / 2
    distance = np.sqrt(axis[:, None, None] ** 2 + axis[None, :, None] ** 2 + axis[None, None, :] ** 2)
    return np.clip(radius - distance + 0.5, 0, 1).astype(np.float32)


# -- closed forms and laws, of the reference


@pytest.mark.parametrize("tau", [0.02, 0.2])
def test_the_middle_of_a_ball(tau):
    """All ways out are as long: exp(-tau (radius - cell)); and no longer than one looks."""
    volume, tf = al.Volume(ball(41, 15.0)), al.TransferFunction([(0, "white", 0), (1, "white", tau)])
    found = openness(volume, tf, al.visibility.AmbientOcclusion(radius=20, cells=41, directions=200), (20, 20, 20))
    assert found[0] == pytest.approx(math.exp(-tau * 14.0), rel=0.01)
    near = openness(volume, tf, al.visibility.AmbientOcclusion(radius=9, cells=41, directions=50), (20, 20, 20))
    assert near[0] == pytest.approx(math.exp(-tau * 8.0), rel=1e-3)


def test_a_place_in_a_homogeneous_ball():
    """At a distance r from the middle the way out is sqrt(R^2 - r^2 sin^2) - r cos: average it over the angle."""
    tau, radius, r = 0.1, 15.0, 8.0
    volume, tf = al.Volume(ball(41, radius)), al.TransferFunction([(0, "white", 0), (1, "white", tau)])
    cosine = np.linspace(-1, 1, 20001)
    way = np.sqrt(radius**2 - r**2 * (1 - cosine**2)) - r * cosine
    expected = np.exp(-tau * np.maximum(way - 1, 0)).mean()
    stage = al.visibility.AmbientOcclusion(radius=30, cells=41, directions=300)
    found = openness(volume, tf, stage, (28, 20, 20), (20, 12, 20), (20, 20, 28))
    assert found == pytest.approx([expected] * 3, rel=0.015)


def test_a_wall_hides_half_of_the_sky():
    """On the face of an opaque half space, as seen from a cell away: what lies within half a cell of the face is seen over."""
    values = np.zeros((24, 24, 24), dtype=np.float32)
    values[:12] = 1
    tf = al.TransferFunction([(0, "white", 0), (1, "white", 50.0)])
    stage = al.visibility.AmbientOcclusion(radius=8, cells=24, directions=400)
    above, below, away = openness(al.Volume(values), tf, stage, (12, 12, 12), (12, 12, 6), (12, 12, 23))
    assert 0.5 < above < 0.75
    assert below < 0.01
    assert away == 1.0  # nothing within eight voxels


@settings(max_examples=15)
@given(
    seed=st.integers(0, 2**16),
    density=st.floats(0.0, 3.0),
    factor=st.floats(1.0, 5.0),
    spacing=st.tuples(*[st.floats(0.3, 3)] * 3),
)
def test_openness_is_a_share_and_falls_with_density(seed, density, factor, spacing):
    values = np.random.default_rng(seed).uniform(0, 1, (7, 8, 9)).astype(np.float32)
    stage = al.visibility.AmbientOcclusion(cells=8, directions=12)
    thin, thick = (
        openness(al.Volume(values, spacing=spacing), al.TransferFunction([(0.3, "white", 0), (1, "white", d)]), stage)
        for d in (density, density * factor)
    )
    assert (thin >= 0).all()
    assert (thin <= 1).all()
    assert (thick <= thin + 1e-12).all()
    if density == 0:
        assert (thin == 1).all()


def test_scale_of_the_world_does_not_matter():
    near = openness(blobs(), function(), COARSE)
    large = al.Volume(blobs().array, world_from_index=np.diag([10, 10, 10, 1.0]) @ blobs().world_from_index)
    assert np.abs(openness(large, function().scaled(0.1), COARSE) - near).max() < 1e-9


# -- the device


def compare(renderer, drawn: al.Scene, tolerance: float = LEVEL / 2) -> np.ndarray:
    image, expected = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.abs(image.rgba - expected.rgba).max() <= tolerance
    return image.rgba


@pytest.mark.parametrize(
    "stage",
    [
        COARSE,
        al.visibility.AmbientOcclusion(cells=40, directions=8, radius=4.0),
        al.visibility.AmbientOcclusion(radius=15.0, cells=9),
    ],
    ids=["coarse", "a cell a voxel", "few cells"],
)
@pytest.mark.parametrize("transfer", ["preintegrated", "postclassified"])
def test_parity(either_renderer, stage, transfer):
    lit = compare(either_renderer, occluded(blobs(), function(), stage, transfer=transfer))
    plain = either_renderer.render(occluded(blobs(), function(), "none", transfer=transfer), SIZE).rgba
    assert np.allclose(lit[..., 3], plain[..., 3], atol=1e-6)
    assert (lit[..., :3] <= plain[..., :3] + 1e-6).all()
    assert lit[..., 0].sum() < 0.9 * plain[..., 0].sum()


def test_parity_with_other_functions_and_samples(any_renderer):
    """Mixtures, surfaces alone, empty samples, labels, thin volumes, nearest and pre-classified fields."""
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    place = {"world_from_index": blobs().world_from_index}
    two = al.Volume(np.stack([blobs().array, 130 - blobs().array]), **place)
    thin = al.TransferFunction([(40, "red", 0.0), (110, "blue", 0.3)])
    labels = np.zeros(blobs().array.shape, dtype=np.uint8)
    labels[:, :18] = 1
    named = al.Labels(al.Volume(labels, **place), {1: al.LabelStyle("red", opacity=0.1)})
    sheet = al.TransferFunction.from_surfaces([al.Surface(70.0, "gold", 0.9)])
    for drawn in (
        occluded(two, al.Channels([al.Channel(0, thin), al.Channel(1, thin.with_reversed_colours())])),
        occluded(blobs(), sheet),
        occluded(al.Volume(holed, **place), function()),
        occluded(al.Volume(blobs().array[:1], **place), function()),
        occluded(blobs(), function(), field="preclassified"),
    ):
        assert compare(any_renderer, drawn).any()
    base = occluded(blobs(), function())
    labelled = al.Scene(layers=[replace(base.layers[0], labels=named)], camera="iso", background=None)
    assert np.abs(compare(any_renderer, labelled) - compare(any_renderer, base)).max() > 0.1


def test_far_volumes(renderer):
    """The device's world is moved near to the volume; openness goes with it."""
    moved = blobs().world_from_index.copy()
    moved[:3, 3] += 1e6
    near = renderer.render(occluded(blobs(), function()), SIZE).rgba
    assert (
        np.abs(renderer.render(occluded(al.Volume(blobs().array, world_from_index=moved), function()), SIZE).rgba - near).max()
        < LEVEL
    )


def test_made_anew_for_another_function_only(monkeypatch):
    made = []
    make = occlusion._made
    monkeypatch.setattr(occlusion, "_made", lambda *given: made.append(1) or make(*given))
    with al.Renderer() as renderer:
        base = occluded(blobs(), function())
        renderer.render(base, SIZE)
        renderer.render(replace(base, camera="front"), SIZE)
        renderer.render(replace(base, lights=()), SIZE)
        renderer.render(occluded(blobs(), al.TransferFunction(function().points)), SIZE, step=0.5)
        assert len(made) == 1
        renderer.render(occluded(blobs(), function().scaled(2)), SIZE)
        assert len(made) == 2
        renderer.render(base, SIZE)
        assert len(made) == 2


def test_a_radius_within_a_cell_is_refused(renderer):
    with pytest.raises(ValueRangeError, match=r"ambient_occlusion.radius is 1, and cells have 3\.7"):
        renderer.render(occluded(blobs(), function(), al.visibility.AmbientOcclusion(radius=1, cells=12)), SIZE)


def test_tiny_volumes_look_two_cells_far(renderer):
    drawn = occluded(al.Volume(np.full((2, 3, 5), 100.0)), function(), al.visibility.AmbientOcclusion())
    assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() <= 1 / 255


def test_what_a_device_would_cut_short_is_refused(renderer):
    """Software devices end loops after 65,536 turns."""
    if renderer.render(scene(), (4, 4)).stats["adapter"]["kind"] != "software":
        pytest.skip("for software devices")
    column = al.Volume(np.full((200, 8, 8), 70.0))
    looking = al.visibility.AmbientOcclusion(radius=190, cells=200, directions=1024)
    with pytest.raises(LimitError, match="looks from a cell"):
        renderer.render(occluded(column, function(), looking), (8, 8))
    with pytest.raises(LimitError, match="take more cells"):
        renderer.render(
            occluded(al.Volume(np.zeros((208, 208, 208), np.uint8)), function(), al.visibility.AmbientOcclusion(cells=8)),
            (8, 8),
        )


def test_stage_of_a_look():
    with pytest.raises(ValueRangeError, match=r"directions is 3, must lie in \[6, 1024\]"):
        al.visibility.AmbientOcclusion(directions=3)
    assert scene(visibility="ambient_occlusion").layers[0].look.visibility == al.visibility.AmbientOcclusion()
