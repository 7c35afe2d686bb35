"""Annotations on pictures: what is written leaves radiance and depth alone, what is drawn shares them."""

from __future__ import annotations

import dataclasses
import io

import numpy as np
import pytest
from PIL import Image as Pillow

import airlight as al
from airlight.annotations.marks import Patch
from airlight.errors import DataError, StageError
from airlight.first_picture import resolve
from airlight.rendering.annotating import annotated

SIZE = (48, 48)
WRITTEN = (al.ScaleBar(), al.ColorBar(), al.Orientation())
SOLID = al.TransferFunction([(0, "#c08040", 0.0), (100, "#c08040", 0.0), (101, "#c08040", 4.0), (1000, "white", 4.0)])


@pytest.fixture(scope="module")
def volume() -> al.Volume:
    """A block of 600 in air, whose world is 14 mm wide."""
    array = np.zeros((8, 8, 8), dtype=np.float32)
    array[2:6, 2:6, 2:6] = 600
    return al.Volume(array, spacing=(2, 2, 2), units="mm", value_unit="HU", anatomical=True)


def scene_of(volume: al.Volume, *annotations: al.annotations.Annotation, **changes) -> al.Scene:
    camera = al.Camera.orthographic(eye=(7, -40, 7), target=(7, 7, 7), height=24)
    given = {"camera": camera, "transfer": SOLID, "look": al.Look(shade="none")} | changes
    return al.Scene(volume, annotations=annotations, **given)


def test_what_is_written_is_in_the_picture_alone(volume, tmp_path):
    plain, image = (al.render(scene_of(volume, *written), SIZE) for written in ((), WRITTEN))
    assert np.array_equal(image.rgba, plain.rgba)
    assert np.array_equal(image.depth, plain.depth)
    assert not plain.marks
    touched = (image.picture() != plain.picture()).any(axis=-1)
    assert 0.05 < touched.mean() < 0.6
    assert np.array_equal((image.rgb != plain.rgb).any(axis=-1) | touched, (image.rgb != plain.rgb).any(axis=-1))
    assert np.array_equal(np.asarray(Pillow.open(io.BytesIO(image._repr_png_()))), image.picture())
    image.save(tmp_path / "a.npy")
    assert np.array_equal(np.load(tmp_path / "a.npy"), plain.rgba)
    told = {one["kind"]: one for one in image.stats["annotations"]}
    assert set(told) == {"scale_bar", "color_bar", "orientation"}
    assert told["scale_bar"]["length"] == 5
    assert told["scale_bar"]["holds"] == "everywhere"
    assert told["color_bar"]["bars"] == [{"channel": "", "range": [0.0, 1000.0]}]
    assert image.scene == scene_of(volume, *WRITTEN)
    assert al.render(image.scene, SIZE).marks == image.marks or len(image.marks) > 5


def test_transparent_pictures_are_opaque_where_something_is_written(volume):
    image = al.render(scene_of(volume, al.ScaleBar(), background=None), SIZE)
    alpha = image.picture()[..., 3]
    bar = image.marks[0].box
    assert alpha[round(bar[3]) - 1, round(bar[0]) + 2] == 255
    assert image.rgba[round(bar[3]) - 1, round(bar[0]) + 2, 3] == 0
    assert alpha[0, 0] == 0


