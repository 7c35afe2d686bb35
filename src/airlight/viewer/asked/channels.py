"""Channels of a volume: their names, and a mixture of them that is chosen from the data."""

from __future__ import annotations

from typing import Any

from ...first_picture import automatic_channels
from ..asking import answers
from ..session import Session
from .probe import layer_numbered


@answers("channels")
def named(session: Session, layer: int = 0) -> dict[str, Any]:
    """Names of all channels of a layer's volume; their numbers where the file names none."""
    volume = layer_numbered(session, layer).volume
    names = list(volume.channel_names) or [f"channel {n}" for n in range(volume.channel_count)]
    return {"names": names}


@answers("channels.mixture")
def mixture(session: Session, layer: int = 0, channels: list[int] | None = None) -> dict[str, Any]:
    """A mixture of some channels, by number, or of all, each in a colour of its own."""
    shown = layer_numbered(session, layer)
    chosen: dict[int | str, Any] | None = None if channels is None else dict.fromkeys(channels)
    return {"transfer": automatic_channels(shown.volume, chosen, shown.time).to_dict()}
