"""Slice drivers: the same slabs as the march takes, group by group, and samples on planes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, blobs, cameras, function, lights, scene
from test_labels import on_other_grid, parcels, styled
from test_labels import scene as scene_of_labels
from test_layers import large, small
from test_meshes import SCENES as MESHES
from test_meshes import ball, with_meshes

import airlight as al
from airlight import reference
from airlight.errors import LimitError, StageError, ValueRangeError
from airlight.rendering import rasterised
from airlight.stages.driver_slices import Planes

LEVEL = 1 / 255
MARCH = al.driver.March(blocks=False)
ISO = al.integrate.FirstHit(iso=70.0)
LOOKS = {
    "lit": {},
    "post": {"transfer": "postclassified", "lighting": "sampled"},
    "cut": {"transfer": "preintegrated_exact", "shade": "none"},
    "mip": {"integrate": "mip", "shade": "none"},
    "mean": {"integrate": "mean", "shade": "none"},
    "sum": {"integrate": "weighted_sum"},
    "first hit": {"integrate": ISO},
}


def farthest(one: al.Image, other: al.Image) -> float:
    """Greatest difference of two images, and of their depths where both have one."""
    both = np.isfinite(one.depth) & np.isfinite(other.depth)
    assert (np.isfinite(one.depth) == np.isfinite(other.depth)).mean() > 0.999
    apart = np.abs(np.where(both, one.depth, 0) - np.where(both, other.depth, 0)).max()
    return max(float(np.abs(one.rgba - other.rgba).max()), 0.01 * float(apart))


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("camera", ["perspective", "inside", "orthographic", "cut"])
def test_shells_are_the_march_in_groups(renderer: al.Renderer, look: str, camera: str) -> None:
    drawn = scene(camera=camera, **LOOKS[look])
    whole = renderer.render(drawn, SIZE, driver=MARCH)
    for group in (1, 7):
        assert farthest(whole, renderer.render(drawn, SIZE, driver=al.driver.Shells(group=group))) <= 2e-6


@pytest.mark.parametrize("look", LOOKS)
def test_slices_are_the_march_where_rays_are_parallel(renderer: al.Renderer, look: str) -> None:
    drawn = scene(camera="orthographic", **LOOKS[look])
    whole = renderer.render(drawn, SIZE, driver=MARCH)
    assert farthest(whole, renderer.render(drawn, SIZE, driver="slices")) <= LEVEL / 2


@pytest.mark.parametrize("look", ["lit", "post", "mip", "first hit"])
@pytest.mark.parametrize("camera", ["perspective", "inside"])
def test_slices_agree_with_the_reference(renderer: al.Renderer, look: str, camera: str) -> None:
    drawn, driver = scene(camera=camera, **LOOKS[look]), al.driver.Slices(group=9)
    truth = reference.render(drawn, SIZE, driver=driver, blocks=False)
    difference = np.abs(renderer.render(drawn, SIZE, driver=driver).rgba - truth.rgba)
    assert np.quantile(difference, 0.999) <= LEVEL
    assert difference.max() <= 4 * LEVEL


@pytest.mark.parametrize("look", ["lit", "mip", "mean", "sum", "first hit"])
def test_either_order_draws_the_same(renderer: al.Renderer, look: str) -> None:
    drawn = scene(**LOOKS[look])
    near, far = (renderer.render(drawn, SIZE, driver=al.driver.Shells(group=7, back_to_front=order)) for order in (False, True))
    # Rays that are all but opaque end early from front to back.
    assert np.abs(near.rgba - far.rgba).max() <= 1e-4
    if look == "lit":
        assert np.isinf(far.depth).all()
        assert far.stats["slices"]["order"] == "back to front, without depth"


def test_surfaces_of_several_layers_are_drawn_in_either_order(renderer: al.Renderer) -> None:
    layers = tuple(replace(layer, look=al.Look(integrate=al.integrate.FirstHit(iso=60.0))) for layer in layered().layers)
    drawn = replace(layered(), layers=layers)
    near, far = (renderer.render(drawn, SIZE, driver=al.driver.Shells(group=2, back_to_front=order)) for order in (False, True))
    assert farthest(near, far) <= 1e-6


def test_skipping_changes_nothing(renderer: al.Renderer) -> None:
    drawn = scene()
    for driver in (al.driver.Slices(group=5), al.driver.Shells(group=5)):
        skipped, whole = (renderer.render(drawn, SIZE, driver=driver, skip=skip) for skip in ("blocks", "none"))
        assert np.abs(skipped.rgba - whole.rgba).max() <= LEVEL
        assert skipped.stats["samples"] < whole.stats["samples"]


def gaps() -> al.Scene:
    array = blobs().array.copy()
    array[15:22, 10:20] = np.nan
    return scene(al.Volume(array, world_from_index=blobs().world_from_index))


def cuts() -> al.Scene:
    x, y, z = blobs().corners_world().mean(axis=0)
    clips = (
        al.Clip.plane(point=(x, y, z), normal=(1.0, -1.0, 0.3), capped=True),
        al.Clip.sphere(center=(x, y, z + 4), radius=9.0, keep="outside"),
    )
    return al.Scene(blobs(), transfer=function(), camera=cameras(blobs())["perspective"], clips=clips, lights=lights())


def covered() -> al.Scene:
    return with_meshes(*MESHES["both kinds"])


def layered() -> al.Scene:
    camera = al.Camera.perspective(eye=(45, 40, 30), target=(11, 11, 11), up=(0, 0, 1), fov_deg=30)
    return al.Scene(layers=(large(), small()), camera=camera, lights=lights(), background=None)


def in_world() -> al.Scene:
    """Tones of the whole image, over an environment."""
    return replace(scene(tone="reinhard"), background=al.Environment.sky())


def regions() -> al.Scene:
    return scene_of_labels(styled(on_other_grid(parcels())), shade="blinn_phong", integrate="emission_absorption")


def solid() -> al.Scene:
    return replace(scene(), clips=(al.Clip.mesh(ball(9.0)),))


@pytest.mark.parametrize("made", [gaps, cuts, covered, layered, in_world, regions, solid], ids=lambda made: made.__name__)
def test_all_that_rays_meet_is_drawn_in_parts(renderer: al.Renderer, made) -> None:
    drawn = made()
    whole = renderer.render(drawn, SIZE, step=1.5)
    parts = renderer.render(drawn, SIZE, step=1.5, driver=al.driver.Shells(group=2))
    assert farthest(whole, parts) <= 1e-6


def test_parts_on_the_core_device(core_renderer: al.Renderer) -> None:
    whole, parts = (core_renderer.render(gaps(), SIZE, step=1.5, driver=d) for d in ("march", al.driver.Shells(group=2)))
    assert farthest(whole, parts) <= 1e-6


def test_tiles_of_an_image_are_drawn_one_by_one(renderer: al.Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn, driver, told = scene(), al.driver.Slices(group=9), []
    whole = renderer.render(drawn, SIZE, driver=driver)
    monkeypatch.setattr(rasterised, "MOST_TILE", 17)
    parts = renderer.render(drawn, SIZE, driver=driver, progress=lambda what, done, total: told.append((done, total)))
    assert np.abs(whole.rgba - parts.rgba).max() <= 1e-5
    assert np.array_equal(whole.depth, parts.depth)
    assert told[-1][0] == told[-1][1] == 9 * whole.stats["slices"]["groups"]


@settings(max_examples=12, deadline=None)
@given(
    eye=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda eye: np.linalg.norm(eye) > 0.2),
    far=st.floats(0.1, 3),
    step=st.sampled_from([0.7, 1.0, 3.0]),
    is_flat=st.booleans(),
)
def test_proxies_cover_all_that_groups_show(renderer: al.Renderer, eye, far: float, step: float, is_flat: bool) -> None:
    corners = blobs().corners_world()
    middle = corners.mean(axis=0)
    reach = np.linalg.norm(corners - middle, axis=1).max()
    place = {
        "eye": tuple(middle + far * reach * np.array(eye) / np.linalg.norm(eye)),
        "target": tuple(middle),
        "up": (0.1, 0.2, 1),
    }
    camera = al.Camera.orthographic(**place, height=reach) if is_flat else al.Camera.perspective(**place, fov_deg=70)
    drawn = al.Scene(blobs(), transfer=function(), camera=camera, look=al.Look(shade="none"), background=None)
    whole = renderer.render(drawn, SIZE, step=step)
    parts = renderer.render(drawn, SIZE, step=step, driver=al.driver.Shells(group=3))
    assert np.abs(whole.rgba - parts.rgba).max() <= 1e-6


def uniform(volume: al.Volume, camera: al.Camera) -> al.Scene:
    """A volume that shows something everywhere, in an image without light."""
    points = [(-100, (1, 0.2, 0.1), 0.2 / volume.spacing[0]), (200, (0.1, 0.4, 1), 0.2 / volume.spacing[0])]
    return al.Scene(volume, transfer=al.TransferFunction(points), camera=camera, look=al.Look(shade="none"), background=None)


@pytest.mark.parametrize("pixel_voxels", [1, 8])
@pytest.mark.parametrize("origin", [(0, 0, 0), (1e6, -3e5, 2e6)])
def test_rays_on_the_border_of_the_domain_are_drawn(renderer: al.Renderer, origin, pixel_voxels: int) -> None:
    """Rasterisers leave out pixels whose middle lies right on an edge, as that of whole voxels a pixel does."""
    volume = al.Volume(np.ascontiguousarray(blobs().array[:33, :33, :17]), origin=origin)
    corners = volume.corners_world()
    middle, pixels = corners.mean(axis=0), 1 + 2 * (18 // pixel_voxels)
    camera = al.Camera.orthographic(
        eye=tuple(middle - (50, 0, 0)), target=tuple(middle), up=(0, 0, 1), height=pixels * pixel_voxels
    )
    drawn = uniform(volume, camera)
    whole = renderer.render(drawn, (pixels, pixels))
    assert (whole.rgba[..., 3] > 0.5).sum() == (32 // pixel_voxels + 1) ** 2
    for driver in (al.driver.Shells(group=9), al.driver.Slices(group=9)):
        assert farthest(whole, renderer.render(drawn, (pixels, pixels), driver=driver)) <= LEVEL / 2


@pytest.mark.parametrize("camera", ["perspective", "inside", "cut"])
def test_worlds_may_be_small(renderer: al.Renderer, camera: str) -> None:
    volume = al.Volume(blobs().array, spacing=(1e-10,) * 3)
    drawn = uniform(volume, cameras(volume)[camera])
    whole = renderer.render(drawn, SIZE)
    parts = renderer.render(drawn, SIZE, driver=al.driver.Shells(group=9))
    assert whole.rgba[..., 3].max() > 0.5
    assert np.abs(whole.rgba - parts.rgba).max() <= 1e-5


def test_planes_keep_their_places_whatever_the_numbers() -> None:
    planes = Planes(np.array([0.0, 0.6, 0.8]), 3.0, 0.5)
    points = np.array([[0, 0, 10.1], [0, 0, 30.0]])
    moved = planes.numbered_from(points)
    ahead = (points @ planes.normal - moved.first) / moved.spacing_world
    assert 0 <= ahead.min() < 1
    assert ((moved.first - planes.first) / 0.5) % 1 == pytest.approx(0, abs=1e-9)
    assert planes.seen_from(np.array([0, 0, 5.0])).first == pytest.approx(-1.0)


def test_nothing_is_drawn_of_what_lies_behind_the_eye(renderer: al.Renderer) -> None:
    middle = blobs().corners_world().mean(axis=0)
    ahead = np.array([0, 100, 0])
    away = {"eye": tuple(middle + ahead), "target": tuple(middle + 2 * ahead)}
    for camera in (al.Camera.perspective(**away), al.Camera.orthographic(**away, height=60)):
        for driver in ("shells", "slices"):
            image = renderer.render(replace(scene(shade="none"), camera=camera), SIZE, driver=driver)
            assert image.rgba.max() == 0
            assert image.stats["slices"]["count"] > 0


def test_what_slices_cannot_draw_is_refused(renderer: al.Renderer) -> None:
    drawn = scene()
    panorama = al.Scene(blobs(), transfer=function(), camera=al.Camera.panorama(eye=(0, 0, 0), target=(0, 1, 0)))
    with pytest.raises(StageError, match="draws no panorama images"):
        renderer.render(panorama, SIZE, driver="slices")
    with pytest.raises(StageError, match="keeps no surfaces"):
        renderer.render(drawn, SIZE, driver="slices", keep_hits=True)
    with pytest.raises(StageError, match="cannot put parts together of local_mip"):
        renderer.render(scene(integrate="local_mip", shade="none"), SIZE, driver=al.driver.Slices(back_to_front=True))
    with pytest.raises(StageError, match="has no order for meshes"):
        renderer.render(covered(), SIZE, driver=al.driver.Slices(back_to_front=True))
    with pytest.raises(ValueRangeError, match="draws whole images"):
        renderer.render(drawn, SIZE, driver="slices", tolerance=0.01)
    wide = replace(cameras(blobs())["inside"], fov_deg=179.5)
    with pytest.raises(ValueRangeError, match='or driver="shells"'):
        renderer.render(replace(drawn, camera=wide), SIZE, driver="slices")
    with pytest.raises(LimitError, match="slices, at most"):
        renderer.render(drawn, SIZE, driver="slices", step=0.001)
    with pytest.raises(ValueRangeError, match=r"driver.slices.group is 0"):
        al.driver.Slices(group=0)
