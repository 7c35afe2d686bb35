"""From a pixel of an image to the point of the world that it shows."""

from __future__ import annotations

import math
from numbers import Integral
from typing import TYPE_CHECKING

from .errors import DataError, ValueRangeError
from .first_picture import resolved_camera
from .scene import Scene
from .transfer.given import listed

if TYPE_CHECKING:
    from .rendering.image import Image


def pick(image: Image, scene: Scene, pixel: tuple[int, int]) -> tuple[float, float, float] | None:
    """Point (x, y, z) of the world that a pixel shows; None where the image has no depth.

    It is the surface of ``first_hit``, the extreme of ``mip`` and ``minip``, and else where opacity passes one half.

    Parameters
    ----------
    image
        A rendered image, with its depth.
    scene
        The scene that it shows; a named view is that of the image's size.
    pixel
        Column and row, from 0, counted from the upper left corner.

    Raises
    ------
    ValueRangeError
        For pixels that lie outside of the image or between its pixels.
    DataError
        When there is no image to look at.
    StageError
        When only the device knows the camera's rays.

    Examples
    --------
    >>> import airlight as al
    >>> scene = al.first_picture(al.samples.load("hydrogen", size=32))
    >>> point = al.pick(al.render(scene, (64, 64)), scene, (32, 32))
    >>> value = scene.layers[0].volume.value_at(point)
    >>> function = al.automatic.peak_at(scene.layers[0].volume, point)
    """
    if not hasattr(image, "depth"):
        raise DataError("image", f"is a {type(image).__name__}", "pass what airlight.render returned, then the scene")
    if not isinstance(scene, Scene):
        raise DataError("scene", f"is a {type(scene).__name__}", "pass the airlight.Scene that the image shows")
    width, height = image.size
    parts: tuple[int, ...] = listed(pixel, "pixel", "give (column, row)")
    if len(parts) != 2:
        raise ValueRangeError("pixel", f"is {pixel!r}, must be a whole column and row")
    column, row = parts
    if not (isinstance(column, Integral) and isinstance(row, Integral)):
        raise ValueRangeError("pixel", f"is {(column, row)}, must be a whole column and row")
    if not (0 <= column < width and 0 <= row < height):
        raise ValueRangeError("pixel", f"is {(column, row)}, must lie in the image of {width} x {height}")
    depth = float(image.depth[row, column])
    if not math.isfinite(depth):
        return None
    origin_world, direction_world = resolved_camera(scene, image.size).ray((column + 0.5, row + 0.5), image.size)
    x, y, z = (float(c) for c in origin_world + depth * direction_world)
    return x, y, z
