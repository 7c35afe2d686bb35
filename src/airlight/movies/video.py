"""H.264 and VP9 through av: sRGB frames in, BT.709 with its matrix, range and tags out."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import FileError
from .targets import Target

Picture = npt.NDArray[np.uint8]

# Codes of ITU-T H.273. The curve is that of sRGB, as the pictures are; players that know no other take it for BT.709's.
MATRIX_BT709, PRIMARIES_BT709, CURVE_SRGB = 1, 1, 13
LIMITED, FULL = 1, 2
SEEK_S = 1.0


def write_video(path: Path, pictures: Iterator[Picture], target: Target) -> None:
    """Encode pictures as they come.

    Parameters
    ----------
    path
        File to write.
    pictures
        uint8 sRGB (height, width, 3), or (height, width, 4) with straight alpha, for WebM.
    target
        Kind, frames a second and quality.

    Raises
    ------
    FileError
        When the encoder refuses.
    OSError
        When the file cannot be written.
    """
    import av

    try:
        _encode(path, pictures, target)
    except av.FFmpegError as error:
        if isinstance(error, OSError):
            raise
        raise FileError(str(target.path), f"cannot be encoded ({error})", "try another size, or another ending") from error


def _encode(path: Path, pictures: Iterator[Picture], target: Target) -> None:
    import av

    rate = Fraction(target.fps).limit_denominator(1001)
    flags = {"movflags": "faststart"} if target.kind == "mp4" else {}
    first = next(pictures)
    alpha = first.shape[2] == 4
    with av.open(str(path), "w", format=target.kind, options=flags) as container:
        stream: Any = container.add_stream("libx264" if target.kind == "mp4" else "libvpx-vp9", rate=rate)
        stream.height, stream.width = first.shape[:2]
        stream.pix_fmt = "yuva420p" if alpha else "yuv420p"
        stream.options = _options(target, alpha)
        codec = stream.codec_context
        codec.gop_size = max(round(SEEK_S * target.fps), 1)
        codec.colorspace, codec.color_primaries, codec.color_trc = MATRIX_BT709, PRIMARIES_BT709, CURVE_SRGB
        codec.color_range = LIMITED
        for number, picture in enumerate(_chained(first, pictures)):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgba" if alpha else "rgb24")
            frame = frame.reformat(
                format=stream.pix_fmt,
                src_color_range=FULL,
                dst_color_range=LIMITED,
                dst_colorspace=MATRIX_BT709,
                dst_color_trc=CURVE_SRGB,
                dst_color_primaries=PRIMARIES_BT709,
                interpolation="AREA",  # colours of four pixels are their mean
            )
            frame.pts, frame.time_base = number, 1 / rate
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def _options(target: Target, alpha: bool) -> dict[str, str]:
    """Options of an encoder: quality is constant, and bits go where they are needed."""
    poor = 1 - target.quality / 100
    if target.kind == "mp4":
        return {"crf": f"{10 + 40 * poor:.0f}", "preset": "medium"}
    options = {"crf": f"{14 + 49 * poor:.0f}", "b": "0", "row-mt": "1", "cpu-used": "4"}
    return options | ({"auto-alt-ref": "0"} if alpha else {})


def _chained(first: Picture, rest: Iterator[Picture]) -> Iterator[Picture]:
    yield first
    yield from rest
