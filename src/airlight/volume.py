"""Volumes: samples on a regular grid, as values.

Arrays are NumPy, C order, ``(z, y, x)``, ``(c, z, y, x)`` or ``(t, c, z, y, x)``. Points and sizes are ``(x, y, z)``. The
centre of voxel (0, 0, 0) lies at index coordinate (0, 0, 0); ``world_from_index`` maps ``(x, y, z, 1)`` to the world.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from .errors import DataError

FloatArray = npt.NDArray[np.float64]
AnyArray = npt.NDArray[Any]

AXES = {3: "(z, y, x)", 4: "(c, z, y, x)", 5: "(t, c, z, y, x)"}


class Volume:
    """Samples on a regular grid, any number of channels and time steps, with an affine and units.

    Parameters
    ----------
    array
        ``(z, y, x)``, ``(c, z, y, x)`` or ``(t, c, z, y, x)``; bool, integer or float. A nibabel image, a SimpleITK image or
        an xarray DataArray is taken as it is, with its geometry. Not copied where NumPy can view it.
    spacing
        World size of a voxel along x, y, z.
    origin
        World position of the centre of voxel (0, 0, 0), as x, y, z.
    world_from_index
        4x4 matrix that maps ``(x, y, z, 1)``; instead of ``spacing`` and ``origin``. Shear is allowed.
    units
        Unit of length of the world, e.g. ``"mm"``; empty when unknown.
    value_unit
        Unit of the values, e.g. ``"HU"``; empty when unknown.
    channel_names
        One name a channel.
    times
        One time a time step, in ``time_unit``.
    no_data
        A value that marks empty samples, beside NaN.
    anatomical
        Whether the world is patient LPS (x to the left, y to posterior, z to superior).
    modality
        ``"CT"``, ``"MR"``, ``"microscopy"``, ``"labels"`` ...; empty when unknown.
    name
        A short name for messages; never written into results.
    source
        Path of the file that the volume was read from, and what within it (see ``airlight.open``); None for arrays.

    Raises
    ------
    DataError
        For complex or RGB-last data, other dimensions than 3 to 5, empty arrays, singular or non-finite geometry.
    """

    def __init__(
        self,
        array: Any,
        *,
        spacing: Sequence[float] | None = None,
        origin: Sequence[float] | None = None,
        world_from_index: npt.ArrayLike | None = None,
        units: str = "",
        value_unit: str = "",
        channel_names: Sequence[str] = (),
        times: Sequence[float] = (),
        time_unit: str = "",
        no_data: float | None = None,
        anatomical: bool = False,
        modality: str = "",
        name: str = "",
        source: Source | None = None,
    ) -> None:
        where = f"volume {name!r}" if name else "volume"
        foreign = _from_foreign(array)
        if foreign is not None:
            if spacing is not None or origin is not None or world_from_index is not None:
                raise DataError(where, "got a geometry beside an image that has its own", "give one of them")
            array, world_from_index = unmistakable(foreign.array), foreign.world_from_index
            units, anatomical = units or foreign.units, anatomical or foreign.anatomical
        data = _checked_array(array, where)
        if world_from_index is not None and (spacing is not None or origin is not None):
            raise DataError(where, "got both world_from_index and spacing or origin", "give one of them")
        if world_from_index is None:
            world_from_index = affine(
                (1.0, 1.0, 1.0) if spacing is None else spacing, (0.0, 0.0, 0.0) if origin is None else origin, where
            )
        self.array: AnyArray = data
        self.world_from_index: FloatArray = checked_affine(world_from_index, f"{where}.world_from_index")
        self.units, self.value_unit, self.time_unit = units, value_unit, time_unit
        self.no_data, self.anatomical, self.modality = no_data, bool(anatomical), modality
        self.name, self.source = name, source
        self.channel_names = tuple(str(c) for c in channel_names)
        self.times = tuple(float(t) for t in times)
        for names, count, what in (
            (self.channel_names, self.channel_count, "channel_names"),
            (self.times, self.time_count, "times"),
        ):
            if names and len(names) != count:
                raise DataError(f"{where}.{what}", f"has {len(names)} entries, the array has {count}")

    # -- shape and geometry

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the samples."""
        return self.array.dtype

    @property
    def size(self) -> tuple[int, int, int]:
        """Number of voxels along x, y, z."""
        z, y, x = self.array.shape[-3:]
        return x, y, z

    @property
    def channel_count(self) -> int:
        """Number of channels."""
        return int(self.array.shape[-4]) if self.array.ndim >= 4 else 1

    @property
    def time_count(self) -> int:
        """Number of time steps."""
        return int(self.array.shape[0]) if self.array.ndim == 5 else 1

    @cached_property
    def spacing(self) -> tuple[float, float, float]:
        """World size of a voxel along its x, y and z axes."""
        x, y, z = np.linalg.norm(self.world_from_index[:3, :3], axis=0)
        return float(x), float(y), float(z)

    @property
    def origin(self) -> tuple[float, float, float]:
        """World position of the centre of voxel (0, 0, 0)."""
        x, y, z = self.world_from_index[:3, 3]
        return float(x), float(y), float(z)

    @cached_property
    def index_from_world(self) -> FloatArray:
        """4x4 inverse of ``world_from_index``."""
        inverse: FloatArray = np.linalg.inv(self.world_from_index).astype(np.float64)
        inverse.flags.writeable = False
        return inverse

    def corners_world(self, cells: bool = False) -> FloatArray:
        """Eight corners (8, 3) of the domain: voxel centres, or voxel cells, which axes of one voxel always use."""
        low, high = domain_index(self.size, cells)
        unit = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=np.float64)
        corners_index = low + unit * (high - low)
        return np.asarray(corners_index @ self.world_from_index[:3, :3].T + self.world_from_index[:3, 3])

    # -- contents

    def channel_index(self, channel: int | str) -> int:
        """Number of a channel given by number or name."""
        if isinstance(channel, str):
            if channel not in self.channel_names:
                known = ", ".join(self.channel_names) or f"numbers 0 to {self.channel_count - 1}"
                raise DataError("channel", f"{channel!r} is unknown", f"choose one of {known}")
            return self.channel_names.index(channel)
        if not 0 <= channel < self.channel_count:
            raise DataError("channel", f"is {channel}, must lie in 0 to {self.channel_count - 1}")
        return int(channel)

    def grid(self, channel: int | str = 0, time: int = 0) -> AnyArray:
        """One channel at one time step, a ``(z, y, x)`` view."""
        c = self.channel_index(channel)
        if not 0 <= time < self.time_count:
            raise DataError("time", f"is {time}, must lie in 0 to {self.time_count - 1}")
        array = self.array
        if array.ndim == 5:
            array = array[time]
        if array.ndim == 4:
            array = array[c]
        return array

    def value_at(
        self, p_world: npt.ArrayLike, *, channel: int | str = 0, time: int = 0, field: str = "linear"
    ) -> float | FloatArray:
        """Value at a point (x, y, z) of the world, or values (...) at points (..., 3); NaN outside and where data are empty.

        Parameters
        ----------
        p_world
            Where, e.g. what ``airlight.pick`` returned.
        channel, time
            Of which channel, by number or name, and time step.
        field
            ``"linear"``: interpolated between voxel centres; ``"nearest"``: the voxel's own, out to its faces.

        Raises
        ------
        ValueRangeError
            For other fields, and what is no point.
        DataError
            For channels and times that the volume does not have.
        """
        from .probing import value_at

        found = value_at(self, p_world, channel, time, field)
        return float(found) if found.ndim == 0 else found

    @cached_property
    def digest(self) -> str:
        """SHA-256 of samples, geometry and units; computed when first asked for."""
        state = hashlib.sha256(repr((self.array.shape, self.array.dtype.str, self._traits())).encode())
        state.update(np.ascontiguousarray(self.world_from_index).data)
        for part in self.array if self.array.ndim > 3 else (self.array,):
            state.update(np.ascontiguousarray(part).data)
        return state.hexdigest()

    def _traits(self) -> tuple[object, ...]:
        return (
            self.units,
            self.value_unit,
            self.channel_names,
            self.times,
            self.time_unit,
            self.no_data,
            self.anatomical,
            self.modality,
        )

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Volume):
            return NotImplemented
        return (
            self.array.shape == other.array.shape
            and self.dtype == other.dtype
            and self.source == other.source
            and self._traits() == other._traits()
            and np.array_equal(self.world_from_index, other.world_from_index)
            and self.digest == other.digest
        )

    def __hash__(self) -> int:
        return hash((self.array.shape, self.dtype.str, self.world_from_index.tobytes()))

    def __repr__(self) -> str:
        x, y, z = self.size
        extra = f", {self.channel_count} channels" if self.channel_count > 1 else ""
        extra += f", {self.time_count} times" if self.time_count > 1 else ""
        sx, sy, sz = self.spacing
        return f"Volume({x}x{y}x{z} {self.dtype}{extra}, spacing {sx:.4g}, {sy:.4g}, {sz:.4g} {self.units})".replace(" )", ")")


