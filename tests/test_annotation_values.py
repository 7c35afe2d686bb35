"""Annotations as values: what they refuse, where they lie, how they are saved and drawn on a picture."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import airlight as al
from airlight import annotations
from airlight.annotations.base import Room, Shown, View, round_below
from airlight.annotations.drawing import over, overlay
from airlight.annotations.marks import Bar, Patch, Text, width_of
from airlight.annotations.scale_bar import length_text
from airlight.errors import DataError, StageError, ValueRangeError
from airlight.transfer.colour import linear_to_srgb

CORNERS = np.array(list(itertools.product((-40.0, 60.0), (10.0, 35.0), (-5.0, 80.0))))
MIDDLE = CORNERS.mean(axis=0)
TF = al.TransferFunction([(-100, "black", 0.0), (250, "#c04020", 0.5), (1000, "white", 2.0)])
EVERY = (
    al.ScaleBar(length=20, color="red"),
    al.ColorBar(layer=0, side="left", title="density"),
    al.Grid(step=10, labels=False, color=(0.1, 0.2, 0.3)),
    al.Axes(origin=(1, 2, 3), length=5),
    al.Orientation(),
    al.Pointer((1, 2, 3), shape="arrow", size_voxels=4, label="here"),
    al.Pointer((1, 2, 3), size_px=12, color="lime"),
)


def view(camera: al.Camera | None = None, size_px: tuple[int, int] = (320, 240), **changes) -> View:
    camera = camera or al.fit_camera("iso", CORNERS, size_px[0] / size_px[1], margin=1.3)
    layers = (Shown((("", TF),), "HU"),)
    return dataclasses.replace(View(camera, size_px, CORNERS, 0.5, "mm", True, layers), **changes)


def seen_from(way, perspective: bool = True, far: float = 300.0) -> al.Camera:
    eye = tuple(MIDDLE + far * np.asarray(way) / np.linalg.norm(way))
    up = (0, 0, 1) if abs(way[2]) < 0.9 * np.linalg.norm(way) else (0, 1, 0)
    if perspective:
        return al.Camera.perspective(eye=eye, target=tuple(MIDDLE), up=up)
    return al.Camera.orthographic(eye=eye, target=tuple(MIDDLE), up=up, height=180)


cameras = st.builds(
    seen_from,
    st.tuples(*[st.floats(-1, 1).map(lambda c: round(c, 3))] * 3).filter(lambda way: np.linalg.norm(way) > 0.1),
    st.booleans(),
)
sizes = st.tuples(st.integers(40, 1500), st.integers(40, 1500))


# -- values


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: al.ScaleBar(length=0), "scale_bar.length is 0, must be above 0"),
        (lambda: al.ScaleBar(color="reddish"), "scale_bar.color"),
        (lambda: al.ColorBar(layer=-1), "color_bar.layer is -1"),
        (lambda: al.ColorBar(side="top"), "color_bar.side is 'top', must be one of left, right"),
        (lambda: al.ColorBar(title=3), "color_bar.title is 3"),
        (lambda: al.Grid(step=float("nan")), "grid.step is nan"),
        (lambda: al.Grid(labels="yes"), "grid.labels is 'yes', must be true or false"),
        (lambda: al.Axes(origin=(1, 2)), r"axes.origin is \(1, 2\): give 3 numbers"),
        (lambda: al.Axes(length=-1), "axes.length is -1"),
        (lambda: al.Pointer((1, 2, "z")), r"pointer.p_world\[2\] is 'z'"),
        (lambda: al.Pointer((1, 2, 3), shape="ring"), "pointer.shape is 'ring', must be one of cross, arrow"),
        (lambda: al.Pointer((1, 2, 3), size_px=3, size_voxels=3), "exclude each other"),
        (lambda: al.Pointer((1, 2, 3), label=None), "pointer.label is None"),
        (lambda: al.Scene(meshes=[al.Lines.axes()], annotations=["grid"]), "scene.annotations holds 'grid'"),
        (lambda: al.Scene(meshes=[al.Lines.axes()], annotations=al.Grid()), "scene.annotations is .* must be a list"),
        (lambda: annotations.from_dict(3), "annotation is 3, must be a table"),
        (lambda: annotations.from_dict({"kind": "compass"}), "annotation.kind is 'compass', must be one of scale_bar"),
        (lambda: annotations.from_dict({"kind": "grid", "stp": 1}), "grid.stp is no parameter of grid"),
        (lambda: annotations.from_dict({"kind": "pointer"}), "pointer.p_world is missing"),
        (lambda: al.Lines.box("abc"), "lines.box got a str: give an airlight.Volume"),
        (lambda: al.Clip.from_dict(3), "clip is 3, must be a table: with kind, one of plane"),
        (lambda: al.Light.from_dict([]), r"light is \[\], must be a table"),
    ],
)
def test_refused(make, message):
    with pytest.raises((DataError, ValueRangeError), match=message):
        make()


def test_they_are_values():
    assert [annotations.from_dict(one.to_dict()) for one in EVERY] == list(EVERY)
    assert len({*EVERY, *EVERY}) == len(EVERY)
    scene = al.Scene(meshes=[al.Lines.axes()], annotations=EVERY)
    assert dataclasses.replace(scene, camera="iso").annotations == EVERY
    assert scene != dataclasses.replace(scene, annotations=())


def test_scene_files(tmp_path):
    scene = al.Scene(meshes=[al.Lines.axes()], camera="iso", annotations=EVERY)
    al.save_scene(scene, tmp_path / "scene.toml")
    assert al.load_scene(tmp_path / "scene.toml")[0] == scene
    (tmp_path / "slip.toml").write_text(
        '[[meshes]]\nkind = "lines"\npoints = [[0,0,0],[1,1,1]]\n[[annotations]]\nkind = "grid"\nstep = 0\n'
    )
    with pytest.raises(ValueRangeError, match=r"slip.toml:6: annotations\[0\].step is 0, must be above 0"):
        al.load_scene(tmp_path / "slip.toml")


@settings(max_examples=30, deadline=None)
@given(cameras, st.tuples(st.integers(1, 400), st.integers(1, 400)), st.booleans())
def test_any_size_and_any_view_will_do(camera, size_px, at_a_point):
    corners = MIDDLE[None] if at_a_point else CORNERS
    seen, room = view(camera, size_px, corners_world=corners), Room()
    marks = [mark for one in sorted(EVERY, key=lambda one: one.rank) for mark in one.drawn(seen, room).marks]
    marks += al.Grid().drawn(seen, room).marks
    pixels = overlay(marks, size_px)
    assert pixels.shape == (size_px[1], size_px[0], 4)
    assert np.isfinite(pixels).all()
    assert pixels.min() >= 0
    assert pixels.max() <= 1 + 1e-6


# -- where points are seen


@settings(max_examples=40, deadline=None)
@given(cameras, sizes, st.tuples(*[st.floats(0, 1)] * 3))
def test_a_point_is_placed_where_its_ray_begins(camera, size_px, share):
    point = CORNERS.min(axis=0) + np.array(share) * np.ptp(CORNERS, axis=0)
    x, y, depth = view(camera, size_px).placed(point)[0]
    origin, direction = camera.ray((x, y), size_px)
    way = point - origin
    assert np.linalg.norm(np.cross(way, direction)) < 1e-9 * np.linalg.norm(way)
    assert depth == pytest.approx(way @ camera.basis()[2])


round_cameras = st.one_of(
    st.builds(
        al.Camera.panorama,
        eye=st.just(tuple(MIDDLE - (9, 4, 3))),
        target=st.sampled_from([(70.0, 20.0, 30.0), (0.0, -90.0, 0.0)]),
        width_deg=st.sampled_from([360, 200]),
        height_deg=st.sampled_from([180, 90]),
    ),
    st.builds(
        al.Camera.dome,
        eye=st.just((-80.0, -60.0, 20.0)),
        target=st.just(tuple(MIDDLE)),
        angle_deg=st.sampled_from([360, 220, 90]),
    ),
)


@settings(max_examples=40, deadline=None)
@given(round_cameras, sizes, st.tuples(*[st.floats(0.01, 0.99)] * 2))
def test_a_point_is_placed_where_its_ray_begins_all_round(camera, size_px, share):
    """There and back: the point at a distance along a pixel's ray is seen at the pixel; beside a disk there are no rays."""
    at = share[0] * size_px[0], share[1] * size_px[1]
    eye, direction = camera.ray(at, size_px)
    x, y, distance = view(camera, size_px).placed(eye + 17.0 * direction)[0]
    if not direction.any():
        assert np.isnan(distance)
        return
    assert distance == pytest.approx(17.0)
    assert (x, y) == pytest.approx(at, abs=1e-6 * max(size_px))


