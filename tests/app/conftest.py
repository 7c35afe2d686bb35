"""A small volume in a file, and a renderer that draws nothing but remembers what it was asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fake_renderer import Drawn

import airlight.io
from airlight import api
from airlight.volume import Volume


@pytest.fixture
def volume_file(tmp_path: Path) -> str:
    z, y, x = np.mgrid[-1:1:12j, -1:1:14j, -1:1:16j]
    ball = (1000 * np.exp(-3 * (x * x + y * y + z * z))).astype(np.int16)
    path = tmp_path / "ball.nrrd"
    volume = Volume(np.stack([ball, 1000 - ball]), spacing=(1, 1, 2), units="mm", value_unit="HU", channel_names=("in", "out"))
    airlight.io.save(volume, path)
    return str(path)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Drawn:
    calls = Drawn()
    monkeypatch.setattr(api, "render", calls)
    monkeypatch.setattr(api, "warm_up", lambda device=None: None)
    return calls