def test_colours_of_values_are_those_of_the_bar(volume):
    function = al.TransferFunction([(0, "navy", 0.0), (500, "gold", 1.0), (1000, "white", 1.0)])
    look = al.Look(integrate="mip", field="nearest")
    image = al.render(scene_of(volume, al.ColorBar(), transfer=function, look=look), SIZE)
    strip = next(mark for mark in image.marks if isinstance(mark, Patch))
    row = strip.top + round((1 - 0.6) * len(strip.rgba))
    shown = image.picture()[SIZE[1] // 2, SIZE[0] // 2 - 2].astype(int)
    in_bar = image.picture()[row - 1 : row + 1, strip.left + 1].astype(int)
    low, high = in_bar.min(axis=0) - 1, in_bar.max(axis=0) + 1
    assert ((shown >= low) & (shown <= high)).all()


def test_what_is_drawn_is_geometry_of_the_scene(volume):
    scene = scene_of(volume, al.Grid(labels=False), al.Axes(), al.Pointer((7, 2, 12), shape="arrow"))
    image = al.render(scene, SIZE)
    bare, notes = annotated(resolve(scene, SIZE), SIZE)
    assert not bare.annotations
    assert len(bare.meshes) == 3
    again = al.render(bare, SIZE)
    assert np.array_equal(image.rgba, again.rgba)
    assert np.array_equal(image.depth, again.depth)
    assert [told["kind"] for told in image.stats["annotations"]] == ["axes", "pointer", "grid"]
    assert image.stats["meshes"] == again.stats["meshes"]
    assert image.scene.meshes == ()
    assert image.scene.annotations == scene.annotations
    assert {mark.words for mark in notes.marks} == {"L", "P", "S"}


def test_pointers_share_depth(volume):
    def shown(y: float) -> bool:
        image = al.render(scene_of(volume, al.Pointer((7, y, 7), size_px=12, color="lime")), SIZE)
        return bool((image.rgba[..., 1] > 0.9).any() and (image.rgba[..., 0] < 0.1)[image.rgba[..., 1] > 0.9].all())

    assert shown(1.0)
    assert not shown(13.0)
    front = al.render(scene_of(volume, al.Pointer((7, 1.0, 7), size_px=12)), SIZE)
    assert front.depth[SIZE[1] // 2, SIZE[0] // 2] == pytest.approx(41, abs=1e-3)


def test_scenes_of_which_only_annotations_are_left(volume):
    hidden = scene_of(volume, al.Pointer((7, 7, 7), color="lime"), al.ScaleBar(), visible=False)
    image = al.render(hidden, SIZE)
    assert (image.rgba[..., 1] > 0.9).any()
    assert image.stats["reason"] == "no visible layer"
    assert image.scene == hidden
    empty = al.render(scene_of(volume, al.ScaleBar(), visible=False), SIZE)
    assert not empty.rgba.any()
    assert empty.picture().any()


def test_meshes_alone_are_no_volume_to_ask(volume):
    scene = al.Scene(meshes=[al.Points([(0, 0, 0), (4, 0, 2)], width_px=12)], camera="front", annotations=[al.Axes()])
    image = al.render(scene, SIZE)
    y, x = (int(c) for c in np.argwhere(image.depth == image.depth.min())[0])
    point = al.pick(image, scene, (x, y))
    assert point == al.pick(image, image.scene, (x, y))
    assert image.scene.layers == ()
    for ask in (image.pick, image.profile):
        with pytest.raises(DataError, match=r"scene shows no volume, whose values could be told: airlight\.pick"):
            ask(x, y)


def test_a_single_point_is_a_scene():
    camera = al.Camera.perspective(eye=(5, -300, 5), target=(5, 5, 5))
    scene = al.Scene(meshes=[al.Points([(5, 5, 5)], color="lime", width_px=9)], camera=camera, annotations=[al.ScaleBar()])
    image = al.render(scene, SIZE)
    assert image.rgba[SIZE[1] // 2, SIZE[0] // 2].tolist() == pytest.approx([0, 1, 0, 1], abs=1e-6)
    assert image.stats["annotations"][0]["length"] == 20


def test_light_changes_under_annotations(volume):
    look = al.Look(integrate=al.integrate.FirstHit(iso=300))
    scene = scene_of(volume, *WRITTEN, look=look)
    image = al.render(scene, SIZE, keep_hits=True)
    lamp = dataclasses.replace(scene, lights=(al.Light.directional(to_light=(1, -1, 1)),))
    again = al.relight(image, lamp)
    assert len(again.marks) == len(image.marks)
    assert again.stats["annotations"] == image.stats["annotations"]
    assert again.scene == lamp


def test_pictures_drawn_smaller_have_annotations_of_their_whole_size(volume):
    scene = scene_of(volume, al.ScaleBar(), al.Grid(), al.Pointer((7, 2, 12), size_px=12, label="here"))
    whole, in_time = al.render(scene, SIZE), al.render(scene, SIZE, budget_ms=1e-3)
    with al.Renderer() as renderer:
        first = next(iter(renderer.refine(scene, SIZE)))
    assert in_time.stats["budget"]["scale"] < 1
    for image in (in_time, first):
        assert image.scene == scene
        assert image.marks == whole.marks
        assert image.stats["annotations"] == whole.stats["annotations"]


def test_colours_of_something_else_have_no_bar(volume):
    look = al.Look(integrate=al.integrate.FirstHit(iso=300, colour_by="distance"))
    with pytest.raises(DataError, match="color_bar shows values, and layer 0 shows distance"):
        al.render(scene_of(volume, al.ColorBar(), look=look), SIZE)


def test_cameras_of_two_eyes_take_none(volume):
    camera = al.Camera.stereo(eye=(7, -40, 7), target=(7, 7, 7))
    with pytest.raises(StageError, match="annotation 'scale_bar' does not go with the camera stereo: use perspective or ortho"):
        al.render(scene_of(volume, al.ScaleBar(), camera=camera), SIZE)
    assert al.render(scene_of(volume, al.ColorBar(), camera=camera), SIZE).marks


def test_environments_tell_how_far_they_are(volume):
    told = []
    source = al.Environment.white((0.5, 0.25, 0.125))
    look = al.Look(shade=al.shade.Environment(environment=source))
    for _ in range(2):
        al.render(scene_of(volume, look=look), (16, 16), progress=lambda *report: told.append(report))
    steps = [report for report in told if report[0] == "environment"]
    assert steps[0] == ("environment", 0, 14)
    assert steps[-1] == ("environment", 14, 14)
    assert [done for _, done, _ in steps] == sorted({done for _, done, _ in steps})
