"""Meshes, lines and points as values: what they refuse, how they are read, saved and typed."""

from __future__ import annotations

import dataclasses
import gc
import sys
import weakref

import numpy as np
import pytest

import airlight as al
from airlight.app import cli
from airlight.errors import DataError, FileError, MissingExtraError, ValueRangeError
from airlight.geometry.marks import mesh_of

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def tetrahedron(**options) -> al.Mesh:
    return al.Mesh(CORNERS, FACES, **options)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.where(CORNERS == 1, np.nan, CORNERS), FACES, "3 points that are not finite, the first is 1"),
        (CORNERS[:, :2], FACES, r"has the shape \(4, 2\)"),
        (CORNERS, np.where(FACES == 3, 4, FACES), "names vertex 4: there are 4"),
        (CORNERS, FACES - 1, "names vertex -1"),
        (CORNERS, np.zeros((0, 3), dtype=int), "is empty"),
        (CORNERS, FACES.astype(float), "give whole numbers"),
        (CORNERS, FACES[:, :2], "give whole numbers"),
        (CORNERS, None, "is missing"),
        ("mesh.stl", None, "Mesh.open"),
        ([["a", "b", "c"]], FACES, "no array of numbers"),
        (CORNERS + 1j, FACES, "no array of numbers"),
        (CORNERS, [[0, 1, 2], [0, 1]], "mesh.faces is a list that is no array of numbers"),
    ],
)
def test_what_is_no_mesh(vertices, faces, message):
    with pytest.raises(DataError, match=message):
        al.Mesh(vertices, faces)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"color": (2, -1, 0)}, "mesh.color"),
        ({"opacity": 1.5}, r"mesh.opacity is 1.5, must lie in \[0, 1\]"),
        ({"smooth": "yes"}, "mesh.smooth"),
        ({"colors": np.ones((3, 3))}, "mesh.colors has the shape"),
        ({"colors": np.full((4, 4), 1.5)}, "opacities above 1"),
        ({"world_from_mesh": np.eye(3)}, r"mesh.world_from_mesh has shape \(3, 3\), must be \(4, 4\)"),
        ({"world_from_mesh": [[1, 2], [3]]}, r"mesh.world_from_mesh is .*, must be numbers \(4, 4\)"),
        ({"world_from_mesh": np.diag([1, 1, 0, 1])}, "is singular"),
    ],
)
def test_what_is_no_look_of_a_mesh(options, message):
    with pytest.raises((DataError, ValueRangeError), match=message):
        tetrahedron(**options)


def test_values():
    mesh = tetrahedron(color="red", opacity=0.5)
    assert mesh == tetrahedron(color="red", opacity=0.5)
    assert hash(mesh) == hash(tetrahedron(color="red", opacity=0.5))
    assert mesh != tetrahedron(color="red")
    assert mesh != dataclasses.replace(mesh, colors=np.ones((4, 3)))
    assert not mesh.vertices.flags.writeable
    assert dataclasses.replace(mesh, opacity=1.0).vertices is mesh.vertices
    assert tetrahedron().opaque
    assert not mesh.opaque
    assert not tetrahedron(colors=np.full((4, 4), 0.5)).opaque


def test_bytes_are_srgb():
    mesh = tetrahedron(colors=np.full((4, 3), 128, dtype=np.uint8))
    assert mesh.colors[0] == pytest.approx([0.21586, 0.21586, 0.21586, 1.0], abs=1e-5)


def test_normals_are_means_by_area():
    expected = -np.ones(3) / np.sqrt(3)
    assert tetrahedron().normals[0] == pytest.approx(expected)
    assert np.linalg.norm(tetrahedron().normals, axis=1) == pytest.approx(np.ones(4))
    loose = al.Mesh(np.concatenate([CORNERS, [[9, 9, 9.0]]]), FACES)
    assert loose.normals[4].tolist() == [0, 0, 0]


