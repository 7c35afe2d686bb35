"""Transfer functions that are made of the data: of the boundaries in a volume, and of a picked point.

Boundaries after G. Kindlmann and J. W. Durkin, "Semi-automatic generation of transfer functions for direct volume rendering",
1998: opacity is a function of the distance from the middle of a boundary, the *boundary emphasis function*, and values and
gradients tell that distance; see ``airlight.transfer.boundary``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..errors import DataError, ValueRangeError
from ..volume import FloatArray, Volume, domain_index, is_empty, statistics
from .arches import arches
from .boundary import BINS, Boundary, boundaries, profile, values_at
from .colour import PALETTE, Colour
from .function import TransferFunction
from .histogram import Progress, Samples
from .joint import JointFunction
from .joint_axes import Axis
from .joint_shapes import Triangle

EMPHASIS = ((-1.0, 0.0), (0.0, 1.0), (1.0, 0.0))
"""Boundary emphasis: a tent over the middle, one sigma to each side."""

GRADIENTS = (1 / 3, 1.5)
"""Gradients that belong to a boundary in two variables, as shares of the gradient in its middle."""
NEIGHBOURHOOD = 2
MOST_VOXELS_THICK = 16.0


def boundary_function(
    volume: Volume,
    channel: int | str = 0,
    time: int = 0,
    *,
    depth: float | Sequence[float] = 1.0,
    emphasis: Sequence[tuple[float, float]] = EMPHASIS,
    colours: Sequence[Colour] = PALETTE,
    threshold: float | None = None,
    progress: Progress | None = None,
) -> TransferFunction:
    """Return a function of the value that shows the boundaries between materials, each in a colour of its own.

    Parameters
    ----------
    volume, channel, time, threshold, progress
        As for ``profile``.
    depth
        Optical depth of each boundary when it is crossed at right angles: 1 lets 37 % through. Several numbers are for the
        boundaries by rising value, the last one for all that are left.
    emphasis
        Boundary emphasis function: ``(position, share)``, positions rising, in sigmas from the middle towards the higher
        material; piecewise linear, and nothing beyond its ends.
    colours
        Linear tuples or sRGB words, in turn for the boundaries by rising value.

    Raises
    ------
    DataError
        When no boundary is found.
    ValueRangeError
        For a depth below 0, and an emphasis without any positive share.
    """
    depths = _depths(depth)
    at, shares = _emphasis(emphasis)
    known = profile(volume, channel, time, threshold=threshold, progress=progress)
    points: list[tuple[float, Colour, float]] = []
    for number, boundary in enumerate(_some(boundaries(known), volume)):
        colour = colours[number % len(colours)]
        extinctions = shares * depths[min(number, len(depths) - 1)] / (boundary.sigma * _integral(shares, at))
        values = values_at(known, boundary, at * boundary.sigma)
        points.append((float(values[0]), colour, 0.0))
        # Positions that the boundary's stretch does not reach fall together at its end: there it goes down to 0.
        reached = (values > values[0]) & (values < values[-1])
        reached[0], reached[-1] = extinctions[0] > 0, extinctions[-1] > 0
        points += [(float(v), colour, float(e)) for v, e in zip(values[reached], extinctions[reached], strict=True)]
        points.append((float(values[-1]), colour, 0.0))
    return TransferFunction(points)


def boundary_joint_function(
    volume: Volume,
    channel: int | str = 0,
    time: int = 0,
    *,
    depth: float | Sequence[float] = 1.0,
    thickness: float = 1.0,
    colours: Sequence[Colour] = PALETTE,
    threshold: float | None = None,
    progress: Progress | None = None,
) -> JointFunction:
    """Return a function of value and gradient that shows the boundaries between materials.

    Boundaries are found as arches of the joint histogram (``airlight.transfer.arches``), so that those of the first with the
    third material and with the second are told apart. Each is a `Triangle` under its arch: with the gradient at hand,
    ``(v - value) / gradient`` is the distance from the middle, whatever the contrast (Levoy 1988). It holds gradients from
    a third to one and a half times of the boundary's, which leaves out noise, and steeper boundaries that pass through the
    same values.

    Parameters
    ----------
    volume, channel, time, threshold, progress
        As for ``profile``.
    depth
        Optical depth of each boundary, if it is ideal, when it is crossed at right angles; or several, as above.
    thickness
        Distance from the middle at which nothing is left, by the formula above, in sigmas.
    colours
        Linear tuples or sRGB words, in turn for the boundaries by rising value.

    Raises
    ------
    DataError
        When no boundary is found.
    ValueRangeError
        For a depth below 0 and a thickness that is not positive.
    """
    if not (np.isfinite(thickness) and thickness > 0):
        raise ValueRangeError("thickness", f"is {thickness}, must be positive")
    depths = _depths(depth)
    known = profile(volume, channel, time, threshold=threshold, progress=progress)
    shapes = []
    for number, boundary in enumerate(_some(arches(volume, known, channel, time), volume)):
        low, top = (share * boundary.gradient for share in GRADIENTS)
        low = max(low, min(known.threshold, 0.9 * boundary.gradient))
        way = thickness * boundary.sigma
        seen = boundary.sigma * _tent_over_arch(thickness, low / boundary.gradient)
        extinction = depths[min(number, len(depths) - 1)] / seen
        colour = colours[number % len(colours)]
        shapes.append(Triangle(boundary.value, way * top, top, low, colour=colour, extinction=extinction))
    gradients = Samples(volume, ("gradient",), volume.channel_index(channel), time).axis(0, BINS)
    reach = [(s.value - s.half_width, s.value + s.half_width) for s in shapes]
    axes = (
        Axis("value", min(known.axis.low, *(a for a, _ in reach)), max(known.axis.high, *(b for _, b in reach))),
        Axis("gradient", 0.0, max(gradients.high, *(s.top for s in shapes))),
    )
    return JointFunction(axes, shapes)


def peak_at(
    volume: Volume,
    p_world: npt.ArrayLike,
    width: float | None = None,
    colour: Colour = PALETTE[0],
    channel: int | str = 0,
    time: int = 0,
    *,
    depth: float = 1.0,
) -> TransferFunction:
    """Return a peak at the value under a point, which shows the surface, or the material, that was picked.

    Parameters
    ----------
    volume, channel, time
        Whose samples.
    p_world
        Picked point (x, y, z) in the world; its value is interpolated trilinearly.
    width
        Width of the peak, data units. When left out: what the value changes by within a voxel to each side, but no less than
        two standard deviations of the noise to each side, and 1/256 of the range of the values. The noise is what a straight
        line through the 5 x 5 x 5 voxels around leaves.
    colour
        Linear tuple or sRGB word.
    depth
        Optical depth of what is met at the point along the gradient; without a gradient, of 16 voxels.

    Raises
    ------
    DataError
        When the point lies outside of the volume's domain, or beside an empty sample.
    ValueRangeError
        For widths that are not positive, and a depth below 0.
    """
    _depths(depth)
    if width is not None and not (np.isfinite(width) and width > 0):
        raise ValueRangeError("width", f"is {width}, must be positive")
    value, gradient, noise = _around(volume, np.asarray(p_world, dtype=np.float64), volume.channel_index(channel), time)
    known = statistics(volume, channel, time)
    voxel = min(volume.spacing)
    if width is None:
        least = (known.maximum - known.minimum) / 256 or abs(value) / 256 or 1.0
        half = max(gradient * voxel, 2 * noise, least)
    else:
        half = width / 2
    # A tent that is crossed along the gradient holds half / gradient of length.
    way = min(max(half / max(gradient, 1e-300), voxel), MOST_VOXELS_THICK * voxel)
    return TransferFunction([(value - half, colour, 0.0), (value, colour, depth / way), (value + half, colour, 0.0)])


# -- pieces of the above


def _some(found: list[Boundary], volume: Volume) -> list[Boundary]:
    if not found:
        where = f"volume {volume.name!r}" if volume.name else "volume"
        raise DataError(where, "shows no boundary between materials", "give a lower threshold, or a function of your own")
    return found


def _depths(depth: float | Sequence[float]) -> list[float]:
    """Optical depths by number of the boundary; the last one holds for all that follow."""
    depths = np.atleast_1d(np.asarray(depth, dtype=np.float64))
    if not (depths.ndim == 1 and depths.size and np.isfinite(depths).all() and (depths >= 0).all()):
        raise ValueRangeError("depth", f"is {depth}, must be at least 0")
    return [float(d) for d in depths]


def _emphasis(emphasis: Sequence[tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
    """Positions (m,) and shares (m,), with the middles between those given."""
    knots = np.asarray(emphasis, dtype=np.float64)
    if knots.ndim != 2 or knots.shape[1] != 2 or not np.isfinite(knots).all() or not (np.diff(knots[:, 0]) > 0).all():
        raise ValueRangeError("emphasis", f"is {emphasis!r}", "give (position, share), finite, positions rising")
    if (knots[:, 1] < 0).any() or not (knots[:, 1] > 0).any() or len(knots) < 2:
        raise ValueRangeError("emphasis", f"is {emphasis!r}", "shares must be at least 0, and some above")
    at = np.sort(np.concatenate([knots[:, 0], (knots[1:, 0] + knots[:-1, 0]) / 2]))
    return at, np.interp(at, knots[:, 0], knots[:, 1])


def _integral(heights: FloatArray, places: FloatArray) -> float:
    return float(((heights[1:] + heights[:-1]) / 2 * np.diff(places)).sum())


def _tent_over_arch(thickness: float, low: float) -> float:
    """Integral of the weight of Levoy's triangle along an ideal boundary, in sigmas; ``low`` is a share of the gradient."""
    t = np.linspace(0, min(4.0, math.sqrt(-2 * math.log(low))), 2001)
    bell = np.exp(-0.5 * t * t)
    risen = np.concatenate([[0.0], np.cumsum((bell[1:] + bell[:-1]) / 2 * (t[1] - t[0]))])
    return 2 * _integral(np.maximum(1 - risen / bell / thickness, 0.0), t)


