"""Light that has passed all layers: closed forms of the reference, parity with it, and slices beside shadow volumes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import airlight as al
from airlight import reference
from airlight.reference import occlusion as open_sky
from airlight.reference import shadows as truth
from airlight.rendering import occluders, shadows

SIZE = (40, 32)
LEVEL = 1 / 255
EVEN = al.TransferFunction([(0, "white", 0.05), (100, "white", 0.05)])
ABOVE = al.Light.directional(to_light=(0, 0, 1))
OPEN = al.visibility.AmbientOcclusion(radius=8.0, cells=12, directions=24)
SCATTERING = al.shade.Phase(ambient=0.5)
WAYS = ["sweep", "rays"]


def slab(z: float, n: int = 12, spacing: float = 1.0, stage=None, density: float = 1.0) -> al.Layer:
    """A homogeneous block whose lowest voxels are at a height."""
    matrix = np.diag([spacing, spacing, spacing, 1.0])
    matrix[:3, 3] = (0, 0, z)
    volume = al.Volume(np.full((n, n, n), 50.0), world_from_index=matrix)
    return al.Layer(
        volume, EVEN, al.Look(visibility=stage or al.visibility.ShadowVolume(cells=12), shade=SCATTERING), density=density
    )


def scene(*layers: al.Layer, lamp: al.Light = ABOVE) -> al.Scene:
    camera = al.Camera.perspective(eye=(45, -40, 30), target=(6, 6, 10), up=(0, 0, 1), fov_deg=35)
    return al.Scene(layers=layers, camera=camera, lights=[lamp], background=None)


def reached(drawn: al.Scene, number: int, *p_world) -> np.ndarray:
    """What comes through of the light to points of a layer."""
    setup = reference.prepare_layers(drawn)[number]
    setup.stages["visibility"] = replace(setup.stages["visibility"], bias=0.0)
    return truth.shadow_volume(setup, 0, np.array(p_world, dtype=np.float64))[:, 0]


# -- closed forms and laws, of the reference


@pytest.mark.parametrize("by", WAYS)
def test_the_upper_slab_dims_the_lower(by):
    """By exp(-tau) of its height, whatever its grid; itself it gets all of the light, and so does what lies beside."""
    stage = al.visibility.ShadowVolume(cells=12, by=by)
    lower, upper = slab(0, stage=stage), slab(40, n=25, spacing=0.5, stage=stage)
    places = [(4.0, 5.0, z) for z in (0.0, 5.0, 10.0)]
    own = np.exp(-0.05 * (11 - np.array([0.0, 5.0, 10.0])))
    assert reached(scene(lower), 0, *places) == pytest.approx(own, rel=1e-3)
    for layers, number in (((lower, upper), 0), ((upper, lower), 1)):
        found = reached(scene(*layers), number, *places)
        assert found == pytest.approx(math.exp(-0.05 * 12) * own, rel=1e-3)
    assert reached(scene(lower, upper), 1, (4, 5, 40)) == pytest.approx(reached(scene(upper), 0, (4, 5, 40)), rel=1e-9)
    below = al.Light.directional(to_light=(0, 0, -1))
    assert reached(scene(lower, upper, lamp=below), 0, *places) == pytest.approx(np.exp(-0.05 * np.array([0, 5, 10])), rel=1e-3)
    between = al.Light.point(position=(4, 5, 25))
    assert reached(scene(lower, upper, lamp=between), 0, *places) == pytest.approx(
        reached(scene(lower, lamp=between), 0, *places), rel=1e-9
    )


def test_the_sky_is_that_of_all_layers():
    """A wall that stands in both halves hides as much as one: openness is a mean of products, and no product of means."""
    values = np.zeros((16, 16, 16), dtype=np.float32)
    values[:8] = 1
    wall = al.TransferFunction([(0, "white", 0), (1, "white", 0.8)])
    stage = al.visibility.AmbientOcclusion(radius=6, cells=16, directions=60)
    whole = al.Layer(al.Volume(values), wall, al.Look(visibility=stage))
    half = replace(whole, density=0.5)
    one, two, alone = (
        open_sky.openness(reference.prepare_layers(scene(*layers))[0]) for layers in ((whole,), (half, half), (half,))
    )
    assert np.abs(one - two).max() < 1e-9
    assert (two <= alone + 1e-12).all()
    assert 0.45 < two[9, 8, 8] < 0.8
    assert two[9, 8, 8] > alone[9, 8, 8] ** 2 + 0.02


def test_layers_of_half_the_extinction_cast_the_shadow_of_one():
    """Exactly along rays where a cell is a voxel: coarser ones hold means of what their voxels let through, and sweeps leak."""
    rng = np.random.default_rng(3)
    volume = al.Volume(rng.uniform(0, 1, (10, 10, 10)).astype(np.float32))
    tf = al.TransferFunction([(0.2, "white", 0), (1, "white", 0.5)])
    for by in WAYS:
        look = al.Look(visibility=al.visibility.ShadowVolume(cells=10, by=by))
        whole = al.Layer(volume, tf, look)
        half = replace(whole, density=0.5)
        found = []
        for layers in ((whole,), (half, half)):
            setup = reference.prepare_layers(scene(*layers, lamp=al.Light.directional(to_light=(1, 0.3, 2))))[0]
            found.append(truth.cells_reached(setup, setup.lights[0])[1:-1, 1:-1, 1:-1])
        assert (found[0] - found[1]).std() < (1e-9 if by == "rays" else 0.05)


# -- the device


def compare(renderer, drawn: al.Scene) -> np.ndarray:
    image, expected = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert expected.rgba[..., 3].max() > 0.2
    assert np.abs(image.rgba - expected.rgba).max() <= LEVEL
    return image.rgba


@pytest.mark.parametrize("stage", [OPEN, al.visibility.ShadowVolume(cells=12, by="rays"), al.visibility.ShadowVolume(cells=12)])
def test_parity_and_order(any_renderer, stage):
    """Of layers that lie apart; the upper one is not dimmed, and casts its shadow."""
    upper = replace(slab(14, n=20, spacing=0.5, density=8.0), look=al.Look(shade=SCATTERING))
    lower = slab(0, stage=stage)
    found = compare(any_renderer, scene(lower, upper))
    assert np.abs(any_renderer.render(scene(upper, lower), SIZE).rgba - found).max() < 1e-4
    bright = any_renderer.render(scene(lower, replace(upper, density=1e-6)), SIZE).rgba
    alone = any_renderer.render(scene(lower), SIZE).rgba
    compare(any_renderer, scene(lower, upper, replace(slab(12, n=8, spacing=0.2, density=8.0), look=al.Look(shade=SCATTERING))))
    assert np.abs(bright - alone)[..., :3].max() < 2 * LEVEL
    assert (alone - found)[..., :3].max() > 3 * LEVEL


def test_made_anew_for_another_function_of_the_other_layer(monkeypatch):
    made, gathered = [], []
    make, gather = shadows._made, occluders._gathered
    monkeypatch.setattr(shadows, "_made", lambda *given: made.append(1) or make(*given))
    monkeypatch.setattr(occluders, "_gathered", lambda *given: gathered.append(1) or gather(*given))
    with al.Renderer() as renderer:
        lower, upper = slab(0), slab(14)
        for drawn in (
            scene(lower, upper),
            scene(upper, lower),
            scene(replace(lower, look=replace(lower.look, shade=al.shade.Phase(ambient=0.7))), upper),
        ):
            renderer.render(drawn, SIZE)
        assert (len(made), len(gathered)) == (2, 2)
        renderer.render(scene(lower, replace(upper, density=2.0)), SIZE)
        assert (len(made), len(gathered)) == (4, 3)


def test_slices_and_shadow_volumes_cast_the_same_shadows(renderer):
    ball = np.indices((24, 24, 24)).astype(np.float32) - 11.5
    volume = al.Volume(np.clip(8 - np.sqrt((ball**2).sum(axis=0)), 0, 2))
    tf = al.TransferFunction([(0, "white", 0), (2, "white", 0.4)])
    matrix = np.eye(4)
    matrix[:3, 3] = (4, -3, 24)
    other = al.Volume(volume.array, world_from_index=matrix)
    shade = al.shade.Phase(ambient=0.2)

    def drawn(visibility: object) -> al.Scene:
        look = al.Look(visibility=visibility, shade=shade)
        lamp = al.Light.directional(to_light=(0.2, -0.4, 1))
        camera = al.Camera.orthographic(eye=(12, -60, 40), target=(12, 10, 23), height=52)
        layers = [al.Layer(volume, tf, look), al.Layer(other, tf.with_reversed_colours(), look)]
        return al.Scene(layers=layers, camera=camera, lights=[lamp], background=None)

    swept = renderer.render(drawn("none"), (48, 48), driver="half_angle").rgba
    kept = renderer.render(drawn(al.visibility.ShadowVolume(cells=24, bias=0.0)), (48, 48)).rgba
    plain = renderer.render(drawn("none"), (48, 48)).rgba
    apart = np.abs(kept - swept)[..., 0]
    assert np.sqrt((apart**2).mean()) < 0.25 * np.sqrt(((plain - swept)[..., 0] ** 2).mean())
