"""Slabs between any two values against the float64 reference: one slab a pixel, so that nothing averages out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from scenes import SIZE, scene

import airlight as al
from airlight import reference
from airlight.stages.transfer import CUT_ERROR
from airlight.transfer.tables import ACCURATE, MOST_PIECES, SIZES, slab_light

SLABS = 3000


@dataclass(frozen=True)
class Behind(al.shade.Shade):
    """Light at the back of slabs, none at the front, so that pictures show the back's part alone."""

    name: ClassVar[str] = "behind"
    wgsl: ClassVar[str] = """
import package::sample::{Sample, Lit};

fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit { return Lit(vec3f(here.p_index.y), vec3f(0.0)); }
"""


def kinds() -> dict[str, list[tuple[float, tuple[float, float, float], float]]]:
    """Points of functions that bend sharply; extinctions up to one, values from 0 to 1."""
    rng = np.random.default_rng(7)
    red, blue, green, white = (1.0, 0.0, 0.0), (0.0, 0.1, 1.0), (0.1, 1.0, 0.1), (1.0, 1.0, 1.0)

    def drawn_by_lot(count: int) -> list[tuple[float, tuple[float, float, float], float]]:
        values = [0.0, *np.sort(rng.random(count)), 1.0]
        return [(float(v), tuple(rng.random(3)), float(rng.random())) for v in values]

    peaks = [(0.0, red, 0.0), (1.0, red, 0.0)]
    for place, rgb in ((77, green), (92, blue), (180, white)):  # at numbers that 32 bits hold
        peaks += [((place - 1) / 256, red, 0.0), (place / 256, rgb, 1.0), ((place + 1) / 256, red, 0.0)]
    return {
        "steps": [(0, red, 0), (0.3125, red, 0), (0.3125, red, 0.2), (0.59375, blue, 0.2), (0.59375, white, 1), (1, green, 1)],
        "colours": [(0, red, 1), (0.5, red, 1), (0.5, blue, 1), (1, blue, 1)],
        "peaks": sorted(peaks, key=lambda p: p[0]),
        "random": drawn_by_lot(40),
        "many": drawn_by_lot(300),
    }


def function(kind: str, depth: float, associated: bool = False) -> al.TransferFunction:
    """Associated ones glow with their colour whatever their extinction: as bright as the others at the depth of one."""
    return al.TransferFunction([(v, rgb, depth * e) for v, rgb, e in kinds()[kind]], associated)


def ends(tf: al.TransferFunction) -> np.ndarray:
    """Values (2, n) at fronts and backs: anywhere, and within a few entries of control points, where tables are coarse."""
    rng = np.random.default_rng(11)
    values = rng.random((2, SLABS))
    near = rng.choice(tf.values, SLABS) + rng.normal(0, 1, (2, SLABS)) * 10.0 ** rng.uniform(-4, -2, SLABS)
    apart = rng.choice(tf.values, (2, SLABS)) + rng.normal(0, 1e-3, (2, SLABS))
    found = np.clip(np.concatenate([values, near, apart], axis=1), 0, 1)
    # Where a step lies between closer ones is told by few of 32 bits.
    return found[:, np.abs(found[1] - found[0]) > 2e-4].astype(np.float32)


def slabs(tf: al.TransferFunction, values: np.ndarray, **look) -> tuple[al.Scene, tuple[int, int]]:
    """Scene of which each pixel is one slab of length 1, seen along y."""
    width = 128
    padded = np.pad(values, ((0, 0), (0, -values.shape[1] % width)), mode="wrap").reshape(2, -1, width)
    # Each slab takes three voxels across, so that interpolation finds the very values in the middle one.
    grid = np.repeat(np.repeat(padded.transpose(1, 0, 2), 3, axis=0), 3, axis=2)
    volume = al.Volume(grid)
    rows = len(padded[0])
    middle = (1.5 * width - 0.5, 0, 1.5 * rows - 0.5)
    camera = al.Camera.orthographic(eye=(middle[0], -1, middle[2]), target=middle, up=(0, 0, 1), height=3.0 * rows)
    look = {"field": "linear_exact", "shade": "none"} | look
    return al.Scene(volume, transfer=tf, camera=camera, look=al.Look(**look), background=None), (width, rows)


