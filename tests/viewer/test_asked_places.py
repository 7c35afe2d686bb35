"""Questions about places: joint histograms and what lies in them, probes, profiles, distances and slices."""

from __future__ import annotations

import io
import json
import math
import subprocess
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from PIL import Image as Pillow
from test_javascript import NODE, needs_node

import airlight as al
from airlight.rendering.image import Image
from airlight.transfer.colour import linear_to_srgb
from airlight.transfer.derivatives import pieces
from airlight.transfer.histogram import joint_histogram
from airlight.viewer.asked.joint import here, joint, neighbours, peak, proposal
from airlight.viewer.asked.probe import measures, probe, probe_at
from airlight.viewer.asked.profile import profile
from airlight.viewer.asked.slices import Plane, colours_of_labels, interpolated, slices
from airlight.viewer.asking import is_slow
from airlight.viewer.document import Document

SHEARED = np.array([[0.7, 0.2, 0.0, 5.0], [0.0, 1.1, -0.3, -4.0], [0.1, 0.0, 2.0, 1.0], [0, 0, 0, 1]])
SHAPES = Path(__file__).parents[2] / "src" / "airlight" / "viewer" / "web" / "joint" / "shapes.js"


class Asked:
    """What questions need of a session."""

    def __init__(self, scene: al.Scene, size_px: tuple[int, int] = (32, 24)) -> None:
        self.document, self.size_px, self.sent = Document(scene), size_px, []
        self.stream = SimpleNamespace(image=None)

    def send(self, message: dict[str, Any]) -> None:
        self.sent.append(message["type"])


def ball(size: int = 12, **given: Any) -> al.Volume:
    z, y, x = np.mgrid[-1 : 1 : size * 1j, -1 : 1 : size * 1j, -1 : 1 : size * 1j]
    return al.Volume((100 * np.exp(-3 * (x * x + y * y + z * z))).astype(np.float32), units="mm", value_unit="HU", **given)


def seen(volume: al.Volume, **given: Any) -> Asked:
    camera = al.Camera.orthographic(eye=(5.5, -30, 5.5), target=(5.5, 5.5, 5.5), up=(0, 0, 1), height=12)
    function = al.TransferFunction([(0, "black", 0), (20, "black", 0), (100, "orange", 4)])
    return Asked(al.Scene(layers=[al.Layer(volume, function, **given)], camera=camera))


def with_depth(session: Asked, t_world: float) -> Asked:
    """A session with a picture that has the same depth everywhere, and none in its first column."""
    width, height = session.size_px
    depth = np.full((height, width), t_world, dtype=np.float32)
    depth[:, 0] = np.inf
    rgba = np.zeros((height, width, 4), dtype=np.float32)
    session.stream.image = Image(rgba, depth, scene=session.document.scene)
    return session


# -- probe, profile, distances


def test_a_probe_tells_what_the_volume_holds() -> None:
    volume = ball()
    labels = np.zeros((12, 12, 12), dtype=np.uint8)
    labels[4:8, 4:8, 4:8] = 7
    session = with_depth(seen(volume, labels=al.Labels(labels, names={7: "core"})), 35.0)
    found = probe(session, 0.5, 0.5)
    assert found["hit"]
    assert found["value_unit"] == "HU"
    assert found["units"] == "mm"
    assert found["values"][0] == pytest.approx(volume.value_at(found["p_world"]), rel=1e-6)
    np.testing.assert_allclose(found["p_index"], found["p_world"], atol=1e-9)
    assert (found["label"], found["label_name"]) == (7, "core")
    assert found["t_world"] == 35.0
    again = probe_at(session, found["p_world"])
    assert again["values"][0] == pytest.approx(found["values"][0], rel=1e-6)
    json.dumps([found, again], allow_nan=False)


