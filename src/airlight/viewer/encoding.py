"""Pictures as bytes: JPEG while something moves, PNG, of which nothing is lost, at rest."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import numpy.typing as npt

from ..rendering.image import Image

Pixels = npt.NDArray[np.uint8]

CHECK_PX = 12
CHECKS = (118, 138)
"""sRGB greys of the checkerboard behind what is transparent."""


def pixels_of(image: Image, scale: float = 1.0) -> Pixels:
    """Return what is shown of an image (h, w, 3), sRGB: over its background, or over a checkerboard where there is none.

    Parameters
    ----------
    image
        The image, ``scale`` times as large as it is shown.
    """
    picture = image.picture()
    if picture.shape[-1] == 3:
        return np.ascontiguousarray(picture)
    y, x = (np.arange(n) // max(1, round(CHECK_PX * scale)) for n in picture.shape[:2])
    behind = np.where((y[:, None] + x) % 2, *(np.float32(grey) for grey in CHECKS))[..., None]
    alpha = picture[..., 3:] / np.float32(255)
    return (picture[..., :3] * alpha + behind * (1 - alpha) + 0.5).astype(np.uint8)


def jpeg(pixels: Pixels, quality: int) -> bytes:
    """Return pixels (h, w, 3) as JPEG, colours at half the resolution; by simplejpeg, or by Pillow where that is missing."""
    try:
        import simplejpeg
    except ImportError:
        return pillow_jpeg(pixels, quality)
    data: bytes = simplejpeg.encode_jpeg(pixels, quality, colorspace="RGB", colorsubsampling="420", fastdct=True)
    return data


def pillow_jpeg(pixels: Pixels, quality: int) -> bytes:
    """As ``jpeg``, by Pillow."""
    from PIL import Image as Pillow

    held = io.BytesIO()
    Pillow.fromarray(pixels).save(held, "jpeg", quality=quality, subsampling="4:2:0")
    return held.getvalue()


def png(pixels: Pixels) -> bytes:
    """Return pixels (h, w, 3) as PNG: each row as its difference from the one above, packed quickly rather than tightly."""
    height, width, channels = pixels.shape
    plain = pixels.reshape(height, width * channels)
    rows = np.empty((height, 1 + width * channels), dtype=np.uint8)
    rows[:, 0] = 2  # the filter "up"
    rows[0, 1:] = plain[0]
    np.subtract(plain[1:], plain[:-1], out=rows[1:, 1:])
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 1)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(data, zlib.crc32(kind)))
