"""Textures of lights: what comes through of them to the planes of a group of slices, and the pictures that they throw."""

from __future__ import annotations

from typing import Any

import numpy as np
import wgpu

from ..errors import LimitError
from ..light_image import LightImage
from .device import Device

LIGHT_FORMAT, TEXEL_BYTES = "rgba32float", 16
PLANES_FORMAT, PLANE_TEXEL_BYTES = "rgba16float", 8  # what is carried on is not rounded so
PICTURE_FORMAT = "rgba16float"


def light_buffers(device: Device, size: int, texels: int) -> tuple[tuple[Any, Any], Any]:
    """Views of two square textures, for the light at a plane in turn, and of one with so many texels in x for each of theirs.

    They are kept for the next frame. What a ray writes lies side by side: planes one behind the other would be a multiple of
    4096 bytes apart, and drive each other out of caches.

    Raises
    ------
    LimitError
        When the device has no textures of this size.
    """
    most = device.limits["max-texture-dimension-3d"]
    for name, number in (("light_size", size), ("group", texels)):
        if number > most:
            what = f"asks for {number} texels, and textures of {device.info.name} have {most} texels a side at most"
            raise LimitError(f"driver.half_angle.{name}", what, "take less")
    usage = wgpu.TextureUsage

    def view(name: str, shape: tuple[int, int, int], texel_format: str, use: int) -> Any:
        def made() -> Any:
            dimension, use_all = "3d" if name == "planes" else "2d", use | usage.TEXTURE_BINDING
            return device.gpu.create_texture(size=shape, dimension=dimension, format=texel_format, usage=use_all)

        return device.kept.get(("light", name, shape), made).create_view()

    one, other = (view(name, (size, size, 1), LIGHT_FORMAT, usage.RENDER_ATTACHMENT) for name in ("one", "other"))
    return (one, other), view("planes", (texels, size, size), PLANES_FORMAT, usage.STORAGE_BINDING)


def picture_view(device: Device, picture: LightImage) -> Any:
    """View of the texture of a light's picture, kept with it."""
    height, width = picture.pixels.shape[:2]
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST

    def made() -> Any:
        texels = np.ones((height, width, 4), dtype=np.float16)
        texels[..., :3] = picture.pixels
        texture = device.gpu.create_texture(size=(width, height, 1), format=PICTURE_FORMAT, usage=usage)
        layout = {"bytes_per_row": width * 8, "rows_per_image": height}
        device.queue.write_texture({"texture": texture}, texels, layout, (width, height, 1))
        return texture

    return device.kept.get(("picture of a light", picture.digest), made).create_view()
