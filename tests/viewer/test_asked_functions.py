"""Questions of the editor of transfer functions: histograms, presets, proposals, files, channels, labels; and windows."""

from __future__ import annotations

import dataclasses
import json
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

import airlight as al
from airlight.viewer.asked.channels import mixture, named
from airlight.viewer.asked.histogram import BINS, histogram
from airlight.viewer.asked.labels import page, shown
from airlight.viewer.asked.presets import SIZE_PX, function, listed, picture
from airlight.viewer.asked.transfer import code, colormap, colormaps, file, mirrored, peak, read, swatch
from airlight.viewer.document import Document
from airlight.viewer.windowing import window_of, windowed

EYE = al.Camera.perspective(eye=(5, -40, 5), target=(5, 5, 5), up=(0, 0, 1))
RAMP = al.TransferFunction(
    [(0, "black", 0), (40, "red", 0.1), (40, "red", 0.5), (100, "white", 2)], surfaces=[(70, "blue", 0.5)]
)
PLAIN = dataclasses.replace(RAMP, surfaces=())


class Renderer:
    """Counts what it is asked to draw, and is done when told."""

    def __init__(self) -> None:
        self.asked: list[tuple[al.Scene, Future[Any]]] = []

    def submit(self, scene: al.Scene, size: tuple[int, int], **_: Any) -> Future[Any]:
        assert size == (SIZE_PX, SIZE_PX)
        self.asked.append((scene, Future()))
        return self.asked[-1][1]


class Asked:
    """What questions need of a session."""

    def __init__(self, *layers: al.Layer) -> None:
        self.document, self.key = Document(al.Scene(layers=layers, camera=EYE)), "k"
        self.viewer = SimpleNamespace(renderer=Renderer())

    def look(self, camera: al.camera.Camera) -> None:
        self.document = self.document.with_camera(camera)


def ball(size: int = 32, **given: Any) -> al.Volume:
    z, y, x = np.mgrid[-1 : 1 : size * 1j, -1 : 1 : size * 1j, -1 : 1 : size * 1j]
    inside = 0.5 - 0.5 * np.tanh(8 * (np.sqrt(x * x + y * y + z * z) - 0.7))
    return al.Volume((100 * inside).astype(np.float32), units="mm", **given)


def asked(volume: al.Volume | None = None, function: Any = RAMP, **given: Any) -> Any:
    return Asked(al.Layer(ball() if volume is None else volume, function, **given))


def test_a_histogram_leaves_out_what_is_empty_or_far_away() -> None:
    values = np.random.default_rng(1).normal(50, 5, (40, 40, 40)).astype(np.float32)
    values[0, 0, :5], values[0, 1, 0], values[0, 2, 0] = np.nan, 1e9, -999
    volume = al.Volume(values, no_data=-999, value_unit="HU")
    session = asked(volume)
    found = histogram(session)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert len(found["counts"]) == BINS
    assert sum(found["counts"]) + found["outside"] == values.size - 6
    assert found["empty"] == 6
    assert 0 < found["outside"] <= 14
    assert 20 < found["low"] < 40 < 60 < found["high"] < 80
    assert found["unit"] == "HU"
    assert histogram(session) is not found
    assert volume.__dict__["_value_histograms"].keys() == {(0, 0)}


def test_a_histogram_is_of_the_part_that_is_edited() -> None:
    volume = al.Volume(np.stack([np.full((4, 4, 4), 3.0), np.full((4, 4, 4), 70.0)]), channel_names=["a", "b"])
    session = asked(volume, al.Channels({"b": PLAIN, 0: PLAIN}))
    assert histogram(session, part=0)["low"] <= 70 <= histogram(session, part=0)["high"]
    assert histogram(session, part=1)["high"] < 70
    for wrong in ({"layer": 1}, {"part": 2}, {"part": "a"}, {"layer": -1}):
        with pytest.raises(al.AirlightError):
            histogram(session, **wrong)


