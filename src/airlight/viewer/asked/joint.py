"""Joint histograms, and where what lies round a point of the world is found in them (dual-domain interaction).

After J. Kniss, G. Kindlmann and C. Hansen, "Multidimensional transfer functions for interactive volume rendering", 2002: a
small region round the pointer is shown in the histogram, and widgets are made of what it holds.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary, ref

import numpy as np

from ...automatic import boundary_joint_function, peak_at
from ...errors import DataError, ValueRangeError
from ...scene import Layer
from ...transfer import TransferFunction
from ...transfer.colour import PALETTE
from ...transfer.derivatives import piece
from ...transfer.given import finite_numbers, listed, whole
from ...transfer.histogram import JointHistogram, joint_histogram
from ...transfer.histogram_picture import label, ticks
from ...transfer.joint_axes import VARIABLES, Axis, check_axes
from ...transfer.joint_shapes import Box, Ellipse, Shape
from ...volume import AnyArray, FloatArray, Volume
from ..asking import answers
from .probe import layer_numbered

if TYPE_CHECKING:
    from ..session import Session

BINS, BINS_OF_THIRD = 256, 128
TICKS = 4
MOST_KEPT = 8
BRIGHT = 99.5
"""Percentile of the counts above which the linear picture is white: the background's peak would leave all else black."""
LEAST_RADIUS = 0.012
"""Of an axis's span: no widget is made so small that it cannot be seen."""
SIGMA_VOXELS = 0.75
"""Of the Gaussian by which the neighbours of a point count."""
REACH_VOXELS = 4
VOXELS_DEEP = 2.0
"""Thickness that a new widget makes half opaque, when no peak tells."""

_KEPT: WeakKeyDictionary[Session, dict[tuple[Any, ...], tuple[ref[Volume], JointHistogram]]] = WeakKeyDictionary()


@answers("joint", slow=True)
def joint(session: Session, layer: int = 0, variables: Any = ("value", "gradient")) -> tuple[dict[str, Any], list[bytes]]:
    """The joint histogram of a layer by the first two of its variables, and that of the third alone.

    Parameters
    ----------
    session
        Whose document; it is told the progress.
    layer
        Number of the layer in the scene.
    variables
        Two or three: names and channel numbers, or axes ``{"variable", "low", "high"}`` that choose the stretch, too.

    Returns
    -------
    dict, list
        Axes with labels and units, numbers of samples, variables that there are. Buffers: shades (n, n) of the counts on a
        logarithmic and on a linear scale, uint8, the first row at the top of the second axis; then those of the third (n,).

    Raises
    ------
    AirlightError
        For variables that the volume does not have, and axes that do not rise.
    """
    chosen = layer_numbered(session, layer)
    given = listed(variables, "joint.variables", "give two or three")
    if not 2 <= len(given) <= 3:
        raise ValueRangeError("joint.variables", f"are {len(given)}, must be two or three")
    wanted = [_axis(v, f"joint.variables[{n}]") if isinstance(v, dict) else v for n, v in enumerate(given)]
    plane = _counted(session, chosen, tuple(wanted[:2]), BINS)
    thirds = [_counted(session, chosen, (third,), BINS_OF_THIRD) for third in wanted[2:]]
    check_axes([axis for histogram in (plane, *thirds) for axis in histogram.axes])
    axes = [_told(histogram, n) for histogram in (plane, *thirds) for n in range(len(histogram.axes))]
    others: list[Any] = [*chosen.volume.channel_names] or [*range(chosen.volume.channel_count)]
    told = {"axes": axes, "bins": BINS, "outside": plane.outside, "empty": plane.empty}
    told["variables"] = [*VARIABLES, *(others if chosen.volume.channel_count > 1 else [])]
    buffers = [plane.image().tobytes(), linear_image(plane.counts[::-1]).tobytes()]
    return told, buffers + [_shade(np.log1p(third.counts)).tobytes() for third in thirds]


@answers("joint.proposal", slow=True)
def proposal(session: Session, layer: int = 0) -> dict[str, Any]:
    """The function of value and gradient that shows the boundaries in a layer, as plain data.

    Raises
    ------
    DataError
        When no boundary is found.
    """
    chosen = layer_numbered(session, layer)
    told = _progress(session)
    found = boundary_joint_function(chosen.volume, chosen.channel, chosen.time, progress=told)
    return {"transfer": found.to_dict()}


