"""Slices through a layer, interpolated as ``Volume.value_at`` does, as small pictures: grey by a window, regions in colour."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...annotations.axes import letters
from ...annotations.base import round_below
from ...annotations.scale_bar import length_text
from ...errors import ValueRangeError
from ...labels import label_numbers, styles_table
from ...scene import Layer
from ...transfer.colour import linear_to_srgb
from ...transfer.given import direction, finite_numbers, listed, positive, rising_range, share, whole
from ...volume import AnyArray, FloatArray, Volume, domain_index, is_empty, statistics
from ..asking import answers
from .probe import layer_numbered

if TYPE_CHECKING:
    from ..session import Session

MOST_PLANES, MOST_PX = 4, 2048
ALLOWANCE = 1e-4
"""Part of a voxel by which points may lie outside, as in ``Volume.value_at``."""
BAR_SHARE = 0.28
"""Most of a slice's width that its scale bar takes."""
ENTRIES = ("centre_world", "right", "up", "pixel_world", "size_px")


@dataclass(frozen=True)
class Plane:
    """A rectangle in the world, and the pixels that show it.

    Attributes
    ----------
    centre_world
        Its middle (3,).
    right, up
        Unit vectors (3,) at right angles.
    pixel_world
        World units a pixel.
    size_px
        Width and height.
    """

    centre_world: FloatArray
    right: FloatArray
    up: FloatArray
    pixel_world: float
    size_px: tuple[int, int]

    @classmethod
    def from_dict(cls, data: Any, where: str) -> Plane:
        """Return the plane of plain data.

        Raises
        ------
        ValueRangeError
            When something is missing or wrong; it names it.
        """
        if not isinstance(data, Mapping) or set(data) != set(ENTRIES):
            raise ValueRangeError(where, "is no plane", f"give {', '.join(ENTRIES)}")
        centre = np.array(finite_numbers(data["centre_world"], f"{where}.centre_world", 3))
        right, up = (np.array(direction(data[name], f"{where}.{name}")) for name in ("right", "up"))
        if abs(right @ up) > 1e-6:
            raise ValueRangeError(f"{where}.up", "is not at right angles to right")
        sizes = finite_numbers(data["size_px"], f"{where}.size_px", 2)
        width, height = (whole(n, f"{where}.size_px", 1, MOST_PX) for n in map(int, sizes))
        return cls(centre, right, up, positive(data["pixel_world"], f"{where}.pixel_world"), (width, height))

    @property
    def p_world(self) -> FloatArray:
        """Centres (h, w, 3) of the pixels."""
        across, upward = self._ways()
        return np.asarray(self.centre_world + across[None, :, None] * self.right + upward[:, None, None] * self.up)

    def p_index(self, volume: Volume) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Index coordinates x, y and z, each (h, w), of the centres of the pixels."""
        matrix = volume.index_from_world
        middle = matrix[:3, :3] @ self.centre_world + matrix[:3, 3]
        across, upward = self._ways()
        columns, rows = (np.outer(matrix[:3, :3] @ way, along) for way, along in ((self.right, across), (self.up, upward)))
        x, y, z = (columns[axis][None, :] + (rows[axis] + middle[axis])[:, None] for axis in range(3))
        return x, y, z

    def _ways(self) -> tuple[FloatArray, FloatArray]:
        """How far columns lie to the right of the middle, and rows above it."""
        width, height = self.size_px
        across = (np.arange(width, dtype=np.float64) + 0.5 - width / 2) * self.pixel_world
        return across, np.asarray((height / 2 - np.arange(height) - 0.5) * self.pixel_world, dtype=np.float64)


@answers("slices")
def slices(
    session: Session, planes: Any, window: Any, layer: int = 0, label_opacity: float = 0.4
) -> tuple[dict[str, Any], list[bytes]]:
    """Pictures of planes through a layer: PNG, transparent where there are no data.

    Parameters
    ----------
    session
        Whose document.
    planes
        At most four, each with ``centre_world``, ``right``, ``up``, ``pixel_world`` and ``size_px``; see `Plane`.
    window
        Values that are black and white.
    layer
        Number of the layer in the scene, shown or not.
    label_opacity
        How strongly the colours of regions lie over the grey values.

    Raises
    ------
    ValueRangeError
        For layers that are not there, and planes and windows that are none.
    """
    chosen = layer_numbered(session, layer)
    black, white = rising_range(window, "slices.window")
    opacity = share(label_opacity, "slices.label_opacity")
    given = listed(planes, "slices.planes", "give a list of planes")
    if len(given) > MOST_PLANES:
        raise ValueRangeError("slices.planes", f"are {len(given)}, must be at most {MOST_PLANES}")
    told, pictures = [], []
    for number, data in enumerate(given):
        plane = Plane.from_dict(data, f"slices.planes[{number}]")
        values = interpolated(chosen.volume, plane, chosen.volume.channel_index(chosen.channel), chosen.time)
        picture = grey(values, black, white)
        if chosen.labels is not None and opacity > 0:
            picture = with_labels(picture, chosen, plane, opacity)
        pictures.append(_png(picture))
        told.append(_told(chosen.volume, plane))
    return {"planes": told}, pictures


def interpolated(volume: Volume, plane: Plane, channel: int = 0, time: int = 0) -> npt.NDArray[np.floating[Any]]:
    """Values (h, w) of a plane, NaN outside and where data are empty: those of ``Volume.value_at``, many times as fast.

    In float32 where that holds the samples.
    """
    grid = volume.grid(channel, time)
    kind = np.float32 if grid.dtype.itemsize <= 2 or grid.dtype == np.float32 else np.float64
    low, high = domain_index(volume.size, cells=False)
    inside = np.ones(plane.size_px[::-1], dtype=bool)
    begin: Any = 0
    shares, steps = [], []
    strides = (1, volume.size[0], volume.size[0] * volume.size[1])
    for axis, along in enumerate(plane.p_index(volume)):
        inside &= (along >= low[axis] - ALLOWANCE) & (along <= high[axis] + ALLOWANCE)
        last = volume.size[axis] - 1
        along = np.clip(along, 0, last)
        first = np.minimum(along.astype(np.intp), max(last - 1, 0))
        begin = begin + first * strides[axis]
        shares.append((along - first).astype(kind))
        steps.append(strides[axis] if last else 0)
    flat = np.ascontiguousarray(grid).reshape(-1)
    if not statistics(volume, channel, time).empty:
        return np.where(inside, _mixed(lambda at: flat.take(at).astype(kind), begin, shares, steps), kind(np.nan))
    # As in pictures: the mean of the voxels that hold something, where these have half of the weight.
    mask = is_empty(flat, volume.no_data)
    empty = np.zeros(flat.shape, dtype=bool) if mask is None else mask
    total = _mixed(lambda at: np.where(empty.take(at), 0, flat.take(at)).astype(kind), begin, shares, steps)
    weight = _mixed(lambda at: (~empty.take(at)).astype(kind), begin, shares, steps)
    known = inside & (weight >= 0.5)
    return np.where(known, total / np.where(known, weight, 1), kind(np.nan))


def _mixed(taken: Any, begin: npt.NDArray[np.intp], shares: list[AnyArray], steps: list[int]) -> AnyArray:
    """What is taken at the eight corners of cells, mixed along x, then y, then z."""
    found = [taken(begin + (i * steps[0] + j * steps[1] + k * steps[2])) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    for part in shares:
        found = [a + (b - a) * part for a, b in zip(found[::2], found[1::2], strict=True)]
    mixed: AnyArray = found[0]
    return mixed


def grey(values: AnyArray, black: float, white: float) -> npt.NDArray[np.uint8]:
    """Picture (h, w, 4), sRGB with straight alpha: black to white between two values, transparent where there are none."""
    there = ~np.isnan(values)
    shade = np.clip((np.where(there, values, black) - black) * (255.0 / (white - black)), 0, 255)
    picture = np.empty((*values.shape, 4), dtype=np.uint8)
    picture[..., :3] = np.rint(shade).astype(np.uint8)[..., None]
    picture[..., 3] = np.where(there, 255, 0)
    return picture


def with_labels(picture: npt.NDArray[np.uint8], layer: Layer, plane: Plane, opacity: float) -> npt.NDArray[np.uint8]:
    """Return a picture with the regions of a layer in their colours, those that are shown."""
    assert layer.labels is not None
    volume = layer.labels.volume
    inside = np.ones(plane.size_px[::-1], dtype=bool)
    place: Any = 0
    stride = 1
    for along, count in zip(plane.p_index(volume), volume.size, strict=True):
        voxel = np.floor(along + 0.5)
        inside &= (voxel >= 0) & (voxel < count)
        place = place + np.clip(voxel, 0, count - 1).astype(np.intp) * stride
        stride *= count
    grid = np.ascontiguousarray(volume.grid(0, layer.labels.time_of(layer.time))).reshape(-1)
    found, which = np.unique(np.where(inside, grid.take(place), layer.labels.background), return_inverse=True)
    colours = colours_of_labels(layer, found)
    colours[:, 3] *= opacity
    over = colours[which.reshape(inside.shape)]
    alpha, behind = over[..., 3:], picture[..., 3:] / 255
    rgb = np.where(behind > 0, over[..., :3] * 255 * alpha + picture[..., :3] * (1 - alpha), over[..., :3] * 255)
    return np.asarray(np.rint(np.concatenate([rgb, 255 * np.maximum(behind, alpha)], axis=-1)), dtype=np.uint8)


def colours_of_labels(layer: Layer, found: AnyArray) -> FloatArray:
    """Colours (n, 4) in which labels (n,) are drawn: sRGB from 0 to 1, and opacity; the background's is 0."""
    labels = layer.labels
    assert labels is not None
    time = labels.time_of(layer.time)
    rows = styles_table(labels, time).reshape(-1, 4)[label_numbers(labels.volume, time, labels.background).of(found)]
    shown = np.where(found == labels.background, 0.0, rows[:, 3].astype(np.float64) % 2)
    tints = rows[:, :3] / np.where(shown > 0, shown, 1.0)[:, None]
    return np.concatenate([linear_to_srgb(np.clip(tints, 0, 1)), np.minimum(shown, 1.0)[:, None]], axis=1)


def _png(picture: npt.NDArray[np.uint8]) -> bytes:
    from PIL import Image

    out = io.BytesIO()
    plain = bool((picture[..., 0] == picture[..., 1]).all() and (picture[..., 1] == picture[..., 2]).all())
    image = Image.fromarray(np.ascontiguousarray(picture[..., [0, 3]]), "LA") if plain else Image.fromarray(picture)
    image.save(out, "png", compress_level=1)
    return out.getvalue()


def _told(volume: Volume, plane: Plane) -> dict[str, Any]:
    """Letters at a plane's sides, of anatomical data, and its scale bar."""
    length = round_below(BAR_SHARE * plane.size_px[0] * plane.pixel_world)
    told: dict[str, Any] = {"bar_px": length / plane.pixel_world, "bar": length_text(length, volume.units)}
    if volume.anatomical:
        ways = {"left": -plane.right, "right": plane.right, "up": plane.up, "down": -plane.up}
        told["letters"] = {side: letters(way) for side, way in ways.items()}
    return told
