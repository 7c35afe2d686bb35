"""Sums without attenuation, and maxima that tell what is near: closed forms, parity where stand-ins draw, laws, errors."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, function, scene
from test_closed_forms import along_y, pixel, straight

import airlight as al
from airlight import reference
from airlight.errors import AirlightError
from airlight.transfer.joint import JointFunction
from airlight.transfer.joint_axes import Axis
from airlight.transfer.joint_shapes import Box

LEVEL = 1 / 255
WHITE = al.TransferFunction([(0, "white", 0), (1, "white", 1)])
EXACT = {"field": "linear_exact"}


def compare(renderer, drawn: al.Scene, step: float = 1.0, scale: float = 1.0) -> np.ndarray:
    image, truth = renderer.render(drawn, SIZE, step=step), reference.render(drawn, SIZE, step=step)
    assert np.abs(image.rgba - truth.rgba).max() <= LEVEL / 4 * scale
    return image.rgba


def of_layer(drawn: al.Scene, **changes) -> al.Scene:
    (layer,) = drawn.layers
    return al.Scene(layers=[replace(layer, **changes)], camera=drawn.camera, lights=drawn.lights, background=None)


# -- sums


@pytest.mark.parametrize("transfer", ["preintegrated", "preintegrated_fast", "postclassified"])
@pytest.mark.parametrize("step", [0.1, 0.3, 1.0, 2.0])
def test_xray_of_water_and_bone(renderer, transfer, step):
    """20 mm of water, a millimetre on which it rises to 1000 HU, and 6 mm of that: I = exp(-mu_w (20 + 1.5 + 2 * 6))."""
    volume = along_y(np.concatenate([np.zeros(21), np.full(7, 1000.0)]))
    mu = 0.0206
    depth = mu * (20 + 1.5 + 2 * 6)
    look = {"transfer": transfer, **EXACT}
    shown = pixel(renderer, volume, al.TransferFunction.from_hounsfield(mu), step, integrate=al.integrate.XRay(high=1), **look)
    # Where the field has a corner between two samples, these miss a part of it.
    assert shown == pytest.approx([depth, depth, depth, 1], abs=mu * step)
    through = al.integrate.XRay(show="transmission")
    shown = pixel(renderer, volume, al.TransferFunction.from_hounsfield(mu), step, integrate=through, **look)
    assert shown[0] == pytest.approx(math.exp(-depth), abs=mu * step)


def test_windows_of_xrays(renderer):
    volume = along_y(np.full(11, 1.0))
    tf = WHITE.scaled(0.2)  # optical depth 2
    for stage, expected in (
        (al.integrate.XRay(low=1, high=5), (2 - 1) / (5 - 1)),
        (al.integrate.XRay(low=3, high=5), 0.0),
        (al.integrate.XRay(show="transmission", low=1, high=3), (math.exp(-2) - math.exp(-3)) / (math.exp(-1) - math.exp(-3))),
        (al.integrate.XRay(), 2 / 2.2),  # the deepest way is straight through, of eleven voxels
    ):
        assert pixel(renderer, volume, tf, 1.0, integrate=stage)[0] == pytest.approx(expected, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("depth", [1e-3, 1.0, 300.0])
def test_a_weighted_sum_attenuates_nothing(renderer, depth):
    """Half a way of red and half of green, at any depth: both are seen as if they were alone."""
    volume = along_y(np.linspace(0, 1, 11))
    tf = al.TransferFunction([(0, (1, 0, 0), depth / 10), (0.5, (1, 0, 0), depth / 10), (0.5, (0, 1, 0), depth / 10)])
    shown = pixel(renderer, volume, tf, 1.0, integrate=al.integrate.WeightedSum(full=depth), **EXACT)
    assert shown == pytest.approx([0.5, 0.5, 0, 1], abs=1e-3)


def test_a_sum_is_the_same_from_behind(renderer):
    """Without attenuation the order along a ray does not matter."""
    middle = blobs().corners_world().mean(axis=0)
    for stage in (al.integrate.WeightedSum(full=3), al.integrate.XRay(high=3)):
        sides = []
        for way in (-1, 1):
            camera = al.Camera.orthographic(eye=tuple(middle + np.array([0, 60.0 * way, 0])), target=tuple(middle), height=30)
            drawn = al.Scene(blobs(), transfer=function(), camera=camera, look=al.Look(integrate=stage), background=None)
            sides.append(renderer.render(drawn, (41, 41), step=0.25).rgba)
        assert sides[0][..., 0].max() > 0.2
        assert np.abs(sides[0] - sides[1][:, ::-1]).max() < 2e-3


def test_sums_of_all_kinds_of_functions(any_renderer):
    """Mixtures of channels, functions of two variables, surfaces, associated colours, empty samples, regions of labels."""
    two = np.stack([blobs().array, 130 - blobs().array])
    mixture = al.Volume(two, world_from_index=blobs().world_from_index)
    joint = JointFunction(
        (Axis("value", 0.0, 130.0), Axis("gradient", 0.0, 30.0)),
        (Box((50, 1), (100, 20), edge=0.3, extinction=0.2, colour="gold"),),
    )
    glow = al.TransferFunction([(40, (0, 0, 0), 0), (70, (0.02, 0.01, 0), 0), (110, (0.1, 0, 0.05), 0.4)], associated=True)
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    labels = np.zeros(blobs().array.shape, dtype=np.uint8)
    labels[:, :18] = 1
    named = al.Labels(al.Volume(labels, world_from_index=blobs().world_from_index), {1: al.LabelStyle("red", opacity=0.4)})
    for stage in (al.integrate.WeightedSum(full=6.0), al.integrate.XRay(high=6.0)):
        base = scene(integrate=stage, transfer="preintegrated_fast")
        several = scene(mixture, integrate=stage)
        thin = al.TransferFunction([(40, "red", 0.0), (110, "blue", 0.3)])
        assert compare(
            any_renderer,
            of_layer(several, transfer=al.Channels([al.Channel(0, thin), al.Channel(1, thin.with_reversed_colours())])),
        ).any()
        assert compare(any_renderer, of_layer(base, transfer=function().with_surfaces([al.Surface(70, "gold", 0.5)]))).any()
        assert compare(any_renderer, of_layer(base, labels=named)).any()
        assert compare(any_renderer, scene(al.Volume(holed, world_from_index=blobs().world_from_index), integrate=stage)).any()
        if isinstance(stage, al.integrate.WeightedSum):
            assert compare(any_renderer, of_layer(base, transfer=glow)).any()
        assert compare(any_renderer, of_layer(base, transfer=joint), scale=4).any()


def test_density_and_modulation_reach_sums(renderer):
    deep = renderer.render(of_layer(scene(integrate=al.integrate.XRay(high=10)), density=2.0), SIZE).rgba
    plain = renderer.render(scene(integrate=al.integrate.XRay(high=10)), SIZE).rgba
    assert np.abs(deep[..., 0] - 2 * plain[..., 0]).max() < 1e-4
    compare(renderer, scene(integrate=al.integrate.XRay(high=10), modulation=al.modulation.GradientMagnitude(full_at=20.0)))


# -- maxima


def test_attenuated_maximum_inside_a_slab(renderer):
    """On a ramp w = s / L it is w exp(-a w^2 L / 2): greatest at w = 1 / sqrt(a L), there exp(-1/2) / sqrt(a L)."""
    volume = along_y(np.linspace(0, 1, 11))
    image = None
    for step in (0.5, 3.0, 20.0):
        stage = al.integrate.AttenuatedMip(attenuation=0.4)
        drawn = al.Scene(
            volume,
            transfer=WHITE,
            camera=straight(volume),
            look=al.Look(integrate=stage, field="linear_exact"),
            background=None,
        )
        image = renderer.render(drawn, (1, 1), step=step)
        assert image.depth[0, 0] == pytest.approx(100 + 10 * 0.5, abs=1e-2)
        assert image.rgba[0, 0] == pytest.approx([math.exp(-0.5)] * 3 + [1], abs=1e-3)  # white, dimmed


def test_depth_shaded_maximum_inside_a_slab(renderer):
    """Strength s / L times brightness 1 - s / L, on a ramp: greatest in the middle."""
    volume = along_y(np.linspace(0, 1, 11))
    stage = al.integrate.DepthShadedMip(darkest=0.0, near=100, far=110)
    for step in (0.5, 3.0, 20.0):
        look = al.Look(integrate=stage, field="linear_exact")
        drawn = al.Scene(volume, transfer=WHITE, camera=straight(volume), look=look, background=None)
        image = renderer.render(drawn, (1, 1), step=step)
        assert image.depth[0, 0] == pytest.approx(105, abs=1e-2)
        assert image.rgba[0, 0] == pytest.approx([0.5] * 3 + [1], abs=1e-3)


@pytest.mark.parametrize("name", ["attenuated_mip", "depth_shaded_mip", "local_mip"])
@pytest.mark.parametrize("camera", ["perspective", "inside", "cut"])
@pytest.mark.parametrize("step", [0.5, 2.0])
def test_maxima_are_those_of_the_reference(either_renderer, name, camera, step):
    drawn = scene(camera=camera, integrate=name)
    image, truth = either_renderer.render(drawn, SIZE, step=step), reference.render(drawn, SIZE, step=step)
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert np.quantile(error, 0.995) <= LEVEL  # of two samples that are equally strong either may be shown
    met = np.isfinite(truth.depth)
    assert (np.isfinite(image.depth) == met).all()
    assert np.quantile(np.abs(image.depth[met] - truth.depth[met]), 0.97) < 0.05


def test_maxima_without_attenuation_or_shade_are_the_maximum(renderer):
    plain = renderer.render(scene(integrate="mip"), SIZE)
    peak = float(blobs().array.max())
    for stage in (
        al.integrate.AttenuatedMip(attenuation=0.0),
        al.integrate.DepthShadedMip(darkest=1.0),
        al.integrate.LocalMip(threshold=peak + 1),
    ):
        image = renderer.render(scene(integrate=stage), SIZE)
        inside = plain.rgba[..., 3] > 0
        # Values beyond the ends of the function are equally strong: the first of them is shown.
        assert np.abs(image.rgba - plain.rgba).max() < LEVEL
        assert (image.depth[inside] <= plain.depth[inside] + 1e-3).all()


def two_peaks(near: float, far: float) -> al.Volume:
    line = np.zeros(31)
    line[8:13], line[18:23] = near * np.array([0.5, 0.9, 1, 0.9, 0.5]), far * np.array([0.5, 0.9, 1, 0.9, 0.5])
    return along_y(line)


def test_local_maximum_is_the_near_one(renderer):
    volume = two_peaks(0.7, 1.0)
    grey = al.TransferFunction([(0, "black", 0), (1, "white", 1)])

    def peak(stage):
        look = al.Look(integrate=stage, field="linear_exact")
        image = renderer.render(al.Scene(volume, transfer=grey, camera=straight(volume), look=look), (1, 1))
        return float(image.rgba[0, 0, 0]), float(image.depth[0, 0])

    assert peak("mip") == pytest.approx((1.0, 120), abs=1e-3)
    assert peak("local_mip") == pytest.approx((0.7, 110), abs=1e-3)
    assert peak(al.integrate.LocalMip(threshold=0.8)) == pytest.approx((1.0, 120), abs=1e-3)
    assert peak(al.integrate.LocalMip(threshold=2.0)) == pytest.approx((1.0, 120), abs=1e-3)
    assert peak(al.integrate.LocalMip(drop=0.65)) == pytest.approx((0.7, 110), abs=1e-3)
    assert peak(al.integrate.LocalMip(drop=0.75)) == pytest.approx((1.0, 120), abs=1e-3)


def test_moving_the_eye_back_keeps_a_depth_shaded_picture(renderer):
    """Ends that are left to the volume go with it: parallel rays from further away, or from very far, show the same."""
    middle = blobs().corners_world().mean(axis=0)
    pictures = []
    for away in (60.0, 96.0, 9060.0):  # samples stay where they are
        camera = al.Camera.orthographic(eye=tuple(middle + np.array([0, -away, 0])), target=tuple(middle), height=40)
        drawn = al.Scene(
            blobs(), transfer=function(), camera=camera, look=al.Look(integrate="depth_shaded_mip"), background=None
        )
        pictures.append(renderer.render(drawn, SIZE).rgba)
    assert all(np.quantile(np.abs(picture - pictures[0]), 0.995) < LEVEL for picture in pictures)


# -- what does not go


def test_what_shows_one_value_refuses_several(renderer):
    two = al.Volume(np.stack([blobs().array] * 2))
    several = al.Channels([al.Channel(0, function()), al.Channel(1, function())])
    for name in ("attenuated_mip", "depth_shaded_mip", "local_mip"):
        with pytest.raises(AirlightError, match=r"shows values, and there are 2 channels"):
            renderer.render(al.Scene(two, transfer=several, look=al.Look(integrate=name)), SIZE)
    for name in ("xray", "weighted_sum"):
        with pytest.raises(AirlightError, match=rf"{name}\.(high|full) is left to the data"):
            renderer.render(al.Scene(two, transfer=several, look=al.Look(integrate=name)), SIZE)
    with pytest.raises(AirlightError, match=r"xray.high is 1, must be above low, 2"):
        renderer.render(scene(integrate=al.integrate.XRay(low=2, high=1)), SIZE)
    with pytest.raises(AirlightError, match=r"depth_shaded_mip.far is 1, must be above near, 2"):
        renderer.render(scene(integrate=al.integrate.DepthShadedMip(near=2, far=1)), SIZE)
    with pytest.raises(AirlightError, match=r"from_hounsfield.water is -1"):
        al.TransferFunction.from_hounsfield(-1)


def test_functions_that_are_left_open(renderer):
    """An X-ray picture of a CT takes what Hounsfield units stand for, in the unit of its world."""
    ct = np.full((12, 12, 12), -1000, dtype=np.int16)
    ct[2:10, 2:10, 2:10] = 0
    shown = []
    for unit, spacing in (("mm", 5.0), ("cm", 0.5)):
        volume = al.Volume(ct, spacing=(spacing,) * 3, units=unit, modality="CT", value_unit="HU")
        camera = al.Camera.orthographic(
            eye=(5.5 * spacing, -100, 5.5 * spacing), target=(5.5 * spacing, 0, 5.5 * spacing), height=1
        )
        drawn = al.Scene(volume, camera=camera, look=al.Look(integrate=al.integrate.XRay(high=1)))
        shown.append(renderer.render(drawn, (1, 1), driver=al.driver.March(curved=False)).rgba[0, 0, 0])
    # Seven slabs of water and one of each side of it, where it begins.
    assert shown == pytest.approx([0.0206 * 5 * 8] * 2, rel=1e-3)
    image = renderer.render(
        al.Scene(blobs(), camera=cameras(blobs())["perspective"], look=al.Look(integrate="weighted_sum")), SIZE
    )
    assert 0.3 < image.rgba[..., 0].max() < 3
