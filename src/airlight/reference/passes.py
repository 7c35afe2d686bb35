"""Passes over a finished picture. ``made(stage, picture) -> what the pass writes (height, width, ...)``.

Overlays: lines on the faces of domains lie wholly before what is inside or wholly behind it, so that two layers of colour
composite with each pixel exactly, ``over`` and under it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ..errors import DataError
from ..scene import Camera
from ..stage import Context, Stage
from ..volume import FloatArray
from .camera import CAMERAS
from .setup import Setup


@dataclass(frozen=True, eq=False)
class Picture:
    """What passes see: ``rgba`` (h, w, 4), share of an environment and depth (h, w), and how they came about."""

    rgba: FloatArray
    backdrop: FloatArray
    depth: FloatArray
    camera: Camera
    setups: Sequence[Setup]
    driver: Stage | None
    step_world: float

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.depth.shape[1], self.depth.shape[0]

    def rays(self, right_px: float = 0.0, down_px: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Origin and direction (h, w, 3) of the rays of pixels, or of places so far from their centres."""
        width, height = self.size_px
        y, x = (axis.ravel() for axis in np.indices((height, width)))
        origin, direction = CAMERAS[self.camera.name](self.camera, self.size_px, x + right_px, y + down_px)
        return origin.reshape(height, width, 3), direction.reshape(height, width, 3)

    def domain(self, setup: Setup) -> tuple[FloatArray, FloatArray]:
        """First corner (3,) of a layer's domain, and its three edges (3, 3), in the world."""
        low, high = setup.domain
        matrix = setup.layer.volume.world_from_index
        return matrix[:3, :3] @ low + matrix[:3, 3], (matrix[:3, :3] * (high - low)).T


def composited(stage: Any, picture: Picture, before: FloatArray, behind: FloatArray) -> FloatArray:
    """Put lines that cover so much (h, w) of pixels behind a picture and over it."""
    line, behind = np.array([*stage.color, 1.0]), behind * stage.opacity
    free = 1 - picture.rgba[..., 3] + picture.backdrop  # of layers and meshes
    under = (1 - behind * picture.backdrop)[..., None] * picture.rgba + (free * behind)[..., None] * line
    over = (before * stage.opacity)[..., None]
    return np.asarray((1 - over) * under + over * line)


def bounding_box(stage: Any, picture: Picture) -> FloatArray:
    """Edges of boxes: how near a ray comes to each, in widths of a pixel there."""
    origin, direction = picture.rays()
    beside = [(o - origin, d - direction) for o, d in (picture.rays(-1.0), picture.rays(1.0))]
    before, behind = np.zeros(picture.depth.shape), np.zeros(picture.depth.shape)
    for setup in picture.setups:
        first, edges = picture.domain(setup)
        t_middle = (direction * (first + edges.sum(axis=0) / 2 - origin)).sum(axis=-1)
        for axis, sides in product(range(3), product((0.0, 1.0), repeat=2)):
            corner = first + np.insert(sides, axis, 0.0) @ edges
            edge, away = edges[axis], origin - corner
            # The least squares of the distance between both lines; the edge ends at its corners.
            along, ahead = direction @ edge, (direction * away).sum(axis=-1)
            share = np.clip((away @ edge - along * ahead) / np.maximum(edge @ edge - along**2, 1e-9 * edge @ edge), 0, 1)
            t = share * along - ahead
            aside = np.linalg.norm(away + t[..., None] * direction - share[..., None] * edge, axis=-1)
            pixel_world = np.min([np.linalg.norm(o + t[..., None] * d, axis=-1) for o, d in beside], axis=0)
            cover = np.where(t >= 0, np.clip(stage.width_px / 2 + 0.5 - aside / pixel_world, 0, 1), 0.0)
            is_before = t < np.minimum(t_middle, picture.depth)
            before, behind = np.maximum(before, cover * is_before), np.maximum(behind, cover * ~is_before)
    return composited(stage, picture, before, behind)


def slice_outlines(stage: Any, picture: Picture) -> FloatArray:
    """Contour lines, on the faces of the domain, of the numbers of slices: how far away the nearest is, to first order."""
    first, edges = picture.domain(picture.setups[0])
    layer, function = picture.setups[0].layer, picture.setups[0].function
    context = Context(
        layer.volume, function, layer.channels, layer.time, picture.step_world, picture.size_px, layer.labels, picture.camera
    )
    told: Any = getattr(picture.driver, "planes", None)
    if told is None:
        raise DataError("driver", "draws no slices", "pass driver=al.driver.Slices()")
    planes = told(picture.camera, context)
    if planes is not None:
        boxes = (picture.domain(setup) for setup in picture.setups)
        corners = [low + np.array(list(product((0.0, 1.0), repeat=3))) @ sides for low, sides in boxes]
        planes = planes.numbered_from(np.concatenate(corners))
    rays = [picture.rays(), picture.rays(1.0), picture.rays(0.0, 1.0)]

    def number(ray: tuple[FloatArray, FloatArray], t: FloatArray) -> FloatArray:
        if planes is None:
            return np.asarray(t / (picture.step_world * stage.every))
        along = (ray[0] + t[..., None] * ray[1]) @ planes.normal
        return np.asarray((along - planes.first) / (planes.spacing_world * stage.every))

    # Pass each ray, and those of the pixels to the right and below, through the planes of all faces.
    normals = np.linalg.inv(edges)  # a column for each coordinate of the cube
    places = [
        np.stack([-((o - first) @ normals) / (d @ normals), (1 - (o - first) @ normals) / (d @ normals)], axis=-1)
        for o, d in rays
    ]
    ends = np.sort(places[0], axis=-1)
    enter, leave = ends[..., 0].max(axis=-1), ends[..., 1].min(axis=-1)
    covers = []
    for t, axis, end in ((enter, ends[..., 0].argmax(axis=-1), 0), (leave, ends[..., 1].argmin(axis=-1), 1)):
        side = np.take_along_axis(places[0].argsort(axis=-1)[..., end], axis[..., None], axis=-1)[..., 0]
        h, w = np.indices(t.shape)
        here = number(rays[0], t)
        steps = [number(ray, place[h, w, axis, side]) - here for ray, place in zip(rays[1:], places[1:], strict=True)]
        per_px = np.maximum(np.hypot(*steps), 1e-9)
        line = np.clip(stage.width_px / 2 + 0.5 - np.abs(here - np.round(here)) / per_px, 0, 1)
        share = np.clip((per_px - 0.5) / 0.5, 0, 1)
        share = share * share * (3 - 2 * share)
        covers.append((1 - share) * line + share * np.clip(stage.width_px * per_px, 0, 1))
    is_met = leave > np.maximum(enter, 0)
    return composited(stage, picture, covers[0] * is_met * (enter > 0) * (enter < picture.depth), covers[1] * is_met)


PASSES: dict[str, Callable[[Any, Picture], FloatArray]] = {"bounding_box": bounding_box, "slice_outlines": slice_outlines}
