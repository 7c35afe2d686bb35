"""Names and short forms of the public page."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import airlight as al


def test_modules_of_the_package_of_functions_are_imported_by_their_names() -> None:
    """``al.transfer`` is the module of the stages, and bears the name of the package of functions."""
    code = """
import airlight.transfer.presets as presets
import airlight.transfer.colormaps as colormaps
import airlight as al
assert presets is al.presets
assert callable(colormaps.colormap_names)
assert al.transfer.PreIntegrated().name == "preintegrated"
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_names_that_are_nowhere_are_attribute_errors() -> None:
    with pytest.raises(AttributeError, match="no attribute 'PreIntegrate'"):
        al.transfer.PreIntegrate  # noqa: B018
    assert not hasattr(al.transfer, "__path__")


def test_a_scene_of_one_volume_takes_all_that_its_layer_takes() -> None:
    volume = al.Volume(np.zeros((2, 4, 4, 4)))
    labels = al.Labels(np.ones((4, 4, 4), dtype=np.uint8), {1: "red"})
    given = {"labels": labels, "visible": False, "density": 2.0, "channel": 1, "look": al.Look(shade="none")}
    assert al.Scene(volume, **given).layers == (al.Layer(volume, **given),)
    assert al.Scene(volume, labels=labels.volume.array).layers == (al.Layer(volume, labels=labels.volume.array),)
    for name, value in given.items():
        with pytest.raises(al.DataError, match=f"got layers beside {name}: give it to the layers"):
            al.Scene(layers=[al.Layer(volume)], **{name: value})
