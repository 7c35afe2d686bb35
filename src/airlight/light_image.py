"""Pictures that lights throw, as frozen values."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import DataError, FileError, ValueRangeError

MOST_SIDE = 4096
GREATEST = 6e4  # as half floats hold it
SOFT_TEXELS = 64
SOFT_FROM = 0.6  # of a soft spot's radius


@dataclass(frozen=True, eq=False)
class LightImage:
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

    pixels: npt.NDArray[np.float32]
    path: str | None = None

    def __post_init__(self) -> None:
        """Check the pixels and keep a copy that cannot be written."""
        where, remedy = "light.image", "give factors (height, width) or (height, width, 3), linear, at least 0"
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

    @cached_property
    def digest(self) -> bytes:
        """What the content is known by."""
        return hashlib.sha256(repr(self.pixels.shape).encode() + self.pixels.tobytes()).digest()

    @property
    def aspect(self) -> float:
        """Width over height."""
        height, width = self.pixels.shape[:2]
        return float(width / height)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LightImage) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return f"LightImage({width}x{height}" + (f", {self.path!r})" if self.path else ")")

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
        """Return the file's name, for scene files.

        Raises
        ------
        DataError
            When the picture came from no file.
        """
        if self.path is None:
            raise DataError("light.image", "came from no file", "save its pixels as .npy and use LightImage.open")
        return {"kind": "picture", "file": self.path}
