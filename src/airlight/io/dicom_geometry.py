"""From the positions of DICOM frames to a grid: order, affine and time axis, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..volume import FloatArray, affine
from .dicom_header import Frame

ROUNDING_MM = 0.1
"""Scanners write positions rounded to this."""


@dataclass(frozen=True)
class Grid:
    """Frames in order, ``frames[time][z]``, and where they lie."""

    frames: tuple[tuple[Frame, ...], ...]
    world_from_index: FloatArray
    units: str
    anatomical: bool
    times: tuple[float, ...] = ()
    time_unit: str = ""


def arrange(frames: list[Frame], where: str, spacing: tuple[float, float, float] | None = None) -> Grid:
    """Order the frames of one series along the normal of their common plane.

    Frames without positions are one volume only where one file holds them all, or ``spacing`` is given.
    """
    if any(f.position is None or f.orientation is None or f.spacing is None for f in frames):
        return _unplaced(frames, where, spacing)
    across, down = _plane(frames, where)
    normal = np.cross(across, down)
    positions = np.array([f.position for f in frames], dtype=np.float64)
    if not np.isfinite(positions).all():
        raise DataError(where, "has positions that are not finite")
    groups = _coincident(frames, positions, normal)
    in_time, times, time_unit = _by_time(groups, frames, where)
    step = _step(positions[in_time[0]], [frames[i] for i in in_time[0]], normal, where)
    row_spacing, column_spacing = frames[0].spacing or (1.0, 1.0)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = across * column_spacing, down * row_spacing, step
    matrix[:3, 3] = positions[in_time[0][0]]
    matrix += 0.0  # no negative zeros
    return Grid(tuple(tuple(frames[i] for i in row) for row in in_time), matrix, "mm", True, times, time_unit)


def _unplaced(frames: list[Frame], where: str, spacing: tuple[float, float, float] | None) -> Grid:
    ordered = tuple(sorted(frames, key=lambda f: (f.instance, f.path.name, f.index)))
    if spacing is not None:
        return Grid((ordered,), affine(spacing, (0, 0, 0), where), "mm", False)
    if len({f.path for f in frames}) > 1:
        raise DataError(
            where,
            f"has {len(frames)} slices without position, orientation or pixel spacing ({frames[0].path.name})",
            "give the spacing (--spacing x,y,z), then they are ordered by instance number",
        )
    first = ordered[0]
    if first.spacing is None or first.thickness <= 0:
        return Grid((ordered,), np.eye(4), "", False)
    return Grid((ordered,), affine((first.spacing[1], first.spacing[0], first.thickness), (0, 0, 0), where), "mm", False)


def _plane(frames: list[Frame], where: str) -> tuple[FloatArray, FloatArray]:
    cosines = np.array([f.orientation for f in frames], dtype=np.float64)
    pixels = np.array([f.spacing for f in frames], dtype=np.float64)
    odd = np.flatnonzero(~(np.abs(cosines - np.median(cosines, axis=0)).max(axis=1) < 1e-3))
    if len(odd):
        raise DataError(
            where,
            f"mixes planes: {len(odd)} of {len(frames)} slices are turned against the others ({_names(frames, odd)})",
            "keep the slices of one plane in a folder of their own",
        )
    odd = np.flatnonzero(~(np.abs(pixels / np.median(pixels, axis=0) - 1).max(axis=1) < 1e-3))
    if len(odd) or not (pixels > 0).all():
        raise DataError(where, f"mixes or lacks pixel spacings ({_names(frames, odd)})", "keep slices of one spacing")
    across, down = cosines[0, :3], cosines[0, 3:]
    lengths = float(np.linalg.norm(across)), float(np.linalg.norm(down))
    if max(abs(lengths[0] - 1), abs(lengths[1] - 1), abs(float(across @ down))) > 1e-2:
        raise DataError(where, f"has an ImageOrientationPatient that is not two unit vectors at right angles: {cosines[0]}")
    return across / lengths[0], down / lengths[1]


def _coincident(frames: list[Frame], positions: FloatArray, normal: FloatArray) -> list[list[int]]:
    """Frames along the normal, those at one place together."""
    height = positions @ normal
    tolerance = 0.01 * min(frames[0].spacing or (1.0,))
    order = np.lexsort((np.arange(len(frames)), height))
    cuts = np.flatnonzero(np.diff(height[order]) > tolerance) + 1
    return [sorted(map(int, group)) for group in np.split(order, cuts)]


def _by_time(groups: list[list[int]], frames: list[Frame], where: str) -> tuple[list[list[int]], tuple[float, ...], str]:
    """Frames as ``[time][z]``; several frames at one place are a time axis only where the file says so."""
    counts = [len(g) for g in groups]
    if max(counts) == 1:
        return [[g[0] for g in groups]], (), ""
    crowded = groups[int(np.argmax(counts))]
    if min(counts) != max(counts):
        raise DataError(
            where,
            f"covers its places {min(counts)} to {max(counts)} times: {_names(frames, crowded)} share one",
            "keep one slice a place",
        )
    differing = sorted({name for group in groups for name in _differing([frames[i] for i in group])})
    for name, _, unit in () if set(differing) - {"acquisition"} else frames[0].moments:
        moments = [[{m[0]: m[1] for m in frames[i].moments}.get(name, np.nan) for i in g] for g in groups]
        order = np.argsort(moments, axis=1, kind="stable")
        table = np.take_along_axis(np.array(moments), order, axis=1)
        steps = np.diff(table, axis=1)
        if (steps > 0).all() and (np.ptp(table, axis=0) < 0.5 * steps.min()).all():
            in_time = [[groups[z][order[z, t]] for z in range(len(groups))] for t in range(counts[0])]
            return in_time, tuple(map(float, table.mean(axis=0))), unit
    told = f"that differ by {', '.join(differing)}" if differing else "and no time that orders them"
    raise DataError(
        where, f"has {counts[0]} frames at each of {len(groups)} places, {told}", "keep those of one kind in a folder"
    )


def _differing(frames: list[Frame]) -> list[str]:
    return [name for name in dict(frames[0].traits) if len({dict(f.traits).get(name) for f in frames}) > 1]


def _step(positions: FloatArray, frames: list[Frame], normal: FloatArray, where: str) -> FloatArray:
    """World vector from a slice to the next: sheared where the gantry was tilted, refused where uneven."""
    count = len(positions)
    if count == 1:
        return np.asarray(normal * (frames[0].thickness or min(frames[0].spacing or (1.0,))))
    step = (positions[-1] - positions[0]) / (count - 1)
    length = float(np.linalg.norm(step))
    off = np.linalg.norm(positions - (positions[0] + np.arange(count)[:, None] * step), axis=1)
    if off.max() > max(0.02 * length, min(ROUNDING_MM, 0.1 * length)):
        raise DataError(where, _uneven(positions, frames, normal), "resample the series, or keep a run of even slices")
    along = float(step @ normal)
    lateral = float(np.linalg.norm(step - along * normal))
    if lateral * (count - 1) <= 0.5 * ROUNDING_MM:
        return np.asarray(along * normal)
    if lateral > 2 * along:
        raise DataError(where, "moves its slices sideways, not apart", "check ImagePositionPatient")
    return np.asarray(step)


def _uneven(positions: FloatArray, frames: list[Frame], normal: FloatArray) -> str:
    steps = np.diff(positions, axis=0)
    usual = np.median(steps, axis=0)
    odd = np.flatnonzero(np.linalg.norm(steps - usual, axis=1) > 0.02 * np.linalg.norm(usual))
    worst = int(odd[0]) if len(odd) else 0
    gaps = steps @ normal
    tilt = np.degrees(np.arccos(np.clip(float(usual @ normal) / float(np.linalg.norm(usual) or 1.0), -1, 1)))
    told = f" (the gantry is tilted by {tilt:.1f} degrees)" if tilt > 0.5 else ""
    return (
        f"has uneven gaps{told}: {frames[worst].path.name} and {frames[worst + 1].path.name} lie {gaps[worst]:.3f} mm "
        f"apart, the usual gap is {np.median(gaps):.3f} mm; {len(odd)} of {len(gaps)} gaps differ"
    )


def _names(frames: list[Frame], indices: npt.NDArray[np.intp] | list[int]) -> str:
    names = list(dict.fromkeys(frames[int(i)].path.name for i in indices))
    return ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")
