"""Images against closed forms along rays, worked out by hand and independent of any code of the package."""

from __future__ import annotations

import math

import numpy as np
import pytest

import airlight as al

STEPS = [0.25, 0.5, 1.0, 1.7, 4.0]


def straight(volume: al.Volume) -> al.Camera:
    """Orthographic camera along +y, one pixel on the axis of the volume."""
    middle = volume.corners_world().mean(axis=0)
    return al.Camera.orthographic(eye=(middle[0], -100.0, middle[2]), target=tuple(middle), height=0.1)


def along_y(values, spacing: float = 1.0) -> al.Volume:
    """Volume that varies along y only."""
    line = np.asarray(values, dtype=np.float32)
    return al.Volume(np.broadcast_to(line[None, :, None], (4, len(line), 4)).copy(), spacing=(2, spacing, 2))


def pixel(renderer, volume, tf, step, transfer="preintegrated", **look):
    drawn = al.Scene(volume, transfer=tf, camera=straight(volume), look=al.Look(transfer=transfer, shade="none", **look))
    return renderer.render(drawn, (1, 1), step=step).rgba[0, 0]


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("transfer", ["preintegrated", "postclassified"])
@pytest.mark.parametrize("tau", [1e-6, 0.01, 0.3, 5.0, 100.0])
def test_homogeneous_slab(renderer, tau, transfer, step):
    """alpha = 1 - exp(-tau d), colour c alpha, for any step."""
    volume = along_y(np.full(11, 5.0), spacing=0.7)
    tf = al.TransferFunction([(0, (0.9, 0.5, 0.1), tau), (10, (0.9, 0.5, 0.1), tau)])
    rgba = pixel(renderer, volume, tf, step, transfer)
    alpha = -math.expm1(-tau * 7.0)
    assert rgba[3] == pytest.approx(alpha, rel=1e-4, abs=1e-4 if tau > 1 else 1e-9)
    assert rgba[:3] == pytest.approx(np.array([0.9, 0.5, 0.1]) * rgba[3], rel=1e-4)


def ramp_truth(tau1: float, length: float, c0: float, c1: float) -> tuple[float, float]:
    """Value runs 0..1 along the ray, extinction tau1 s, colour c0 + (c1 - c0) s: integrate in closed form.

    With a = tau1 / (2 length): T(t) = exp(-a t^2), so the integral of tau T is 1 - exp(-a L^2), and of s tau T by parts
    sqrt(pi / a) erf(sqrt(a) L) / (2 L) - exp(-a L^2).
    """
    a = tau1 / (2 * length)
    through = math.exp(-a * length**2)
    first = math.sqrt(math.pi / a) * math.erf(math.sqrt(a) * length) / (2 * length) - through
    return 1 - through, c0 * (1 - through) + (c1 - c0) * first


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("tau", [0.05, 0.5, 2.0])
def test_ramp_is_exact_for_any_step(renderer, tau, step):
    """The field is linear over every slab, so pre-integration has no error of its own at any step."""
    volume = along_y(np.linspace(0, 1, 11))
    tf = al.TransferFunction([(0, (1.0, 0.2, 0.5), 0), (1, (0.0, 0.8, 0.5), tau)])
    rgba = pixel(renderer, volume, tf, step, field="linear_exact")
    alpha, red = ramp_truth(tau, 10.0, 1.0, 0.0)
    _, green = ramp_truth(tau, 10.0, 0.2, 0.8)
    assert rgba == pytest.approx([red, green, 0.5 * alpha, alpha], abs=1e-4)


@pytest.mark.parametrize("step", STEPS)
def test_ramp_across_the_ends_of_the_function(renderer, step):
    """Beyond its ends the function is constant; the slabs that cross an end are put together of pieces."""
    volume = along_y(np.linspace(-1, 2, 31))
    tf = al.TransferFunction([(0, (1, 1, 1), 0.2), (1, (1, 1, 1), 0.6)])
    depth = 10 * 0.2 + 10 * 0.4 + 10 * 0.6
    assert pixel(renderer, volume, tf, step, field="linear_exact")[3] == pytest.approx(1 - math.exp(-depth), abs=1e-4)