def test_presets_suit_the_data() -> None:
    hounsfield = ball(value_unit="HU", modality="CT")
    shifted = al.Volume(hounsfield.array * 20 - 1000, value_unit="HU", modality="CT")
    names = {entry["name"] for entry in listed(asked(shifted))["presets"]}
    assert {"ct_bone", "automatic", "glow:viridis"} <= names
    assert not {"mri", "microscopy"} & names
    names = {entry["name"] for entry in listed(asked())["presets"]}
    assert {"mri", "microscopy", "automatic", "boundaries"} <= names
    assert not {name for name in names if name.startswith("ct_")}
    for name in names:
        assert al.TransferFunction.from_dict(function(asked(), name)["transfer"]).extinctions.max() > 0
    with pytest.raises(al.ValueRangeError, match="preset"):
        function(asked(), "nothing")


def test_a_picture_of_a_preset_is_made_once_for_where_the_camera_looks_from() -> None:
    session = asked()
    drawn = session.viewer.renderer.asked
    assert picture(session, "mri") == picture(session, "mri") == ({"kind": ""}, [])
    assert len(drawn) == 1
    assert drawn[0][0].layers[0].transfer == al.presets.get("mri", ball())
    drawn[0][1].set_result(SimpleNamespace(picture=lambda: np.zeros((SIZE_PX, SIZE_PX, 4), dtype=np.uint8)))
    told, [data] = picture(session, "mri")
    assert told == {"kind": "jpeg"}
    assert data[:2] == b"\xff\xd8"
    session.look(dataclasses.replace(EYE, eye=(5.001, -40, 5)))
    assert picture(session, "mri")[1] == [data]
    session.look(dataclasses.replace(EYE, eye=(40, 5, 5)))
    assert picture(session, "mri")[1] == []
    session.look(EYE)
    lit = dataclasses.replace(session.document.scene, lights=(al.Light.head(intensity=0.5),))
    session.document = dataclasses.replace(session.document, scene=lit)
    assert picture(session, "mri")[1] == []
    assert len(drawn) == 3
    drawn[-1][1].cancel()
    assert picture(session, "mri")[1] == []
    assert len(drawn) == 4


def test_functions_that_the_library_makes() -> None:
    session = asked()
    coloured = al.TransferFunction.from_dict(colormap(session, "viridis")["transfer"])
    assert coloured.surfaces == RAMP.surfaces
    at = np.linspace(-5, 110, 200)
    np.testing.assert_allclose(coloured(at)[1], RAMP(at)[1])
    assert not np.allclose(coloured(at)[0], RAMP(at)[0])
    turned = al.TransferFunction.from_dict(mirrored(session)["transfer"])
    np.testing.assert_allclose(turned.colours[0], RAMP.colours[-1])
    np.testing.assert_allclose(turned(at)[1], RAMP(at)[1])
    assert "viridis" in str(colormaps(session)["names"])
    assert swatch(session, "gray")["colours"][0] < swatch(session, "gray")["colours"][-1]
    with pytest.raises(al.ValueRangeError, match="did you mean"):
        swatch(session, "virids")


def test_a_peak_is_put_on_the_function() -> None:
    session = asked()
    added = al.TransferFunction.from_dict(peak(session, value=10.0)["transfer"])
    assert added([10.0])[1] > 5 * RAMP([10.0])[1]
    assert added([90.0])[1] == RAMP([90.0])[1]
    picked = peak(session, p_world=[15.0, 15.0, 5.0])
    assert al.TransferFunction.from_dict(picked["transfer"])([picked["value"]])[1] > RAMP([picked["value"]])[1]
    associated = asked(function=dataclasses.replace(PLAIN, associated=True))
    assert peak(associated, value=10.0)["transfer"]["associated"]


