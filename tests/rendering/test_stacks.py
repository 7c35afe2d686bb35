"""Stacks of 2-D textures: fields over them, and the drivers of object-aligned slices and of stripes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import function, lights, rotation

import airlight as al
from airlight import reference
from airlight.errors import LimitError, StageError, ValueRangeError
from airlight.gpu.stacks import check_layers, layered, turned
from airlight.rendering.layers import read_layers
from airlight.stage import Context, Stack
from airlight.stages.driver_stacks import facing_planes
from airlight.stages.field_stack import facing_layers
from airlight.stages.view_rays import least_cosine

LEVEL = 1 / 255
SIZE = (26, 22)
SIDES = {"x": (1.0, 0.3, 0.2), "y": (0.2, -1.0, 0.3), "z": (0.1, 0.2, -1.0)}
DRIVERS = {
    "object": al.driver.ObjectSlices(group=5),
    "interpolated": al.driver.InterpolatedSlices(),
    "stripes": al.driver.Stripes(),
    "object stripes": al.driver.Stripes(aligned="object", axis="x"),
}
FILTERS = {
    "nearest": al.field.Nearest(),
    "bspline": al.field.BSpline(),
    "mitchell": al.field.Mitchell(),
    "windowed_sinc": al.field.WindowedSinc(radius=2),
    "kernel_body": al.field.KernelBody(),
}
ISO = al.integrate.FirstHit(iso=70.0)


def sheared_matrix() -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 2, 3), 0.4) @ np.array([[1, 0.25, 0], [0, 1.3, 0.2], [0, 0, 0.8]])
    matrix[:3, 3] = (5, -3, 2)
    return matrix


@cache
def sheared(dtype: str = "float32") -> al.Volume:
    """A field without symmetry on a sheared, anisotropic grid of three different sizes."""
    z, y, x = np.mgrid[-1:1:14j, -1:1:12j, -1:1:13j]
    field = np.exp(-2 * (x * x + 1.5 * y * y + z * z)) * 100 + 8 * np.sin(3 * x) * np.cos(2 * y) + 20
    return al.Volume(field.astype(dtype), world_from_index=sheared_matrix())


def camera_from(volume: al.Volume, way, is_flat: bool = False, away: float = 3.0, fov_deg: float = 40.0) -> al.Camera:
    corners = volume.corners_world()
    middle = corners.mean(axis=0)
    reach = float(np.linalg.norm(corners - middle, axis=1).max())
    place = {"eye": tuple(middle - away * reach * np.array(way) / np.linalg.norm(way)), "target": tuple(middle)}
    if is_flat:
        return al.Camera.orthographic(**place, up=(0.1, 0.3, 1.0), height=1.9 * reach)
    return al.Camera.perspective(**place, up=(0.1, 0.3, 1.0), fov_deg=fov_deg)


def seen(way="y", is_flat: bool = False, volume: al.Volume | None = None, labels=None, **look) -> al.Scene:
    volume = volume or sheared()
    camera = camera_from(volume, SIDES.get(way, way), is_flat)
    layer = al.Layer(volume, transfer=function(), look=al.Look(**look), labels=labels)
    return al.Scene(layers=[layer], camera=camera, lights=lights(), background=None)


def truth_of(drawn: al.Scene, driver) -> np.ndarray:
    """Reference on the driver's slices, through the field that it reads."""
    read = replace(drawn, layers=read_layers(drawn.layers, driver))
    return reference.render(read, SIZE, driver=driver, blocks=False).rgba


# -- fields


def test_fields_over_stacks_are_those_over_grids(any_renderer):
    for way, dtype in zip(SIDES, ("uint8", "int16", "float32"), strict=True):
        drawn = [seen(way, volume=sheared(dtype), shade="none", field=field) for field in ("stack", "linear")]
        stack, grid = (any_renderer.render(one, SIZE) for one in drawn)
        assert np.abs(stack.rgba - grid.rgba).max() <= LEVEL / 8
        assert stack.stats["layers"][0]["stacks"]["drawn"] == way


@pytest.mark.parametrize("shape", [(1, 12, 13), (14, 1, 13), (14, 12, 1)])
def test_an_axis_of_one_voxel_is_one_layer(renderer, shape):
    samples = np.random.default_rng(3).uniform(40, 110, shape).astype(np.float32)
    volume = al.Volume(samples, spacing=(1, 1.5, 2))
    for way in SIDES:
        stack, grid = (renderer.render(seen(way, volume=volume, shade="none", field=f), SIZE) for f in ("stack", "linear"))
        assert np.abs(stack.rgba - grid.rgba).max() <= LEVEL / 8