def error(renderer: al.Renderer, tf: al.TransferFunction, **look) -> tuple[float, dict]:
    """Greatest error of the slabs of a function, and what the layer's statistics say."""
    drawn, size = slabs(tf, ends(tf), **look)
    image = renderer.render(drawn, size, driver=al.driver.March(curved=False))
    truth = reference.render(drawn, size)
    assert image.stats["samples"] <= 2 * size[0] * size[1]  # one slab a ray
    return float(np.abs(image.rgba - truth.rgba).max()), image.stats["layers"][0]


@pytest.mark.parametrize("depth", [3.0, 10.0, 40.0])
@pytest.mark.parametrize("kind", kinds())
def test_deep_slabs_of_functions_that_bend_sharply(either_renderer, kind, depth):
    """Where no table is accurate slabs are cut at control points."""
    found, known = error(either_renderer, function(kind, depth))
    assert known["stages"]["transfer"] == "preintegrated_exact"
    assert found < CUT_ERROR < ACCURATE
    assert known["errors"]["transfer: colour of a slab"] == pytest.approx(CUT_ERROR, rel=0.1)


@pytest.mark.parametrize("kind", ["steps", "peaks", "random"])
def test_tables_are_not_accurate_there(renderer, kind):
    """What the choice is for: the same slabs from the largest of the usual tables."""
    found, known = error(renderer, function(kind, 40.0), transfer=al.transfer.PreIntegrated(entries=SIZES[-1]))
    assert known["stages"]["transfer"] == "preintegrated"
    assert found > 10 * ACCURATE


@pytest.mark.parametrize("depth", [1e-6, 1e-2, 0.3, 3.0, 1e3, 1e6])
@pytest.mark.parametrize("associated", [False, True])
@pytest.mark.parametrize("kind", ["steps", "peaks", "random"])
def test_cut_slabs_of_any_depth(renderer, kind, associated, depth):
    found, _ = error(renderer, function(kind, depth, associated), transfer="preintegrated_exact")
    assert found < CUT_ERROR


@pytest.mark.parametrize("value", [-3.0, 5.0])
@pytest.mark.parametrize("transfer", ["preintegrated_exact", "preintegrated", "preintegrated_fast", "postclassified"])
@pytest.mark.parametrize("side", [-1, 1])
def test_slabs_of_one_value_beyond_a_step_at_the_very_end(renderer, side, transfer, value):
    """A function that begins or ends with a step holds something else beyond it, also where nothing changes along the ray."""
    points = [(0.0, "red", 0.0), (0.0, "red", 1.0), (1.0, "blue", 1.0), (1.0, "blue", 0.3)]
    if side > 0:
        points = [(1 - v, rgb, e) for v, rgb, e in reversed(points)]
    volume = al.Volume(np.full((4, 5, 6), value, dtype=np.float32))
    look = al.Look(shade="none", transfer=transfer)
    drawn = al.Scene(volume, transfer=al.TransferFunction(points), camera="iso", look=look, background=None)
    for skip in ("auto", "none"):
        assert np.abs(renderer.render(drawn, (12, 10), skip=skip).rgba - reference.render(drawn, (12, 10)).rgba).max() < 1e-5


@pytest.mark.parametrize("depth", [3.0, 40.0])
@pytest.mark.parametrize("lighting", ["sampled", "interpolated"])
@pytest.mark.parametrize("kind", ["steps", "random"])
def test_cut_slabs_tell_where_light_comes_from(either_renderer, kind, lighting, depth):
    """The two ends of a slab are lit by different lights: their slopes differ."""
    tf = function(kind, depth)
    points = [(40 + 70 * v, rgb, e) for v, rgb, e in tf.points]
    drawn = scene(camera="orthographic", lighting=lighting, field="linear_exact")
    layer = drawn.layers[0]
    drawn = al.Scene(
        layer.volume,
        transfer=al.TransferFunction(points),
        camera=drawn.camera,
        look=layer.look,
        lights=drawn.lights,
        background=None,
    )
    image, truth = either_renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert image.stats["layers"][0]["stages"]["transfer"] == "preintegrated_exact"
    assert np.abs(image.rgba - truth.rgba).max() < ACCURATE


def gentle(depth: float) -> al.TransferFunction:
    points = [(0, (1, 0, 0), 0), (0.4, (0, 1, 0.2), 0.5), (1, (1, 1, 1), 1)]
    return al.TransferFunction([(v, rgb, depth * e) for v, rgb, e in points])


