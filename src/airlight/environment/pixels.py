"""Pixels that users give."""

from __future__ import annotations

from typing import Any

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
