"""Colours: linear-light Rec. 709 inside; sRGB where users write words and where images are saved or shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError

Colour = str | Sequence[float]


def srgb_to_linear(srgb: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Linear light of sRGB-encoded values in [0, 1] (IEC 61966-2-1)."""
    v = np.asarray(srgb, dtype=np.float64)
    return np.where(v <= 0.04045, v / 12.92, ((np.maximum(v, 0.04045) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(linear: npt.ArrayLike) -> npt.NDArray[Any]:
    """Encode linear light for sRGB displays (IEC 61966-2-1); what lies outside of [0, 1] is clipped. Keeps float32."""
    v = np.clip(np.asarray(linear), 0.0, 1.0)
    encoded: npt.NDArray[Any] = np.where(v <= 0.0031308, v * 12.92, 1.055 * np.maximum(v, 0.0031308) ** (1 / 2.4) - 0.055)
    return encoded


def linear_rgb(colour: Colour, where: str = "colour") -> tuple[float, float, float]:
    """Linear light of a colour: tuples are linear already, names and ``#rrggbb`` are sRGB and are decoded.

    Raises
    ------
    ValueRangeError
        For unknown names, and tuples that are not three finite numbers of at least zero.
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
    return float(parts[0]), float(parts[1]), float(parts[2])
