"""Blinn-Phong light worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_scenes import ONE, along_z, constant, ramp_z, scene, setup_of

from airlight import reference
from airlight.reference.setup import Sample
from airlight.reference.shade import automatic_threshold, blinn_phong
from airlight.scene import Light, Look
from airlight.stage import Context
from airlight.stages.integrate import FirstHit
from airlight.stages.lighting import Sampled
from airlight.stages.shade import BlinnPhong
from airlight.stages.shade import automatic_threshold as stage_threshold
from airlight.volume import Volume

DOWN = np.array([[0.0, 0.0, -1.0]])  # towards the eye of a ray up the z axis
PLAIN = BlinnPhong(ambient=0.1, diffuse=0.6, specular=0.3, shininess=10, gradient_threshold=0.01)
ANY = Volume(np.zeros((2, 2, 2)))


def light_at(stage, lights, gradient, p_world=(0, 0, 0), to_eye=DOWN):
    setup = setup_of(ANY, lights=lights, shade=stage)
    sample = Sample(np.zeros(1), np.zeros(1, bool), np.zeros((1, 3)), np.array([p_world], dtype=float), np.zeros(1))
    lit = blinn_phong(setup, sample, np.array([gradient], dtype=float), to_eye)
    return lit.diffuse[0], lit.specular[0]


def test_head_light():
    # The normal -g/|g| makes an angle of 60 degrees with the way to the eye.
    g = (math.sin(math.pi / 3), 0, math.cos(math.pi / 3))
    diffuse, specular = light_at(PLAIN, [Light.head(color=(1, 0.5, 0), intensity=2)], g)
    assert diffuse == pytest.approx([0.1 + 2 * 0.6 * 0.5, 0.1 + 0.6 * 0.5, 0.1])
    assert specular == pytest.approx([2 * 0.3 * 0.5**10, 0.3 * 0.5**10, 0])


def test_directional_light_with_its_half_vector():
    # Light from +x, eye at -z, normal half way: n.l = cos 45, n.h = 1.
    diffuse, specular = light_at(PLAIN, [Light.directional(to_light=(2, 0, 0))], (-3, 0, 3))
    assert diffuse == pytest.approx([0.1 + 0.6 * math.sqrt(0.5)] * 3)
    assert specular == pytest.approx([0.3] * 3)


def test_point_light_falls_off_only_by_request():
    place = (0, 0, -4)
    for radius, factor in ((None, 1.0), (2.0, 0.25), (8.0, 4.0)):
        diffuse, _ = light_at(PLAIN, [Light.point(position=place, radius=radius)], (0, 0, 1))
        assert diffuse == pytest.approx([0.1 + 0.6 * factor] * 3)


def test_lights_add():
    a, b = Light.directional(to_light=(1, 0, -1)), Light.point(position=(0, 3, -1), color=(0, 1, 0))
    gradient = (0.3, -0.2, 0.7)
    both = light_at(PLAIN, [a, b], gradient)
    none = light_at(PLAIN, [], gradient)
    for part in (0, 1):
        single = [light_at(PLAIN, [lamp], gradient)[part] for lamp in (a, b)]
        assert both[part] + none[part] == pytest.approx(single[0] + single[1])
    assert none[0] == pytest.approx([0.1] * 3)


def test_sides():
    from dataclasses import replace

    for gradient in ((0, 0, 1.0), (0, 0, -1.0)):
        diffuse, specular = light_at(PLAIN, [Light.head()], gradient)
        assert (diffuse[0], specular[0]) == pytest.approx((0.7, 0.3))
    one_sided = replace(PLAIN, two_sided=False)
    assert light_at(one_sided, [Light.head()], (0, 0, 1.0))[0][0] == pytest.approx(0.7)
    diffuse, specular = light_at(one_sided, [Light.head()], (0, 0, -1.0))
    assert (diffuse[0], specular[0]) == pytest.approx((0.1, 0.0))


def test_below_the_threshold_only_ambient_light_is_left():
    for gradient in ((0, 0, 0.009), (0, 0, 0)):
        diffuse, specular = light_at(PLAIN, [Light.head()], gradient)
        assert (diffuse[0], specular[0]) == pytest.approx((0.1, 0.0))
    diffuse, _ = light_at(BlinnPhong(ambient=0.1, gradient_threshold=0.0), [Light.head()], (0, 0, 0))
    assert diffuse == pytest.approx([0.1] * 3)


@settings(max_examples=50, deadline=None)
@given(
    gradient=st.tuples(*(st.floats(-1e6, 1e6, allow_subnormal=False),) * 3),
    direction=st.tuples(*(st.integers(-3, 3),) * 3).filter(any),
    shininess=st.floats(0.1, 10_000),
    two_sided=st.booleans(),
)
def test_light_is_finite_and_bounded(gradient, direction, shininess, two_sided):
    # Opposite lights, lights at the point itself, sharpest highlights: nothing overflows or divides by zero.
    stage = BlinnPhong(shininess=shininess, two_sided=two_sided, gradient_threshold=1e-3)
    lights = [Light.directional(to_light=direction), Light.point(position=(0, 0, 0)), Light.head()]
    diffuse, specular = light_at(stage, lights, gradient)
    assert (diffuse >= 0.1).all()
    assert (diffuse <= 0.1 + 3 * 0.7 + 1e-9).all()
    assert (specular >= 0).all()
    assert (specular <= 3 * 0.2 + 1e-9).all()


def test_automatic_threshold_is_the_stages():
    rng = np.random.default_rng(4)
    volume = Volume(rng.normal(size=(30, 28, 27)), spacing=(0.5, 1, 2))
    setup = setup_of(volume)
    context = Context(volume, setup.function, (0,), 0, 1.0, ONE)
    assert automatic_threshold(setup) == pytest.approx(stage_threshold(context))
    low, high = np.percentile(volume.array, [0.5, 99.5])
    assert automatic_threshold(setup) == pytest.approx((high - low) / 2000 / 0.5, rel=0.02)


# -- in images


def test_lit_first_hit():
    # The ramp's gradient is +z, so the normal faces the eye: diffuse ambient + diffuse, specular full.
    look = scene(ramp_z(7), constant(1, (0.5, 0.25, 0)), shade=PLAIN, integrate=FirstHit(iso=0.4))
    rgba = reference.render(look, ONE).rgba[0, 0]
    assert rgba == pytest.approx([0.5 * 0.7 + 0.3, 0.25 * 0.7 + 0.3, 0.3, 1])


@pytest.mark.parametrize("associated", [False, True])
def test_lit_medium(associated):
    # Everywhere on a ramp the light is the same: colour times 0.7, and white 0.3 weighted by opacity.
    tf = constant(0.2, (0.5, 0.25, 0), associated)
    rgba = reference.render(scene(ramp_z(7), tf, shade=PLAIN), ONE).rgba[0, 0]
    alpha = 1 - math.exp(-0.2 * 6)
    colour = np.array([0.5, 0.25, 0]) * (alpha / 0.2 if associated else alpha)
    assert rgba[:3] == pytest.approx(0.7 * colour + 0.3 * alpha)
    assert rgba[3] == pytest.approx(alpha)


def test_light_may_be_evaluated_in_the_middle_of_a_slab():
    # Slopes half-way between samples: 0, 0, 1/4, 3/4, 1, 1.
    values = np.array([0.0, 0, 0, 0, 1, 2, 3])
    volume = Volume(np.broadcast_to(values[:, None, None], (7, 3, 3)))
    stage = BlinnPhong(ambient=0, diffuse=1, specular=0, gradient_threshold=0.4)
    lit = scene(volume, constant(0.1), shade=stage, lighting=Sampled(at="middle"))
    # The middles at 3.5, 4.5 and 5.5 are lit, the first of them not in full: its slope is less than twice the threshold.
    expected = sum(share * math.exp(-0.1 * k) * -math.expm1(-0.1) for k, share in ((3, 0.875), (4, 1.0), (5, 1.0)))
    assert reference.render(lit, ONE).rgba[0, 0, 0] == pytest.approx(expected)


def test_unlit_looks_ask_for_no_light():
    look = scene(ramp_z(7), constant(0.2), shade=PLAIN, lighting="unlit")
    rgba = reference.render(look, ONE).rgba[0, 0]
    assert rgba == pytest.approx([1 - math.exp(-1.2)] * 4)
    assert Look(shade="none").stages()["lighting"].name == "unlit"


def test_point_light_in_an_image():
    look = scene(
        ramp_z(7), constant(1), along_z(1, 1), lights=[Light.point(position=(1, 4, -1.6))],
        shade=BlinnPhong(ambient=0, diffuse=1, specular=0), integrate=FirstHit(iso=0.4),
    )  # fmt: skip
    # The hit lies at (1, 1, 2.4); the way to the light is (0, 3, -4), the normal (0, 0, -1).
    assert reference.render(look, ONE).rgba[0, 0, 0] == pytest.approx(0.8)