def test_a_probe_finds_what_is_faint() -> None:
    volume = ball()
    session = with_depth(seen(volume, density=0.02), math.inf)
    found = probe(session, 0.5, 0.5)
    assert found["faint"]
    # Faint is seen as a whole: the mean lies in the middle of the ball.
    assert found["p_world"] == pytest.approx([5.5, 5.5, 5.5], abs=0.3)
    assert found["values"][0] == pytest.approx(volume.value_at(found["p_world"]))
    assert probe(with_depth(seen(volume, density=0.0), math.inf), 0.5, 0.5) == {"hit": False}


def test_a_probe_that_misses_is_no_error() -> None:
    session = with_depth(seen(ball()), 35.0)
    assert probe(session, 0.0, 0.5) == {"hit": False}
    outside = probe_at(session, [99.0, 0.0, 0.0])
    assert not outside["hit"]
    assert outside["values"] == [None]
    with pytest.raises(al.AirlightError, match=r"probe\.x"):
        probe(session, 1.5, 0.5)
    with pytest.raises(al.AirlightError, match="layer"):
        probe_at(session, [0, 0, 0], 3)


def test_a_profile_is_that_of_the_library() -> None:
    session = with_depth(seen(ball()), 35.0)
    told, (buffer,) = profile(session, 0.5, 0.5)
    ray = al.ray_profile(session.document.scene, session.size_px, (16.0, 12.0))
    rows = np.frombuffer(buffer, "<f4").reshape(3 + told["channels"], told["count"])
    for row, expected in zip(rows, (ray.t_world, ray.extinction, ray.opacity, ray.value), strict=True):
        np.testing.assert_allclose(row, expected, rtol=1e-6, atol=1e-12)
    assert told["t_mean"] is not None
    # What is seen lies before the middle, behind where the ray goes in.
    assert ray.t_world[0] < told["t_mean"] < 35.5
    way = np.array(told["origin"]) + ray.t_world[:, None] * told["direction"]
    np.testing.assert_allclose(way, ray.p_world)
    hidden = seen(ball(), visible=False)
    assert profile(with_depth(hidden, 35.0), 0.5, 0.5)[0]["count"] == 0


def test_distances_and_angles_are_kept() -> None:
    session = seen(ball())
    kept = [[[0, 0, 0], [3, 4, 0]], [[1, 0, 0], [0, 0, 0], [0, 0, 9]], [[1, 1, 1], [1, 1, 1]]]
    told = measures(session, kept)["measures"]
    assert [one["value"] for one in told] == pytest.approx([5, 90, 0])
    assert [one["text"] for one in told] == ["5 mm", "90°", "0 mm"]
    assert measures(session)["measures"] == told
    assert measures(session, [])["measures"] == []
    with pytest.raises(al.AirlightError, match="two, or three"):
        measures(session, [[[0, 0, 0]]])


# -- the joint histogram


def test_the_picture_is_the_histogram_of_the_library() -> None:
    session = seen(ball())
    told, (shades, linear) = joint(session)
    assert joint(session)[1][0] == shades
    assert session.sent.count("progress") == 1  # counted once
    counted = joint_histogram(session.document.scene.layers[0].volume)
    assert [axis["variable"] for axis in told["axes"]] == ["value", "gradient"]
    assert [axis["unit"] for axis in told["axes"]] == ["HU", "HU/mm"]
    assert shades == counted.image().tobytes()
    on = np.frombuffer(linear, np.uint8).reshape(256, 256)
    np.testing.assert_array_equal(on > 0, counted.counts[::-1] > 0)
    axes = [{"variable": "value", "low": 0, "high": 50}, "gradient", {"variable": "second", "low": -9, "high": 9}]
    told, buffers = joint(session, variables=axes)
    assert [len(buffer) for buffer in buffers] == [256 * 256, 256 * 256, 128]
    assert told["axes"][0]["high"] == 50
    assert all(0 <= value <= 50 for value, _ in told["axes"][0]["ticks"])
    json.dumps(told, allow_nan=False)


