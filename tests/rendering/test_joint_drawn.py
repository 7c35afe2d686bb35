"""Functions of two and three variables on the device: against the reference, and by laws that need none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scenes import blobs, scene

import airlight as al
from airlight import reference
from airlight.transfer.derivatives import pieces
from airlight.transfer.joint import JointFunction
from airlight.transfer.joint_axes import Axis, Ramp
from airlight.transfer.joint_shapes import Box, Ellipse, Polygon, Triangle

SIZE = (28, 24)
LEVEL = 1 / 255
VALUE, GRADIENT, SECOND = Axis("value", 0.0, 140.0), Axis("gradient", 0.0, 20.0), Axis("second", -12.0, 12.0)
PLANE = JointFunction(
    (VALUE, GRADIENT),
    [
        Ellipse((70, 8), (40, 7), 0.3, colour=(1, 0.5, 0.2), extinction=0.8),
        Triangle(95, 45, 20, colour=(0.2, 0.4, 1), extinction=1.5),
        Box((30, 1), (60, 9), edge=1, extinction=0.2, ramp=Ramp(1, ((2, (0, 1, 0)), (8, (1, 0, 1))))),
        Polygon(((105, 0), (130, 0), (118, 8)), edge=1, colour=(1, 1, 1), extinction=2),
    ],
)
SPACE = JointFunction(
    (VALUE, GRADIENT, SECOND),
    [
        Ellipse((65, 8, -2), (50, 8, 8), colour=(1, 0.5, 0.2), extinction=0.6),
        Ellipse((110, 4, 1), (28, 4, 10), colour=(0.2, 0.6, 1), extinction=0.6),
    ],
)
GLOW = JointFunction(
    PLANE.axes,
    [
        Ellipse((60, 8), (40, 8), colour=(0.05, 0.02, 0), extinction=0),
        Ellipse((100, 8), (35, 8), colour=(0, 0.03, 0.1), extinction=0.3),
    ],
    associated=True,
)
FUNCTIONS = {"value and gradient": PLANE, "and second": SPACE, "associated": GLOW}
WAYS = ("postclassified", "preintegrated")


def drawn_with(function, volume=None, camera="perspective", **look) -> al.Scene:
    base = scene(volume, camera, **look)
    return dataclasses.replace(base, layers=[dataclasses.replace(base.layers[0], transfer=function)])


def compare(renderer, drawn: al.Scene, step: float = 1.0, tolerance: float = 3 * LEVEL) -> None:
    """Differences are those of the table, which the device interpolates and the reference has not."""
    image, truth = renderer.render(drawn, SIZE, step=step), reference.render(drawn, SIZE, step=step)
    assert truth.rgba[..., 3].max() > 0.3 or drawn.layers[0].transfer.associated
    assert np.abs(image.rgba - truth.rgba).max() <= tolerance
    met = np.isfinite(truth.depth)
    assert (np.isfinite(image.depth) == met).mean() > 0.995
    both = met & np.isfinite(image.depth)
    if both.any():
        assert np.quantile(np.abs(image.depth[both] - truth.depth[both]), 0.98) < 0.2


# -- parity


@pytest.mark.parametrize("transfer", WAYS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions(either_renderer, name, transfer):
    compare(either_renderer, drawn_with(FUNCTIONS[name], shade="none", transfer=transfer))


@pytest.mark.parametrize(("name", "entries"), [("value and gradient", 1024), ("and second", 160), ("associated", 1024)])
def test_what_is_left_is_the_tables_size(any_renderer, name, entries):
    way = al.transfer.PreIntegrated(entries=entries)
    compare(any_renderer, drawn_with(FUNCTIONS[name], shade="none", transfer=way), tolerance=LEVEL / 2)


@pytest.mark.parametrize("camera", ["orthographic", "inside", "cut"])
def test_cameras(renderer, camera):
    compare(renderer, drawn_with(PLANE, camera=camera, shade="none"))


@pytest.mark.parametrize("step", [0.4, 2.5])
@pytest.mark.parametrize("transfer", WAYS)
def test_steps(renderer, step, transfer):
    compare(renderer, drawn_with(PLANE, shade="none", transfer=transfer), step=step)


@pytest.mark.parametrize(
    ("field", "gradient"),
    [("linear", "central"), ("linear_exact", "sobel"), ("linear", "precomputed"), ("linear", al.gradient.Precomputed("sobel"))],
    ids=str,
)
def test_lit_by_every_gradient(any_renderer, field, gradient):
    """What lights is what classifies: the look's own gradient."""
    compare(any_renderer, drawn_with(PLANE, field=field, gradient=gradient))


