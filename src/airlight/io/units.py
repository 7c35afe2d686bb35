"""Units of length and time by their one name here, and the way from other anatomical spaces to patient LPS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

MILLIMETRES = {"m": 1000.0, "cm": 10.0, "mm": 1.0, "um": 1e-3, "nm": 1e-6, "angstrom": 1e-7, "inch": 25.4, "km": 1e6}
"""Millimetres in one unit of length."""

_SPELLINGS = {
    "m": ("meter", "metre", "meters", "metres"),
    "cm": ("centimeter", "centimetre", "centimeters", "centimetres"),
    "mm": ("millimeter", "millimetre", "millimeters", "millimetres"),
    "um": ("µm", "μm", "micron", "microns", "micrometer", "micrometre", "micrometers", "micrometres"),
    "nm": ("nanometer", "nanometre", "nanometers", "nanometres"),
    "angstrom": ("å", "Å", "ångström", "angstroms"),
    "inch": ("in", "inches"),
    "km": ("kilometer", "kilometre", "kilometers", "kilometres"),
    "s": ("sec", "second", "seconds"),
    "ms": ("msec", "millisecond", "milliseconds"),
    "us": ("µs", "μs", "usec", "microsecond", "microseconds"),
    "min": ("minute", "minutes"),
    "h": ("hour", "hours"),
}
_NAMES = {spelling: name for name, spellings in _SPELLINGS.items() for spelling in spellings}


def unit_name(text: str) -> str:
    """One name for a unit's many spellings; unknown ones stay as they are."""
    text = text.strip()
    return _NAMES.get(text.lower(), _NAMES.get(text, text))


def in_millimetres(matrix: FloatArray, unit: str) -> FloatArray:
    """``world_from_index`` with its world in ``unit``, given in millimetres; an empty unit counts as millimetres."""
    return _scaled_rows(matrix, (MILLIMETRES[unit] if unit else 1.0,) * 3)


def in_lps(matrix: FloatArray, letters: str) -> FloatArray:
    """``world_from_index`` with its world in the space that the letters name, e.g. ``RAS``, given in LPS."""
    return _scaled_rows(matrix, [1.0 if have == want else -1.0 for have, want in zip(letters, "LPS", strict=True)])


def _scaled_rows(matrix: FloatArray, factors: Sequence[float]) -> FloatArray:
    # Not by a product of matrices: what is infinite in a damaged file stays so, to be refused, and spreads no warning.
    with np.errstate(over="ignore"):
        rows: FloatArray = matrix * np.array([*factors, 1.0])[:, None]
    return rows


def matrix_of(columns: npt.ArrayLike, origin: npt.ArrayLike) -> FloatArray:
    """4x4 ``world_from_index`` of the three columns (3, 3) and the place of voxel (0, 0, 0)."""
    matrix = np.eye(4)
    matrix[:3, :3] = columns
    matrix[:3, 3] = origin
    return matrix