def _around(volume: Volume, p_world: FloatArray, channel: int, time: int) -> tuple[float, float, float]:
    """Value at a point, gradient magnitude in the world, and standard deviation of the noise."""
    if p_world.shape != (3,) or not np.isfinite(p_world).all():
        raise ValueRangeError("p_world", f"is {p_world.tolist()}", "give three finite numbers x, y, z")
    p_index = volume.index_from_world[:3, :3] @ p_world + volume.index_from_world[:3, 3]
    low, high = domain_index(volume.size, cells=False)
    if ((p_index < low - 1e-6) | (p_index > high + 1e-6)).any():
        corners = volume.corners_world()
        box = f"{corners.min(axis=0).round(3).tolist()} to {corners.max(axis=0).round(3).tolist()}"
        raise DataError("p_world", f"is {p_world.tolist()}, outside of the volume", f"it reaches from {box}")
    grid = volume.grid(channel, time)
    p = np.clip(p_index, 0, np.array(volume.size) - 1.0)
    cell = np.minimum(np.floor(p), np.maximum(np.array(volume.size) - 2, 0)).astype(np.int64)
    eight = tuple(slice(c, c + 2) for c in cell[::-1])
    if is_empty(grid[eight], volume.no_data) is not None:
        raise DataError("p_world", f"is {p_world.tolist()}, beside an empty sample", "pick another point")
    corner = grid[eight].astype(np.float64)
    for share in (p - cell)[::-1]:
        corner = corner[0] * (1 - share) + corner[-1] * share
    near = tuple(slice(max(0, round(c) - NEIGHBOURHOOD), round(c) + NEIGHBOURHOOD + 1) for c in p[::-1])
    samples = grid[near].astype(np.float64)
    mask = is_empty(grid[near], volume.no_data)
    there = np.ones(samples.shape, dtype=bool) if mask is None else ~mask
    offsets = np.stack(np.nonzero(there), axis=1)[:, ::-1] - np.array([0.0, 0.0, 0.0])
    terms = np.column_stack([np.ones(len(offsets)), offsets - offsets.mean(axis=0)])
    line, *_ = np.linalg.lstsq(terms, samples[there], rcond=None)
    left = samples[there] - terms @ line
    spare = max(1, len(offsets) - 4)
    gradient = float(np.linalg.norm(line[1:] @ volume.index_from_world[:3, :3]))
    return float(corner), gradient, math.sqrt(float((left**2).sum()) / spare)