@pytest.mark.parametrize(
    ("channels", "field", "name"),
    [
        (1, "linear", "linear_masked"),
        (6, "linear", "linear_channels_masked"),
        (1, "bspline", "bspline_exact"),
        (1, "preclassified", "preclassified_masked"),
    ],
)
def test_gaps_and_channels_lie_in_stacks_too(any_renderer, channels, field, name):
    """Six channels, in two groups of four, each with a gap of its own; one channel with gaps."""
    parts = [np.roll(sheared().array, number, axis=number % 3) for number in range(channels)]
    for number, part in enumerate(parts):
        part[5:8, number : number + 3, 4:9] = np.nan
    array = np.stack(parts) if channels > 1 else parts[0]
    volume = al.Volume(array, world_from_index=sheared_matrix())
    mixes = {"transfer": "postclassified"} if channels > 1 else {}
    look = al.Look(field=field, shade="none", **mixes)
    functions = [function()] * channels if channels > 1 else function()
    drawn = al.Scene(volume, transfer=functions, camera=camera_from(volume, SIDES["x"]), look=look, background=None)
    images = [any_renderer.render(drawn, SIZE, driver=driver) for driver in (al.driver.Stripes(axis="y"), "slices")]
    assert np.abs(images[0].rgba - images[1].rgba).max() <= LEVEL / 8
    assert [image.stats["layers"][0]["stages"]["field"] for image in images] == [name, name]


def test_several_channels_lie_in_layers(renderer):
    """By the texture unit, groups one behind the other."""
    volume = al.Volume(np.stack([np.roll(sheared().array, n, axis=n % 3) for n in range(6)]), world_from_index=sheared_matrix())
    look = al.Look(transfer="postclassified")
    drawn = al.Scene(volume, transfer=[function()] * 6, camera=camera_from(volume, SIDES["x"]), look=look, background=None)
    images = [renderer.render(drawn, SIZE, driver=driver).rgba for driver in (al.driver.Stripes(axis="y"), "slices")]
    assert np.abs(images[0] - images[1]).max() <= LEVEL / 8


@given(size=st.tuples(*[st.integers(1, 5)] * 3), axis=st.integers(0, 2))
def test_layers_hold_each_voxel_at_its_place(size, axis):
    samples = np.arange(np.prod(size)).reshape(size[::-1])
    layers = layered(samples, axis)
    width, height, count = turned(size, axis)
    assert layers.shape == (count, height, width)
    p_index = np.array([n - 1 for n in size])
    u, v = (n for other, n in enumerate(p_index) if other != axis)
    assert layers[p_index[axis], v, u] == samples[tuple(p_index[::-1])]


def test_too_many_layers_are_refused_before_anything_is_uploaded():
    limits = {"max-texture-dimension-2d": 16, "max-texture-array-layers": 13}
    device = SimpleNamespace(info=SimpleNamespace(name="A device"), limits=limits)
    check_layers(device, Stack(sheared(), (0,), 0, True, axis=0), 1)
    with pytest.raises(LimitError, match=r"14 layers along z; A device holds at most 13 .*use the driver slices or march"):
        check_layers(device, Stack(sheared(), (0,), 0, True, axis=2), 1)
    with pytest.raises(LimitError, match="12 layers along y for each of 2 groups"):
        check_layers(device, Stack(sheared(), (0,), 0, True, axis=1), 2)
    limits["max-texture-dimension-2d"] = 13
    with pytest.raises(LimitError, match="layers of 12 x 14 voxels along x"):
        check_layers(device, Stack(sheared(), (0,), 0, True, axis=0), 1)


class Own(al.field.Field):
    """A field from outside: the mean of two places half a voxel apart."""

    name = "own"
    filtered = True
    wgsl = """
import generated::layer::layer;
import generated::sizes::Values;
import package::ray::INFINITE;
import slot::voxels::sample_at;
struct Place { p_index: vec3f }
fn locate(p_index: vec3f) -> Place { return Place(p_index); }
fn field_value(place: Place) -> Values {
  let mean = (sample_at(place.p_index - 0.25).r + sample_at(place.p_index + 0.25).r) / 2.0;
  return mean * layer.value_scale + layer.value_offset;
}
fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
"""


