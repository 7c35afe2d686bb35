"""OME-Zarr 0.1 to 0.5 (Zarr 2 and 3), a chosen level; plain Zarr arrays. Writes OME-Zarr 0.5."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from ..errors import AirlightError, DataError, FileError, MissingExtraError
from ..volume import AnyArray, FloatArray, Source, Volume, unmistakable
from .given import recipe
from .options import ReadOptions
from .samples import byte_count, check_kind
from .units import MILLIMETRES, unit_name
from .zarr_write import write

__all__ = ["read", "write"]

SLAB_BYTES = 32 << 20
OWN = "airlight"


def read(path: Path, options: ReadOptions) -> Volume:
    """Read an image of a Zarr folder (or a zip file of one).

    ``options.dataset`` names an image, a label image (``labels/nuclei``) or an array inside, ``options.level`` a level of
    its pyramid, 0 being the finest.
    """
    with opened(path) as root:
        node = _node(root, path, options.dataset)
        if hasattr(node, "shape"):
            array = _ordered(_samples(node, str(path), options), "tczyx"[-len(node.shape) :])
            source = Source(str(path), options.dataset, options=recipe(options.spacing))
            return Volume(array, spacing=options.spacing, name=path.name, source=source)
        return _image(node, path, options)


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Root node of a store, without warnings; errors of the library told as errors of the file."""
    try:
        import zarr
    except ImportError as error:
        raise MissingExtraError(str(path), "needs zarr to be read", 'pip install "airlight[zarr]"') from error
    if path.is_dir() and not any((path / n).is_file() for n in ("zarr.json", ".zgroup", ".zarray", ".zattrs")):
        raise FileError(str(path), "is no Zarr folder: it has no zarr.json, .zgroup or .zarray", "give the image's folder")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            store = zarr.storage.LocalStore(path, read_only=True) if path.is_dir() else zarr.storage.ZipStore(path, mode="r")
            try:
                yield zarr.open(store=store, mode="r")
            finally:
                store.close()
        except AirlightError:
            raise
        except Exception as error:
            raise FileError(str(path), f"cannot be read as Zarr ({type(error).__name__}: {error})") from error


# -- which image


def _node(root: Any, path: Path, name: str) -> Any:
    if not name:
        return root
    if ".." in PurePosixPath(name).parts or name.startswith("/"):
        raise FileError(str(path), f"has no image {name!r}", "give a path inside the folder")
    if hasattr(root, "shape") or name not in root:
        raise DataError(str(path), f"has no image {name!r}", _choices(root))
    return root[name]


def _choices(root: Any) -> str:
    names = [] if hasattr(root, "shape") else sorted(key for key, _ in root.members())[:20]
    return f"choose one of {', '.join(names)} (--dataset, dataset=)" if names else ""


def _image(node: Any, path: Path, options: ReadOptions) -> Volume:
    where = f"{path}/{options.dataset}" if options.dataset else str(path)
    attributes: dict[str, Any] = dict(node.attrs)
    told: Any = attributes.get("ome", attributes)
    scales = told.get("multiscales") if isinstance(told, dict) else None
    if not scales:
        raise DataError(where, "is a group without an image (no multiscales)", _choices(node))
    image = scales[0]
    levels = image["datasets"]
    if not 0 <= options.level < len(levels):
        raise DataError(where, f"has no level {options.level}", f"choose 0 to {len(levels) - 1} (--level, level=)")
    level = levels[options.level]
    array = _node(node, path, str(level["path"]))
    if not hasattr(array, "shape"):
        raise FileError(where, f"names {level['path']!r} as a level, which is no array")
    axes = _axes(image.get("axes") or list("tczyx"[-len(array.shape) :]), len(array.shape), where)
    names = "".join(a[0] for a in axes)
    scale, shift = _transform([level, image], len(axes), where)
    matrix, units = _world(axes, scale, shift, where)
    samples = _ordered(_samples(array, where, options), names)
    t = names.find("t")
    timed = t >= 0 and samples.ndim == 5 and (axes[t][1] or (scale[t], shift[t]) != (1, 0))
    times = tuple(scale[t] * i + shift[t] for i in range(array.shape[t])) if timed else ()
    own: Any = attributes.get(OWN) if isinstance(attributes.get(OWN), dict) else {}
    channels = [str(c.get("label") or "") for c in (told.get("omero") or {}).get("channels") or ()]
    count = samples.shape[-4] if samples.ndim > 3 else 1
    return Volume(
        unmistakable(samples),
        world_from_index=matrix,
        units=units,
        value_unit=str(own.get("value_unit", "")),
        channel_names=channels if len(channels) == count and any(channels) else (),
        times=times,
        time_unit=axes[t][1] if times else "",
        no_data=None if own.get("no_data") is None else float(own["no_data"]),
        anatomical=bool(own.get("anatomical", False)),
        modality=str(own.get("modality", "labels" if "image-label" in told else "microscopy")),
        name=path.name,
        source=Source(str(path), options.dataset, options.level),
    )


