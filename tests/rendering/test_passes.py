"""Passes over finished pictures: those of the package against the reference, those of users as a stranger writes them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import ClassVar

import numpy as np
import pytest
from scenes import SIZE, scene

import airlight as al
from airlight import reference
from airlight.rendering import ways
from airlight.rendering.half_angle import lamps_of
from airlight.stage import STAGES
from airlight.stages.driver_half_angle import HalfAngleSweep

TOLERANCE = 1 / 255


@pytest.fixture(autouse=True)
def _plain_stages():
    before = dict(STAGES["passes"])
    yield
    STAGES["passes"].clear()
    STAGES["passes"].update(before)


@dataclass(frozen=True)
class Steps(al.Pass):
    """How far depth goes up to the right: a picture of its own."""

    name: ClassVar[str] = "steps"
    reads: ClassVar[dict] = {"depth": al.passes.DEPTH}
    writes: ClassVar[dict] = {"steps": al.passes.PerPixel("f32")}
    wgsl: ClassVar[str] = """
import generated::pass::depth;
import package::picture::place;
fn pixel(p_px: vec2i) -> f32 { return min(depth[place(p_px + vec2i(0, 3))].x, 1e4) - min(depth[place(p_px)].x, 1e4); }
"""

    def reach_px(self) -> int:
        return 3


@dataclass(frozen=True)
class Shown(al.Pass):
    """The steps as red."""

    name: ClassVar[str] = "shown"
    reads: ClassVar[dict] = {"radiance": al.passes.COLOUR, "steps": al.passes.PerPixel("f32")}
    scale: al.F32 = al.param(0.5, above=0)
    wgsl: ClassVar[str] = """
import generated::pass::{radiance, steps};
import generated::shown::params;
import package::picture::place;
fn pixel(p_px: vec2i) -> vec4f { return radiance[place(p_px)] + vec4f(params.scale * steps[place(p_px)], 0.0, 0.0, 0.0); }
"""

    def reach_px(self) -> int:
        return 0


def steps_of(depth: np.ndarray) -> np.ndarray:
    below = np.minimum(np.arange(depth.shape[0]) + 3, depth.shape[0] - 1)
    return np.minimum(depth[below], 1e4) - np.minimum(depth, 1e4)


def compare(image: al.Image, truth: reference.ReferenceImage) -> None:
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    # Opacities of about one half may fall to either side, and with them depth.
    assert np.sort(error.ravel())[-3] <= TOLERANCE, np.sort(error.ravel())[-8:]


@pytest.mark.parametrize(("kind", "camera"), [("renderer", "perspective"), ("core_renderer", "orthographic")])
def test_bounding_box_as_in_the_reference(request, kind, camera):
    own = al.passes.BoundingBox(color=(0.2, 0.9, 0.4), opacity=0.8, width_px=2.5)
    drawn = scene(camera=camera)
    image = request.getfixturevalue(kind).render(drawn, SIZE, passes=[own])
    compare(image, reference.render(drawn, SIZE, passes=[own]))
    assert np.abs(image.rgba - request.getfixturevalue(kind).render(drawn, SIZE).rgba).max() > 0.5


@pytest.mark.parametrize(
    ("kind", "camera", "driver"),
    [("renderer", "perspective", "slices"), ("renderer", "perspective", "shells"), ("renderer", "orthographic", "shells")],
)
def test_outlines_as_in_the_reference(request, kind, camera, driver):
    own, drawn = al.passes.SliceOutlines(every=6, color=(1, 0.5, 0)), scene(camera=camera)
    image = request.getfixturevalue(kind).render(drawn, SIZE, driver=driver, passes=[own])
    compare(image, reference.render(drawn, SIZE, driver=STAGES["driver"][driver](), passes=[own]))


def test_each_of_several_layers_has_its_box(renderer):
    own, one = al.passes.BoundingBox(), scene(shade="none").layers[0]
    moved = one.volume.world_from_index.copy()
    moved[:3, 3] += (20, 5, -10)
    other = replace(one, volume=al.Volume(one.volume.array, world_from_index=moved))
    for layers in ((one, other), (one,)):  # of which none is left behind in the next frame
        drawn = al.Scene(layers=layers, camera=scene().camera, background=None)
        compare(renderer.render(drawn, SIZE, passes=[own]), reference.render(drawn, SIZE, passes=[own]))


def test_lines_lie_before_an_environment(renderer):
    """As before any background: it is only what is in the volume, and meshes, that hides them."""
    own = al.passes.BoundingBox(color=(1, 0, 0), width_px=2.5)
    drawn = replace(scene(), background=al.Environment.white())
    image, plain = renderer.render(drawn, SIZE, passes=[own]), renderer.render(drawn, SIZE)
    compare(image, reference.render(drawn, SIZE, passes=[own]))
    alone, bare = renderer.render(scene(), SIZE, passes=[own]), renderer.render(scene(), SIZE)
    empty = (bare.rgba[..., 3] == 0) & (alone.rgba[..., 3] > 0)
    cover = alone.rgba[empty][:, 3:]
    expected = cover * (1, 0, 0) + (1 - cover) * plain.rgba[empty][:, :3]
    assert empty.sum() > 100
    assert np.abs(image.rgba[empty][:, :3] - expected).max() < 1e-4


def test_both_eyes_see_the_box(renderer):
    own, eye = al.passes.BoundingBox(), scene().camera
    both = al.Camera.stereo(eye=eye.eye, target=eye.target, up=eye.up, fov_deg=eye.fov_deg)
    drawn = replace(scene(), camera=both)
    compare(renderer.render(drawn, SIZE, passes=[own]), reference.render(drawn, SIZE, passes=[own]))


def test_what_is_measured_may_be_read(renderer):
    @dataclass(frozen=True)
    class Meter(al.Pass):
        """The log-average luminance as grey."""

        name: ClassVar[str] = "meter"
        reads: ClassVar[dict] = {"radiance": al.passes.COLOUR, "luminance": al.passes.NUMBER}
        wgsl: ClassVar[str] = """
