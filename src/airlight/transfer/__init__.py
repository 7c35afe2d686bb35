"""Transfer functions, colours, and the tables that are made of them in float64."""

from __future__ import annotations

from .colour import linear_rgb, linear_to_srgb, srgb_to_linear
from .function import TransferFunction

__all__ = ["TransferFunction", "linear_rgb", "linear_to_srgb", "srgb_to_linear"]