@pytest.mark.parametrize("p_world", [(5.5, 5.5, 5.5), (3.2, 5.0, 6.1), (0.0, 0.0, 0.0), (11.0, 11.0, 11.0)])
def test_marks_are_the_samples_round_a_point(p_world: tuple[float, float, float]) -> None:
    volume = ball(world_from_index=np.diag([1.0, 1.0, 1.0, 1.0]))
    session = seen(volume)
    axes = [{"variable": "value", "low": 0, "high": 110}, {"variable": "gradient", "low": 0, "high": 40}]
    told = here(session, list(p_world), axes)
    assert sum(told["weights"]) == pytest.approx(1)
    corner = p_world in ((0.0, 0.0, 0.0), (11.0, 11.0, 11.0))
    assert len(told["marks"]) == (8 if corner else 27)
    assert told["at"][0] == pytest.approx(volume.value_at(p_world), rel=1e-6)
    # Both proposals are shapes that a function of these axes takes.
    made = al.JointFunction.from_dict({"axes": axes, "shapes": [told["around"], told["peak"]]})
    weight = made.shapes[0].weight(np.array([told["at"]]), np.array([110.0, 40.0]))
    assert weight[0] > 0.2


def test_neighbours_are_those_of_the_whole_volume(rng: np.random.Generator) -> None:
    array = rng.normal(size=(2, 9, 8, 7))
    array[0, 4, 4, 3] = np.nan
    volume = al.Volume(array, world_from_index=SHEARED, channel_names=["a", "b"])
    layer = al.Layer(volume, channel=0)
    whole = next(pieces(volume))
    for index in ((3, 4, 4), (1, 2, 8), (6, 0, 0)):
        p_world = SHEARED[:3, :3] @ index + SHEARED[:3, 3]
        found, p_index = neighbours(layer, p_world, ("value", "gradient", "second", "b"))
        assert len(found) < 27
        x, y, z = p_index.astype(int).T
        np.testing.assert_allclose(found[:, 1], whole.gradient[z, y, x])
        np.testing.assert_allclose(found[:, 2], whole.second[z, y, x])
        np.testing.assert_allclose(found[:, 3], array[1, z, y, x])
    assert len(neighbours(layer, np.array([1e3, 0, 0]), ("value", "gradient"))[0]) == 0


def test_a_peak_is_added_to_what_is_there() -> None:
    session = seen(ball())
    base = {"points": [[0.0, [0, 0, 1], 0.5], [100.0, [0, 0, 1], 0.5]]}
    alone = al.TransferFunction.from_dict(peak(session, [5.5, 5.5, 2.0])["transfer"])
    both = al.TransferFunction.from_dict(peak(session, [5.5, 5.5, 2.0], base=base)["transfer"])
    value = ball().value_at((5.5, 5.5, 2.0))
    assert both(value)[1] == pytest.approx(max(alone(value)[1], 0.5))
    assert both(99.0)[1] == pytest.approx(0.5)
    with pytest.raises(al.AirlightError, match="outside"):
        peak(session, [99, 0, 0])


def test_the_proposal_is_that_of_the_library() -> None:
    away = np.sqrt(sum((axis - 15.5) ** 2 for axis in np.mgrid[0:32, 0:32, 0:32]))
    noise = np.random.default_rng(4).normal(scale=0.3, size=away.shape)
    volume = al.Volume((50 - 50 * np.tanh((away - 9) / 1.5) + noise).astype(np.float32))
    told = proposal(Asked(al.Scene(volume)))
    assert al.JointFunction.from_dict(told["transfer"]) == al.automatic.boundary_joint_function(volume)


