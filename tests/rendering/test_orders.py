"""Orders of classification and interpolation, and values put right for curvature: parity and laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import SIZE, blobs, function, scene

import airlight as al
from airlight import reference

LEVEL = 1 / 255
GLOW = al.TransferFunction([(40, (0, 0, 0), 0), (70, (0.02, 0.01, 0), 0), (110, (0.1, 0, 0.05), 0.4)], associated=True)
ORDERS = ({"field": "preclassified"}, {"transfer": "postclassified"}, {"transfer": "preintegrated"})
STRAIGHT, CURVED = (al.driver.March(curved=curved) for curved in (False, True))


def holed() -> al.Volume:
    array = blobs().array.copy()
    array[10:25, 12:20, 8:22] = np.nan
    return al.Volume(array, world_from_index=blobs().world_from_index)


def with_function(drawn: al.Scene, tf: al.TransferFunction) -> al.Scene:
    (layer,) = drawn.layers
    return al.Scene(layers=[replace(layer, transfer=tf)], camera=drawn.camera, lights=drawn.lights, background=None)


def compare(renderer, drawn, step=1.0, curved=True, tolerance=LEVEL / 4) -> np.ndarray:
    image = renderer.render(drawn, SIZE, step=step, driver=al.driver.March(curved=curved))
    truth = reference.render(drawn, SIZE, step=step, curved=curved)
    assert np.abs(image.rgba - truth.rgba).max() <= tolerance
    return image.rgba


# -- pre-classification


@pytest.mark.parametrize(
    ("weighted", "volume", "tf"),
    [(True, blobs, function()), (True, holed, GLOW), (False, holed, function()), (False, blobs, GLOW)],
    ids=["plain", "empty samples, associated", "empty samples, not weighted", "associated, not weighted"],
)
def test_preclassified(any_renderer, weighted, volume, tf):
    drawn = with_function(scene(volume(), field=al.field.PreClassified(weighted)), tf)
    assert compare(any_renderer, drawn).any()
    assert compare(
        any_renderer, with_function(scene(volume(), "inside", field=al.field.PreClassified(weighted)), tf), 0.7
    ).any()


def test_orders_agree_where_the_function_is_linear_in_all_data(any_renderer):
    """Then classification and interpolation may change places."""
    line = al.TransferFunction([(-100, (0.8, 0.5, 0.2), 0), (300, (0.8, 0.5, 0.2), 0.4)])
    pictures = [any_renderer.render(with_function(scene(**order), line), SIZE, step=0.25).rgba for order in ORDERS]
    assert all(np.abs(picture - pictures[0]).max() < LEVEL for picture in pictures)
    assert pictures[0][..., 3].max() > 0.9


def test_orders_differ_where_the_function_has_peaks(renderer):
    peak = al.TransferFunction.peak(70.0, 1.0, "white", 3.0)
    truth = reference.converged(with_function(scene(shade="none"), peak), SIZE).rgba
    errors = []
    for order in ORDERS:
        image = renderer.render(with_function(scene(shade="none", **order), peak), SIZE)
        errors.append(np.sqrt(np.mean((image.rgba - truth) ** 2)))
    assert errors[0] > 2 * errors[2]
    assert errors[1] > 2 * errors[2]


def test_colours_that_are_not_weighted_bleed(renderer):
    """Green lies at values that are clear: it shows only where colour is interpolated by itself."""
    values = np.zeros((12, 12, 12), dtype=np.float32)
    values[4:8, 4:8, 4:8] = 1
    red = al.TransferFunction([(0, (0, 1, 0), 0), (0.99, (0, 1, 0), 0), (1, (1, 0, 0), 2)])

    def green(weighted: bool) -> float:
        look = al.Look(field=al.field.PreClassified(weighted), shade="none")
        drawn = al.Scene(al.Volume(values), transfer=red, look=look, camera="iso", background=None)
        return float(renderer.render(drawn, SIZE).rgba[..., 1].max())

    assert green(True) == 0
    assert green(False) > 0.1


def test_preclassified_skips_nothing_that_shows(renderer):
    for drawn in (scene(field="preclassified"), scene(holed(), field="preclassified")):
        skipped, whole = (renderer.render(drawn, SIZE, skip=skip).rgba for skip in ("auto", "none"))
        assert np.abs(skipped - whole).max() < 1e-6


def test_another_function_makes_another_table(renderer):
    drawn = scene(field="preclassified")
    first = renderer.render(drawn, SIZE)
    other = with_function(drawn, function().scaled(3.0))
    assert np.abs(renderer.render(other, SIZE).rgba - first.rgba).max() > 0.05
    assert np.array_equal(renderer.render(drawn, SIZE).rgba, first.rgba)
    layer = first.stats["layers"][0]
    assert layer["stages"]["transfer"] == "from_field"
    assert layer["tables"]["field.classified"] == [*blobs().array.shape, 4]


@pytest.mark.parametrize(
    "look", [{"integrate": "mip"}, {"integrate": "mean"}, {"integrate": "first_hit"}, {"modulation": "change"}]
)
def test_what_looks_at_values_is_refused(renderer, look):
    with pytest.raises(al.StageError, match="preclassified"):
        renderer.render(scene(field="preclassified", **look), SIZE)
    with pytest.raises(al.StageError, match="preclassified"):
        reference.render(scene(field="preclassified", **look), SIZE)


def test_only_functions_of_one_value_are_preclassified(renderer):
    pair = al.Volume(np.stack([blobs().array] * 2), world_from_index=blobs().world_from_index)
    both = al.Scene(pair, transfer=[function(), function()], look=al.Look(field="preclassified"))
    with pytest.raises(al.StageError, match="preclassified"):
        renderer.render(both, SIZE)


# -- values put right for curvature


@pytest.mark.parametrize(
    ("transfer", "volume", "step"),
    [("preintegrated", blobs, 0.7), ("preintegrated", holed, 2.0), ("preintegrated_fast", blobs, 2.0)],
)
def test_curved(any_renderer, transfer, volume, step):
    drawn = scene(volume(), transfer=transfer)
    curved, straight = (compare(any_renderer, drawn, step, curved, tolerance=LEVEL) for curved in (True, False))
    assert np.abs(curved - straight).max() > 1e-4
    assert np.array_equal(curved, any_renderer.render(drawn, SIZE, step=step).rgba)


def test_curved_has_less_than_half_of_the_error_on_smooth_fields(renderer):
    drawn = scene(shade="none")
    truth = reference.converged(drawn, SIZE).rgba
    for step in (2.0, 1.0):
        straight, curved = (
            np.sqrt(np.mean((renderer.render(drawn, SIZE, step=step, driver=driver).rgba - truth) ** 2))
            for driver in (STRAIGHT, CURVED)
        )
        assert curved < 0.5 * straight


def test_nothing_is_curved_where_values_run_straight(renderer):
    ramp = np.add.outer(np.add.outer(np.linspace(0, 30, 16), np.linspace(30, 60, 16)), np.linspace(0, 20, 16))
    drawn = scene(al.Volume(ramp.astype(np.float32)), shade="none", field="linear_exact")
    straight, curved = (renderer.render(drawn, SIZE, driver=driver).rgba for driver in (STRAIGHT, CURVED))
    assert np.abs(straight - curved).max() < 1e-4
    assert straight.any()


@pytest.mark.parametrize(
    "look",
    [
        {"transfer": "postclassified"},
        {"field": "preclassified"},
        {"field": "nearest"},
        {"integrate": "mip"},
        {"integrate": "first_hit"},
    ],
)
def test_curved_is_left_out_where_nothing_is_gained(renderer, look):
    drawn = scene(**look)
    asked = renderer.render(drawn, SIZE, driver=CURVED)
    assert np.array_equal(asked.rgba, renderer.render(drawn, SIZE, driver=STRAIGHT).rgba)
    assert asked.stats["curved"] is False
    straight, curved = (reference.render(drawn, SIZE, step=2, curved=curved).rgba for curved in (False, True))
    assert np.array_equal(straight, curved)
    assert renderer.render(scene(), SIZE).stats["curved"] is True
    assert renderer.render(scene(), SIZE, driver=STRAIGHT).stats["curved"] is False


def test_labels_alone_are_not_curved(renderer):
    numbers = al.Volume((blobs().array > 60).astype(np.uint8), world_from_index=blobs().world_from_index)
    drawn = al.Scene(layers=[al.Layer(numbers, labels=al.Labels(numbers))], camera="iso", background=None)
    image = renderer.render(drawn, SIZE)
    assert image.rgba.any()
    assert image.stats["curved"] is False


@pytest.mark.parametrize("step", [2.0, 1.0])
def test_the_step_does_not_matter_by_default(renderer, step):
    """The mean colour changes by less than half as much as without curvature."""
    drawn = scene(shade="none")

    def change(driver):
        coarse, fine = (renderer.render(drawn, SIZE, step=s, driver=driver).rgb.mean(axis=(0, 1)) for s in (step, 0.25))
        return np.linalg.norm(coarse - fine) / np.linalg.norm(fine)

    assert change(al.driver.March()) < min(0.01, 0.5 * change(STRAIGHT))


def test_several_channels_are_curved_together(renderer):
    array = blobs().array
    pair = al.Volume(np.stack([array, 130 - array]), world_from_index=blobs().world_from_index)
    for transfer in ("preintegrated", "postclassified"):
        look = al.Look(shade="none", transfer=transfer)
        both = al.Scene(pair, transfer=[function(), function()], camera=scene().camera, look=look, background=None)
        compare(renderer, both, 1.5)
        assert renderer.render(both, SIZE).stats["curved"] is (transfer == "preintegrated")


# -- modulation


def ramp_along(axis: int) -> al.Volume:
    """Ten data units a voxel along one axis, two world units a voxel."""
    values = np.moveaxis(np.broadcast_to(10.0 * np.arange(12, dtype=np.float32), (12, 12, 12)), 2, 2 - axis)
    return al.Volume(np.ascontiguousarray(values), spacing=(2, 2, 2))


def alpha(renderer, volume, modulation, step, transfer="preintegrated") -> float:
    """Opacity of the middle ray, along x, through a constant medium."""
    camera = al.Camera.orthographic(eye=(-50, 11, 11), target=(11, 11, 11), up=(0, 0, 1), height=1)
    look = al.Look(modulation=modulation, transfer=transfer, shade="none", field="linear_exact")
    tf = al.TransferFunction([(-50, "white", 0.05), (500, "white", 0.05)])
    drawn = al.Scene(volume, transfer=tf, camera=camera, look=look, background=None)
    return float(renderer.render(drawn, (1, 1), step=step).rgba[0, 0, 3])


@pytest.mark.parametrize("step", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("transfer", ["preintegrated", "preintegrated_fast", "postclassified"])
@pytest.mark.parametrize("modulation", [al.modulation.Change, al.modulation.GradientMagnitude])
def test_weights_do_not_depend_on_the_step(renderer, modulation, transfer, step):
    """Five data units a world unit, of ten that count in full: half of the extinction, over 22 world units."""
    found = alpha(renderer, ramp_along(0), modulation(full_at=10.0), step, transfer)
    assert abs(found - (1 - np.exp(-0.5 * 0.05 * 22))) < 1e-4
    full = alpha(renderer, ramp_along(0), modulation(full_at=2.0), step, transfer)
    assert abs(full - (1 - np.exp(-0.05 * 22))) < 1e-4


def test_change_is_seen_head_on_alone(renderer):
    assert alpha(renderer, ramp_along(1), al.modulation.Change(full_at=10.0), 1.0) < 1e-4
    across = alpha(renderer, ramp_along(1), al.modulation.GradientMagnitude(full_at=10.0), 1.0)
    assert abs(across - (1 - np.exp(-0.5 * 0.05 * 22))) < 1e-4


@pytest.mark.parametrize(
    ("stage", "volume", "shade"),
    [
        (al.modulation.Change, holed, "none"),
        (al.modulation.GradientMagnitude, holed, "none"),
        (al.modulation.GradientMagnitude, blobs, "blinn_phong"),
    ],
)
def test_modulations(any_renderer, stage, volume, shade):
    for full_at in (None, 30.0):
        weighted = compare(any_renderer, scene(volume(), modulation=stage(full_at), shade=shade))
        assert 0 < weighted[..., 3].sum() < 0.95 * any_renderer.render(scene(volume(), shade=shade), SIZE).rgba[..., 3].sum()
