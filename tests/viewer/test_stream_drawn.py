"""The stream of a small volume: what is sent at rest is the picture, bit for bit, and it is refined until it is right."""

from __future__ import annotations

import io

import numpy as np
import pytest
from fake_drawing import Watching, eventually
from PIL import Image as Pillow

import airlight as al
from airlight.benchmark.measure import psnr
from airlight.viewer import stream
from airlight.viewer.document import Document
from airlight.viewer.session import Viewer

SIZE_PX = (48, 32)


@pytest.fixture
def watching(renderer, monkeypatch):
    z, y, x = np.mgrid[-1:1:16j, -1:1:16j, -1:1:16j]
    volume = al.Volume(np.exp(-3 * (x * x + y * y + z * z)).astype(np.float32))
    function = al.TransferFunction([(0, (0, 0, 0), 0.0), (0.3, (1, 0.5, 0.2), 0.1), (1, (1, 1, 1), 1.0)])
    scene = al.Scene(volume, transfer=function, camera="iso", look=al.Look(shade="none"))
    monkeypatch.setattr(stream, "scenes_near", lambda scene: iter([scene]))  # eight programs, which this test has no use for
    viewer = Viewer(Document(scene, tolerance=0.02), renderer=renderer)
    yield Watching(viewer.session(), size_px=SIZE_PX)
    viewer.close()


def test_what_is_sent(watching, renderer):
    eventually(lambda: watching.last.get("tolerance_reached"), 60)
    first, full, *refined = watching.of("frame")
    pixels = [np.asarray(Pillow.open(io.BytesIO(data))) for data in watching.buffers]
    document = watching.session.document
    assert np.array_equal(pixels[1], renderer.render(document.scene, SIZE_PX).picture())
    enlarged = np.asarray(Pillow.fromarray(pixels[0]).resize(SIZE_PX, Pillow.Resampling.BILINEAR), dtype=np.float64)
    assert psnr(float(np.sqrt(((enlarged - pixels[1]) ** 2).mean())) / 255) > 25
    assert (first["kind"], first["drawn_px"], full["kind"], full["drawn_px"]) == ("jpeg", [24, 16], "png", [48, 32])
    assert full["stats"]["milliseconds"]["march"] > 0
    assert refined[-1]["stats"]["tolerance"]["pixels_over"] == 0
    right = renderer.render(document.scene, SIZE_PX, tolerance=0.02).picture()
    assert np.array_equal(pixels[-1], right)

    count = len(watching.of("frame"))
    watching.turn(0.1)
    eventually(lambda: watching.last["final"] and len(watching.of("frame")) > count)
    turned = watching.of("frame")[count:]
    assert not turned[0]["final"]
    assert turned[0]["camera"] == turned[-1]["camera"] != full["camera"]
    assert not watching.of("error")