class Inward(Own):
    """A field that looks into the texture itself."""

    name = "inward"
    wgsl = Own.wgsl.replace("slot::voxels::sample_at", "generated::inward::grid")


def test_fields_from_outside_are_read_from_layers(renderer):
    own, inward = (dataclass(frozen=True)(one)() for one in (Own, Inward))
    drawn = seen("y", field=own)
    march, layers = (renderer.render(drawn, SIZE, driver=driver).rgba for driver in ("slices", al.driver.Stripes(axis="x")))
    assert np.abs(march - layers).max() <= LEVEL / 8
    with pytest.raises(StageError, match=r"look.field 'inward' looks into the grid's 3-D texture itself.*slot::voxels"):
        renderer.render(seen("y", field=inward), SIZE, driver="stripes")


@pytest.mark.parametrize("way", SIDES)
def test_coarser_levels_are_read_from_layers(renderer, way):
    """Pixels as wide as two, or about six voxels; layers of each axis, whose numbers differ."""
    for bias in (1.0, 2.6):
        drawn = seen("y", field=al.field.Levels(bias=bias), gradient="analytic")
        driver = al.driver.Stripes(axis=way)
        slices, stripes = (renderer.render(drawn, SIZE, driver=one) for one in ("slices", driver))
        assert np.abs(slices.rgba - stripes.rgba).max() <= LEVEL
        assert np.abs(stripes.rgba - truth_of(drawn, driver)).max() <= LEVEL / 8
    fine = renderer.render(seen("y", gradient="analytic"), SIZE, driver="stripes").rgba
    assert np.abs(fine - stripes.rgba).max() > 10 * LEVEL


# -- drivers


@pytest.mark.parametrize(
    ("look", "driver"),
    [
        *(({"shade": "none"}, driver) for driver in DRIVERS),
        *(({"shade": "none", "transfer": "postclassified"}, driver) for driver in ("object", "interpolated")),
        *(({"shade": "none", "field": "preclassified"}, driver) for driver in ("object", "stripes")),
        *(({"lighting": "interpolated", "gradient": "analytic"}, driver) for driver in ("object", "interpolated")),
    ],
    ids=str,
)
def test_slices_over_stacks_agree_with_the_reference(renderer, look, driver):
    for way, is_flat in (("x", True), ("y", False), ("z", False)):
        drawn = seen(way, is_flat, **look)
        image = renderer.render(drawn, SIZE, driver=DRIVERS[driver])
        assert np.abs(image.rgba - truth_of(drawn, DRIVERS[driver])).max() <= LEVEL


@pytest.mark.parametrize("field", [*FILTERS, "bspline through samples"])
def test_filters_are_read_from_layers(any_renderer, field):
    """Lit by their own derivatives; parallel rays, so that samples lie where those of the march do."""
    made = FILTERS.get(field, al.field.BSpline(prefilter=True))
    gradient = "analytic" if made.differentiable else "central"
    drawn = seen((0.3, 1.0, 0.5), True, field=made, gradient=gradient)
    march, stripes = (any_renderer.render(drawn, SIZE, driver=driver) for driver in ("march", al.driver.Stripes(axis="x")))
    assert np.abs(march.rgba - stripes.rgba).max() <= LEVEL / 2
    assert stripes.stats["layers"][0]["stacks"]["drawn"] == "x"
    assert march.stats["layers"][0]["stages"]["field"] == stripes.stats["layers"][0]["stages"]["field"]


@pytest.mark.parametrize("field", FILTERS)
def test_filters_on_layers_agree_with_the_reference(renderer, field):
    drawn = seen("x", field=FILTERS[field], gradient="analytic" if FILTERS[field].differentiable else "central")
    for driver in (DRIVERS["object"], DRIVERS["interpolated"]):
        image = renderer.render(drawn, SIZE, driver=driver)
        assert np.abs(image.rgba - truth_of(drawn, driver)).max() <= LEVEL


@pytest.mark.parametrize(
    "look", [{"integrate": "mip"}, {"integrate": "weighted_sum"}, {"integrate": ISO}], ids=["mip", "sum", "iso"]
)
def test_projections_and_surfaces(core_renderer, look):
    driver, drawn = DRIVERS["object"], seen("y", shade="none", **look)
    image = core_renderer.render(drawn, SIZE, driver=driver)
    difference = np.abs(image.rgba - truth_of(drawn, driver)).max(axis=-1)
    assert np.quantile(difference, 0.99) <= LEVEL  # a ray along the rim of a surface may fall to either side


