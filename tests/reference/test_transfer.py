"""The integrals over slabs against adaptive quadrature."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from reference_scenes import WHITE, ends, setup_of
from scipy.integrate import quad_vec

from airlight.reference.transfer import postclassified, preintegrated, riemann
from airlight.transfer import TransferFunction
from airlight.volume import Volume

ANY = Volume(np.zeros((2, 2, 2)))
share = st.floats(0, 1, width=16)


@st.composite
def functions(draw):
    count = draw(st.integers(1, 6))
    values = sorted(draw(st.lists(st.integers(-8, 8), min_size=count, max_size=count)))
    points = [(v / 4, (draw(share), draw(share), 0.5), 3 * draw(share)) for v in values]
    return TransferFunction(points, associated=draw(st.booleans()))


def by_quadrature(tf, a, b, d):
    """Light (r, g, b, opacity) and its part from the back by SciPy, between control points."""
    cuts = sorted({0.0, 1.0} | {(v - a) / (b - a) for v in tf.values if min(a, b) < v < max(a, b)}) if a != b else [0.0, 1.0]

    def tau(x):
        return float(tf(a + (b - a) * x)[1])

    sent, before = np.zeros(8), 0.0
    for low, high in pairwise(cuts):

        def depth(x, low=low, before=before):
            # Extinction is linear between cuts: the midpoint rule is exact.
            return before + (x - low) * d * tau((low + x) / 2)

        def light(x, depth=depth):
            here = d * math.exp(-depth(x)) * np.append(tf.source(a + (b - a) * x), tau(x))
            return np.concatenate([here, x * here])

        sent += quad_vec(light, low, high, epsabs=1e-11, norm="max")[0]
        before = depth(high)
    return sent[:4], sent[4:]


@settings(max_examples=40, deadline=None)
@given(tf=functions(), a=st.floats(-2.5, 2.5, width=16), b=st.floats(-2.5, 2.5, width=16), d=st.sampled_from([0.01, 0.4, 1.6]))
@example(tf=TransferFunction([(0, WHITE, 1), (0, (1, 0, 0), 3)]), a=0.0, b=0.0, d=0.5)
@example(tf=TransferFunction([(0, WHITE, 1), (0, (1, 0, 0), 3)]), a=0.0, b=1.0, d=0.5)
@example(tf=TransferFunction([(0, WHITE, 1), (0, (1, 0, 0), 3)]), a=0.0, b=-1.0, d=0.5)
def test_preintegrated_is_the_integral(tf, a, b, d):
    slab = preintegrated(setup_of(ANY, tf), ends(a), ends(b), np.array([d]))
    whole, back = by_quadrature(tf, a, b, d)
    assert [*slab.rgb[0], slab.alpha[0]] == pytest.approx(whole, abs=1e-9)
    assert [*slab.back_rgb[0], slab.back_alpha[0]] == pytest.approx(back, abs=1e-9)


@pytest.mark.parametrize("depth", [0.29, 4.9, 49.0, 400.0, 1e6])
@pytest.mark.parametrize("associated", [False, True])
def test_error_by_optical_depth(depth, associated):
    # Extinction from 0 to 2 k, colour 1 - s: closed forms of associated sources by the error function.
    tf = TransferFunction([(0, WHITE, 0), (1, (0, 0, 0), 2)], associated=associated)
    rgb = preintegrated(setup_of(ANY, tf), ends(0.0), ends(1.0), np.array([depth])).rgb
    root = math.sqrt(depth)
    glow = math.sqrt(math.pi) / 2 / root * math.erf(root) - (1 - math.exp(-depth)) / (2 * depth)
    hidden = 1 - math.exp(-depth) - (math.sqrt(math.pi) / 2 * math.erf(root) / root - math.exp(-depth))
    expected = depth * glow if associated else hidden
    assert rgb[0] == pytest.approx([expected] * 3, rel=2e-9)


@settings(max_examples=40, deadline=None)
@given(tf=functions(), a=st.floats(-2.5, 2.5), d=st.floats(1e-6, 1e5))
def test_constant_values_agree_in_all_stages(tf, a, d):
    setup, end, length = setup_of(ANY, tf), ends(a), np.array([d])
    tau = float(tf(a)[1])
    post, pre = postclassified(setup, end, end, length), preintegrated(setup, end, end, length)
    assert post.alpha[0] == pytest.approx(-math.expm1(-min(tau * d, 700)), rel=1e-12)
    assert pre.rgb == pytest.approx(post.rgb, rel=1e-9, abs=1e-300)
    assert pre.alpha == pytest.approx(post.alpha, rel=1e-12, abs=1e-300)
    assert pre.back_rgb == pytest.approx(post.back_rgb, rel=1e-6, abs=1e-300)
    assert pre.back_alpha == pytest.approx(post.back_alpha, rel=1e-6, abs=1e-300)


def test_short_slabs_tend_to_the_papers_form():
    tf = TransferFunction([(0, WHITE, 0), (1, (1, 0.5, 0), 2)])
    setup, front, back = setup_of(ANY, tf), ends(0.4), ends(0.4)
    for d in (1e-2, 1e-4, 1e-6):
        length = np.array([d])
        papers = riemann(setup, front, back, length).rgb / d
        assert postclassified(setup, front, back, length).rgb / d == pytest.approx(papers, rel=d)
        assert preintegrated(setup, front, back, length).rgb / d == pytest.approx(papers, rel=d)


def test_slabs_without_length_are_empty():
    setup = setup_of(ANY, TransferFunction([(0, WHITE, 0), (1, WHITE, 2)], associated=True))
    for classify in (postclassified, preintegrated, riemann):
        slab = classify(setup, ends([0.1, 0.9]), ends([0.9, 0.9]), np.zeros(2))
        assert (slab.rgb == 0).all()
        assert (slab.alpha == 0).all()
