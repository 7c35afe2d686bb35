"""What must hold whatever the scene."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_scenes import along_z, blob, ramp_z, rotation, scene

from airlight import reference
from airlight.scene import Camera, Light
from airlight.stages.integrate import EmissionAbsorption, FirstHit
from airlight.transfer import TransferFunction
from airlight.volume import Volume

FULL = EmissionAbsorption(opaque_at=1.0)
TF = TransferFunction([(0.05, (0.1, 0.2, 0.9), 0), (0.3, (1, 0.6, 0.2), 1.5), (0.5, (0, 1, 0), 0.2), (1, (1, 1, 1), 4)])
CAMERA = Camera.perspective(eye=(1.4, -4, 1.1), target=(0.1, 0, -0.1), fov_deg=32)
SIZE = (12, 9)
INTEGRATES = ["emission_absorption", "mip", "minip", "mean", FirstHit(iso=0.4)]


def error(a, b):
    return float(np.abs(a.rgba - b.rgba).max())


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated"])
def test_halving_the_step_converges(transfer):
    look = scene(blob(), TF, CAMERA, transfer=transfer, integrate=FULL)
    truth = reference.converged(look, SIZE, step=1 / 64)
    errors = [error(reference.render(look, SIZE, step=s), truth) for s in (1, 1 / 2, 1 / 4, 1 / 8, 1 / 16)]
    # Second order: sixteen times finer is more than a hundred times nearer.
    assert errors[-1] < errors[0] / 100
    assert errors[-1] < 2e-4
    assert all(fine < coarse for coarse, fine in pairwise(errors))


def test_lit_images_converge():
    look = scene(blob(), TF, CAMERA, shade="blinn_phong", integrate=FULL)
    truth = reference.converged(look, SIZE, step=1 / 64)
    errors = [error(reference.render(look, SIZE, step=s), truth) for s in (1, 1 / 4, 1 / 16)]
    assert errors[2] < errors[0] / 8
    assert errors[2] < 5e-3


def test_all_transfer_stages_have_one_limit():
    pair = [scene(blob(), TF, CAMERA, transfer=t) for t in ("postclassified", "preintegrated")]
    assert error(*(reference.converged(s, SIZE, step=1 / 4) for s in pair)) == 0
    assert error(*(reference.render(s, SIZE, step=1 / 32) for s in pair)) < 1e-4


def test_preintegration_is_better_at_the_same_step():
    shell = TransferFunction([(0.45, (1, 1, 1), 0), (0.5, (1, 0, 0), 9), (0.55, (0, 0, 1), 0)])
    truth = reference.converged(scene(blob(), shell, CAMERA), SIZE, step=1 / 32)
    post, pre = (
        error(reference.render(scene(blob(), shell, CAMERA, transfer=t, integrate=FULL), SIZE), truth)
        for t in ("postclassified", "preintegrated")
    )
    assert pre < post / 4


@pytest.mark.parametrize("integrate", INTEGRATES)
@settings(max_examples=5, deadline=None)
@given(
    axis=st.tuples(*(st.integers(-3, 3),) * 3).filter(any),
    angle=st.floats(0.1, 6),
    shift=st.tuples(*(st.floats(-9, 9, width=32),) * 3),
)
def test_moving_volume_and_camera_together_changes_nothing(integrate, axis, angle, shift):
    turn, shift = rotation(axis, angle), np.array(shift)
    volume = blob()
    look = scene(volume, TF, CAMERA, shade="blinn_phong", integrate=integrate)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, shift
    moved = Volume(volume.array, world_from_index=matrix @ volume.world_from_index)
    camera = Camera.perspective(
        eye=tuple(turn @ CAMERA.eye + shift),
        target=tuple(turn @ CAMERA.target + shift),
        up=tuple(turn @ CAMERA.up),
        fov_deg=CAMERA.fov_deg,
    )
    a = reference.render(look, SIZE)
    b = reference.render(scene(moved, TF, camera, shade="blinn_phong", integrate=integrate), SIZE)
    assert error(a, b) < 1e-8
    far = np.isinf(a.depth)
    assert (far == np.isinf(b.depth)).all()
    assert a.depth[~far] == pytest.approx(b.depth[~far], abs=1e-8)


def test_another_unit_of_length_changes_nothing():
    # All lengths times 25, extinctions and thresholds by 1/25: metres or inches, the picture is the same.
    volume, k = blob(), 25.0
    thin = TransferFunction([(v, c, e / k) for v, c, e in TF.points])
    affine = volume.world_from_index.copy()
    affine[:3] *= k
    camera = replace(CAMERA, eye=tuple(k * c for c in CAMERA.eye), target=tuple(k * c for c in CAMERA.target))
    a = reference.render(scene(volume, TF, CAMERA, shade="blinn_phong"), SIZE)
    b = reference.render(scene(Volume(volume.array, world_from_index=affine), thin, camera, shade="blinn_phong"), SIZE)
    assert error(a, b) < 1e-10
    near = np.isfinite(a.depth)
    assert b.depth[near] == pytest.approx(k * a.depth[near])


@pytest.mark.parametrize("integrate", ["emission_absorption", "mip", "minip", "mean", FirstHit(iso=0.4)])
def test_the_same_data_at_another_spacing(integrate):
    # A field that is linear along z, sampled by 5 or by 9 voxels over the same world size.
    tf = TransferFunction([(0, (0, 0, 1), 0.1), (1, (1, 0, 0), 0.9)])
    images = []
    for n in (5, 9):
        volume = ramp_z(n, aside=n, spacing=(4 / (n - 1),) * 3)
        look = scene(volume, tf, along_z(2, 2), integrate=FULL if integrate == "emission_absorption" else integrate)
        images.append(reference.render(look, (1, 1)))
    assert error(*images) < 1e-10


def test_two_halves_composite_to_the_whole():
    # Cut between the planes of voxels 7 and 8 of 17, on a plane of voxels that both halves keep.
    volume = blob()
    array, spacing = volume.array, volume.spacing
    lower = Volume(array[:9], spacing=spacing, origin=(-1, -1, -1))
    upper = Volume(array[8:], spacing=spacing, origin=(-1, -1, 0))
    # Looking along z with the plane on the lattice: 16 steps of 1/8 lie before it.
    camera = Camera.orthographic(eye=(0, 0, -3), target=(0, 0, 0), up=(0, 1, 0), height=1.9)
    # Curvature would need a neighbour on either side, which a sample at the cut has lost.
    looks = (scene(v, TF, camera, integrate=FULL) for v in (volume, lower, upper))
    whole, near, far = (reference.render(look, SIZE, curved=False).rgba for look in looks)
    assert np.abs(near + (1 - near[..., 3:]) * far - whole).max() < 1e-13
    # From anywhere else, once converged.
    whole, near, far = (reference.converged(scene(v, TF, CAMERA), SIZE, step=1 / 32).rgba for v in (volume, upper, lower))
    assert np.abs(near + (1 - near[..., 3:]) * far - whole).max() < 1e-5


def test_light_of_one_direction_turns_with_the_scene():
    volume = blob()
    lamp = Light.directional(to_light=(1, -1, 2))
    a = reference.render(scene(volume, TF, CAMERA, [lamp], shade="blinn_phong"), SIZE)
    turn = rotation((0, 0, 1), math.pi / 2)
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    moved = Volume(volume.array, world_from_index=matrix @ volume.world_from_index)
    camera = replace(CAMERA, eye=tuple(turn @ CAMERA.eye), target=tuple(turn @ CAMERA.target))
    turned = Light.directional(to_light=tuple(turn @ np.array([1.0, -1, 2])))
    b = reference.render(scene(moved, TF, camera, [turned], shade="blinn_phong"), SIZE)
    assert error(a, b) < 1e-9
    assert error(a, reference.render(scene(moved, TF, camera, [lamp], shade="blinn_phong"), SIZE)) > 1e-2


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.75])
def test_offsets_shift_the_lattice(offset):
    # A lattice shifted by a fraction is the lattice of an eye that stands that much nearer.
    # Post-classified steep functions tell lattices apart, most of all where rays enter.
    volume = ramp_z(6, 1.0, 0.0)
    look = scene(volume, TF, along_z(1, 1, -3), transfer="postclassified", integrate=FULL)
    moved = scene(volume, TF, along_z(1, 1, -3 + offset), transfer="postclassified", integrate=FULL)
    a = reference.render(look, (1, 1), offset_fraction=lambda x, y: np.full(x.shape, offset))
    b = reference.render(moved, (1, 1))
    assert error(a, b) < 1e-12
    assert offset == 0 or error(a, reference.render(look, (1, 1))) > 1e-2


def test_opacity_and_colour_stay_in_range():
    rng = np.random.default_rng(5)
    volume = Volume(rng.uniform(size=(6, 7, 8)) * 1000)
    tf = TransferFunction([(0, (0, 0, 0), 0), (500, (1, 0.5, 0), 5), (1000, (1, 1, 1), 1e6)])
    image = reference.render(scene(volume, tf, "iso"), SIZE, step=0.5)
    assert (image.rgba >= 0).all()
    assert (image.rgba[..., :3] <= image.rgba[..., 3:] + 1e-9).all()
    assert (image.rgba[..., 3] <= 1).all()
