"""``--layer``, made into values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ..errors import ValueRangeError
from ..scene import Layer, Look
from ..transfer import presets
from .inputs import open_named
from .meshes import file_and_options
from .parse import parse_transfer
from .progress import ProgressBar

OPTION = "--layer"
FUNCTIONS = ("tf", "preset", "colormap")
OPTIONS = (*FUNCTIONS, "density", "channel", "time")


def parse_layer(text: str) -> tuple[str, dict[str, Any]]:
    """File and options of ``pet.nii.gz:colormap=inferno,density=0.5``.

    Raises
    ------
    ValueRangeError
        For options that there are none of, and several functions.
    """
    name, options = file_and_options(text, OPTION, "pet.nii.gz:colormap=inferno,density=0.5")
    for key in options:
        if key not in OPTIONS:
            raise ValueRangeError(f"{OPTION}.{key}", "is unknown", "use " + ", ".join(OPTIONS))
    given = [key for key in FUNCTIONS if key in options]
    if len(given) > 1:
        raise ValueRangeError(f"{OPTION}.{given[0]}", f"and {given[1]} exclude each other", "leave one of them out")
    if "tf" in options:
        options["tf"] = parse_transfer(str(options["tf"]))
    return name, options


def open_layers(
    parsed: Iterable[tuple[str, dict[str, Any]]],
    others: Sequence[Layer],
    max_memory: int,
    progress: ProgressBar | None = None,
) -> tuple[Layer, ...]:
    """Layers of files, with the look of the first of the others, if there are any."""
    look, clips = (others[0].look, others[0].clips) if others else (Look(), ())
    layers = []
    for name, options in parsed:
        volume = open_named(name, progress, max_memory=max_memory)
        channel, time = options.get("channel", 0), options.get("time", 0)
        transfer = options.get("tf")
        if "preset" in options:
            transfer = presets.get(str(options["preset"]), volume, channel, time)
        elif "colormap" in options:
            transfer = presets.glowing(str(options["colormap"]), volume, channel, time)
        given = {"density": options.get("density", 1.0), "channel": channel, "time": time, "clips": clips}
        layers.append(Layer(volume, transfer, look, **given))
    return tuple(layers)
