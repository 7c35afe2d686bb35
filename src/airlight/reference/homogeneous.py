"""Media, and slabs that are the same all along: closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..volume import FloatArray
from .setup import Sent


def source_and_extinction(function: Any, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Source (..., 3) and extinction (...) [1/world] of a function at values; it is evaluated once for both."""
    rgb, extinction = function(values)
    return (rgb if function.associated else rgb * extinction[..., None]), extinction


@np.errstate(under="ignore")
def homogeneous(source: FloatArray, extinction: FloatArray, length: FloatArray) -> Sent:
    """Sent of slabs with a source (n, 3) [1/world], an extinction (n,) [1/world] and a length (n,) [world]."""
    depth = extinction * length
    alpha = -np.expm1(-depth)
    # Length times the mean transmittance over the slab, which is 1 where nothing absorbs.
    absorbs = depth > 1e-30
    mean = np.where(absorbs, alpha / np.where(absorbs, depth, 1.0), 1.0)
    rgb, back = source * (length * mean)[:, None], centre(depth)
    return Sent(rgb, alpha, rgb * back[:, None], alpha * back)


def centre(depth: FloatArray) -> FloatArray:
    """Mean place (n,) of the light of slabs of depth x, from 0 at the front: ``1 / x - exp(-x) / (1 - exp(-x))``."""
    deep = depth > 1e-4
    x = np.where(deep, depth, 1.0)
    return np.where(deep, 1 / x - np.exp(-x) / -np.expm1(-x), 0.5 - depth / 12)
