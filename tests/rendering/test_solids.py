"""Closed meshes that clip, meshes that are clipped, and clips that cut in front or behind alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, rotation, scene
from test_meshes import SCENES, ball, sphere, with_meshes

import airlight as al
from airlight import reference
from airlight.errors import LimitError, StageError, ValueRangeError
from airlight.reference.clips import winding

LEVEL = 1 / 255
MIDDLE = blobs().corners_world().mean(axis=0)
CAMERAS = ("perspective", "orthographic", "inside", "cut")
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])[:, [0, 1, 2, 0, 2, 3]]
FACES = FACES.reshape(-1, 3)


def at(*offset: float) -> tuple[float, float, float]:
    x, y, z = MIDDLE + offset
    return float(x), float(y), float(z)


def cube(low, high, **options) -> al.Mesh:
    return al.Mesh(low + CUBE * np.subtract(high, low), FACES, smooth=False, **options)


def ring(large: float = 9.0, small: float = 3.5, rows: int = 18, columns: int = 8, **options) -> al.Mesh:
    """A torus: rays pass it in two pieces."""
    a, b = (2 * np.pi * np.arange(n) / n for n in (rows, columns))
    along, across = np.meshgrid(a, b, indexing="ij")
    out = large + small * np.cos(across)
    vertices = np.stack([out * np.cos(along), out * np.sin(along), small * np.sin(across)], axis=-1).reshape(-1, 3)
    i, j = (axis.ravel() for axis in np.indices((rows, columns)))
    at = lambda di, dj: (i + di) % rows * columns + (j + dj) % columns  # noqa: E731
    faces = np.concatenate([np.stack([at(0, 0), at(1, 0), at(1, 1)], 1), np.stack([at(0, 0), at(1, 1), at(0, 1)], 1)])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation((1, 0.3, 0.2), 0.7), MIDDLE
    return al.Mesh(vertices, faces, world_from_mesh=matrix, **options)


def clipped(*clips: al.Clip, camera: str = "perspective", **look) -> al.Scene:
    return dataclasses.replace(scene(None, camera, **look), clips=clips)


def strays(renderer, drawn: al.Scene, **options) -> int:
    """How many pixels differ from the reference."""
    image, truth = renderer.render(drawn, SIZE, **options), reference.render(drawn, SIZE, **options)
    assert np.isfinite(image.rgba).all()
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert np.quantile(error, 0.99) <= LEVEL
    return int((error > LEVEL).sum())


# -- closed meshes as clips


@pytest.mark.parametrize("cuts", ["volume", "front", "back"])
@pytest.mark.parametrize("camera", CAMERAS)
def test_a_cube_is_a_box(either_renderer, camera, cuts):
    low, high = tuple(MIDDLE - (10, 12, 14)), at(10, 12, 14)
    for keep, capped in (("inside", False), ("outside", True)):
        told = {"keep": keep, "cuts": cuts, "capped": capped}
        images = [
            either_renderer.render(clipped(clip, camera=camera, lighting="interpolated"), SIZE)
            for clip in (al.Clip.box(low=low, high=high, **told), al.Clip.mesh(cube(low, high), **told))
        ]
        assert np.abs(images[0].rgba - images[1].rgba).max() <= 1e-4
        assert images[1].stats["clips"]["cutting"] == 1


@pytest.mark.parametrize("keep", ["inside", "outside"])
@pytest.mark.parametrize("camera", ["perspective", "inside"])
def test_parity(either_renderer, camera, keep):
    """Several pieces of a ray, faces lit by smooth normals, solid faces, and another clip beside it."""
    plane = al.Clip.plane(point=tuple(MIDDLE), normal=(0.2, 1, 0.4))
    for capped in (False, True):
        solid = al.Clip.mesh(ring(), keep=keep, capped=capped)
        assert strays(either_renderer, clipped(solid, plane, camera=camera, lighting="interpolated")) <= 1


def test_parity_of_flat_faces_and_surfaces(renderer):
    assert strays(renderer, clipped(al.Clip.mesh(ring(smooth=False)), integrate=al.integrate.FirstHit(iso=70.0))) <= 2
    assert strays(renderer, clipped(al.Clip.mesh(ring(), keep="outside"), integrate="mean"), step=2.0) <= 1


@pytest.mark.parametrize("cuts", ["front", "back"])
def test_parity_of_what_is_in_front_or_behind(renderer, cuts):
    """Of a ring, and of the other shapes: with the eye in front of them and inside. Cuts are exact whatever the step."""
    for camera in ("perspective", "inside"):
        for keep in ("inside", "outside"):
            told = {"keep": keep, "cuts": cuts}
            for clip in (al.Clip.mesh(ring(), **told), al.Clip.sphere(center=at(3, -4, 2), radius=8, **told)):
                assert strays(renderer, clipped(clip, camera=camera, lighting="interpolated"), step=2.0) <= 1
    plane = al.Clip.plane(point=tuple(MIDDLE), normal=(0.2, 1, 0.4), cuts=cuts)
    assert strays(renderer, clipped(plane, lighting="interpolated"), step=2.0) <= 1


def test_rays_that_miss_a_clip_in_front_stay_whole(renderer):
    """The shape opens the volume where it is seen, and its shadow behind it is not cut away."""
    solid = cube(MIDDLE - 4, MIDDLE + 4)
    whole, front, back = (
        renderer.render(clipped(*clips), SIZE).rgba
        for clips in (
            (),
            [al.Clip.mesh(solid, keep="outside", cuts="front")],
            [al.Clip.mesh(solid, keep="outside", cuts="back")],
        )
    )
    alone = dataclasses.replace(with_meshes(solid), layers=())
    beside = renderer.render(alone, SIZE).rgba[..., 3] == 0
    assert beside.any()
    assert (~beside).any()
    assert np.array_equal(front[beside], whole[beside])
    assert np.array_equal(back[beside], whole[beside])
    opaque = renderer.render(with_meshes(dataclasses.replace(solid, color=(0, 0, 0), lit=False)), SIZE).rgba
    assert np.abs(back - opaque)[..., :3].max() < 0.02  # as an opaque thing in its place, but for the light of faces


def test_how_faces_run_does_not_matter(renderer):
    """Faces that look in, a mirrored mesh, corners that faces do not share, and a ball within a ball."""
    vertices, faces = sphere(9.0)
    vertices = vertices * (1, 1, 0.7) + (0, 0, 2)
    place = np.eye(4)
    place[:3, 3] = MIDDLE
    mirror = place @ np.diag([1, 1, -1, 1])
    told = {"smooth": False}
    one = al.Mesh(vertices, faces, world_from_mesh=place, **told)
    others = [
        al.Mesh(vertices, faces[:, ::-1], world_from_mesh=place, **told),
        al.Mesh(vertices * (1, 1, -1), faces, world_from_mesh=mirror, **told),
        al.Mesh(vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3), world_from_mesh=place, **told),
        al.Mesh(
            np.concatenate([vertices, 0.5 * vertices]),
            np.concatenate([faces, faces + len(vertices)]),
            world_from_mesh=place,
            **told,
        ),
    ]
    expected = renderer.render(clipped(al.Clip.mesh(one)), SIZE).rgba
    assert expected.any()
    for other in others:
        assert other.outward == (-1 if other is others[0] else 1)
        assert np.abs(renderer.render(clipped(al.Clip.mesh(other)), SIZE).rgba - expected).max() < 1e-3
    hollow = al.Mesh(
        np.concatenate([vertices, 0.5 * vertices]),
        np.concatenate([faces, faces[:, ::-1] + len(vertices)]),
        world_from_mesh=place,
    )
    assert strays(renderer, clipped(al.Clip.mesh(hollow, capped=True))) <= 1


def test_far_from_the_origin_and_in_tiles(renderer, monkeypatch):
    from airlight.rendering import rasterised

    solid = al.Clip.mesh(ring(), keep="outside")
    whole = renderer.render(clipped(solid), SIZE).rgba
    monkeypatch.setattr(rasterised, "MOST_TILE", 17)
    error = np.abs(renderer.render(clipped(solid), SIZE).rgba - whole).max(axis=-1)
    assert (error > 1e-4).mean() < 0.01
    monkeypatch.undo()
    away, matrix = np.array([4.3e6, -6.1e5, 2.2e5]), blobs().world_from_index.copy()
    matrix[:3, 3] += away
    move = np.eye(4)
    move[:3, 3] = away
    volume = al.Volume(blobs().array, world_from_index=matrix)
    moved = dataclasses.replace(scene(volume), clips=[al.Clip.mesh(solid.closed.moved(move), keep="outside")])
    assert strays(renderer, moved) <= 3


def test_a_mesh_beyond_the_volume_is_left_out(renderer):
    away = al.Clip.mesh(cube(MIDDLE + 80, MIDDLE + 90), keep="outside")
    assert renderer.explain(clipped(away)).key == renderer.explain(clipped()).key
    image = renderer.render(clipped(dataclasses.replace(away, keep="inside")), SIZE)
    assert image.stats["reason"] == "scene.clips[0], a mesh, leaves nothing of the volume"


def test_limits_and_refusals(renderer):
    shells = [sphere(r, 5, 8) for r in np.linspace(2, 12, 10)]
    counts = np.cumsum([0, *(len(v) for v, _ in shells[:-1])])
    vertices = np.concatenate([v for v, _ in shells]) + MIDDLE
    faces = np.concatenate([f + n for (_, f), n in zip(shells, counts, strict=True)])
    many = clipped(al.Clip.mesh(al.Mesh(vertices, faces)))
    with pytest.raises(LimitError, match=r"with 20 surfaces behind one pixel.*March\(clip_layers=20\)"):
        renderer.render(many, SIZE)
    assert renderer.render(many, SIZE, driver=al.driver.March(clip_layers=20)).rgba.any()
    for name, most in (("clip_layers", 64), ("mesh_layers", 32)):
        with pytest.raises(ValueRangeError, match=rf"{name} is {most + 1}, must be a whole number in .*{most}]"):
            al.driver.March(**{name: most + 1})
    hidden = clipped(al.Clip.mesh(ring()), visibility=al.visibility.AmbientOcclusion(cells=12, directions=16))
    with pytest.raises(StageError, match="knows nothing of a mesh that cuts rays"):
        renderer.render(hidden, SIZE)


def test_several_layers(renderer):
    """One mesh cuts all of them, and rays that meet none of them end."""
    one = scene(None, "perspective").layers[0]
    other = dataclasses.replace(one, volume=al.Volume(blobs().array[::-1].copy(), world_from_index=blobs().world_from_index))
    for solid in (al.Clip.mesh(ring(), keep="outside", capped=True), al.Clip.mesh(ring(), cuts="front")):
        assert strays(renderer, dataclasses.replace(clipped(solid), layers=(one, other)), step=2.0) <= 1


def test_profiles_follow_what_is_kept():
    """A ray's profile is cut where its picture is."""
    solid = al.Clip.mesh(cube(MIDDLE - 5, MIDDLE + 5), cuts="front")
    drawn = clipped(solid)
    profile = al.ray_profile(drawn, SIZE, (SIZE[0] / 2, SIZE[1] / 2))
    origin, direction = drawn.camera.ray((SIZE[0] / 2, SIZE[1] / 2), SIZE)
    begin = reference.clips.surface_distances(solid, origin[None], direction[None]).min()
    assert (profile.extinction[profile.t_world < begin - 1e-6] == 0).all()
    assert (profile.extinction > 0).any()


