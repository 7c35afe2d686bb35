"""Lights, layers and scenes of what they cannot be made of: errors that name the parameter."""

from __future__ import annotations

import math

import numpy as np
import pytest

import airlight as al
from airlight import Light
from airlight.errors import AirlightError

VOLUME = al.Volume(np.zeros((3, 3, 3), np.float32))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: al.Scene(layers=[VOLUME]), "scene.layers holds a Volume"),
        (lambda: al.Scene(layers=al.Layer(VOLUME)), "scene.layers is .* must be a list"),
        (lambda: al.Scene(layers=[]), "scene.layers is empty"),
        (lambda: al.Scene(VOLUME, camera=None), "scene.camera is None, must be a Camera or one of front"),
        (lambda: al.Scene(VOLUME, camera=["front"]), "scene.camera"),
        (lambda: al.Scene(VOLUME, lights=Light.head()), "scene.lights is .* must be a list: pass lights="),
        (lambda: al.Scene(VOLUME, lights=["head"]), "scene.lights holds 'head'"),
        (lambda: Light.point(position=("a", 1, 2)), r"light.position\[0\] is 'a', must be a finite number"),
        (lambda: Light.point(position=(1, 2)), "light.position"),
        (lambda: Light.point(position=(1, 2, 3), radius="x"), "light.radius is 'x'"),
        (lambda: Light.point(position=(1, 2, 3), radius=0), "light.radius is 0, must be above 0"),
        (lambda: Light.head(intensity="x"), "light.intensity is 'x', must be a finite number"),
        (lambda: Light.head(intensity=-1), "light.intensity is -1, must be at least 0"),
        (lambda: Light.directional(to_light=(0, 0, 0)), "light.to_light is .* must be a finite direction"),
        (lambda: Light.directional(to_light=("a", 0, 0)), "light.to_light"),
        (lambda: Light.directional(to_light=None), "light.to_light is None"),
        (lambda: Light("directional", (0, 0, 0)), "light.to_light is .* must be a finite direction"),
        (lambda: Light("head", colour=(-1, 0, 0)), "light.color is .* must be three finite numbers of at least 0"),
        (lambda: Light("lamp"), "light.kind is 'lamp'"),
        (lambda: al.Renderer(keep_bytes="x"), "keep_bytes is 'x', must be a whole number of at least 0"),
        (lambda: al.Renderer(keep_bytes=-1), "keep_bytes is -1"),
        (lambda: al.relight(None, al.Scene(VOLUME)), "image is a NoneType: pass what airlight.render returned"),
    ],
)
def test_what_they_cannot_be_made_of(make, words):
    with pytest.raises(AirlightError, match=words):
        make()


def test_lights_are_values():
    """Lists and arrays become tuples, directions get length one, equal lights are one."""
    given = Light("directional", [0, 0, 2], np.array([1, 0.5, 0]), 2)
    assert given == Light.directional(to_light=np.array([0, 0, 5.0]), color=(1, 0.5, 0), intensity=2)
    assert len({given, Light("directional", (0.0, 0.0, 1.0), (1.0, 0.5, 0.0), 2.0)}) == 1
    assert given.vector == (0, 0, 1)
    assert isinstance(given.intensity, float)
    third = math.sqrt(1 / 3)
    assert Light("directional", (third, third, third)).vector == (third, third, third)
