"""What is typed behind options: values, and errors that name the option."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from airlight.app import parse
from airlight.errors import AirlightError, ValueRangeError
from airlight.scene import Camera
from airlight.stages.driver import March
from airlight.stages.gradient import Precomputed
from airlight.stages.integrate import FirstHit
from airlight.stages.shade import BlinnPhong
from airlight.transfer import TransferFunction, linear_rgb


@pytest.mark.parametrize(("text", "size"), [("640x480", (640, 480)), ("512", (512, 512)), (" 3 X 4 ", (3, 4)), ("5,6", (5, 6))])
def test_sizes(text: str, size: tuple[int, int]) -> None:
    assert parse.parse_size(text) == size


@pytest.mark.parametrize("text", ["", "x", "0x5", "5x0", "-1x3", "1x2x3", "1.5x2", "9999999x1"])
def test_wrong_sizes(text: str) -> None:
    with pytest.raises(ValueRangeError, match=r"--size is .* must be WIDTHxHEIGHT"):
        parse.parse_size(text)


@pytest.mark.parametrize(
    ("text", "count"), [("4G", 4 << 30), ("500m", 500 << 20), ("1.5 KiB", 1536), ("7", 7), ("2TB", 2 << 40)]
)
def test_bytes(text: str, count: int) -> None:
    assert parse.parse_bytes(text) == count


@pytest.mark.parametrize("text", ["", "G", "-4G", "0", "4X", "nan"])
def test_wrong_bytes(text: str) -> None:
    with pytest.raises(ValueRangeError, match="--max-memory"):
        parse.parse_bytes(text)


def test_shape_and_spacing() -> None:
    assert parse.parse_shape("3x4,5") == (3, 4, 5)
    assert parse.parse_spacing("2") == (2.0, 2.0, 2.0)
    assert parse.parse_spacing("1,2,.5") == (1.0, 2.0, 0.5)
    for wrong in ("3", "3x4", "1x2x3x4x5x6", "ax2x3", "0x1x1"):
        with pytest.raises(ValueRangeError, match="--shape"):
            parse.parse_shape(wrong)
    for wrong in ("1,2", "0,1,1", "a", "inf"):
        with pytest.raises(ValueRangeError, match="--spacing"):
            parse.parse_spacing(wrong)


def test_cameras() -> None:
    assert parse.parse_camera("left") == "left"
    assert parse.parse_camera("1,2,3,4,5,6") == Camera.perspective(eye=(1, 2, 3), target=(4, 5, 6))
    assert parse.parse_camera("-1,0,0,0,0,0,0,1,0") == Camera.perspective(eye=(-1, 0, 0), target=(0, 0, 0), up=(0, 1, 0))
    assert parse.parse_camera("0,0,9,0,0,0") == Camera.perspective(eye=(0, 0, 9), target=(0, 0, 0), up=(0, -1, 0))
    dome = Camera.dome(eye=(1, 2, 3), target=(4, 5, 6), angle_deg=220)
    assert parse.parse_camera("dome:eye=[1,2,3],target=[4,5,6],angle_deg=220") == dome
    with pytest.raises(ValueRangeError, match=r"--camera is 'panorama:eye=.*', must tell eye and target: e.g. panorama:eye="):
        parse.parse_camera("panorama:eye=[0,0,0]")
    wrong_kinds = ("dome", "dome:eye=[1,2,3],target=[1,2,3]", "dome:eye=[1,2,3],target=[4,5,6],fov_deg=3", "stereo:eye")
    for wrong in ("above", "1,2,3", "1,2,3,4,5,nan", "1,1,1,1,1,1", *wrong_kinds):
        with pytest.raises(ValueRangeError, match="camera"):
            parse.parse_camera(wrong)


def test_backgrounds() -> None:
    assert parse.parse_background("none") is None
    assert parse.parse_background("0.5,0,1") == (0.5, 0.0, 1.0)
    assert parse.parse_background("#ff0000") == (1.0, 0.0, 0.0)
    assert parse.parse_background("tomato") == linear_rgb("tomato")
    with pytest.raises(ValueRangeError, match="--background"):
        parse.parse_background("nocolour")


def test_transfer_functions() -> None:
    typed = parse.parse_transfer("-50:black:0 300:#ffaa88:0.02 1200:1,0.5,0:0.5")
    assert typed == TransferFunction([(-50, "black", 0), (300, "#ffaa88", 0.02), (1200, (1, 0.5, 0), 0.5)])
    for wrong in ("", "1:2", "a:red:1", "1:nocolour:0", "1:red:-1", "2:red:0 1:red:0"):
        with pytest.raises(ValueRangeError):
            parse.parse_transfer(wrong)


def test_stages() -> None:
    assert parse.parse_stage("shade", "blinn_phong:ambient=.2, shininess=40") == BlinnPhong(ambient=0.2, shininess=40.0)
    assert parse.parse_stage("shade", "blinn_phong:two_sided=false,gradient_threshold=none") == BlinnPhong(two_sided=False)
    assert parse.parse_stage("gradient", "precomputed:method=sobel") == Precomputed(method="sobel")
    assert parse.parse_stage("integrate", "first_hit:iso=-3e2") == FirstHit(iso=-300.0)
    assert parse.parse_stage("camera", "perspective:eye=[0,1,2]") == Camera.perspective(eye=(0, 1, 2), target=(0, 0, 0))
    assert parse.parse_stage("driver", "march:offsets=interleaved") == March(offsets="interleaved")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("phong", r"--shade is 'phong', must be one of .*blinn_phong.*--plugin"),
        ("blinn_phong:ambience=1", r"--shade.ambience is no parameter of blinn_phong: it has ambient"),
        ("blinn_phong:ambient=-1", r"shade.blinn_phong.ambient is -1.0, must lie in \[0, inf\)"),
        ("blinn_phong:ambient=nan", r"ambient is nan"),
        ("blinn_phong:ambient=much", r"--shade.ambient is 'much', must be a number"),
        ("blinn_phong:two_sided=1", r"--shade.two_sided is 1, must be true or false"),
        ("blinn_phong:ambient=1,ambient=2", r"--shade.ambient is given twice"),
        ("blinn_phong:", r"must be PARAMETER=VALUE"),
        ("blinn_phong:ambient", r"must be PARAMETER=VALUE"),
    ],
)
def test_wrong_stages(text: str, message: str) -> None:
    with pytest.raises(ValueRangeError, match=message):
        parse.parse_stage("shade", text)


@given(st.text(max_size=30))
def test_any_text_is_a_value_or_a_clear_error(text: str) -> None:
    for function in (parse.parse_size, parse.parse_bytes, parse.parse_camera, parse.parse_shape, parse.parse_background):
        try:
            function(text)
        except AirlightError:
            continue
    try:
        parse.parse_stage("shade", "blinn_phong:" + text)
        parse.parse_transfer(text)
    except AirlightError:
        pass


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=0))
def test_numbers_of_stages_are_exact(number: float) -> None:
    stage = parse.parse_stage("shade", f"blinn_phong:ambient={number!r}")
    assert isinstance(stage, BlinnPhong)
    assert math.isclose(stage.ambient, number, rel_tol=0)
