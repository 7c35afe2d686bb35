"""What the axes of a NRRD file are: which three are space, which are channels and time, and where they lie in the world."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import DataError, FileError
from .messages import shown
from .samples import AnyArray
from .units import MILLIMETRES, FloatArray, in_lps, in_millimetres, matrix_of, unit_name

ANATOMICAL = {
    "right-anterior-superior": "RAS",
    "left-anterior-superior": "LAS",
    "left-posterior-superior": "LPS",
    "ras": "RAS",
    "las": "LAS",
    "lps": "LPS",
}
OTHER_SPACES = ("scanner-xyz", "3d-right-handed", "3d-left-handed")
SPATIAL_KINDS = {"domain", "space"}
COLOURS = {"rgb-color": ("red", "green", "blue"), "rgba-color": ("red", "green", "blue", "alpha")}


@dataclass(frozen=True)
class Axes:
    """The meaning of a file's axes, fastest first, and the geometry that follows from it."""

    sizes: tuple[int, ...]
    spatial: tuple[int, int, int]
    channels: tuple[int, ...]
    time: int | None
    world_from_index: FloatArray
    units: str
    anatomical: bool
    channel_names: tuple[str, ...]
    time_start: float
    time_step: float
    time_unit: str

    @property
    def times(self) -> tuple[float, ...]:
        """One time a step; empty where the file gives no step."""
        return tuple(self.time_start + self.time_step * i for i in range(self.time_count)) if self.time_step else ()

    @property
    def file_shape(self) -> tuple[int, ...]:
        """Shape in C order as the file has it."""
        return tuple(reversed(self.sizes))

    @property
    def channel_count(self) -> int:
        """Number of channels."""
        return math.prod(self.sizes[axis] for axis in self.channels)

    @property
    def time_count(self) -> int:
        """Number of time steps."""
        return self.sizes[self.time] if self.time is not None else 1

    def arrange(self, array: AnyArray) -> AnyArray:
        """View of an array of ``file_shape`` with its axes as ``(t, c, z, y, x)`` and without those that the file lacks."""
        last = len(self.sizes) - 1
        order = [last - axis for axis in (*reversed(self.channels), *reversed(self.spatial))]
        if self.time is not None:
            order.insert(0, last - self.time)
        array = array.transpose(order)
        space = array.shape[-3:]
        if self.time is not None:
            return array.reshape(self.time_count, self.channel_count, *space)
        return array.reshape(self.channel_count, *space) if self.channels else array


def axes_of(fields: Mapping[str, Any], where: str) -> Axes:
    """Meaning and geometry of the axes that a header declares."""
    sizes = tuple(int(n) for n in fields["sizes"])
    count = int(fields["dimension"])
    if count != len(sizes):
        raise FileError(f"{where}: sizes", f"lists {len(sizes)} numbers for {count} axes", "mend the header")
    if not 3 <= count <= 8:
        raise DataError(where, f"has {count} axes, a volume has 3 to 5", "stack its slices into one file")
    kinds = [str(kind).lower() for kind in fields.get("kinds", ["???"] * count)]
    directions = fields.get("space directions")
    vectors = None if directions is None else [None if v is None else np.asarray(v, dtype=np.float64) for v in directions]
    for key, values in (("kinds", kinds), ("space directions", vectors)):
        if values is not None and len(values) != count:
            raise FileError(f"{where}: {key}", f"lists {len(values)} entries for {count} axes", "mend the header")
    vectors = None if vectors is None else [None if v is None or np.isnan(v).any() else v for v in vectors]
    if any("complex" in kind for kind in kinds):
        raise DataError(where, "holds complex samples", "write their magnitude or phase into a file")
    time, vectors, time_step = _time_axis(kinds, vectors)
    spatial = _spatial_axes(kinds, vectors, time, fields, count, where)
    channels = tuple(axis for axis in range(count) if axis not in spatial and axis != time)
    matrix, units, anatomical = _geometry(fields, vectors, spatial, sizes, where)
    names = COLOURS.get(kinds[channels[0]], ()) if len(channels) == 1 else ()
    start, step, time_unit = _times(fields, time, sizes, time_step)
    return Axes(sizes, spatial, channels, time, matrix, units, anatomical, names, start, step, time_unit)


def _time_axis(kinds: Sequence[str], vectors: Any) -> tuple[int | None, Any, float]:
    """The axis of time and its step; ``...-time`` spaces have it as a fourth component of every vector."""
    time = kinds.index("time") if "time" in kinds else None
    step = 0.0
    if vectors is not None and any(v is not None and len(v) == 4 for v in vectors):
        short = []
        for axis, vector in enumerate(vectors):
            if vector is not None and len(vector) == 4 and vector[3] != 0 and not vector[:3].any():
                time, step = axis, float(vector[3])
                vector = None
            short.append(None if vector is None else vector[:3])
        vectors = short
    if time is not None and vectors is not None:
        vectors = [None if axis == time else vector for axis, vector in enumerate(vectors)]
    return time, vectors, step


