"""Meshes, lines and points among volumes: parity with rays that meet triangles in float64, laws, limits, and errors."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, function, lights, rotation

import airlight as al
from airlight import reference
from airlight.errors import DataError, LimitError, StageError
from airlight.geometry import Lines, Mesh, Points
from airlight.reference.intersections import intersections

MIDDLE = blobs().corners_world().mean(axis=0)


def sphere(radius: float, rows: int = 9, columns: int = 14) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a sphere of triangles."""
    polar, azimuth = np.linspace(0, np.pi, rows), 2 * np.pi * np.arange(columns) / columns
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    vertices = radius * np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=-1).reshape(-1, 3)
    cell = (np.arange(rows - 1)[:, None] * columns + np.arange(columns)).ravel()
    right = (np.arange(rows - 1)[:, None] * columns + (np.arange(columns) + 1) % columns).ravel()
    faces = np.concatenate([np.stack([cell, cell + columns, right], 1), np.stack([right, cell + columns, right + columns], 1)])
    return vertices, faces


def ball(radius: float, place=MIDDLE, **options) -> Mesh:
    vertices, faces = sphere(radius)
    rng = np.random.default_rng(3)
    options.setdefault("colors", rng.uniform(0.1, 1, (len(vertices), 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 1, 2), 0.7) * (1.0, 1.2, 0.8)
    matrix[:3, 3] = place
    return Mesh(vertices, faces, world_from_mesh=matrix, **options)


def with_meshes(*meshes, camera="perspective", volume=None, **look) -> al.Scene:
    volume = volume or blobs()
    look.setdefault("field", "linear_exact")
    return al.Scene(
        volume,
        transfer=function(),
        camera=cameras(volume)[camera],
        look=al.Look(**look),
        lights=lights(),
        background=None,
        meshes=meshes,
    )


def compare(renderer, scene: al.Scene, strays: float = 0.012, step: float = 1.0, size=SIZE, tolerance: float = 1 / 255) -> None:
    """Images agree but for pixels whose rays all but touch an edge, which rasteriser and reference may see on either side."""
    image, truth = renderer.render(scene, size, step=step), reference.render(scene, size, step=step)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    assert np.isfinite(image.rgba).all()
    assert error[: error.size - int(strays * error.size)].max() <= tolerance
    met = np.isfinite(truth.depth)
    assert (np.isfinite(image.depth) == met).mean() > 1 - strays
    both = met & np.isfinite(image.depth)
    assert both.any()
    assert np.quantile(np.abs(image.depth[both] - truth.depth[both]), 0.98) < 5e-3


SCENES = {
    "opaque within": (ball(9.0),),
    "opaque in front": (ball(6.0, MIDDLE + np.array([14, -25, 8])),),
    "opaque behind": (ball(16.0, MIDDLE - (20, -40, 8)),),
    "around": (ball(30.0),),
    "flat": (ball(10.0, smooth=False),),
    "one colour, unlit": (ball(11.0, colors=None, color="orange", lit=False),),
    "translucent": (ball(12.0, opacity=0.55),),
    "interleaved": (ball(14.0, opacity=0.3), ball(7.0, MIDDLE + np.array([2, 1, 0]), opacity=0.6)),
    "both kinds": (ball(14.0, opacity=0.4), ball(6.0)),
    "vertices let light pass": (ball(12.0, colors=np.random.default_rng(1).uniform(0.2, 0.9, (9 * 14, 4))),),
}


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("name", SCENES)
def test_parity(either_renderer, name, camera):
    compare(either_renderer, with_meshes(*SCENES[name], camera=camera))


@pytest.mark.parametrize("name", SCENES)
def test_parity_of_surfaces(any_renderer, name):
    compare(any_renderer, with_meshes(*SCENES[name], integrate=al.integrate.FirstHit(iso=70.0)), strays=0.02)


@pytest.mark.parametrize(
    "look",
    [
        {"transfer": "postclassified"},
        {"lighting": "interpolated"},
        {"shade": "none"},
        {"shade": al.shade.BlinnPhong(ambient=0.3, two_sided=False)},
        {"field": "nearest"},
        {"tone": "reinhard"},
    ],
    ids=str,
)
def test_parity_of_looks(renderer, look):
    compare(renderer, with_meshes(*SCENES["both kinds"], **look), strays=0.02)


@pytest.mark.parametrize("integrate", ["mip", "minip", "mean"])
def test_values_along_the_ray_end_at_what_is_opaque(renderer, integrate):
    compare(renderer, with_meshes(*SCENES["opaque within"], SCENES["opaque in front"][0], integrate=integrate), strays=0.02)


@pytest.mark.parametrize("step", [0.4, 3.0])
def test_slabs_are_cut_at_meshes(renderer, step):
    """Large steps leave no staircase: a slab that is cut has its true length and end."""
    compare(renderer, with_meshes(*SCENES["interleaved"]), step=step)


def test_interleaved_offsets(renderer):
    scene = with_meshes(*SCENES["interleaved"])
    image = renderer.render(scene, SIZE, driver=al.driver.March(offsets="interleaved"), step=2.0)
    truth = renderer.render(scene, SIZE, step=0.1)
    assert np.abs(image.rgba - truth.rgba).mean() < 0.01


def test_empty_samples(renderer):
    _, y, x = np.mgrid[:40, :36, :32]
    grid = np.where((x + y) % 9 < 3, np.nan, blobs().array).astype(np.float32)
    volume = al.Volume(grid, world_from_index=blobs().world_from_index)
    compare(renderer, with_meshes(*SCENES["interleaved"], volume=volume), strays=0.03)


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside"])
def test_lines_and_points(any_renderer, camera):
    rng = np.random.default_rng(5)
    reach = np.linalg.norm(blobs().corners_world() - MIDDLE, axis=1).max()
    ends = MIDDLE + rng.uniform(-reach, reach, (12, 2, 3))
    spots = MIDDLE + rng.uniform(-reach, reach, (20, 3))
    marks = (
        Lines(ends, width_px=3.0, colors=rng.uniform(0, 1, (12, 3))),
        Points(spots, width_px=5.0, color="gold"),
        Lines.box(blobs(), width_world=0.8, opacity=0.5),
        Points(spots[:6] + 1.0, width_world=3.0, opacity=0.4),
    )
    scene = with_meshes(*marks, camera=camera)
    image = any_renderer.render(scene, SIZE, driver=al.driver.March(mesh_layers=12))
    truth = reference.render(scene, SIZE)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    assert error[: int(0.98 * error.size)].max() <= 1 / 255
    assert image.stats["meshes"]["pixels_with_more_layers"] == 0


@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
def test_depth_is_where_rays_meet_triangles(any_renderer, camera):
    """The distance of an unlit mesh alone, at twenty thousand pixels, is that of the ray's own intersection."""
    mesh = ball(20.0)
    size = (160, 128)
    scene = al.Scene(meshes=[mesh], camera=cameras(blobs())[camera])
    image = any_renderer.render(scene, size)
    y, x = (axis.ravel() for axis in np.indices(size[::-1]))
    origin, direction = reference.TABLES["camera"][camera](scene.camera, size, x, y)
    vertices = mesh.vertices @ mesh.matrix[:3, :3].T + mesh.matrix[:3, 3]
    truth = intersections(vertices[mesh.faces], origin, direction)[0].min(axis=1).reshape(size[::-1])
    met = np.isfinite(truth)
    assert 0.2 < met.mean() < 0.95
    assert (np.isfinite(image.depth) == met).mean() > 0.9995
    both = met & np.isfinite(image.depth)
    assert np.quantile(np.abs(image.depth[both] / truth[both] - 1), 0.999) < 4e-6


def test_the_projection_is_that_of_the_rays(renderer):
    """A triangle's edge lies where the camera's rays say, to a hundredth of a pixel: coverage of thin slices adds up to it."""
    camera = al.Camera.perspective(eye=(1, -7, 2), target=(0.3, 0, 0.2), fov_deg=40)
    size = (256, 192)
    corners = np.array([[-1.5, 0.3, -1.2], [1.7, -0.6, -0.8], [0.2, 0.9, 1.6]])
    image = renderer.render(al.Scene(meshes=[Mesh(corners, [[0, 1, 2]], lit=False)], camera=camera), size)
    right, up, forward = camera.basis()
    seen = np.stack([(corners - np.array(camera.eye)) @ axis for axis in (right, up, forward)], axis=1)
    tangent = np.tan(np.radians(20))
    on_image = seen[:, :2] / seen[:, 2:] / tangent * size[1] / 2
    (ax, ay), (bx, by), (cx, cy) = on_image
    area = abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)) / 2
    assert abs(image.rgba[..., 3].sum() / area - 1) < 0.004


