"""The kinds of transfer functions that a layer may have."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ..errors import DataError
from ..volume import Volume
from .channels import Channel, Channels
from .function import TransferFunction
from .joint import JointFunction
from .joint_axes import VARIABLES, channel_of
from .regions import ByRegion

AnyFunction = TransferFunction | JointFunction | Channels
DrawnFunction = AnyFunction | ByRegion


def channels_of(function: AnyFunction, volume: Volume, channel: int) -> tuple[int, ...]:
    """Numbers of the channels that are kept for a function; ``channel`` is the layer's own."""
    match function:
        case TransferFunction():
            return (channel,)
        case Channels():
            numbers, visible = function.channels(volume), function.visible
            return numbers if len(visible) > 1 else (volume.channel_index(visible[0].channel),)
        case JointFunction():
            # The layer's own comes first where the function asks for it: gradients are those of the first channel.
            axes = [(v, f"transfer.axes[{number}]") for number, v in enumerate(function.variables) if v not in VARIABLES]
            named = [channel_of(variable, volume, where) for variable, where in axes]
            own = [channel] if len(named) < len(function.variables) else []
            return tuple(dict.fromkeys([*own, *named]))


@lru_cache(maxsize=16)
def drawn_function(function: AnyFunction, density: float = 1.0) -> AnyFunction:
    """Return the function with its extinctions multiplied; of a mixture with one visible channel that channel's own."""
    if isinstance(function, Channels) and len(function.visible) == 1:
        (function,) = function.functions
    return function if density == 1 else function.scaled(density)


def as_function(given: Any) -> Any:
    """Return a sequence of functions as a mixture of the first channels, and all else as it is."""
    if isinstance(given, (tuple, list)):
        if any(isinstance(part, (tuple, list)) for part in given):
            raise DataError("layer.transfer", "is a list of points", "wrap them: airlight.TransferFunction(points)")
        return Channels([Channel(number, function) for number, function in enumerate(given)])
    return given
