"""Pictures of joint histograms: ticks, labels, and shapes where they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import airlight as al
from airlight.transfer.histogram_picture import LEFT_PX, SIDE_PX, TOP_PX, label, ticks

AXES = al.joint.Axis("value", 0, 100), al.joint.Axis("gradient", 0, 50)


def ramp() -> al.Volume:
    values = np.broadcast_to(np.arange(64.0), (8, 8, 64)).astype(np.float32)
    return al.Volume(values, units="mm", value_unit="HU")


@given(st.floats(-1e6, 1e6), st.floats(1e-4, 1e6))
def test_ticks_are_round_and_within(low, span):
    axis = al.joint.Axis("value", low, low + span)
    if axis.span < 0.5 * span:
        return
    found = [value for value, _ in ticks(axis)]
    assert 2 <= len(found) <= 8
    steps = np.diff(found)
    assert steps == pytest.approx(np.full(len(steps), steps[0]), rel=1e-3)
    mantissa = steps[0] / 10 ** np.floor(np.log10(steps[0] * 1.0001))
    assert min(abs(mantissa - m) for m in (1, 2, 5, 10)) < 0.01
    assert all(axis.low - 1e-9 * abs(low) - 1e-9 <= v <= axis.high + 1e-9 * abs(low) + 1e-9 for v in found)


def test_ticks_are_written_with_the_digits_that_they_need():
    assert [text for _, text in ticks(al.joint.Axis("value", 0, 255))] == ["0", "50", "100", "150", "200", "250"]
    assert [text for _, text in ticks(al.joint.Axis("value", -0.3, 0.31))][:3] == ["-0.2", "0.0", "0.2"]
    assert [text for _, text in ticks(al.joint.Axis("value", 0, 3e-9))][1] == "5e-10"


def test_labels_name_variables_and_units():
    found = al.joint.histogram(ramp(), ("value", "gradient", "second"), bins=8)
    assert [label(found, n) for n in range(3)] == ["value (HU)", "gradient (HU/mm)", "second derivative (HU/mm²)"]
    bare = al.joint.histogram(al.Volume(np.stack([np.mgrid[:4, :4, :4][0]] * 2)), (0, 1), bins=8)
    assert label(bare, 1) == "channel 1"


def test_counts_and_shapes_lie_where_the_axes_say():
    """All gradients are 1: one row is bright, at 1/50 of the height; a box covers its part of the plot and no more."""
    found = al.joint.histogram(ramp(), AXES, bins=128)
    function = al.JointFunction(AXES, [al.joint.Box((50, 25), (75, 50), colour="red")])
    plain, over = (
        image[TOP_PX : TOP_PX + SIDE_PX, LEFT_PX : LEFT_PX + SIDE_PX].astype(int)
        for image in (found.picture(), found.picture(function))
    )
    rows = np.flatnonzero((plain.sum(axis=-1) > 200).any(axis=1))
    assert (SIDE_PX - rows.mean()) / SIDE_PX * 50 == pytest.approx(1, abs=0.4)
    changed = np.argwhere((plain != over).any(axis=-1))
    assert changed.min(axis=0).tolist() == [0, SIDE_PX // 2]
    assert changed.max(axis=0).tolist() == [SIDE_PX // 2 - 1, SIDE_PX * 3 // 4 - 1]


def test_shapes_of_three_variables_are_seen_through_the_third():
    axes = (*AXES, al.joint.Axis("second", -5, 5))
    found = al.joint.histogram(ramp(), axes, bins=16)
    function = al.JointFunction(axes, [al.joint.Ellipse((50, 25, 3), (20, 10, 1.5))])
    assert (found.picture(function) != found.picture()).any(axis=-1).sum() > 0.2 * 0.4 * 0.4 * SIDE_PX**2


def test_files(tmp_path):
    found = al.joint.histogram(ramp(), AXES, bins=16)
    found.save(tmp_path / "h.png")
    assert (tmp_path / "h.png").read_bytes() == found._repr_png_()
    with pytest.raises(al.FileError, match=r"is no PNG file: end its name in \.png"):
        found.save(tmp_path / "h.jpg")
    with pytest.raises(al.FileError, match="cannot be written"):
        found.save(tmp_path / "absent" / "h.png")
    other = al.JointFunction((AXES[0], al.joint.Axis("second", -1, 1)))
    with pytest.raises(al.ValueRangeError, match="looks at value, second, the histogram at value, gradient"):
        found.picture(other)
