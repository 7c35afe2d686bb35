"""Filters at single points: values and derivatives against float64 sums, laws, and what is refused."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from points import in_reference, inside, on_device, scene_of
from scenes import rotation

import airlight as al
from airlight.reconstruction import kernels, spline
from airlight.reconstruction.spline import prefiltered
from airlight.stage import Context

FILTERS = [
    al.field.Linear(),
    al.field.LinearExact(),
    al.field.BSpline(),
    al.field.BSpline(prefilter=True),
    al.field.BSplineExact(),
    al.field.BSplineExact(prefilter=True),
    al.field.CatmullRom(),
    al.field.Mitchell(),
    al.field.Mitchell(b=0.2, c=0.7),
    al.field.WindowedSinc(),
    al.field.WindowedSinc("kaiser", 2),
    al.field.WindowedSinc("lanczos", 5),
    al.field.Kernel(),
    al.field.Kernel.of(lambda x: np.maximum(1 - np.abs(x), 0) ** 2 * (1 + 2 * np.abs(x)), 1),
    al.field.KernelBody(),
]
# Samples that no voxel meets when a place is one: the kernel's kinks lie elsewhere.
PLACE = np.linspace(-2, 2, 12)
ODD_BODY = al.field.KernelBody(tuple(np.prod(np.meshgrid(*[np.sinc(PLACE) * np.sinc(PLACE / 2)] * 3), axis=0).ravel()), 2)
INTERPOLATING = [FILTERS[n] for n in (0, 1, 3, 5, 6, 9, 10, 11)]
NEAR = 1e-4  # of the field's range: what float formats must reach


def name_of(stage) -> str:
    short = {k: v for k, v in vars(stage).items() if not isinstance(v, tuple)}
    return stage.name + "".join(f" {k}={v}" for k, v in short.items())


def sheared(samples: np.ndarray) -> al.Volume:
    """Samples on a grid that is turned, stretched and sheared."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 2, 3), 0.7) @ np.array([[1.0, 0.3, 0.1], [0, 0.6, -0.2], [0, 0, 1.7]])
    matrix[:3, 3] = 3, -2, 1
    return al.Volume(samples.astype(np.float32), world_from_index=matrix)


@pytest.fixture(scope="module")
def noise() -> al.Volume:
    return sheared(np.random.default_rng(5).uniform(-40, 60, (9, 12, 14)))


@pytest.mark.parametrize("stage", FILTERS, ids=name_of)
def test_values_and_gradients(device, noise, stage, rng):
    """On random samples, the worst there are: within 1e-4 of the range, and 1e-3 of the longest gradient."""
    drawn, p = scene_of(noise, stage, "analytic"), inside(noise, 4000, rng)
    (value, gradient), (true_value, true_gradient) = on_device(device, drawn, p), in_reference(drawn, p)
    assert np.abs(value - true_value).max() <= NEAR * 100
    longest = np.linalg.norm(true_gradient, axis=1).max()
    assert np.linalg.norm(gradient - true_gradient, axis=1).max() <= 1e-3 * longest


@pytest.mark.parametrize("stage", FILTERS, ids=name_of)
def test_on_core_devices(core_device, noise, stage, rng):
    """Where 32-bit floats are not filtered, half floats stand for them, and the error of the format is known."""
    drawn, p = scene_of(noise, stage, "analytic"), inside(noise, 1000, rng)
    value, _ = on_device(core_device, drawn, p)
    tolerance = 2e-3 if stage.filtered else NEAR
    assert np.abs(value - in_reference(drawn, p)[0]).max() <= tolerance * 100


@pytest.mark.parametrize("stage", FILTERS[2:], ids=name_of)
def test_derivative_is_that_of_the_field(noise, stage, rng):
    """The reference's derivative against differences of its own field, in the world."""
    drawn, p = scene_of(noise, stage, "analytic"), inside(noise, 500, rng)
    p = 0.02 + 0.96 * p
    h = 1e-4
    matrix = noise.world_from_index[:3, :3]
    found = in_reference(drawn, p)[1]
    ends = [(in_reference(drawn, p + h * e)[0], in_reference(drawn, p - h * e)[0]) for e in np.eye(3)]
    along = np.stack([(high - low) / (2 * h) for high, low in ends], axis=1)
    # Kernels that are tables have a derivative of their own, smoother than that of straight pieces.
    tolerance = {"kernel": 0.05, "kernel_body": 0.15}.get(stage.name, 1e-4)
    assert np.abs(found @ matrix - along).max() <= tolerance * np.abs(along).max()