def test_labels_are_drawn(renderer):
    numbers = np.zeros(sheared().array.shape, dtype=np.uint8)
    numbers[:, :6] = 1
    labels = al.Labels(al.Volume(numbers, world_from_index=sheared_matrix())).hide(1)
    drawn = seen("z", labels=labels, shade="none")
    image = renderer.render(drawn, SIZE, driver=DRIVERS["interpolated"])
    assert np.abs(image.rgba - truth_of(drawn, DRIVERS["interpolated"])).max() <= LEVEL
    assert np.abs(image.rgba - renderer.render(seen("z", shade="none"), SIZE, driver=DRIVERS["interpolated"]).rgba).max() > 0.1


@pytest.mark.parametrize("way", SIDES)
def test_stripes_are_slices_over_a_third_of_the_bytes(renderer, way):
    drawn = seen(way, shade="none")
    slices, stripes = (renderer.render(drawn, SIZE, driver=driver) for driver in ("slices", "stripes"))
    assert np.abs(slices.rgba - stripes.rgba).max() <= LEVEL / 8
    assert stripes.stats["layers"][0]["stacks"]["drawn"] == "z"


def test_each_axis_that_was_faced_keeps_a_stack(renderer):
    volume = al.Volume(sheared().array.copy(), world_from_index=sheared_matrix())
    found = {}
    for way in ("x", "z"):
        found = renderer.render(seen(way, volume=volume, shade="none"), SIZE, driver="object_slices").stats["layers"][0]
    assert found["stacks"] == {"drawn": "z", "bytes": dict.fromkeys("xz", found["textures"][0]["bytes"])}
    assert found["textures"][0]["bytes"] % np.prod(volume.size) == 0