import generated::luminance::params;
fn pixel(p_px: vec2i) -> vec4f { return vec4f(vec3f(params.log_average), 1.0); }
"""

    metered = renderer.render(scene(tone="reinhard"), SIZE)
    for tone in ("linear", al.tone.Linear(exposure=3.0)):  # it is that of the scene, before any tone
        image = renderer.render(scene(tone=tone), SIZE, passes=[Meter()])
        assert image.stats["passes"]["drawn"] == ["march", "luminance", "tone", "meter"]
        assert image.rgba[0, 0, 0] == pytest.approx(metered.stats["luminance"], rel=1e-5)


def test_what_is_handed_on_and_what_nobody_asks_for(renderer):
    drawn = scene()
    plain = renderer.render(drawn, SIZE)
    image = renderer.render(drawn, SIZE, passes=[Shown(), Steps()])  # in the order of what they read
    assert image.stats["passes"] == {"drawn": ["march", "steps", "shown"], "left_out": []}
    assert np.abs(image.rgba[..., 0] - plain.rgba[..., 0] - 0.5 * steps_of(plain.depth)).max() < 1e-3
    alone = renderer.render(drawn, SIZE, passes=[Steps()])
    assert alone.stats["passes"] == {"drawn": ["march"], "left_out": ["steps"]}
    assert "steps" not in alone.stats["milliseconds"]
    assert (alone.rgba == plain.rgba).all()


def test_bands_of_rows_have_no_seams(renderer, monkeypatch):
    drawn, own = scene(), [Steps(), Shown(), Shown(scale=0.1)]
    whole = renderer.render(drawn, SIZE, passes=own)
    monkeypatch.setattr(ways, "MOST_ROWS", 15)
    parts = renderer.render(drawn, SIZE, passes=own)
    assert (parts.rgba == whole.rgba).all()
    assert (parts.depth == whole.depth).all()
    with pytest.raises(
        al.LimitError, match=r"pass 'everywhere' looks at the image in one piece, and .* holds 15 of its 40 rows"
    ):
        renderer.render(drawn, SIZE, passes=[everywhere()])
    monkeypatch.setattr(ways, "MOST_ROWS", 6)
    with pytest.raises(al.LimitError, match="passes look 3 rows up and down"):
        renderer.render(drawn, SIZE, passes=own)


def everywhere() -> al.Pass:
    @dataclass(frozen=True)
    class Everywhere(Shown):
        name: ClassVar[str] = "everywhere"

        def reach_px(self) -> None:
            return None

    return Everywhere()


def test_passes_over_the_scene_come_before_its_tones(renderer):
    @dataclass(frozen=True)
    class Doubled(al.Pass):
        """Twice the light."""

        name: ClassVar[str] = "doubled"
        over: ClassVar[str] = "scene"
        wgsl: ClassVar[str] = """