@pytest.mark.parametrize("stage", INTERPOLATING, ids=name_of)
def test_interpolating_filters_keep_the_samples(device, noise, stage):
    z, y, x = (axis.ravel() for axis in np.indices(noise.array.shape))
    value, _ = on_device(device, scene_of(noise, stage, "zero"), np.stack([x, y, z], axis=1).astype(np.float64))
    assert np.abs(value - noise.array.ravel()).max() <= NEAR * 100


@pytest.mark.parametrize("stage", FILTERS, ids=name_of)
@pytest.mark.parametrize("samples", ["constant", "linear"])
def test_constants_and_straight_lines(device, stage, samples, rng):
    """All keep constants; symmetric filters whose moments are right keep straight lines, away from the faces."""
    z, y, x = np.indices((16, 17, 18))
    plane = 3.0 + 2 * x - y + 0.5 * z
    volume = sheared(plane if samples == "linear" else np.full(plane.shape, 7.25))
    p = 5.5 + rng.uniform(0, 1, (300, 3)) * 5
    value, gradient = on_device(device, scene_of(volume, stage, "analytic"), p)
    if samples == "constant":
        assert np.abs(value - 7.25).max() < 1e-5
        assert np.abs(gradient).max() < 1e-4
    elif stage.name not in ("windowed_sinc", "kernel", "kernel_body") and getattr(stage, "c", 1 / 3) < 0.5:
        # The others keep straight lines about; of the cubic ones do those with B + 2 C = 1.
        assert np.abs(value - (3.0 + 2 * p[:, 0] - p[:, 1] + 0.5 * p[:, 2])).max() < 1e-3
        assert np.abs(gradient @ volume.world_from_index[:3, :3] - (2, -1, 0.5)).max() < 1e-3


@settings(max_examples=20)
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=3))
def test_catmull_rom_keeps_quadratics(factors):
    a, b, c = factors
    voxels, share = np.arange(4) - 1.0, np.linspace(0, 1, 33)
    weights = kernels.cubic_weights(0.0, 0.5, share)
    assert np.abs(weights @ (a * voxels**2 + b * voxels + c) - (a * share**2 + b * share + c)).max() < 1e-12


@given(st.floats(0, 2), st.floats(0, 2))
def test_weights_sum_to_one_and_are_symmetric(b, c):
    share = np.linspace(0, 1, 65)
    weights = kernels.cubic_weights(b, c, share)
    assert np.abs(weights.sum(axis=1) - 1).max() < 1e-12
    assert np.abs(weights - weights[::-1, ::-1]).max() < 1e-12


@settings(max_examples=25)
@given(st.sampled_from(["lanczos", "kaiser"]), st.integers(1, 8))
def test_tables_of_windowed_sincs(window, radius):
    weights, slopes = al.field.WindowedSinc(window, radius).weights()
    assert np.abs(weights.sum(axis=1) - 1).max() < 1e-12
    assert np.abs(slopes.sum(axis=1)).max() < 1e-9
    assert np.abs(weights - weights[::-1, ::-1]).max() < 1e-12
    assert np.abs(weights[0] - (np.arange(2 * radius) == radius - 1)).max() < 1e-12


