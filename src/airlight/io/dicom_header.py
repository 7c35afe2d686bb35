"""What a DICOM file says of its frames: geometry, scale of values, moment in time. No pixels and no patient data."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import AirlightError, DataError, FileError
from .dicom_checks import TAGS, check_deflated, check_drawable, check_frame_count
from .options import ReadOptions

DIRECTORY = "1.2.840.10008.1.3.10"


@contextmanager
def quiet() -> Iterator[None]:
    """Hush pydicom's warnings: what matters of them is checked here and told as an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def read_header(path: Path, options: ReadOptions, *, force: bool = False) -> Header | None:
    """Header of an image; None where the file is no DICOM file or holds no image.

    ``force`` also takes files without the DICOM preamble.
    """
    import pydicom
    from pydicom.errors import InvalidDicomError

    with quiet():
        try:
            with path.open("rb") as stream:
                if stream.read(132)[128:] != b"DICM" and not force:
                    return None
            check_deflated(path, options)
            dataset = pydicom.dcmread(path, stop_before_pixels=True, specific_tags=list(TAGS), force=force)
            if getattr(dataset.file_meta, "MediaStorageSOPClassUID", "") == DIRECTORY or "Rows" not in dataset:
                return None
            return _header(path, dataset)
        except InvalidDicomError:
            return None
        except AirlightError:
            raise
        except OSError as error:
            raise FileError(str(path), f"cannot be read ({error})") from error
        except Exception as error:
            raise FileError(str(path), f"is a damaged DICOM file ({type(error).__name__}: {error})") from error


@dataclass(frozen=True)
class Frame:
    """One picture: where it lies, how its stored values scale, and what tells it from others at the same place."""

    path: Path
    index: int
    instance: float
    position: tuple[float, ...] | None
    orientation: tuple[float, ...] | None
    spacing: tuple[float, ...] | None
    thickness: float
    slope: float
    intercept: float
    stack: str
    moments: tuple[tuple[str, float, str], ...]
    traits: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Header:
    """What one file says."""

    path: Path
    sop_instance: str
    series: str
    number: str
    description: str
    modality: str
    value_unit: str
    syntax: str
    rows: int
    columns: int
    bits: int
    padding: tuple[float, float] | None
    frames: tuple[Frame, ...]