@answers("joint.here")
def here(session: Session, p_world: Any, axes: Any, layer: int = 0, number: int = 0) -> dict[str, Any]:
    """Where a point of the world and its 26 neighbours lie in the histogram of some axes, and widgets made of them.

    Parameters
    ----------
    session
        Whose document.
    p_world
        The point.
    axes
        Two or three tables ``{"variable", "low", "high"}``.
    layer
        Number of the layer in the scene.
    number
        How many widgets there are: it chooses the colour of the new ones.

    Returns
    -------
    dict
        ``marks``: coordinates, and ``weights`` of each, 1 in all; ``at``: those of the point; ``around``: a shape that
        covers them; ``peak``: a box at the point's value; both plain data, None where there are no samples.
    """
    chosen = layer_numbered(session, layer)
    checked = check_axes(_axis(a, f"joint.axes[{n}]") for n, a in enumerate(listed(axes, "joint.axes", "give a list")))
    point = np.array(finite_numbers(p_world, "joint.p_world", 3))
    coordinates, p_index = neighbours(chosen, point, tuple(axis.variable for axis in checked))
    if not len(coordinates):
        return {"marks": [], "weights": [], "at": None, "around": None, "peak": None}
    at_index = chosen.volume.index_from_world[:3, :3] @ point + chosen.volume.index_from_world[:3, 3]
    away = ((p_index - at_index) ** 2).sum(axis=1)
    weights = np.exp(-0.5 * away / SIGMA_VOXELS**2)
    weights /= weights.sum()
    # At the point itself the neighbours count as in linear interpolation.
    near = np.clip(1 - np.abs(p_index - at_index), 0, 1).prod(axis=1)
    at = (near if near.sum() > 0 else weights) @ coordinates / (near.sum() if near.sum() > 0 else 1.0)
    colour = PALETTE[number % len(PALETTE)]
    half, extinction = _peak(chosen, point)
    told = {"marks": coordinates.tolist(), "weights": weights.tolist(), "at": at.tolist()}
    told["around"] = around(checked, at, coordinates, weights, colour, extinction).to_dict()
    of_value = checked[0].variable == "value"
    return told | {"peak": box(checked, float(at[0]), half, colour, extinction).to_dict() if of_value else None}


@answers("joint.peak")
def peak(session: Session, p_world: Any, layer: int = 0, base: Any = None, number: int = 0) -> dict[str, Any]:
    """A function of the value with a peak at what lies under a point.

    Parameters
    ----------
    session, p_world, layer, number
        As for ``here``.
    base
        Plain data of the function that gets the peak: at each value the greater extinction wins; None for the peak alone.

    Raises
    ------
    DataError
        For points outside of the volume, and beside empty samples.
    """
    chosen = layer_numbered(session, layer)
    colour = PALETTE[whole(number, "joint.number", 0) % len(PALETTE)]
    found = peak_at(chosen.volume, finite_numbers(p_world, "joint.p_world", 3), None, colour, chosen.channel, chosen.time)
    if base is not None:
        if not isinstance(base, dict):
            raise ValueRangeError("joint.base", "is no function", "give the plain data of a TransferFunction")
        found = TransferFunction.from_dict(base) | found
    return {"transfer": found.to_dict()}


def neighbours(layer: Layer, p_world: FloatArray, variables: tuple[str | int, ...]) -> tuple[FloatArray, FloatArray]:
    """Coordinates (m, k) of the 27 voxels round a point by some variables, and their index coordinates (m, 3).

    Voxels that are empty or outside are left out: far from the volume there are none.
    """
    volume = layer.volume
    size = np.array(volume.size)
    middle = np.rint(volume.index_from_world[:3, :3] @ p_world + volume.index_from_world[:3, 3]).astype(int)
    if ((middle < -1) | (middle > size)).any():
        return np.zeros((0, len(variables))), np.zeros((0, 3))
    low, high = np.clip(middle - REACH_VOXELS, 0, size - 1), np.clip(middle + REACH_VOXELS + 1, 1, size)
    part = _cut(volume, layer.time, low, high)
    first, last = np.maximum(middle - 1, 0) - low, np.minimum(middle + 2, size) - low
    x, y, z = (slice(a, b) for a, b in zip(first, last, strict=True))
    whole_part = slice(0, part.size[2]), slice(0, part.size[1])
    own = piece(part, whole_part, volume.channel_index(layer.channel), 0, 2)
    known: dict[str | int, AnyArray | None] = {"value": own.value, "gradient": own.gradient, "second": own.second}
    full = np.ones(own.value.shape, dtype=bool) if own.full is None else own.full
    columns = []
    for variable in variables:
        found = known.get(variable)
        if found is None:
            other = piece(part, whole_part, variable, 0, 0)
            found, full = other.value, full if other.full is None else full & other.full
        columns.append(found[z, y, x])
    there = full[z, y, x]
    k, j, i = np.nonzero(there)
    p_index = np.stack([i, j, k], axis=1) + first + low
    return np.stack([column[there] for column in columns], axis=1), p_index.astype(np.float64)