def test_beside_the_disk_of_a_dome_points_have_no_place():
    camera = al.Camera.dome(eye=(0, 0, 0), target=(0, 1, 0), angle_deg=180)
    assert np.isnan(view(camera, (200, 200)).placed(np.array([2.0, -1.0, 2.0]))[0, :2]).all()
    drawn = al.Pointer((2, -1, 2)).drawn(view(camera), Room())
    assert drawn.told == {"shown": False, "reason": "lies beside the image"}


@settings(max_examples=25, deadline=None)
@given(round_cameras, st.sampled_from([(512, 256), (300, 300), (40, 900)]))
def test_what_looks_all_round_has_grids_axes_and_pointers(camera, size_px):
    """Words lie in the image and beside each other; those of axes beside their tips, on the far side of the arrow."""
    seen, room = view(camera, size_px), Room()
    middle = tuple(MIDDLE.tolist())
    notes = al.Axes(origin=middle, length=20), al.Pointer(middle, shape="arrow"), al.Grid()
    drawn = [one.drawn(seen, room) for one in notes]
    for mark in drawn[0].marks:
        axis = seen.named_axes().index(mark.words)
        tip = seen.placed(MIDDLE + 20 * np.eye(3)[axis])[0, :2]
        assert np.linalg.norm((mark.x_px, mark.y_px) - tip) < 4 * seen.text_px
    boxes = [mark.box for mark in drawn[2].marks]
    assert all(seen.holds(box) for box in boxes)
    for a, b in itertools.combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


