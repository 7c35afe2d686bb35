"""The picture of an environment as it is seen behind a scene."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from .sources import Source, picture_of
from .sphere import resized

MOST_COLUMNS = 2046  # of a picture in a texture that all devices have, with a column on each side


@lru_cache(maxsize=2)
def background_picture(source: Source) -> npt.NDArray[np.float32]:
    """Return the equirectangular picture (1, h, w + 2, 4), float32: beside its outermost columns are those from the other side.

    Pictures of more than 2046 columns are reduced to so many.
    """
    pixels = picture_of(source)
    if pixels.shape[1] > MOST_COLUMNS:
        pixels = resized(np.asarray(pixels, dtype=np.float64), MOST_COLUMNS // 2, MOST_COLUMNS).astype(np.float32)
    height, width = pixels.shape[:2]
    texels = np.ones((1, height, width + 2, 4), dtype=np.float32)
    texels[0, :, 1:-1, :3] = pixels
    texels[0, :, 0, :3], texels[0, :, -1, :3] = pixels[:, -1], pixels[:, 0]
    texels.setflags(write=False)
    return texels


def is_reduced(source: Source) -> bool:
    """Whether the picture is finer than what is shown of it."""
    return bool(picture_of(source).shape[1] > MOST_COLUMNS)
