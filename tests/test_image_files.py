"""Pictures in files: 8 bits with and without dithering, floats in EXR, and nothing left behind where writing fails."""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest
from PIL import Image as Pillow

import airlight as al
from airlight.rendering.dithering import bytes_of
from airlight.rendering.image import Image

OpenEXR = pytest.importorskip("OpenEXR")


@pytest.fixture
def image() -> Image:
    rng = np.random.default_rng(0)
    alpha = rng.uniform(0, 1, (6, 9, 1))
    rgba = np.concatenate([alpha * rng.uniform(0, 50, (6, 9, 3)), alpha], axis=-1).astype(np.float32)
    depth = rng.uniform(1, 9, (6, 9)).astype(np.float32)
    depth[0, 0] = np.inf
    return Image(rgba, depth)


# -- dithering


def test_dithered_ramps_keep_their_mean_and_have_no_bands():
    """A ramp of three of 255 steps over 768 pixels: means of 16 x 16 pixels are off by a half without, and hardly with."""
    ramp = np.tile(np.linspace(100.2, 103.2, 768) / 255, (64, 1))[..., None].repeat(3, axis=2)

    def error(picture):
        blocks = (picture.astype(float) - 255 * ramp).reshape(4, 16, 48, 16, 3)
        return blocks.mean(axis=(1, 3))

    plain, dithered = error(bytes_of(ramp)), error(bytes_of(ramp, dither=True))
    assert np.abs(plain).max() > 0.45
    assert np.abs(dithered).max() < 0.06
    assert dithered.var() < plain.var() / 100
    assert abs(dithered.mean()) < 2e-3
    assert np.abs(bytes_of(ramp, dither=True) - 255 * ramp).max() < 1  # neighbouring steps alone
    assert np.array_equal(bytes_of(ramp, dither=True), bytes_of(ramp, dither=True))
    assert (np.ptp(bytes_of(ramp, dither=True), axis=2) == 0).all()  # grey stays grey


def test_steps_stay_exact_when_dithered():
    """Also as float32, and where a rounding error lies between; 0 and 1 above all."""
    steps = np.arange(256)[:, None].repeat(64, axis=1)
    unit = (steps / 255).astype(np.float32)
    for wrong in (unit, np.nextafter(unit, 0), np.minimum(np.nextafter(unit, 1), 1)):
        assert np.array_equal(bytes_of(wrong, dither=True), steps)


def test_pictures_are_dithered_where_it_is_asked_for(image, tmp_path):
    assert np.array_equal(np.asarray(Pillow.open(io.BytesIO(image.png()))), image.picture())
    image.save(tmp_path / "a.png", dither=True)
    dithered = np.asarray(Pillow.open(tmp_path / "a.png"))
    assert np.array_equal(dithered, image.picture(dither=True))
    difference = np.abs(dithered.astype(int) - image.picture())
    assert difference.max() == 1


# -- EXR


@pytest.mark.parametrize("half", [False, True])
def test_exr_holds_light_and_depth(image, tmp_path, half):
    image.rgba[0, 0] = 1e-9  # beyond half floats
    assert image.save(tmp_path / "a.exr", half=half) == tmp_path / "a.exr"
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    assert channels["RGBA"].dtype == (np.float16 if half else np.float32)
    assert channels["RGBA"] == pytest.approx(image.rgba, rel=1e-3 if half else 0, abs=1e-8 if half else 0)
    assert np.array_equal(channels["Z"], image.depth)


def test_options_of_other_files_are_refused(image, tmp_path):
    with pytest.raises(
        al.AirlightError, match=r"dither is for 8 bits, and \.exr files hold floats: leave it out, or write \.png"
    ):
        image.save(tmp_path / "a.exr", dither=True)
    with pytest.raises(al.AirlightError, match=r"half is for \.exr files alone: leave it out, or write \.exr"):
        image.save(tmp_path / "a.png", half=True)
    assert not list(tmp_path.iterdir())


def test_nothing_is_left_where_writing_fails(image, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(al.MissingExtraError, match=r'writing EXR needs OpenEXR: pip install "airlight\[exr\]"'):
        image.save(tmp_path / "a.exr")
    assert not list(tmp_path.iterdir())
    monkeypatch.undo()
    (tmp_path / "a.exr").write_bytes(b"as it was")

    def broken(*_):
        raise RuntimeError('Failed to write pixel data to image file "/tmp/.airlight-1.exr". No space left on device.')

    monkeypatch.setattr(OpenEXR.File, "write", broken)
    with pytest.raises(al.FileError, match=r"a.exr cannot be written \(No space left on device.\)"):
        image.save(tmp_path / "a.exr")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"as it was"]
