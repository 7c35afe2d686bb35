"""From pixels to the points that they show."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, scene

import airlight as al
from airlight import reference
from airlight.first_picture import resolved_camera


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
def test_rays_are_those_of_the_reference(camera):
    camera = cameras(blobs())[camera]
    x_px, y_px = np.array([0.0, 17, 47, 30]), np.array([0.0, 39, 5, 20])
    origin, direction = reference.camera.CAMERAS[camera.name](camera, SIZE, x_px, y_px)
    for n in range(4):
        begins, goes = camera.ray((x_px[n] + 0.5, y_px[n] + 0.5), SIZE)
        assert begins == pytest.approx(origin[n], abs=1e-12)
        assert goes == pytest.approx(direction[n], abs=1e-12)


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "front", "iso"])
def test_picked_points_lie_on_the_surface(renderer, camera):
    """Wherever the surface of a value is not the face of the volume, the field has that value at picked points."""
    iso = 70.0
    camera = cameras(blobs()).get(camera, camera)
    drawn = dataclasses.replace(scene(integrate=al.integrate.FirstHit(iso=iso)), camera=camera)
    image = renderer.render(drawn, SIZE, step=0.5)
    points = [al.pick(image, drawn, (x, y)) for x in range(0, 48, 3) for y in range(0, 40, 3)]
    assert [p is not None for p in points] == np.isfinite(image.depth[::3, ::3].T).ravel().tolist()
    setup = reference.prepare(dataclasses.replace(drawn, camera=resolved_camera(drawn, SIZE)))
    p_index = setup.index_of(np.array([p for p in points if p is not None]))
    inside = ((p_index > setup.domain[0] + 0.1) & (p_index < setup.domain[1] - 0.1)).all(axis=1)
    assert inside.sum() > 10
    assert reference.field.field_value(setup, p_index[inside])[0] == pytest.approx(iso, abs=1.0)


@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
def test_points_come_back_to_their_pixels(renderer, camera):
    """Projected by the camera's frame, which shares nothing with rays, a picked point falls on the middle of its pixel."""
    drawn = scene(camera=camera)
    image = renderer.render(drawn, SIZE)
    eye, (right, up, forward) = np.array(drawn.camera.eye), drawn.camera.basis()
    for row, column in np.argwhere(np.isfinite(image.depth))[::97]:
        way = np.array(al.pick(image, drawn, (int(column), int(row)))) - eye
        if camera == "perspective":
            assert np.linalg.norm(way) == pytest.approx(image.depth[row, column], rel=1e-6)
            half = np.tan(np.radians(drawn.camera.fov_deg) / 2) * (way @ forward)
        else:
            assert way @ forward == pytest.approx(image.depth[row, column], rel=1e-5)
            half = drawn.camera.height / 2
        x, y = way @ right / half * SIZE[1] / SIZE[0], way @ up / half
        assert ((x + 1) / 2 * SIZE[0], (1 - y) / 2 * SIZE[1]) == pytest.approx((column + 0.5, row + 0.5), abs=1e-6)


def test_a_peak_at_a_picked_point_shows_what_was_picked(renderer):
    """Two calls: the function has its peak at the value of the surface."""
    drawn = scene(integrate=al.integrate.FirstHit(iso=75.0))
    image = renderer.render(drawn, SIZE, step=0.25)
    point = al.pick(image, drawn, (24, 20))
    peak = al.automatic.peak_at(blobs(), point)
    assert peak.points[1][0] == pytest.approx(75, abs=1)


def test_pixels_outside_and_rays_that_nobody_knows(renderer):
    drawn = scene()
    image = renderer.render(drawn, SIZE)
    for pixel in ((48, 0), (0, 40), (-1, 3)):
        with pytest.raises(al.ValueRangeError, match="must lie in the image of 48 x 40"):
            al.pick(image, drawn, pixel)
    with pytest.raises(al.ValueRangeError, match=r"pixel is \(3\.5, 2\), must be a whole column and row"):
        al.pick(image, drawn, (3.5, 2))
    for pixel in (None, (1, 2, 3), 7, "ab"):
        with pytest.raises(al.ValueRangeError, match=r"^pixel is "):
            al.pick(image, drawn, pixel)
    with pytest.raises(al.DataError, match=r"scene is a NoneType"):
        al.pick(image, None, (3, 2))
    with pytest.raises(al.DataError, match=r"image is a Scene: pass what .* returned, then the scene"):
        al.pick(drawn, image, (3, 2))
    with pytest.raises(al.StageError, match="does not tell its rays"):
        al.Camera.ray(drawn.camera, (1, 1), SIZE)
