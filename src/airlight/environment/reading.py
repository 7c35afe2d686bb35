"""Pictures of environments in files, by well-kept libraries that are imported when they are needed."""

from __future__ import annotations

import math
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
PIXEL_BYTES = 12
NPY = b"\x93NUMPY"


def read_picture(path: Path, max_bytes: int = MOST_BYTES) -> npt.NDArray[Any]:
    """Pixels (h, w, 3 or 4) of a file, linear; not checked further.

    Raises
    ------
    FileError
        When the file is missing, damaged or of another kind.
    LimitError
        When it declares more than 2^27 pixels, or more than ``max_bytes`` of them in float32.
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
        return reader(path, max_bytes)
    except (FileError, LimitError, MissingExtraError):
        raise
    except (OSError, ValueError) as error:  # names with a null character are wrong values
        raise FileError(str(path), f"cannot be read ({getattr(error, 'strerror', None) or error})") from error


def _read_hdr(path: Path, max_bytes: int) -> npt.NDArray[Any]:
    """Radiance's picture of shared exponents; the size is checked before a byte is unpacked."""
    try:
        import imagecodecs
    except ImportError as error:
        raise MissingExtraError(str(path), "needs imagecodecs to be read", 'pip install "airlight[hdr]"') from error
    data = path.read_bytes()
    head, _, rest = data.partition(b"\n\n")
    line, _, packed = rest.partition(b"\n")
    size = re.fullmatch(rb"-Y (\d{1,6}) \+X (\d{1,6})", line)
    if not head.startswith(b"#?") or len(head) > HEADER_BYTES or size is None:
        raise FileError(str(path), "is no Radiance picture of rows from the top (-Y h +X w)", "save it again as .hdr or .exr")
    height, width = int(size[1]), int(size[2])
    _check_size(path, height, width, max_bytes)
    exposure = _exposure(path, head.splitlines()[1:])
    try:
        # The decoder is told no more than what was understood here.
        plain = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width)
        return np.asarray(imagecodecs.rgbe_decode(plain + packed)).reshape(height, width, 3) / exposure
    except (ValueError, RuntimeError) as error:
        raise FileError(str(path), f"is damaged ({error})", "save it again") from error


def _exposure(path: Path, lines: list[bytes]) -> npt.NDArray[np.float32]:
    """What radiance was multiplied by, for one or three channels: the product of what lines of a header say.

    Exposures and colour corrections add up, and the format must be RGB (Radiance's manual, File Formats).
    """
    total = np.ones(3)
    for line in lines:
        name, _, value = (part.strip() for part in line.partition(b"="))
        if name == b"FORMAT" and value != b"32-bit_rle_rgbe":
            raise FileError(str(path), f"holds {value.decode(errors='replace')!r}, not RGB", "convert it by ra_xyze -r")
        if name in (b"EXPOSURE", b"COLORCORR"):
            try:
                factors = [float(part) for part in value.split()]
            except ValueError:
                factors = []
            sound = len(factors) == (1 if name == b"EXPOSURE" else 3) and all(math.isfinite(f) and f > 0 for f in factors)
            if not sound:
                raise FileError(str(path), f"is damaged (its header says {line.decode(errors='replace')!r})", "save it again")
            total *= factors
    with np.errstate(all="ignore"):
        found = total.astype(np.float32)
    if not (np.isfinite(found).all() and (found > 0).all()):
        raise FileError(str(path), f"has exposures whose product is {total.tolist()}", "save it again")
    return found


def _read_exr(path: Path, max_bytes: int) -> npt.NDArray[Any]:
    """The colour channels of the first part of an OpenEXR file."""
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtraError(str(path), "needs OpenEXR to be read", 'pip install "airlight[exr]"') from error
    try:
        with OpenEXR.File(str(path), header_only=True) as file:
            low, high = file.header()["dataWindow"]
        width, height = (int(b) - int(a) + 1 for a, b in zip(low, high, strict=True))
        _check_size(path, height, width, max_bytes)
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: np.asarray(channel.pixels) for name, channel in file.channels().items()}
        grey = channels.get("Y")
        colours = [channels.get(name, grey) for name in "RGB"]
        if any(colour is None for colour in colours):
            raise FileError(str(path), f"has the channels {', '.join(sorted(channels))}", "it must have R, G and B, or Y")
        return np.stack([np.asarray(colour, dtype=np.float32) for colour in colours], axis=-1)
    except (RuntimeError, TypeError, ValueError, KeyError) as error:
        raise FileError(str(path), f"is no OpenEXR picture that can be read ({error})", "save it again") from error


def _read_npy(path: Path, max_bytes: int) -> npt.NDArray[Any]:
    """Return the array of a NumPy file."""
    with path.open("rb") as file:
        if file.read(len(NPY)) != NPY:
            raise FileError(str(path), "is no array of NumPy", "np.save(path, radiance)")
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError, OverflowError, TypeError) as error:
        raise FileError(str(path), f"is no array that can be read ({error})", "np.save(path, radiance)") from error
    if array.ndim == 3:
        _check_size(path, array.shape[0], array.shape[1], max_bytes)
    return np.asarray(array)


def _check_size(path: Path, height: int, width: int, max_bytes: int) -> None:
    most = min(MOST_PIXELS, max_bytes // PIXEL_BYTES)
    if not (height > 0 and width > 0 and height * width <= most):
        raise LimitError(str(path), f"declares {width} x {height} pixels, at most {most:,} are read", "reduce the picture")