@pytest.mark.parametrize(
    "camera",
    [
        al.Camera.perspective(eye=(0, 0, 0), target=(0, 1, 0)),
        al.Camera.orthographic(eye=(0, 0, 0), target=(0, 1, 0), height=9),
    ],
)
def test_points_behind_the_eye_have_no_place(camera):
    assert np.isnan(view(camera).placed(np.array([0.0, -1.0, 0.0]))[0, :2]).all()
    drawn = al.Pointer((0, -1, 0)).drawn(view(camera), Room())
    assert not drawn.shapes
    assert drawn.told == {"shown": False, "reason": "lies behind the eye"}


# -- scale bars


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("size_px", [(64, 48), (512, 512), (300, 1024)])
def test_a_scale_bar_is_as_long_as_it_says(perspective, size_px):
    camera = seen_from((0.4, -1, 0.3), perspective)
    drawn = al.ScaleBar().drawn(view(camera, size_px), Room())
    bar, words = drawn.marks
    middle = size_px[1] / 2
    (a, along), (b, also) = (camera.ray((x, middle), size_px) for x in (bar.left, bar.right))
    forward = camera.basis()[2]
    at_target = np.linalg.norm(MIDDLE - camera.eye)
    ends = [
        start + way * ((at_target - (start - camera.eye) @ forward) / (way @ forward)) for start, way in ((a, along), (b, also))
    ]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(drawn.told["length"], rel=1e-9)
    assert words.words == f"{drawn.told['length']:g} mm" + (" at target" if perspective else "")
    assert drawn.told["holds"] == ("at the target" if perspective else "everywhere")
    assert 0.1 * size_px[0] < bar.right - bar.left < 0.29 * size_px[0]
    assert bar.left >= 0
    assert bar.bottom <= size_px[1]


@settings(max_examples=50, deadline=None)
@given(st.floats(1e-9, 1e12))
def test_lengths_are_round(most):
    length = round_below(most)
    assert 0.399 * most < length <= most * (1 + 1e-12)
    assert round(length / 10 ** np.floor(np.log10(length) + 1e-9), 9) in (1, 2, 5)


@pytest.mark.parametrize(
    ("length", "unit", "words"),
    [
        (50, "mm", "50 mm"),
        (2000, "mm", "2 m"),
        (0.05, "mm", "50 µm"),
        (5e-7, "um", "0.0005 nm"),
        (200, "um", "200 µm"),
        (5000, "um", "5 mm"),
        (0.2, "nm", "0.2 nm"),
        (20, "bohr", "20 bohr"),
        (0.001, "", "0.001"),
        (1e7, "km", "1e+07 km"),
    ],
)
def test_lengths_are_written_short(length, unit, words):
    assert length_text(length, unit) == words


# -- grids