def test_a_mesh_alone_needs_no_volume(any_renderer):
    scene = al.Scene(meshes=[ball(9.0, colors=None, color="red", lit=False)], camera="iso", background=None)
    image = any_renderer.render(scene, (64, 64))
    assert image.rgba[32, 32].tolist() == pytest.approx([1, 0, 0, 1])
    assert image.rgba[0, 0].tolist() == [0, 0, 0, 0]
    assert np.isinf(image.depth[0, 0])


def test_before_an_environment(renderer):
    sky = al.Environment.sky()
    layer = with_meshes(*SCENES["both kinds"]).layers[0]
    scene = dataclasses.replace(with_meshes(*SCENES["both kinds"]), layers=(layer,), background=sky)
    compare(renderer, scene, strays=0.02)
    alone = al.Scene(meshes=SCENES["opaque within"], camera=scene.camera, background=sky)
    assert renderer.render(alone, SIZE).rgba[..., 3].min() == 1


def test_an_eye_inside_of_a_mesh_sees_its_inner_side(any_renderer):
    eye = tuple(MIDDLE)
    camera = al.Camera.perspective(eye=eye, target=tuple(MIDDLE + np.array([1, 0.2, 0])), fov_deg=120)
    image = any_renderer.render(al.Scene(meshes=[ball(9.0)], camera=camera, background=None), SIZE)
    assert image.rgba[..., 3].min() == 1
    assert np.isfinite(image.depth).all()


