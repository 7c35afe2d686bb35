"""Surfaces of equal value: parity with the reference, closed forms, and the laws that they keep."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SIZE, blobs, function, scene
from test_closed_forms import STEPS, along_y, straight

import airlight as al
from airlight import Surface, reference
from airlight.errors import LimitError, StageError

ONE = al.TransferFunction.from_surfaces([Surface(70, "gold", 0.4, back_colour="red", back_opacity=0.8)])
TWO = al.TransferFunction.from_surfaces([Surface(45, "skyblue", 0.3), Surface(90, "white", 1.0, "purple")])
TEN = al.TransferFunction.from_surfaces(
    Surface(v, (v / 120, 0.5, 1 - v / 120), 0.25, (1, 0.1, 0.1), 0.1) for v in np.linspace(15, 115, 10)
)
IN_MEDIUM = function().with_surfaces(
    # Below and above the function's axis, on a control point, and within.
    [Surface(30, "white", 0.2), Surface(62, "red", 0.5, "blue", 0.3), Surface(80, "lime", 0.4), Surface(118, "gold", 0.9)]
)
STEP_THERE = al.TransferFunction(
    [(60, (1, 1, 1), 0), (60, (0.2, 0.4, 1), 0.4), (90, (1, 0.3, 0.1), 0.4), (90, (1, 1, 1), 0)],
    surfaces=[Surface(60, "white", 0.3), Surface(90, "lime", 0.2)],
)
GLOW = al.TransferFunction(
    [(40, (0, 0, 0), 0), (70, (0.02, 0.01, 0), 0), (110, (0.1, 0, 0.05), 0.4)], True, [Surface(60, "white", 0.3), Surface(75)]
)
STRAIGHT = al.driver.March(refine="none")
FUNCTIONS = {"one": ONE, "two": TWO, "ten": TEN, "in a medium": IN_MEDIUM, "at steps": STEP_THERE, "associated": GLOW}


def with_function(tf, volume=None, camera="perspective", field="linear_exact", **look) -> al.Scene:
    """The scene of all parity tests with another function; core devices filter no 32-bit floats, so the field is exact."""
    look["field"] = field
    base = scene(volume, camera=camera, **look)
    layer = base.layers[0]
    return al.Scene(layer.volume, transfer=tf, camera=base.camera, look=layer.look, lights=base.lights, background=None)


def compare(
    renderer, drawn: al.Scene, step: float = 1.0, tolerance: float = 1 / 255, strays: float = 0.0, refine: str = "none"
) -> None:
    """By straight lines unless told: what is found one by one is in ``test_crossings.py``."""
    image = renderer.render(drawn, SIZE, step=step, driver=al.driver.March(refine=refine))
    truth = reference.render(drawn, SIZE, step=step, refine=refine)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    assert error[: error.size - int(strays * error.size)].max() <= tolerance
    met = np.isfinite(truth.depth)
    assert (np.isfinite(image.depth) == met).mean() > 0.998
    both = met & np.isfinite(image.depth)
    if both.any():
        assert np.quantile(np.abs(image.depth[both] - truth.depth[both]), 0.98) < 5e-3


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_parity(either_renderer, name, camera):
    compare(either_renderer, with_function(FUNCTIONS[name], camera=camera, shade="none"))


@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_lit_parity(either_renderer, name, camera):
    compare(either_renderer, with_function(FUNCTIONS[name], camera=camera))


@pytest.mark.parametrize("name", ["one", "two", "ten"])
def test_lit_parity_inside(renderer, name):
    compare(renderer, with_function(FUNCTIONS[name], camera="inside"), step=2.0)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_parity_of_the_fast_stage(any_renderer, name):
    compare(any_renderer, with_function(FUNCTIONS[name], transfer="preintegrated_fast", shade="none"))


@pytest.mark.parametrize("step", [0.3, 2.5, 7.0])
@pytest.mark.parametrize("name", ["ten", "in a medium", "at steps"])
def test_several_in_one_slab(renderer, name, step):
    """Steps so large that slabs cross many surfaces: blended in order, the medium between them attenuated."""
    drawn = with_function(FUNCTIONS[name], shade="none")
    error = renderer.render(drawn, SIZE, step=step, driver=STRAIGHT).stats["layers"][0]["errors"]
    compare(renderer, drawn, step=step, tolerance=1 / 255 + sum(error.values()))


@pytest.mark.parametrize("lighting", ["sampled", "supersampled", "unlit"])
def test_lighting(renderer, lighting):
    compare(renderer, with_function(TEN, lighting=lighting), step=2.5)


@pytest.mark.parametrize("transfer", ["preintegrated", "preintegrated_fast"])
@pytest.mark.parametrize("field", ["nearest", "linear", "linear_exact"])
def test_values_of_samples(either_renderer, field, transfer):
    """Whole numbers, and surfaces on them: neither lost nor doubled, on plateaus and ramps, seen from both sides."""
    stairs = np.round(blobs().array / 10).astype(np.uint8)
    volume = al.Volume(stairs, world_from_index=blobs().world_from_index)
    tf = al.TransferFunction.from_surfaces([Surface(v, (1, v / 12, 0.5), 0.3, "blue", 0.2) for v in (3, 5, 6, 9)])
    # A ray along the border of two voxels may fall to either.
    compare(either_renderer, with_function(tf, volume, field=field, transfer=transfer, shade="none"), strays=0.01)


def test_gaps_hold_no_surface(any_renderer):
    """NaN in the middle: no surface between what is known and what is not."""
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    compare(any_renderer, with_function(TEN, al.Volume(holed, world_from_index=blobs().world_from_index), shade="none"))


def rgba_along(renderer, values, tf, step=1.0, field="linear_exact", **look):
    volume = along_y(values)
    look = al.Look(shade="none", field=field, **look)
    drawn = al.Scene(volume, transfer=tf, camera=straight(volume), look=look, background=None)
    image = renderer.render(drawn, (1, 1), step=step)
    return image.rgba[0, 0], float(image.depth[0, 0])


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("value", [0.5, 3.0, 4.123, 9.999, 10.0])
def test_opacity_counts_once_whatever_the_step(either_renderer, step, value):
    """A ramp is crossed once: alpha is the opacity, and the depth is where the ramp has the value."""
    tf = al.TransferFunction.from_surfaces([Surface(value, (1, 0.5, 0.25), 0.6, (0, 0, 1), 0.7)])
    up, up_depth = rgba_along(either_renderer, np.linspace(0, 10, 11), tf, step)
    assert up == pytest.approx([0.6, 0.3, 0.15, 0.6], abs=1e-6)
    assert up_depth == pytest.approx(100 + value, abs=1e-3)
    down, down_depth = rgba_along(either_renderer, np.linspace(10, 0, 11), tf, step)
    assert down == pytest.approx([0, 0, 0.7, 0.7], abs=1e-6)
    assert down_depth == pytest.approx(110 - value, abs=1e-3)


def test_where_the_domain_begins(renderer):
    """A ray that begins on the value is inside already; one that begins below it and ends on it has crossed it."""
    tf = al.TransferFunction.from_surfaces([Surface(5, "white", 0.5)])
    alphas = {name: rgba_along(renderer, line, tf)[0][3] for name, line in LINES.items()}
    assert alphas == pytest.approx({"rises from it": 0, "falls to it": 0, "rises to it": 0.5, "falls from it": 0.5}, abs=1e-6)


LINES = {
    "rises from it": np.linspace(5, 9, 5),
    "falls to it": np.linspace(9, 5, 5),
    "rises to it": np.linspace(1, 5, 5),
    "falls from it": np.linspace(5, 1, 5),
}


@pytest.mark.parametrize("step", STEPS)
def test_surfaces_in_fog_have_a_closed_form(any_renderer, step):
    """Fog of constant extinction t, two surfaces at depths p and q: the pieces in order."""
    t, p, q = 0.2, 2.5, 6.0
    fog = al.TransferFunction([(0, (0, 0, 1), t)], surfaces=[Surface(p, (1, 0, 0), 0.4), Surface(q, (0, 1, 0), 0.7)])
    rgba, depth = rgba_along(any_renderer, np.linspace(0, 10, 11), fog, step)
    a, b, c = (1 - np.exp(-t * d) for d in (p, q - p, 10 - q))
    behind_p, behind_q = (1 - a) * 0.6, (1 - a) * 0.6 * (1 - b) * 0.3
    expected = [(1 - a) * 0.4, behind_p * (1 - b) * 0.7, a + behind_p * b + behind_q * c]
    assert rgba == pytest.approx([*expected, 1 - behind_q * (1 - c)], abs=1e-4)
    assert depth == pytest.approx(100 + p, abs=1e-3)  # opacity is 0.39 before the surface, and 0.64 behind it


def test_an_opaque_surface_hides_what_is_behind(any_renderer):
    wall = al.TransferFunction.from_surfaces([Surface(v, "red" if v == 40 else "lime", 1.0) for v in (40, 60, 80)])
    image = any_renderer.render(with_function(wall, shade="none"), SIZE, step=6.0)
    seen = image.rgba[..., 3] > 0
    assert seen.mean() > 0.02
    assert image.rgba[seen][:, 3] == pytest.approx(1, abs=1e-6)
    # From below every ray meets 40 first.
    assert image.rgba[seen][:, 1].max() == 0


def test_skipping_changes_nothing(renderer):
    for tf in (ONE, TEN, STEP_THERE):
        drawn = with_function(tf)
        a, b = (renderer.render(drawn, SIZE, step=0.5, skip=skip).rgba for skip in ("auto", "none"))
        assert np.abs(a - b).max() < 1e-5


def test_density_scales_optical_thickness(renderer):
    base = with_function(IN_MEDIUM, shade="none")
    layer = base.layers[0]
    thin = al.Layer(layer.volume, transfer=IN_MEDIUM, look=layer.look, density=0.3)
    drawn = al.Scene(layers=[thin], camera=base.camera, lights=base.lights, background=None)
    compare(renderer, drawn)
    once, thrice = (
        rgba_along(renderer, np.linspace(0, 10, 11), al.TransferFunction.from_surfaces([Surface(4, "white", 0.5)]).scaled(f))[0]
        for f in (1, 3)
    )
    assert 1 - thrice[3] == pytest.approx((1 - once[3]) ** 3, abs=1e-6)


def test_more_than_a_bin_holds(any_renderer):
    """Hundreds of values within a millionth of the range beside one far away, and a thousand at even distances."""
    crowd = al.TransferFunction.from_surfaces(
        [Surface(60 + 1e-4 * n, (n / 100, 1, 0), 0.01) for n in range(100)] + [Surface(1e6)]
    )
    compare(any_renderer, with_function(crowd, shade="none"))
    many = al.TransferFunction.random_surfaces(1, (0, 130), 1024, 0.01)
    compare(any_renderer, with_function(many, shade="none"))


def test_stages_that_draw_none_say_so(renderer):
    with pytest.raises(StageError, match="'postclassified' draws no surfaces of equal value: use preintegrated"):
        renderer.render(with_function(ONE, transfer="postclassified"), SIZE)
    full = function().with_surfaces([Surface(v / 4) for v in range(300)])
    with pytest.raises(LimitError, match="are 300 in a medium, where at most 256 fit"):
        renderer.render(with_function(full), SIZE, driver=STRAIGHT)


def test_statistics_name_the_stage_and_the_error(renderer):
    layer = renderer.render(with_function(IN_MEDIUM), SIZE, driver=STRAIGHT).stats["layers"][0]
    assert layer["stages"]["transfer"] == "preintegrated_surfaces"
    assert 0 < layer["errors"]["transfer: colour of a slab with several surfaces"] < 1e-3
    assert renderer.render(with_function(ONE), SIZE, driver=STRAIGHT).stats["layers"][0]["errors"] == {}


def test_what_thins_a_slab_thins_its_surface(renderer):
    """A modulation multiplies optical thickness, of sheets too; what is opaque stays opaque."""
    for tf in (ONE, TWO):
        compare(renderer, with_function(tf, modulation="change", shade="none"))
    plain, thin = (
        renderer.render(with_function(ONE, modulation=name, shade="none"), SIZE).rgba[..., 3].mean()
        for name in ("none", "change")
    )
    assert thin < 0.9 * plain


@pytest.mark.parametrize("extinction", [0.0, 0.02])
@pytest.mark.parametrize("step", [1.0, 4.0, 11.0])
def test_depth_where_modulation_thins(either_renderer, step, extinction):
    """A ramp of slope 1 counts by half: the second surface, not the first, takes opacity past one half."""
    fog = al.TransferFunction(
        [(-9, (1, 1, 1), extinction), (19, (1, 1, 1), extinction)],
        surfaces=[Surface(3, "white", 0.6), Surface(7, "white", 0.6)],
    )
    modulation = al.modulation.Change(full_at=2.0)
    rgba, depth = rgba_along(either_renderer, np.linspace(0, 10, 11), fog, step, modulation=modulation)
    assert rgba[3] == pytest.approx(1 - 0.4 * np.exp(-extinction * 5), abs=1e-5)
    assert depth == pytest.approx(107, abs=1e-3)


@pytest.mark.parametrize("name", ["ten", "in a medium"])
@pytest.mark.parametrize("modulation", ["change", "gradient_magnitude"])
def test_modulated_parity(renderer, modulation, name):
    compare(renderer, with_function(FUNCTIONS[name], modulation=modulation, gradient="central", shade="none"), step=2.5)
