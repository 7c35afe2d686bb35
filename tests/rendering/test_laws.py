"""Laws that hold for every image, whatever the scene."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, cameras, function, lights, rotation, scene

import airlight as al

LEVEL = 1 / 255


def draw(renderer, volume, camera, step=1.0, tf=None, lit=None, **look):
    made = al.Scene(volume, transfer=tf or function(), camera=camera, look=al.Look(**look), lights=lit, background=None)
    return renderer.render(made, SIZE, step=step)


def test_the_same_data_at_another_spacing_is_the_same_image(renderer):
    """A field that is linear between samples, sampled twice as densely over the same world."""
    coarse = np.add.outer(np.add.outer(np.linspace(0, 30, 16), np.linspace(30, 60, 16)), np.linspace(0, 20, 16))
    fine = np.add.outer(np.add.outer(np.linspace(0, 30, 31), np.linspace(30, 60, 31)), np.linspace(0, 20, 31))
    a = al.Volume(coarse.astype(np.float32), spacing=(2, 2, 2))
    b = al.Volume(fine.astype(np.float32), spacing=(1, 1, 1))
    camera = cameras(a)["perspective"]
    for look in ({"shade": "none"}, {"shade": al.shade.BlinnPhong(gradient_threshold=0.1)}):
        one, two = draw(renderer, a, camera, step=1.0, **look), draw(renderer, b, camera, step=2.0, **look)
        assert np.abs(one.rgba - two.rgba).max() <= LEVEL


@settings(max_examples=8)
@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle_rad=st.floats(0, 6.28),
    shift=st.tuples(*[st.floats(-200, 200)] * 3),
    kind=st.sampled_from(["perspective", "orthographic", "inside"]),
)
def test_moving_volume_camera_and_lights_together_changes_nothing(renderer, axis, angle_rad, shift, kind):
    volume, camera = blobs(), cameras(blobs())[kind]
    turn = rotation(axis, angle_rad)
    move = np.eye(4)
    move[:3, :3], move[:3, 3] = turn, shift
    moved = al.Volume(volume.array, world_from_index=move @ volume.world_from_index)
    there = {name: tuple(turn @ getattr(camera, name) + shift) for name in ("eye", "target")}
    common = {"fov_deg": camera.fov_deg} if hasattr(camera, "fov_deg") else {"height": camera.height}
    moved_camera = type(camera)(**there, up=tuple(turn @ camera.up), **common)
    moved_lights = [
        al.Light(
            source.kind,
            tuple(turn @ source.vector + (np.array(shift) if source.kind == "point" else 0)),
            source.colour,
            source.intensity,
            source.radius,
        )
        for source in lights()
    ]
    one = draw(renderer, volume, camera, lit=lights())
    two = draw(renderer, moved, moved_camera, lit=moved_lights)
    assert np.abs(one.rgba - two.rgba).max() <= LEVEL


def test_empty_is_transparent(renderer):
    nothing = al.TransferFunction([(0, (1, 1, 1), 0), (200, (1, 1, 1), 0)])
    image = draw(renderer, blobs(), cameras(blobs())["perspective"], tf=nothing)
    assert not image.rgba.any()
    assert np.isinf(image.depth).all()


def test_a_look_away_is_empty(renderer):
    camera = al.Camera.perspective(eye=(0, -500, 0), target=(0, -600, 0))
    for integrate in ("emission_absorption", "mip", "minip", "mean", "first_hit"):
        image = draw(renderer, blobs(), camera, integrate=integrate)
        assert not image.rgba.any()
        assert np.isinf(image.depth).all()


def test_halving_the_step_converges(renderer):
    best = draw(renderer, blobs(), cameras(blobs())["perspective"], step=1 / 16, shade="none").rgba
    errors = [
        np.sqrt(np.mean((draw(renderer, blobs(), cameras(blobs())["perspective"], step=s, shade="none").rgba - best) ** 2))
        for s in (2.0, 1.0, 0.5, 0.25)
    ]
    assert all(b < 0.6 * a for a, b in itertools.pairwise(errors)), errors


def test_two_halves_composite_to_the_whole(renderer):
    """Cut where samples lie: the near half over the far half is the whole.

    Curvature needs a neighbour on either side, which a sample at the cut has lost: what is missing goes with the step's square.
    """
    rng = np.random.default_rng(5)
    data = rng.uniform(40, 100, (8, 21, 8)).astype(np.float32)
    camera = al.Camera.orthographic(eye=(3.5, -30, 3.5), target=(3.5, 10, 3.5), height=6)

    def part(y):
        return al.Volume(np.ascontiguousarray(data[:, y]), origin=(0, y.start, 0))

    def missing(step, curved):
        look = al.Look(shade="none", integrate=al.integrate.EmissionAbsorption(opaque_at=1.0))
        whole, near, far = (
            renderer.render(
                al.Scene(part(s), transfer=function(), camera=camera, look=look, background=None),
                SIZE,
                step=step,
                driver=al.driver.March(curved=curved),
            ).rgba
            for s in (slice(0, 21), slice(0, 11), slice(10, 21))
        )
        return np.abs(near + (1 - near[..., 3:]) * far - whole).max()

    assert missing(1, curved=False) < 1e-4
    assert 1e-4 < missing(1 / 4, curved=True) < missing(1, curved=True) / 8


def test_density_multiplies_extinction(renderer):
    volume, camera = blobs(), cameras(blobs())["perspective"]
    thick = al.Scene(layers=[al.Layer(volume, function(), density=2.5)], camera=camera, background=None)
    by_hand = al.TransferFunction([(v, rgb, 2.5 * extinction) for v, rgb, extinction in function().points])
    scaled = al.Scene(volume, transfer=by_hand, camera=camera, background=None)
    # Mesa compiles a program again when it knows its uniforms, and rounds the last bits otherwise then.
    assert np.abs(renderer.render(thick, SIZE).rgba - renderer.render(scaled, SIZE).rgba).max() <= 1e-12


@pytest.mark.parametrize("size", [(1, 1), (3, 200), (257, 5)])
def test_odd_sizes(renderer, size):
    image = renderer.render(scene(), size)
    assert image.rgba.shape == (size[1], size[0], 4)
    assert np.isfinite(image.rgba).all()


def test_a_picture_is_not_mirrored(renderer):
    """Front view of LPS data: the patient's left, +x, is on the image's right; up is superior, +z."""
    data = np.zeros((20, 20, 20), dtype=np.float32)
    data[15:18, 8:12, 15:18] = 100
    volume = al.Volume(data, anatomical=True)
    tf = al.TransferFunction([(50, "white", 0), (100, "white", 2)])
    image = renderer.render(al.Scene(volume, transfer=tf, camera="front"), (40, 40))
    y, x = np.nonzero(image.rgba[..., 3] > 0.5)
    assert x.mean() > 22
    assert y.mean() < 18
    back = renderer.render(al.Scene(volume, transfer=tf, camera="back"), (40, 40))
    assert np.nonzero(back.rgba[..., 3] > 0.5)[1].mean() < 18
    left = renderer.render(al.Scene(al.Volume(np.moveaxis(data, 1, 2).copy()), transfer=tf, camera="left"), (40, 40))
    assert np.nonzero(left.rgba[..., 3] > 0.5)[1].mean() > 22


def test_the_rest_of_a_ray_that_ends_early_is_taken_to_look_alike(renderer):
    """In one medium it does: pixels that are opaque enough have its colour, the others stay as they are."""
    volume = al.Volume(np.full((12, 12, 12), 50.0, dtype=np.float32))
    medium = al.TransferFunction([(0, (0.8, 0.4, 0.2), 0.15), (100, (0.8, 0.4, 0.2), 0.15)])
    camera = cameras(volume)["perspective"]
    whole, quick = (
        draw(renderer, volume, camera, tf=medium, shade="none", integrate=integrate)
        for integrate in (
            al.integrate.EmissionAbsorption(opaque_at=1.0),
            al.integrate.EmissionAbsorption(opaque_at=0.7, fills_rest=True),
        )
    )
    ends = whole.rgba[..., 3] >= 0.7
    assert 0 < ends.mean() < 1
    assert np.abs(quick.rgba[ends] - [0.8, 0.4, 0.2, 1.0]).max() < 1e-4
    assert np.array_equal(quick.rgba[~ends], whole.rgba[~ends])
    look = al.Look(shade="none", integrate=al.integrate.EmissionAbsorption(opaque_at=0.7, fills_rest=True))
    blob = al.Scene(blobs(), transfer=function(), camera=cameras(blobs())["perspective"], look=look, background=None)
    assert np.abs(renderer.render(blob, SIZE).rgba - al.reference.render(blob, SIZE).rgba).max() <= LEVEL
