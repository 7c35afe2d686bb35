"""GIF, APNG and single frames by Pillow."""

from __future__ import annotations

import itertools
import shutil
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np
import numpy.typing as npt

from ..errors import FileError
from .targets import FRAME_NAME, NUMBER, Target

if TYPE_CHECKING:
    from PIL.Image import Image as PillowImage

Picture = npt.NDArray[np.uint8]

PALETTE_COLOURS = 255  # one is left for what does not change from frame to frame
PALETTE_PIXELS, PALETTE_ROUNDS = 1 << 19, 3
SAMPLE_WIDTH = 1021


def write_apng(path: Path, pictures: Iterator[Picture], target: Target) -> None:
    """Write an animated PNG without loss; Pillow wants all frames before it begins."""
    first, *rest = _images(pictures)
    with _opened(path, target) as file:
        lasting_ms = _lasting(1 + len(rest), 1000 / target.fps)
        first.save(file, "png", save_all=True, append_images=rest, duration=lasting_ms, loop=0, compress_level=4)


@contextmanager
def _opened(path: Path, target: Target) -> Iterator[BinaryIO]:
    """Open a file to write; what does not change is one frame to Pillow, whose time has 16 bits."""
    try:
        with path.open("wb") as file:
            yield file
    except (OverflowError, ValueError, struct.error) as error:
        what = "cannot be written, a picture in it stays for too long"
        raise FileError(str(target.path), what, "write .mp4 or .webm, or make it shorter") from error


def _lasting(count: int, frame: float) -> list[int]:
    """How long each frame is seen in whole units, of which one takes ``frame``: it ends when it is to, but for rounding."""
    ends = [round(frame * number) for number in range(count + 1)]
    return [end - begin for begin, end in itertools.pairwise(ends)]


def write_gif(path: Path, pictures: Iterator[Picture], target: Target) -> None:
    """Write a GIF with one palette for all frames, so that colours do not flicker, and diffused errors instead of bands.

    The palette needs all frames: median cut, then the means of what is nearest to each colour.
    """
    from PIL import Image as Pillow

    kept = list(pictures)
    pixels = np.concatenate([picture.reshape(-1, 3) for picture in kept])
    some = pixels[:: max(len(pixels) // PALETTE_PIXELS, 1)]
    sample = Pillow.fromarray(np.resize(some, (len(some) // SAMPLE_WIDTH + 1, SAMPLE_WIDTH, 3)))
    palette = sample.quantize(PALETTE_COLOURS, method=Pillow.Quantize.MEDIANCUT, kmeans=PALETTE_ROUNDS)
    del pixels, some, sample
    images = (Pillow.fromarray(one).quantize(palette=palette, dither=Pillow.Dither.FLOYDSTEINBERG) for one in kept)
    lasting_ms = [10 * hundredths for hundredths in _lasting(len(kept), 100 / target.fps)]
    with _opened(path, target) as file:
        next(images).save(file, "gif", save_all=True, append_images=images, duration=lasting_ms, loop=0, optimize=False)


def write_frames(pictures: Iterator[Picture], target: Target) -> None:
    """Write single PNG files, numbered from 1; they come to their place together, once all are written.

    Raises
    ------
    FileError
        When they cannot be written.
    """
    numbered = NUMBER.search(target.path.name) is not None
    folder, name = (target.path.parent, target.path.name) if numbered else (target.path, FRAME_NAME)
    with _folder_beside(target.path) as temporary:
        for number, image in enumerate(_images(pictures), start=1):
            image.save(temporary / (name % number), "png", compress_level=4)
        folder.mkdir(exist_ok=True)
        for file in sorted(temporary.iterdir()):
            file.replace(folder / file.name)


@contextmanager
def _folder_beside(path: Path) -> Iterator[Path]:
    temporary = None
    try:
        temporary = Path(tempfile.mkdtemp(prefix=".airlight-", dir=path.absolute().parent))
        yield temporary
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(str(path), f"cannot be written ({error.strerror})") from error
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)


def _images(pictures: Iterator[Picture]) -> Iterator[PillowImage]:
    from PIL import Image as Pillow

    for picture in pictures:
        yield Pillow.fromarray(picture)
