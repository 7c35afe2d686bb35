"""Meshes, lines and points for cameras that look all round: pixels show what their rays meet, without seams."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from scenes import blobs
from test_meshes import MIDDLE, ball, sphere, with_meshes
from test_solids import at, clipped, ring

import airlight as al
from airlight import reference
from airlight.errors import StageError
from airlight.first_picture import resolve
from airlight.geometry import Lines, Mesh, Points
from airlight.rendering.annotating import annotated
from airlight.stages.camera import Perspective

SIZE = (48, 32)
WITHIN, BESIDE = at(1, 2, 3), at(20, -40, 13)
CAMERAS = {
    "panorama": al.Camera.panorama(eye=WITHIN, target=at(5, 1, 0)),
    "part": al.Camera.panorama(eye=BESIDE, target=at(5, 1, 60), width_deg=200, height_deg=120),
    "dome": al.Camera.dome(eye=WITHIN, target=at(5, 1, 0), angle_deg=220),
    "all round": al.Camera.dome(eye=BESIDE, target=tuple(MIDDLE), angle_deg=360),
}


def worst(renderer, scene: al.Scene, size=SIZE) -> float:
    """Greatest error of any pixel: rays meet the very triangles that the reference's meet, at edges, too."""
    image, truth = renderer.render(scene, size), reference.render(scene, size)
    assert truth.rgba[..., 3].max() > 0.2
    return float(np.abs(image.rgba - truth.rgba).max())


@pytest.mark.parametrize("camera", CAMERAS)
def test_parity(any_renderer, camera):
    """What is opaque, and what lets light pass, flat, and smooth: in front of each other."""
    meshes = ball(14.0, opacity=0.4), ball(30.0, smooth=False, opacity=0.3), ball(6.0)
    assert worst(any_renderer, dataclasses.replace(with_meshes(*meshes), camera=CAMERAS[camera])) <= 1 / 255


@pytest.mark.parametrize(
    ("camera", "cuts"), [("panorama", {"keep": "outside", "capped": True}), ("all round", {"cuts": "front"})]
)
def test_parity_of_closed_meshes_that_clip(renderer, camera, cuts):
    """A ring, which rays pass in two pieces, cuts the volume and meshes in it."""
    meshes = ball(12.0, opacity=0.5, clipped=True), ball(8.0, clipped=True)
    scene = dataclasses.replace(with_meshes(*meshes), clips=[al.Clip.mesh(ring(), **cuts)])
    assert worst(renderer, dataclasses.replace(scene, camera=CAMERAS[camera])) <= 1 / 255


@pytest.mark.parametrize("camera", CAMERAS)
def test_lines_and_points(renderer, camera):
    """All but for edges: bands are cut every ten degrees, and the reference has the whole of one."""
    rng = np.random.default_rng(5)
    ends, spots = MIDDLE + rng.uniform(-30, 30, (12, 2, 3)), MIDDLE + rng.uniform(-30, 30, (20, 3))
    marks = (
        Lines(ends, colors=rng.uniform(0, 1, (12, 3)), width_px=1.5),
        Lines(ends + 3, width_world=1.0, opacity=0.5),
        Points(spots, color="orange", width_px=7, opacity=0.6),
        Points(spots + 4, width_world=3.0),
    )
    scene, size = dataclasses.replace(with_meshes(*marks), camera=CAMERAS[camera]), (96, 48)
    image, truth = renderer.render(scene, size, driver=al.driver.March(mesh_layers=12)), reference.render(scene, size)
    assert (np.abs(image.rgba - truth.rgba).max(axis=-1) > 0.02).mean() < 0.012


@pytest.mark.parametrize("camera", ["panorama", "all round"])
def test_annotations(renderer, camera):
    """Grids, axes and pointers are lines and meshes: the reference draws the same, all but for edges of thin lines."""
    notes = (
        al.Grid(color="gold"),
        al.Axes(origin=at(9, 3, 3), length=14),
        al.Pointer(at(3, 14, 8), size_voxels=14, shape="arrow"),
    )
    scene = dataclasses.replace(with_meshes(ball(6.0)), camera=CAMERAS[camera], annotations=notes)
    image = renderer.render(scene, (96, 48))
    drawn, _ = annotated(resolve(scene, (96, 48)), (96, 48))
    truth = reference.render(drawn, (96, 48))
    assert (np.abs(image.rgba - truth.rgba).max(axis=-1) > 0.02).mean() < 0.012
    assert image.marks


@pytest.mark.parametrize("angle_deg", [None, 360.0])
def test_a_sphere_round_the_eye_has_no_holes(any_renderer, angle_deg):
    """Of 79,600 triangles, one a pixel or smaller and one corner of 400: all pixels see them, at the radius."""
    told = {"eye": (0, 0, 0), "target": (1, 0.3, 0)}
    camera = al.Camera.panorama(**told) if angle_deg is None else al.Camera.dome(**told, angle_deg=angle_deg)
    image = any_renderer.render(al.Scene(meshes=[Mesh(*sphere(10.0, 200, 200))], camera=camera), (256, 128))
    y, x = np.indices((128, 256))
    in_image = np.full((128, 256), True) if angle_deg is None else np.hypot(x + 0.5 - 128, y + 0.5 - 64) < 64
    assert np.isfinite(image.depth[in_image]).all()
    assert not np.isfinite(image.depth[~in_image]).any()
    assert abs(image.depth[in_image] - 10).max() < 10 * (1 - np.cos(np.pi / 199)) * 2


def test_a_plane_at_a_known_distance(any_renderer):
    """Two triangles that are seen over half of all directions."""
    corners = 500.0 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) - (0, 0, 3)
    camera = al.Camera.panorama(eye=(0, 0, 0), target=(1, 0, 0))
    image = any_renderer.render(al.Scene(meshes=[Mesh(corners, [[0, 1, 2], [0, 2, 3]])], camera=camera), (128, 64))
    down = np.sin(np.pi * ((np.arange(32, 64) + 0.5) / 64 - 0.5))
    assert not np.isfinite(image.depth[:32]).any()
    assert np.abs(image.depth[33:] * down[1:, None] / 3 - 1).max() < 5e-5


def test_a_camera_that_tells_no_places_is_refused(renderer):
    @dataclass(frozen=True)
    class RaysAlone(Perspective):
        name: ClassVar[str] = "rays_alone"
        wgsl: ClassVar[str] = (
            "import package::ray::Ray;\n"
            "fn eye_ray(p_px: vec2f) -> Ray { return Ray(vec3f(0.0), normalize(vec3f(p_px.x, 9.0, p_px.y))); }\n"
        )

    camera = RaysAlone(eye=WITHIN, target=BESIDE)
    for scene in (with_meshes(ball(5.0)), clipped(al.Clip.mesh(ring()))):
        with pytest.raises(StageError, match="neither clip_place nor seen_within"):
            renderer.render(dataclasses.replace(scene, camera=camera), SIZE)
    assert renderer.render(al.Scene(blobs(), camera=camera), SIZE).rgba.shape
