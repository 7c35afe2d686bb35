"""What a volume holds, found from a part of its samples: its kind, its background, and where the object begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..volume import AnyArray, FloatArray, Statistics, Volume, is_empty, statistics

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
    z, y, x = (max(1, n // SAMPLES_PER_AXIS) for n in grid.shape)
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
    return _scalar(found)


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
    if grid.dtype.kind == "f":
        if known.maximum - known.minimum >= MOST_LABELS or not _all_whole(grid, volume.no_data):
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
    """Whether neighbours beside the commonest value are mostly equal, and far apart where they are not."""
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


def _scalar(found: Survey) -> Survey:
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
    background = float(np.median(faces)) if faces.size else float(low)
    at = int(np.clip(np.searchsorted(edges, background) - 1, 0, BINS - 1))
    otsu = _otsu(counts, middle)
    share = counts[: at + 1].sum() / counts.sum()
    surrounded = background < otsu and (faces < otsu).mean() > 0.6
    if not surrounded or share > 0.9995:
        return _changed(found, kind="filled", background=float(low), begin=float(np.percentile(values, 60)))
    noise_top = _noise_top(faces[faces <= otsu], background, otsu)
    peaks, valley = _materials(counts, middle, at, noise_top)
    if not peaks:
        # Noise without a gap to what is bright: go by the spread of the faces' lower half, which holds nothing bright.
        lower = background - faces[faces <= background]
        noise_top = max(noise_top, background + 6 * float(np.median(lower)))
        noise_top = min(noise_top, float(np.percentile(values, 99)))
        begin = max(noise_top, (min(otsu, float(np.percentile(values, 97))) + background) / 2)
        return _changed(found, kind="cloud", background=background, noise_top=noise_top, begin=begin)
    begin = min(valley, (background + peaks[0]) / 2)
    begin = float(np.clip(begin, noise_top, (noise_top + 2 * peaks[0]) / 3))
    return _changed(found, kind="object", background=background, noise_top=noise_top, begin=begin, peaks=peaks)


def _is_signed(values: FloatArray, low: float, high: float) -> bool:
    """Whether values lie to both sides of a zero that most of them are near to."""
    if not low < 0 < high or min(-low, high) < 0.05 * max(-low, high):
        return False
    return bool((np.abs(values) < 0.2 * max(-low, high)).mean() > 0.5)


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


def _noise_top(low_faces: FloatArray, background: float, most: float) -> float:
    spread = 1.4826 * float(np.median(np.abs(low_faces - background)))
    return min(background + max(4 * spread, float(np.percentile(low_faces, 90)) - background), most)


def _otsu(counts: npt.NDArray[np.int64], middle: FloatArray) -> float:
    """Threshold that parts a histogram into the two classes of least variance."""
    weight = np.cumsum(counts) / counts.sum()
    mean = np.cumsum(counts * middle) / counts.sum()
    inside = (weight > 0) & (weight < 1)
    between = np.zeros(len(counts))
    between[inside] = (mean[-1] * weight[inside] - mean[inside]) ** 2 / (weight[inside] * (1 - weight[inside]))
    best = np.flatnonzero(between >= between.max() * (1 - 1e-9))
    return float(middle[best].mean())


def _materials(
    counts: npt.NDArray[np.int64], middle: FloatArray, background_bin: int, noise_top: float
) -> tuple[tuple[float, ...], float]:
    """Peaks of the histogram above the background that stand out from the valley before them, and the first valley."""
    smooth = counts.astype(np.float64)
    for _ in range(3):
        smooth = np.convolve(np.pad(smooth, 2, mode="edge"), (1 / 9, 2 / 9, 3 / 9, 2 / 9, 1 / 9), mode="valid")
    above = counts[middle > noise_top].sum()
    peaks: list[float] = []
    first_valley = 0.0
    valley, top, rising = background_bin, background_bin, False
    for i in range(background_bin + 1, len(smooth)):
        if not rising:
            valley = i if smooth[i] < smooth[valley] else valley
            rising = smooth[i] > 1.25 * smooth[valley] + 4 * np.sqrt(smooth[valley]) and middle[i] > noise_top
            top = i
            continue
        top = i if smooth[i] > smooth[top] else top
        if smooth[i] < 0.8 * smooth[top] or i == len(smooth) - 1:
            if counts[valley : i + 1].sum() > 0.03 * above:
                peaks.append(float(middle[top]))
                first_valley = first_valley or float(middle[valley])
            rising, valley = False, i
    return tuple(peaks), first_valley


def _changed(found: Survey, **changes: object) -> Survey:
    from dataclasses import replace

    return replace(found, **changes)  # type: ignore[arg-type]
