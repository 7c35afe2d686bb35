"""Transfer functions, colours, and the tables that are made of them in float64."""

from __future__ import annotations

from .channels import Channel, Channels
from .colormaps import colormap_names
from .colour import linear_rgb, linear_to_srgb, srgb_to_linear
from .function import TransferFunction
from .joint import JointFunction
from .opacity import extinction_from_opacity, opacity_from_extinction
from .surfaces import Surface

__all__ = [
    "Channel",
    "Channels",
    "JointFunction",
    "Surface",
    "TransferFunction",
    "colormap_names",
    "extinction_from_opacity",
    "linear_rgb",
    "linear_to_srgb",
    "opacity_from_extinction",
    "srgb_to_linear",
]