@settings(max_examples=40, deadline=None)
@given(cameras, st.sampled_from([(256, 256), (640, 360), (300, 900)]))
def test_a_grid_lies_behind_all_and_its_numbers_beside_each_other(camera, size_px):
    seen, room = view(camera, size_px), Room()
    drawn = al.Grid().drawn(seen, room)
    (lines,) = drawn.shapes
    step = drawn.told["step"]
    for one in lines.points:
        (axis,) = np.flatnonzero(np.ptp(one, axis=0))
        assert [one[0, axis], one[1, axis]] == [seen.low[axis], seen.high[axis]]
        for across in {0, 1, 2} - {axis}:
            value = one[0, across]
            on_edge = value in (seen.low[across], seen.high[across])
            assert on_edge or abs(value / step - round(value / step)) < 1e-9
        # What lies in the box is nearer to the eye: the way on from a line leads out of the box.
        middle = one.mean(axis=0)
        forward = middle - camera.eye if camera.name == "perspective" else camera.basis()[2]
        beyond = middle + 1e-6 * forward
        assert not ((beyond > seen.low) & (beyond < seen.high)).all()
    boxes = [mark.box for mark in drawn.marks]
    for box in boxes:
        assert seen.holds(box)
    for a, b in itertools.combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    assert drawn.told["labels"] == len(boxes)


def test_numbers_stand_beside_their_lines():
    seen = view(al.Camera.orthographic(eye=(10, -300, 37), target=(10, 0, 37), height=140))
    drawn = al.Grid(step=20).drawn(seen, Room())
    assert {"-40", "-20", "0", "20", "40", "60", "80", "L (mm)", "S (mm)"} >= {mark.words for mark in drawn.marks}
    for number in (-20, 20, 40):
        x, y, _ = seen.placed(np.array([number, 35.0, -5.0]))[0]
        (word,) = (mark for mark in drawn.marks if mark.words == str(number) and mark.y_px > y)
        assert word.x_px == pytest.approx(x, abs=1)
    plain = al.Grid(step=20).drawn(dataclasses.replace(seen, anatomical=False, unit=""), Room())
    assert {"x", "z"} <= {mark.words for mark in plain.marks}


def test_from_inside_all_faces_have_lines_and_none_a_number():
    camera = al.Camera.perspective(eye=tuple(MIDDLE), target=tuple(MIDDLE + np.array([1, 0.2, 0.1])), fov_deg=90)
    drawn = al.Grid().drawn(view(camera), Room())
    assert drawn.told["faces"] == 6
    assert not drawn.marks


def test_from_inside_cameras_that_look_all_round_have_numbers():
    camera = al.Camera.panorama(eye=tuple(MIDDLE - (9, 4, 3)), target=tuple(MIDDLE + np.array([50, 0, 0])))
    seen = view(camera, (800, 400))
    drawn = al.Grid(step=20).drawn(seen, Room())
    assert {"L (mm)", "P (mm)", "S (mm)"} <= {mark.words for mark in drawn.marks}
    edge = seen.placed(np.array([[20.0, y, -5.0] for y in (10.0, 35.0)]))[:, :2]
    numbers = [np.array((mark.x_px, mark.y_px)) for mark in drawn.marks if mark.words == "20"]
    assert min(np.linalg.norm(number - place) for number in numbers for place in edge) < 2 * seen.text_px


# -- axes, letters, pointers


def test_axes_are_arrows_along_the_world():
    drawn = al.Axes(origin=(0, 20, 0), length=30).drawn(view(), Room())
    (arrows,) = drawn.shapes
    vertices = arrows.vertices.reshape(3, -1, 3)
    for axis in range(3):
        assert vertices[axis, :, axis].max() == pytest.approx(30 + (20 if axis == 1 else 0))
        assert np.argmax(arrows.colors.reshape(3, -1, 4)[axis, 0, :3]) == axis
    assert [mark.words for mark in drawn.marks] == ["L", "P", "S"]
    # Faces look outwards: the volume that they enclose is that of three arrows, above zero.
    a, b, c = (arrows.vertices[arrows.faces[:, n]] for n in range(3))
    assert (np.cross(a, b) * c).sum() / 6 > 0.3 * 3 * np.pi * (0.028 * 30) ** 2 * 30


@pytest.mark.parametrize(
    ("way", "right", "up"),
    [((0, -1, 0), "L", "S"), ((0, 1, 0), "R", "S"), ((1, 0, 0), "P", "S"), ((0.5, -0.5, 0), "LP", "S"), ((0, 0, -1), "R", "P")],
)
def test_letters_of_anatomical_directions(way, right, up):
    drawn = al.Orientation().drawn(view(seen_from(way)), Room())
    told = drawn.told
    assert (sorted(told["right"]), told["up"]) == (sorted(right), up)
    opposite = dict(zip("LRPASI", "RLAPIS", strict=True))
    assert drawn.marks[0].words == "".join(opposite[letter] for letter in told["right"])


