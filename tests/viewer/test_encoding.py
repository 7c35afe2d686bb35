"""Pictures as bytes: PNG bit for bit, JPEG near enough by either package."""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as Pillow

from airlight import Image
from airlight.viewer.encoding import CHECK_PX, CHECKS, jpeg, pixels_of, png


def decoded(data: bytes) -> np.ndarray:
    return np.asarray(Pillow.open(io.BytesIO(data)))


@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 1 << 30))
def test_png_loses_nothing(width, height, seed):
    pixels = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    data = png(pixels)
    assert np.array_equal(decoded(data), pixels)
    assert Pillow.open(io.BytesIO(data)).verify() is None


@pytest.mark.parametrize("package", ["simplejpeg", "Pillow"])
def test_jpeg(package, monkeypatch):
    if package == "Pillow":
        monkeypatch.setitem(sys.modules, "simplejpeg", None)
    else:
        pytest.importorskip("simplejpeg")
    y, x = np.mgrid[:48, :64]
    pixels = np.stack([2 * x, 3 * y, x + y], axis=-1).astype(np.uint8)
    good, small = jpeg(pixels, 80), jpeg(pixels, 20)
    assert decoded(good).shape == pixels.shape
    assert np.abs(decoded(good).astype(int) - pixels).mean() < 4
    assert len(small) < len(good)


def test_what_is_transparent_lies_over_a_checkerboard_that_scales():
    rgba = np.zeros((3 * CHECK_PX, 4 * CHECK_PX, 4), np.float32)
    rgba[: CHECK_PX // 2] = 1.0
    image = Image(rgba, rgba[..., 0])
    pixels = pixels_of(image)
    assert (pixels[: CHECK_PX // 2] == 255).all()
    assert {tuple(np.unique(pixels[y, :CHECK_PX])) for y in (CHECK_PX // 2, CHECK_PX)} == {(grey,) for grey in CHECKS}
    small = pixels_of(Image(rgba[::2, ::2], rgba[::2, ::2, 0]), 0.5)
    assert np.array_equal(small, pixels[::2, ::2])
    opaque = pixels_of(Image(rgba, rgba[..., 0], (0.0, 0.0, 0.0)))
    assert opaque.shape == pixels.shape
    assert opaque[-1].max() == 0
