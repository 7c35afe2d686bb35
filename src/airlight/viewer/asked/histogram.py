"""The histogram behind the curve: how many samples of a layer have which value."""

from __future__ import annotations

from typing import Any

from ...transfer.histogram import JointHistogram, joint_histogram
from ...volume import Volume
from ..asking import answers
from ..layers import channel_in
from ..session import Session
from .probe import layer_numbered

BINS = 1024


@answers("histogram", slow=True)
def histogram(session: Session, layer: int = 0, part: int | None = None) -> dict[str, Any]:
    """Counts of the values of a layer's channel, or of that of a part of its mixture, at its time step.

    The axis holds all but outliers, which are counted as ``outside``; NaN and no-data are ``empty``.
    """
    shown = layer_numbered(session, layer)
    found = counted(shown.volume, channel_in(shown, part), shown.time)
    (axis,) = found.axes
    told = {"counts": found.counts.tolist(), "low": axis.low, "high": axis.high}
    return told | {"outside": found.outside, "empty": found.empty, "unit": found.units[0]}


def counted(volume: Volume, channel: int, time: int) -> JointHistogram:
    """Histogram of one channel at one time step; counted once and kept with the volume."""
    cache: dict[tuple[int, int], JointHistogram] = volume.__dict__.setdefault("_value_histograms", {})
    if (channel, time) not in cache:
        cache[channel, time] = joint_histogram(volume, ("value",), BINS, channel, time)
    return cache[channel, time]