def around(
    axes: tuple[Axis, ...], at: FloatArray, coordinates: FloatArray, weights: FloatArray, colour: str, extinction: float
) -> Shape:
    """Ellipse round a point of three standard deviations of weighted coordinates, inside of the axes.

    A box of two, where an ellipse would lie across the axes' ends: in what is homogeneous gradients are next to 0.
    """
    low, high, span = (np.array([getattr(axis, name) for axis in axes]) for name in ("low", "high", "span"))
    at = np.clip(at, low, high)
    radii = np.clip(3 * np.sqrt(weights @ (coordinates - at) ** 2), LEAST_RADIUS * span, span / 2)
    centre = np.clip(at, low + radii, high - radii)
    if (np.abs(centre - at) <= radii / 3).all():
        return Ellipse(tuple(centre.tolist()), tuple(radii.tolist()), colour=colour, extinction=extinction)
    first, last = np.clip(at - 2 / 3 * radii, low, high), np.clip(at + 2 / 3 * radii, low, high)
    return Box(tuple(first.tolist()), tuple(last.tolist()), colour=colour, extinction=extinction)


def box(axes: tuple[Axis, ...], value: float, half: float, colour: str, extinction: float) -> Box:
    """Box around a value on the first axis, over the whole of the others."""
    first, *others = axes
    half = float(np.clip(half, LEAST_RADIUS * first.span, first.span / 2))
    middle = float(np.clip(value, first.low + half, first.high - half))
    low, high = (middle - half, *(a.low for a in others)), (middle + half, *(a.high for a in others))
    return Box(low, high, colour=colour, extinction=extinction)


def linear_image(counts: AnyArray) -> AnyArray:
    """Shades of counts on a linear scale, white above a high percentile of those that are not 0."""
    filled = counts[counts > 0]
    return _shade(np.minimum(counts, np.percentile(filled, BRIGHT) if filled.size else 1))


def _shade(numbers: AnyArray) -> AnyArray:
    greatest = max(float(numbers.max(initial=0)), 1e-300)
    return np.rint(255 * (numbers.astype(np.float64) / greatest)).astype(np.uint8)


def _peak(layer: Layer, p_world: FloatArray) -> tuple[float, float]:
    """Half width and extinction of a peak at a point."""
    try:
        found = peak_at(layer.volume, p_world, None, PALETTE[0], layer.channel, layer.time)
    except DataError:  # beside an empty sample
        return 0.0, float(np.log(2) / (VOXELS_DEEP * min(layer.volume.spacing)))
    (low, _, _), (_, _, extinction), (high, _, _) = found.points
    return (high - low) / 2, extinction


def _counted(session: Session, layer: Layer, variables: tuple[Any, ...], bins: int) -> JointHistogram:
    """Histogram of a layer's volume, kept for the session."""
    kept = _KEPT.setdefault(session, {})
    key = (id(layer.volume), layer.channel, layer.time, variables, bins)
    of, found = kept.get(key, (None, None))
    # A volume that is gone may have left its number to another.
    if found is None or of is None or of() is not layer.volume:
        found = joint_histogram(layer.volume, variables, bins, layer.channel, layer.time, _progress(session))
        kept.pop(key, None)
        kept[key] = ref(layer.volume), found
        for old in list(kept)[:-MOST_KEPT]:
            kept.pop(old, None)
    return found


def _progress(session: Session) -> Any:
    return lambda what, done, total: session.send({"type": "progress", "what": what, "done": done, "total": total})


def _told(histogram: JointHistogram, number: int) -> dict[str, Any]:
    unit = histogram.units[number] if histogram.units else ""
    axis = histogram.axes[number]
    return dataclasses.asdict(axis) | {"label": label(histogram, number), "unit": unit, "ticks": ticks(axis, TICKS)}


def _axis(data: Any, where: str) -> Axis:
    if not isinstance(data, dict) or not {"variable", "low", "high"} <= set(data):
        raise ValueRangeError(where, "is no axis", "give variable, low and high")
    return Axis(data["variable"], data["low"], data["high"])


def _cut(volume: Volume, time: int, low: AnyArray, high: AnyArray) -> Volume:
    """The voxels from low to before high, of one time step."""
    (x, y, z), matrix = (slice(a, b) for a, b in zip(low, high, strict=True)), volume.world_from_index.copy()
    matrix[:3, 3] += matrix[:3, :3] @ low
    array = np.stack([volume.grid(channel, time)[z, y, x] for channel in range(volume.channel_count)])
    return Volume(array[None], world_from_index=matrix, channel_names=volume.channel_names, no_data=volume.no_data)
