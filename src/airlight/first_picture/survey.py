"""What a volume holds, found from a part of its samples: its kind, its background, and where the object begins."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..volume import AnyArray, FloatArray, Statistics, Volume, is_empty, statistics
from .histogram import materials, noise_above, otsu_threshold

SAMPLES_PER_AXIS = 96
MOST_LABELS = 1600
BINS = 128


@dataclass(frozen=True, eq=False)
class Survey:
    """Findings about one channel at one time step.

    Attributes
    ----------
    kind
        ``"empty"``, ``"constant"``, ``"mask"``, ``"labels"``, ``"ct"``, ``"signed"``, ``"object"`` (something solid before a
        background), ``"cloud"`` (values that fade into the background, as fluorescence does) or ``"filled"`` (no background).
    known
        Range and histogram of all samples.
    samples
        Every few samples of the grid (z, y, x), float64.
    filled
        Where ``samples`` are not empty.
    stride
        Voxels from sample to sample along z, y, x.
    background, noise_top
        Value of the surroundings, and the value above which their noise no longer reaches.
    begin
        Value at which the object begins.
    peaks
        Values of the object's materials, rising; empty where none stands out.
    labels
        Whole values that occur, for labels and masks.
    dark
        The object is darker than what surrounds it: background, noise_top, begin and peaks are those of the negated values.
    """

    kind: str
    known: Statistics
    samples: FloatArray
    filled: npt.NDArray[np.bool_]
    stride: tuple[int, int, int]
    background: float = 0.0
    noise_top: float = 0.0
    begin: float = 0.0
    peaks: tuple[float, ...] = ()
    labels: tuple[int, ...] = ()
    dark: bool = False

    @property
    def values(self) -> FloatArray:
        """Samples that are not empty, in a row."""
        return self.samples[self.filled]


def survey(volume: Volume, channel: int | str = 0, time: int = 0) -> Survey:
    """Find out what a channel holds; kept with the volume, so that asking again costs nothing."""
    # Beside the volume's other cached properties: volumes compare by content, too slow for a key.
    cache: dict[tuple[int, int], Survey] = volume.__dict__.setdefault("_surveys", {})
    slot = (volume.channel_index(channel), time)
    if slot not in cache:
        cache[slot] = _survey(volume, *slot)
    return cache[slot]


def _survey(volume: Volume, channel: int, time: int) -> Survey:
    grid = volume.grid(channel, time)
    known = statistics(volume, channel, time)
    z, y, x = (-(-n // SAMPLES_PER_AXIS) for n in grid.shape)
    part = grid[::z, ::y, ::x]
    mask = is_empty(part, volume.no_data)
    filled = np.ones(part.shape, dtype=bool) if mask is None else ~mask
    samples = np.where(filled, part, 0).astype(np.float64)
    found = Survey("empty", known, samples, filled, (z, y, x))
    if known.histogram.sum() == 0:
        return found
    if known.maximum <= known.minimum:
        return _changed(found, kind="constant", background=known.minimum, begin=known.minimum)
    whole = _labels(volume, grid, known)
    if whole:
        kind = "mask" if len(whole) == 2 else "labels"
        begin = (whole[0] + whole[1]) / 2
        return _changed(found, kind=kind, background=float(whole[0]), begin=begin, labels=whole)
    if is_ct(volume, known):
        return _changed(found, kind="ct", background=-1000.0, noise_top=-700.0, begin=-500.0)
    return _scalar(found, volume.modality)


def is_ct(volume: Volume, known: Statistics) -> bool:
    """Whether values are Hounsfield units: said by the file, or told by air and soft tissue where they must lie."""
    if known.minimum > -500 or known.maximum > 100_000:
        return False
    if volume.modality == "CT" or volume.value_unit == "HU":
        return True
    if volume.modality or known.minimum < -10_000 or known.maximum < 100:
        return False
    middle = (known.edges[1:] + known.edges[:-1]) / 2
    total = known.histogram.sum()
    air = known.histogram[middle < -850].sum() / total
    tissue = known.histogram[(middle > -150) & (middle < 150)].sum() / total
    between = known.histogram[(middle > -850) & (middle < -150)].sum() / total
    return bool(air > 0.02 and tissue > 0.05 and between < air + tissue)


# -- labels


def _labels(volume: Volume, grid: AnyArray, known: Statistics) -> tuple[int, ...]:
    """Whole values that occur, where the data are labels or a mask of two values; else nothing."""
    if grid.dtype.kind == "f" and (known.maximum - known.minimum >= MOST_LABELS or not _all_whole(grid, volume.no_data)):
        return ()
    if grid.dtype == bool:
        return (0, 1)
    said = volume.modality == "labels"
    if not said and not _is_flat(grid, known):
        return ()
    occurring = np.flatnonzero(known.histogram)
    one_a_bin = bool(known.edges[1] - known.edges[0] <= 1)
    if len(occurring) == 2 and one_a_bin:
        return round(known.minimum), round(known.maximum)
    if one_a_bin and grid.dtype.kind != "f":
        return tuple(round(known.edges[i] + 0.5) for i in occurring)
    whole = np.unique(grid[:: max(1, grid.shape[0] // 256)])
    whole = whole[np.isfinite(whole)]
    return tuple(int(v) for v in whole) if 2 <= len(whole) <= MOST_LABELS else ()


def _all_whole(grid: AnyArray, no_data: float | None) -> bool:
    part = grid[:: max(1, grid.shape[0] // 16)]
    mask = is_empty(part, no_data)
    values = part if mask is None else part[~mask]
    return bool((values == np.rint(values)).all())


def _is_flat(grid: AnyArray, known: Statistics) -> bool:
    """Whether neighbours that do not have the commonest value are mostly equal."""
    occurring = int(np.count_nonzero(known.histogram))
    if occurring == 2:
        return True
    part = grid[:: max(1, grid.shape[0] // 24)].astype(np.float64)
    if part.shape[-1] < 2:
        return False
    left, right = part[..., :-1], part[..., 1:]
    commonest = known.edges[int(np.argmax(known.histogram))] + 0.5
    # The greatest value of an image may be where it was clipped: that is no region.
    counted = (left != commonest) & (right != commonest) & (left != known.maximum)
    if counted.sum() < 16:
        return False
    equal = float((left == right)[counted].mean())
    return equal > 0.7


# -- images and fields


def _scalar(found: Survey, modality: str) -> Survey:
    values = found.values
    known = found.known
    low, high = np.percentile(values, (0.1, 99.9)) if values.size else (known.minimum, known.maximum)
    if high <= low:
        low, high = known.minimum, known.maximum
    if _is_signed(values, low, high):
        return _changed(found, kind="signed", background=0.0, begin=0.0)
    # What lies beyond stays out: a bin that gathers clipped values would be taken for a peak.
    counts, edges = np.histogram(values, bins=BINS, range=(low, high))
    middle = (edges[1:] + edges[:-1]) / 2
    faces = _faces(found)
    # Bodies in an MR scanner often reach through several faces; air is dark.
    background = float(np.percentile(faces, 25 if modality == "MR" else 50)) if faces.size else float(low)
    at = int(np.clip(np.searchsorted(edges, background) - 1, 0, BINS - 1))
    otsu = otsu_threshold(counts, middle)
    share = counts[: at + 1].sum() / counts.sum()
    if faces.size and not found.dark and _is_bright_background(faces, background, otsu, float(low)):
        negated = _scalar(_changed(found, samples=-found.samples, dark=True), modality)
        return _changed(negated, samples=found.samples)
    surrounded = faces.size > 0 and background < otsu and (faces < otsu).mean() > 0.6
    if not surrounded or share > 0.9995:
        return _changed(found, kind="filled", background=float(low), begin=float(np.percentile(values, 60)))
    noise_top = noise_above(faces[faces <= otsu], background, otsu)
    peaks, valley = materials(counts, middle, at, noise_top)
    if not peaks:
        # Noise without a gap to what is bright: go by the spread of the faces' lower half, which holds nothing bright.
        lower = background - faces[faces <= background]
        noise = min(4 * float(np.median(lower)), 6 * _roughness(found))
        noise_top = max(noise_top, background + noise)
        noise_top = min(noise_top, float(np.percentile(values, 99)))
        begin = max(noise_top, (min(otsu, float(np.percentile(values, 97))) + background) / 2)
        return _changed(found, kind="cloud", background=background, noise_top=noise_top, begin=begin)
    if noise_top <= background and len(peaks) > 1 and peaks[0] - background < 0.5 * (otsu - background):
        # The background was cut away: what is dark inside (liquid, bone in MRI) is no border, the cut's own steps would show.
        peaks = peaks[1:]
    # Halfway to the material lies its border, unless the valley is nearer: something thin may not reach the whole value.
    half = (background + peaks[0]) / 2
    begin = (min(valley, half) + half) / 2
    begin = float(np.clip(begin, noise_top, (noise_top + 2 * peaks[0]) / 3))
    return _changed(found, kind="object", background=background, noise_top=noise_top, begin=begin, peaks=peaks)


def _is_signed(values: FloatArray, low: float, high: float) -> bool:
    """Whether values lie to both sides of a zero that most of them are near to."""
    if not low < 0 < high or min(-low, high) < 0.05 * max(-low, high):
        return False
    return bool((np.abs(values) < 0.2 * max(-low, high)).mean() > 0.5)


def _is_bright_background(faces: FloatArray, background: float, otsu: float, low: float) -> bool:
    """Whether the faces hold one bright value, with little noise."""
    spread = 1.4826 * float(np.median(np.abs(faces - background)))
    return bool(background > otsu and (faces > otsu).mean() > 0.9 and spread < 0.1 * (background - low))


def _faces(found: Survey) -> FloatArray:
    """Samples on the faces of the grid, of axes with at least four samples."""
    parts = []
    for axis in range(3):
        if found.samples.shape[axis] < 4:
            continue
        for side in (0, -1):
            values = np.take(found.samples, side, axis=axis)
            parts.append(values[np.take(found.filled, side, axis=axis)])
    return np.concatenate(parts) if parts else np.empty(0)


def _roughness(found: Survey) -> float:
    """Standard deviation of the noise, from differences of neighbours; large where a field is smooth but steep, too."""
    both = found.filled[..., 1:] & found.filled[..., :-1]
    if not both.any():
        return 0.0
    steps = np.diff(found.samples, axis=2)[both]
    return 1.4826 * float(np.median(np.abs(steps))) / 2**0.5


def _changed(found: Survey, **changes: object) -> Survey:
    return replace(found, **changes)  # type: ignore[arg-type]
