"""Tone: from the scene's radiance to what a display can show. ``tone(stage, rgba (..., 4)) -> (..., 4)``, premultiplied."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..volume import FloatArray

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear Rec. 709


def linear(stage: Any, rgba: FloatArray) -> FloatArray:
    """Double the light with each stop of exposure."""
    return np.concatenate([rgba[..., :3] * 2.0**stage.exposure, rgba[..., 3:]], axis=-1)


def reinhard(stage: Any, rgba: FloatArray) -> FloatArray:
    """Map the log-average luminance of what is covered to ``key``, and ``white`` to 1 (Reinhard et al. 2002, eq. 1 to 4)."""
    rgb, alpha = rgba[..., :3], rgba[..., 3]
    if not (alpha > 0).any():
        return rgba
    # The average is that of what covers; the operator maps the radiance that reaches the pixel, premultiplied.
    luminance = rgb @ LUMINANCE
    covered = alpha > 0
    of_cover = luminance[covered] / alpha[covered]
    log_average = np.exp((alpha[covered] * np.log(1e-6 + of_cover)).sum() / alpha.sum())
    # Ld / L = scale * (1 + L_scaled / white^2) / (1 + L_scaled), without a division by L.
    scale = 2.0**stage.exposure * stage.key / log_average
    scaled = scale * luminance
    factor = scale * (1 + scaled / stage.white**2) / (1 + scaled)
    return np.concatenate([rgb * factor[..., None], rgba[..., 3:]], axis=-1)


TONES: dict[str, Callable[[Any, FloatArray], FloatArray]] = {"linear": linear, "reinhard": reinhard}
