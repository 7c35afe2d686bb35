"""TIFF: ImageJ, OME (also in several files), LSM and plain stacks, through tifffile."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import AirlightError, DataError, FileError, MissingExtraError
from ..volume import AnyArray, Source, Volume, unmistakable
from .given import recipe
from .options import ReadOptions
from .paths import detached
from .samples import check_kind
from .tiff_meta import number, read_meta

PRIVATE = 32768
OURS = {34412, 42113, 50838, 50839}
"""Private tags that are read: of LSM, GDAL's no-data value, ImageJ's."""

DAMAGE = ("zeroed", "out of range", "invalid TiffData", "corrupted", "truncated")


def read(path: Path, options: ReadOptions) -> Volume:
    """Read a stack of a TIFF file.

    ``options.dataset`` chooses a series by number or name, ``options.level`` a level of its pyramid. Axes come from the
    file (OME, ImageJ, LSM or tifffile's own); an axis without a name counts as z. Spacing is taken only where all three
    sizes are told, else it is ``options.spacing``, or 1, 1, 1, without a unit.

    Raises
    ------
    DataError
        For colours, unknown axes, complex samples, several series without a choice.
    FileError
        For files that are damaged or cut short.
    """
    import tifffile

    with _log() as records:
        try:
            with tifffile.TiffFile(path) as tif:
                _check_description(path, tif)
                series = _choose(tif, path, options)
                _raise_damage(path, records)
                level = _level(series, path, options)
                meta = read_meta(tif, series)
                array, axes = _samples(level, path, options)
                size = (
                    dict(zip(series.axes, series.shape, strict=True)),
                    dict(zip(level.axes, level.shape, strict=True)),
                )
                nodata = series.keyframe.tags.get(42113)
        except AirlightError:
            raise
        except Exception as error:
            if "imagecodecs" in str(error):
                raise MissingExtraError(str(path), f"is compressed ({error})", 'pip install "airlight[tiff]"') from error
            raise FileError(str(path), f"cannot be read as TIFF ({type(error).__name__}: {error})") from error
        _raise_damage(path, records)
    given = options.spacing if not meta.units and meta.spacing == (1.0, 1.0, 1.0) else None
    finest = np.array(given or meta.spacing)
    stack_axis = next((a for a in "ZQI" if a in axes), "Z")
    shrink = np.array([size[0].get(a, 1) / size[1].get(a, 1) for a in ("X", "Y", stack_axis)])
    matrix = np.diag([*(finest * shrink), 1.0])
    matrix[:3, 3] = (shrink - 1) / 2 * finest
    array = _ordered(array, axes)
    counts = (array.shape[-4] if array.ndim > 3 else 1, array.shape[0] if array.ndim == 5 else 1)
    return Volume(
        unmistakable(array),
        world_from_index=matrix,
        units=meta.units,
        channel_names=meta.channels if len(meta.channels) == counts[0] else (),
        times=tuple(i * meta.time_step for i in range(counts[1])) if counts[1] > 1 and meta.time_step else (),
        time_unit=meta.time_unit,
        no_data=number(nodata.value) if nodata is not None else None,
        modality=meta.modality,
        name=path.name,
        source=Source(str(path), options.dataset, options.level, recipe(given)),
    )


# -- which samples


def _choose(tif: Any, path: Path, options: ReadOptions) -> Any:
    found = list(tif.series)
    if not found:
        raise FileError(str(path), "holds no image")
    wanted = options.dataset
    if wanted:
        chosen = [s for i, s in enumerate(found) if wanted in (str(i), s.name)]
    else:
        chosen = found if len(found) == 1 else [s for s in found if any(a in "ZQIT" and n > 1 for a, n in _axes(s))]
    if len(chosen) != 1:
        told = "; ".join(f"{i} {s.name!r} {s.axes} {s.shape}" for i, s in enumerate(found[:20]))
        what = f"has no series {wanted!r}" if wanted and not chosen else f"holds {len(found)} series"
        raise DataError(str(path), what, f"choose one by number or name (--dataset, dataset=): {told}")
    return chosen[0]


def _axes(series: Any) -> list[tuple[str, int]]:
    return list(zip(series.axes, series.shape, strict=True))


def _level(series: Any, path: Path, options: ReadOptions) -> Any:
    if not 0 <= options.level < len(series.levels):
        raise DataError(str(path), f"has no level {options.level}", f"choose 0 to {len(series.levels) - 1} (--level, level=)")
    return series.levels[options.level]


def _samples(level: Any, path: Path, options: ReadOptions) -> tuple[AnyArray, str]:
    where = str(path)
    axes = "".join(a for a, n in _axes(level) if n > 1 or a in "YX")
    if "S" in axes:
        raise DataError(where, f"holds colours (axes {level.axes})", "save its channels as a stack of grey values (axes CZYX)")
    stacks = [a for a in axes if a in "ZQI"]
    strange = [a for a in axes if a not in "TCZYXQI"]
    if strange or len(stacks) > 1 or not {"Y", "X"} <= set(axes):
        raise DataError(
            where,
            f"has axes {level.axes} of {level.shape}, which of them are channel, time and z is not told",
            "write it with tifffile.imwrite(..., metadata={'axes': 'TCZYX'}) or as OME-TIFF",
        )
    check_kind(where, level.dtype)
    options.check_bytes(where, math.prod(level.shape) * level.dtype.itemsize)
    _check_whole(level, path)
    options.progress(f"reading {path.name}", 0, 1)
    array = np.asarray(level.asarray()).reshape([n for a, n in _axes(level) if n > 1 or a in "YX"])
    options.progress(f"reading {path.name}", 1, 1)
    return array, axes


def _ordered(array: AnyArray, axes: str) -> AnyArray:
    axes = axes.replace("Q", "Z").replace("I", "Z")
    order = [axes.index(a) for a in "TCZYX" if a in axes]
    array = array.transpose(order)
    if "Z" not in axes:
        array = np.expand_dims(array, -3)
    if "T" in axes and "C" not in axes:
        array = array[:, None]
    return np.ascontiguousarray(array)


# -- damage that tifffile logs, or fills with zeros


def _check_whole(level: Any, path: Path) -> None:
    size = path.stat().st_size
    if level.dataoffset is not None:
        end = level.dataoffset + math.prod(level.shape) * level.dtype.itemsize
        if end > size:
            raise FileError(str(path), f"is cut short: {end:,} bytes are declared, {size:,} are there", "copy it again")
        return
    for page in level.pages:
        if page is None:
            raise FileError(str(path), "lacks pages that it declares", "copy all files of the set into one folder")
        if page.parent.filehandle.path == str(path.resolve()):
            ends = [o + n for o, n in zip(page.dataoffsets, page.databytecounts, strict=False)]
            if max(ends, default=0) > size:
                raise FileError(str(path), f"is cut short: page {page.index} ends beyond {size:,} bytes", "copy it again")


def _check_description(path: Path, tif: Any) -> None:
    """Refuse what the OME description must not hold, before tifffile parses it: entities, files elsewhere."""
    text = str(tif.pages[0].description or "")
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise FileError(str(path), "has XML entities in its description", "write it without")
    if not tif.is_ome:
        return
    from defusedxml.ElementTree import fromstring

    for element in fromstring(text).iter():
        name = element.get("FileName")
        if name and element.tag.endswith("UUID") and name.lower() != path.name.lower():
            detached(path, name, "FileName")


@contextmanager
def _log() -> Iterator[list[logging.LogRecord]]:
    """What tifffile logs, kept from the terminal."""
    records: list[logging.LogRecord] = []
    handler = logging.Handler(logging.WARNING)
    setattr(handler, "emit", records.append)  # noqa: B010
    logger = logging.getLogger("tifffile")
    before = logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield records
    finally:
        logger.removeHandler(handler)
        logger.propagate = before


def _raise_damage(path: Path, records: list[logging.LogRecord]) -> None:
    for record in records:
        told = record.getMessage()
        tag = re.search(r"TiffTag (\d+)", told)
        if tag and int(tag[1]) >= PRIVATE and int(tag[1]) not in OURS:
            continue  # many vendors write private tags that break the rules and say nothing of the samples
        if record.levelno >= logging.ERROR or any(word in told for word in DAMAGE):
            raise FileError(str(path), f"is damaged ({told[:200]})", "copy or write it again")
