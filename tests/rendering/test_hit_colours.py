"""Surfaces coloured by curvature and by distance: parity, and shapes whose curvature is known."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SIZE, scene

import airlight as al
from airlight import reference
from airlight.errors import ValueRangeError
from airlight.reference.hit_colours import curvatures
from airlight.stages.hit_colours import COLOUR_BY, is_by_curvature

GREY = al.TransferFunction([(0, "white", 0.0), (1, "white", 1.0)])
CURVATURES = [name for name in COLOUR_BY if is_by_curvature(name)]


def number_of(image: al.Image, low: float, high: float) -> np.ndarray:
    """What the colours of the map "gray" say, which is drawn in sRGB."""
    shown = np.asarray(al.TransferFunction.from_colormap("gray", (0, 1))(np.linspace(0, 1, 4097))[0])[:, 0]
    return low + (high - low) * np.interp(image.rgba[..., 0], shown, np.linspace(0, 1, 4097))


def sampled(field, half: int = 20, spacing: float = 0.5, iso: float = 0.0, **hit) -> al.Scene:
    """A field of the world's coordinates on a grid round the origin, seen along y."""
    z, y, x = spacing * np.mgrid[-half : half + 1, -half : half + 1, -half : half + 1].astype(np.float64)
    volume = al.Volume(field(x, y, z).astype(np.float32), spacing=(spacing,) * 3, origin=(-spacing * half,) * 3)
    way = al.integrate.FirstHit(iso=iso, colours="gray", **hit)
    look = al.Look(field=al.field.BSpline(prefilter=True), gradient="analytic", shade="none", integrate=way)
    camera = al.Camera.orthographic(eye=(1, -50, 0.5), target=(1, 0, 0.5), height=5)
    return al.Scene(volume, transfer=GREY, camera=camera, look=look, background=None)


@pytest.mark.parametrize("camera", ["perspective", "inside"])
@pytest.mark.parametrize("colour_by", COLOUR_BY)
def test_parity(either_renderer, colour_by, camera):
    way = al.integrate.FirstHit(iso=70.0, colour_by=colour_by, colours="turbo")
    check(either_renderer, scene(camera=camera, field="linear_exact", integrate=way), strays=0.02)


@pytest.mark.parametrize("gradient", ["sobel", "analytic", "precomputed"])
@pytest.mark.parametrize("field", ["linear_exact", "bspline"])
def test_parity_of_gradients(renderer, field, gradient):
    way = al.integrate.FirstHit(iso=70.0, colour_by="mean_curvature", low=-0.2, high=0.2)
    # The derivative of linear interpolation jumps from cell to cell.
    strays = 0.15 if (field, gradient) == ("linear_exact", "analytic") else 0.02
    check(renderer, scene(field=field, gradient=gradient, integrate=way, shade="none"), strays)


@pytest.mark.parametrize(
    "place", [{}, {"point": (5, -3, 2)}, {"point": (5, -3, 2), "normal": (1, 2, -0.5)}, {"normal": (0, 0, 3)}]
)
@pytest.mark.parametrize("camera", ["perspective", "orthographic", "cut"])
def test_distances(either_renderer, place, camera):
    way = al.integrate.FirstHit(iso=70.0, colour_by="distance", **place)
    check(either_renderer, scene(camera=camera, field="linear_exact", integrate=way, shade="none"), strays=0.002)


def check(renderer, drawn, strays: float) -> None:
    image = renderer.render(drawn, SIZE)
    truth = reference.render(drawn, SIZE)
    assert truth.rgba[..., 3].mean() > 0.05
    assert np.ptp(truth.rgba[..., :3]) > 0.2
    assert np.quantile(np.abs(image.rgba - truth.rgba).max(axis=-1), 1 - strays) < 1 / 255


