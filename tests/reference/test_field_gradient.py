"""Fields, their empty samples, and gradients."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_scenes import ONE, along_z, constant, ramp_z, rotation, scene, setup_of
from scipy.ndimage import map_coordinates, sobel

from airlight import reference
from airlight.reference.field import field_value
from airlight.reference.gradient import field_gradient
from airlight.scene import Light
from airlight.stages.gradient import Precomputed
from airlight.stages.integrate import EmissionAbsorption, FirstHit
from airlight.stages.shade import BlinnPhong
from airlight.transfer import TransferFunction
from airlight.volume import Volume

NAN = math.nan


def test_trilinear_is_scipys():
    rng = np.random.default_rng(1)
    array = rng.normal(size=(4, 5, 6))
    p = rng.uniform(-0.5, 6, size=(200, 3))
    value, empty = field_value(setup_of(Volume(array)), p)
    expected = map_coordinates(array, p[:, ::-1].T, order=1, mode="nearest")
    assert value == pytest.approx(expected, abs=1e-13)
    assert not empty.any()


def test_nearest_rounds_half_up_and_clamps():
    volume = Volume(np.arange(4, dtype=np.uint8)[None, None])
    x = np.array([-0.5, 0.0, 0.49, 0.5, 1.5, 2.5, 3.5])
    p = np.stack([x, 0 * x, 0 * x], axis=1)
    value, _ = field_value(setup_of(volume, field="nearest"), p)
    assert value.tolist() == [0, 0, 0, 1, 2, 3, 3]


def test_bool_is_zero_and_one():
    volume = Volume(np.array([False, True])[None, None])
    value, _ = field_value(setup_of(volume), np.array([[0.25, 0.0, 0.0]]))
    assert value.tolist() == [0.25]


def test_empty_samples_do_not_spread():
    array = np.full((2, 2, 2), 3.0)
    array[:, :, 1] = NAN
    p = np.array([[0.0, 0, 0], [0.3, 0.2, 0.9], [0.5, 0, 0], [0.51, 0, 0], [1, 0, 0]])
    value, empty = field_value(setup_of(Volume(array)), p)
    assert empty.tolist() == [False, False, False, True, True]
    assert value == pytest.approx([3, 3, 3, 0, 0])
    for field, no_data in (("linear", -7), ("nearest", -7)):
        marked = np.where(np.isnan(array), -7, array).astype(np.int16)
        value, empty = field_value(setup_of(Volume(marked, no_data=no_data), field=field), p[[0, 4]])
        assert empty.tolist() == [False, True]


def test_slabs_at_the_edge_of_emptiness_count_half():
    # Voxels 3 to 5 of nine hold a 1, the others are empty: samples at 3, 4, 5 see it, slabs 2-3 and 5-6 count half.
    values = np.full(9, NAN)
    values[3:6] = 1
    volume = Volume(np.broadcast_to(values[:, None, None], (9, 3, 3)))
    for transfer in ("postclassified", "preintegrated"):
        image = reference.render(scene(volume, constant(0.2), transfer=transfer), ONE)
        assert image.rgba[0, 0, 3] == pytest.approx(1 - math.exp(-0.2 * 3), abs=1e-13)
    # Samples on half voxels: 2.5 to 5.5 see it.
    image = reference.render(scene(volume, constant(0.2), along_z(1, 1, -9.5)), ONE)
    assert image.rgba[0, 0, 3] == pytest.approx(1 - math.exp(-0.2 * 4), abs=1e-13)
    tf = TransferFunction([(0, (0, 0, 0), 0), (2, (1, 1, 1), 1)])
    # Surfaces are looked for at quarters of blocks of four voxels: at 3 first.
    for integrate, depth in (("mip", 13), ("minip", 13), ("mean", math.inf), (FirstHit(iso=0.5), 13)):
        image = reference.render(scene(volume, tf, integrate=integrate), ONE)
        assert image.rgba[0, 0] == pytest.approx([0.5, 0.5, 0.5, 1])
        assert image.depth[0, 0] == pytest.approx(depth, abs=1e-12)


@pytest.mark.parametrize("integrate", ["emission_absorption", "mip", "minip", "mean", "first_hit"])
def test_a_volume_of_nothing_is_transparent(integrate):
    look = scene(Volume(np.full((3, 3, 3), NAN)), constant(1.0), shade="blinn_phong", integrate=integrate)
    image = reference.render(look, ONE)
    assert (image.rgba == 0).all()
    assert image.depth[0, 0] == math.inf


# -- gradients

SHEAR = rotation((1, 2, 3), 0.7) @ np.array([[0.5, 0.2, 0.0], [0, 1.5, -0.3], [0, 0, 2.0]])


def linear_volume(gradient_world, n=(5, 4, 6), matrix=SHEAR, **options):
    x, y, z = np.meshgrid(*(np.arange(m) for m in n), indexing="ij")
    world = np.stack([x, y, z], axis=-1) @ matrix.T
    affine = np.eye(4)
    affine[:3, :3] = matrix
    return Volume((world @ gradient_world + 2).transpose(2, 1, 0), world_from_index=affine, **options)


@pytest.mark.parametrize("gradient", ["central", "sobel", "precomputed", Precomputed(method="sobel")])
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_gradient_of_a_linear_field_is_exact(gradient, data):
    g = np.array(data.draw(st.tuples(*(st.floats(-5, 5, width=16),) * 3)))
    p = np.array([data.draw(st.tuples(st.floats(0, 4), st.floats(0, 3), st.floats(0, 5)))])
    found = field_gradient(setup_of(linear_volume(g), gradient=gradient), p)
    assert found[0] == pytest.approx(g, abs=1e-10)


def test_gradients_on_voxels_are_the_usual_stencils():
    rng = np.random.default_rng(2)
    array = rng.normal(size=(5, 6, 7))
    volume = Volume(array, spacing=(1, 2, 4))
    z, y, x = (axis.ravel() for axis in np.meshgrid(np.arange(1, 4), np.arange(1, 5), np.arange(1, 6), indexing="ij"))
    p = np.stack([x, y, z], axis=1).astype(float)
    found = field_gradient(setup_of(volume, gradient="central"), p)
    expected = np.stack(np.gradient(array, 4.0, 2.0, 1.0)[::-1], axis=-1)[z, y, x]
    assert found == pytest.approx(expected, abs=1e-12)
    found = field_gradient(setup_of(volume, gradient="sobel"), p)
    expected = np.stack([sobel(array, axis) / 32 / s for axis, s in ((2, 1), (1, 2), (0, 4))], axis=-1)[z, y, x]
    assert found == pytest.approx(expected, abs=1e-12)


def test_precomputed_gradients_are_interpolated():
    rng = np.random.default_rng(3)
    volume = Volume(rng.normal(size=(4, 4, 4)))
    setup = setup_of(volume, gradient="precomputed")
    ends = field_gradient(setup_of(volume), np.array([[1.0, 1, 1], [2, 1, 1]]))
    assert field_gradient(setup, np.array([[1.25, 1, 1]]))[0] == pytest.approx(0.75 * ends[0] + 0.25 * ends[1])


def test_surfaces_towards_emptiness_are_lit():
    # The solid 1 in voxels 3 to 5 has a ramp across, so that its cut face has a normal.
    values = np.full((9, 5, 5), NAN)
    values[3:6] = 1 + np.arange(5.0)
    stage = BlinnPhong(ambient=0, diffuse=1, specular=0, gradient_threshold=0.5)
    lights = [Light.directional(to_light=(1, 0, 0))]
    for field in ("nearest", "linear"):
        look = scene(
            Volume(values), constant(1.0), along_z(2, 2), lights, field=field, shade=stage, integrate=FirstHit(iso=0.5)
        )
        image = reference.render(look, ONE)
        assert image.rgba[0, 0] == pytest.approx([1, 1, 1, 1])


def test_axes_of_one_voxel_have_no_slope():
    volume = Volume(np.arange(4.0)[None, None])
    for gradient in ("central", "sobel", "precomputed"):
        found = field_gradient(setup_of(volume, gradient=gradient), np.array([[1.0, 0.2, -0.4]]))
        assert found[0] == pytest.approx([1, 0, 0])


@pytest.mark.parametrize("gradient", ["central", "sobel"])
def test_gradients_beside_emptiness_are_one_sided(gradient):
    g = np.array([1.0, -2.0, 0.5])
    array = linear_volume(g, matrix=np.eye(3)).array.copy()
    array[:, :, 3:] = NAN
    setup = setup_of(Volume(array), gradient=gradient)
    assert field_gradient(setup, np.array([[2.0, 1.0, 2.0]]))[0] == pytest.approx(g)
    # Deep inside what is empty nothing is known.
    assert field_gradient(setup, np.array([[4.0, 1.0, 2.0]]))[0] == pytest.approx([0, 0, 0])


# -- domains


def test_domains():
    # Nearest: n voxels are n long. Linear: n - 1. One voxel: always its cell.
    for n, field, length in ((4, "nearest", 4), (4, "linear", 3), (1, "linear", 1), (1, "nearest", 1)):
        volume = Volume(np.ones((n, 3, 3)), spacing=(1, 1, 0.5))
        look = scene(volume, constant(0.3), along_z(1, 1), field=field, integrate=EmissionAbsorption(opaque_at=1))
        image = reference.render(look, ONE)
        assert image.rgba[0, 0, 3] == pytest.approx(1 - math.exp(-0.3 * length * 0.5), abs=1e-13)
    # Aside, the linear domain ends at the outer centres, the nearest one at the outer faces.
    for field, inside, outside in (("linear", 1.99, 2.01), ("nearest", 2.49, 2.51)):
        hits = [reference.render(scene(ramp_z(3), constant(1), along_z(x, 1), field=field), ONE) for x in (inside, outside)]
        assert [h.rgba[0, 0, 3] > 0 for h in hits] == [True, False]


def test_an_empty_point_has_no_gradient():
    volume = Volume(np.broadcast_to(np.array([1.0, NAN, 3.0]), (3, 3, 3)))
    assert field_gradient(setup_of(volume), np.array([[1.0, 1, 1]])).tolist() == [[0, 0, 0]]
    # Beside it the slopes that have one end only are not known either.
    assert field_gradient(setup_of(volume), np.array([[0.0, 1, 1]])).tolist() == [[0, 0, 0]]
