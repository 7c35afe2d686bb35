"""What users give, checked: lists, numbers and ranges, with errors that name the parameter."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from numbers import Integral, Real
from typing import Any

import numpy as np

from ..errors import DataError, ValueRangeError

ROUNDING = 1e-12  # of the length of a direction


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


def listed_values(given: Any, kinds: type | tuple[type, ...], where: str, listing: str, making: str) -> tuple[Any, ...]:
    """Return the parts of a list of values of these kinds; the remedies tell how it is listed, and how they are made.

    Raises
    ------
    ValueRangeError
        When it has no parts.
    DataError
        When something else is among them.
    """
    parts = listed(given, where, listing)
    for part in parts:
        if not isinstance(part, kinds):
            raise DataError(where, f"holds {part!r}", making)
    return parts


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


def number(given: Any, where: str) -> float:
    """Return a number, finite or not.

    Raises
    ------
    ValueRangeError
        When it is none.
    """
    if isinstance(given, (bool, np.bool_)) or not isinstance(given, Real):
        raise ValueRangeError(where, f"is {given!r}, must be a number")
    return float(given)


def not_negative(given: Any, where: str) -> float:
    """Return a finite number of at least 0.

    Raises
    ------
    ValueRangeError
        When it is none.
    """
    number = finite(given, where)
    if number < 0:
        raise ValueRangeError(where, f"is {given!r}, must be at least 0")
    return number


def positive(given: Any, where: str) -> float:
    """Return a finite number above 0.

    Raises
    ------
    ValueRangeError
        When it is none.
    """
    number = finite(given, where)
    if number <= 0:
        raise ValueRangeError(where, f"is {given!r}, must be above 0")
    return number


def share(given: Any, where: str) -> float:
    """Return a number in [0, 1].

    Raises
    ------
    ValueRangeError
        When it is none.
    """
    number = finite(given, where)
    if not 0 <= number <= 1:
        raise ValueRangeError(where, f"is {given!r}, must lie in [0, 1]")
    return number


def finite_numbers(given: Any, where: str, *counts: int) -> tuple[float, ...]:
    """Return finite numbers, as many as one of the counts.

    Raises
    ------
    ValueRangeError
        When they are others; it names the first at fault.
    """
    if not isinstance(given, (tuple, list, np.ndarray)) or len(given) not in counts:
        raise ValueRangeError(where, f"is {given!r}", f"give {' or '.join(map(str, counts))} numbers")
    return tuple(finite(part, f"{where}[{number}]") for number, part in enumerate(given))


def direction(given: Any, where: str) -> tuple[float, float, float]:
    """Return a direction of length one; one that has it but for rounding stays as it is.

    Raises
    ------
    ValueRangeError
        When it is no three finite numbers, or has no length.
    """
    x, y, z = finite_numbers(given, where, 3)
    length = math.hypot(x, y, z)
    if not 0 < length < math.inf:
        raise ValueRangeError(where, f"is {given!r}, must be a finite direction")
    return (x, y, z) if abs(length - 1) <= ROUNDING else (x / length, y / length, z / length)


def kind_of(data: Mapping[str, Any], kinds: Iterable[str], where: str) -> str:
    """Return the entry ``kind`` of plain data.

    Raises
    ------
    ValueRangeError
        When it is none of the kinds, or the data are no table.
    """
    if not isinstance(data, Mapping):
        raise ValueRangeError(where, f"is {data!r}, must be a table", f"with kind, one of {', '.join(kinds)}")
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in kinds:
        raise ValueRangeError(f"{where}.kind", f"is {kind!r}, must be one of {', '.join(kinds)}")
    return kind


def check_names(data: Mapping[str, Any], known: Collection[str], where: str, kind: str) -> None:
    """Refuse entries of plain data beside the kind and what it has.

    Raises
    ------
    ValueRangeError
        For the first that is unknown.
    """
    for name in data:
        if name != "kind" and name not in known:
            raise ValueRangeError(f"{where}.{name}", f"is no parameter of {kind}", f"it has {', '.join(known)}")


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


def check_size(size: Any) -> None:
    """Refuse what is no width and height of an image.

    Raises
    ------
    ValueRangeError
        When it is none.
    """
    allowed = isinstance(size, (tuple, list, np.ndarray)) and len(size) == 2
    if not (allowed and all(isinstance(n, Integral) and 0 < int(n) <= 1 << 16 for n in size)):
        raise ValueRangeError("size", f"is {size!r}, must be width and height, whole numbers in [1, 65536]")


def set_fields(frozen: object, **values: object) -> None:
    """Set checked fields of a value that is being made."""
    for name, value in values.items():
        object.__setattr__(frozen, name, value)
