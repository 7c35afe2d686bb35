"""Which channel of a layer, and which part of a mixture, a question is about."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..scene import Layer, Scene
from ..transfer import Channels, TransferFunction
from ..transfer.given import whole
from ..transfer.kinds import AnyFunction


def channel_in(layer: Layer, part: Any = None) -> int:
    """Return the number of a layer's channel, or of the channel of a part of its mixture."""
    if part is None or not isinstance(layer.transfer, Channels):
        return layer.volume.channel_index(layer.channel)
    return layer.volume.channel_index(layer.transfer.parts[_checked(layer.transfer, part)].channel)


def function_in(layer: Layer, part: Any = None) -> AnyFunction:
    """Return the transfer function of a layer, or of a part of its mixture."""
    assert layer.transfer is not None
    if part is None or not isinstance(layer.transfer, Channels):
        return layer.transfer
    return layer.transfer.parts[_checked(layer.transfer, part)].transfer


def with_function(scene: Scene, layer: int, part: Any, function: TransferFunction) -> Scene:
    """Return a scene with another function for a layer, or for a part of its mixture."""
    given = scene.layers[layer].transfer
    if part is not None and isinstance(given, Channels):
        place = _checked(given, part)
        changed: AnyFunction = Channels([replace(p, transfer=function) if n == place else p for n, p in enumerate(given.parts)])
    else:
        changed = function
    layers = tuple(replace(one, transfer=changed) if n == layer else one for n, one in enumerate(scene.layers))
    return replace(scene, layers=layers)


def _checked(mixture: Channels, part: Any) -> int:
    return whole(part, "part", 0, len(mixture.parts) - 1)