def test_a_function_is_saved_and_read_again() -> None:
    session = asked()
    text = file(session)["text"]
    assert text.startswith("# A transfer function")
    assert read(session, "mine.toml", text)["transfer"] == RAMP.to_dict()
    assert read(session, "mine.JSON", json.dumps(RAMP.to_dict()))["transfer"] == RAMP.to_dict()
    assert eval(code(session)["code"].partition("transfer = ")[2], {"al": al}) == RAMP
    with pytest.raises(al.ValueRangeError, match=r"^bad\.toml:1: transfer\.points\[0\]\.extinction is -1"):
        read(session, "bad.toml", "points = [[1, [0, 0, 0], -1]]")
    with pytest.raises(al.FileError, match=r"^bad\.toml is no sound TOML"):
        read(session, "bad.toml", "points =")
    with pytest.raises(al.FileError, match="no TOML or JSON"):
        read(session, "../secret.py", "")


def test_channels_are_named_and_mixed() -> None:
    volume = al.Volume(np.random.default_rng(2).random((3, 8, 8, 8)), channel_names=["red", "green", "blue"])
    session = asked(volume)
    assert named(session) == {"names": ["red", "green", "blue"]}
    assert [part["channel"] for part in mixture(session)["transfer"]["channels"]] == [0, 1, 2]
    assert [part["channel"] for part in mixture(session, channels=[2])["transfer"]["channels"]] == [2]


def labelled(count: int = 300_000) -> Any:
    ids = np.minimum(np.arange(72**3, dtype=np.int32), count - 1).reshape(72, 72, 72)
    labels = al.Labels(ids, {7: "red"}, names={7: "liver", 8: "left kidney", 80: "right kidney"})
    return Asked(al.Layer(al.Volume(np.zeros((72, 72, 72), dtype=np.float32)), RAMP, labels=labels))


def test_very_many_labels_come_by_pages() -> None:
    session = labelled()
    found = page(session, start=5, count=4)
    assert (found["total"], found["found"], len(found["rows"])) == (300_000, 300_000, 4)
    assert found["rows"][2] == {
        "label": "7",
        "name": "liver",
        "colour": [1.0, 0.0, 0.0],
        "opacity": 1.0,
        "own": True,
        "visible": True,
        "highlighted": False,
        "background": False,
    }
    assert [row["label"] for row in page(session, search="KIDNEY")["rows"]] == ["8", "80"]
    assert page(session, search="2999")["found"] == 1 + 10 + 100  # 2999, 2999x, 2999xx
    assert page(session, start=299_999)["rows"][0]["label"] == "299999"
    assert len(page(session, count=10**9)["rows"]) == 500


def test_what_is_hidden_is_short_text() -> None:
    session = labelled()
    assert shown(session, "only", labels=["7"]) == {"hidden": "0-6,8-299999", "highlighted": ""}
    assert shown(session, "hide", labels=["3", "4"])["hidden"] == "3-4"
    assert shown(session, "highlight", labels=["9"]) == {"hidden": "", "highlighted": "9"}
    for wrong in ({"change": "burn"}, {"change": "hide", "labels": ["x"]}):
        with pytest.raises(al.ValueRangeError):
            shown(session, **wrong)


@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e4))
def test_a_window_is_where_it_was_put(centre: float, width: float) -> None:
    moved = windowed(RAMP, centre, width)
    assert window_of(moved) == pytest.approx((centre, width), rel=1e-6, abs=1e-6)
    back = windowed(moved, *window_of(RAMP))
    assert isinstance(back, al.TransferFunction)
    np.testing.assert_allclose(back.values, RAMP.values, atol=1e-4)
    np.testing.assert_array_equal(back.extinctions, RAMP.extinctions)


def test_windows_of_steps_mixtures_and_others() -> None:
    single = al.TransferFunction([(5, "white", 1)])
    assert window_of(windowed(single, 9, 100)) == (9, 0)
    assert window_of(windowed(RAMP, 3, 0))[1] > 0
    mixed = windowed(al.Channels({0: PLAIN, 1: PLAIN.shifted(100)}), 0, 20)
    assert isinstance(mixed, al.Channels)
    assert [part.transfer.domain for part in mixed.parts] == [(-10, 0), (0, 10)]
    joint = al.JointFunction([al.joint.Axis("value", 0, 1), al.joint.Axis("gradient", 0, 1)], [])
    with pytest.raises(al.ValueRangeError, match="JointFunction"):
        window_of(joint)
