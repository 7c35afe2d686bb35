"""Iso-surfaces without geometry: hits against the reference and closed forms, blocks of voxels, thin sheets at large steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, cameras, function, lights, scene
from test_closed_forms import along_y, straight

import airlight as al
from airlight import reference
from airlight.errors import StageError
from airlight.gpu import blocks
from airlight.reference.camera import CAMERAS
from airlight.reference.field import field_value
from airlight.reference.march import span
from airlight.stage import STAGES

REFINES = ["none", "bisection", "secant", "exact"]


def at(iso: float, volume=None, camera="perspective", field="linear_exact", **look) -> al.Scene:
    return scene(volume, camera=camera, field=field, integrate=al.integrate.FirstHit(iso=iso), **look)


def compare(renderer, drawn, step=1.0, strays=0.0, **driver) -> None:
    image = renderer.render(drawn, SIZE, step=step, driver=al.driver.March(**driver))
    truth = reference.render(drawn, SIZE, step=step, **driver)
    met = np.isfinite(truth.depth) & np.isfinite(image.depth)
    assert met.sum() > 50
    assert (np.isfinite(truth.depth) != np.isfinite(image.depth)).mean() <= max(strays, 1e-3)
    error = np.abs(np.where(met, image.depth, 0.0) - np.where(met, truth.depth, 0.0))
    assert np.sort(error.ravel())[: int(met.size * (1 - strays))].max() < 2e-3
    assert np.quantile(np.abs(image.rgba - truth.rgba).max(axis=-1), 1 - strays) < 1 / 255


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("refine", [*REFINES, "cells"])
def test_parity(either_renderer, refine, camera):
    compare(either_renderer, at(70.0, camera=camera), step=2.5, refine=refine, strays=0.002)


@pytest.mark.parametrize("step", [0.4, 1.0, 7.0])
@pytest.mark.parametrize("kept", [True, False])
def test_parity_of_steps(renderer, step, kept):
    compare(renderer, at(60.0), step=step, blocks=kept, strays=0.002)


def test_parity_with_empty_samples(any_renderer):
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    for refine in ("secant", "exact", "cells"):
        compare(any_renderer, at(60.0, volume), step=1.5, refine=refine, strays=0.01)


TWO_COLOURS = al.TransferFunction.from_surfaces([al.Surface(60.0, "gold", back_colour="blue"), al.Surface(90.0, "red")])


@pytest.mark.parametrize("camera", ["perspective", "inside", "cut"])
@pytest.mark.parametrize("side", ["above", "below", "both"])
@pytest.mark.parametrize("tf", [None, TWO_COLOURS], ids=["medium", "surface"])
def test_parity_of_sides(either_renderer, side, camera, tf):
    base = at(60.0, camera=camera)
    layer = base.layers[0]
    look = al.Look(field="linear_exact", integrate=al.integrate.FirstHit(iso=60.0, side=side))
    made = tf or layer.transfer
    drawn = al.Scene(layer.volume, transfer=made, camera=base.camera, look=look, lights=base.lights, background=None)
    compare(either_renderer, drawn, step=1.5, strays=0.003)
    skipped, whole = (either_renderer.render(drawn, SIZE, skip=skip) for skip in ("auto", "none"))
    assert np.quantile(np.abs(skipped.rgba - whole.rgba).max(axis=-1), 0.999) < 1e-3


def test_sides_of_plateaus(renderer):
    """Whole numbers on the very value: at least and at most both hold there; a sheet is met once, from either side."""
    stairs = along_y([0, 0, 3, 3, 5, 5, 3, 3, 0, 0])
    camera = straight(stairs)
    tf = al.TransferFunction.from_surfaces([al.Surface(3.0, "gold", back_colour="blue")])

    def depth_of(side, volume=stairs, iso=3.0):
        look = al.Look(integrate=al.integrate.FirstHit(iso=iso, side=side), shade="none", field="linear_exact")
        drawn = al.Scene(volume, transfer=tf, camera=camera, look=look)
        image = renderer.render(drawn, (1, 1), step=1.7, driver=al.driver.March(refine="bisection"))
        return float(image.depth[0, 0]) - 100, image.rgba[0, 0, :3]

    assert depth_of("above")[0] == pytest.approx(2.0, abs=1e-3)
    assert depth_of("below")[0] == pytest.approx(0.0, abs=1e-3)
    assert depth_of("both")[0] == pytest.approx(2.0, abs=1e-3)
    falling = along_y([5, 5, 3, 3, 0, 0, 0, 0, 0, 0])
    found, rgb = depth_of("below", falling)
    assert found == pytest.approx(2.0, abs=1e-3)
    found, rgb = depth_of("both", falling)
    assert found == pytest.approx(3.0, abs=1.7 / 64)
    assert rgb == pytest.approx([0, 0, 1], abs=1e-5)


@pytest.mark.parametrize("field", ["nearest", "linear"])
def test_parity_of_fields(renderer, field):
    compare(renderer, at(60.0, field=field, shade="none"), strays=0.02)


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("step", [0.5, 1.0, 5.0])
def test_skipping_changes_nothing(renderer, camera, step):
    drawn = at(75.0, camera=camera)
    skipped, whole = (renderer.render(drawn, SIZE, step=step, skip=skip) for skip in ("auto", "none"))
    assert skipped.stats["skip"]["done"] == "blocks"
    assert skipped.stats["samples"] <= (1.0 if camera == "inside" else 0.7) * whole.stats["samples"]
    assert (np.isfinite(skipped.depth) == np.isfinite(whole.depth)).all()
    assert np.abs(skipped.rgba - whole.rgba).max() < 1e-4


@settings(max_examples=15)
@given(seed=st.integers(0, 1000), iso=st.floats(0.05, 0.99), shape=st.tuples(*[st.integers(1, 14)] * 3))
def test_skipping_changes_nothing_in_noise(renderer, seed, iso, shape):
    """Single bright voxels at borders of blocks and of the volume, and axes of one voxel."""
    data = (np.random.default_rng(seed).random(shape) ** 6).astype(np.float32)
    volume = al.Volume(data, spacing=(1.0, 1.3, 0.8))
    drawn = at(iso, volume)
    skipped, whole = (renderer.render(drawn, SIZE, step=2.0, skip=skip) for skip in ("auto", "none"))
    differs = np.isfinite(skipped.depth) != np.isfinite(whole.depth)
    assert differs.mean() < 2e-3  # a grazed voxel may fall to either
    assert np.quantile(np.abs(skipped.rgba - whole.rgba).max(axis=-1), 0.99) < 1 / 255


SINGLE = [name for name in sorted(STAGES["field"]) if name not in ("preclassified", "occupancy")]


@pytest.mark.parametrize("field", [*SINGLE, al.field.BSpline(prefilter=True)], ids=lambda f: getattr(f, "name", f))
def test_skipping_changes_nothing_for_any_field(renderer, field):
    """Blocks know how far a field reaches beyond its samples and how far it overshoots them."""
    drawn = at(100.0, field=field)  # few samples reach it: a field that overshoots has it beside them
    skipped, whole = (renderer.render(drawn, SIZE, skip=skip) for skip in ("auto", "none"))
    assert np.isfinite(whole.depth).any()
    assert (np.isfinite(skipped.depth) != np.isfinite(whole.depth)).mean() < 2e-3
    assert np.quantile(np.abs(skipped.rgba - whole.rgba).max(axis=-1), 0.998) < 1 / 255


def test_roots_of_cubics_are_for_trilinear_fields(renderer):
    with pytest.raises(StageError, match="trilinear"):
        renderer.render(at(60.0, field="nearest"), SIZE, driver=al.driver.March(refine="exact"))


def test_all_cells_are_those_of_blocks(renderer):
    drawn = at(60.0)
    with pytest.raises(StageError, match="looks through blocks"):
        renderer.render(drawn, SIZE, driver=al.driver.March(refine="cells", blocks=False))
    twice = al.Scene(layers=[drawn.layers[0], drawn.layers[0]], camera=drawn.camera, lights=drawn.lights)
    with pytest.raises(StageError, match="use exact"):
        renderer.render(twice, SIZE, driver=al.driver.March(refine="cells"))


def test_exact_roots_are_those_of_the_field(renderer):
    """Every hit is a root of the trilinear field, of whatever sheet; halving leaves more of the way at steps of five voxels."""
    noise = al.Volume(np.random.default_rng(4).random((12, 13, 14)).astype(np.float32), spacing=(1.0, 1.2, 0.9))
    drawn = at(0.8, noise, "orthographic", shade="none")
    setup = reference.prepare(drawn)
    worst = {}
    for refine in ("bisection", "exact"):
        depth = renderer.render(drawn, SIZE, step=5.0, driver=al.driver.March(refine=refine)).depth
        y, x = np.nonzero(np.isfinite(depth))
        origin, direction = CAMERAS["orthographic"](drawn.camera, SIZE, x, y)
        inside = depth[y, x] > span(setup, origin, direction)[0] + 1e-3
        value, _ = field_value(setup, setup.index_of(origin + depth[y, x, None].astype(float) * direction))
        assert inside.sum() > 200
        worst[refine] = np.abs(value - 0.8)[inside].max()
    assert worst["exact"] < 2e-5 < 1e-4 < worst["bisection"]


def test_another_iso_value_is_another_surface(renderer):
    """Leaps follow the value that is looked for, on one volume."""
    found = [np.isfinite(renderer.render(at(iso), SIZE).depth).sum() for iso in (50.0, 90.0, 50.0, 70.0)]
    assert found[0] == found[2] > found[3] > found[1] > 0


def test_six_bisections_leave_a_64th(renderer):
    """A bend inside of the last bracket, which the straight line through it misses by more than half of its width.

    Samples lie at 12.1 and 28.1: six halvings leave [19.85, 20.1], five leave [19.6, 20.1], and the surface is just behind 20.
    """
    y, step, iso = np.arange(33.0), 16.0, 0.5
    volume = along_y(100 * np.maximum(y - 20, 0))
    x, _, z = volume.corners_world().mean(axis=0)
    drawn = al.Scene(
        volume,
        transfer=al.TransferFunction([(0, "white", 0), (100, "white", 1)]),
        camera=al.Camera.orthographic(eye=(x, -99.9, z), target=(x, 16, z), height=0.1),
        look=al.Look(integrate=al.integrate.FirstHit(iso=iso), shade="none", field="linear_exact"),
    )
    driver = al.driver.March(refine="bisection", blocks=False)
    error = 20.005 + 99.9 - renderer.render(drawn, (1, 1), step=step, driver=driver).depth[0, 0]
    assert step / 128 < error <= step / 64


def test_refinements_of_a_parabola(renderer):
    """A straight line between samples errs; what is sharpened errs less, each way within its bound."""
    y = np.arange(33.0)
    volume = along_y((y / 32) ** 2 * 100)
    # Within a voxel the field is straight, so the truth is piecewise linear.
    iso, truth = 30.0, np.interp(30.0, (y / 32) ** 2 * 100, y)
    drawn = al.Scene(
        volume,
        transfer=al.TransferFunction([(0, "white", 0), (100, "white", 1)]),
        camera=straight(volume),
        look=al.Look(integrate=al.integrate.FirstHit(iso=iso), shade="none", field="linear_exact"),
    )
    step = 16.0
    error = {}
    for refine in REFINES:
        driver = al.driver.March(refine=refine, blocks=False)
        error[refine] = abs(renderer.render(drawn, (1, 1), step=step, driver=driver).depth[0, 0] - 100 - truth)
    assert error["none"] > step / 64
    assert error["bisection"] <= step / 64
    assert error["secant"] <= 1e-2
    assert error["exact"] <= 1e-3


def test_the_first_of_several_roots_in_a_step(renderer):
    """Two sheets within one step: where all cells are looked through the root is that of the first."""
    values = np.zeros(40)
    values[[14, 17]] = 10.0
    values[18:] = 10.0
    volume = along_y(values)
    drawn = al.Scene(
        volume,
        transfer=al.TransferFunction([(0, "white", 0), (10, "white", 1)]),
        camera=straight(volume),
        look=al.Look(integrate=al.integrate.FirstHit(iso=5.0), shade="none", field="linear_exact"),
    )
    image = renderer.render(drawn, (1, 1), step=10.0, driver=al.driver.March(refine="cells"))
    assert image.depth[0, 0] == pytest.approx(113.5, abs=1e-3)


def first_roots(drawn: al.Scene) -> np.ndarray:
    """Distances (h, w) at which rays first pass the value on the way up, from the field in steps of a hundredth of a voxel."""
    setup = reference.prepare(drawn)
    y, x = np.mgrid[: SIZE[1], : SIZE[0]].reshape(2, -1)
    origin, direction = CAMERAS[drawn.camera.name](drawn.camera, SIZE, x, y)
    enter, leave = span(setup, origin, direction)
    found = np.full(len(x), np.inf)
    t, begins_before = enter.copy(), None
    while (t < leave).any():
        value, _ = field_value(setup, setup.index_of(origin + t[:, None] * direction))
        begins_before = value < setup.stages["integrate"].iso if begins_before is None else begins_before
        found = np.where(np.isinf(found) & (t < leave) & (value >= setup.stages["integrate"].iso), t, found)
        t += 0.01 * setup.spacing_world
    return np.where(begins_before, found, np.nan).reshape(SIZE[::-1])


@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
def test_cells_leave_out_no_sheet(renderer, camera):
    """Noise from voxel to voxel, whose peaks between samples are met for less than a voxel, at steps of five voxels."""
    noise = al.Volume(np.random.default_rng(4).random((12, 13, 14)).astype(np.float32), spacing=(1.0, 1.2, 0.9))
    drawn = at(0.8, noise, camera, shade="none")
    truth = first_roots(drawn)
    known = np.isfinite(truth)
    depths = {r: renderer.render(drawn, SIZE, step=5.0, driver=al.driver.March(refine=r)).depth for r in ("bisection", "cells")}
    wrong = {r: (np.abs(np.where(np.isfinite(d), d, 1e9) - truth) > 0.02)[known].mean() for r, d in depths.items()}
    assert known.mean() > 0.1
    assert wrong["bisection"] > 0.1
    assert wrong["cells"] < 2e-3  # what is met for less than a hundredth of a voxel is not in the truth
    compare(renderer, drawn, step=5.0, refine="cells", strays=0.004)


def test_cells_beside_empty_samples(renderer):
    """What is empty counts as what lies before the surface, also within the cell where it begins."""
    rng = np.random.default_rng(3)
    noise = rng.random((12, 13, 14)).astype(np.float32)
    noise[rng.random(noise.shape) < 0.15] = np.nan
    drawn = at(0.8, al.Volume(noise, spacing=(1.0, 1.2, 0.9)), "orthographic", shade="none")
    image = renderer.render(drawn, SIZE, driver=al.driver.March(refine="cells"))
    truth = reference.render(drawn, SIZE, refine="cells")
    assert np.isfinite(truth.depth).sum() > 400
    assert (np.abs(image.rgba - truth.rgba).max(axis=-1) > 1 / 255).sum() <= 1


def test_thin_sheets_are_found_at_large_steps(renderer):
    """A sheet of one voxel, looked at along the diagonal, at steps of five voxels."""
    data = np.zeros((40, 40, 40), dtype=np.float32)
    data[:, 21, :] = 100
    volume = al.Volume(data)
    camera = al.Camera.orthographic(eye=(19.5, -60, 19.5), target=(19.5, 20, 19.5), height=30)
    tf = al.TransferFunction([(0, "white", 0), (100, "white", 1)])
    look = al.Look(integrate=al.integrate.FirstHit(iso=30.0), shade="none", field="linear_exact")
    drawn = al.Scene(volume, transfer=tf, camera=camera, look=look)
    found = {
        kept: np.isfinite(renderer.render(drawn, (24, 24), step=5.0, driver=al.driver.March(blocks=kept)).depth).mean()
        for kept in (True, False)
    }
    assert found[True] == 1.0
    assert found[False] == 0.0


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), size=st.tuples(*[st.integers(1, 9)] * 3), share=st.floats(0.0, 0.2))
def test_leaps_are_distances(seed, size, share):
    """Against the distances to all blocks that count."""
    rng = np.random.default_rng(seed)
    high = (rng.random(size) < share).astype(np.float32)
    found = blocks.leaps(high > 0)
    active = np.argwhere(high > 0)
    places = np.argwhere(np.ones(size))
    far = (
        np.full(len(places), blocks.MOST_LEAP) if not len(active) else np.abs(places[:, None] - active).max(axis=2).min(axis=1)
    )
    assert np.array_equal(found.ravel(), np.minimum(far, blocks.MOST_LEAP))


def test_blocks_and_steps_converge_to_one_picture(renderer):
    camera = cameras(blobs())["perspective"]
    look = al.Look(integrate=al.integrate.FirstHit(iso=65.0), field="linear_exact")
    drawn = al.Scene(blobs(), transfer=function(), camera=camera, look=look, lights=lights(), background=None)
    fine, coarse = (renderer.render(drawn, SIZE, step=step) for step in (0.25, 5.0))
    met = np.isfinite(fine.depth)
    assert (met == np.isfinite(coarse.depth)).mean() > 0.997
    both = met & np.isfinite(coarse.depth)
    assert np.quantile(np.abs(fine.depth[both] - coarse.depth[both]), 0.99) < 0.02