@pytest.mark.parametrize("shape", ["ball", "hollow", "cylinder", "saddle"])
def test_known_curvatures(renderer, shape):
    """Quadratic fields, which cubic B-splines reproduce: balls, a cylinder, and a saddle at its middle."""
    r = 4.0
    field, expected = {
        "ball": (lambda x, y, z: r * r - x * x - y * y - z * z, (1 / r, 1 / r)),
        "hollow": (lambda x, y, z: x * x + y * y + z * z - r * r, (-1 / r, -1 / r)),
        "cylinder": (lambda x, y, z: r * r - x * x - y * y, (1 / r, 0.0)),
        "saddle": (lambda x, y, z: y + 0.1 * (x * x - z * z), (0.2, -0.2)),
    }[shape]
    greatest, least = expected
    wanted = {
        "greatest_curvature": greatest,
        "least_curvature": least,
        "mean_curvature": (greatest + least) / 2,
        "gaussian_curvature": greatest * least,
    }
    for colour_by, number in wanted.items():
        drawn = sampled(field, colour_by=colour_by, low=-0.5, high=0.5, side="both")
        found = number_of(renderer.render(drawn, (40, 40)), -0.5, 0.5)
        at = (20 + 4, 20 - 8) if shape == "saddle" else (slice(10, 30), slice(10, 30))  # the pixel over the origin
        assert np.abs(found[at] - number).max() < 4e-3, colour_by


def test_a_torus(renderer):
    """Gaussian curvature of a torus: cos(v) / (r (R + r cos(v))), positive outside, negative inside."""
    big, small = 5.0, 2.0

    def field(x, y, z):
        return small - np.hypot(np.hypot(x, z) - big, y)

    drawn = sampled(field, half=36, spacing=0.25, colour_by="gaussian_curvature", low=-0.4, high=0.4)
    drawn = al.Scene(
        layers=drawn.layers,
        camera=al.Camera.orthographic(eye=(0, -50, 0), target=(0, 0, 0), height=16),
        background=None,
    )
    image = renderer.render(drawn, (64, 64))
    found = number_of(image, -0.4, 0.4)
    y, x = np.mgrid[:64, :64]
    along = np.hypot((x + 0.5) / 4 - 8, (y + 0.5) / 4 - 8) - big  # r cos(v)
    front = np.abs(along) < 0.85 * small
    truth = along / small / (small * (big + along))
    assert front.sum() > 500
    assert np.abs(found - truth)[front].max() < 0.02


def test_curvature_of_the_reference_in_a_sheared_grid():
    """In the world, whatever the grid."""
    shear = np.array([[1.0, 0.3, 0.0, 2.0], [0.0, 0.8, 0.2, 1.0], [0.0, 0.0, 1.3, -1.0], [0, 0, 0, 1]])
    z, y, x = np.mgrid[-14:15, -14:15, -14:15].astype(np.float64)
    world = np.stack([x, y, z, np.ones_like(x)], axis=-1) @ shear.T
    centre = np.array([2.0, 1.0, -1.0])
    values = 100 - ((world[..., :3] - centre) ** 2).sum(axis=-1)
    matrix = shear.copy()
    matrix[:3, 3] -= shear[:3, :3] @ (14, 14, 14)
    volume = al.Volume(values.astype(np.float32), world_from_index=matrix)
    look = al.Look(field=al.field.BSpline(prefilter=True), gradient="analytic", integrate=al.integrate.FirstHit(iso=60))
    setup = reference.prepare(al.Scene(volume, transfer=GREY, look=look))
    rng = np.random.default_rng(1)
    way = rng.normal(size=(50, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    greatest, least = curvatures(setup, setup.index_of(centre + 4 * way))
    assert np.abs(greatest - 0.25).max() < 2e-3
    assert np.abs(least - 0.25).max() < 2e-3


def test_light_again_keeps_colours(renderer):
    way = al.integrate.FirstHit(iso=70.0, colour_by="mean_curvature")
    drawn = scene(field="linear_exact", integrate=way)
    image = renderer.render(drawn, SIZE, keep_hits=True)
    assert np.abs(renderer.relight(image, drawn).rgba - image.rgba).max() < 1e-4


def test_what_cannot_be_shown():
    with pytest.raises(ValueRangeError, match=r"first_hit\.colours"):
        al.integrate.FirstHit(colour_by="distance", colours="viridos")
    with pytest.raises(ValueRangeError, match="must have a length"):
        al.integrate.FirstHit(colour_by="distance", normal=(0, 0, 0))
    drawn = scene(integrate=al.integrate.FirstHit(iso=70, colour_by="distance", low=9, high=3))
    with pytest.raises(ValueRangeError, match="low is 9, must be below high, 3"):
        al.render(drawn, size=(4, 4))
