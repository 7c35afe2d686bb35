"""What ``image.stats`` says, and when it is computed."""

from __future__ import annotations

import dataclasses
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
    assert list(errors) == ["transfer: colour of a slab", "transfer: colour of a shorter slab"]
    assert not asked
    assert errors["transfer: colour of a slab"] == 0.25
    assert len(asked) == 1
    assert set(errors.values()) == {0.25}
    assert len(asked) == 2
    assert not any(isinstance(thing, al.Volume) for thing in asked[0])


def test_estimates_are_written_as_numbers():
    found = Estimates({"a": lambda: np.float64(0.5), "b": 2.0})
    assert json.loads(json.dumps({"errors": found}, default=plain)) == {"errors": {"a": 0.5, "b": 2.0}}
    assert repr(found) == "{'a': np.float64(0.5), 'b': 2.0}" or repr(found) == "{'a': 0.5, 'b': 2.0}"


def test_the_fast_form_tells_what_it_costs(renderer):
    """Beyond thin slabs, and where the two ends of a slab are lit differently, it is not silent."""
    drawn = {depth: scene(transfer="preintegrated_fast") for depth in (1e-3, 1.0)}
    told = {}
    for depth, one in drawn.items():
        layer = dataclasses.replace(one.layers[0], density=depth)
        errors = renderer.render(dataclasses.replace(one, layers=[layer]), SIZE).stats["layers"][0]["errors"]
        told[depth] = [errors[f"transfer: colour of {what}, its medium spread evenly"] for what in ("a slab", "a slab's end")]
    assert max(told[1e-3]) < 1e-3
    assert min(told[1.0]) > 0.01