def test_samples_of_object_slices_lie_on_layers(renderer):
    """What lies between two layers, and no ray ends there, is read from neither: fields with and without agree."""
    drawn = [seen("z", True, shade="none", field=al.field.LinearStack(between=b)) for b in (True, False)]
    a, b = (renderer.render(one, SIZE, driver=DRIVERS["object"]).rgba for one in drawn)
    middle = (slice(SIZE[1] // 2 - 2, SIZE[1] // 2 + 2), slice(SIZE[0] // 2 - 2, SIZE[0] // 2 + 2))
    assert np.abs(a - b)[middle].max() <= LEVEL / 8
    assert (
        renderer.render(seen("z", step := True, shade="none"), SIZE, driver="object_slices", step=2).stats["slices"]["count"]
        <= 9
    )
    assert step


def test_without_correction_opacity_forgets_the_angle(renderer):
    """A homogeneous box in perspective: rays through both of its large faces have the opacity of one at right angles."""
    volume = al.Volume(np.full((6, 24, 24), 1.0, dtype=np.float32), spacing=(1, 1, 2))
    even = al.TransferFunction([(0, "white", 0.07), (2, "white", 0.07)])
    camera = al.Camera.perspective(eye=(11.5, 11.5, 40), target=(11.5, 11.5, 0), up=(0, 1, 0), fov_deg=30)
    drawn = al.Scene(volume, transfer=even, camera=camera, look=al.Look(shade="none"), background=None)
    flat, real = (renderer.render(drawn, SIZE, driver=al.driver.ObjectSlices(corrects=c)).rgba[..., 3] for c in (False, True))
    assert np.abs(flat[1:-1, 1:-1] - (1 - np.exp(-0.07 * 10))).max() <= 1e-5
    assert real[1, 1] > real[SIZE[1] // 2, SIZE[0] // 2] + 0.005
    # Each of several layers forgets it, too.
    both = al.Scene(layers=2 * drawn.layers, camera=camera, background=None)
    twice = renderer.render(both, SIZE, driver=al.driver.ObjectSlices(corrects=False)).rgba[..., 3]
    assert np.abs(twice[1:-1, 1:-1] - (1 - np.exp(-0.14 * 10))).max() <= 1e-5


def test_pictures_pop_where_the_axis_changes(renderer):
    """Just below and just above half a right angle: object slices jump, a stack of one axis does not."""
    ball = al.Volume(sheared().array[:12, :12, :12], spacing=(1, 1, 1))
    jumps = {}
    for driver in ("object_slices", "stripes"):
        ways = [(np.sin(a), np.cos(a), 0.05) for a in np.radians((44.9, 45.1))]
        images = [
            renderer.render(seen(way, True, ball, shade="none", transfer="postclassified"), SIZE, driver=driver) for way in ways
        ]
        jumps[driver] = np.abs(images[0].rgba - images[1].rgba).max()
    assert jumps["object_slices"] > 3 * jumps["stripes"]


# -- where slices lie


@settings(max_examples=30)
@given(
    way=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda way: np.linalg.norm(way) > 0.2),
    is_flat=st.booleans(),
    away=st.floats(0.1, 4),
)
def test_the_layers_that_are_chosen_face_the_view_most(way, is_flat, away):
    camera = camera_from(sheared(), way, is_flat, away)
    volume, corners = sheared(), sheared().corners_world(cells=True)
    axis, side = facing_layers(volume, camera, SIZE)
    planes = facing_planes(camera, Context(volume, function(), (0,), 0, 1.0, SIZE))
    rows = volume.index_from_world[:3, :3]
    cosines = [least_cosine(s * row / np.linalg.norm(row), camera, SIZE, corners) for s in (1, -1) for row in rows]
    assert least_cosine(planes.normal, camera, SIZE, corners) == pytest.approx(max(cosines), abs=1e-12)
    # Whole numbers of planes are whole numbers of layers.
    p_index = np.array([2.0, 3.0, 4.0])
    p_index[axis] = 7
    p_world = volume.world_from_index[:3, :3] @ p_index + volume.world_from_index[:3, 3]
    assert (planes.normal @ p_world - planes.first) / planes.spacing_world == pytest.approx(side * 7, abs=2e-3)


@settings(max_examples=30)
@given(
    way=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda way: np.linalg.norm(way) > 0.2),
    away=st.floats(0.1, 4),
    fov_deg=st.floats(5, 150),
    place=st.tuples(*[st.floats(0, 1)] * 2),
)
def test_no_ray_that_meets_the_volume_is_more_askew(way, away, fov_deg, place):
    """Against a ray of the image to a point of the volume."""
    volume = sheared()
    camera = camera_from(volume, way, away=away, fov_deg=fov_deg)
    corners = volume.corners_world(cells=True)
    p_world = corners[:4].mean(axis=0) + place[0] * (corners[0] - corners[3]) / 2 + place[1] * (corners[4] - corners[0])
    _, _, forward = camera.basis()
    to = p_world - np.array(camera.eye)
    depth = float(to @ forward)
    half = np.tan(np.radians(fov_deg) / 2)
    right, up, _ = camera.basis()
    inside = depth > 0 and abs(to @ up) <= half * depth and abs(to @ right) <= half * depth * SIZE[0] / SIZE[1]
    for normal in (*np.eye(3), *-np.eye(3)):
        least = least_cosine(normal, camera, SIZE, corners)
        assert not inside or least <= 0 or to @ normal / np.linalg.norm(to) >= least - 1e-9


def test_interpolated_slices_are_a_step_apart_along_the_view(renderer):
    drawn = seen("y", True, shade="none")
    camera = drawn.camera
    for step in (0.5, 1.7):
        context = Context(sheared(), function(), (0,), 0, step, SIZE)
        planes = al.driver.InterpolatedSlices().planes(camera, context)
        assert planes.spacing_world / (planes.normal @ camera.basis()[2]) == pytest.approx(step)


def test_what_cannot_be_sliced_is_refused(renderer):
    with pytest.raises(ValueRangeError, match=r"step is 0.5 voxels, and the driver 'object_slices' has no slices between"):
        renderer.render(seen(shade="none"), SIZE, driver="object_slices", step=0.5)
    assert renderer.render(seen(shade="none"), SIZE, driver="object_slices", budget_ms=1e5).stats["budget"]["step"] == 1
    inside = replace(seen(shade="none"), camera=camera_from(sheared(), (1, 1, 1), away=0.05, fov_deg=120))
    for driver in ("object_slices", "interpolated_slices"):
        with pytest.raises(ValueRangeError, match=rf"camera sees slices of the driver '{driver}' from the edge"):
            renderer.render(inside, SIZE, driver=driver)
    assert renderer.render(inside, SIZE, driver="stripes").rgba[..., 3].max() > 0
