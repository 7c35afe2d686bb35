"""Colours: linear-light Rec. 709 inside; sRGB where users write words and where images are saved or shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError

Colour = str | Sequence[float]

MOST_COLOUR = 16.0
"""Greatest component of colours of media, surfaces and backgrounds; 1 is all of the light, what is beyond it glows."""

PALETTE = ("#56b4e9", "#e69f00", "#009e73", "#f0e442", "#d55e00", "#cc79a7", "#0072b2")
"""sRGB colours of Okabe and Ito (2008), which people with any kind of colour vision tell apart; the darkest comes last."""


def srgb_to_linear(srgb: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Linear light of sRGB-encoded values in [0, 1] (IEC 61966-2-1)."""
    v = np.asarray(srgb, dtype=np.float64)
    return np.where(v <= 0.04045, v / 12.92, ((np.maximum(v, 0.04045) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(linear: npt.ArrayLike) -> npt.NDArray[Any]:
    """Encode linear light for sRGB displays (IEC 61966-2-1); what lies outside of [0, 1] is clipped. Keeps float32."""
    v = np.clip(np.asarray(linear), 0.0, 1.0)
    encoded: npt.NDArray[Any] = np.where(v <= 0.0031308, v * 12.92, 1.055 * np.maximum(v, 0.0031308) ** (1 / 2.4) - 0.055)
    return encoded


def linear_rgb(colour: Colour, where: str = "colour", most: float | None = None) -> tuple[float, float, float]:
    """Linear light of a colour: tuples are linear already, names and ``#rrggbb`` are sRGB and are decoded.

    Raises
    ------
    ValueRangeError
        For unknown names, tuples that are not three finite numbers of at least zero, and those above ``most``.
    """
    if isinstance(colour, str):
        from PIL import ImageColor

        try:
            encoded = ImageColor.getrgb(colour)[:3]
        except ValueError:
            raise ValueRangeError(where, f"is {colour!r}", "use a CSS name, #rrggbb or three linear numbers") from None
        r, g, b = srgb_to_linear(np.asarray(encoded) / 255.0)
        return float(r), float(g), float(b)
    try:
        parts = np.asarray(colour, dtype=np.float64)
    except (TypeError, ValueError):
        parts = np.empty(0)
    if parts.shape != (3,) or not np.isfinite(parts).all() or (parts < 0).any():
        raise ValueRangeError(where, f"is {colour!r}, must be three finite numbers of at least 0")
    if most is not None:
        check_colour(parts, where, most)
    return float(parts[0]), float(parts[1]), float(parts[2])


def check_colour(rgb: npt.ArrayLike, where: str, most: float = MOST_COLOUR) -> None:
    """Refuse what is brighter than a medium can be: 8-bit numbers in the place of linear light.

    Raises
    ------
    ValueRangeError
        Where a component is above ``most``; it says what to write instead.
    """
    parts = np.asarray(rgb, dtype=np.float64)
    if parts.max() <= most * (1 + 1e-9):
        return
    words = ", ".join(f"{part:g}" for part in parts)
    remedy = "1 is all of the light"
    if parts.max() <= 255:
        encoded = "".join(f"{round(part):02x}" for part in parts.tolist())
        remedy = f'write "#{encoded}", which is sRGB, or divide by 255 where these are linear'
    raise ValueRangeError(where, f"is ({words}), must be linear light of at most {most:g}", remedy)
