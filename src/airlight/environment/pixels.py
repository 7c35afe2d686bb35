"""Pixels that users give, and pictures that are known by them."""

from __future__ import annotations

import hashlib
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..errors import DataError


def pixels_in(given: npt.ArrayLike, where: str, dtype: npt.DTypeLike | None = None) -> npt.NDArray[Any]:
    """Return what is given as an array, of its own type or of ``dtype``.

    Raises
    ------
    DataError
        When its rows differ in length, or it holds no numbers.
    """
    try:
        return np.asarray(given, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise DataError(where, f"is no array of numbers ({error})", "give pixels (height, width, 3)") from error


class KnownByPixels:
    """Base of frozen pictures (height, width, ...), maybe from a file: equal to others of their kind of equal content."""

    where: ClassVar[str]
    opener: ClassVar[str]
    pixels: npt.NDArray[np.float32]
    path: str | None

    @cached_property
    def digest(self) -> bytes:
        """What the content is known by."""
        return hashlib.sha256(repr(self.pixels.shape).encode() + self.pixels.tobytes()).digest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return f"{type(self).__name__}({width}x{height}" + (f", {self.path!r})" if self.path else ")")

    def to_dict(self) -> dict[str, Any]:
        """Return the file's name, for scene files.

        Raises
        ------
        DataError
            When the picture came from no file.
        """
        if self.path is None:
            raise DataError(self.where, "came from no file", f"save its pixels as .npy and use {self.opener}")
        return {"file": self.path}