@needs_node
def test_shapes_of_the_editor_are_shapes_of_the_library() -> None:
    program = f"""
import {{ fresh, handles, pulled, shifted, withThird, withVariables }} from {json.dumps(SHAPES.as_uri())};
let seed = 3;
const random = (low, high) => low + ((high - low) * (seed = (seed * 48271) % 2147483647)) / 2147483647;
const ends = {{ value: [-1000, 3000], gradient: [5, 80], second: [-9, 9] }};
const axes = Object.entries(ends).map(([variable, [low, high]]) => ({{ variable, low, high }}));
const two = axes.slice(0, 2);
const made = [];
for (const kind of ["triangle", "box", "ellipse", "polygon"]) {{
  let shape = fresh(kind, axes, [random(-1000, 3000), random(0, 80)], [1, 0, 0], 1);
  for (let n = 0; n < 25; n++) {{
    const all = handles(shape, axes);
    if (n % 3) shape = pulled(shape, axes, all[n % all.length].name, [random(-3000, 6000), random(-60, 150)]);
    else shape = shifted(shape, axes, [random(-2e3, 2e3), random(-50, 50)]);
    shape = withThird(shape, axes, [random(-12, 12), random(-12, 12)]);
    made.push({{ axes, shapes: [shape] }}, {{ axes: two, shapes: [withVariables(shape, two)] }});
  }}
}}
console.log(JSON.stringify(made));
"""
    assert NODE is not None
    done = subprocess.run(
        [NODE, "--no-warnings", "--input-type=module"], input=program, capture_output=True, text=True, timeout=60, check=True
    )
    functions = [al.JointFunction.from_dict(data) for data in json.loads(done.stdout)]
    assert {len(function.axes) for function in functions} == {2, 3}
    assert len(functions) == 200


# -- slices


def plane_of(volume: al.Volume, right: Any, up: Any, pixel: float, size_px: tuple[int, int]) -> Plane:
    right = np.asarray(right, float) / np.linalg.norm(right)
    up = np.asarray(up, float) - (np.asarray(up, float) @ right) * right
    middle = volume.corners_world().mean(axis=0) + 0.1
    return Plane(middle, right, up / np.linalg.norm(up), pixel, size_px)


@given(
    seed=st.integers(0, 1 << 30),
    kind=st.sampled_from(["uint8", "int16", "float32", "float64", "bool"]),
    empty=st.booleans(),
    size=st.tuples(st.integers(1, 6), st.integers(2, 6), st.integers(2, 6)),
)
def test_slices_interpolate_as_the_volume_does(seed: int, kind: str, empty: bool, size: tuple[int, int, int]) -> None:
    rng = np.random.default_rng(seed)
    array = (rng.random(size) * 200 - (0 if kind == "uint8" else 100)).astype(kind)
    if empty and kind.startswith("float"):
        array[rng.random(size) < 0.3] = np.nan
    volume = al.Volume(array, world_from_index=SHEARED, no_data=3 if empty and kind == "int16" else None)
    plane = plane_of(volume, rng.normal(size=3), rng.normal(size=3), 0.37, (23, 17))
    expected = np.asarray(volume.value_at(plane.p_world))
    found = interpolated(volume, plane)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-3)


def decoded(data: bytes) -> np.ndarray[Any, Any]:
    return np.asarray(Pillow.open(io.BytesIO(data)).convert("RGBA"))


def test_slices_are_pictures_of_a_window() -> None:
    volume = ball(anatomical=True)
    session = seen(volume)
    asked = {"centre_world": [5.5, 5.5, 5.5], "right": [1, 0, 0], "up": [0, -1, 0], "pixel_world": 1.0, "size_px": [16, 12]}
    told, (data,) = slices(session, [asked], [0, 50])
    picture = decoded(data)
    assert picture.shape == (12, 16, 4)
    # Pixels lie on voxels here: the middle column, from the front to the back, and nothing beside the volume.
    plane = Plane.from_dict(asked, "plane")
    values = volume.value_at(plane.p_world)
    there = ~np.isnan(values)
    np.testing.assert_array_equal(picture[..., 3], np.where(there, 255, 0))
    shade = np.rint(np.clip(values[there] * 255 / 50, 0, 255))
    assert np.abs(picture[..., 0][there] - shade).max() <= 1
    assert told["planes"][0]["letters"] == {"left": "R", "right": "L", "up": "A", "down": "P"}
    assert told["planes"][0]["bar"] == "2 mm"
    assert told["planes"][0]["bar_px"] == 2
    assert slices(session, [], [0, 1]) == ({"planes": []}, [])


