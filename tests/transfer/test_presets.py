"""Presets: sound functions in their units, whatever the unit of the world."""

from __future__ import annotations

import numpy as np
import pytest

from airlight.errors import ValueRangeError
from airlight.transfer import presets
from airlight.volume import Volume, statistics

GRID = np.linspace(-1000, 1500, 24**3).reshape(24, 24, 24)


@pytest.mark.parametrize("name", presets.names())
def test_presets_are_sound(name):
    volume = Volume(GRID, spacing=(2, 2, 2), units="mm")
    tf = presets.get(name, volume)
    assert tf.extinctions[0] == 0
    assert tf.extinctions.max() > 0
    assert (np.diff(tf.values) > 0).all()
    assert tf.domain[1] <= 1500
    # The same body in metres looks the same.
    in_metres = presets.get(name.replace("_", "-"), Volume(GRID, spacing=(0.002,) * 3, units="m"))
    assert in_metres.values.tolist() == tf.values.tolist()
    np.testing.assert_allclose(in_metres.extinctions, 1000 * tf.extinctions)
    assert presets.describe(name)


def test_presets_by_colour_maps():
    volume = Volume(GRID, units="mm")
    tf, known = presets.get("microscopy_green", volume), statistics(volume)
    assert (tf.colours[:, [0, 2]] < 0.3).all()
    assert tf.domain == pytest.approx([known.percentile(p) for p in presets.ROBUST_PERCENT])
    assert presets.glowing("cmocean:ice", volume) == presets.get("microscopy_ice", volume)


def test_unknown_names():
    with pytest.raises(ValueRangeError, match="preset is 'bone', must be one of ct_bone, "):
        presets.get("bone", Volume(GRID))