@pytest.mark.parametrize("opacity", [1.0, 0.4])
def test_two_halves_are_the_whole(renderer, opacity):
    vertices, faces = sphere(12.0)
    vertices = vertices + MIDDLE
    normals_alike = {"smooth": False, "opacity": opacity}
    whole = renderer.render(with_meshes(Mesh(vertices, faces, **normals_alike)), SIZE)
    half = len(faces) // 2
    parts = [Mesh(vertices, faces[:half], **normals_alike), Mesh(vertices, faces[half:], **normals_alike)]
    image = renderer.render(with_meshes(*parts), SIZE)
    assert np.abs(image.rgba - whole.rgba).max() < 1e-6
    np.testing.assert_allclose(image.depth, whole.depth, rtol=1e-6)


def test_moved_together_nothing_changes(renderer):
    scene = with_meshes(*SCENES["both kinds"])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation((0, 1, 3), 0.8), (3, -2, 5)
    volume = al.Volume(blobs().array, world_from_index=matrix @ blobs().world_from_index)
    camera = scene.camera

    def moved(point):
        return tuple(matrix[:3, :3] @ np.array(point) + matrix[:3, 3])

    there = dataclasses.replace(
        scene,
        layers=(dataclasses.replace(scene.layers[0], volume=volume),),
        meshes=tuple(mesh.moved(matrix) for mesh in scene.meshes),
        camera=dataclasses.replace(
            camera, eye=moved(camera.eye), target=moved(camera.target), up=tuple(matrix[:3, :3] @ np.array(camera.up))
        ),
        lights=(al.Light.head(),),
    )
    here = dataclasses.replace(scene, lights=(al.Light.head(),))
    error = np.abs(renderer.render(there, SIZE).rgba - renderer.render(here, SIZE).rgba).max(axis=-1)
    assert np.quantile(error, 0.99) < 2e-3


