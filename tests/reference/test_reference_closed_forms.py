"""Whole rays against integrals done by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_scenes import ONE, WHITE, along_z, constant, ramp_z, scene

from airlight import reference
from airlight.scene import Camera
from airlight.stages.integrate import EmissionAbsorption, FirstHit
from airlight.transfer import TransferFunction
from airlight.volume import Volume

FULL = EmissionAbsorption(opaque_at=1.0)
RAMP = TransferFunction([(0, (0, 0, 0), 0), (1, (1, 1, 1), 1)])


def one(what, step=1.0, **options):
    image = reference.render(what, ONE, step=step, **options)
    return image.rgba[0, 0], image.depth[0, 0]


# -- homogeneous


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
@pytest.mark.parametrize("field", ["nearest", "linear", "linear_exact"])
@settings(max_examples=20, deadline=None)
@given(extinction=st.floats(0, 20), step=st.floats(0.1, 3), spacing=st.floats(0.01, 50), n=st.integers(1, 6))
def test_homogeneous_slab(field, transfer, extinction, step, spacing, n):
    volume = Volume(np.ones((n, 3, 3), np.uint8), spacing=(spacing,) * 3)
    cells = field == "nearest" or n == 1
    length = spacing * (n if cells else n - 1)
    rgba, _ = one(
        scene(
            volume,
            constant(extinction, (1.0, 0.5, 0.0)),
            along_z(spacing, spacing, -3.3 * spacing),
            field=field,
            transfer=transfer,
            integrate=FULL,
        ),
        step,
    )
    alpha = 1 - math.exp(-min(extinction * length, 700))
    assert rgba == pytest.approx([alpha, alpha / 2, 0, alpha], abs=1e-11)


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
@pytest.mark.parametrize("extinction", [0.0, 1e-9, 0.3, 40.0])
def test_homogeneous_associated(transfer, extinction):
    volume = Volume(np.ones((5, 3, 3)))
    tf = constant(extinction, (2.0, 1.0, 0.5), associated=True)
    rgba, _ = one(scene(volume, tf, transfer=transfer, integrate=FULL), 0.7)
    shine = 4.0 if extinction == 0 else -math.expm1(-extinction * 4) / extinction
    assert rgba == pytest.approx([2 * shine, shine, shine / 2, -math.expm1(-4 * extinction)], rel=1e-10, abs=1e-14)


def test_depth_is_where_opacity_passes_one_half():
    rgba, depth = one(scene(Volume(np.ones((9, 3, 3))), constant(0.4)), 1.7)
    assert depth == pytest.approx(10 + math.log(2) / 0.4, abs=1e-12)
    rgba, depth = one(scene(Volume(np.ones((9, 3, 3))), constant(0.08)))
    assert rgba[3] < 0.5
    assert depth == math.inf
    _, depth = one(scene(Volume(np.ones((9, 3, 3))), constant(1e6)))
    # One slab that hides everything tells its depth to within float64: ln 2 / ln 1e-15.
    assert depth == pytest.approx(10, abs=0.021)


def test_an_opaque_ray_stops_and_keeps_its_opacity():
    volume = Volume(np.ones((9, 3, 3)))
    rgba, _ = one(scene(volume, constant(0.5), integrate=EmissionAbsorption(opaque_at=0.9)))
    # Slabs of length one: the fifth is the first that passes 0.9.
    assert rgba == pytest.approx([1 - math.exp(-2.5)] * 4, abs=1e-14)


def test_density_scales_extinction():
    from dataclasses import replace

    from airlight.scene import Scene

    base = scene(Volume(np.ones((5, 3, 3))), constant(0.1))
    layer = replace(base.layers[0], density=3.0)
    rgba, _ = one(Scene(layers=[layer], camera=base.camera))
    assert rgba[3] == pytest.approx(1 - math.exp(-0.3 * 4), abs=1e-13)


# -- ramps


@pytest.mark.parametrize("step", [0.3, 1.0, 2.6])
def test_ramp_of_extinction(step):
    # tau(x) = x / L over length L: optical depth L / 2, whatever the step.
    rgba, _ = one(scene(ramp_z(7), TransferFunction([(0, WHITE, 0), (1, WHITE, 1)]), integrate=FULL), step)
    assert rgba == pytest.approx([1 - math.exp(-3)] * 4, abs=1e-11)


@pytest.mark.parametrize("step", [0.3, 1.0, 2.6, 6.0])
def test_ramp_of_colour(step):
    # c(x) = x / L, tau = k: C = (1 - e^-kL (1 + kL)) / (kL).
    k, length = 0.4, 6.0
    rgba, _ = one(scene(ramp_z(7), TransferFunction([(0, (0, 0, 0), k), (1, WHITE, k)]), integrate=FULL), step)
    expected = (1 - math.exp(-k * length) * (1 + k * length)) / (k * length)
    assert rgba[:3] == pytest.approx([expected] * 3, abs=1e-11)


@pytest.mark.parametrize("step", [0.3, 1.0, 6.0])
def test_ramp_of_an_associated_glow(step):
    # c~ = 1, tau(x) = x / L: C = integral of exp(-x^2 / 2L) = sqrt(pi L / 2) erf(sqrt(L / 2)).
    tf = TransferFunction([(0, WHITE, 0), (1, WHITE, 1)], associated=True)
    rgba, _ = one(scene(ramp_z(7), tf, integrate=FULL), step)
    assert rgba[:3] == pytest.approx([math.sqrt(math.pi * 3) * math.erf(math.sqrt(3))] * 3, abs=1e-10)


@pytest.mark.parametrize("step", [0.3, 1.0, 6.0])
def test_ramp_of_colour_and_extinction(step):
    # c = tau = x / L: with u = x^2 / 2L, C = integral of sqrt(2u / L) e^-u du over 0..L/2
    #   = sqrt(2 / L) (sqrt(pi) / 2 erf(sqrt(L/2)) - sqrt(L/2) e^(-L/2)).
    length = 6.0
    rgba, _ = one(scene(ramp_z(7), RAMP, integrate=FULL), step)
    root = math.sqrt(length / 2)
    expected = math.sqrt(2 / length) * (math.sqrt(math.pi) / 2 * math.erf(root) - root * math.exp(-length / 2))
    assert rgba[:3] == pytest.approx([expected] * 3, abs=1e-10)


def test_a_step_in_the_function_is_met_exactly():
    # Extinction jumps to 2 at the value 0.4 of a ramp over length 6: 3.6 units of it lie behind.
    tf = TransferFunction([(0, WHITE, 0), (0.4, WHITE, 0), (0.4, (1, 0, 0), 2), (1, (1, 0, 0), 2)])
    for step in (0.37, 1.0, 6.0):
        rgba, depth = one(scene(ramp_z(7), tf, integrate=FULL), step)
        alpha = 1 - math.exp(-7.2)
        assert rgba == pytest.approx([alpha, 0, 0, alpha], abs=1e-12)
    # From behind it is the same in the other direction.
    behind = Camera.orthographic(eye=(1, 1, 20), target=(1, 1, 0), up=(0, 1, 0), height=0.1)
    rgba, depth = one(scene(ramp_z(7), tf, behind, integrate=FULL))
    assert rgba[3] == pytest.approx(alpha, abs=1e-12)
    assert depth == pytest.approx(14 + math.log(2) / 2, abs=1e-12)


# -- Gaussian, sphere


def cube(n, function):
    g = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(g, g, g, indexing="ij")
    return Volume(function(x, y, z), spacing=(2 / (n - 1),) * 3, origin=(-1, -1, -1))


@pytest.mark.parametrize("offset", [0.0, 0.25, -0.5])
def test_gaussian_blob(offset):
    # Along lattice lines the trilinear field integrates to the trapezoid sum, which is exact for a Gaussian.
    sigma, peak = 0.15, 3.0
    volume = cube(65, lambda x, y, z: np.exp(-(x**2 + y**2 + z**2) / (2 * sigma**2)))
    tf = TransferFunction([(0, WHITE, 0), (1, WHITE, peak)])
    rgba, _ = one(scene(volume, tf, along_z(offset, 0.125, -5), integrate=FULL))
    depth = peak * sigma * math.sqrt(2 * math.pi) * math.exp(-(offset**2 + 0.125**2) / (2 * sigma**2))
    assert rgba[3] == pytest.approx(1 - math.exp(-depth), abs=1e-9)


def test_gaussian_blob_obliquely():
    sigma, peak = 0.2, 3.0
    volume = cube(97, lambda x, y, z: np.exp(-(x**2 + y**2 + z**2) / (2 * sigma**2)))
    tf = TransferFunction([(0, WHITE, 0), (1, WHITE, peak)])
    camera = Camera.perspective(eye=(1.5, -3, 1.2), target=(0.1, 0, 0.05), fov_deg=10)
    rgba, _ = one(scene(volume, tf, camera, integrate=FULL), 0.5)
    eye, towards = np.array(camera.eye), np.array(camera.target) - camera.eye
    closest = np.linalg.norm(np.cross(eye, towards)) / np.linalg.norm(towards)
    depth = peak * sigma * math.sqrt(2 * math.pi) * math.exp(-(closest**2) / (2 * sigma**2))
    assert rgba[3] == pytest.approx(1 - math.exp(-depth), abs=2e-3)


@pytest.mark.parametrize(("impact", "tolerance"), [(0.0, 1e-9), (0.25, 2e-4), (0.5, 5e-4)])
def test_sphere_chord(impact, tolerance):
    radius, extinction = 0.7, 1.3
    volume = cube(81, lambda x, y, z: radius - np.sqrt(x**2 + y**2 + z**2))
    tf = TransferFunction([(0, WHITE, 0), (0, WHITE, extinction)])
    rgba, _ = one(scene(volume, tf, along_z(impact, 0.0, -5), integrate=FULL))
    chord = 2 * math.sqrt(radius**2 - impact**2)
    assert rgba[3] == pytest.approx(1 - math.exp(-extinction * chord), abs=tolerance)


# -- projections


def test_mip_minip_and_mean_of_a_ramp():
    down = ramp_z(7, 5.0, -1.0)
    tf = TransferFunction([(-1, (0, 0, 0), 0), (5, WHITE, 1)])
    rgba, depth = one(scene(down, tf, integrate="mip"))
    assert rgba == pytest.approx([1, 1, 1, 1])
    assert depth == pytest.approx(10)
    rgba, depth = one(scene(down, tf, integrate="minip"), 0.7)
    assert rgba == pytest.approx([0, 0, 0, 1], abs=1e-12)
    assert depth == pytest.approx(16)
    rgba, depth = one(scene(down, tf, integrate="mean"), 0.7)
    assert rgba == pytest.approx([0.5, 0.5, 0.5, 1], abs=1e-12)
    assert depth == math.inf


def test_mip_keeps_the_first_of_equal_extremes():
    values = np.array([0, 3, 1, 3, 0.0])
    volume = Volume(np.broadcast_to(values[:, None, None], (5, 3, 3)))
    tf = TransferFunction([(0, (0, 0, 0), 0), (3, (1, 0.5, 0), 1)])
    rgba, depth = one(scene(volume, tf, integrate="mip"))
    assert rgba == pytest.approx([1, 0.5, 0, 1])
    assert depth == pytest.approx(11)


def test_rays_that_miss_see_nothing():
    for integrate in ("emission_absorption", "mip", "minip", "mean", "first_hit"):
        rgba, depth = one(scene(ramp_z(5), RAMP, along_z(50, 50), integrate=integrate))
        assert (rgba == 0).all()
        assert depth == math.inf
        # Behind the eye there is nothing, either.
        rgba, depth = one(scene(ramp_z(5), RAMP, along_z(1, 1, 7.0), integrate=integrate))
        assert (rgba == 0).all()


def test_a_ray_from_within_begins_at_the_eye():
    rgba, depth = one(scene(Volume(np.ones((9, 3, 3))), constant(0.4), along_z(1, 1, 3.0)))
    assert rgba[3] == pytest.approx(1 - math.exp(-0.4 * 5), abs=1e-13)
    assert depth == pytest.approx(math.log(2) / 0.4, abs=1e-12)


# -- first hit


def test_first_hit_of_a_plane():
    tf = TransferFunction([(0, (1, 0, 0), 0), (1, (0, 0, 1), 1)])
    for step in (0.4, 1.0, 3.0):
        rgba, depth = one(scene(ramp_z(7), tf, integrate=FirstHit(iso=0.3)), step)
        assert rgba == pytest.approx([0.7, 0, 0.3, 1], abs=1e-12)
        assert depth == pytest.approx(10 + 0.3 * 6, abs=1e-12)
    # Without iso it is where extinction reaches half of its maximum.
    _, depth = one(scene(ramp_z(7), tf, integrate="first_hit"))
    assert depth == pytest.approx(13, abs=1e-12)


def test_first_hit_from_inside_is_the_cut_face():
    rgba, depth = one(scene(ramp_z(7, 1.0, 0.0), RAMP, integrate=FirstHit(iso=0.3)))
    # The cut shows the value that lies there.
    assert depth == pytest.approx(10)
    assert rgba == pytest.approx([1, 1, 1, 1])
    # A ray that begins below and never reaches the value hits nothing.
    rgba, depth = one(scene(ramp_z(7, 0.2, 0.0), RAMP, integrate=FirstHit(iso=0.3)))
    assert rgba[3] == 0
    assert depth == math.inf


def test_first_hit_at_a_step_of_the_function_shows_what_lies_behind():
    # The automatic iso-value of a step is the step itself, where the later point holds, however hits are rounded.
    tf = TransferFunction([(0, (0, 1, 0), 0), (0.3, (0, 1, 0), 0), (0.3, (1, 0, 0), 1)])
    rng = np.random.default_rng(7)
    for low, high in zip(rng.uniform(-2, 0.29, 60), rng.uniform(0.31, 3, 60), strict=True):
        rgba, depth = one(scene(ramp_z(5, low, high), tf, integrate="first_hit"), 0.7)
        assert rgba.tolist() == [1, 0, 0, 1]
        assert depth == pytest.approx(10 + 4 * (0.3 - low) / (high - low))


def test_first_hit_of_an_oblique_plane():
    g = np.arange(12.0)
    z, y, x = np.meshgrid(g, g, g, indexing="ij")
    volume = Volume(2 * x - y + 3 * z)
    camera = Camera.perspective(eye=(20, 1, 25), target=(6, 5, 6), up=(0, 1, 0), fov_deg=5)
    iso = 20.0
    tf = TransferFunction([(-100, WHITE, 1), (100, WHITE, 1)])
    look = scene(volume, tf, camera, integrate=FirstHit(iso=iso))
    towards = np.array(camera.target) - camera.eye
    towards /= np.linalg.norm(towards)
    # The ray enters above the value and is cut there, at the face that it meets last of x = 11 and z = 11 and y = 0.
    _, depth = one(look)
    faces = [(limit - e) / d for limit, e, d in zip((11, 0, 11), camera.eye, towards, strict=True)]
    assert depth == pytest.approx(max(faces), abs=1e-9)
    # From below it meets the plane.
    eye = np.array([-5.0, 6.0, -8.0])
    camera = Camera.perspective(eye=tuple(eye), target=(6, 5, 6), up=(0, 1, 0), fov_deg=5)
    towards = np.array(camera.target) - eye
    towards /= np.linalg.norm(towards)
    normal = np.array([2.0, -1, 3])
    _, depth = one(scene(volume, tf, camera, integrate=FirstHit(iso=iso)), 0.9)
    assert depth == pytest.approx((iso - normal @ eye) / (normal @ towards), abs=1e-9)


def test_first_hit_of_a_sphere():
    radius = 0.7
    volume = cube(65, lambda x, y, z: radius - np.sqrt(x**2 + y**2 + z**2))
    camera = Camera.perspective(eye=(0.2, -4, 0.5), target=(0, 0, 0), fov_deg=18)
    image = reference.render(scene(volume, constant(1.0), camera, integrate=FirstHit(iso=0.0)), (9, 9), step=0.5)
    # |e + t d| = radius for the direction of each pixel.
    for y in range(9):
        for x in range(9):
            eye, middle = np.array(camera.eye), -np.array(camera.eye) / np.linalg.norm(camera.eye)
            right = np.cross(middle, (0, 0, 1))
            right /= np.linalg.norm(right)
            up = np.cross(right, middle)
            tangent = math.tan(math.radians(9))
            d = middle + tangent * ((2 * x + 1) / 9 - 1) * right + tangent * (1 - (2 * y + 1) / 9) * up
            d /= np.linalg.norm(d)
            closest = eye @ eye - (eye @ d) ** 2
            if closest < (radius - 0.02) ** 2:
                t = -(eye @ d) - math.sqrt(radius**2 - closest)
                assert image.depth[y, x] == pytest.approx(t, abs=2e-3)
                assert image.rgba[y, x, 3] == 1
            elif closest > (radius + 0.02) ** 2:
                assert image.depth[y, x] == math.inf