def test_moved():
    turn = np.array([[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    moved = tetrahedron().moved(turn).moved(turn)
    assert moved.corners_world.min(axis=0) == pytest.approx([4, 4, 0])


def test_lines_and_points():
    row = al.Lines(CORNERS)
    assert row.points.shape == (3, 2, 3)
    assert row == al.Lines(np.stack([CORNERS[:-1], CORNERS[1:]], axis=1))
    assert row != al.Lines(CORNERS, width_px=3)
    assert al.Points(CORNERS) == al.Points(CORNERS.tolist())
    box = al.Lines.box(al.Volume(np.zeros((3, 4, 5)), spacing=(2, 1, 1)))
    lengths = np.sort(np.linalg.norm(np.diff(box.points, axis=1)[:, 0], axis=1))
    assert lengths.tolist() == [2, 2, 2, 2, 3, 3, 3, 3, 8, 8, 8, 8]
    axes = al.Lines.axes(origin=(1, 2, 3), length=4)
    assert axes.points[:, 1].tolist() == [[5, 2, 3], [1, 6, 3], [1, 2, 7]]


def test_marks_keep_the_triangles_of_their_last_camera_alone():
    spots = al.Points(CORNERS)
    cameras = [al.Camera.perspective(eye=(0, -far, 0), target=(0, 0, 0)) for far in (5, 6, 7)]
    made = [weakref.ref(mesh_of(spots, camera, (32, 32))) for camera in cameras]
    gc.collect()
    assert [reference() is None for reference in made] == [True, True, False]
    assert mesh_of(spots, cameras[-1], (32, 32)) is made[-1]()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: al.Lines(CORNERS, width_px=1, width_world=1), "exclude each other"),
        (lambda: al.Lines(CORNERS, width_px=0), "must be above 0"),
        (lambda: al.Lines(CORNERS[:1]), "in a row"),
        (lambda: al.Lines([[0, 1, 2], [0, 1]]), "lines.points is a list that is no array of numbers"),
        (lambda: tetrahedron().moved("away"), "mesh.moved is 'away'"),
        (lambda: al.Lines(np.full((2, 3), np.inf)), "not finite"),
        (lambda: al.Points(CORNERS, colors=np.ones((2, 3))), "points.colors"),
        (lambda: al.Points(np.zeros((0, 3))), "has the shape"),
        (lambda: al.Scene(meshes=["box"]), "scene.meshes holds a str"),
        (lambda: al.Scene(meshes=()), "needs either a volume or layers"),
    ],
)
def test_refused(make, message):
    with pytest.raises((DataError, ValueRangeError), match=message):
        make()


# -- files


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_files(tmp_path, ending):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / f"body.{ending}"
    trimesh.Trimesh(CORNERS, FACES, process=False).export(path)
    mesh = al.Mesh.open(path, color="gold", opacity=0.5)
    assert len(mesh.faces) == 4
    assert len(mesh.vertices) == 4  # of an STL, too, whose triangles share nothing
    assert np.sort(mesh.vertices, axis=0) == pytest.approx(np.sort(CORNERS, axis=0))
    assert mesh.opacity == 0.5
    assert mesh == al.Mesh.open(path, color="gold", opacity=0.5)


def test_colours_of_files_are_srgb(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "body.ply"
    colours = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [128, 128, 128, 128]], dtype=np.uint8)
    body = trimesh.Trimesh(CORNERS, FACES, vertex_colors=colours, process=False)
    body.export(path)
    assert al.Mesh.open(path).colors == pytest.approx(al.Mesh(body).colors)
    assert al.Mesh.open(path).colors[3] == pytest.approx([0.21586] * 3 + [128 / 255], abs=1e-5)


