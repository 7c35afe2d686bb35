"""Pictures of environments in files, by well-kept libraries that are imported when they are needed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import FileError, LimitError, MissingExtraError

ENDINGS = (".hdr", ".exr", ".npy")
MOST_PIXELS = 1 << 27
MOST_BYTES = 1 << 31
HEADER_BYTES = 1 << 16


def read_picture(path: Path) -> npt.NDArray[Any]:
    """Pixels (h, w, 3 or 4) of a file, linear; not checked further.

    Raises
    ------
    FileError
        When the file is missing, damaged or of another kind.
    LimitError
        When it declares more than 2^27 pixels.
    MissingExtraError
        When its library is not installed.
    """
    readers = {".hdr": _read_hdr, ".exr": _read_exr, ".npy": _read_npy}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise FileError(str(path), "is no picture of an environment", f"use one of {', '.join(ENDINGS)}, or a built-in one")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise LimitError(str(path), "is larger than 2 GiB", "reduce the picture")
        return reader(path)
    except (FileError, LimitError, MissingExtraError):
        raise
    except OSError as error:
        raise FileError(str(path), f"cannot be read ({error.strerror or error})") from error


def _read_hdr(path: Path) -> npt.NDArray[Any]:
    """Radiance's picture of shared exponents; the size is checked before a byte is unpacked."""
    try:
        import imagecodecs
    except ImportError as error:
        raise MissingExtraError(str(path), "needs imagecodecs to be read", 'pip install "airlight[hdr]"') from error
    data = path.read_bytes()
    size = re.search(rb"\n-Y (\d{1,6}) \+X (\d{1,6})\n", data[:HEADER_BYTES])
    if not data.startswith(b"#?") or size is None:
        raise FileError(str(path), "is no Radiance picture of rows from the top (-Y h +X w)", "save it again as .hdr or .exr")
    height, width = int(size[1]), int(size[2])
    _check_size(path, height, width)
    try:
        pixels = np.asarray(imagecodecs.rgbe_decode(data))
    except (ValueError, RuntimeError) as error:
        raise FileError(str(path), f"is damaged ({error})", "save it again") from error
    return pixels.reshape(height, width, 3)


def _read_exr(path: Path) -> npt.NDArray[Any]:
    """The colour channels of the first part of an OpenEXR file."""
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtraError(str(path), "needs OpenEXR to be read", 'pip install "airlight[exr]"') from error
    try:
        with OpenEXR.File(str(path), header_only=True) as file:
            low, high = file.header()["dataWindow"]
        width, height = (int(b) - int(a) + 1 for a, b in zip(low, high, strict=True))
        _check_size(path, height, width)
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: np.asarray(channel.pixels) for name, channel in file.channels().items()}
    except (RuntimeError, TypeError, ValueError, KeyError) as error:
        raise FileError(str(path), f"is no OpenEXR picture that can be read ({error})", "save it again") from error
    grey = channels.get("Y")
    colours = [channels.get(name, grey) for name in "RGB"]
    if any(colour is None for colour in colours):
        raise FileError(str(path), f"has the channels {', '.join(sorted(channels))}", "it must have R, G and B, or Y")
    return np.stack([np.asarray(colour, dtype=np.float32) for colour in colours], axis=-1)


def _read_npy(path: Path) -> npt.NDArray[Any]:
    """Return the array of a NumPy file."""
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise FileError(str(path), f"is no array that can be read ({error})", "np.save(path, radiance)") from error
    if array.ndim == 3:
        _check_size(path, *array.shape[:2])
    return np.asarray(array)


def _check_size(path: Path, height: int, width: int) -> None:
    if not (height > 0 and width > 0 and height * width <= MOST_PIXELS):
        raise LimitError(
            str(path), f"declares {width} x {height} pixels, at most {MOST_PIXELS:,} are read", "reduce the picture"
        )