def test_gradients_are_kept_where_nothing_is_lit():
    assert drawn_with(PLANE, shade="none", gradient="sobel").layers[0].stages()["gradient"].name == "sobel"
    assert scene(shade="none", gradient="sobel").layers[0].stages()["gradient"].name == "zero"


@pytest.mark.parametrize("name", ["value and gradient", "and second"])
def test_empty_samples_do_not_spread(any_renderer, name):
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    compare(any_renderer, drawn_with(FUNCTIONS[name], volume, shade="none"), tolerance=3 * LEVEL)


@pytest.mark.parametrize("shape", [(1, 20, 30), (20, 1, 30), (12, 13, 1), (1, 1, 1), (2, 2, 2), (3, 3, 3)])
@pytest.mark.parametrize("name", ["value and gradient", "and second"])
def test_thin_volumes(renderer, shape, name):
    z, y, x = (np.linspace(0, 1, n) for n in shape)
    field = 65 + 5 * np.sin(3 * x + 1) * np.cos(y)[:, None] + 3 * (z * z)[:, None, None]
    volume = al.Volume(np.broadcast_to(field, shape).astype(np.float32), spacing=(1, 1.5, 2))
    axes = FUNCTIONS[name].axes
    flat = [dataclasses.replace(axis, low=-axis.high) for axis in axes]
    shape_of_all = Ellipse((75, 0, 0)[: len(axes)], (60, 20, 12)[: len(axes)], extinction=0.7)
    compare(renderer, drawn_with(JointFunction([axes[0], *flat[1:]], [shape_of_all]), volume, shade="none"))


def test_samples_of_whole_numbers(any_renderer):
    compare(any_renderer, drawn_with(PLANE, blobs("uint8"), shade="none"))


# -- one definition of derivatives: histograms, the reference, and the device


