"""Which dimension of a CF variable is x, y, z, time or channel, and the world that its coordinates make."""

from __future__ import annotations

import numpy as np

from ..errors import DataError
from ..volume import FloatArray
from .units import MILLIMETRES, unit_name

Coordinates = dict[str, tuple[FloatArray, dict[str, str]]]

_NAMES = {
    "x": ("x", "lon", "longitude", "xc", "easting", "nx", "west_east", "rlon", "i"),
    "y": ("y", "lat", "latitude", "yc", "northing", "ny", "south_north", "rlat", "j"),
    "z": ("z", "lev", "level", "depth", "height", "altitude", "alt", "plev", "zc", "nz", "bottom_top", "pressure", "k"),
    "t": ("t", "time", "times"),
    "c": ("c", "channel", "channels", "band"),
}
_LETTERS = {name: letter for letter, names in _NAMES.items() for name in names}
_STANDARD = {
    "x": ("longitude", "projection_x_coordinate", "grid_longitude"),
    "y": ("latitude", "projection_y_coordinate", "grid_latitude"),
    "z": ("depth", "height", "altitude", "air_pressure", "model_level_number"),
    "t": ("time",),
}


def axis_letters(dims: tuple[str, ...], coordinates: Coordinates, where: str) -> str:
    """One letter a dimension; where none is recognised their order is t, c, z, y, x."""
    letters = [_letter(dim, coordinates.get(dim, (None, {}))[1]) for dim in dims]
    if not any(letters):
        return "tczyx"[-len(dims) :]
    missing = [a for a in "zyxct" if a not in letters]
    unknown = [i for i, letter in enumerate(letters) if not letter]
    if len(unknown) == 1:
        letters[unknown[0]] = "c" if {"x", "y", "z"} <= set(letters) else missing[0]
    told = "".join(letters)
    if "" in letters or len(set(told)) != len(told) or not {"x", "y"} <= set(told):
        raise DataError(
            where,
            f"has dimensions {dims}, which of them are x, y and z is not told",
            "name them t, z, y, x or give axis attributes",
        )
    return told


def world(dims: tuple[str, ...], letters: str, coordinates: Coordinates, where: str) -> tuple[FloatArray, str]:
    """``world_from_index`` and its unit; axes without coordinates get a spacing of 1, mixed units no name."""
    matrix = np.eye(4)
    units: dict[str, str] = {}
    for row, letter in enumerate("xyz"):
        dim = dims[letters.index(letter)] if letter in letters else ""
        if dim not in coordinates:
            continue
        values, attributes = coordinates[dim]
        step, start = _even(values, f"{where}: {dim}")
        sign = -1.0 if letter == "z" and attributes.get("positive", "").lower() == "down" else 1.0
        matrix[row, row], matrix[row, 3] = sign * step, sign * start
        units[letter] = unit_name(attributes.get("units", ""))
    names = set(units.values())
    if len(names) > 1 and len(units) == 3 and names <= set(MILLIMETRES):
        for row, letter in enumerate("xyz"):
            matrix[row] *= MILLIMETRES[units[letter]] / MILLIMETRES[units["x"]]
        return matrix, units["x"]
    return matrix, names.pop() if len(names) == 1 else ""


def _letter(dim: str, attributes: dict[str, str]) -> str:
    axis = attributes.get("axis", "").lower()
    if axis in ("x", "y", "z", "t"):
        return axis
    standard = attributes.get("standard_name", "")
    for letter, names in _STANDARD.items():
        if standard in names:
            return letter
    units = attributes.get("units", "").lower()
    if units.startswith(("degrees_e", "degree_e")):
        return "x"
    if units.startswith(("degrees_n", "degree_n")):
        return "y"
    if " since " in units:
        return "t"
    if attributes.get("positive"):
        return "z"
    return _LETTERS.get(dim.lower(), "")


def _even(values: FloatArray, where: str) -> tuple[float, float]:
    if not np.isfinite(values).all() or len(values) == 0:
        raise DataError(where, "has coordinates that are not finite")
    if len(values) == 1:
        return 1.0, float(values[0])
    step = (values[-1] - values[0]) / (len(values) - 1)
    off = np.abs(values - (values[0] + step * np.arange(len(values))))
    if step == 0 or off.max() > 1e-2 * abs(step):
        at = int(np.argmax(np.abs(np.diff(values) - np.median(np.diff(values)))))
        raise DataError(
            where,
            f"is uneven: steps of {np.median(np.diff(values)):g}, but {values[at]:g} is followed by {values[at + 1]:g}",
            "resample it to even steps (xarray's interp does)",
        )
    return float(step), float(values[0])
