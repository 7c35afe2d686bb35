"""Clips as values: what they may be, what they keep, and their way through scene files and the command line."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import airlight as al
from airlight.app.clips import cropped, parse_clips, parse_crop, with_clips
from airlight.errors import DataError, ValueRangeError

numbers = st.floats(-1e3, 1e3)
vectors = st.tuples(numbers, numbers, numbers)
common = {
    "keep": st.sampled_from(["inside", "outside"]),
    "capped": st.booleans(),
    "cuts": st.sampled_from(["volume", "front", "back"]),
}
directions = vectors.filter(lambda v: np.linalg.norm(v) > 1e-3)
boxes = st.builds(
    lambda low, sides, moved, **rest: al.Clip.box(
        low=low,
        high=tuple(np.add(low, sides)),
        world_from_box=[*np.eye(4)[:2], [0.5, 0, 2, 7], [0, 0, 0, 1]] if moved else None,
        **rest,
    ),
    vectors,
    st.tuples(*[st.floats(0.1, 1e3)] * 3),
    st.booleans(),
    **common,
)
clips = st.one_of(
    st.builds(lambda point, normal, **rest: al.Clip.plane(point=point, normal=normal, **rest), vectors, directions, **common),
    st.builds(lambda c, r, **rest: al.Clip.sphere(center=c, radius=r, **rest), vectors, st.floats(1e-3, 1e3), **common),
    boxes,
)


@given(clips)
def test_plain_data_and_back(clip):
    assert al.Clip.from_dict(clip.to_dict()) == clip
    assert hash(al.Clip.from_dict(clip.to_dict())) == hash(clip)


@given(made=st.lists(clips, max_size=3), own=st.lists(clips, max_size=2))
def test_scene_files(tmp_path_factory, made, own):
    folder = tmp_path_factory.mktemp("clips")
    layer = al.Layer(al.Volume(np.zeros((2, 2, 2), np.float32)), clips=own)
    al.save_scene(al.Scene(layers=[layer], clips=made), folder / "scene.toml", embed=folder / "volume.nrrd")
    back, _ = al.load_scene(folder / "scene.toml")
    assert back.clips == tuple(made)
    assert back.layers[0].clips == tuple(own)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: al.Clip.plane(point=(0, 0, 0), normal=(0, 0, 0)), r"clip.normal is \(0, 0, 0\), must be a finite direction"),
        (lambda: al.Clip.plane(point=(0, np.nan, 0), normal=(0, 0, 1)), r"clip.point\[1\] is nan"),
        (lambda: al.Clip.sphere(center=(0, 0, 0), radius=-2), "clip.radius is -2, must be above 0"),
        (lambda: al.Clip.box(low=(0, 0, 0), high=(1, 0, 1)), "high must be above low"),
        (
            lambda: al.Clip.box(low=(0, 0, 0), high=(1, 1, 1), world_from_box=np.zeros((4, 4))),
            "world_from_box must be .*last row",
        ),
        (
            lambda: al.Clip.box(low=(0, 0, 0), high=(1, 1, 1), world_from_box=np.diag([1, 1, 0])),
            "clip.world_from_box is singular",
        ),
        (lambda: al.Clip.box(low=(0, 0, 0), high=(1, 1, 1), world_from_box="turn"), "clip.world_from_box is 'turn'"),
        (lambda: al.Clip.plane(point=(0, 0, 0), normal=(0, 0, 1), keep="front"), "clip.keep is 'front', must be one of inside"),
        (lambda: al.Clip.sphere(center=(0, 0, 0), radius=2, capped="yes"), "clip.capped is 'yes', must be true or false"),
        (lambda: al.Clip.sphere(center=(0, 0, 0), radius=2, cuts="side"), "clip.cuts is 'side', must be one of volume, front"),
        (lambda: al.Clip.from_dict({"kind": "cone"}), "clip.kind is 'cone', must be one of plane, box, sphere, mesh"),
        (lambda: al.Clip.from_dict({"kind": "mesh"}), "clip.file is missing: name the file of a closed mesh"),
        (lambda: al.Clip.from_dict({"kind": "mesh", "file": "a.stl", "color": "red"}), "clip.color is no parameter of mesh"),
        (lambda: al.Clip.from_dict({"kind": "sphere", "radius": 2}), "clip.center is missing"),
        (lambda: al.Clip.from_dict({"kind": "sphere", "point": 2}), "clip.point is no parameter of sphere"),
    ],
)
def test_what_a_clip_may_not_be(make, message):
    with pytest.raises(ValueRangeError, match=message):
        make()


def test_lists_hold_clips():
    volume = al.Volume(np.zeros((2, 2, 2)))
    with pytest.raises(DataError, match=r"scene.clips holds 'plane'"):
        al.Scene(volume, clips=["plane"])
    with pytest.raises(DataError, match=r"layer.clips holds Clip"):
        al.Layer(volume, clips=[al.Clip()])
    with pytest.raises(ValueRangeError, match=r"scene.clips is 3, must be a list"):
        al.Scene(volume, clips=3)


def test_a_scene_file_names_line_and_key(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("[[clips]]\nkind='sphere'\ncenter=[0,0,0]\nradius=0\n[[layers]]\nvolume='a.nrrd'")
    with pytest.raises(ValueRangeError, match=r"scene.toml:4: clips\[0\].radius is 0, must be above 0"):
        al.load_scene(path)


PYRAMID = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
SIDES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def test_what_a_mesh_that_clips_may_not_be():
    for make, message in (
        (lambda: al.Clip.mesh(al.Mesh(PYRAMID, SIDES[1:])), "clip.mesh has 3 edges without a neighbour .* it is open"),
        (lambda: al.Clip.mesh(al.Mesh(PYRAMID, [SIDES[0][::-1], *SIDES[1:]])), "some faces are turned over"),
        (lambda: al.Clip.mesh(al.Mesh(PYRAMID[:3], [[0, 1, 2], [0, 2, 1]])), "clip.mesh encloses nothing"),
        (lambda: al.Clip.mesh(al.Mesh(np.where(PYRAMID == 1, np.nan, 0), SIDES)), "3 points that are not finite, the first"),
        (lambda: al.Clip.mesh("skull.stl"), "use airlight.Mesh.open"),
    ):
        with pytest.raises(DataError, match=message):
            make()
    assert al.Clip.mesh(al.Mesh(PYRAMID, SIDES)).closed.outward == 1
    assert al.Clip.mesh(al.Mesh(PYRAMID, SIDES[:, ::-1])).closed.outward == -1
    assert al.Clip.mesh(al.Mesh(PYRAMID, SIDES, world_from_mesh=np.diag([-1, 1, 1, 1]))).closed.outward == -1


def test_a_mesh_that_clips_is_named_by_its_file(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    trimesh.Trimesh(PYRAMID, SIDES).export(tmp_path / "pyramid.stl")
    trimesh.Trimesh(PYRAMID, SIDES[1:]).export(tmp_path / "open.stl")
    shift = np.eye(4)
    shift[:3, 3] = 2
    mesh = al.Mesh.open(tmp_path / "pyramid.stl", world_from_mesh=shift)
    clip = al.Clip.mesh(mesh, keep="outside", capped=True, cuts="back")
    layer = al.Layer(al.Volume(np.zeros((2, 2, 2), np.float32)), clips=[al.Clip.mesh(mesh)])
    path = tmp_path / "scene.toml"
    al.save_scene(al.Scene(layers=[layer], clips=[clip]), path, embed=tmp_path / "volume.nrrd")
    assert 'file = "pyramid.stl"' in path.read_text()
    back, _ = al.load_scene(path)
    assert back.clips == (clip,)
    assert back.layers[0].clips == layer.clips
    with pytest.raises(DataError, match=r"clip\.mesh came from no file"):
        al.Clip.mesh(al.Mesh(PYRAMID, SIDES)).to_dict()
    (data,) = parse_clips([f"mesh:file={tmp_path}/pyramid.stl,keep=outside,world_from_mesh={shift.ravel().tolist()}"])
    assert al.Clip.from_dict(data) == al.Clip.mesh(mesh, keep="outside")
    with pytest.raises(DataError, match=r"--clip.mesh has 3 edges without"):
        parse_clips([f"mesh:file={tmp_path}/open.stl"])
    path.write_text("[[clips]]\nkind='mesh'\nfile='../pyramid.stl'\n[[layers]]\nvolume='a.nrrd'")
    with pytest.raises(al.FileError, match="outside of the folder of an untrusted scene"):
        al.load_scene(path, untrusted=True)


def test_a_wedge_is_a_box_that_is_sheared():
    wedge = al.Clip.box(low=(0, 0, 0), high=(9, 9, 9), world_from_box=[[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])
    unit = wedge.unit_from_world @ np.array([5 + 0.5 * 8, 8, 1, 1])
    assert unit == pytest.approx([5 / 4.5 - 1, 8 / 4.5 - 1, 1 / 4.5 - 1])


# -- the command line


def test_options_are_checked_before_a_file_is_opened():
    plane, sphere = parse_clips(["plane:normal=[0,-1,0],capped=true", "sphere:center=[1,2,3],radius=5,keep=outside"])
    scene = al.Scene(al.Volume(np.zeros((5, 5, 5)), origin=(10, 0, 0)))
    assert with_clips(scene, [plane, sphere]).clips == (
        al.Clip.plane(point=(12, 2, 2), normal=(0, -1, 0), capped=True),
        al.Clip.sphere(center=(1, 2, 3), radius=5, keep="outside"),
    )
    old = dataclasses.replace(scene, clips=[al.Clip.sphere(center=(0, 0, 0), radius=1)])
    assert with_clips(old, []).clips == old.clips
    for text, message in (
        ("plane:normal=[0,0,0]", "--clip.normal is"),
        ("box:low=[0,0,0]", "--clip.high is missing"),
        ("cone", "--clip.kind is 'cone'"),
        ("sphere:radius", "--clip has 'radius'"),
        ("box:low=[0,0,0],high=[1,1,1],world_from_box=[[1,0,0],[0,1,0]]", "--clip.world_from_box is"),
    ):
        with pytest.raises(ValueRangeError, match=message):
            parse_clips([text])


def test_a_matrix_can_be_typed():
    (data,) = parse_clips(["box:low=[0,0,0],high=[1,2,3],world_from_box=[[1,0.5,0],[0,1,0],[0,0,1]],keep=outside"])
    wedge = al.Clip.box(low=(0, 0, 0), high=(1, 2, 3), world_from_box=[[1, 0.5, 0], [0, 1, 0], [0, 0, 1]], keep="outside")
    assert al.Clip.from_dict(data) == wedge


def test_crop_counts_voxels():
    layer = al.Layer(al.Volume(np.zeros((20, 30, 40)), spacing=(1, 2, 3)))
    (box,) = cropped(layer, parse_crop("10:20,:,5:")).clips
    assert (box.low, box.high[0]) == ((9.5, -0.5, 4.5), 19.5)
    assert np.array_equal(box.matrix, layer.volume.world_from_index)
    for text in ("1:2,3:4", "5:5,:,:", "a:b,:,:", "-3:4,:,:"):
        with pytest.raises(ValueRangeError, match="--crop"):
            parse_crop(text)