def test_winding_is_one_inside():
    vertices, faces = sphere(1.0)
    rng = np.random.default_rng(1)
    p_world = rng.uniform(-1.5, 1.5, (200, 3))
    away = np.linalg.norm(p_world, axis=1)
    clear = (away < 0.85) | (away > 1)
    np.testing.assert_allclose(np.abs(winding(vertices[faces], p_world))[clear], (away < 0.85)[clear], atol=1e-9)


# -- clips that cut meshes


@pytest.mark.parametrize(("name", "camera"), [("interleaved", "perspective"), ("both kinds", "cut")])
def test_clipped_meshes(any_renderer, name, camera):
    clips = [
        al.Clip.plane(point=tuple(MIDDLE), normal=(0.3, 0.8, 0.2)),
        al.Clip.mesh(ring(), keep="outside"),
        al.Clip.sphere(center=at(5, -6, 3), radius=7, keep="outside", cuts="front"),
    ]
    meshes = [dataclasses.replace(mesh, clipped=True) for mesh in SCENES[name]]
    drawn = dataclasses.replace(with_meshes(*meshes, camera=camera), clips=clips)
    assert strays(any_renderer, drawn) <= 8
    uncut = dataclasses.replace(drawn, meshes=SCENES[name])
    assert strays(any_renderer, uncut) <= 8


