"""What a movie is written to: the ending tells the kind, and everything is checked before a frame is drawn."""

from __future__ import annotations

import re
from dataclasses import dataclass
from glob import escape
from importlib.util import find_spec
from pathlib import Path

from ..errors import FileError, LimitError, MissingExtraError, ValueRangeError
from ..transfer.given import check_size, positive, whole

ENDINGS = (".mp4", ".webm", ".gif", ".png")
FRAME_NAME = "frame-%04d.png"
NUMBER = re.compile(r"%0?(\d*)d")
QUALITY = 80
LEAST_FPS, MOST_FPS = 0.01, 240.0
MOST_GIF_FPS = 50.0  # viewers slow down what is faster
MOST_FRAMES = 1_000_000
MOST_H264_PX = 16384
KEPT_BYTES = {"gif": 5, "apng": 8}  # a pixel, of pictures that are held until all are there
MOST_KEPT_BYTES = 2 << 30


@dataclass(frozen=True)
class Target:
    """Where a movie goes, and as what.

    Attributes
    ----------
    path
        File, folder, or the name of single frames with their number as ``%04d``.
    kind
        ``"mp4"``, ``"webm"``, ``"gif"``, ``"apng"`` or ``"frames"``.
    fps
        Frames a second.
    quality
        1 to 100, of ``.mp4`` and ``.webm``.
    """

    path: Path
    kind: str
    fps: float
    quality: int = QUALITY

    @property
    def takes_alpha(self) -> bool:
        """Whether it can be transparent."""
        return self.kind not in ("mp4", "gif")


def checked_target(path: Path, fps: float = 30.0, quality: int | None = None) -> Target:
    """Return what is written to a path.

    Raises
    ------
    FileError
        For endings that say nothing, and folders that are not there or hold frames already.
    ValueRangeError
        For frame rates and qualities that the kind does not have.
    MissingExtraError
        When the package that writes it is missing.
    """
    kind = _kind(path)
    fps = positive(fps, "fps")
    most = MOST_GIF_FPS if kind == "gif" else MOST_FPS
    if fps < LEAST_FPS:
        raise ValueRangeError("fps", f"is {fps:g}, must be at least {LEAST_FPS:g}")
    if fps > most:
        raise ValueRangeError("fps", f"is {fps:g}, must be at most {most:g}" + (" for .gif" if kind == "gif" else ""))
    if quality is not None and kind not in ("mp4", "webm"):
        raise ValueRangeError("quality", "is for .mp4 and .webm", "leave it out")
    if kind in ("mp4", "webm") and find_spec("av") is None:
        raise MissingExtraError(f"writing {path.suffix}", "needs av", 'pip install "airlight[movie]", or write .gif or .png')
    return Target(path, kind, fps, QUALITY if quality is None else whole(quality, "quality", 1, 100))


def check_frames(target: Target, size_px: tuple[int, int], count: int) -> None:
    """Refuse sizes and numbers of frames that a target cannot take.

    Raises
    ------
    ValueRangeError
        For odd sizes of videos; it names the even ones.
    LimitError
        For frames too large for the codec, and more of them than can be held, or counted.
    """
    check_size(size_px)
    width, height = size_px
    if target.kind in ("mp4", "webm") and (width % 2 or height % 2):
        even = f"{width + width % 2}x{height + height % 2}"
        raise ValueRangeError("size", f"is {width}x{height}, and {target.path.suffix} takes even numbers", f"use {even}")
    if target.kind == "mp4" and max(size_px) > MOST_H264_PX:
        what = f"is {width}x{height}, and .mp4 takes at most {MOST_H264_PX:,} pixels a side"
        raise LimitError("size", what, "make it smaller, or write .webm")
    if count > MOST_FRAMES:
        raise LimitError("movie", f"would have {count:,} frames, at most {MOST_FRAMES:,} are allowed", "give less seconds")
    needed = count * width * height * KEPT_BYTES.get(target.kind, 0)
    if needed > MOST_KEPT_BYTES:
        what = f"would hold {needed / 2**30:.1f} GiB of frames in memory, at most {MOST_KEPT_BYTES >> 30} GiB are allowed"
        raise LimitError(str(target.path), what, "write .mp4 or .webm, or make it smaller or shorter")


def _kind(path: Path) -> str:
    numbered = NUMBER.search(path.name)
    single = path.suffix.lower() not in ENDINGS or path.is_dir() or numbered
    folder = path if single and not numbered else path.parent
    if single and not numbered and path.suffix and not path.is_dir():
        raise FileError(str(path), "has no ending that says what to write", f"use {', '.join(ENDINGS)}, or name a folder")
    if numbered and (path.suffix.lower() != ".png" or len(NUMBER.findall(path.name)) > 1 or path.name.count("%") > 1):
        raise FileError(str(path), "is no name of frames", f"write it as {FRAME_NAME}")
    parent = path.absolute().parent
    if not parent.is_dir():
        raise FileError(str(path), "cannot be written, its folder is not there", f"make {parent}")
    if single:
        name = path.name if numbered else FRAME_NAME
        if folder.is_dir() and any(folder.glob(NUMBER.sub("*", escape(name)))):
            raise FileError(str(path), f"has frames already ({NUMBER.sub('*', name)})", "name another folder, or remove them")
        return "frames"
    return {".png": "apng"}.get(path.suffix.lower(), path.suffix.lower()[1:])
