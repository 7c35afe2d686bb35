"""Every stage of every slot against the float64 reference, found from the table of stages: a new stage is tested the day it
is registered, on a device with all features and on one with core WebGPU alone.
"""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, scene

import airlight as al
from airlight import reference
from airlight.stage import SLOTS, STAGES

LOOK_SLOTS = [slot for slot in SLOTS if slot in al.Look.__dataclass_fields__]  # regions: test_labels.py
PARAMETERS = {
    ("integrate", "attenuated_mip"): {"attenuation": 0.005},  # more makes places that are equally strong: test_projections.py
    ("integrate", "first_hit"): {"iso": 70.0},
    ("visibility", "ambient_occlusion"): {"cells": 12, "directions": 16},
    ("visibility", "shadow_volume"): {"cells": 12},
}
ELSEWHERE = {("lighting", "quantised")}  # it refuses perspective views and point lights: test_quantised.py
NAMES = [(slot, name) for slot in LOOK_SLOTS for name in sorted(STAGES[slot]) if (slot, name) not in ELSEWHERE]
CHOICES = [
    *((slot, STAGES[slot][name](**PARAMETERS.get((slot, name), {}))) for slot, name in NAMES),
    ("gradient", al.gradient.Precomputed("sobel")),
    ("shade", al.shade.BlinnPhong(two_sided=False, ambient=0.2, shininess=5)),
    ("tone", al.tone.Linear(exposure=1.0)),
]
TABLE_ERROR = 1 / 255  # tables are interpolated between entries


def compare(renderer: al.Renderer, drawn: al.Scene, step: float = 1.0, tolerance: float = TABLE_ERROR) -> None:
    image = renderer.render(drawn, SIZE, step=step)
    truth = reference.render(drawn, SIZE, step=step)
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    look = drawn.layers[0].look
    if look.field.name == "nearest" or look.gradient.name == "analytic":
        # A sample, or a neighbour that its gradient asks for, on the border of two voxels or cells may fall to either.
        assert error.max() <= 10 * tolerance
        error = np.sort(error.ravel())[: -max(1, error.size // 200)]
    assert error.max() <= tolerance
    met = np.isfinite(truth.depth)
    assert (np.isfinite(image.depth) == met).mean() > 0.999  # opacities of exactly one half may fall to either side
    both = met & np.isfinite(image.depth)
    if both.any():
        # Equal extremes, and those that a half float makes equal, may be found at either place.
        assert np.quantile(np.abs(image.depth[both] - truth.depth[both]), 0.98) < 0.05


@pytest.mark.parametrize(("kind", "camera"), [("renderer", "perspective"), ("core_renderer", "orthographic")])
@pytest.mark.parametrize(("slot", "stage"), CHOICES, ids=lambda c: getattr(c, "name", c))
def test_stage(request, kind, slot, stage, camera):
    """On both kinds of devices and with both kinds of cameras, which know nothing of each other: one program for each pair."""
    compare(request.getfixturevalue(kind), scene(camera=camera, **{slot: stage}))


@pytest.mark.parametrize("camera", ["inside", "cut"])
@pytest.mark.parametrize("integrate", ["emission_absorption", "mip", "first_hit"])
def test_eye_inside(renderer, integrate, camera):
    compare(renderer, scene(camera=camera, integrate=integrate))


@pytest.mark.parametrize("dtype", ["uint8", "int8", "int16", "uint16", "int32", "float16", "float64"])
def test_sample_types(any_renderer, dtype):
    """Also on the core device, where 16-bit integers go as half floats: their error is within a level of the picture."""
    compare(any_renderer, scene(blobs(dtype), shade="none"))


@pytest.mark.parametrize("step", [0.3, 2.5])
def test_steps(renderer, step):
    compare(renderer, scene(shade="none"), step=step)


@pytest.mark.parametrize("field", ["nearest", "linear", "linear_exact"])
@pytest.mark.parametrize("integrate", ["emission_absorption", "mip", "mean"])
def test_empty_samples_do_not_spread(either_renderer, field, integrate):
    """NaN in the middle: transparent there, and neighbours keep their values."""
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    drawn = scene(volume, field=field, integrate=integrate, shade="none")
    compare(either_renderer, drawn)
    marked = al.Volume(np.where(np.isnan(holed), -99, holed), world_from_index=blobs().world_from_index, no_data=-99)
    again = either_renderer.render(scene(marked, field=field, integrate=integrate, shade="none"), SIZE)
    assert np.array_equal(again.rgba, either_renderer.render(drawn, SIZE).rgba)


def test_interleaved_offsets(renderer):
    def fraction(x, y):
        bayer = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])
        return bayer[np.asarray(y) % 4, np.asarray(x) % 4] / 16

    drawn = scene(transfer="postclassified", shade="none")
    image = renderer.render(drawn, SIZE, step=2, driver=al.driver.March(offsets="interleaved"))
    truth = reference.render(drawn, SIZE, step=2, offset_fraction=fraction)
    plain = reference.render(drawn, SIZE, step=2)
    assert np.abs(image.rgba - truth.rgba).max() <= TABLE_ERROR
    assert np.abs(plain.rgba - truth.rgba).max() > TABLE_ERROR


def test_associated_functions_glow_without_extinction(any_renderer):
    glow = al.TransferFunction([(40, (0, 0, 0), 0), (70, (0.02, 0.01, 0), 0), (110, (0.1, 0, 0.05), 0.4)], associated=True)
    for transfer in ("preintegrated", "postclassified"):
        base = scene(transfer=transfer, shade="none")
        drawn = al.Scene(base.layers[0].volume, transfer=glow, camera=base.camera, look=base.layers[0].look, background=None)
        compare(any_renderer, drawn)
    image = any_renderer.render(drawn, SIZE)
    assert (image.rgba[..., 0] > image.rgba[..., 3]).any()


@pytest.mark.parametrize("shape", [(1, 20, 30), (20, 1, 30), (12, 13, 1), (1, 1, 1), (2, 2, 2)])
def test_thin_volumes(renderer, shape):
    """An axis of one voxel is a slab one voxel thick."""
    rng = np.random.default_rng(3)
    volume = al.Volume(rng.uniform(40, 110, shape).astype(np.float32), spacing=(1, 1.5, 2))
    for field in ("linear", "nearest"):
        compare(renderer, scene(volume, field=field, integrate="mean"))
        compare(renderer, scene(volume, field=field, shade="none", transfer=al.transfer.PreIntegrated(entries=512)))


@pytest.mark.parametrize("transfer", ["preintegrated", "preintegrated_fast"])
@pytest.mark.parametrize("field", ["nearest", "linear"])
def test_whole_numbers_at_a_step_at_the_end_of_a_function(renderer, transfer, field):
    """Values that are exactly the first one of a function that begins with a step: what lies below it stays empty."""
    rng = np.random.default_rng(5)
    volume = al.Volume(rng.choice([50, 100, 150], (12, 13, 14)).astype(np.uint8), spacing=(1, 1.5, 2))
    box = al.TransferFunction([(100, "black", 0), (100, "red", 0.5), (150, "lime", 0.5), (150, "black", 0)])
    drawn = al.Scene(
        volume, transfer=box, camera=cameras(volume)["perspective"], look=al.Look(field=field, transfer=transfer, shade="none")
    )
    image, truth = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert np.quantile(error, 0.98) <= TABLE_ERROR  # samples on a border of voxels may fall to either