@dataclass(frozen=True)
class Source:
    """Where a volume came from: what a scene file stores instead of the samples."""

    path: str
    dataset: str = ""
    level: int = 0
    options: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Statistics:
    """What is known of one channel at one time step, computed once.

    ``histogram`` has ``len(edges) - 1`` counts of finite samples that are not ``no_data``; ``empty`` counts the others.
    """

    minimum: float
    maximum: float
    histogram: npt.NDArray[np.int64]
    edges: FloatArray
    empty: int

    def percentile(self, percent: float) -> float:
        """Value below which ``percent`` of the samples lie, interpolated inside its bin."""
        cumulative = np.concatenate([[0], np.cumsum(self.histogram)])
        if cumulative[-1] == 0:
            return self.minimum
        return float(np.interp(percent / 100 * cumulative[-1], cumulative, self.edges))


_STATISTICS: WeakKeyDictionary[_Key, dict[tuple[int, int, int], Statistics]] = WeakKeyDictionary()


class _Key:
    """Identity of a volume as a weak key: volumes compare by content, which is slow."""


def statistics(volume: Volume, channel: int | str = 0, time: int = 0, bins: int = 1024) -> Statistics:
    """Range and histogram of one channel; empty samples stay out. Cached for the volume's life.

    Integers of up to 16 bits get bins of whole values, so that no bin covers more values than its neighbour.
    """
    key: _Key = volume.__dict__.setdefault("_statistics_key", _Key())
    slot = (volume.channel_index(channel), time, bins)
    cache = _STATISTICS.setdefault(key, {})
    if slot not in cache:
        cache[slot] = _statistics(volume.grid(*slot[:2]), volume.no_data, bins)
    return cache[slot]


