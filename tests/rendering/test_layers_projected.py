"""Projections of several layers: each as if it were alone, added; parity with the reference, laws, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from test_layers import SIZE, compare, holed, large, own_clips, scene, small

import airlight as al

GREY = al.TransferFunction([(0, "black", 0.0), (1000, (0.6, 0.6, 0.6), 1.0)])
HOT = al.TransferFunction([(200, "black", 0.0), (700, (0.5, 0.1, 0), 0.5), (1000, (0.4, 0.35, 0.1), 1.0)])
STEP = 0.8
ALONE = STEP * min(small().volume.spacing)  # the same way between samples, in voxels of the large one
PROJECTIONS = ("mip", "minip", "mean", "attenuated_mip", "depth_shaded_mip", "local_mip")


def grey(integrate: al.Stage | str = "mip", **given) -> al.Layer:
    return al.Layer(waves(large().volume), GREY, al.Look(integrate=integrate), **given)


def hot(integrate: al.Stage | str = "mip", **given) -> al.Layer:
    return al.Layer(waves(small().volume), HOT, al.Look(integrate=integrate), **given)


@cache
def waves(volume: al.Volume) -> al.Volume:
    """No two places of the same value in its grid, so that each extreme has one place."""
    z, y, x = np.indices(volume.array.shape) * 0.8
    field = 500 + 220 * np.sin(x + 0.3 * y) * np.cos(0.7 * y - 0.4 * z) + 150 * np.sin(0.3 * x * z) + 8 * (x + 2 * y - z)
    return al.Volume(field.astype(np.float32), world_from_index=volume.world_from_index)


@pytest.mark.parametrize("name", PROJECTIONS)
def test_each_layer_is_projected_as_if_it_were_alone(renderer, name):
    image = compare(renderer, scene(grey(name), hot(name)), STEP)
    one = renderer.render(scene(grey(name)), SIZE, step=ALONE)
    other = renderer.render(scene(hot(name)), SIZE, step=STEP)
    assert np.abs(image.rgba[..., :3] - one.rgba[..., :3] - other.rgba[..., :3]).max() < 1e-6
    np.testing.assert_array_equal(image.rgba[..., 3], np.maximum(one.rgba[..., 3], other.rgba[..., 3]))
    assert image.stats["samples"] == one.stats["samples"] + other.stats["samples"]
    assert image.stats["several"] == {"layers": 2, "projections": "added"}


def test_rules_may_differ_and_order_does_not_matter(any_renderer):
    layers = grey("minip"), hot(al.integrate.LocalMip(threshold=400)), holed_mean()
    image = compare(any_renderer, scene(*layers), STEP)
    back = any_renderer.render(scene(*layers[::-1]), SIZE, step=STEP)
    assert np.abs(image.rgba - back.rgba).max() < 1e-6
    np.testing.assert_allclose(back.depth, image.depth, atol=1e-4)


def holed_mean() -> al.Layer:
    return replace(holed(), transfer=HOT, look=al.Look(integrate="mean"))


def test_skipping_changes_nothing_and_what_is_empty_adds_nothing(renderer):
    layers = grey(), hot("attenuated_mip")
    image = renderer.render(scene(*layers), SIZE, step=STEP)
    all_samples = renderer.render(scene(*layers), SIZE, step=STEP, skip="none")
    assert (image.stats["skip"]["done"], all_samples.stats["skip"]["done"]) == ("blocks", "none")
    assert image.stats["samples"] < all_samples.stats["samples"]
    assert np.abs(image.rgba - all_samples.rgba).max() < 1e-6
    gaps = al.Layer(al.Volume(np.full((9, 9, 9), np.nan, np.float32)), GREY, al.Look(integrate="mip"))
    for nothing in (gaps, hot(density=0.0), hot(visible=False)):
        alone = renderer.render(scene(grey()), SIZE, step=STEP)
        assert np.abs(renderer.render(scene(grey(), nothing), SIZE, step=STEP).rgba - alone.rgba).max() < 1e-6


def test_clips_of_all_and_of_one_and_meshes(renderer):
    clips = own_clips()
    wall = al.Mesh([(0, 10, 0), (24, 10, 0), (12, 12, 24)], [(0, 1, 2)], color=(0.2, 0.9, 0.3))
    cut = grey(clips=[clips["sphere"], clips["mesh"]]), hot("mean", clips=[clips["front"]])
    image = compare(renderer, scene(*cut, clips=[clips["plane"]], meshes=[wall]), STEP)
    assert image.stats["clips"]["cutting"] == 4
    alone = renderer.render(scene(cut[0], clips=[clips["plane"]]), SIZE, step=ALONE).rgba[..., :3]
    other = renderer.render(scene(cut[1], clips=[clips["plane"]]), SIZE, step=STEP).rgba[..., :3]
    both = renderer.render(scene(*cut, clips=[clips["plane"]]), SIZE, step=STEP).rgba[..., :3]
    assert np.abs(both - alone - other).max() < 1e-6


def test_depth_and_what_is_picked_are_those_of_the_brighter_layer(renderer):
    layers = grey("minip"), hot()
    image = renderer.render(scene(*layers), SIZE, step=STEP)
    parts = [renderer.render(scene(layer), SIZE, step=step) for layer, step in zip(layers, (ALONE, STEP), strict=True)]
    brightness = np.stack([part.rgba[..., :3].sum(axis=-1) for part in parts])
    apart = np.abs(brightness[0] - brightness[1]) > 0.1
    brighter = brightness.argmax(axis=0)
    depth = np.where(brighter == 0, parts[0].depth, parts[1].depth)
    np.testing.assert_allclose(image.depth[apart], depth[apart], atol=1e-4)
    for layer in (0, 1):
        rows, columns = np.nonzero(apart & (brighter == layer))
        assert image.pick(int(columns[0]), int(rows[0])).layer == layer


@pytest.mark.parametrize(
    ("looks", "given", "match"),
    [
        (
            ("mip", "emission_absorption"),
            {},
            r"layers\[1\].look.integrate .*a ray has one: use emission_absorption, .* for all",
        ),
        (("mip", "xray"), {}, "a ray has one: use .* projections of values for all"),
        (("mip", "mip"), {"driver": "slices"}, "driver 'slices' projects one layer, and 2 are visible: use driver='march'"),
        (("mip", "mip"), {"keep_hits": True}, "meets no surfaces that could be kept"),
    ],
)
def test_what_cannot_be_added_is_refused(renderer, looks, given, match):
    with pytest.raises(al.StageError, match=match):
        renderer.render(scene(*(grey(look) for look in looks)), SIZE, **given)
