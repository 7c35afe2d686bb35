"""Gradient magnitude and second derivative along the gradient, in world units, a few slices at a time.

Both come from differences of neighbouring voxels, at the voxels, so that the device half can do the same with the same taps.
Along index axis i with voxels at distance one

    g_i  = (f(+1) - f(-1)) / 2,    H_ii = f(+1) - 2 f(0) + f(-1),    H_ij = (f(++) - f(+-) - f(-+) + f(--)) / 4.

With M = A A^T, where A is the linear part of ``index_from_world``, and u = M g, the world's derivatives are

    |grad f| = sqrt(g . u),    second derivative along the gradient = u^T H u / (g . u)

(the second measure of Kindlmann and Durkin 1998, section 3.2: the Hessian along the gradient's direction), whatever the
spacing and shear. Beyond the faces, and where a neighbour is empty, the field goes on straight: g_i is one-sided there, H_ii
is 0, and H_ij is one-sided at faces and 0 beside empty voxels. Where the gradient is 0 the second derivative is 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..volume import AnyArray, FloatArray, Volume, is_empty

VOXELS_AT_ONCE = 1 << 17
"""Voxels of a piece: its dozen temporaries take some 12 MB, whatever the size of the volume, and stay near the cache."""

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Piece:
    """Rows of some slices of a volume, with derivatives at their voxels.

    Attributes
    ----------
    place
        The slices along z and y that the piece takes from the grid; it has all of x.
    value
        ``(z, y, x)`` float64 in data units; 0 where empty.
    gradient
        ``(z, y, x)`` float64, gradient magnitude in data units per world unit; None where it was not asked for.
    second
        ``(z, y, x)`` float64, second derivative along the gradient in data units per world unit squared; or None.
    full
        ``(z, y, x)`` bool, which voxels are not empty; None when all are full.
    """

    place: tuple[slice, slice]
    value: FloatArray
    gradient: FloatArray | None = None
    second: FloatArray | None = None
    full: BoolArray | None = None


def places(shape: tuple[int, ...]) -> list[tuple[slice, slice]]:
    """Slices along z and y that cut a ``(z, y, x)`` grid into pieces of about ``VOXELS_AT_ONCE`` voxels."""
    nz, ny, nx = shape
    rows = min(ny, max(1, VOXELS_AT_ONCE // nx))
    layers = max(1, VOXELS_AT_ONCE // (nx * rows)) if rows == ny else 1
    return [
        (slice(z, min(z + layers, nz)), slice(y, min(y + rows, ny))) for z in range(0, nz, layers) for y in range(0, ny, rows)
    ]


def piece(volume: Volume, place: tuple[slice, slice], channel: int | str = 0, time: int = 0, order: int = 2) -> Piece:
    """Values of one piece, and their derivatives up to an order.

    Parameters
    ----------
    volume, channel, time
        Where the samples are.
    place
        One of ``places``.
    order
        0: values alone; 1: the gradient's magnitude too; 2: the second derivative too.
    """
    taps = _Taps.of(volume.grid(channel, time), place, volume.no_data, halo=int(order > 0))
    value = taps.at()
    if order == 0:
        return Piece(place, value, full=taps.full())
    linear = volume.index_from_world[:3, :3]
    metric = linear @ linear.T
    slopes = [taps.slope(axis) for axis in range(3)]
    turned = [sum(metric[i, j] * slopes[j] for j in range(3) if metric[i, j] != 0) for i in range(3)]
    squared = np.maximum(sum(g * u for g, u in zip(slopes, turned, strict=True)), 0.0)
    gradient = np.sqrt(squared)
    if order == 1:
        return Piece(place, value, gradient, full=taps.full())
    second = np.zeros_like(value)
    for i in range(3):
        second += turned[i] * turned[i] * taps.bend(i)
        for j in range(i):
            second += 2 * turned[i] * turned[j] * taps.twist(i, j)
    steep = squared > np.finfo(np.float64).tiny
    second = np.where(steep, second / np.where(steep, squared, 1.0), 0.0)
    return Piece(place, value, gradient, second, taps.full())


def pieces(volume: Volume, channel: int | str = 0, time: int = 0, order: int = 2) -> Iterator[Piece]:
    """All pieces of a volume, one after the other; see ``piece``."""
    for place in places(volume.grid(channel, time).shape):
        yield piece(volume, place, channel, time, order)


@dataclass(frozen=True, eq=False)
class _Taps:
    """A piece with one voxel more on each side (``halo``); beyond a face the voxel at the face is repeated.

    ``ways`` holds the distance of the two neighbours along x, y and z: 2, at faces 1, and 0 where the grid has one voxel.
    """

    block: FloatArray
    filled: BoolArray | None
    halo: int
    ways: tuple[FloatArray, ...]

    @classmethod
    def of(cls, grid: AnyArray, place: tuple[slice, slice], no_data: float | None, halo: int) -> _Taps:
        extents = (*place, slice(0, grid.shape[2]))
        z, y, x = (np.arange(p.start - halo, p.stop + halo).clip(0, n - 1) for p, n in zip(extents, grid.shape, strict=True))
        samples = grid[z[0] : z[-1] + 1, y[0] : y[-1] + 1]
        mask = is_empty(samples, no_data)
        values = (samples if mask is None else np.where(mask, 0, samples)).astype(np.float64)
        around = np.ix_(z - z[0], y - y[0], x)
        ways = [
            (np.minimum(i + 1, n - 1) - np.maximum(i - 1, 0)).astype(np.float64).reshape([-1] + [1] * axis)
            for axis, (p, n) in enumerate(zip(extents[::-1], grid.shape[::-1], strict=True))
            for i in [np.arange(p.start, p.stop)]
        ]
        filled = None if mask is None else ~mask[around]
        return cls(values[around] if halo else values, filled, halo, tuple(ways))

    def _cut(self, array: AnyArray, steps: dict[int, int]) -> AnyArray:
        """Part of the block that lies a number of steps away along each axis."""
        h = self.halo
        return array[tuple(slice(h + steps.get(a, 0), array.shape[2 - a] - h + steps.get(a, 0)) for a in (2, 1, 0))]

    def at(self, steps: dict[int, int] | None = None) -> FloatArray:
        """Values of the voxels so many steps away along each axis."""
        return self._cut(self.block, steps or {})

    def full(self, *steps: dict[int, int]) -> BoolArray | None:
        """Where the voxels at all of these steps hold something; None where all of the piece does."""
        if self.filled is None:
            return None
        found: BoolArray = np.logical_and.reduce([self._cut(self.filled, s) for s in steps or ({},)])
        return found

    def slope(self, axis: int) -> FloatArray:
        """Difference quotient along an axis; an empty neighbour is replaced by the voxel itself."""
        high, low, way = self.at({axis: 1}), self.at({axis: -1}), self.ways[axis]
        if self.filled is not None:
            has_high, has_low = (self._cut(self.filled, {axis: s}) for s in (1, -1))
            high, low = np.where(has_high, high, self.at()), np.where(has_low, low, self.at())
            way = np.where(self._cut(self.filled, {}), way - ~has_high - ~has_low, 0.0)
        return np.asarray((high - low) * np.where(way > 0, 1 / np.maximum(way, 1), 0.0))

    def bend(self, axis: int) -> FloatArray:
        """Second difference along an axis; 0 without two neighbours."""
        ends = {axis: 1}, {axis: -1}
        known = self.full(*ends)
        inside = self.ways[axis] == 2
        difference = self.at(ends[0]) - 2 * self.at() + self.at(ends[1])
        return np.asarray(difference * (inside if known is None else inside & known))

    def twist(self, a: int, b: int) -> FloatArray:
        """Mixed second difference quotient; 0 beside empty voxels, and along axes of one voxel."""
        corners = [{a: i, b: j} for i, j in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
        known = self.full(*corners)
        pp, pm, mp, mm = (self.at(c) for c in corners)
        way = self.ways[a] * self.ways[b]
        quotient = (pp - pm - mp + mm) * np.where(way > 0, 1 / np.maximum(way, 1), 0.0)
        return quotient if known is None else np.asarray(quotient * known)
