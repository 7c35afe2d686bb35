"""Fields of several channels, four to a vector: they stand in for those of one channel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..stage import Context, Mat4f, Vec4f, param
from ..transfer.channels import ENDLESS, Channels, Slope
from ..volume import FloatArray, Statistics, statistics
from .field import Field, Linear, LinearExact, Nearest, needed_groups
from .field_labels import are_alone

MARKED = -ENDLESS


@dataclass(frozen=True, eq=False)
class ChannelsUniforms:
    """Where groups of four channels lie in the texture, and the line that stands for each channel in gradients.

    Matrices have a column for each group of a value, and in it a row for each channel of the group.
    """

    stacked: Vec4f = param((0.0, 1.0, 2.0, 3.0))
    weight: Mat4f = param(None, unit="1/data")
    low: Mat4f = param(None, unit="data")
    high: Mat4f = param(None, unit="data")
    nothing: Mat4f = param(None, unit="data")


class OfChannels(Field):
    """Base of the fields of several channels.

    Gradients are taken of one number: of a mixture a weighted sum (see ``Channels.slopes``), else the first channel.
    """

    uniform_type: ClassVar[type] = ChannelsUniforms

    def uniforms(self, context: Context) -> Any:
        """Return the places of the groups and the lines of their channels."""
        return ChannelsUniforms(**channels_values(context))

    def for_channels(self) -> Field:
        """Return the field itself."""
        return self


def channels_values(context: Context) -> dict[str, Any]:
    """Members of ``ChannelsUniforms``: the places of the groups and the lines of their channels."""
    stacked, lines = needed_groups(context), lines_of(context)
    parts = {
        name: by_group({lane: getattr(line, name) for lane, line in lines.items()})
        for name in ("weight", "low", "high", "nothing")
    }
    a, b, c, d = (float(g) for g in (*stacked, 0, 0, 0)[:4])
    return {"stacked": (a, b, c, d), **parts}


def lanes_of(context: Context) -> tuple[int, ...]:
    """Where the visible channels of a mixture lie in a value, four to a group."""
    groups = needed_groups(context)
    return tuple(4 * groups.index(place // 4) + place % 4 for place in context.transfer.places(context.volume))


def lines_of(context: Context) -> dict[int, Slope]:
    """Line of each place of a value that gradients are made of."""
    if isinstance(context.transfer, Channels):
        return dict(zip(lanes_of(context), context.transfer.slopes, strict=True))
    return {0: Slope(1.0, nothing=MARKED)}


def by_group(lanes: dict[int, float], other: float = 0.0) -> FloatArray:
    """Matrix of a number for each place of a value: a column for each group."""
    matrix = np.full(16, other)
    for lane, number in lanes.items():
        matrix[lane] = number
    return matrix.reshape(4, 4).T


def scalar_range(context: Context, known_low: str | float, known_high: str | float) -> float:
    """Range of the number that gradients are taken of: the greatest of the channels' own.

    Ends are percentiles, or ``"minimum"`` and ``"maximum"``.
    """
    if are_alone(context.labels, context.volume):
        return 1.0
    if not isinstance(context.transfer, Channels):
        known = statistics(context.volume, context.channel, context.time)
        return _end(known, known_high) - _end(known, known_low)
    ranges = []
    for part, line in zip(context.transfer.visible, context.transfer.slopes, strict=True):
        known = statistics(context.volume, part.channel, context.time)
        low, high = (float(np.clip(_end(known, end), line.low, line.high)) for end in (known_low, known_high))
        ranges.append(abs(line.weight) * (high - low))
    return max(ranges)


def _end(known: Statistics, end: str | float) -> float:
    return float(getattr(known, end)) if isinstance(end, str) else known.percentile(end)


@dataclass(frozen=True)
class NearestChannels(OfChannels, Nearest):
    """The values of the nearest voxel."""

    name: ClassVar[str] = "nearest_channels"

    def for_empty(self) -> Field:
        """Return the nearest field over marked samples."""
        return NearestChannelsMasked()


@dataclass(frozen=True)
class LinearChannels(OfChannels, Linear):
    """Trilinear interpolation by the texture unit."""

    name: ClassVar[str] = "linear_channels"
    wgsl: ClassVar[str] = "field/linear_channels.wgsl"

    def for_empty(self) -> Field:
        """Return the linear field over marked samples."""
        return LinearChannelsMasked()


@dataclass(frozen=True)
class LinearExactChannels(OfChannels, LinearExact):
    """Trilinear interpolation in the shader."""

    name: ClassVar[str] = "linear_exact_channels"

    def for_empty(self) -> Field:
        """Return the linear field over marked samples."""
        return LinearChannelsMasked()


@dataclass(frozen=True)
class NearestChannelsMasked(NearestChannels):
    """The values of the nearest voxel, where empty samples of a channel hold nothing."""

    name: ClassVar[str] = "nearest_channels_masked"
    masked = True


@dataclass(frozen=True)
class LinearChannelsMasked(LinearExactChannels):
    """Trilinear interpolation of the samples that are there, channel by channel."""

    name: ClassVar[str] = "linear_channels_masked"
    masked = True