import generated::pass::radiance;
import package::picture::place;
fn pixel(p_px: vec2i) -> vec4f { return radiance[place(p_px)] * vec4f(2.0, 2.0, 2.0, 1.0); }
"""

    metered = renderer.render(scene(tone="reinhard"), SIZE)
    doubled = renderer.render(scene(tone="reinhard"), SIZE, passes=[Doubled()])
    assert np.abs(doubled.rgba - metered.rgba).max() < 1e-3  # the exposure follows
    assert doubled.stats["passes"]["drawn"] == ["march", "doubled", "luminance", "tone"]
    fixed = renderer.render(scene(tone=al.tone.Linear(exposure=1.0)), SIZE)
    exposed = renderer.render(scene(), SIZE, passes=[Doubled()])
    assert np.abs(exposed.rgba - fixed.rgba).max() < 1e-5
    boxed = renderer.render(scene(tone="reinhard"), SIZE, passes=["bounding_box"])
    assert boxed.stats["luminance"] == metered.stats["luminance"]  # measured before lines are drawn


def test_lit_again_with_passes(renderer):
    drawn = scene(integrate=al.integrate.FirstHit(iso=70.0))
    image = renderer.render(drawn, SIZE, keep_hits=True, passes=["bounding_box"])
    darker = replace_lights(drawn)
    again = renderer.relight(image, darker, passes=["bounding_box"])
    assert np.abs(again.rgba - renderer.render(darker, SIZE, passes=["bounding_box"]).rgba).max() < 1e-5


def replace_lights(drawn: al.Scene) -> al.Scene:
    return replace(drawn, lights=(al.Light.head(intensity=0.3),))


def test_where_nothing_else_is_seen(renderer):
    hidden = al.Scene(layers=[replace(scene().layers[0], visible=False)], camera=scene().camera, background=None)
    image = renderer.render(hidden, SIZE, passes=["bounding_box"])
    assert image.stats["reason"] == "no visible layer"
    assert image.rgba.any()


def test_meshes_alone_have_no_domains(renderer):
    floor = al.Mesh([(0, 0, 0), (9, 0, 0), (0, 9, 0)], [(0, 1, 2)])
    drawn = al.Scene(meshes=[floor], camera=scene().camera, background=None)
    with pytest.raises(al.StageError, match="pass 'bounding_box' reads 'domains', and the scene has no volume"):
        renderer.render(drawn, SIZE, passes=["bounding_box"])


REFUSED = [
    (["nobody"], al.ValueRangeError, "passes has 'nobody', must be a Pass or one of bounding_box, slice_outlines"),
    ("bounding_box", al.ValueRangeError, "passes is 'bounding_box', must be a list"),
    (["slice_outlines"], al.StageError, "pass 'slice_outlines' reads 'slices', and the driver 'march' draws none here: use"),
    ([Shown()], al.StageError, "pass 'shown' reads 'steps', which no pass writes"),
    ([Steps(), Steps()], al.StageError, "pass 'steps' writes 'steps', which belongs to pass 'steps'"),
    ([al.shade.BlinnPhong()], al.StageError, "BlinnPhong, a stage of the slot shade"),
    ([{}], al.ValueRangeError, "passes has {}, must be a Pass or one of bounding_box"),
]


@pytest.mark.parametrize(("given", "error", "words"), REFUSED, ids=range(len(REFUSED)))
def test_what_is_refused(renderer, given, error, words):
    with pytest.raises(error, match=words):
        renderer.render(scene(), SIZE, passes=given)


def test_types_that_do_not_agree(renderer):
    @dataclass(frozen=True)
    class Wrong(Shown):
        reads: ClassVar[dict] = {"radiance": al.passes.COLOUR, "steps": al.passes.PerPixel("vec2f")}

    words = "pass 'shown' reads 'steps' as a vec2f for each pixel, and pass 'steps' writes it as a f32 for each pixel"
    with pytest.raises(al.StageError, match=words):
        renderer.render(scene(), SIZE, passes=[Steps(), Wrong()])


def test_more_lists_than_a_shader_may_read(core_renderer):
    @dataclass(frozen=True)
    class Greedy(Shown):
        reads: ClassVar[dict] = {f"n{n}": al.passes.PerPixel("f32") for n in range(8)} | {"radiance": al.passes.COLOUR}

    with pytest.raises(al.LimitError, match=r"pass 'shown' reads 9 lists, at most 7 here: make two passes of it"):
        core_renderer.render(scene(), SIZE, passes=[Greedy()])


def test_slips_in_wgsl_name_the_file(renderer):
    @dataclass(frozen=True)
    class Slip(al.Pass):
        """Looks at what it does not say that it reads."""

        name: ClassVar[str] = "slip"
        wgsl: ClassVar[str] = """
