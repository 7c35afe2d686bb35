"""Longer slabs where little of them gets through to the eye."""

import numpy as np
import pytest

import airlight as al
from airlight import reference
from airlight.reference.march import pace_at

SIZE = (32, 24)
DENSE = al.TransferFunction([(40, (0.2, 0.3, 0.6), 0), (70, (0.9, 0.6, 0.3), 0.6), (200, (1, 1, 1), 2.0)])
ADAPTIVE = al.driver.March(adaptive=True)


def ball(voxels=20):
    axis = np.linspace(-1, 1, voxels)
    radius = np.sqrt(axis[:, None, None] ** 2 + axis[None, :, None] ** 2 + axis[None, None, :] ** 2)
    noise = np.random.default_rng(4).normal(0, 8, (voxels,) * 3)
    return al.Volume(np.where(radius < 0.9, 160 * (1 - radius) + 40 + noise, 0).astype(np.float32))


def scene(transfer=DENSE, volume=None, classified="preintegrated_exact", **stages):
    look = al.Look(field="linear_exact", shade="none", transfer=classified, **stages)
    return al.Scene(volume or ball(), transfer=transfer, look=look, camera="iso", background=None)


@pytest.mark.parametrize("transfer", ["preintegrated_exact", "postclassified"])
def test_slabs_are_those_of_the_reference(any_renderer, transfer):
    drawn = scene(classified=transfer)
    image = any_renderer.render(drawn, SIZE, driver=ADAPTIVE)
    truth = reference.render(drawn, SIZE, adaptive=True)
    # A ray whose opacity lies at a bound may take another slab: a few pixels.
    off = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert np.quantile(off, 0.99) < 5e-4
    assert off.max() < 0.02
    assert image.stats["adaptive"]
    fixed = any_renderer.render(drawn, SIZE)
    assert image.stats["samples"] < 0.9 * fixed.stats["samples"]
    assert 1e-4 < np.abs(image.rgba - fixed.rgba).max() < 0.03


def test_skipping_leaves_the_image_as_it_is(renderer):
    for transfer in ("preintegrated_exact", "postclassified"):
        drawn = scene(classified=transfer)
        images = [renderer.render(drawn, SIZE, driver=ADAPTIVE, skip=skip).rgba for skip in ("auto", "none")]
        assert np.abs(images[0] - images[1]).max() < 1 / 255


def test_homogeneous_media_are_exact(renderer):
    volume = al.Volume(np.full((24, 24, 24), 3.0, dtype=np.float32))
    constant = al.TransferFunction([(2.0, (1, 0.5, 0.2), 0.15), (4.0, (1, 0.5, 0.2), 0.15)])
    drawn = scene(constant, volume)
    image, fixed = (renderer.render(drawn, SIZE, driver=driver, skip="none") for driver in (ADAPTIVE, al.driver.March()))
    assert np.abs(image.rgba - fixed.rgba).max() < 2e-6
    assert image.stats["samples"] < 0.9 * fixed.stats["samples"]


def test_it_is_for_what_light_is_lost_in(renderer):
    drawn = scene(integrate="mip")
    image, fixed = (renderer.render(drawn, SIZE, driver=driver) for driver in (ADAPTIVE, al.driver.March()))
    assert not image.stats["adaptive"]
    assert np.array_equal(image.rgba, fixed.rgba)


def test_lengths_are_powers_of_two():
    assert list(pace_at(np.array([1.0, 0.26, 0.25, 0.07, 0.0625, 0.02, 0.01, 0.0]))) == [1, 1, 2, 2, 4, 4, 8, 8]