def test_crosses_have_the_size_that_is_asked():
    seen = view()
    for pointer, size in ((al.Pointer(tuple(MIDDLE), size_voxels=8), 4.0), (al.Pointer(tuple(MIDDLE), size_px=24), None)):
        drawn = pointer.drawn(seen, Room())
        (lines,) = drawn.shapes
        lengths = np.linalg.norm(np.diff(lines.points, axis=1)[:, 0], axis=1)
        expected = size or 24 * seen.pixel_world(float(np.linalg.norm(MIDDLE - seen.camera.eye)))
        assert lengths == pytest.approx([expected] * 3)
        assert lines.points.mean(axis=1) == pytest.approx(np.broadcast_to(MIDDLE, (3, 3)))


def test_arrows_end_at_their_point():
    (arrow,) = al.Pointer(tuple(MIDDLE), shape="arrow", size_voxels=40).drawn(view(), Room()).shapes
    distances = np.linalg.norm(arrow.vertices - MIDDLE, axis=1)
    assert distances.min() < 1e-4
    assert distances.max() == pytest.approx(20, rel=0.02)


def test_words_of_pointers_find_a_free_place():
    room = Room()
    first, second = (al.Pointer(tuple(MIDDLE), label="here").drawn(view(), room).marks[0] for _ in range(2))
    assert first.anchor == "lm"
    assert second.anchor == "rm"


# -- colour bars


def strip_of(drawn) -> Patch:
    return next(mark for mark in drawn.marks if isinstance(mark, Patch))


@pytest.mark.parametrize("size_px", [(96, 64), (512, 512)])
def test_a_colour_bar_shows_the_function(size_px):
    drawn = al.ColorBar().drawn(view(size_px=size_px), Room())
    strip = strip_of(drawn)
    rows = len(strip.rgba)
    values = 1000 - (np.arange(rows) + 0.5) / rows * 1100
    assert strip.rgba[:, 0, :3] == pytest.approx(TF(values)[0], abs=1e-6)
    assert (strip.rgba[..., 3] == 1).all()
    numbers = [mark for mark in drawn.marks if isinstance(mark, Text)]
    assert numbers[-1].words == "HU"
    for number in numbers[:-1]:
        assert number.y_px == pytest.approx(strip.top + (1000 - float(number.words)) / 1100 * rows)
    profile = [mark for mark in drawn.marks if isinstance(mark, Patch)][1]
    wide = (profile.rgba[..., 3].sum(axis=1) - 1) / (profile.rgba.shape[1] - 1)
    thickness = 0.01 * np.ptp(CORNERS, axis=0).max()
    clear = values > 400
    assert wide[clear] == pytest.approx(1 - np.exp(-TF(values)[1][clear] * thickness), abs=1.5 / (profile.rgba.shape[1] - 1))
    for mark in drawn.marks:
        assert view(size_px=size_px).holds(mark.box)


def test_colour_bars_of_channels_lie_side_by_side():
    layers = (Shown((("actin", TF), ("dna", TF.scaled(0.5))), ""),)
    drawn = al.ColorBar().drawn(view(layers=layers), Room())
    assert {mark.words for mark in drawn.marks if isinstance(mark, Text)} >= {"actin", "dna"}
    assert [bar["channel"] for bar in drawn.told["bars"]] == ["dna", "actin"]
    frames = [mark.box for mark in drawn.marks if isinstance(mark, Bar) and mark.bottom - mark.top > 50]
    assert frames[1][2] < frames[0][0]


def test_projections_have_no_opacities():
    drawn = al.ColorBar().drawn(view(layers=(Shown((("", TF),), "", True),)), Room())
    assert sum(isinstance(mark, Patch) for mark in drawn.marks) == 1


def test_surfaces_are_lines_in_the_bar():
    sheets = al.TransferFunction.from_surfaces([al.Surface(10.0, (1, 0, 0), 0.5), al.Surface(20.0, (0, 1, 0), 1.0)])
    strip = strip_of(al.ColorBar().drawn(view(layers=(Shown((("", sheets),)),)), Room())).rgba[:, 0]
    assert (strip == (1, 0, 0, 1)).all(axis=1).any()
    assert (strip == (0, 1, 0, 1)).all(axis=1).any()


JOINT = al.JointFunction(
    [al.joint.Axis("value", 0, 1), al.joint.Axis("gradient", 0, 1)], [al.joint.Box((0.2, 0.1), (0.4, 0.5))]
)