def test_far_from_the_origin(renderer):
    """A survey in metres: 32 bits hold neither its vertices nor its eye."""
    away = np.array([4.3e6, -6.1e5, 2.2e5])
    vertices, faces = sphere(9.0)
    matrix = blobs().world_from_index.copy()
    matrix[:3, 3] += away
    volume = al.Volume(blobs().array, world_from_index=matrix)
    scene = with_meshes(Mesh(vertices + MIDDLE + away, faces, opacity=0.5), volume=volume)
    compare(renderer, scene)


def test_more_layers_than_are_kept_are_told(renderer):
    shells = [ball(r, opacity=0.2) for r in (4.0, 7.0, 10.0)]
    scene = al.Scene(meshes=shells, camera=cameras(blobs())["perspective"], background=None)
    told = renderer.render(scene, SIZE).stats["meshes"]
    assert told["layers"] == 4
    assert told["pixels_with_more_layers"] > 0
    assert len(told["layer_pixels"]) == 4
    all_of_them = renderer.render(scene, SIZE, driver=al.driver.March(mesh_layers=6)).stats["meshes"]
    assert all_of_them["pixels_with_more_layers"] == 0
    found = all_of_them["layer_pixels"]
    assert found == sorted(found, reverse=True)
    assert found[5] > 0
    beside = dataclasses.replace(scene, meshes=[ball(1.0), *shells])
    assert 0 < renderer.render(beside, SIZE).stats["meshes"]["pixels_with_more_layers"] <= told["pixels_with_more_layers"]


def test_four_layers_are_the_nearest_four(renderer):
    shells = [ball(r, opacity=0.3) for r in (4.0, 7.0, 10.0)]
    scene = with_meshes(*shells)
    image, truth = renderer.render(scene, SIZE), reference.render(scene, SIZE, mesh_layers=4)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    assert error[: int(0.985 * error.size)].max() <= 1 / 255


@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
def test_meshes_beside_the_volume_are_seen(renderer, camera):
    # Pixels in which nothing is are left out: neither blocks that hold something nor meshes.
    volume = blobs()
    right, up, _ = cameras(volume)[camera].basis()
    reach = 0.5 * max(np.ptp(volume.corners_world(), axis=0))
    beside = [
        ball(3.0, MIDDLE + reach * (a * right + b * up), opacity=o) for a, b, o in ((-1, 0.6, 1), (1, 0, 0.5), (0.2, -1, 0.5))
    ]
    scene = with_meshes(*beside, camera=camera)
    image, plain = renderer.render(scene, SIZE), renderer.render(scene, SIZE, skip="none")
    assert np.abs(image.rgba - plain.rgba).max() <= 1 / 255
    assert image.stats["meshes"]["layer_pixels"] == plain.stats["meshes"]["layer_pixels"]
    assert image.stats["samples"] < plain.stats["samples"]
    compare(renderer, scene)


def test_images_larger_than_a_texture(renderer, monkeypatch):
    from airlight.rendering import rasterised

    scene = with_meshes(*SCENES["both kinds"])
    whole = renderer.render(scene, SIZE)
    monkeypatch.setattr(rasterised, "MOST_TILE", 17)
    parts = renderer.render(scene, SIZE)
    error = np.abs(parts.rgba - whole.rgba).max(axis=-1)
    assert (error > 1e-4).mean() < 0.01
    assert parts.stats["meshes"]["layer_pixels"] == pytest.approx(whole.stats["meshes"]["layer_pixels"], rel=0.02)