def _header(path: Path, dataset: Any) -> Header:
    where = str(path)
    rows, columns, count = int(dataset.Rows), int(dataset.Columns), int(dataset.get("NumberOfFrames") or 1)
    bits = int(dataset.get("BitsAllocated") or 0)
    syntax = str(getattr(dataset.file_meta, "TransferSyntaxUID", "1.2.840.10008.1.2"))
    if rows < 1 or columns < 1 or count < 1:
        raise FileError(where, f"declares {columns} x {rows} x {count} samples")
    check_frame_count(path, syntax, rows * columns * bits * count // 8, count)
    check_drawable(where, dataset)
    shared = _first(dataset, "SharedFunctionalGroupsSequence")
    per_frame = list(dataset.get("PerFrameFunctionalGroupsSequence") or ())
    if per_frame and len(per_frame) != count:
        raise FileError(where, f"describes {len(per_frame)} frames and declares {count}")
    frames = [_frame(path, i, dataset, shared, per_frame[i] if per_frame else None) for i in range(count)]
    if count > 1 and not per_frame:
        frames = _place_offsets(where, dataset, frames)
    low = dataset.get("PixelPaddingValue")
    high = dataset.get("PixelPaddingRangeLimit", low)
    return Header(
        path,
        str(dataset.get("SOPInstanceUID", "")),
        str(dataset.get("SeriesInstanceUID", "")),
        str(dataset.get("SeriesNumber") or ""),
        str(dataset.get("SeriesDescription") or ""),
        str(dataset.get("Modality") or ""),
        _value_unit(dataset, shared, per_frame),
        syntax,
        rows,
        columns,
        bits,
        None if low is None or high is None else (float(min(low, high)), float(max(low, high))),
        tuple(frames),
    )


def _frame(path: Path, index: int, dataset: Any, shared: Any, own: Any) -> Frame:
    def find(keyword: str, *groups: str) -> Any:
        """A value from the frame's own group, the shared one, or the top, in the order of the standard."""
        for holder in (own, shared):
            for group in groups:
                item = None if holder is None else _first(holder, group)
                if item is not None and item.get(keyword) is not None:
                    return item.get(keyword)
        return dataset.get(keyword)

    content = _first(own, "FrameContentSequence") if own is not None else None
    slope = find("RescaleSlope", "PixelValueTransformationSequence")
    if slope is None:
        slope = dataset.get("DoseGridScaling")
    thickness = find("SpacingBetweenSlices", "PixelMeasuresSequence") or find("SliceThickness", "PixelMeasuresSequence")
    return Frame(
        path,
        index,
        float(dataset.get("InstanceNumber") or 0) + index,
        _floats(find("ImagePositionPatient", "PlanePositionSequence"), 3),
        _floats(find("ImageOrientationPatient", "PlaneOrientationSequence"), 6),
        _floats(find("PixelSpacing", "PixelMeasuresSequence") or dataset.get("ImagerPixelSpacing"), 2),
        abs(float(thickness or 0)),
        1.0 if slope is None else float(slope),
        float(find("RescaleIntercept", "PixelValueTransformationSequence") or 0),
        str(content.get("StackID") or "") if content is not None else "",
        tuple(_moments(dataset, content, find)),
        tuple(_traits(find)),
    )


def _moments(dataset: Any, content: Any, find: Callable[..., Any]) -> Iterator[tuple[str, float, str]]:
    offset = find("TemporalPositionTimeOffset", "TemporalPositionSequence")
    if offset is not None:
        yield "TemporalPositionTimeOffset", float(offset), "s"
    index = content.get("TemporalPositionIndex") if content is not None else dataset.get("TemporalPositionIdentifier")
    resolution = dataset.get("TemporalResolution")
    if index is not None:
        yield "TemporalPosition", float(index) * float(resolution or 1), "ms" if resolution else ""
    trigger = find("NominalCardiacTriggerDelayTime", "CardiacSynchronizationSequence")
    trigger = dataset.get("TriggerTime") if trigger is None else trigger
    for name, value in (("TriggerTime", trigger), ("FrameReferenceTime", dataset.get("FrameReferenceTime"))):
        if value is not None:
            yield name, float(value), "ms"


def _traits(find: Callable[..., Any]) -> Iterator[tuple[str, str]]:
    for name, keyword, *groups in (
        ("echo time", "EffectiveEchoTime", "MREchoSequence"),
        ("echo time", "EchoTime"),
        ("echo number", "EchoNumbers"),
        ("b-value", "DiffusionBValue", "MRDiffusionSequence"),
        ("inversion time", "InversionTime"),
        ("image type", "FrameType", "MRImageFrameTypeSequence", "CTImageFrameTypeSequence", "PETFrameTypeSequence"),
        ("image type", "ImageType"),
        ("component", "ComplexImageComponent", "MRImageFrameTypeSequence"),
        ("acquisition", "AcquisitionNumber"),
        ("segment", "ReferencedSegmentNumber", "SegmentIdentificationSequence"),
    ):
        value = find(keyword, *groups)
        if value is not None:
            yield name, str(value)


def _place_offsets(where: str, dataset: Any, frames: list[Frame]) -> list[Frame]:
    """Frames of a dose grid, which gives one position and offsets; other plain multi-frame files place no frame."""
    offsets = dataset.get("GridFrameOffsetVector")
    if offsets is None:
        if dataset.get("FrameTime") is not None or dataset.get("FrameTimeVector") is not None:
            raise DataError(where, f"is a film of {len(frames)} pictures in time, no volume", "draw volumes")
        return [replace(frame, position=None) for frame in frames]
    position, across = frames[0].position, frames[0].orientation
    if len(offsets) != len(frames) or position is None or across is None:
        raise FileError(where, "has frame offsets that do not fit its frames")
    (a, b, c), (d, e, f) = across[:3], across[3:]
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    shifts = [float(o) - float(offsets[0]) for o in offsets]
    return [
        replace(frame, position=tuple(p + shift * n for p, n in zip(position, normal, strict=True)))
        for frame, shift in zip(frames, shifts, strict=True)
    ]


def _value_unit(dataset: Any, shared: Any, per_frame: list[Any]) -> str:
    holders = [h for h in (per_frame[0] if per_frame else None, shared) if h is not None]
    groups = [_first(h, "PixelValueTransformationSequence") for h in holders]
    kinds = [g.get("RescaleType") for g in groups if g is not None] + [dataset.get("RescaleType")]
    kind = next((str(k) for k in kinds if k), "")
    if kind:
        return "" if kind == "US" or "UNITLESS" in kind.upper() else kind
    if dataset.get("Modality") == "CT" and "LOCALIZER" not in (dataset.get("ImageType") or ()):
        return "HU"
    return str(dataset.get("Units") or dataset.get("DoseUnits") or "").replace("BQML", "Bq/ml").replace("GY", "Gy")


def _first(holder: Any, keyword: str) -> Any:
    sequence = holder.get(keyword) if holder is not None else None
    return sequence[0] if sequence else None


def _floats(values: Any, count: int) -> tuple[float, ...] | None:
    if values is None or isinstance(values, str) or len(values) != count:
        return None
    return tuple(float(v) for v in values)