def test_clipped_meshes_alone(renderer, monkeypatch):
    """Without a volume, and drawn again, in parts, where there is no room for all triangles."""
    from airlight.rendering import covers, rasterised

    plane = al.Clip.plane(point=tuple(MIDDLE), normal=(0.3, 0.8, 0.2))
    meshes = [ball(r, opacity=0.4, clipped=True) for r in (14.0, 9.0)]
    drawn = al.Scene(meshes=meshes, camera=cameras(blobs())["perspective"], background=None, clips=[plane])
    one = renderer.render(drawn, SIZE)
    assert 0.1 < one.rgba[..., 3].max() < 1
    monkeypatch.setattr(covers, "SLOTS", 1)
    monkeypatch.setattr(rasterised, "MOST_FRAGMENT_BYTES", 4 * 40 * 40)
    two = renderer.render(drawn, SIZE)
    monkeypatch.undo()
    assert np.abs(one.rgba - two.rgba).max() < 1e-5
    assert one.stats["meshes"] == two.stats["meshes"]
    uncut = renderer.render(dataclasses.replace(drawn, clips=()), SIZE)
    assert uncut.rgba[..., 3].sum() > 1.2 * one.rgba[..., 3].sum()


# -- two eyes


@pytest.mark.parametrize(("view", "size"), [("both", (SIZE[0] + 1, SIZE[1])), ("right", SIZE)])
def test_stereo(any_renderer, view, size):
    """Opaque and semi-transparent meshes, and one that clips, as each eye sees them."""
    one = cameras(blobs())["perspective"]
    camera = al.Camera.stereo(eye=one.eye, target=one.target, up=one.up, fov_deg=one.fov_deg, interocular=8.0)
    drawn = dataclasses.replace(with_meshes(*SCENES["both kinds"]), clips=[al.Clip.mesh(ring(), keep="outside")])
    both = dataclasses.replace(drawn, camera=dataclasses.replace(camera, view=view))
    image, truth = any_renderer.render(both, size), reference.render(both, size)
    error = np.abs(image.rgba - truth.rgba).max(axis=-1)
    assert (error > LEVEL).mean() < 0.012