def test_a_moved_mesh_is_not_uploaded_again(renderer):
    from airlight.gpu import raster

    mesh = ball(9.0)
    renderer.render(with_meshes(mesh), SIZE)
    uploads = []
    before = raster.upload_triangles
    raster.upload_triangles = lambda *a: uploads.append(1) or before(*a)
    try:
        turned = np.eye(4)
        turned[:3, 3] = (1, 2, 3)
        renderer.render(with_meshes(dataclasses.replace(mesh.moved(turned), opacity=0.5, color="red")), SIZE)
        assert not uploads
        renderer.render(with_meshes(ball(9.0)), SIZE)
        assert uploads
    finally:
        raster.upload_triangles = before


def test_nothing_is_drawn_behind_the_eye(any_renderer):
    for camera in ("inside", "cut"):
        chosen = cameras(blobs())[camera]
        behind = np.array(chosen.eye) - 30 * chosen.basis()[2]
        scene = al.Scene(
            meshes=[ball(4.0, behind), Points([behind]), Lines([[behind, behind + 1]])], camera=chosen, background=None
        )
        assert not any_renderer.render(scene, SIZE).rgba.any()


def test_a_line_that_passes_the_eye(any_renderer):
    camera = al.Camera.perspective(eye=(0, -2, 0.1), target=(0, 0, 0), fov_deg=60)
    scene = al.Scene(meshes=[Lines([[(0.02, -9, 0), (0.03, 9, 0)]], width_px=3)], camera=camera, background=None)
    compare(any_renderer, scene_with_layer(scene), strays=0.01)


def scene_with_layer(scene: al.Scene) -> al.Scene:
    """The reference wants a layer: one in which there is nothing to be seen."""
    volume = al.Volume(np.zeros((2, 2, 2), dtype=np.float32), origin=(-0.5, -0.5, -0.5))
    empty = al.Layer(volume, al.TransferFunction([(0, "black", 0), (1, "black", 0)]))
    return dataclasses.replace(scene, layers=(empty,))


def test_refused(renderer):
    with pytest.raises(StageError, match="semi-transparent mesh has no place"):
        renderer.render(with_meshes(ball(5.0, opacity=0.5), integrate="mip"), SIZE)
    with pytest.raises(StageError, match="keeps surfaces of volumes"):
        renderer.render(with_meshes(ball(5.0), integrate=al.integrate.FirstHit(iso=70.0)), SIZE, keep_hits=True)
    with pytest.raises(DataError, match="holds a Volume"):
        al.Scene(blobs(), meshes=[blobs()])


def test_a_mesh_too_large_for_the_device(core_device, monkeypatch):
    from airlight.gpu import raster

    limits = {**core_device.limits, "max-storage-buffer-binding-size": 1000}
    monkeypatch.setattr(type(core_device), "limits", property(lambda self: limits))
    vertices, faces = sphere(1.0)
    attributes = np.zeros((len(vertices), 2, 4), dtype=np.float32)
    with pytest.raises(LimitError, match="split it"):
        raster.upload_triangles(core_device, faces.astype(np.uint32), attributes, "mesh")


@pytest.mark.parametrize("capped", [False, True])
def test_with_clips(renderer, capped):
    """Pieces that clips keep and pieces between meshes go together; clips cut no meshes."""
    normal = (0.6, -0.7, 0.4)
    clips = [
        al.Clip.plane(normal=tuple(-n for n in normal), point=tuple(MIDDLE + np.array([2, 1, 0])), capped=capped),
        al.Clip.sphere(center=tuple(MIDDLE - np.array([4, 2, 0])), radius=6, keep="outside", capped=capped),
    ]
    compare(renderer, dataclasses.replace(with_meshes(*SCENES["interleaved"]), clips=tuple(clips)), strays=0.02)
