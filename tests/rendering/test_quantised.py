"""Quantised normals: sets of directions, parity with the reference, and what the stage refuses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, function, lights, rotation, scene

import airlight as al
from airlight import reference
from airlight.stages.directions import angles_to, annealed, dodecahedron, spiral, volume_normals
from airlight.stages.shade import Shade

LEVEL = 1 / 255
FAR = [light for light in lights() if light.kind != "point"]
Quantised = al.lighting.Quantised


def quantised(volume=None, camera="orthographic", lamps=FAR, lighting=Quantised(), **look) -> al.Scene:  # noqa: B008
    base = scene(volume, camera=camera, lighting=lighting, **look)
    return al.Scene(layers=base.layers, camera=base.camera, lights=lamps, background=None)


def holed() -> al.Volume:
    array = blobs().array.copy()
    array[10:25, 12:20, 8:22] = np.nan
    return al.Volume(array, world_from_index=blobs().world_from_index)


# -- sets


def test_the_dodecahedron_gives_240_directions_of_nearly_equal_distance():
    directions = dodecahedron()
    assert directions.shape == (240, 3)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    cosines = directions @ directions.T - 2 * np.eye(240)
    to_next_deg = np.degrees(np.arccos(cosines.max(axis=1)))
    assert to_next_deg.min() > 10.6
    assert to_next_deg.max() < 10.9
    # The solid looks the same from behind, and after a fifth of a turn around the middle of a face.
    golden = (1 + np.sqrt(5)) / 2
    for turned in (-directions, directions @ rotation((1, 0, golden), 2 * np.pi / 5).T):
        assert angles_to(directions, turned).max() < 1e-5


@settings(max_examples=10, deadline=None)
@given(count=st.integers(4, 400))
def test_spirals_are_even(count):
    directions = spiral(count)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert np.linalg.norm(directions.mean(axis=0)) < 2 / count
    everywhere = np.random.default_rng(1).normal(size=(2000, 3))
    everywhere /= np.linalg.norm(everywhere, axis=1)[:, None]
    # A cap of this radius has twice the area that is a direction's share.
    assert np.mean(1 - np.cos(np.radians(angles_to(directions, everywhere)))) < 2 * 2 / count


def clustered(seed: int, n: int = 3000) -> np.ndarray:
    """Normals of a solid with a few faces and rounded edges."""
    rng = np.random.default_rng(seed)
    faces = np.array([(1, 0, 0), (0, 1, 0.2), (-1, 0.5, 1), (0, 0, -1.0)])[rng.integers(0, 4, n)]
    normals = faces + 0.15 * rng.normal(size=(n, 3))
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def test_annealed_directions_go_where_normals_are():
    normals, others = clustered(1), clustered(2)
    fitted = annealed(normals, 64, seed=3)
    assert np.allclose(np.linalg.norm(fitted, axis=1), 1)
    assert np.array_equal(fitted, annealed(normals, 64, seed=3))
    assert not np.array_equal(fitted, annealed(normals, 64, seed=4))
    # Others of their kind are met much closer than by an even spread, and better than by as many of the normals themselves.
    assert angles_to(fitted, others).mean() < 0.5 * angles_to(spiral(64), others).mean()
    assert angles_to(fitted, others).mean() < 0.95 * angles_to(normals[:64], others).mean()


def test_normals_of_a_volume_are_in_the_world_and_weighted_by_steepness():
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 2, 3), 0.7) @ np.array([[0.5, 0.2, 0.0], [0, 1.5, -0.3], [0, 0, 2.0]])
    x, y, z = np.meshgrid(*(np.arange(n) for n in (9, 10, 11)), indexing="ij")
    g = np.array([0.3, -0.8, 0.5])
    values = (np.stack([x, y, z], axis=-1) @ matrix[:3, :3].T @ g).transpose(2, 1, 0)
    volume = al.Volume(values, world_from_index=matrix)
    inside = volume_normals(volume, (0,), 0)
    assert np.degrees(np.arccos(np.median(inside @ -g) / np.linalg.norm(g))) < 1e-4
    # A step that is a hundred times as high as a ramp takes most of them.
    two = np.zeros((20, 20, 20))
    two += np.arange(20)
    two[10:] += 100
    assert (np.abs(volume_normals(al.Volume(two), (0,), 0)[:, 2]) > 0.9).mean() > 0.8
    assert len(volume_normals(al.Volume(np.zeros((4, 4, 4))), (0,), 0)) > 0


# -- pictures


@pytest.mark.parametrize("camera", ["orthographic", "cut"])
@pytest.mark.parametrize(
    "lighting", [Quantised(), Quantised("spiral", 300), Quantised("annealed", 64, seed=3), Quantised("spiral", 4)], ids=str
)
def test_stage(either_renderer, lighting, camera):
    drawn = quantised(camera=camera, lighting=lighting)
    image, truth = either_renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    # Half floats, which the core device takes for these data, turn some of the voxels that are half way between two directions.
    assert np.quantile(error, 0.9) <= LEVEL / 4
    assert error.max() <= (25 * LEVEL if image.stats["core"] else LEVEL / 4)
    exact = either_renderer.render(quantised(camera=camera, lighting="interpolated"), SIZE)
    assert np.abs(image.rgba - exact.rgba).max() > LEVEL  # it is an approximation, and says which
    assert np.array_equal(image.rgba[..., 3], exact.rgba[..., 3])
    told = image.stats["layers"][0]
    assert 0 < told["errors"]["lighting: angle rms [degree]"] < told["errors"]["lighting: angle max [degree]"]
    x, y, z = blobs().size
    bits = 16 if lighting.count == 300 else 8
    assert told["voxels"]["lighting.numbers"] == {"format": f"rgba{bits}uint", "bytes": x * y * z * bits // 8}


@pytest.mark.parametrize(
    "look",
    [
        {"volume": holed},
        {"field": "nearest"},
        {"gradient": "sobel"},
        {"gradient": al.gradient.Precomputed("sobel", "snorm8", True)},
        {"transfer": "postclassified"},
        {"integrate": al.integrate.FirstHit(iso=70.0)},
        {"shade": al.shade.BlinnPhong(two_sided=False, gradient_threshold=40.0, diffuse=1)},
        {"modulation": "gradient_magnitude", "gradient": "precomputed"},
    ],
    ids=lambda look: next(iter(look)),
)
def test_beside_other_stages(any_renderer, look):
    look = dict(look)
    drawn = quantised(look.pop("volume", blobs)(), **look)
    error = np.abs(any_renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max(axis=-1)
    # Voxels half way between two directions, or at the threshold, may fall to either; samples between nearest voxels, too.
    assert np.quantile(error, 0.99) <= LEVEL
    assert error.max() <= 20 * LEVEL


def test_axes_that_are_no_multiple_of_four_and_thin_ones(renderer):
    rng = np.random.default_rng(3)
    for shape in ((9, 10, 11), (5, 6, 1), (1, 7, 9)):
        volume = al.Volume(rng.uniform(40, 110, shape).astype(np.float32), spacing=(1, 1.5, 2))
        drawn = quantised(volume)
        assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() <= LEVEL


def test_channels(renderer):
    array = np.stack([blobs().array, blobs().array[::-1, :, ::-1]])
    volume = al.Volume(array, world_from_index=blobs().world_from_index)
    base = quantised(volume)
    (layer,) = base.layers
    mixture = al.Channels([al.Channel(0, function()), al.Channel(1, function().scaled(0.4))])
    drawn = al.Scene(layers=[replace(layer, transfer=mixture)], camera=base.camera, lights=FAR, background=None)
    error = np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba)
    assert np.quantile(error, 0.99) <= LEVEL


def test_other_lights_ask_for_no_other_numbers(renderer):
    """Light is linear in the lights, and what was computed for the voxels stays."""
    one, other = ([light] for light in FAR)
    made = []

    def told(what, done, total):
        made.append(what)

    volume = al.Volume(blobs().array.copy(), world_from_index=blobs().world_from_index)
    shade = al.shade.BlinnPhong(ambient=0)
    both = renderer.render(quantised(volume, shade=shade), SIZE, progress=told)
    assert "numbers8" in made
    made.clear()
    parts = [renderer.render(quantised(volume, lamps=lamps, shade=shade), SIZE, progress=told).rgba for lamps in (one, other)]
    assert "numbers8" not in made
    assert np.allclose(parts[0][..., :3] + parts[1][..., :3], both.rgba[..., :3], atol=1e-5)
    renderer.render(quantised(volume, shade=replace(shade, gradient_threshold=9.0)), SIZE, progress=told)
    assert "numbers8" in made


def test_flat_places_keep_ambient_light_alone(any_renderer):
    shade = al.shade.BlinnPhong(ambient=0.25, diffuse=1, specular=1)
    even = al.Volume(np.full((8, 9, 10), 70.0, dtype=np.float32))
    rgba = any_renderer.render(quantised(even, shade=shade), SIZE).rgba
    unlit = any_renderer.render(quantised(even, shade="none"), SIZE).rgba
    assert unlit[..., :3].any()
    assert np.allclose(rgba[..., :3], 0.25 * unlit[..., :3], atol=1e-5)


def test_more_directions_are_better(renderer):
    truth = renderer.render(quantised(lighting="interpolated", gradient="precomputed"), SIZE).rgba
    error = [
        np.abs(renderer.render(quantised(lighting=Quantised("spiral", count)), SIZE).rgba - truth).mean()
        for count in (16, 64, 256, 2047)
    ]
    assert error == sorted(error, reverse=True)
    assert error[-1] < 0.3 * error[1]


# -- refusals


@dataclass(frozen=True)
class Striped(Shade):
    """Light that differs from place to place."""

    name: ClassVar[str] = "striped"
    wgsl: ClassVar[str] = """
        import package::sample::{Sample, Lit};
        fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit { return Lit(fract(here.p_world), vec3f(0.0)); }
    """


@pytest.mark.parametrize(
    ("drawn", "named", "remedy"),
    [
        (lambda: quantised(camera="perspective"), "a perspective view differs from pixel to pixel", "Camera.orthographic"),
        (lambda: quantised(lamps=lights()), "a point light comes from elsewhere", "directional or head lights"),
        (lambda: quantised(visibility="ambient_occlusion"), "'ambient_occlusion' differs from place", 'visibility="none"'),
        (lambda: quantised(shade=Striped()), "'striped' looks at more than normals", 'lighting="interpolated"'),
        (lambda: quantised(lighting=Quantised(count=256)), "count is 256, and the dodecahedron gives 240", '"annealed"'),
    ],
)
def test_what_differs_from_place_to_place_is_refused(renderer, drawn, named, remedy):
    with pytest.raises(al.StageError) as caught:
        renderer.render(drawn(), SIZE)
    assert named in str(caught.value)
    assert remedy in str(caught.value)


def test_the_reference_refuses_too():
    for drawn in (quantised(camera="perspective"), quantised(lamps=lights())):
        with pytest.raises(al.StageError, match="lights each direction once"):
            reference.render(drawn, (6, 6))


def test_a_seed_where_nothing_is_random_is_refused():
    with pytest.raises(
        al.ValueRangeError, match=r"seed is 3, and nothing is random about 'spiral': use directions=\"annealed\""
    ):
        Quantised("spiral", 64, seed=3)


def test_occlusion_where_nothing_is_lit_is_refused(renderer):
    volume = al.Volume(np.arange(64.0).reshape(4, 4, 4))
    for unlit in ({"shade": "none"}, {"integrate": "mip"}):
        with pytest.raises(al.StageError, match=r"ambient_occlusion.*dims light, and nothing is lit: use shade="):
            renderer.render(al.Scene(volume, look=al.Look(visibility="ambient_occlusion", **unlit)), (8, 8))