def _spatial_axes(
    kinds: Sequence[str], vectors: Any, time: int | None, fields: Mapping[str, Any], count: int, where: str
) -> tuple[int, int, int]:
    others = [axis for axis in range(count) if axis != time]
    by_kind = [axis for axis in others if kinds[axis] in SPATIAL_KINDS]
    by_vector = [] if vectors is None else [axis for axis in others if vectors[axis] is not None]
    spacings = np.asarray(fields.get("spacings", []), dtype=np.float64)
    by_spacing = [axis for axis in others if len(spacings) == count and not np.isnan(spacings[axis])]
    for found in (by_vector, by_kind, by_spacing, others):
        if len(found) == 3:
            return found[0], found[1], found[2]
    raise FileError(
        where,
        f"has {count} axes and does not say which three are space",
        "add kinds to its header, e.g. 'kinds: domain domain domain list'",
    )


def _geometry(
    fields: Mapping[str, Any], vectors: Any, spatial: Sequence[int], sizes: Sequence[int], where: str
) -> tuple[FloatArray, str, bool]:
    space = str(fields.get("space", "")).strip().lower().removesuffix("-time").removesuffix("t")
    letters = ANATOMICAL.get(space, "")
    if space and not letters and space not in OTHER_SPACES:
        raise FileError(f"{where}: space", f"is {shown(fields['space'])}", "write left-posterior-superior or another of NRRD's")
    origin = np.asarray(fields.get("space origin", np.zeros(3)), dtype=np.float64)[:3]
    if vectors is not None and all(vectors[axis] is not None for axis in spatial):
        columns = [vectors[axis] for axis in spatial]
        if any(len(column) != 3 for column in columns) or len(origin) != 3:
            raise FileError(f"{where}: space directions", "are not vectors of three numbers", "mend the header")
        matrix = matrix_of(np.transpose(columns), np.nan_to_num(origin))
        unit = _common_unit(fields.get("space units", fields.get("spaceunits")), range(3), where)
    else:
        matrix = _unrotated(fields, spatial, sizes, origin, where)
        unit = _common_unit(fields.get("units"), spatial, where)
    if not letters:
        return matrix, unit, False
    if unit and unit not in MILLIMETRES:
        raise FileError(f"{where}: space units", f"are {shown(unit)}, no length", "write mm")
    return in_lps(in_millimetres(matrix, unit), letters), "mm", True


def _unrotated(
    fields: Mapping[str, Any], spatial: Sequence[int], sizes: Sequence[int], origin: FloatArray, where: str
) -> FloatArray:
    """Geometry of ``spacings``, ``axis mins`` and ``axis maxs``, older than space directions."""

    def per_axis(*keys: str) -> FloatArray:
        for key in keys:
            values = np.asarray(fields.get(key, []), dtype=np.float64)
            if len(values) == len(sizes):
                return values[list(spatial)]
            if len(values):
                raise FileError(f"{where}: {key}", f"lists {len(values)} numbers for {len(sizes)} axes", "mend the header")
        return np.full(3, np.nan)

    centers = fields.get("centers", fields.get("centerings", ["???"] * len(sizes)))
    cell = np.array([str(centers[axis]) == "cell" if axis < len(centers) else False for axis in spatial])
    low, high = per_axis("axis mins", "axismins"), per_axis("axis maxs", "axismaxs")
    count = np.array([sizes[axis] for axis in spatial], dtype=np.float64)
    from_ends = (high - low) / np.where(cell, count, np.maximum(count - 1, 1))
    spacing = per_axis("spacings")
    spacing = np.where(np.isnan(spacing), from_ends, spacing)
    spacing = np.where(np.isnan(spacing) | (spacing == 0), 1.0, spacing)
    start = np.where(np.isnan(low), 0.0, low + np.where(cell, spacing / 2, 0.0))
    if np.isnan(low).all() and len(origin) == 3:
        start = np.nan_to_num(origin)
    return matrix_of(np.diag(spacing), start)


def _common_unit(listed: Any, axes: Sequence[int], where: str) -> str:
    if listed is None or len(listed) <= max(axes):
        return ""
    units = {unit_name(str(listed[axis])) for axis in axes} - {"???"}
    if len(units) > 1:
        raise FileError(f"{where}: units", f"differ between axes: {shown(', '.join(sorted(units)))}", "write one unit for all")
    return units.pop() if units else ""


def _times(fields: Mapping[str, Any], time: int | None, sizes: Sequence[int], step: float) -> tuple[float, float, str]:
    """First time, step (0 when unknown) and unit."""
    if time is None:
        return 0.0, 0.0, ""
    spacings = np.asarray(fields.get("spacings", []), dtype=np.float64)
    if not step and len(spacings) == len(sizes) and np.isfinite(spacings[time]):
        step = float(spacings[time])
    units = fields.get("units", [])
    unit = unit_name(str(units[time])) if len(units) == len(sizes) else ""
    lows = np.asarray(fields.get("axis mins", fields.get("axismins", [])), dtype=np.float64)
    start = float(lows[time]) if len(lows) == len(sizes) and np.isfinite(lows[time]) else 0.0
    return start, step, unit