# -- axes and transforms


def _axes(told: list[Any], count: int, where: str) -> list[tuple[str, str]]:
    """One letter and unit an axis, in the order of the array."""
    axes = []
    for axis in told:
        named = axis if isinstance(axis, dict) else {"name": axis}
        name, kind = str(named.get("name", "")).lower(), str(named.get("type", ""))
        letter = {"channel": "c", "time": "t"}.get(kind, name[:1] if name in ("channel", "time") else name)
        axes.append((letter, unit_name(str(named.get("unit") or ""))))
    letters = "".join(a for a, _ in axes)
    if len(axes) != count or len(set(letters)) != count or not set("yx") <= set(letters) <= set("tczyx"):
        raise DataError(where, f"has the axes {letters!r} for {count} dimensions", "they must be x, y, z, and c or t")
    return axes


def _transform(holders: list[Any], count: int, where: str) -> tuple[list[float], list[float]]:
    """Scale and translation of all axes: those of the level first, then those of the whole image."""
    scale, shift = np.ones(count), np.zeros(count)
    for holder in holders:
        for step in holder.get("coordinateTransformations") or ():
            kind = step.get("type")
            values = np.array(step.get(kind) or (), dtype=np.float64) if kind in ("scale", "translation") else None
            if kind == "identity":
                continue
            if values is None or values.shape != (count,) or not np.isfinite(values).all():
                raise DataError(where, f"has a transformation {kind!r} that is not understood", "scale and translation are")
            if kind == "scale":
                scale, shift = scale * values, shift * values
            else:
                shift = shift + values
    return scale.tolist(), shift.tolist()


def _world(axes: list[tuple[str, str]], scale: list[float], shift: list[float], where: str) -> tuple[FloatArray, str]:
    letters = [a for a, _ in axes]
    units = {axes[letters.index(a)][1] for a in "xyz" if a in letters}
    unit = axes[letters.index("x")][1]
    if len(units) > 1 and not units <= set(MILLIMETRES):
        raise DataError(where, f"measures its axes in different units ({', '.join(sorted(units))})", "write one unit")
    matrix = np.eye(4)
    for row, a in enumerate("xyz"):
        if a in letters:
            i = letters.index(a)
            factor = MILLIMETRES[axes[i][1]] / MILLIMETRES[unit] if len(units) > 1 else 1.0
            matrix[row, row], matrix[row, 3] = scale[i] * factor, shift[i] * factor
    return matrix, unit


# -- samples


def _samples(array: Any, where: str, options: ReadOptions) -> AnyArray:
    """All samples, chunk by chunk along the axis with most chunks."""
    check_kind(where, array.dtype)
    byte_count(where, array.dtype, array.shape, options)
    chunks = getattr(array, "shards", None) or array.chunks
    options.check_bytes(where, math.prod(chunks) * array.dtype.itemsize)
    counts = [-(-n // c) for n, c in zip(array.shape, chunks, strict=True)]
    axis = int(np.argmax(counts))
    chunk = chunks[axis]
    row = math.prod(array.shape) * array.dtype.itemsize // array.shape[axis]
    slab = max(1, SLAB_BYTES // max(1, row * chunk)) * chunk
    out = np.empty(array.shape, array.dtype)
    for start in range(0, array.shape[axis], slab):
        options.progress("reading Zarr", start, array.shape[axis])
        place = (slice(None),) * axis + (slice(start, start + slab),)
        out[place] = array[place]
    return out


def _ordered(array: AnyArray, axes: str) -> AnyArray:
    array = array.transpose([axes.index(a) for a in "tczyx" if a in axes])
    if "z" not in axes:
        array = np.expand_dims(array, -3)
    if "t" in axes and "c" not in axes:
        array = array[:, None]
    return np.ascontiguousarray(array)
