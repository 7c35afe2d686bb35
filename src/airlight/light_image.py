"""Pictures that lights throw, as frozen values."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .environment.pixels import KnownByPixels
from .errors import DataError, FileError, ValueRangeError

MOST_SIDE = 4096
GREATEST = 6e4  # as half floats hold it
SOFT_TEXELS = 64
SOFT_FROM = 0.6  # of a soft spot's radius


@dataclass(frozen=True, eq=False)
class LightImage(KnownByPixels):
    """Factors of a light's colour over its beam, first row on top as seen from the light; equal to another of equal content.

    Attributes
    ----------
    pixels
        Linear factors, at least 0: (height, width) or (height, width, 3), kept as float32 (height, width, 3). ``uint8`` counts
        as 0 to 255 of 1.
    path
        The file that it came from, for scene files.

    Raises
    ------
    DataError
        For what is no array of numbers, and other shapes.
    ValueRangeError
        For factors that are negative, no number, or above 60000, and more than 4096 pixels a side.
    """

    where: ClassVar[str] = "light.image"
    opener: ClassVar[str] = "LightImage.open"
    pixels: npt.NDArray[np.float32]
    path: str | None = None

    def __post_init__(self) -> None:
        """Check the pixels and keep a copy that cannot be written."""
        where, remedy = self.where, "give factors (height, width) or (height, width, 3), linear, at least 0"
        try:
            given = np.asarray(self.pixels)
        except ValueError:
            given = np.asarray(None)
        if given.dtype.kind not in "fiub":
            raise DataError(where, f"is a {type(self.pixels).__name__} of {given.dtype}, no array of numbers", remedy)
        if given.ndim not in (2, 3) or (given.ndim == 3 and given.shape[2] != 3) or not given.size:
            raise DataError(where, f"has the shape {given.shape}", remedy)
        if max(given.shape[:2]) > MOST_SIDE:
            raise ValueRangeError(
                where, f"has {given.shape[1]} x {given.shape[0]} pixels, at most {MOST_SIDE} a side", "reduce it"
            )
        factors = given.astype(np.float64) / (255.0 if given.dtype == np.uint8 else 1.0)
        if not (np.isfinite(factors).all() and factors.min() >= 0 and factors.max() <= GREATEST):
            raise ValueRangeError(where, "has factors that are no number, negative or above 60000", remedy)
        kept = np.ascontiguousarray(np.broadcast_to(factors.reshape(*given.shape[:2], -1), (*given.shape[:2], 3)), np.float32)
        kept.setflags(write=False)
        object.__setattr__(self, "pixels", kept)

    @property
    def aspect(self) -> float:
        """Width over height."""
        height, width = self.pixels.shape[:2]
        return float(width / height)

    @staticmethod
    def soft() -> LightImage:
        """Return a round spot with a soft edge."""
        axis = (np.arange(SOFT_TEXELS) + 0.5) * 2 / SOFT_TEXELS - 1
        share = np.clip((1 - np.hypot(axis[:, None], axis)) / (1 - SOFT_FROM), 0.0, 1.0)
        return LightImage((share * share * (3 - 2 * share)).astype(np.float32))

    @staticmethod
    def open(path: str | os.PathLike[str]) -> LightImage:
        """Return the picture in a ``.npy``, ``.hdr`` or ``.exr`` file.

        Raises
        ------
        FileError
            When the file is missing, damaged or of another kind.
        """
        from .environment.reading import ENDINGS, read_picture

        if Path(path).suffix.lower() not in ENDINGS:
            raise FileError(str(path), "is no picture that a light throws", f"use one of {', '.join(ENDINGS)}")
        pixels = read_picture(Path(path))
        return LightImage(pixels[..., :3] if pixels.ndim == 3 else pixels, os.path.abspath(path))

    def to_dict(self) -> dict[str, Any]:
        """Return kind and file, for scene files; refused as for other pictures."""
        return {"kind": "picture", **super().to_dict()}
