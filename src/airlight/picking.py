"""From a pixel of an image to the point of the world that it shows, and what is there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING

import numpy as np

from .errors import DataError, ValueRangeError
from .first_picture import resolve, resolved_camera
from .inspecting import gradients_at, labels_at, layer_of, pieces, sample_at, setup_of, values_at
from .reference.integrate import INTEGRATES, EmissionAbsorption
from .reference.setup import Sample, Setup
from .reference.transfer import colour
from .scene import Scene, check_scene
from .transfer.given import listed
from .volume import FloatArray

if TYPE_CHECKING:
    from .rendering.image import Image

Point = tuple[float, float, float]
ALLOWANCE = 1e-3
"""Part of a voxel by which points may lie outside: a float32 depth is as exact."""


@dataclass(frozen=True)
class Picked:
    """What a pixel shows.

    Attributes
    ----------
    p_world, p_index
        The point, x, y, z, in the world and in voxels of the layer's volume.
    t_world
        Its distance along the pixel's ray, as in ``image.depth``.
    values
        Values of the layer's field there in data units, one for each channel that its function looks at; NaN where empty,
        and outside of the volume, as on a mesh.
    gradient
        Gradient of the field in data units per world unit, of the first channel, or the mixture that is drawn.
    label, label_name
        Label of the voxel there, and its name; None without labels.
    layer
        Number of the visible layer that these are of.
    """

    p_world: Point
    p_index: Point
    t_world: float
    values: tuple[float, ...]
    gradient: Point
    label: int | None = None
    label_name: str | None = None
    layer: int = 0

    @property
    def value(self) -> float:
        """Value of the first channel."""
        return self.values[0]

    @property
    def normal(self) -> Point:
        """Unit vector against the gradient, towards lower values; 0 where there is no gradient."""
        length = math.hypot(*self.gradient)
        x, y, z = (-c / length if length > 0 else 0.0 for c in self.gradient)
        return x, y, z


def picked(image: Image, scene: Scene, pixel: tuple[int, int], layer: int | None = None) -> Picked | None:
    """Return what a pixel shows of one of the visible layers; None where the image has no depth. See ``image.pick``."""
    point = pick(image, scene, pixel)
    if point is None:
        return None
    scene = resolve(scene, image.size)
    p_world = np.array([point])
    number = seen_layer(scene, p_world, image.size) if layer is None else layer
    chosen = layer_of(scene, number)
    setup = setup_of(scene, chosen, image.size)
    ((_, near),) = pieces(setup, p_world)
    p_index = setup.index_of(p_world)[0]
    x, y, z = p_index.tolist()
    low, high = setup.domain
    inside = bool(((p_index >= low - ALLOWANCE) & (p_index <= high + ALLOWANCE)).all())
    values = np.atleast_1d(values_at(near, p_world)[0]) if inside else np.full(len(setup.channels), np.nan)
    label = None if (found := labels_at(chosen, p_world)) is None else int(found[0])
    slope_x, slope_y, slope_z = gradients_at(near, p_world)[0].tolist() if inside else (0.0, 0.0, 0.0)
    return Picked(
        p_world=point,
        p_index=(x, y, z),
        t_world=float(image.depth[pixel[1], pixel[0]]),
        values=tuple(values.tolist()),
        gradient=(slope_x, slope_y, slope_z),
        label=label,
        label_name=None if label is None or chosen.labels is None else chosen.labels.name_of(label),
        layer=number,
    )


def seen_layer(scene: Scene, p_world: FloatArray, size_px: tuple[int, int]) -> int:
    """Number of the visible layer that shows most at a point (1, 3).

    It is the most opaque one, whose surface is nearest, or for projections of values which is brightest there.
    """
    visible = scene.visible_layers
    if len(visible) <= 1:
        return 0
    shown = []
    drawn, length_world = scene.drawn_layers, min(min(layer.volume.spacing) for layer in visible)
    for layer in visible:
        setup = setup_of(scene, layer, size_px)
        ((_, near),) = pieces(setup, p_world)
        low, high = setup.domain
        here = sample_at(near, p_world, np.zeros(1))
        inside = ((here.p_index >= low - ALLOWANCE) & (here.p_index <= high + ALLOWANCE)).all()
        is_there = inside and not here.empty[0] and any(layer is one for one in drawn)
        shown.append(_strength(near, here, length_world) if is_there else -np.inf)
    return int(np.argmax(shown))


def _strength(setup: Setup, here: Sample, length_world: float) -> float:
    """Opacity of a length of what lies at a sample; of surfaces how near they are, as a negative distance.

    Of projections of values the brightness there.
    """
    integrate = INTEGRATES[setup.stages["integrate"].name](setup)
    if not integrate.uses_slabs:
        return float(colour(setup, here).sum())
    if not integrate.has_surface:
        alpha = EmissionAbsorption(setup).classify(here, here, np.array([length_world])).alpha
        return float(alpha[0])
    slope = float(np.linalg.norm(gradients_at(setup, here.p_world)[0]))
    return -abs(float(np.atleast_2d(here.value)[0, 0]) - integrate.level) / max(slope, 1e-30)


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
    check_scene(scene, "pass the airlight.Scene that the image shows")
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
