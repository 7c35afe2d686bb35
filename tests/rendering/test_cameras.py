"""Every camera against the reference, found from the table of stages; what rays are; eyes inside a volume."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, function, lights, scene

import airlight as al
from airlight import reference
from airlight.reference.camera import CAMERAS
from airlight.stage import STAGES

LEVEL = 1 / 255
EYE, TARGET, UP = (9.0, -2.0, 4.0), (20.0, 13.0, 12.0), (0.2, 0.1, 1.0)
KINDS = sorted(STAGES["camera"])
VARIANTS = {
    **{name: {} for name in KINDS},
    "orthographic": {"height": 40.0},
    "left eye": {"name": "stereo", "view": "left", "interocular": 3.0, "convergence": 12.0},
    "right eye": {"name": "stereo", "view": "right", "fov_deg": 80.0},
    "half panorama": {"name": "panorama", "width_deg": 140.0, "height_deg": 60.0},
    "whole dome": {"name": "dome", "angle_deg": 360.0},
}


def made(kind: str, eye=EYE, target=TARGET, up=UP) -> al.Camera:
    options = dict(VARIANTS[kind])
    return STAGES["camera"][options.pop("name", kind)](eye=eye, target=target, up=up, **options)


def seen_from(camera: al.Camera, **look) -> al.Scene:
    return al.Scene(blobs(), transfer=function(), camera=camera, look=al.Look(**look), lights=lights(), background=None)


@pytest.mark.parametrize("kind", VARIANTS)
def test_pixels_are_those_of_the_reference(any_renderer, kind):
    """From an eye inside."""
    index = (blobs().index_from_world @ (*EYE, 1))[:3]
    assert (index > 0).all()
    assert (index < np.array(blobs().size) - 1).all()
    drawn = seen_from(made(kind))
    image, truth = any_renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert truth.rgba[..., 3].max() > 0.5
    assert np.abs(image.rgba - truth.rgba).max() <= LEVEL
    met = np.isfinite(truth.depth) & np.isfinite(image.depth)
    assert met.sum() > 20
    assert np.quantile(np.abs(image.depth[met] - truth.depth[met]), 0.98) < 0.05


@pytest.mark.parametrize("size", [(48, 40), (33, 50), (1, 7)])
@pytest.mark.parametrize("kind", VARIANTS)
def test_rays_are_those_of_the_reference(kind, size):
    camera = made(kind)
    y_px, x_px = (axis.ravel().astype(np.float64) for axis in np.indices(size[::-1]))
    origin, direction = CAMERAS[camera.name](camera, size, x_px, y_px)
    for n in range(0, len(x_px), 7):
        begins, goes = camera.ray((x_px[n] + 0.5, y_px[n] + 0.5), size)
        assert begins == pytest.approx(origin[n], abs=1e-12)
        assert goes == pytest.approx(direction[n], abs=1e-12)


@pytest.mark.parametrize("kind", VARIANTS)
def test_pixels_are_as_wide_as_cameras_tell(kind):
    """Two rays beside each other in the middle of the image, which one eye of two has for itself."""
    size, camera = (200, 160), made(kind)
    x, y = (50 if getattr(camera, "view", "") == "both" else 100), 80
    (begin, go), *others = (camera.ray(p, size) for p in ((x, y), (x + 1, y), (x, y + 1)))
    at_eye, per_world = camera.pixel_width(size)
    for distance in (0.0, 30.0):
        apart = max(np.linalg.norm(b + distance * d - begin - distance * go) for b, d in others)
        assert apart == pytest.approx(at_eye + per_world * distance, rel=0.02)
        told = reference.camera.pixel_width(camera, size, np.array([distance]))
        assert told == pytest.approx(at_eye + per_world * distance)


@settings(max_examples=25)
@given(data=st.data())
def test_eyes_anywhere_inside_see_no_holes(renderer, data):
    """The near plane is the eye: whatever it is in is drawn from there on."""
    unit = st.floats(-1, 1, allow_nan=False, width=32)
    kind = data.draw(st.sampled_from(sorted(VARIANTS)), label="camera")
    share = np.array([data.draw(st.floats(0, 1, width=32)) for _ in range(3)])
    size = np.array(blobs().size) - 1
    matrix = blobs().world_from_index
    eye = matrix[:3, :3] @ (share * size) + matrix[:3, 3]
    way = np.array(data.draw(st.tuples(unit, unit, unit).filter(lambda v: math.hypot(*v) > 0.1), label="way"))
    way = 10 * way / np.linalg.norm(way)
    up = np.roll(way, 1) * (1, 1, -1) + (0, 0, 1e-3)
    if np.linalg.norm(np.cross(way, up)) < 1.0:
        up = np.array([way[1], way[2], way[0] + 3.0])
    drawn = seen_from(made(kind, tuple(eye), tuple(eye + way), tuple(up)), shade="none")
    pixels = np.array([(x, y) for x in range(1, 24, 3) for y in range(1, 20, 3)])
    image = renderer.render(drawn, (24, 20))
    truth = reference.render(drawn, (24, 20), pixels=pixels)
    assert np.abs(image.rgba[pixels[:, 1], pixels[:, 0]] - truth.rgba).max() <= LEVEL


def test_eyes_of_one_image_are_those_of_two(renderer):
    camera = made("stereo")
    both = renderer.render(seen_from(camera), (96, 40))
    for half, eye in zip((both.rgba[:, :48], both.rgba[:, 48:]), camera.eyes(), strict=True):
        assert np.abs(half - renderer.render(seen_from(eye), (48, 40)).rgba).max() <= 1e-4


def test_points_at_the_convergence_have_no_parallax():
    """A nearer point lies further to the right for the left eye: it stands out of the screen."""
    camera = al.Camera.stereo(eye=(0, -50, 0), target=(0, 0, 0), fov_deg=40, interocular=6)
    left, right = camera.eyes()
    for p_px in ((100.0, 80.0), (31.0, 140.0)):
        points = []
        for eye in (left, right):
            begin, go = eye.ray(p_px, (200, 160))
            points.append(begin + go * (0 - begin[1]) / go[1])
        assert points[0] == pytest.approx(points[1], abs=1e-9)
    begins = [eye.ray((100, 80), (200, 160))[0] for eye in (left, right)]
    assert np.subtract(*begins) == pytest.approx((-6, 0, 0))
    near = np.array([0.0, -25, 0])
    columns = [_column_of(eye, near) for eye in (left, right)]
    assert columns[0] > 100 > columns[1]


def _column_of(camera, p_world):
    """Column, found by bisection, whose ray passes a point in the plane of the middle row."""
    low, high = 0.0, 200.0
    for _ in range(60):
        middle = (low + high) / 2
        begin, go = camera.ray((middle, 80), (200, 160))
        low, high = (middle, high) if np.cross(go, p_world - begin)[2] < 0 else (low, middle)
    return low


def test_unless_told_eyes_converge_on_the_target():
    told = al.Camera.stereo(eye=EYE, target=TARGET, interocular=math.dist(EYE, TARGET) / 30, convergence=math.dist(EYE, TARGET))
    plain = al.Camera.stereo(eye=EYE, target=TARGET)
    for p_px in ((3.5, 9.5), (40.5, 2.5)):
        for one, other in zip(plain.ray(p_px, SIZE), told.ray(p_px, SIZE), strict=True):
            assert one == pytest.approx(other)


def test_a_panorama_sees_each_direction_once():
    camera = al.Camera.panorama(eye=(0, 0, 0), target=(0, 1, 0))
    size = (64, 32)
    looks = {name: camera.ray(p, size)[1] for name, p in {"middle": (32, 16), "right": (48, 16), "top": (32, 0)}.items()}
    assert looks["middle"] == pytest.approx((0, 1, 0))
    assert looks["right"] == pytest.approx((1, 0, 0), abs=1e-12)
    assert looks["top"] == pytest.approx((0, 0, 1), abs=1e-12)
    assert camera.ray((0, 16), size)[1] == pytest.approx(camera.ray((64, 16), size)[1], abs=1e-12)


def test_a_dome_is_equidistant_and_round():
    camera = al.Camera.dome(eye=(0, 0, 0), target=(0, 1, 0), angle_deg=240)
    for share in (0.0, 0.3, 1.0):
        go = camera.ray((100 + 100 * share, 100), (200, 200))[1]
        assert math.degrees(math.acos(np.clip(go[1], -1, 1))) == pytest.approx(120 * share)
    assert not camera.ray((199, 1), (200, 200))[1].any()


def test_nothing_is_drawn_beside_the_disk(renderer):
    """Neither the volume that the eye is in nor what lies behind it."""
    sky = al.Environment.studio()
    for background in (None, sky):
        drawn = dataclasses.replace(seen_from(made("dome")), background=background)
        image, truth = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
        x, y = np.arange(48) + 0.5 - 24, np.arange(40)[:, None] + 0.5 - 20
        beside = np.hypot(x, y) > 20
        assert not image.rgba[beside].any()
        assert not truth.rgba[beside].any()
        assert np.isinf(image.depth[beside]).all()
        assert image.rgba[~beside][:, 3].max() > 0.5
        assert np.abs(image.rgba - truth.rgba).max() <= 2 * LEVEL


@pytest.mark.parametrize("kind", ["stereo", "panorama", "dome"])
def test_surfaces_lie_where_the_reference_finds_them(renderer, kind):
    drawn = seen_from(made(kind), integrate=al.integrate.FirstHit(iso=70.0))
    image, truth = renderer.render(drawn, SIZE, keep_hits=True), reference.render(drawn, SIZE)
    met = np.isfinite(truth.depth)
    assert met.sum() > 30
    assert (np.isfinite(image.depth) == met).mean() > 0.995
    both = met & np.isfinite(image.depth)
    assert np.quantile(np.abs(image.depth[both] - truth.depth[both]), 0.98) < 1e-3
    again = renderer.relight(image, drawn)
    assert np.abs(again.rgba - image.rgba).max() <= LEVEL


@pytest.mark.parametrize("kind", ["stereo", "panorama", "dome"])
def test_levels_follow_the_width_of_pixels(renderer, kind):
    drawn = seen_from(made(kind), field="levels", shade="none")
    assert np.abs(renderer.render(drawn, SIZE).rgba - reference.render(drawn, SIZE).rgba).max() <= 2 * LEVEL


def test_a_world_far_from_its_origin(renderer):
    shift = np.array([5e5, 6e6, -2e5])
    matrix = blobs().world_from_index.copy()
    matrix[:3, 3] += shift
    far = al.Volume(blobs().array, world_from_index=matrix)
    for kind in ("stereo", "panorama", "dome"):
        here = renderer.render(seen_from(made(kind), shade="none"), SIZE)
        camera = made(kind, tuple(EYE + shift), tuple(TARGET + shift))
        there = al.Scene(far, transfer=function(), camera=camera, look=al.Look(shade="none"), background=None)
        assert np.abs(renderer.render(there, SIZE).rgba - here.rgba).max() <= LEVEL


@pytest.mark.parametrize("kind", ["perspective", "panorama"])
def test_eyes_too_far_away_are_refused_wherever_they_look(renderer, kind):
    drawn = dataclasses.replace(scene(), camera=made(kind, eye=(0.0, -1e7, 0.0), target=(0.0, -2e7, 0.0)))
    with pytest.raises(al.ValueRangeError, match=r"camera is [\d,]+ steps away from the volume"):
        renderer.render(drawn, SIZE)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: al.Camera.stereo(eye=EYE, target=TARGET, interocular=-1), r"stereo.interocular is -1, must lie in \[0, inf"),
        (lambda: al.Camera.stereo(eye=EYE, target=TARGET, convergence=0), "stereo.convergence is 0, must lie in"),
        (lambda: al.Camera.stereo(eye=EYE, target=TARGET, view="middle"), "must be one of both, left, right"),
        (
            lambda: al.Camera.panorama(eye=EYE, target=TARGET, height_deg=200),
            r"panorama.height_deg is 200.0, must lie in \(0, 180\]",
        ),
        (lambda: al.Camera.dome(eye=EYE, target=TARGET, angle_deg=400), r"dome.angle_deg is 400.0, must lie in \(0, 360\]"),
        (lambda: al.Camera.dome(eye=EYE, target=EYE), "camera.dome looks from"),
    ],
)
def test_what_cameras_refuse(make, message):
    with pytest.raises(al.ValueRangeError, match=message):
        make()


@pytest.mark.parametrize("kind", VARIANTS)
def test_scene_files_hold_them(tmp_path, kind):
    drawn = dataclasses.replace(scene(), camera=made(kind))
    al.save_scene(drawn, tmp_path / "scene.toml", embed=tmp_path / "volume.nrrd")
    assert al.load_scene(tmp_path / "scene.toml")[0].camera == drawn.camera