def test_scenes_of_several_parts_become_one(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "parts.glb"
    part = trimesh.Trimesh(CORNERS, FACES, process=False)
    there = np.eye(4)
    there[:3, 3] = (5, 0, 0)
    scene = trimesh.Scene()
    scene.add_geometry(part)
    scene.add_geometry(part, transform=there)
    scene.export(path)
    mesh = al.Mesh.open(path)
    assert len(mesh.faces) == 8
    assert mesh.vertices[:, 0].max() == pytest.approx(6)


def test_files_that_are_none(tmp_path, monkeypatch):
    pytest.importorskip("trimesh")
    with pytest.raises(FileError, match=r"is no mesh by its ending '\.vtk'"):
        al.Mesh.open(tmp_path / "a.vtk")
    with pytest.raises(FileError, match="cannot be read"):
        al.Mesh.open(tmp_path / "a.stl")
    for ending in ("stl", "obj", "ply", "glb"):
        (tmp_path / f"bad.{ending}").write_bytes(b"\x07" * 333)
        with pytest.raises(FileError, match=r"damaged|holds no faces"):
            al.Mesh.open(tmp_path / f"bad.{ending}")
    (tmp_path / "nan.obj").write_text("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(DataError, match=r"nan.obj: mesh.vertices has 1 points that are not finite"):
        al.Mesh.open(tmp_path / "nan.obj")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingExtraError, match=r"airlight\[mesh\]"):
        al.Mesh.open(tmp_path / "bad.stl")


# -- scenes in files, and the command line


def saved(folder) -> al.Mesh:
    trimesh = pytest.importorskip("trimesh")
    trimesh.Trimesh(10 * CORNERS, FACES, process=False).export(folder / "body.ply")
    return al.Mesh.open(folder / "body.ply", opacity=0.25)


def test_scene_files(tmp_path):
    shift = np.eye(4)
    shift[0, 3] = 2.5
    mesh = dataclasses.replace(saved(tmp_path), color=(0.5, 0.25, 0.125), world_from_mesh=shift, smooth=False)
    marks = al.Lines.axes(length=3), al.Points(CORNERS, color="red", width_world=0.5, opacity=0.5)
    scene = al.Scene(meshes=[mesh, *marks], camera="iso")
    al.save_scene(scene, tmp_path / "scene.toml")
    assert 'file = "body.ply"' in (tmp_path / "scene.toml").read_text()
    assert al.load_scene(tmp_path / "scene.toml")[0] == scene


def test_scene_files_name_what_is_in_files(tmp_path):
    with pytest.raises(DataError, match=r"meshes\[0\] came from no file"):
        al.save_scene(al.Scene(meshes=[tetrahedron()]), tmp_path / "scene.toml")
    changed = dataclasses.replace(saved(tmp_path), colors=np.ones((4, 3)))
    with pytest.raises(DataError, match="has changed since it was read"):
        al.save_scene(al.Scene(meshes=[changed]), tmp_path / "scene.toml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('file = "body.ply"\nopacty = 1', "opacty is unknown"),
        ("opacity = 1", "file is missing"),
        ('kind = "cone"', "must be one of mesh, lines, points"),
        ('kind = "lines"', "points is missing"),
        ('file = "../body.ply"', "lies outside"),
    ],
)
def test_scene_files_with_slips(tmp_path, text, message):
    saved(tmp_path)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "scene.toml").write_text(f"[[meshes]]\n{text}\n")
    with pytest.raises((ValueRangeError, FileError), match=message):
        al.load_scene(tmp_path / "in" / "scene.toml", untrusted=True)


def test_the_command_line(tmp_path):
    saved(tmp_path)
    volume = tmp_path / "box.nrrd"
    al.save(al.Volume(np.random.default_rng(0).random((8, 8, 8), dtype=np.float32)), volume)
    out = tmp_path / "out.npy"
    body = str(tmp_path / "body.ply")
    plain = (
        str(volume),
        "-o",
        str(out),
        "--size",
        "32",
        "--camera",
        "iso",
        "--background",
        "none",
        "--tf",
        "0:black:0 2:white:0",
    )
    scene = ("--save-scene", str(tmp_path / "s.toml"))
    assert cli.main(["render", *plain, "--mesh", f"{body}:color=red,lit=false", "--box", "lime", *scene]) in (None, 0)
    rgba = np.load(out)
    assert (rgba[..., 0] > 0.9).any()
    assert (rgba[..., 1] > 0.9).any()
    assert len(al.load_scene(tmp_path / "s.toml")[0].meshes) == 2


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("{body}:opacity=2", "--mesh.opacity is 2"),
        ("{body}:colour=red", "--mesh.colour is unknown"),
        ("{body}:world_from_mesh=[1,2]", "--mesh.world_from_mesh"),
        ("nowhere.stl", "nowhere.stl cannot be read"),
    ],
)
def test_slips_on_the_command_line(tmp_path, option, message):
    from airlight.app.meshes import open_meshes, parse_mesh

    saved(tmp_path)
    text = option.format(body=tmp_path / "body.ply")
    with pytest.raises((ValueRangeError, FileError), match=message.replace(".", r"\.").replace("[", r"\[")):
        open_meshes([parse_mesh(text)])
