"""Several channels at a glance: each in a colour of its own, lit up where it is bright."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping

import numpy as np

from ..errors import ValueRangeError
from ..scene import Look, Scene
from ..transfer import Channel, Channels, TransferFunction, linear_rgb, srgb_to_linear
from ..transfer.channels import MOST_CHANNELS
from ..transfer.colour import Colour
from ..volume import Volume
from .functions import levels, way_through
from .survey import survey
from .view import chosen_direction, chosen_lights, fitted_camera, visible_points

PAIR = ("#00e600", "#ff28ff")
"""Green and magenta make white, and are told apart by all but very few."""
TRIPLE = ("#00d2ff", "#ff28c8", "#ffdc00")
FULL_AT = 99.5
DEPTHS = (0.0, 6.0, 20.0, 50.0)
MEAN_DEPTH = 0.4
SHADES = (0.4, 0.6, 0.85, 1.0)


def automatic_channels(
    volume: Volume, colours: Mapping[int | str, Colour | None] | None = None, time: int = 0, *, density: float = 1.0
) -> Channels:
    """Return a mixture of channels, each with a function chosen from its data, in one colour.

    A channel begins to be seen where its object does, or above its background, and has its full colour from its 99.5th
    percentile of what lies above on. The mean optical depth of a channel is at most 0.4 on the way through the volume.

    Parameters
    ----------
    volume
        Whose channels.
    colours
        Channels, by number or name, and their colours: linear tuples or sRGB words; None chooses them. Without ``colours`` all
        channels are taken, in colours that are easily told apart.
    time
        Time step from which the functions are chosen.
    density
        Factor of all extinctions.

    Raises
    ------
    ValueRangeError
        When there are more than 16 channels.
    DataError
        When the volume has no such channel.

    Examples
    --------
    >>> import airlight as al, numpy as np
    >>> volume = al.Volume(np.random.default_rng(0).random((2, 8, 8, 8)), channel_names=["DAPI", "GFP"])
    >>> mixture = al.automatic_channels(volume, {"GFP": "lime", "DAPI": None})
    """
    if colours is None and volume.channel_count > MOST_CHANNELS:
        found = f"are {volume.channel_count}; a mixture holds at most {MOST_CHANNELS}"
        raise ValueRangeError("channels", found, "name those that are wanted")
    chosen = dict.fromkeys(range(volume.channel_count)) if colours is None else dict(colours)
    parts = [
        Channel(channel, _function(volume, channel, time, own if colour is None else colour))
        for (channel, colour), own in zip(chosen.items(), channel_colours(len(chosen)), strict=True)
    ]
    mixture = Channels(parts)
    return mixture if density == 1 else mixture.scaled(density)


def channels_picture(volume: Volume, mixture: Channels, size_px: tuple[int, int], time: int) -> Scene:
    """Return the scene that shows a mixture: a view of all that any of its channels shows, glowing by itself."""
    shown = mixture.visible
    points = [visible_points(volume, part.transfer, survey(volume, part.channel, time)) for part in shown]
    to_eye, up = chosen_direction(np.concatenate(points), volume, survey(volume, shown[0].channel, time))
    camera = fitted_camera(np.concatenate(points), to_eye, up, size_px[0] / size_px[1])
    look, lights = Look(shade="none"), chosen_lights(to_eye, up)
    return Scene(volume, transfer=mixture, look=look, time=time, camera=camera, lights=lights)


def channel_colours(count: int) -> tuple[tuple[float, float, float], ...]:
    """Linear colours of so many channels: pairs and triples of complements, else hues round the circle."""
    if count == 1:
        return ((1.0, 1.0, 1.0),)
    if count <= 3:
        return tuple(linear_rgb(word) for word in (PAIR if count == 2 else TRIPLE))
    found = []
    for number in range(count):
        saturation = 1.0 if count <= 8 or number % 2 == 0 else 0.55
        r, g, b = srgb_to_linear(colorsys.hsv_to_rgb(number / count, saturation, 1.0))
        found.append((float(r), float(g), float(b)))
    return tuple(found)


def _function(volume: Volume, channel: int | str, time: int, colour: Colour) -> TransferFunction:
    rgb = np.array(linear_rgb(colour, "channels.colour"))
    found = survey(volume, channel, time)
    low = found.begin
    above = found.values[found.values > low]
    high = float(np.percentile(above, FULL_AT)) if above.size else found.known.maximum
    if high <= low:
        low, high = found.known.minimum, found.known.maximum
    at = levels(low, high, len(DEPTHS) - 1)
    # What is everywhere must be thin, or it hides all else.
    mean = float(np.interp(found.values, at, DEPTHS).mean()) if found.values.size else 0.0
    thinned = min(1.0, MEAN_DEPTH / max(mean, 1e-9)) / way_through(volume)
    points = zip(at, SHADES, DEPTHS, strict=True)
    return TransferFunction([(float(v), tuple(shade * rgb), thinned * depth) for v, shade, depth in points])