@pytest.mark.parametrize("step", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("transfer", ["preintegrated", "postclassified"])
def test_gaussian_blob(renderer, transfer, step):
    """Optical depth of a Gaussian of 12 voxels: sqrt(2 pi) sigma tau erf(reach / (sqrt(2) sigma))."""
    sigma, reach, tau = 12.0, 40, 0.02
    y = np.arange(-reach, reach + 1, dtype=np.float64)
    volume = along_y(np.exp(-(y**2) / (2 * sigma**2)))
    tf = al.TransferFunction([(0, (1, 0.5, 0.25), 0), (1, (1, 0.5, 0.25), tau)])
    depth = math.sqrt(2 * math.pi) * sigma * tau * math.erf(reach / (math.sqrt(2) * sigma))
    # Trilinear reconstruction is the trapezoid rule: its own distance from the Gaussian is below 1e-6 here.
    rgba = pixel(renderer, volume, tf, step, transfer, field="linear_exact")
    assert rgba[3] == pytest.approx(1 - math.exp(-depth), abs=1e-4)


def test_mean_and_extremes_of_a_ramp(renderer):
    volume = along_y(np.linspace(0, 10, 11))
    tf = al.TransferFunction([(0, (0, 0, 0), 0), (10, (1, 1, 1), 1)])
    shown = {name: pixel(renderer, volume, tf, 1.0, integrate=name) for name in ("mip", "minip", "mean")}
    assert shown["mip"] == pytest.approx([1, 1, 1, 1], abs=1e-5)
    assert shown["minip"] == pytest.approx([0, 0, 0, 1], abs=1e-5)
    assert shown["mean"] == pytest.approx([0.5, 0.5, 0.5, 1], abs=1e-5)


def test_first_hit_of_a_ramp_has_its_depth(renderer):
    volume = along_y(np.linspace(0, 10, 11))
    tf = al.TransferFunction([(0, (0, 0, 0), 0), (10, (1, 0.5, 0), 1)])
    look = al.Look(integrate=al.integrate.FirstHit(iso=3.25), shade="none", field="linear_exact")
    image = renderer.render(al.Scene(volume, transfer=tf, camera=straight(volume), look=look), (1, 1))
    assert image.depth[0, 0] == pytest.approx(100 + 3.25, abs=1e-3)
    assert image.rgba[0, 0] == pytest.approx([0.325, 0.1625, 0, 1], abs=1e-4)


def test_lambert_and_highlight_on_a_ramp(renderer):
    """The gradient points to the eye: ambient + diffuse + specular of a head light, in full."""
    volume = along_y(np.linspace(0, 10, 11))
    tf = al.TransferFunction([(0, (1, 1, 1), 50.0), (10, (1, 1, 1), 50.0)])
    look = al.Look(shade=al.shade.BlinnPhong(ambient=0.1, diffuse=0.6, specular=0.2, shininess=8, gradient_threshold=0.1))
    side = math.radians(60)
    light = al.Light.directional(to_light=(math.sin(side), -math.cos(side), 0), intensity=1.0)
    drawn = al.Scene(volume, transfer=tf, camera=straight(volume), look=look, lights=[light])
    rgb = renderer.render(drawn, (1, 1)).rgba[0, 0, :3]
    expected = 0.1 + 0.6 * math.cos(side) + 0.2 * math.cos(side / 2) ** 8
    assert rgb == pytest.approx([expected] * 3, abs=1e-3)


def test_half_opacity_depth_of_fog(renderer):
    """In fog opacity passes one half at ln 2 / tau."""
    volume = along_y(np.full(41, 1.0))
    tf = al.TransferFunction([(0, (1, 1, 1), 0.05), (2, (1, 1, 1), 0.05)])
    drawn = al.Scene(volume, transfer=tf, camera=straight(volume), look=al.Look(shade="none"))
    assert renderer.render(drawn, (1, 1)).depth[0, 0] == pytest.approx(100 + math.log(2) / 0.05, abs=1e-2)