def test_slices_show_regions_that_are_shown() -> None:
    labels = np.zeros((12, 12, 12), dtype=np.uint16)
    labels[:, :6], labels[:, 6:, :6] = 3, 5
    regions = al.Labels(al.Volume(labels), {3: "#ff0000", 5: "#0000ff"})
    session = seen(ball(), labels=regions)
    asked = {"centre_world": [5.5, 5.5, 5.5], "right": [1, 0, 0], "up": [0, -1, 0], "pixel_world": 1.0, "size_px": [12, 12]}
    (data,) = slices(session, [asked], [0, 1e6], label_opacity=1.0)[1]
    picture = decoded(data)[..., :3]
    assert picture[0, 0].tolist() == [255, 0, 0]
    assert picture[11, 0].tolist() == [0, 0, 255]
    assert picture[11, 11].max() <= 1
    layer = session.document.scene.layers[0]
    hidden = replace(session.document.scene, layers=[replace(layer, labels=regions.hide(3))])
    (data,) = slices(Asked(hidden), [asked], [0, 1e6], label_opacity=1.0)[1]
    assert decoded(data)[0, 0, :3].max() <= 1


@pytest.mark.parametrize("highlighted", [(), (5,)])
def test_slices_show_regions_in_the_colours_in_which_they_are_drawn(highlighted: tuple[int, ...]) -> None:
    ids = [-4, 0, 2, 5, 9, 70_000]
    array = np.resize(np.array(ids, dtype=np.int32), (12, 12, 12))
    styles = {2: al.LabelStyle("#20c0f0", 0.5), 9: al.TransferFunction([(0, "red", 1), (1, "red", 1)])}
    labels = al.Labels(al.Volume(array), styles).hide(-4).highlight(highlighted)
    found = colours_of_labels(al.Layer(ball(), labels=labels), np.array(ids, dtype=np.int32))
    for label, (*srgb, opacity) in zip(ids, found.tolist(), strict=True):
        assert opacity == pytest.approx(labels.opacity_of(label) if label else 0, abs=1e-6)
        if opacity:
            np.testing.assert_allclose(srgb, linear_to_srgb(np.clip(labels.tint_of(label), 0, 1)), atol=1e-6)


def test_what_takes_long_holds_up_no_probe() -> None:
    slow = ("histogram", "joint", "joint.proposal", "presets", "presets.function", "presets.picture")
    assert all(map(is_slow, slow))
    assert not any(map(is_slow, ("probe", "probe.at", "profile", "slices", "joint.here", "labels")))


@pytest.mark.parametrize(
    ("changes", "window", "named"),
    [
        ({"up": [1, 0, 0]}, [0, 1], "up"),
        ({"pixel_world": 0}, [0, 1], "pixel_world"),
        ({"size_px": [9, 1 << 20]}, [0, 1], "size_px"),
        ({"size_px": [math.nan, 4]}, [0, 1], "size_px"),
        ({"extra": 1}, [0, 1], "plane"),
        ({}, [1, 0], "window"),
    ],
)
def test_planes_that_are_none_are_refused(changes: dict[str, Any], window: list[float], named: str) -> None:
    asked = {"centre_world": [5.5, 5.5, 5.5], "right": [1, 0, 0], "up": [0, -1, 0], "pixel_world": 1.0, "size_px": [8, 8]}
    with pytest.raises(al.AirlightError, match=named):
        slices(seen(ball()), [asked | changes], window)