def is_empty(grid: AnyArray, no_data: float | None) -> npt.NDArray[np.bool_] | None:
    """Mask of the samples that are NaN, infinite or no-data; None when there is none."""
    mask: npt.NDArray[np.bool_] | None = None
    if grid.dtype.kind == "f":
        mask = ~np.isfinite(grid)
    if no_data is not None and np.isfinite(no_data):
        marked = _marked(grid, no_data)
        mask = marked if mask is None else mask | marked
    return mask if mask is not None and bool(mask.any()) else None


def _marked(grid: AnyArray, no_data: float) -> npt.NDArray[np.bool_]:
    """Where integers equal a whole number that their type holds, or floats equal the number as their type holds it."""
    if grid.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return np.asarray(grid == np.float64(no_data).astype(grid.dtype))
    low, high = (0, 1) if grid.dtype.kind == "b" else (np.iinfo(grid.dtype).min, np.iinfo(grid.dtype).max)
    if no_data != int(no_data) or not low <= int(no_data) <= high:
        return np.zeros(grid.shape, dtype=bool)
    return np.asarray(grid == grid.dtype.type(int(no_data)))


def _statistics(grid: AnyArray, no_data: float | None, bins: int) -> Statistics:
    mask = is_empty(grid, no_data)
    empty = 0 if mask is None else int(mask.sum())
    values = grid if mask is None else grid[~mask]
    if values.size == 0:
        return Statistics(0.0, 0.0, np.zeros(1, dtype=np.int64), np.array([0.0, 1.0]), empty)
    if values.dtype == bool:
        values = values.view(np.uint8)
    low, high = float(values.min()), float(values.max())
    whole_low = int(values.min()) if values.dtype.kind in "iu" else 0
    if values.dtype.kind in "iu" and high - low < 65536:
        whole = np.bincount(
            (values.ravel().astype(np.int64) - whole_low)
            if values.dtype.itemsize > 2
            else np.subtract(values.ravel(), whole_low, dtype=np.int32)
        )
        width = max(1, -(-len(whole) // bins))
        padded = np.zeros(-(-len(whole) // width) * width, dtype=np.int64)
        padded[: len(whole)] = whole
        counts = padded.reshape(-1, width).sum(axis=1)
        edges = low - 0.5 + width * np.arange(len(counts) + 1, dtype=np.float64)
        return Statistics(low, high, counts, edges, empty)
    if high == low:
        return Statistics(low, high, np.array([values.size]), np.array([low, low + max(1e-12, 1e-15 * abs(low))]), empty)
    counts = np.zeros(bins, dtype=np.int64)
    edges = np.linspace(low, high, bins + 1)
    for part in np.array_split(values.ravel(), max(1, values.size >> 24)):
        counts += np.histogram(part.astype(np.float64, copy=False), bins=bins, range=(low, high))[0]
    return Statistics(low, high, counts, edges, empty)


def domain_index(size: Sequence[int], cells: bool) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest index coordinate (x, y, z) of the domain: centres, or cells, which axes of one voxel always use."""
    n = np.asarray(size, dtype=np.float64)
    use_cells = np.full(3, cells) | (n == 1)
    return np.where(use_cells, -0.5, 0.0), np.where(use_cells, n - 0.5, n - 1.0)


def affine(spacing: Sequence[float], origin: Sequence[float], where: str = "volume") -> FloatArray:
    """4x4 ``world_from_index`` of an unrotated grid."""
    if np.shape(spacing) != (3,) or np.shape(origin) != (3,):
        raise DataError(where, f"has spacing {spacing} and origin {origin}", "give three numbers each, in x, y, z order")
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(np.asarray(spacing, dtype=np.float64))
    matrix[:3, 3] = origin
    if not (np.asarray(spacing, dtype=np.float64) > 0).all():
        raise DataError(f"{where}.spacing", f"is {tuple(spacing)}, must be positive", "flip axes by world_from_index")
    return matrix


def checked_affine(matrix: npt.ArrayLike, where: str) -> FloatArray:
    """Read-only matrix (4, 4) that maps space to space.

    Raises
    ------
    DataError
        When it is none.
    """
    try:
        checked = np.array(matrix, dtype=np.float64)
    except (TypeError, ValueError):
        raise DataError(where, f"is {matrix!r}, must be numbers (4, 4)") from None
    if checked.shape != (4, 4):
        raise DataError(where, f"has shape {checked.shape}, must be (4, 4)")
    if not np.isfinite(checked).all() or not np.allclose(checked[3], (0, 0, 0, 1)):
        raise DataError(where, "must be finite with last row 0, 0, 0, 1")
    lengths = np.linalg.norm(checked[:3, :3], axis=0)
    if not (lengths > 0).all() or abs(np.linalg.det(checked[:3, :3] / lengths)) < 1e-9:
        raise DataError(where, "is singular: its axes do not span space")
    checked.flags.writeable = False
    return checked


def unmistakable(array: AnyArray) -> AnyArray:
    """Array whose axes are told: with one time step in front where three or four voxels would be taken for colours."""
    return array[None] if _seems_colours_last(array) else array


def _seems_colours_last(array: AnyArray) -> bool:
    return array.ndim == 4 and array.shape[-1] in (3, 4) and min(array.shape[:3]) > array.shape[-1]


def _checked_array(array: Any, where: str) -> AnyArray:
    data = np.asarray(array)
    if data.dtype.kind == "c":
        raise DataError(where, f"is complex ({data.dtype})", "pass abs(array) or np.angle(array)")
    if data.dtype.kind not in "biuf" or data.dtype.itemsize > 8:
        raise DataError(where, f"has dtype {data.dtype}", "use bool, integers, float16, float32 or float64")
    if _seems_colours_last(data):
        raise DataError(where, f"has shape {data.shape}, colours last", "pass np.moveaxis(array, -1, 0) to draw the channels")
    if data.ndim not in AXES:
        raise DataError(where, f"has {data.ndim} dimensions", f"pass one of {', '.join(AXES.values())}")
    if data.size == 0:
        raise DataError(where, f"has shape {data.shape}, no samples")
    if not data.dtype.isnative:
        data = data.astype(data.dtype.newbyteorder("="))
    view = data.view()
    view.flags.writeable = False
    return view


# -- objects of other libraries, recognised by what they offer so that none is imported


@dataclass(frozen=True)
class _Foreign:
    array: AnyArray
    world_from_index: FloatArray
    units: str
    anatomical: bool


LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])


def _from_foreign(image: Any) -> _Foreign | None:
    module = type(image).__module__.partition(".")[0]
    if module == "nibabel":
        data = np.asanyarray(image.dataobj)
        data = data.reshape(data.shape[:3] + (1,) * (3 - data.ndim)) if data.ndim < 3 else data
        to_mm = np.diag([{"meter": 1e3, "micron": 1e-3}.get(_nibabel_unit(image), 1.0)] * 3 + [1.0])
        return _Foreign(np.asarray(data.T), to_mm @ LPS_FROM_RAS @ np.asarray(image.affine, dtype=np.float64), "mm", True)
    if module == "SimpleITK":
        import SimpleITK

        array = SimpleITK.GetArrayFromImage(image)
        if image.GetNumberOfComponentsPerPixel() > 1:
            array = np.moveaxis(array, -1, 0)
        matrix = np.eye(4)
        if image.GetDimension() == 3:
            matrix[:3, :3] = np.reshape(image.GetDirection(), (3, 3)) * np.asarray(image.GetSpacing())
            matrix[:3, 3] = image.GetOrigin()
        return _Foreign(np.asarray(array), matrix, "mm", image.GetDimension() == 3)
    if module == "xarray" and hasattr(image, "dims"):
        return _from_xarray(image)
    return None


def _nibabel_unit(image: Any) -> str:
    header = image.header
    return str(header.get_xyzt_units()[0]) if hasattr(header, "get_xyzt_units") else "mm"


def _from_xarray(image: Any) -> _Foreign:
    order = [d for d in ("t", "time", "c", "channel", "z", "y", "x") if d in image.dims]
    if order[-3:] != ["z", "y", "x"] or len(order) != len(image.dims):
        raise DataError("volume", f"has dims {tuple(image.dims)}", "name them t, c, z, y, x (the last three are needed)")
    image = image.transpose(*order)
    matrix = np.eye(4)
    for axis, dim in enumerate(("x", "y", "z")):
        if dim not in image.coords or image.sizes[dim] < 2:
            continue
        place = np.asarray(image.coords[dim], dtype=np.float64)
        steps = np.diff(place)
        if not np.allclose(steps, steps[0], rtol=1e-4):
            raise DataError("volume", f"has uneven coordinates along {dim}", "resample it to a regular grid")
        matrix[axis, axis], matrix[axis, 3] = steps.mean(), place[0]
    return _Foreign(
        np.asarray(image.data),
        matrix,
        str(image.coords["x"].attrs.get("units", "")) if "x" in image.coords else "",
        False,
    )
