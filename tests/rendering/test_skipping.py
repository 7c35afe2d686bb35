"""Blocks in which nothing is are passed over, and pixels whose rays meet no other are not drawn: the image stays as it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, cameras, scene

import airlight as al
from airlight.gpu import blocks
from airlight.gpu.tiles import Tile
from airlight.rendering.shown import columns_of, on_image
from airlight.transfer.joint import JointFunction
from airlight.transfer.joint_axes import Axis
from airlight.transfer.joint_shapes import Box

LEVEL = 1 / 255
DENSE = al.TransferFunction([(0, "teal", 0.02), (60, "orange", 0.5)])


def islands(seed: int, count: int, gaps: bool = False) -> al.Volume:
    """Narrow islands in a flat sea, with steep sides and of several heights."""
    rng = np.random.default_rng(seed)
    z, y, x = np.mgrid[:30, :34, :38]
    field = np.zeros(x.shape)
    for centre, radius, height in zip(
        rng.uniform(3, 30, (count, 3)), rng.uniform(1, 4, count), rng.uniform(30, 120, count), strict=True
    ):
        away = np.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2)
        field = np.maximum(field, height * np.clip(2 - away / radius, 0, 1))
    if gaps:
        field[rng.random(field.shape) < 0.02] = np.nan
    matrix = np.diag([1.0, 1.2, 0.9, 1.0])
    matrix[:3, 3] = (4, -3, 7)
    return al.Volume(field.astype(np.float32), world_from_index=matrix)


FUNCTIONS = {
    "hill": al.TransferFunction([(20, "red", 0), (60, "green", 0.8), (110, "white", 0.1)]),
    "steps": al.TransferFunction(
        [(35, "red", 0), (35, "red", 2), (50, "red", 2), (50, "blue", 0), (80, "blue", 0), (90, "white", 3)]
    ),
    "shell": al.TransferFunction([(28, "gold", 0), (30, "gold", 5), (32, "gold", 0)]),
    "glow": al.TransferFunction([(40, (0, 0, 0), 0), (70, (0.3, 0.5, 0.1), 0), (71, (0, 0, 0), 0)], associated=True),
    "surfaces": al.TransferFunction.from_surfaces([al.Surface(25.0, "gold", opacity=0.4), al.Surface(60.0, "red")]),
}


def both(renderer, volume: al.Volume, function: al.TransferFunction, camera: str, step: float = 1.0, **look):
    drawn = al.Scene(volume, transfer=function, camera=cameras(volume)[camera], look=al.Look(**look), background=None)
    return [renderer.render(drawn, SIZE, step=step, skip=skip) for skip in ("auto", "none")]


LOOKS = [{}, {"shade": "none", "field": "linear_exact"}, {"transfer": "postclassified", "field": "nearest"}]
PLACES = (("perspective", "inside"), ("orthographic", "cut"))
# Each look with both kinds of cameras, with gaps and without, in turns: two programs for each of these.
CASES = [
    (name, look, PLACES[(i + j) % 2], (i // 2 + j) % 2 == 1) for i, name in enumerate(FUNCTIONS) for j, look in enumerate(LOOKS)
]


@pytest.mark.parametrize(("name", "look", "places", "gaps"), CASES)
@settings(max_examples=8)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 8),
    outside=st.booleans(),
    step=st.sampled_from([0.7, 1.0, 1.9]),
)
def test_the_image_is_the_same(renderer, name, look, places, gaps, seed, count, outside, step):
    camera = places[0] if outside else places[1]
    if name == "surfaces" and look.get("transfer") == "postclassified":
        look = {"field": "nearest"}
    skipped, whole = both(renderer, islands(seed, count, gaps), FUNCTIONS[name], camera, step, **look)
    assert skipped.stats["skip"]["done"] == "blocks"
    assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL
    met = np.isfinite(whole.depth)
    assert np.mean(met != np.isfinite(skipped.depth)) <= 2e-3
    both_met = met & np.isfinite(skipped.depth)
    assert np.quantile(np.abs(np.where(both_met, skipped.depth, 0) - np.where(both_met, whole.depth, 0)), 0.998) < 0.05


def of_kind(kind: str, seed: int, count: int) -> dict[str, Any]:
    """Volume, function, labels and look of a scene whose blocks are told to be empty in one way or another."""
    volume = islands(seed, count)
    matrix, hill = volume.world_from_index, FUNCTIONS["hill"]
    rng = np.random.default_rng(seed)
    if kind == "channels":
        both = al.Volume(np.stack([volume.array, islands(seed + 1, count).array]), world_from_index=matrix)
        return {"volume": both, "transfer": al.Channels({0: hill, 1: FUNCTIONS["steps"]})}
    if kind in ("sum", "x-ray"):
        integrate = al.integrate.WeightedSum(full=40) if kind == "sum" else al.integrate.XRay(high=30)
        return {"volume": volume, "transfer": hill, "look": {"integrate": integrate}}
    if kind == "gradients":
        noise = rng.uniform(0, 4, volume.array.shape).astype(np.float32)
        shapes = [Box((20, 15), (110, 50), edge=1, colour=(1, 0.5, 0), extinction=2.0)]
        function = JointFunction((Axis("value", 0, 140), Axis("gradient", 0, 60)), shapes)
        return {"volume": al.Volume(40 + noise + volume.array / 2, world_from_index=matrix), "transfer": function}
    cells = np.repeat(np.repeat(np.repeat(rng.integers(0, 5, (3, 3, 3), dtype=np.uint8), 14, 0), 14, 1), 14, 2)[:30, :34, :38]
    labels = al.Volume(np.ascontiguousarray(cells), world_from_index=matrix)
    if kind == "labels alone":
        return {
            "volume": labels,
            "labels": al.Labels(labels, hidden=(0, 1, 4)),
            "transfer": al.TransferFunction([(0.3, "gold", 0), (0.6, "gold", 3)]),
        }
    return {
        "volume": volume,
        "transfer": DENSE if kind == "hidden, dense" else hill,
        "labels": al.Labels(labels, hidden=(0, 1, 2)),
    }


KINDS = ["channels", "gradients", "hidden", "hidden, dense", "labels alone", "sum", "x-ray"]


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=6)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 8),
    camera=st.sampled_from(["perspective", "inside"]),
    step=st.sampled_from([0.7, 1.0, 1.9]),
)
def test_the_image_is_the_same_whatever_tells(renderer, kind, seed, count, camera, step):
    made = of_kind(kind, seed, count)
    look = al.Look(**made.pop("look", {}))
    layer = al.Layer(**made, look=look)
    drawn = al.Scene(layers=[layer], camera=cameras(layer.volume)[camera], background=None)
    skipped, whole = (renderer.render(drawn, SIZE, step=step, skip=skip) for skip in ("auto", "none"))
    assert skipped.stats["skip"]["done"] == "blocks"
    assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL
    met = np.isfinite(whole.depth) & np.isfinite(skipped.depth)
    assert np.mean(np.isfinite(whole.depth) != np.isfinite(skipped.depth)) <= 2e-3
    assert np.quantile(np.abs(np.where(met, skipped.depth, 0) - np.where(met, whole.depth, 0)), 0.998) < 0.05


@pytest.mark.parametrize("kind", KINDS)
def test_fewer_samples_whatever_tells(renderer, kind):
    layer = al.Layer(**(made := of_kind(kind, 1, 2)) | {"look": al.Look(**made.get("look", {}))})
    drawn = al.Scene(layers=[layer], camera=cameras(layer.volume)["perspective"], background=None)
    skipped, whole = (renderer.render(drawn, SIZE, skip=skip) for skip in ("auto", "none"))
    assert skipped.stats["samples"] < 0.9 * whole.stats["samples"]


EXTREMES = {
    "mip": al.integrate.Mip(),
    "minip": al.integrate.MinIp(),
    "local": al.integrate.LocalMip(threshold=50, drop=4),
    "depth": al.integrate.DepthShadedMip(),
    "attenuated": al.integrate.AttenuatedMip(),
}


@pytest.mark.parametrize("name", EXTREMES)
@settings(max_examples=6)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 8),
    camera=st.sampled_from(["perspective", "inside"]),
    step=st.sampled_from([0.7, 1.0, 1.9]),
    noise=st.sampled_from([0.0, 3.0]),
)
def test_what_is_looked_for_is_found(renderer, name, seed, count, camera, step, noise):
    """Blocks that hold nothing greater than what was found change nothing at all."""
    volume = islands(seed, count)
    rough = noise * np.random.default_rng(seed).random(volume.array.shape, dtype=np.float32)
    volume = al.Volume(volume.array + rough, world_from_index=volume.world_from_index)
    skipped, whole = both(renderer, volume, FUNCTIONS["hill"], camera, step, shade="none", integrate=EXTREMES[name])
    assert skipped.stats["skip"]["done"] == "blocks"
    assert np.array_equal(skipped.rgba, whole.rgba)
    assert np.array_equal(skipped.depth, whole.depth)


def test_tops_that_end_just_below_where_something_is(renderer):
    """Values put right for curvature are not moved across: the field does not go there."""
    volume = islands(5, 1)
    assert 34 < volume.array.max() < 35
    skipped, whole = both(renderer, volume, FUNCTIONS["steps"], "perspective", 0.7)
    assert not skipped.rgba.any()
    assert not whole.rgba.any()


def test_tops_that_end_just_below_a_shape(renderer):
    """Nothing holds values of several variables where they are: blocks allow for what moves them."""
    steep = islands(5, 8)
    volume = al.Volume(np.minimum(steep.array, 34), world_from_index=steep.world_from_index)
    shapes = [Box((35, 0), (110, 400), edge=0, colour=(1, 0.5, 0), extinction=20.0)]
    function = JointFunction((Axis("value", 0, 140), Axis("gradient", 0, 400)), shapes)
    for step in (1.0, 1.9):
        skipped, whole = both(renderer, volume, function, "perspective", step)
        assert skipped.stats["skip"]["done"] == "blocks"
        assert whole.rgba.any()
        assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL


@pytest.mark.parametrize("side", [(0, -1, 0), (-1, 0, 0)])
@pytest.mark.parametrize(("shape", "look"), [((3, 4, 5), {"field": "nearest", "transfer": "postclassified"}), ((1, 4, 5), {})])
def test_outer_cells_are_drawn(renderer, shape, look, side):
    """They reach half a voxel beyond the outer centres; so does a slice."""
    volume, solid = al.Volume(np.full(shape, 100, np.float32)), al.TransferFunction([(20, "red", 0), (90, "red", 5)])
    middle = volume.corners_world().mean(axis=0)
    camera = al.Camera.orthographic(eye=tuple(middle + 20 * np.array(side)), target=tuple(middle), height=7)
    drawn = al.Scene(volume, transfer=solid, camera=camera, look=al.Look(shade="none", **look), background=None)
    chosen, skipped, whole = (renderer.render(drawn, (200, 200), skip=skip) for skip in ("auto", "blocks", "none"))
    assert chosen.stats["skip"]["done"] == "none"
    assert "95% of the blocks" in chosen.stats["skip"]["reason"]
    assert skipped.stats["skip"]["done"] == "blocks"
    assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside"])
def test_pieces_in_which_nothing_is(renderer, name, camera):
    """What clips cut a ray into is passed over where nothing is: the same image, hardly a sample more than without clips."""
    volume = islands(7, 4)
    middle = volume.corners_world().mean(axis=0)
    slices = [
        al.Clip.box(low=(-99, y, -99), high=(99, y + 1.5, 99), keep="outside", capped=y > 20)
        for y in middle[1] + np.arange(-18, 18, 6)
    ]
    drawn = al.Scene(volume, transfer=FUNCTIONS[name], camera=cameras(volume)[camera], background=None, clips=slices)
    skipped, whole = (renderer.render(drawn, SIZE, skip=skip) for skip in ("auto", "none"))
    assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL
    assert skipped.rgba.any()
    unclipped = renderer.render(al.Scene(volume, transfer=FUNCTIONS[name], camera=drawn.camera, background=None), SIZE)
    assert skipped.stats["samples"] < 1.5 * unclipped.stats["samples"]


@pytest.mark.parametrize("field", ["bspline", "catmull_rom", "mitchell"])
def test_filters_that_reach_further(renderer, field):
    for seed in range(3):
        skipped, whole = both(renderer, islands(seed, 5), FUNCTIONS["hill"], "perspective", field=field)
        assert skipped.stats["skip"]["done"] == "blocks"
        assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL


def test_fewer_samples(renderer):
    skipped, whole = both(renderer, islands(1, 3), FUNCTIONS["hill"], "orthographic")
    assert skipped.stats["samples"] < 0.3 * whole.stats["samples"]


def test_a_function_that_shows_nothing(renderer):
    skipped, whole = both(renderer, islands(1, 3), al.TransferFunction([(500, "red", 0), (600, "red", 1)]), "perspective")
    assert not skipped.rgba.any()
    assert not whole.rgba.any()
    assert np.isinf(skipped.depth).all()
    assert skipped.stats["samples"] == 0


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10_000),
    camera=st.sampled_from(["perspective", "orthographic"]),
    p_px=st.tuples(st.floats(0, SIZE[0]), st.floats(0, SIZE[1])),
    depth=st.floats(0.1, 50),
)
def test_places_on_the_image_are_those_of_rays(seed, camera, p_px, depth):
    drawn = scene(camera=camera).camera
    origin, direction = drawn.ray(p_px, SIZE)
    assert np.allclose(on_image(drawn, np.array([origin + depth * direction]), SIZE), [p_px], atol=1e-6)


@given(seed=st.integers(0, 10_000), count=st.integers(0, 6))
def test_columns_enclose_what_is_shown(seed, count):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-10, 60, (8, count, 2))
    columns = columns_of(corners, SIZE)
    shown = np.zeros(SIZE[::-1], dtype=bool)
    for x, y in np.floor(corners.mean(axis=0)).astype(int):
        if 0 <= x < SIZE[0] and 0 <= y < SIZE[1]:
            shown[y, x] = True
    covered = np.zeros_like(shown)
    for tile in columns.trimmed(iter([Tile(0, y, SIZE[0], 8) for y in range(0, SIZE[1], 8)])):
        covered[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width] = True
    assert not (shown & ~covered).any()


def test_groups_of_blocks_are_few_and_enclose_all_that_counts(device):
    rng = np.random.default_rng(3)
    active = rng.random((60, 61, 62)) < 0.2
    made = blocks.make_leaps(device, active)
    assert 0 < len(made.groups) <= blocks.MOST_GROUPS
    places = np.argwhere(active)[:, ::-1] * blocks.BLOCK_VOXELS // made.group_voxels
    assert {tuple(place) for place in places} == {tuple(group) for group in made.groups}
