"""What users give, checked: lists, numbers and ranges, with errors that name the parameter."""

from __future__ import annotations

from numbers import Integral
from typing import Any

import numpy as np

from ..errors import ValueRangeError


def listed(given: Any, where: str, remedy: str) -> tuple[Any, ...]:
    """Return the parts of what is given; words count as no lists.

    Raises
    ------
    ValueRangeError
        When it has no parts.
    """
    try:
        parts = None if isinstance(given, (str, bytes)) else iter(given)
    except TypeError:
        parts = None
    if parts is None:
        raise ValueRangeError(where, f"is {given!r}, must be a list", remedy)
    return tuple(parts)


def finite(given: Any, where: str) -> float:
    """Return a finite number.

    Raises
    ------
    ValueRangeError
        When it is none.
    """
    try:
        number = float("nan") if isinstance(given, (str, bytes, bool)) else float(given)
    except (TypeError, ValueError, OverflowError):
        number = float("nan")
    if not np.isfinite(number):
        raise ValueRangeError(where, f"is {given!r}, must be a finite number")
    return number


def density_factor(given: Any) -> float:
    """Return a factor of extinctions.

    Raises
    ------
    ValueRangeError
        When it is no finite number of at least 0.
    """
    if isinstance(given, (str, bytes, bool)) or np.ndim(given) or not (np.isreal(given) and np.isfinite(given) and given >= 0):
        raise ValueRangeError("density", f"is {given!r}, must be at least 0")
    return float(given)


def whole(given: Any, where: str, least: int, most: int | None = None, remedy: str = "") -> int:
    """Return a whole number in a range.

    Raises
    ------
    ValueRangeError
        When it is none, or lies outside of the range.
    """
    number = int(given) if isinstance(given, Integral) and not isinstance(given, bool) else None
    if number is not None and least <= number and (most is None or number <= most):
        return number
    allowed = f"must be a whole number of at least {least}" if most is None else f"must be a whole number in [{least}, {most}]"
    raise ValueRangeError(where, f"is {given!r}, {allowed}", remedy)


def rising_range(given: Any, where: str) -> tuple[float, float]:
    """Return two finite numbers, the second above the first.

    Raises
    ------
    ValueRangeError
        When they are not.
    """
    parts = listed(given, where, "give (first, last)")
    if len(parts) != 2:
        raise ValueRangeError(where, f"is {given!r}", "give (first, last)")
    low, high = (finite(part, where) for part in parts)
    if not low < high:
        raise ValueRangeError(where, f"runs from {low:g} to {high:g}", "give a finite range that rises")
    return low, high


def flag(given: Any, where: str) -> bool:
    """Return true or false.

    Raises
    ------
    ValueRangeError
        When it is neither.
    """
    if not isinstance(given, (bool, np.bool_)):
        raise ValueRangeError(where, f"is {given!r}, must be true or false")
    return bool(given)