import generated::pass::luminance;
fn pixel(p_px: vec2i) -> vec4f { return vec4f(luminance); }
"""

    with pytest.raises(
        al.ShaderError, match="<slip>:2 imports 'luminance' of generated::pass, which the host does not declare"
    ):
        renderer.render(scene(), SIZE, passes=[Slip()])


WRITES = [
    ({}, "pass 'odd' writes nothing: a pass writes one value for each pixel"),
    ({"a": al.passes.PerPixel("f32"), "b": al.passes.PerPixel("f32")}, "pass 'odd' writes a, b"),
    ({"a": al.passes.PerPixel("vec3f")}, "pass 'odd' writes 'a' as a vec3f for each pixel: pixels have f32"),
    ({"two words": al.passes.COLOUR}, "pass 'odd' writes 'two words'"),
    ({"a": "vec4f"}, "pass 'odd' writes 'a' as 'vec4f', which is no name with a type"),
    (["radiance"], r"pass 'odd' writes \['radiance'\]: e.g. writes = "),
]


@pytest.mark.parametrize(("writes", "words"), WRITES, ids=range(len(WRITES)))
def test_what_a_class_may_write(writes, words):
    odd = dataclass(frozen=True)(type("Odd", (al.Pass,), {"name": "odd", "writes": writes, "wgsl": "\n"}))
    with pytest.raises(al.StageError, match=words):
        odd()


@pytest.mark.parametrize("reach", [-1, 1.5, "3", 1 << 17])
def test_how_far_a_class_may_look(reach):
    odd = dataclass(frozen=True)(type("Odd", (al.Pass,), {"name": "odd", "reach_px": lambda self: reach, "wgsl": "\n"}))
    with pytest.raises(al.ValueRangeError, match=r"pass 'odd': reach_px\(\) is .*, must be a whole number in \[0, 65536\]"):
        odd()


def test_scene_files_keep_passes_by_name(tmp_path):
    al.save(scene().layers[0].volume, tmp_path / "v.nrrd")
    drawn = replace(scene(), layers=(replace(scene().layers[0], volume=al.open(tmp_path / "v.nrrd")),))
    own = (al.passes.BoundingBox(), al.passes.SliceOutlines(every=3.0, color=(1.0, 0.0, 0.0)))
    al.save_scene(drawn, tmp_path / "s.toml", render={"size": SIZE, "passes": own})
    assert al.load_scene(tmp_path / "s.toml")[1] == {"size": SIZE, "passes": own}
    for wrong, words in (('["nobody"]', "'nobody', must be one of bounding_box"), ('"bounding_box"', "must be a list")):
        (tmp_path / "w.toml").write_text(f'[[layers]]\nvolume = "v.nrrd"\n\n[render]\npasses = {wrong}\n')
        with pytest.raises(al.ValueRangeError, match=rf"w.toml:5: render.passes.*{words}"):
            al.load_scene(tmp_path / "w.toml")


def test_tolerances_and_refinements_are_refused(renderer):
    words = "pass 'bounding_box' changes finished pictures, and a tolerance bounds the error"
    with pytest.raises(al.StageError, match=words):
        renderer.render(scene(), SIZE, tolerance=0.1, passes=["bounding_box"])
    with pytest.raises(al.StageError, match=words):
        next(renderer.refine(scene(), SIZE, passes=["bounding_box"]))
    assert renderer.render(scene(), SIZE, budget_ms=1e5, passes=["bounding_box"]).stats["passes"]["drawn"][-1] == "bounding_box"


def test_outlines_of_half_angle_slices_are_those_of_the_first_light(renderer):
    drawn, own = scene(), al.passes.SliceOutlines(every=4)
    empty = replace(drawn, layers=(replace(drawn.layers[0], transfer=al.TransferFunction([(0, "black", 0.0)])),))
    image = renderer.render(empty, SIZE, driver="half_angle", passes=[own])
    volume = drawn.layers[0].volume
    planes = lamps_of(empty, drawn.camera, SIZE, volume.corners_world(), min(volume.spacing))[0].planes
    compare(image, reference.render(empty, SIZE, driver=HalfAngleSweep(given=planes), passes=[own]))


def test_outlines_are_those_of_polygons(renderer):
    """Lines are where plain clipping of the box by each plane has its edges, and nowhere else."""
    drawn, (width, height), every = scene(camera="orthographic"), (96, 80), 8
    thin = al.passes.SliceOutlines(every=every, width_px=1.0)
    empty = replace(drawn, layers=(replace(drawn.layers[0], transfer=al.TransferFunction([(0, "black", 0.0)])),))
    lines = renderer.render(empty, (width, height), driver="slices", passes=[thin]).rgba[..., 3]
    camera, volume = drawn.camera, drawn.layers[0].volume
    unit = np.array(list(product((0, 1), repeat=3)))
    corners = unit * (np.array(volume.size) - 1) @ volume.world_from_index[:3, :3].T + volume.world_from_index[:3, 3]
    right, up, forward = camera.basis()
    away = corners - camera.eye
    depths = away @ forward
    places = np.stack([away @ right, -(away @ up)], axis=1) / camera.height * height + (width / 2, height / 2)
    step = min(volume.spacing)
    y, x = np.indices((height, width)) + 0.5
    nearest = np.full((height, width), np.inf)
    for depth in np.arange(np.floor(depths.min() / step) * step, depths.max(), every * step):
        for face in (np.flatnonzero(unit[:, axis] == side) for axis, side in product(range(3), (0, 1))):
            edges = [(a, b) for a, b in combinations(face, 2) if np.abs(unit[a] - unit[b]).sum() == 1]
            shares = [(depth - depths[a]) / (depths[b] - depths[a]) for a, b in edges]
            ends = [places[a] + t * (places[b] - places[a]) for t, (a, b) in zip(shares, edges, strict=True) if 0 <= t <= 1]
            if len(ends) == 2:
                way, ahead = ends[1] - ends[0], np.stack([x, y], axis=-1) - ends[0]
                along = np.clip(ahead @ way / (way @ way), 0, 1)
                nearest = np.minimum(nearest, np.linalg.norm(ahead - along[..., None] * way, axis=-1))
    assert (nearest < 0.2).sum() > 200
    assert (lines[nearest < 0.2] > 0.5).mean() > 0.97  # but for rays that just miss the box
    assert (lines[nearest > 1.5] > 0).mean() < 0.005  # where a face ends, half a pixel of its lines may lie on the next one