@settings(max_examples=30)
@given(st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_coefficients_solve_the_equations_of_the_spline(n, seed):
    """(c[i-1] + 4 c[i] + c[i+1]) / 6 are the samples, with outer coefficients going on beyond the faces."""
    samples = np.random.default_rng(seed).uniform(0, 100, (n, 3, 5))
    found = prefiltered(samples).astype(np.float64)
    for axis in range(3):
        padded = np.pad(found, [(1, 1) if a == axis else (0, 0) for a in range(3)], mode="edge")
        low, middle, high = (np.take(padded, np.arange(found.shape[axis]) + k, axis=axis) for k in range(3))
        found = (low + 4 * middle + high) / 6
    assert np.abs(found - samples).max() < 2e-3


@pytest.mark.parametrize("stage", [s for s in FILTERS if s.name != "kernel_body"], ids=name_of)
def test_reach_and_overshoot(device, stage, rng):
    """Steps between 0 and 1 leave that range by no more than is said, and nearly by it somewhere."""
    volume = sheared(rng.integers(0, 2, (12, 12, 12)))
    p = inside(volume, 20000, rng)
    value, _ = on_device(device, scene_of(volume, stage, "zero"), p)
    held = np.concatenate([value, [0.0, 1.0]])
    if getattr(stage, "prefilter", False):
        grid = stage.resources(Context(volume, None, (0,), 0, 1.0, (1, 1)))["grid"].volume.array
        assert held.max() <= grid.max()
        assert held.min() >= grid.min()
    else:
        assert held.max() - 1 <= stage.overshoot + 1e-4
        assert -held.min() <= stage.overshoot + 1e-4
    assert max(held.max() - 1, -held.min()) >= 0.1 * stage.overshoot - 1e-6


def test_smoothing_is_what_its_response_says(device):
    """A wave of eight voxels through each filter is the wave times the response at an eighth of a cycle."""
    wave = np.cos(2 * np.pi * np.arange(64) / 8)
    volume = al.Volume(np.broadcast_to(wave, (8, 8, 64)).astype(np.float32))
    p = np.stack([np.linspace(24, 40, 257), np.full(257, 3.5), np.full(257, 3.5)], axis=1)
    for stage in (al.field.BSpline(), al.field.Mitchell(), al.field.Kernel()):
        value, _ = on_device(device, scene_of(volume, stage, "zero"), p)
        share = (np.arange(512) + 0.5) / 512
        weights = kernels.cubic_weights(1.0, 0.0, share) if stage.name == "bspline" else None
        weights = kernels.cubic_weights(*stage.family, share) if stage.name == "mitchell" else weights
        if weights is None:
            weights, _ = kernels.tap_weights(kernels.tabulated(stage.samples, stage.radius), stage.radius, share, 1e-5)
        expected = kernels.response(weights, np.array([1 / 8]))[0]
        found = 2 * np.mean(value[:-1] * np.cos(2 * np.pi * p[:-1, 0] / 8))
        assert found == pytest.approx(expected, abs=2e-3)


def test_kernels_that_are_given(noise, rng, device):
    """A tent is linear interpolation, as a product and as a body; so is one given as samples."""
    p = inside(noise, 500, rng)
    linear = in_reference(scene_of(noise, "linear", "zero"), p)[0]
    tents = [
        al.field.Kernel.of(lambda x: np.maximum(1 - np.abs(x), 0), 1),
        al.field.Kernel((0, 1, 0), 1),
        al.field.Kernel((0, 5, 0), 1),
        al.field.KernelBody.of(
            lambda x, y, z: np.prod([np.maximum(1 - np.abs(a), 0) for a in np.broadcast_arrays(x, y, z)], axis=0), 1, 32
        ),
    ]
    for stage in tents:
        tolerance = 0.3 if stage.name == "kernel_body" else 0.01  # products of straight lines, interpolated between samples
        assert np.abs(on_device(device, scene_of(noise, stage, "zero"), p)[0] - linear).max() < tolerance


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: al.field.Kernel((1.0, 1.0), 1), "at least three"),
        (lambda: al.field.Kernel((-1.0, 1.0, -1.0, 1.0, -1.0), 2), "almost nothing"),
        (lambda: al.field.Kernel((0.0, float("nan"), 0.0), 1), "finite"),
        (lambda: al.field.WindowedSinc(radius=9), r"\[1, 8\]"),
        (lambda: al.field.WindowedSinc("hann"), "lanczos"),
        (lambda: al.field.KernelBody((1.0,) * 26), "cube"),
        (lambda: al.field.KernelBody((0.0,) * 27), "almost nothing"),
        (lambda: al.field.KernelBody((1.0, -1.0) * 13 + (1.0,), 1), "almost nothing"),
        (lambda: al.field.Kernel.of(np.sinc, 2.5), "whole number"),
        (lambda: al.field.Kernel.of(np.sinc, -1), "whole number"),
        (lambda: al.field.Kernel.of(lambda x: x[:2], 2), "no numbers that fit"),
        (lambda: al.field.Kernel("abc"), "must be a list"),
        (lambda: al.field.Kernel(None), "must be a list"),
        (lambda: al.field.Kernel(((1, 2), (3,))), "no numbers"),
        (lambda: al.field.KernelBody.of(lambda x, y, z: x, 2.5), "whole number"),
        (lambda: al.field.Mitchell(b=-1), r"\[0, 2\]"),
    ],
)
def test_bad_kernels_are_refused(make, words):
    with pytest.raises(al.ValueRangeError, match=words):
        make()