@pytest.mark.parametrize("holed", [False, True])
def test_derivatives_at_voxels_are_those_of_the_histogram(holed):
    """At faces, edges and corners of the grid, and beside empty samples, too."""
    array = blobs().array[::3, ::3, ::3].copy()
    if holed:
        array[3:5, 4, 2:6] = np.nan
        array[9, 9, 0] = np.nan
    volume = al.Volume(array, world_from_index=blobs().world_from_index)
    drawn = drawn_with(SPACE, volume, shade="none")
    setup = reference.prepare(drawn)
    nz, ny, nx = array.shape
    p_index = np.stack(np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")[::-1], axis=-1).reshape(-1, 3)
    p_index = p_index.astype(np.float64)
    value, empty = reference.field.field_value(setup, p_index)
    sample = reference.setup.Sample(value, empty, p_index, p_index, np.zeros(len(p_index)))
    found = reference.joint.variables(setup, sample)[~empty]
    known = [np.concatenate([getattr(p, n).ravel() for p in pieces(volume)]) for n in ("value", "gradient", "second")]
    assert np.abs(found - np.stack(known, axis=1)[~empty]).max() < 1e-4


def test_second_derivatives_fade_towards_faces_without_a_jump():
    """A parabola: its second difference is 2, one voxel inside; at the face, where it goes on straight, there is none."""
    volume = al.Volume(np.broadcast_to((np.arange(9.0) ** 2), (5, 5, 9)).astype(np.float32))
    setup = reference.prepare(drawn_with(SPACE, volume, shade="none"))
    p_index = np.array([[x, 2.0, 2.0] for x in (4, 7, 7.25, 7.5, 8 - 1e-9, 8)])
    gradient = reference.gradient.field_gradient(setup, p_index)
    second = reference.joint.second_along(setup, p_index, gradient)
    assert second == pytest.approx([2, 2, 1.5, 1, 0, 0], abs=1e-6)


# -- laws


@pytest.mark.parametrize("transfer", WAYS)
def test_a_function_that_ignores_the_gradient_is_one_of_the_value(renderer, transfer):
    """A box over all gradients whose extinction is a trapezium of the value."""
    colour = (1, 0.5, 0.2)
    trapezium = al.TransferFunction([(40, colour, 0), (60, colour, 0.8), (80, colour, 0.8), (100, colour, 0)])
    # The edge falls off to all sides, so the box reaches far beyond the gradients that there are.
    wide = JointFunction(
        (Axis("value", 0, 255), Axis("gradient", -1e4, 1e4)),
        [Box((40, -9e3), (100, 9e3), edge=2 / 3, colour=colour, extinction=0.8)],
    )
    look = {"shade": "none", "transfer": transfer}
    one = renderer.render(drawn_with(trapezium, **look), SIZE)
    two = renderer.render(drawn_with(wide, **look), SIZE)
    assert one.rgba[..., 3].max() > 0.9
    assert np.abs(one.rgba - two.rgba).max() <= LEVEL


@pytest.mark.parametrize("name", FUNCTIONS)
def test_skipping_does_not_change_the_image(any_renderer, name):
    drawn = drawn_with(FUNCTIONS[name], shade="none")
    images = [any_renderer.render(drawn, SIZE, skip=skip).rgba for skip in ("auto", "none")]
    assert np.array_equal(*images)


def test_skipping_happens(renderer):
    """The reader of derivatives is not asked where values are empty: counted by what is found, since time is no measure."""
    drawn = drawn_with(JointFunction(PLANE.axes, [Ellipse((70, 8), (10, 6))]), shade="none")
    assert drawn.layers[0].transfer.empty_values[0][1] > 59
    assert "SKIPS_EMPTY = true" in al.explain(drawn, SIZE).replace("const ", "").replace(": bool", "")


@pytest.mark.parametrize("transfer", WAYS)
def test_nothing_is_drawn_without_shapes(renderer, transfer):
    for function in (JointFunction(PLANE.axes), PLANE.scaled(0)):
        image = renderer.render(drawn_with(function, transfer=transfer), SIZE)
        assert not image.rgba.any()
        assert np.isinf(image.depth).all()


def test_density_is_that_of_the_function(renderer):
    thick = drawn_with(PLANE.scaled(3), shade="none")
    layer = drawn_with(PLANE, shade="none").layers[0]
    again = dataclasses.replace(thick, layers=[dataclasses.replace(layer, density=3.0)])
    assert np.array_equal(renderer.render(thick, SIZE).rgba, renderer.render(again, SIZE).rgba)


def sphere() -> al.Volume:
    """A ball with a soft border, nothing outside and 250 inside."""
    z, y, x = np.mgrid[-1:1:24j, -1:1:24j, -1:1:24j]
    inside = 250 / (1 + np.exp((np.sqrt(x * x + y * y + z * z) - 0.7) / 0.05))
    return al.Volume(inside.astype(np.float32))


@pytest.mark.parametrize("width", [40, 12])
def test_thin_bands_need_samples_inside_of_slabs(renderer, width):
    """A step of one voxel passes over a thin band of values; the slab's own samples find it."""
    band = Box((125 - width / 2, 1), (125 + width / 2, 200), edge=1, colour=(1, 0.6, 0.2), extinction=3)
    function = JointFunction((Axis("value", 0, 255), Axis("gradient", 0, 200)), [band])
    truth = reference.render(drawn_with(function, sphere(), shade="none", transfer="postclassified"), SIZE, substeps=48)
    error = {}
    for transfer in WAYS:
        image = renderer.render(drawn_with(function, sphere(), shade="none", transfer=transfer), SIZE)
        error[transfer] = float(np.sqrt(((image.rgba - truth.rgba) ** 2).mean()))
    assert error["preintegrated"] < 0.02
    assert error["preintegrated"] < 0.35 * error["postclassified"]


def test_a_slab_is_split_where_its_light_is(renderer):
    """What is in front of a slab's far end is lit there: the parts of a slab add up whatever lights them."""
    even = [al.Light.directional(to_light=(0, 0, 1))]
    lit = {}
    for lighting in ("sampled", "supersampled"):
        look = {"lighting": lighting, "shade": al.shade.BlinnPhong(ambient=1, diffuse=0, specular=0)}
        drawn = dataclasses.replace(drawn_with(PLANE, **look), lights=even)
        lit[lighting] = renderer.render(drawn, SIZE).rgba
    plain = renderer.render(drawn_with(PLANE, shade="none"), SIZE).rgba
    for image in lit.values():
        assert np.abs(image - plain).max() < LEVEL / 4


# -- what is said


def test_statistics_name_the_stand_in_and_its_error(renderer):
    stats = renderer.render(drawn_with(PLANE, shade="none"), SIZE).stats["layers"][0]
    assert stats["stages"]["transfer"] == "joint"
    assert stats["tables"]["transfer.shapes"] == [1, 256, 256, 4]
    one = JointFunction(PLANE.axes, [Ellipse((70, 8), (40, 7))])
    errors = {}
    for entries in (64, 128, 256):
        drawn = drawn_with(one, shade="none", transfer=al.transfer.PreIntegrated(entries=entries))
        errors[entries] = renderer.render(drawn, SIZE).stats["layers"][0]["errors"]["transfer: extinction between entries"]
    assert errors[256] < errors[128] / 2 < errors[64] / 4 < 0.02


def test_tables_have_bounds(renderer):
    for function, entries, most in ((PLANE, 4096, 2048), (SPACE, 512, 256)):
        drawn = drawn_with(function, shade="none", transfer=al.transfer.PreIntegrated(entries=entries))
        with pytest.raises(al.ValueRangeError, match=rf"entries is {entries}, must lie in \[2, {most}\]"):
            renderer.render(drawn, SIZE)


# -- with the other parts of a look


@pytest.mark.parametrize("look", [{"lighting": "supersampled"}, {"modulation": "gradient_magnitude"}], ids=str)
def test_lighting_and_modulation(renderer, look):
    compare(renderer, drawn_with(PLANE, **look))


def test_regions_of_labels(any_renderer):
    """Regions tint and thin what the function draws; names of both devices' halves do not collide."""
    regions = np.zeros(blobs().array.shape, dtype=np.uint8)
    regions[10:30, 10:24, 8:20] = 1
    labels = al.Labels(al.Volume(regions, world_from_index=blobs().world_from_index))
    drawn = drawn_with(PLANE)
    labelled = dataclasses.replace(drawn, layers=[dataclasses.replace(drawn.layers[0], labels=labels)])
    compare(any_renderer, labelled)
    assert np.abs(any_renderer.render(labelled, SIZE).rgba - any_renderer.render(drawn, SIZE).rgba).max() > 0.05


def test_voxels_are_not_classified_by_several_variables(renderer):
    with pytest.raises(al.StageError, match="cannot classify voxels by a JointFunction"):
        renderer.render(drawn_with(PLANE, field="preclassified"), SIZE)


# -- projections and surfaces


@pytest.mark.parametrize("integrate", ["mip", "minip", al.integrate.FirstHit(iso=70.0)], ids=str)
def test_one_sample_of_each_ray(any_renderer, integrate):
    """An extreme and a surface have the colour of the value and the gradient where they lie."""
    cover = JointFunction(PLANE.axes, [Box((0, 0), (140, 20), ramp=Ramp(1, ((2, (1, 0, 0)), (10, (0, 0.2, 1)))))])
    drawn = drawn_with(cover, integrate=integrate)
    image, truth = any_renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.ptp(truth.rgba[..., 0][truth.rgba[..., 3] > 0]) > 0.2
    # Equal extremes may be found at either of two places, which differ in their gradients.
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert np.quantile(error, 0.98) <= 2 * LEVEL


def test_what_has_no_place_has_no_gradient(renderer):
    with pytest.raises(al.StageError, match=r"look\.integrate 'mean' makes a value that has no gradient"):
        renderer.render(drawn_with(PLANE, integrate="mean"), SIZE)
    with pytest.raises(al.ValueRangeError, match=r"first_hit.iso is left to the function.*FirstHit\(iso=...\)"):
        renderer.render(drawn_with(PLANE, integrate="first_hit"), SIZE)


# -- channels


def channels(holed: bool = False) -> al.Volume:
    """Three fields in one place; their names are no variables of axes, but one is a trap."""
    first = blobs().array
    z, y, x = np.mgrid[-1:1:40j, -1:1:36j, -1:1:32j]
    second = 60 + 50 * np.sin(2 * x + z)
    third = 100 - 40 * np.cos(3 * y) * np.sin(2 * z)
    samples = np.stack([first, second, third]).astype(np.float32)
    if holed:
        samples[1, 10:25, 12:20, 8:22] = np.nan
        samples[:, :8, :8, :8] = np.nan
    return al.Volume(samples, world_from_index=blobs().world_from_index, channel_names=("T1", "value", "T2"))


TWO = JointFunction(
    (Axis("T1", 0, 140), Axis("T2", 0, 160)),
    [
        Ellipse((80, 100), (50, 50), 0.4, colour=(1, 0.5, 0.2), extinction=0.8),
        Ellipse((50, 120), (40, 40), colour=(0, 0.5, 1)),
    ],
)
THREE = JointFunction(
    (Axis("T2", 0, 160), Axis("T1", 0, 140), Axis(1, 0, 140)),
    [Ellipse((100, 70, 70), (60, 60, 70), colour=(1, 0.5, 0.2), extinction=0.8)],
)
MIXED = JointFunction(
    (Axis("T2", 0, 160), Axis("value", 0, 140), Axis("gradient", 0, 20)),
    [Ellipse((100, 70, 8), (60, 60, 8), colour=(0.3, 0.9, 0.2), extinction=0.8)],
)


@pytest.mark.parametrize(("holed", "shade"), [(False, "none"), (True, "blinn_phong")], ids=["full", "holed and lit"])
@pytest.mark.parametrize("function", [TWO, THREE, MIXED], ids=["two", "three", "one and its gradient"])
def test_variables_that_are_channels(either_renderer, function, shade, holed):
    drawn = drawn_with(function, channels(holed), shade=shade)
    assert drawn.layers[0].stages()["field"].name.startswith("linear_channels")
    compare(either_renderer, drawn, tolerance=4 * LEVEL)


def test_the_layers_own_channel_is_the_value(renderer):
    """The value and its gradient are those of the layer's channel, whatever else the function looks at, and in what order."""
    volume = channels()
    for channel, by_number in ((2, "T2"), (0, "T1")):
        layer = dataclasses.replace(drawn_with(PLANE, volume, shade="none").layers[0], channel=channel)
        assert layer.channels == (channel,)
        alone = al.Volume(volume.grid(by_number), world_from_index=volume.world_from_index)
        drawn = dataclasses.replace(drawn_with(PLANE, volume, shade="none"), layers=[layer])
        same = drawn_with(PLANE, alone, shade="none")
        assert np.array_equal(renderer.render(drawn, SIZE).rgba, renderer.render(same, SIZE).rgba)
    assert drawn_with(MIXED, volume).layers[0].channels == (0, 2)


def test_projections_of_several_channels_are_refused(renderer):
    with pytest.raises(al.StageError, match="shows values, and there are 2 channels of them"):
        renderer.render(drawn_with(TWO, channels(), integrate="mip"), SIZE)


def test_channels_that_are_not_there(renderer):
    with pytest.raises(al.AirlightError, match="FLAIR"):
        renderer.render(drawn_with(JointFunction((Axis("FLAIR", 0, 1), Axis("T1", 0, 1))), channels()), SIZE)
