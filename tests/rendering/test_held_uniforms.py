"""Uniforms that entry points hold in variables: the same picture, and only where each look at one costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import airlight as al
from airlight.pages.device import PageDevice
from airlight.rendering.frame import Request, prepare
from airlight.rendering.march import march_program
from airlight.rendering.ways import draw_frame
from airlight.shader.program import build_program

SIZE_PX = (24, 20)
BEAMS = tuple(al.Light.directional(to_light=v) for v in ((1.0, 0.5, 0.2), (-0.4, 1.0, 0.3), (0.0, -1.0, 1.0)))


def mixed() -> al.Scene:
    """Five channels, each with a function of its own, under three lights."""
    values = np.random.default_rng(3).random((5, 9, 10, 11)).astype(np.float32)
    colours = ["red", "lime", "blue", "cyan", "white"]
    mixture = al.Channels({n: al.TransferFunction([(0.3, "black", 0.0), (1.0, c, 0.8)]) for n, c in enumerate(colours)})
    return al.Scene(al.Volume(values), transfer=mixture, lights=BEAMS)


def drawn(device, scene: al.Scene, driver: al.Driver) -> tuple[np.ndarray, ...]:
    return draw_frame(prepare(device, scene, Request(SIZE_PX, driver, 0.7), lambda: None, lambda *_: None))[:2]


@pytest.mark.parametrize("driver", [al.driver.March(), al.driver.Slices()])
def test_pictures_are_the_same(device, monkeypatch, driver):
    here, other = device.traits, replace(device.traits, holds_uniforms=not device.traits.holds_uniforms)
    found = []
    for traits in (here, other):
        monkeypatch.setitem(device.__dict__, "traits", traits)
        found.append(drawn(device, mixed(), driver))
    for one, two in zip(*found, strict=True):
        np.testing.assert_array_equal(one, two)


def test_software_holds_them_and_pages_do_not(device):
    frame = prepare(device, mixed(), Request(SIZE_PX, al.driver.March(), 0.7), lambda: None, lambda *_: None)
    key = march_program(frame).key
    texts = {
        holds: build_program(replace(key, traits=replace(key.traits, holds_uniforms=holds))).linked.text
        for holds in (True, False)
    }
    assert "var<private> uniforms: Uniforms;" in texts[True]
    assert "lights = given_lights;" in texts[True]
    assert "given_" not in texts[False]
    assert device.traits.holds_uniforms == (device.info.kind == "software")
    assert not PageDevice.traits.holds_uniforms
