"""Several channels of a volume, each with a transfer function of its own, as media that lie in one place."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from textwrap import indent
from typing import Any

import numpy as np

from ..errors import ValueRangeError
from ..volume import Volume
from .function import TransferFunction
from .given import flag, listed, not_negative, set_fields
from .saving import Kept

MOST_CHANNELS = 16
ENDLESS = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Channel:
    """One channel of a mixture.

    Parameters
    ----------
    channel
        Number or name.
    transfer
        Its transfer function.
    visible
        Whether it is drawn.
    density
        Factor of its extinctions, at least 0.
    """

    channel: int | str
    transfer: TransferFunction
    visible: bool = True
    density: float = 1.0

    def __post_init__(self) -> None:
        """Check the values."""
        where = f"transfer.channel {self.channel!r}"
        if not isinstance(self.channel, (numbers.Integral, str)) or isinstance(self.channel, bool):
            raise ValueRangeError("transfer.channel", f"is {self.channel!r}, must be a number or a name")
        if not isinstance(self.transfer, TransferFunction):
            raise ValueRangeError(where, f"has a {type(self.transfer).__name__}", "give it a TransferFunction")
        if self.transfer.surfaces:
            raise ValueRangeError(where, "has surfaces of equal value", "they are drawn of one channel, without a mixture")
        channel = self.channel if isinstance(self.channel, str) else int(self.channel)
        visible, density = flag(self.visible, f"{where}: visible"), not_negative(self.density, f"{where}: density")
        set_fields(self, channel=channel, visible=visible, density=density)


@dataclass(frozen=True)
class Slope:
    """A straight line in place of a function's extinction, for the normals of a mixture.

    ``weight`` [1/world/data] times the value, held within ``low`` and ``high``. Its gradient is that of the channel, weighted
    by what the channel does to light, and 0 where the channel is not seen since its value lies before ``nothing``.
    """

    weight: float
    low: float = -ENDLESS
    high: float = ENDLESS
    nothing: float = 0.0


def slope_of(function: TransferFunction) -> Slope:
    """Line from where a function's extinction last is 0 before its maximum, and straight on beyond that.

    Extinction itself would not do: where it is constant there would be no normal, though the value has a gradient.
    """
    strength = function.extinctions
    if function.associated:
        strength = np.maximum(strength, function.colours.max(axis=1))
    values, top, (first, last) = function.values, int(strength.argmax()), function.domain
    most, reach = float(strength[top]), last - first or abs(first) or 1.0
    below, above = np.flatnonzero(strength[:top] == 0), top + np.flatnonzero(strength[top:] == 0)
    if most == 0:
        return Slope(0.0)
    if len(below):
        begin = float(values[below[-1]])
        return Slope(most / (values[top] - begin or reach), low=begin, nothing=begin)
    if len(above):
        begin = float(values[above[0]])
        return Slope(-most / (begin - values[top] or reach), high=begin, nothing=begin)
    rising = strength[-1] >= strength[0]
    return Slope(most / reach if rising else -most / reach, nothing=first if rising else last)


@dataclass(frozen=True)
class Channels(Kept):
    """A mixture of channels in one march: extinctions add, colours are weighted by extinction.

    Parameters
    ----------
    parts
        ``Channel``s, or a mapping from channels to transfer functions; at most 16, and none twice.

    Raises
    ------
    ValueRangeError
        When there are none or too many, when one comes twice, or associated and other functions are mixed.

    Examples
    --------
    >>> import airlight as al
    >>> nuclei = al.TransferFunction([(100, "blue", 0.0), (900, "blue", 0.2)])
    >>> membrane = al.TransferFunction([(80, "lime", 0.0), (500, "lime", 0.1)])
    >>> mixture = al.Channels({"DAPI": nuclei, "GFP": membrane})
    """

    parts: tuple[Channel, ...]

    def __init__(self, parts: Iterable[Channel] | Mapping[int | str, TransferFunction]) -> None:
        if isinstance(parts, Mapping):
            parts = [Channel(channel, transfer) for channel, transfer in parts.items()]
        found = listed(parts, "transfer.channels", "give Channel(number or name, transfer) of each")
        if not all(isinstance(part, Channel) for part in found):
            raise ValueRangeError("transfer.channels", f"holds {found!r}", "give Channel(number or name, transfer)")
        if not 1 <= len(found) <= MOST_CHANNELS:
            raise ValueRangeError("transfer.channels", f"are {len(found)}, must be 1 to {MOST_CHANNELS}")
        names = [part.channel for part in found]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise ValueRangeError("transfer.channels", f"name {twice!r} twice", "add the two functions")
        if len({part.transfer.associated for part in found}) > 1:
            raise ValueRangeError("transfer.channels", "mix associated and other functions", "make all of one kind")
        object.__setattr__(self, "parts", found)

    @cached_property
    def visible(self) -> tuple[Channel, ...]:
        """The parts that are drawn; the first, with no density, where none is."""
        return tuple(part for part in self.parts if part.visible) or (replace(self.parts[0], density=0.0),)

    @cached_property
    def functions(self) -> tuple[TransferFunction, ...]:
        """Functions of the visible parts, with their densities."""
        return tuple(part.transfer if part.density == 1 else part.transfer.scaled(part.density) for part in self.visible)

    def channels(self, volume: Volume) -> tuple[int, ...]:
        """Return the numbers of the channels in a volume, rising: those that are hidden, too, as they may be shown any time.

        Raises
        ------
        DataError
            When the volume has no such channel.
        ValueRangeError
            When two parts name the same one.
        """
        numbers = [volume.channel_index(part.channel) for part in self.parts]
        if len(set(numbers)) < len(numbers):
            raise ValueRangeError("transfer.channels", f"are {numbers} in this volume", "name each channel once")
        return tuple(sorted(numbers))

    def places(self, volume: Volume) -> tuple[int, ...]:
        """Return where the visible parts come among ``channels``."""
        numbers = self.channels(volume)
        return tuple(numbers.index(volume.channel_index(part.channel)) for part in self.visible)

    @cached_property
    def slopes(self) -> tuple[Slope, ...]:
        """What normals are made of: a straight line for each of the ``functions``."""
        return tuple(slope_of(function) for function in self.functions)

    def scaled(self, density: float) -> Channels:
        """Return the mixture with all densities multiplied."""
        return Channels([replace(part, density=part.density * density) for part in self.parts])

    def as_code(self) -> str:
        """Return Python text that makes an equal mixture, where airlight is imported as ``al``."""
        return "\n".join(["al.Channels(", "    [", *(indent(_part_code(part), " " * 8) for part in self.parts), "    ],", ")"])

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as scene files keep it."""
        return {"channels": [_part_to_dict(part) for part in self.parts]}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Channels:
        """Return the mixture that ``to_dict`` wrote.

        Raises
        ------
        ValueRangeError
            For entries that are unknown, missing or not legal; it names them.
        """
        if unknown := sorted(set(data) - {"channels"}):
            raise ValueRangeError("transfer", f"has unknown entries {unknown}", "use channels")
        parts, entries = [], data.get("channels")
        if not isinstance(entries, (list, tuple)) or not all(isinstance(entry, Mapping) for entry in entries):
            raise ValueRangeError("transfer.channels", f"is {entries!r}", "write a list of tables with channel and transfer")
        for number, entry in enumerate(entries):
            where = f"transfer.channels[{number}]"
            if not {"channel", "transfer"} <= set(entry) <= {"channel", "transfer", "visible", "density"}:
                remedy = "give channel and transfer, and visible and density where needed"
                raise ValueRangeError(where, f"has the entries {sorted(entry)}", remedy)
            if not isinstance(entry["transfer"], dict):
                raise ValueRangeError(f"{where}.transfer", f"is {entry['transfer']!r}, must be a table with points")
            try:
                parts.append(Channel(**{**entry, "transfer": TransferFunction.from_dict(entry["transfer"])}))
            except ValueRangeError as error:
                inner = error.where.removeprefix("transfer.") if error.where.startswith("transfer.channel") else error.where
                raise ValueRangeError(f"{where}: {inner}", error.what, error.remedy) from None
        return cls(parts)


def _part_code(part: Channel) -> str:
    rest = [] if part.visible else ["visible=False"]
    rest += [] if part.density == 1 else [f"density={part.density!r}"]
    return "\n".join(
        [
            "al.Channel(",
            f"    {part.channel!r},",
            *(indent(f"{text},", "    ") for text in [part.transfer.as_code(), *rest]),
            "),",
        ]
    )


def _part_to_dict(part: Channel) -> dict[str, Any]:
    data: dict[str, Any] = {"channel": part.channel, "transfer": part.transfer.to_dict()}
    return data | ({} if part.visible else {"visible": False}) | ({} if part.density == 1 else {"density": part.density})
