"""Which pixels of an image are drawn: rays that meet no block in which there is something are left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..gpu.tiles import Tile
from ..stages.camera import Orthographic, Perspective
from ..stages.tone import keeps_black
from ..volume import FloatArray, domain_index
from .resources import DrawnLayer, layer_leaps, told_leaps

if TYPE_CHECKING:
    from .march import MarchFrame

IntArray = npt.NDArray[np.int64]

ROUNDING_PX = 1.0
LANES = 16  # columns begin at whole groups of so many pixels, which wide processors draw together


@dataclass(frozen=True, eq=False)
class Columns:
    """The first pixel of each row (h,) that is drawn, and that behind the last; none where it does not exceed the first."""

    first: IntArray
    last: IntArray

    @property
    def width(self) -> int:
        """Return the columns up to the last that is drawn, at least one."""
        return max(1, int(self.last.max()))

    def of_rows(self, tile: Tile) -> Tile:
        """Return a tile without the columns that are not drawn in any of its rows."""
        rows = slice(tile.y, tile.y + tile.height)
        first = max(tile.x, int(self.first[rows].min()))
        last = min(tile.x + tile.width, int(self.last[rows].max()))
        return replace(tile, x=first, width=max(last - first, 0))

    def trimmed(self, tiles: Iterator[Tile]) -> Iterator[Tile]:
        """Tiles without what is not drawn."""
        for tile in tiles:
            part = self.of_rows(tile)
            if part.width:
                yield part


def shown_columns(frame: MarchFrame) -> Columns | None:
    """Return the pixels in which something may be seen of a frame's layers and meshes; None where it is not known."""
    camera = frame.scene.camera
    told = isinstance(camera, (Perspective, Orthographic)) and keeps_black(frame.scene_stages["tone"])
    told = told and not getattr(frame.scene_stages["integrate"], "fills", False)
    if not told or frame.keeps_hits or not all(told_leaps(x) for x in frame.layers):
        return None
    boxes_world = [corners_world(frame, layer) for layer in frame.layers]
    boxes_world += [mesh.corners_world[:, None] for mesh in frame.covers.meshes]
    seen = [on_image(camera, corners, frame.size_px) for corners in boxes_world]  # type: ignore[arg-type]
    known = [corners for corners in seen if corners is not None]
    return columns_of(np.concatenate(known, axis=1), frame.size_px) if len(known) == len(seen) else None


def part_seen(camera: object, boxes_world: list[FloatArray], size_px: tuple[int, int], tile: Tile) -> Tile:
    """Return the part of a tile in which what lies in boxes, of corners (8, 3), is seen; all of it where that is not known."""
    known = isinstance(camera, (Perspective, Orthographic))
    corners_px = on_image(camera, np.concatenate(boxes_world), size_px) if known else None  # type: ignore[arg-type]
    if corners_px is None:
        return tile
    begin, end = np.array([tile.x, tile.y]), np.array([tile.x + tile.width, tile.y + tile.height])
    low = np.clip(np.floor(corners_px.min(axis=0) - ROUNDING_PX), begin, end).astype(np.int64)
    high = np.clip(np.ceil(corners_px.max(axis=0) + ROUNDING_PX), begin, end).astype(np.int64)
    x, y = (int(n) for n in low)
    return Tile(x, y, int(high[0]) - x, int(high[1]) - y)


def corners_world(frame: MarchFrame, layer: DrawnLayer) -> FloatArray:
    """Corners (8, n, 3) of the groups of blocks in which there is something, kept for the next frame."""
    leaps, volume, cells = layer_leaps(frame.device, layer), layer.context.volume, layer.field.cells

    def make() -> FloatArray:
        offsets = np.array(list(product((0.0, leaps.group_voxels), repeat=3)))
        corners = leaps.groups * float(leaps.group_voxels) + offsets[:, None, :]
        # Outer blocks go on to where the domain ends, which may be half a voxel further.
        low, high = domain_index(volume.size, cells)
        corners = np.where(corners <= 0, low, np.where(corners >= np.array(volume.size) - 1.0, high, corners))
        return np.asarray(corners @ volume.world_from_index[:3, :3].T + volume.world_from_index[:3, 3])

    found: FloatArray = frame.device.kept.get(("corners of blocks", cells), make, leaps, volume)
    return found


def on_image(camera: Perspective | Orthographic, p_world: FloatArray, size_px: tuple[int, int]) -> FloatArray | None:
    """Places (..., 2) of points (..., 3) on the image [px]; None where one is beside or behind the eye of a perspective."""
    width, height = size_px
    away = p_world - np.asarray(camera.eye)
    aside, above, depth = np.stack(camera.basis()) @ away.reshape(-1, 3).T
    is_perspective = isinstance(camera, Perspective)
    if depth.size and is_perspective and depth.min() <= 1e-3 * np.abs(away).max():
        return None
    scale = height / 2 / camera.half_height / (depth if is_perspective else 1.0)
    return np.stack([width / 2 + scale * aside, height / 2 - scale * above], axis=-1).reshape(*p_world.shape[:-1], 2)


def columns_of(corners_px: FloatArray, size_px: tuple[int, int]) -> Columns:
    """Return the columns that enclose, row by row, the rectangles round groups of corners (k, n, 2)."""
    width, height = size_px
    low = np.clip(np.floor(corners_px.min(axis=0) - ROUNDING_PX), 0, size_px).astype(np.int64)
    high = np.clip(np.ceil(corners_px.max(axis=0) + ROUNDING_PX), 0, size_px).astype(np.int64)
    counts = np.maximum(high[:, 1] - low[:, 1], 0)
    box = np.repeat(np.arange(len(low)), counts)
    row = np.arange(len(box)) - np.repeat(np.cumsum(counts) - counts, counts) + low[box, 1]
    first, last = np.full(height, width), np.zeros(height, dtype=np.int64)
    np.minimum.at(first, row, low[box, 0] // LANES * LANES)
    np.maximum.at(last, row, high[box, 0])
    return Columns(first, last)
