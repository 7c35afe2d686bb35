"""Surfaces of the transfer function where the field has their value: closed forms, parity, large steps."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SIZE, blobs, function
from test_surfaces import FUNCTIONS, IN_MEDIUM, ONE, TEN, compare, with_function

import airlight as al
from airlight import Surface, reference
from airlight.errors import StageError

RADII = (12.0, 7.0)
OUTER = Surface(200 - RADII[0] ** 2, (1, 0.5, 0.2), 0.3, back_colour=(0.1, 0.2, 0.9), back_opacity=0.2)
INNER = Surface(200 - RADII[1] ** 2, (0.2, 0.9, 0.3), 0.4, back_colour=(0.9, 0.1, 0.8), back_opacity=0.5)


def ball() -> al.Volume:
    """A quadratic field, 200 - r^2, which interpolating cubic B-splines reproduce away from the border."""
    z, y, x = np.mgrid[-24:25, -24:25, -24:25].astype(np.float64)
    return al.Volume((200 - x * x - y * y - z * z).astype(np.float32), origin=(-24, -24, -24))


def shells(lit: bool, medium: float = 0.0) -> tuple[al.Scene, np.ndarray]:
    """Two translucent shells seen along y, and how far from the axis each pixel lies."""
    points = [(-2000, (0.3, 0.3, 0.3), 0.0), (OUTER.value, (0.3, 0.3, 0.3), 0.0), (OUTER.value, (0.3, 0.3, 0.3), medium)]
    tf = al.TransferFunction([*points, (300, (0.3, 0.3, 0.3), medium)], surfaces=[OUTER, INNER])
    shade = al.shade.BlinnPhong(ambient=0.1, diffuse=0.9, specular=0.0) if lit else "none"
    look = al.Look(field=al.field.BSpline(prefilter=True), gradient="analytic", shade=shade)
    camera = al.Camera.orthographic(eye=(0, -100, 0), target=(0, 0, 0), height=20)
    y, x = np.mgrid[:40, :40]
    off = np.hypot((x + 0.5 - 20) / 2, (y + 0.5 - 20) / 2)
    return al.Scene(ball(), transfer=tf, camera=camera, look=look, background=None), off


def closed_form(off: np.ndarray, lit: bool, medium: float) -> tuple[np.ndarray, np.ndarray]:
    """Colours, and distances at which opacity passes one half, of the shells along rays at distances from the axis."""
    half = [np.sqrt(np.maximum(radius**2 - off**2, 0)) for radius in RADII]
    places = [-half[0], -half[1], half[1], half[0]]
    sides = [OUTER.front, INNER.front, INNER.back, OUTER.back]
    met = [off < RADII[0], off < RADII[1], off < RADII[1], off < RADII[0]]
    rgb, through, depth = np.zeros((*off.shape, 3)), np.ones_like(off), np.full_like(off, np.inf)
    begin = places[0]
    for place, (colour, opacity), there, radius in zip(places, sides, met, (*RADII, *RADII[::-1]), strict=True):
        way = np.where(there, place - begin, 0.0)
        clear = np.exp(-medium * way)
        rgb += (through * (1 - clear))[..., None] * 0.3
        depth = np.where(
            np.isinf(depth) & (through > 0.5) & (through * clear <= 0.5), begin + np.log(2 * through) / max(medium, 1e-9), depth
        )
        through = through * clear
        light = 0.1 + 0.9 * np.abs(place) / radius if lit else np.ones_like(off)
        alpha = np.where(there, opacity, 0.0)
        rgb += (through * alpha * light)[..., None] * colour
        depth = np.where(np.isinf(depth) & (through * (1 - alpha) <= 0.5), place, depth)
        through = through * (1 - alpha)
        begin = np.where(there, place, begin)
    return np.concatenate([rgb, (1 - through)[..., None]], axis=-1), depth + 100


@pytest.mark.parametrize("step", [0.7, 5.0])
@pytest.mark.parametrize(("lit", "medium"), [(False, 0.0), (True, 0.0), (False, 0.05)])
def test_shells_of_a_ball(either_renderer, lit, medium, step):
    """Light at the very hits, colours of both sides, the medium between them, depth: in closed form at any step."""
    drawn, off = shells(lit, medium)
    # Values that are put right for curvature would move the edge of the fog in the slabs beside the shells.
    image = either_renderer.render(drawn, (40, 40), step=step, driver=al.driver.March(refine="secant", curved=False))
    rgba, depth = closed_form(off, lit, medium)
    # A chord that is shorter than a step may fall between two samples.
    sure = (np.abs(off - RADII[1]) > 1.0 + 0.02 * step**2) & (off < RADII[0] - 0.8)
    assert sure.mean() > 0.5
    assert np.abs(image.rgba - rgba)[sure].max() < 2e-3
    assert (np.isfinite(depth) == np.isfinite(image.depth))[sure].all()
    both = sure & np.isfinite(depth)
    assert both.sum() > 100
    assert np.abs(image.depth[both] - depth[both]).max() < 0.02


@pytest.mark.parametrize("refine", ["bisection", "secant", "exact"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_parity(either_renderer, name, refine):
    compare(either_renderer, with_function(FUNCTIONS[name]), step=2.5, refine=refine, strays=0.002)


@pytest.mark.parametrize("transfer", ["preintegrated_fast", "preintegrated_exact"])
@pytest.mark.parametrize("name", ["in a medium", "associated"])
def test_parity_of_media(renderer, name, transfer):
    compare(renderer, with_function(FUNCTIONS[name], transfer=transfer), step=1.5, refine="bisection", strays=0.002)


@pytest.mark.parametrize("modulation", ["change", "gradient_magnitude"])
def test_parity_of_what_is_thinned(renderer, modulation):
    compare(renderer, with_function(TEN, modulation=modulation, gradient="central"), refine="bisection", strays=0.002)


@pytest.mark.parametrize("name", ["ten", "in a medium"])
def test_gaps_hold_no_surface(any_renderer, name):
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    compare(any_renderer, with_function(FUNCTIONS[name], volume), step=1.5, refine="secant", strays=0.005)


@pytest.mark.parametrize("lighting", ["interpolated", "averaged"])
@pytest.mark.parametrize("name", ["ten", "in a medium"])
def test_light_kept_of_ends(either_renderer, name, lighting):
    """What is known of how ends are lit goes on from surface to surface."""
    compare(either_renderer, with_function(FUNCTIONS[name], lighting=lighting), step=2.5, refine="bisection", strays=0.002)


@pytest.mark.parametrize("integrate", ["weighted_sum", "xray", "first_hit"])
def test_other_integrals(renderer, integrate):
    way = al.integrate.FirstHit(iso=62.0) if integrate == "first_hit" else integrate
    compare(renderer, with_function(IN_MEDIUM, integrate=way, shade="none"), refine="bisection", strays=0.002)


COLOURS = "transfer: colour of a slab with several surfaces"


@pytest.mark.parametrize("name", ["one", "in a medium"])
def test_large_steps(renderer, name):
    """At steps of five voxels all that is not missed between two samples is where it is, and lit as it is."""
    drawn = with_function(FUNCTIONS[name])
    truth = reference.converged(drawn, SIZE, step=1 / 8).rgba
    straight, sharp = (
        np.abs(renderer.render(drawn, SIZE, step=5.0, driver=al.driver.March(refine=r)).rgba - truth).max(axis=-1)
        for r in ("none", "bisection")
    )
    seen = truth[..., 3] > 0
    factor = 0.02 if name == "one" else 0.85
    for quantile in (0.75, 0.9):
        assert np.quantile(sharp[seen], quantile) < factor * np.quantile(straight[seen], quantile)


@pytest.mark.parametrize("name", ["one", "in a medium"])
def test_large_steps_miss_no_thin_pin(renderer, name):
    """A pin thinner than a step is met by rays that cross it, since blocks that hold it are sampled."""
    field = np.full((24, 24, 24), 40.0, dtype=np.float32)
    field[:, 12, 12] = 110
    tf = FUNCTIONS[name]
    camera = al.Camera.orthographic(eye=(-20, 12, 12), target=(12, 12, 12), height=24)
    drawn = al.Scene(al.Volume(field), transfer=tf, camera=camera, look=al.Look(shade="none"), background=None)
    small, large = (renderer.render(drawn, SIZE, step=step).rgba[..., 3] for step in (0.25, 7.3))
    blind = renderer.render(drawn, SIZE, step=7.3, driver=al.driver.March(blocks=False)).rgba[..., 3]
    assert (small > 0.01).sum() > 20
    assert np.abs(small - large).mean() < 0.3 * np.abs(small - blind).mean()


def test_skipping_changes_nothing(renderer):
    for tf in FUNCTIONS.values():
        drawn = with_function(tf)
        a, b = (renderer.render(drawn, SIZE, step=2.0, skip=skip).rgba for skip in ("auto", "none"))
        assert np.abs(a - b).max() <= 1e-5


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside"])
def test_rays_that_leap_meet_no_surface(any_renderer, camera):
    """Values below 0, and surfaces between them and 0, where devices begin."""
    volume = al.Volume(blobs().array - 1000, world_from_index=blobs().world_from_index)
    points = [(-1000, "red", 0), (-940, "red", 0), (-920, "red", 0.3), (-890, "white", 0.5)]
    tf = al.TransferFunction(points, surfaces=[Surface(-950.0, "white", 0.5), Surface(-500.0, "white", 0.5)])
    drawn = with_function(tf, volume, camera, shade="none")
    whole = any_renderer.render(drawn, SIZE, skip="none").rgba
    for driver in (al.driver.March(), al.driver.Shells(group=4)):
        assert np.abs(any_renderer.render(drawn, SIZE, driver=driver).rgba - whole).max() <= 1e-5


def test_what_is_drawn_is_told(renderer):
    """Tables of runs have no part in it, and what they cost is no error of it."""
    many = function().with_surfaces([Surface(float(v), "white", 0.08) for v in range(75)])
    image = renderer.render(with_function(many), SIZE)
    layer = image.stats["layers"][0]
    assert layer["stages"]["transfer"] == "preintegrated_sharp_surfaces"
    assert "transfer.pairs" not in layer["tables"]
    assert COLOURS not in layer["errors"]
    compare(renderer, with_function(many), step=2.5, refine="bisection", strays=0.002)


def test_roots_of_cubics_are_for_trilinear_fields(renderer):
    with pytest.raises(StageError, match="trilinear"):
        renderer.render(with_function(ONE, field="bspline"), SIZE, driver=al.driver.March(refine="exact"))


def test_programs_without_surfaces_hold_nothing_of_them(renderer):
    plain, cut = (renderer.explain(with_function(tf), SIZE).linked.text for tf in (function(), TEN))
    assert "number_of" not in plain
    assert "number_of" in cut