def test_functions_may_give_one_number():
    assert al.field.Kernel.of(lambda x: 1.0, 2).samples == (1.0,) * 129


@pytest.mark.parametrize(("side", "radius"), [(6, 2), (12, 2), (4, 1), (20, 3)])
def test_overshoot_of_a_body_is_that_of_its_product(side, radius):
    """A separable kernel interpolated along each axis stays a product: its gain is the cube of that along an axis."""
    place = np.linspace(-radius, radius, side)
    line = np.sinc(1.3 * place) * np.cos(np.pi * place / (2 * radius + 1))
    body = al.field.KernelBody(tuple(np.prod(np.meshgrid(line, line, line), axis=0).ravel()), radius)
    distance = np.linspace(0, 1, 4621)[:, None] - (np.arange(2 * radius) + 1 - radius)  # holds all kinks
    weights = kernels.tabulated(tuple(line), radius)(distance)
    gain = kernels.greatest_gain(weights / weights.sum(axis=1, keepdims=True))
    assert body.overshoot == pytest.approx(kernels.overshoot_of(gain), rel=1e-3)


def test_coefficients_are_kept_but_not_without_end(rng):
    volume = al.Volume(rng.random((9, 4, 5, 6)).astype(np.float32))
    first = spline.coefficients(volume, (0,), 0)
    assert spline.coefficients(volume, (0,), 0) is first
    for channel in range(1, 9):
        spline.coefficients(volume, (channel,), 0)
    assert len(volume.__dict__["_coefficients"]) == spline.KEPT_GRIDS
    assert spline.coefficients(volume, (0,), 0) is not first
    assert pickle.loads(pickle.dumps(volume)) == volume


@pytest.mark.parametrize("field", ["nearest", "preclassified"])
@pytest.mark.parametrize("gradient", ["analytic", al.gradient.Precomputed("analytic")])
def test_fields_without_a_derivative_refuse_it(renderer, noise, field, gradient):
    with pytest.raises(al.StageError, match=r"derivative.*use central"):
        renderer.render(scene_of(noise, field, gradient), (8, 8))


@pytest.mark.parametrize("stage", [s for s in FILTERS if s.name != "kernel_body"] + [al.field.Levels(), ODD_BODY], ids=name_of)
def test_blocks_bound_filters(renderer, stage, rng):
    """Surfaces that only overshooting values reach are found, whatever blocks say of the samples."""
    volume = sheared(rng.integers(0, 2, (20, 20, 20)))
    hits = [al.integrate.FirstHit(iso=iso) for iso in (0.5, 1 + 0.3 * stage.overshoot, 1.2)]
    for hit in hits:
        drawn = al.Scene(
            volume,
            transfer=al.TransferFunction([(0, "red", 1), (1, "blue", 1)]),
            camera="iso",
            look=al.Look(field=stage, integrate=hit, shade="none"),
        )
        skipped, whole = (renderer.render(drawn, (40, 40), skip=skip) for skip in ("auto", "none"))
        assert np.array_equal(skipped.rgba, whole.rgba)
        assert np.array_equal(skipped.depth, whole.depth)
