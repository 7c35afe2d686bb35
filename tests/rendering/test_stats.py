"""What ``image.stats`` says, and when it is computed."""

from __future__ import annotations

import json

import numpy as np
from scenes import SIZE, scene

import airlight as al
from airlight.app.render import plain
from airlight.rendering.stats import Estimates


def test_errors_are_computed_when_they_are_read(renderer, monkeypatch):
    """An edit draws many frames whose errors nobody asks for."""
    asked = []
    monkeypatch.setattr("airlight.stages.transfer.colour_error", lambda *what: asked.append(what) or 0.25)
    image = renderer.render(scene(), SIZE)
    errors = image.stats["layers"][0]["errors"]
    assert list(errors) == ["transfer: colour of a slab"]
    assert not asked
    assert errors["transfer: colour of a slab"] == 0.25
    assert errors == {"transfer: colour of a slab": 0.25}
    assert len(asked) == 1
    assert not any(isinstance(thing, al.Volume) for thing in asked[0])


def test_estimates_are_written_as_numbers():
    found = Estimates({"a": lambda: np.float64(0.5), "b": 2.0})
    assert json.loads(json.dumps({"errors": found}, default=plain)) == {"errors": {"a": 0.5, "b": 2.0}}
    assert repr(found) == "{'a': np.float64(0.5), 'b': 2.0}" or repr(found) == "{'a': 0.5, 'b': 2.0}"
