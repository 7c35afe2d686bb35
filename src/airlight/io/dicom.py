"""DICOM: a series in a folder, one slice, or one enhanced multi-frame file. The world is patient LPS in millimetres."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..errors import AirlightError, DataError, FileError, MissingExtraError
from ..volume import AnyArray, Source, Volume
from .dicom_checks import DEFLATED
from .dicom_geometry import Grid, arrange
from .dicom_header import DIRECTORY, Frame, Header, quiet, read_header
from .given import recipe
from .options import ReadOptions


def read(path: Path, options: ReadOptions) -> Volume:
    """Read a DICOM file, or one series of a folder.

    Rescale slope and intercept are applied; whole ones keep integers. ``options.dataset`` chooses among several series:
    its SeriesInstanceUID, number or description, or the StackID inside an enhanced file. ``options.spacing`` serves
    series without positions, which are then ordered by instance number.

    Parameters
    ----------
    path
        A file, a folder, or a DICOMDIR, which stands for its folder.
    options
        Choices and limits.

    Raises
    ------
    DataError
        Where the slices form no regular grid, or several series are there and none is chosen; it tells the reason.
    FileError
        Where nothing readable is found.
    MissingExtraError
        Where a compression needs a decoder that is not installed.
    """
    headers = _headers(path, options)
    headers = _choose(headers, path, options)
    frames = _choose_stack([f for h in headers for f in h.frames], path, options)
    first = headers[0]
    for header in headers:
        if (header.rows, header.columns) != (first.rows, first.columns):
            raise DataError(
                str(path),
                f"mixes {first.columns} x {first.rows} and {header.columns} x {header.rows} slices "
                f"({first.path.name}, {header.path.name})",
                "keep those of one size in a folder of their own",
            )
    options.check_bytes(str(path), len(frames) * first.rows * first.columns * max(1, first.bits // 8))
    grid = arrange(frames, str(path), options.spacing)
    with quiet():
        array, no_data = _samples(grid, {h.path: h for h in headers}, options)
    return Volume(
        array,
        world_from_index=grid.world_from_index,
        units=grid.units,
        value_unit=first.value_unit,
        times=grid.times,
        time_unit=grid.time_unit,
        no_data=no_data,
        anatomical=grid.anatomical,
        modality=first.modality,
        name=path.name,
        source=Source(str(path), options.dataset, options=recipe(None if grid.anatomical else options.spacing)),
    )


# -- which files


def _headers(path: Path, options: ReadOptions) -> list[Header]:
    if path.is_file() and not _is_directory_file(path):
        header = read_header(path, options, force=True)
        if header is None:
            raise FileError(str(path), "is no DICOM image", "give an image file or a folder of a series")
        return [header]
    folder = path if path.is_dir() else path.parent
    names = [Path(base) / name for base, _, files in sorted(os.walk(folder)) for name in sorted(files)]
    headers, seen = [], set()
    for i, name in enumerate(names):
        options.progress("reading DICOM headers", i, len(names))
        header = read_header(name, options) if name.is_file() else None
        if header is not None and (not header.sop_instance or header.sop_instance not in seen):
            seen.add(header.sop_instance)
            headers.append(header)
    if not headers:
        raise FileError(str(path), f"holds no DICOM image among {len(names)} files")
    return headers


def _is_directory_file(path: Path) -> bool:
    from pydicom.filereader import read_file_meta_info

    with path.open("rb") as stream:
        if stream.read(132)[128:] != b"DICM":
            return False
    with quiet():
        try:
            return str(getattr(read_file_meta_info(path), "MediaStorageSOPClassUID", "")) == DIRECTORY
        except Exception:
            return False


def _choose(headers: list[Header], path: Path, options: ReadOptions) -> list[Header]:
    """Files of the one series that is there or wanted; an enhanced file is a series of its own."""
    series: dict[tuple[str, str], list[Header]] = {}
    for header in headers:
        alone = header.sop_instance if len(header.frames) > 1 else ""
        series.setdefault((header.series, alone), []).append(header)
    wanted = options.dataset.strip()
    found = list(series.values())
    if wanted and not (len(found) == 1 and _stacks(found[0]).issuperset({wanted})):
        found = [
            group
            for group in found
            if wanted in (group[0].series, group[0].sop_instance, group[0].number)
            or wanted.casefold() == group[0].description.casefold()
        ]
    if len(found) == 1:
        return found[0]
    told = "; ".join(
        f"{g[0].number or '-'} {g[0].description!r} {g[0].modality}, {sum(len(h.frames) for h in g)} slices, "
        f"{g[0].series if len(g[0].frames) == 1 else g[0].sop_instance}"
        for g in list(series.values())[:20]
    )
    what = f"holds {len(found)} series" if found else "has no series"
    what += f" {wanted!r}" if wanted else ""
    raise DataError(str(path), what, f"choose one by number, description or UID (--dataset, dataset=): {told}")


def _stacks(headers: list[Header]) -> set[str]:
    return {f.stack for h in headers for f in h.frames if f.stack}


def _choose_stack(frames: list[Frame], path: Path, options: ReadOptions) -> list[Frame]:
    stacks = list(dict.fromkeys(f.stack for f in frames))
    if len(stacks) < 2:
        return frames
    chosen = [f for f in frames if f.stack == options.dataset]
    if not chosen:
        raise DataError(str(path), f"holds {len(stacks)} stacks", f"choose one (--dataset): {', '.join(stacks[:20])}")
    return chosen


# -- samples


def _samples(grid: Grid, headers: dict[Path, Header], options: ReadOptions) -> tuple[AnyArray, float | None]:
    """Array ``(z, y, x)`` or ``(t, 1, z, y, x)`` in the unit of the values, and its no-data value."""
    places = {(f.path, f.index): (t, z) for t, row in enumerate(grid.frames) for z, f in enumerate(row)}
    frames = [f for row in grid.frames for f in row]
    first = frames[0]
    whole = first.slope.is_integer() and first.intercept.is_integer()
    keep = whole and all((f.slope, f.intercept) == (first.slope, first.intercept) for f in frames)
    shape = (len(grid.frames), len(grid.frames[0]), headers[first.path].rows, headers[first.path].columns)
    stored: AnyArray | None = None
    padding: float | None = None
    done = 0
    for path in dict.fromkeys(f.path for f in frames):
        header = headers[path]
        scales = {f.index: f for f in header.frames}
        for index, picture in _pictures(header, [i for p, i in places if p == path] if len(headers) == 1 else None):
            options.progress("reading DICOM slices", done, len(frames))
            done += 1
            if (path, index) not in places:
                continue
            if stored is None:
                dtype = picture.dtype if keep else np.dtype(np.float32)
                options.check_bytes(str(path), int(np.prod(shape, dtype=np.int64)) * dtype.itemsize)
                stored = np.empty(shape, dtype)
            if picture.shape != shape[2:] or (keep and picture.dtype != stored.dtype):
                raise DataError(str(path), f"has {picture.dtype} samples {picture.shape}, others {stored.dtype} {shape[2:]}")
            pads = _pads(picture, header.padding)
            place = stored[places[path, index]]
            if keep:
                place[...] = picture
                if pads is not None and header.padding is not None:
                    padding = header.padding[0] if padding is None else padding
                    place[pads] = padding
            else:
                place[...] = picture * scales[index].slope + scales[index].intercept
                if pads is not None:
                    place[pads] = np.nan
    if stored is None:
        raise FileError(str(first.path), "holds no samples")
    array = _rescaled(stored, int(first.slope), int(first.intercept)) if keep else stored
    no_data = None if padding is None else padding * first.slope + first.intercept
    return (array[:, None] if len(array) > 1 else array[0]), no_data


def _pads(picture: AnyArray, padding: tuple[float, float] | None) -> npt.NDArray[np.bool_] | None:
    if padding is None:
        return None
    mask = picture == padding[0] if padding[0] == padding[1] else (picture >= padding[0]) & (picture <= padding[1])
    return np.asarray(mask) if bool(mask.any()) else None


def _rescaled(stored: AnyArray, slope: int, intercept: int) -> AnyArray:
    """Whole numbers scaled in the narrowest signed type that holds them; untouched where nothing changes."""
    if (slope, intercept) == (1, 0) or stored.dtype.kind not in "iu":
        return stored if (slope, intercept) == (1, 0) else stored * stored.dtype.type(slope) + stored.dtype.type(intercept)
    ends = [int(v) * slope + intercept for v in (stored.min(), stored.max())]
    for dtype in (np.int16, np.int32, np.int64):
        if np.iinfo(dtype).min <= min(ends) and max(ends) <= np.iinfo(dtype).max:
            break
    out = stored.view(dtype) if stored.dtype.itemsize == np.dtype(dtype).itemsize else np.empty(stored.shape, dtype)
    pictures = (-1, *stored.shape[2:])
    for source, target in zip(stored.reshape(pictures), out.reshape(pictures), strict=True):
        np.add(source.astype(np.int64) * slope, intercept, out=target, casting="unsafe")
    return out


def _pictures(header: Header, indices: list[int] | None) -> Iterator[tuple[int, AnyArray]]:
    """Decoded frames of a file, one after the other, with their numbers."""
    from pydicom import dcmread
    from pydicom.pixels import get_decoder, iter_pixels
    from pydicom.uid import UID

    where, name = str(header.path), UID(header.syntax).name
    wanted = sorted(indices) if indices is not None else list(range(len(header.frames)))
    try:
        decoder = get_decoder(UID(header.syntax))
    except NotImplementedError as error:
        raise FileError(where, f"uses the unknown transfer syntax {name}", "convert it with gdcmconv") from error
    if not decoder.is_available:
        raise MissingExtraError(where, f"is compressed ({name})", 'pip install "airlight[dicom]"')
    try:
        source = dcmread(header.path, force=True) if header.syntax == DEFLATED else header.path
        yield from zip(wanted, iter_pixels(source, raw=True, indices=wanted), strict=True)
    except AirlightError:
        raise
    except Exception as error:
        told = f"has pixels that cannot be decoded ({type(error).__name__}: {error})"
        raise FileError(where, told, "copy it again") from error