@pytest.mark.parametrize(
    ("tf", "entries"),
    [(gentle(0.3), 128), (function("peaks", 0.03), 256)]
    + [(function(kind, depth), 0) for kind, depth in (("peaks", 0.3), ("steps", 0.3), ("random", 3.0))],
    ids=["gentle", "thin peaks", "peaks", "steps", "random"],
)
def test_ends_of_slabs_get_their_parts(any_renderer, tf, entries):
    """Shares want larger tables than colours do, and none where they are lost between entries of any."""
    values = ends(tf)
    drawn, size = slabs(tf, values, shade=Behind(), lighting="interpolated")
    image = any_renderer.render(drawn, size, driver=al.driver.March(curved=False))
    known = image.stats["layers"][0]
    assert known["stages"]["transfer"] == ("preintegrated" if entries else "preintegrated_exact")
    assert known["tables"].get("transfer.slabs", [2, 0])[:2] == [2, entries]
    light, moment = slab_light(tf, *values.astype(np.float64), 1.0)
    seen = image.rgba[::-1].reshape(-1, 4)[: len(light)]
    assert np.abs(seen[:, 3] - light[:, 3]).max() < CUT_ERROR
    assert np.abs(seen[:, :3] - moment[:, :3]).max() < (1.2 * ACCURATE if entries else CUT_ERROR)
    assert known["errors"]["transfer: colour of a slab"] <= ACCURATE


@pytest.mark.parametrize("shade", [al.shade.NoShade(), Behind()])
def test_the_error_of_slabs_shorter_than_the_table_s_is_told(renderer, shade):
    """The first slab of a ray is shorter than a step; tables of more lengths know it better."""
    tf = gentle(10.0)
    values = ends(tf)
    light, moment = slab_light(tf, *values.astype(np.float64), 1.0)
    seen, told = [], []
    for lengths in (1, 8):
        table = al.transfer.PreIntegrated(entries=512, lengths=lengths)
        drawn, size = slabs(tf, values, shade=shade, lighting="interpolated", transfer=table)
        image = renderer.render(drawn, size, step=2.0, driver=al.driver.March(curved=False))
        rgb = image.rgba[::-1].reshape(-1, 4)[: len(light), :3]
        seen.append(np.abs(rgb - (moment if shade.lit else light)[:, :3]).max())
        told.append(image.stats["layers"][0]["errors"]["transfer: colour of a shorter slab"])
    assert seen[0] / 2 < told[0] < 2 * seen[0]
    assert seen[1] < told[1] < told[0] / 2


@pytest.mark.parametrize("refine", ["none", "bisection"])
def test_surfaces_in_a_medium_that_is_cut(any_renderer, refine):
    tf = function("steps", 10.0)
    points = [(40 + 70 * v, rgb, e) for v, rgb, e in tf.points]
    surfaces = [al.Surface(85, "gold", 0.5, "blue", 0.3)]
    base = scene(shade="none", field="linear_exact")
    drawn = al.Scene(
        base.layers[0].volume,
        transfer=al.TransferFunction(points, surfaces=surfaces),
        camera=base.camera,
        look=base.layers[0].look,
        background=None,
    )
    driver = al.driver.March(refine=refine)
    image = any_renderer.render(drawn, SIZE, driver=driver)
    assert image.stats["layers"][0]["stages"]["transfer"].startswith("preintegrated_exact_")
    assert np.abs(image.rgba - reference.render(drawn, SIZE, refine=refine).rgba).max() < 2 * ACCURATE


def chosen(tf: al.TransferFunction, **transfer) -> str:
    drawn, _ = slabs(tf, np.zeros((2, 1), np.float32), transfer=al.transfer.PreIntegrated(**transfer))
    return al.render(drawn, (1, 1)).stats["layers"][0]["stages"]["transfer"]


def test_tables_stay_where_they_are_accurate_or_asked_for():
    smooth = al.TransferFunction([(0, "black", 0), (0.4, "red", 0.5), (1, "white", 2)])
    assert chosen(smooth) == "preintegrated"
    assert chosen(function("steps", 10.0)) == "preintegrated_exact"
    assert chosen(function("steps", 10.0), entries=256) == "preintegrated"
    rng = np.random.default_rng(1)
    lots = np.linspace(0, 1, MOST_PIECES + 2)
    assert chosen(al.TransferFunction([(v, tuple(rng.random(3)), 10 * rng.random()) for v in lots])) == "preintegrated"