@pytest.mark.parametrize(
    ("annotation", "changes", "message"),
    [
        (al.ColorBar(layer=1), {}, "color_bar.layer is 1, and 1 layers are visible"),
        (al.ColorBar(), {"layers": (Shown(()),)}, "layer 0 shows labels"),
        (al.ColorBar(), {"layers": (Shown((), instead="distance"),)}, "layer 0 shows distance: leave it out"),
        (al.ColorBar(), {"layers": (Shown((("", JOINT),)),)}, "layer 0 has a JointFunction"),
        (al.Grid(step=0.09), {}, "grid.step is 0.09, and the longest edge is 100: at most 1000 lines are drawn along it"),
        (al.Orientation(), {"anatomical": False}, "orientation is that of anatomical data"),
        *(
            (
                one,
                {"camera": al.Camera.stereo(eye=(0, 0, 0), target=(0, 1, 0))},
                "does not go with the camera stereo: use persp",
            )
            for one in (al.ScaleBar(), al.Grid(), al.Axes(), al.Orientation(), al.Pointer((1, 2, 3)))
        ),
        *(
            (
                one,
                {"camera": al.Camera.panorama(eye=(0, 0, 0), target=(0, 1, 0))},
                "panorama, whose pixels are angles: no length",
            )
            for one in (al.ScaleBar(), al.Orientation())
        ),
    ],
)
def test_what_cannot_be_shown(annotation, changes, message):
    with pytest.raises((DataError, StageError, ValueRangeError), match=message):
        annotation.drawn(view(**changes), Room())


# -- pixels


@pytest.mark.parametrize("ground", [0.0, 0.02, 0.18, 0.5, 1.0])
@pytest.mark.parametrize("ink", [(0.9, 0.9, 0.9), (0.012, 0.012, 0.012)])
def test_words_are_readable_on_any_ground(ground, ink):
    pixels = over(overlay([Text(60, 16, "L 250 µm", 15, ink)], (120, 32)), np.full((32, 120, 3), ground, dtype=np.float32))
    luminance = pixels.mean(axis=-1)
    assert (luminance.max() + 0.05) / (luminance.min() + 0.05) > 4.5  # the contrast that WCAG 2 asks for
    assert np.array_equal(pixels[0, 0], np.float32([ground] * 3))


def test_a_bar_covers_parts_of_pixels():
    pixels = overlay([Bar(2.25, 3.0, 7.5, 5.0, (1, 1, 1))], (12, 8))
    inked = pixels[3, :, 0]
    assert inked[2:8].tolist() == pytest.approx([0.75, 1, 1, 1, 1, 0.5])
    assert pixels[..., 3].max() <= 1
    assert (pixels[..., :3] <= pixels[..., 3:] + 1e-6).all()


def test_marks_beyond_the_border_are_cut():
    marks = [
        Text(-3, 5, "wide words", 12, (1, 1, 1)),
        Bar(-5, -5, 50, 3, (1, 0, 0)),
        Patch(14, 6, np.ones((9, 9, 4), np.float32)),
    ]
    pixels = overlay([*marks, Text(500, 500, "far", 12, (1, 1, 1))], (16, 8))
    assert pixels.shape == (8, 16, 4)
    assert pixels[7, 15].tolist() == [1, 1, 1, 1]
    assert pixels[0, 8].tolist() == [1, 0, 0, 1]


def test_signs_that_the_font_has_not():
    assert width_of("5 µm", 20) == width_of("5 um", 20)
    with_tail, without = (overlay([Text(20, 15, word, 20, (1, 1, 1))], (40, 30))[..., 0] for word in ("µ", "u"))
    assert with_tail[:18].tolist() == without[:18].tolist()
    below = with_tail - without
    assert below.max() > 0.8
    assert np.flatnonzero(below.max(axis=0) > 0.5).mean() < np.flatnonzero(without.max(axis=0) > 0.5).mean()
    assert (
        overlay([Text(20, 15, "中", 20, (1, 1, 1))], (40, 30)).tolist()
        == overlay([Text(20, 15, "?", 20, (1, 1, 1))], (40, 30)).tolist()
    )


def test_what_is_brighter_than_white_does_not_shine_through():
    front = np.array([[[0, 0, 0, 0.5], [0, 0, 0, 0]]], dtype=np.float32)
    assert over(front, np.full((1, 2, 3), 4.0, dtype=np.float32))[0].tolist() == [[0.5] * 3, [4.0] * 3]
    assert float(linear_to_srgb(np.array([0.5]))[0]) < 0.8
