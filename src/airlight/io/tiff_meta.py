"""What the metadata of a TIFF file tell of a stack: spacing, unit, channels, time. What is not told is not guessed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .units import unit_name


def read_meta(tif: Any, series: Any) -> Meta:
    """What OME, ImageJ or LSM metadata tell of a series; nothing of other files."""
    if tif.is_ome:
        return _ome_meta(tif, series)
    if tif.is_imagej:
        return _imagej_meta(tif, series)
    if tif.is_lsm:
        told = tif.lsm_metadata or {}
        sizes = tuple(float(told.get(f"VoxelSize{a}") or 0) * 1e6 for a in "XYZ")
        return Meta(*_calibrated(sizes, "um"), modality="microscopy")
    return Meta()


def _imagej_meta(tif: Any, series: Any) -> Meta:
    told = tif.imagej_metadata or {}
    tags = series.keyframe.tags
    across = [_ratio(tags.get(name)) for name in ("XResolution", "YResolution")]
    unit = unit_name(str(told.get("unit") or "").replace("\\u00B5", "µ"))
    # ImageJ leaves out what is 1: a resolution of one sample a unit, a distance of one unit
    sizes = (across[0] or 1.0, across[1] or 1.0, float(told.get("spacing") or 1.0))
    unit = "" if unit in ("pixel", "pixels", "voxel", "null") else unit
    step = float(told.get("finterval") or 0)
    labels = told.get("Labels") or []
    channels = int(told.get("channels") or 1)
    names = tuple(str(n) for n in labels[:channels]) if channels > 1 and len(labels) == channels else ()
    return Meta(*_calibrated(sizes, unit), names, step, unit_name(str(told.get("tunit") or "s")) if step else "")


def _ome_meta(tif: Any, series: Any) -> Meta:
    from defusedxml.ElementTree import fromstring

    root = fromstring(tif.ome_metadata)
    images = [e for e in root if e.tag.rpartition("}")[2] == "Image"]
    ids = [i for i, e in enumerate(images) if e.get("Name", f"Image:{i}") == series.name]
    own = next((i for i, s in enumerate(tif.series) if s is series), 0)
    place = own if len(images) == len(tif.series) else (ids[0] if len(ids) == 1 else 0)
    pixels = next((e for e in images[place] if e.tag.endswith("Pixels")), None) if place < len(images) else None
    if pixels is None:
        return Meta(modality="microscopy")
    units = {unit_name(pixels.get(f"PhysicalSize{a}Unit", "µm")) for a in "XYZ" if pixels.get(f"PhysicalSize{a}")}
    flat = int(pixels.get("SizeZ", "1")) == 1
    sizes = [float(pixels.get(f"PhysicalSize{a}", "0")) for a in "XYZ"]
    sizes[2] = sizes[2] or (sizes[0] if flat else 0.0)
    spacing, unit = _calibrated((sizes[0], sizes[1], sizes[2]), units.pop()) if len(units) == 1 else ((1.0, 1.0, 1.0), "")
    found = [e for e in pixels if e.tag.rpartition("}")[2] == "Channel"]
    names = tuple(e.get("Name") or f"channel {i}" for i, e in enumerate(found))
    step = float(pixels.get("TimeIncrement", "0"))
    time_unit = unit_name(pixels.get("TimeIncrementUnit", "s")) if step else ""
    named = any(e.get("Name") for e in found)
    return Meta(spacing, unit, names if named else (), step, time_unit, "microscopy")


def _calibrated(sizes: tuple[float, ...], unit: str) -> tuple[tuple[float, float, float], str]:
    """All three sizes or none: one alone says nothing of a volume's shape."""
    if len(sizes) != 3 or not all(math.isfinite(s) and s > 0 for s in sizes):
        return (1.0, 1.0, 1.0), ""
    return (sizes[0], sizes[1], sizes[2]), unit


def _ratio(tag: Any) -> float:
    """World size of a sample from a resolution tag, which holds samples a unit as a fraction; 0 where it says nothing."""
    if tag is None or len(np.shape(tag.value)) != 1 or len(tag.value) != 2 or 0 in tag.value:
        return 0.0
    return float(tag.value[1] / tag.value[0])


def number(text: Any) -> float | None:
    """A finite number out of a text tag; None where it is none."""
    try:
        value = float(str(text).strip("\0 ").replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


@dataclass(frozen=True)
class Meta:
    """Spacing (x, y, z) and its unit, names of channels, seconds or so between time steps."""

    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0)
    units: str = ""
    channels: tuple[str, ...] = ()
    time_step: float = 0.0
    time_unit: str = ""
    modality: str = ""
