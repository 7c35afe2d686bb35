"""What is looked at in a DICOM file, and what is refused before a pixel is read."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Any

from ..errors import DataError, FileError
from .options import ReadOptions

DEFLATED = "1.2.840.10008.1.2.1.99"

# Only these are ever parsed: names, dates and comments of the patient stay in the file.
TAGS = [
    "SOPClassUID",
    "SOPInstanceUID",
    "SeriesInstanceUID",
    "SeriesNumber",
    "SeriesDescription",
    "Modality",
    "ImageType",
    "InstanceNumber",
    "Rows",
    "Columns",
    "NumberOfFrames",
    "SamplesPerPixel",
    "PhotometricInterpretation",
    "BitsAllocated",
    "BitsStored",
    "PixelRepresentation",
    "ImagePositionPatient",
    "ImageOrientationPatient",
    "PixelSpacing",
    "ImagerPixelSpacing",
    "SliceThickness",
    "SpacingBetweenSlices",
    "RescaleSlope",
    "RescaleIntercept",
    "RescaleType",
    "ModalityLUTSequence",
    "PixelPaddingValue",
    "PixelPaddingRangeLimit",
    "Units",
    "GridFrameOffsetVector",
    "DoseGridScaling",
    "DoseUnits",
    "FrameTime",
    "FrameTimeVector",
    "TemporalPositionIdentifier",
    "TemporalResolution",
    "TriggerTime",
    "FrameReferenceTime",
    "EchoTime",
    "EchoNumbers",
    "DiffusionBValue",
    "AcquisitionNumber",
    "InversionTime",
    "ComplexImageComponent",
    "SharedFunctionalGroupsSequence",
    "PerFrameFunctionalGroupsSequence",
]


def check_drawable(where: str, dataset: Any) -> None:
    """Refuse colours, tables of values and mosaics, with the remedy."""
    photometric, samples = str(dataset.get("PhotometricInterpretation") or ""), int(dataset.get("SamplesPerPixel") or 1)
    if samples != 1 or photometric not in ("MONOCHROME1", "MONOCHROME2", ""):
        raise DataError(where, f"holds colours ({photometric})", "convert it to one grey value a sample")
    if dataset.get("ModalityLUTSequence"):
        raise DataError(where, "scales its values by a look-up table", "convert it with a rescale slope and intercept")
    if "MOSAIC" in (dataset.get("ImageType") or ()):
        raise DataError(where, "is a Siemens mosaic, many slices in one picture", "convert it with dcm2niix")


def check_frame_count(path: Path, syntax: str, needed: int, count: int) -> None:
    """Refuse more frames than the file can hold."""
    size = path.stat().st_size
    native = syntax in ("1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2")
    if (native and needed > size) or (syntax != DEFLATED and count > size):
        raise FileError(str(path), f"is truncated: {count} frames are declared, {size} bytes are there", "copy it again")


def check_deflated(path: Path, options: ReadOptions) -> None:
    """Inflate in pieces and forget: pydicom inflates without a bound."""
    from pydicom.filereader import read_file_meta_info

    meta = read_file_meta_info(path)
    if getattr(meta, "TransferSyntaxUID", "") != DEFLATED:
        return
    inflate, total = zlib.decompressobj(-zlib.MAX_WBITS), 0
    with path.open("rb") as stream:
        stream.seek(144 + int(meta.FileMetaInformationGroupLength))
        piece = stream.read(1 << 16)
        while piece and not inflate.eof:
            total += len(inflate.decompress(piece, 1 << 20))
            options.check_bytes(str(path), total)
            piece = inflate.unconsumed_tail or stream.read(1 << 16)
