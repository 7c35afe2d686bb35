"""Warm renderers compile nothing while a function is edited."""

from __future__ import annotations

import numpy as np
import pytest

import airlight as al

EDITS = {
    "drag": [(0, "black", 0), (0.51, "red", 1), (1, "white", 2)],
    "anywhere": [(0, "black", 0), (0.523456, "red", 1), (1, "white", 2)],
    "open ends": [(0, "black", 0.5), (0.523456, "red", 1), (1, "white", 2)],
    "open and even": [(0, "black", 0.5), (0.5, "red", 1), (1, "white", 2)],
    "closed": [(0, "black", 0), (0.5, "red", 1), (1, "white", 0)],
    "closed, anywhere": [(0, "black", 0), (0.523456, "red", 1), (1, "white", 0)],
    "empty within": [(0, "red", 1), (0.25, "red", 0), (0.5, "red", 0), (1, "white", 1)],
    "empty within, anywhere": [(0, "red", 1), (0.25, "red", 0), (0.523456, "red", 0), (1, "white", 1)],
    "empty before, open behind": [(0, "red", 0), (0.5, "red", 0), (1, "white", 1)],
    "opaque step": [(0, "red", 0), (0.5, "red", 90), (0.5, "blue", 90), (1, "white", 0)],
    "opaque step, open ends": [(0, "red", 1), (0.5, "red", 90), (0.5, "blue", 90), (1, "white", 1)],
    "opaque step, empty within": [(0, "red", 1), (0.2, "red", 0), (0.5, "blue", 0), (0.5, "blue", 90), (1, "white", 1)],
}


@pytest.mark.parametrize("transfer", ["preintegrated", "postclassified"])
def test_edits_compile_nothing(transfer):
    volume = al.Volume(np.random.default_rng(0).random((8, 8, 8), dtype=np.float32))
    look = al.Look(transfer=transfer)

    def scene(points) -> al.Scene:
        return al.Scene(volume, transfer=al.TransferFunction(points), look=look)

    with al.Renderer() as renderer:
        renderer.warm_up(scene(EDITS["drag"]))

        def programs() -> set[object]:
            return renderer._thread.submit(lambda job: {key for key in renderer._device.kept if key[0] == "pipeline"}).result()

        warm = programs()
        for name, points in EDITS.items():
            renderer.render(scene(points), (8, 8))
            assert programs() == warm, name


def test_without_a_scene_it_opens_the_device():
    with al.Renderer() as renderer:
        renderer.warm_up()
        assert renderer.kept_bytes == 0
        assert renderer._device is not None
