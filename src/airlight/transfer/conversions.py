"""Transfer functions of other programs, and airlight's for them.

Where others keep opacities for a unit distance and run straight from one to the next, points are put in until opacities over
any length of up to 100 unit distances are within 1/1000; colours in display numbers likewise. See `airlight.transfer.opacity`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from .colour import linear_to_srgb, srgb_to_linear
from .given import rising_range, whole
from .opacity import check_distance, extinction_from_opacity, extinctions_of, opacities_of, opacity_from_extinction
from .polyline import FloatArray, Track, crossed, densified, even, sides, simplified, stepped, thinned, track, union

if TYPE_CHECKING:
    from .function import TransferFunction

Encoding = Literal["srgb", "linear"]

COLOUR_TOLERANCE = 1e-3
SHARES = np.linspace(0, 1, 257)
VTK_RGB = 0
STRAIGHT = 0.01
"""VTK: with a lesser sharpness the way from a node to the next is straight."""
EDGE = 1e-9
"""How far from a step, as a share of the way between nodes, its sides are looked up."""


# -- VTK


def from_vtk(
    cls: type[TransferFunction], opacity: Any, colour: Any, unit_distance: float = 1.0, *, encoding: Encoding = "srgb"
) -> TransferFunction:
    """Return the function that a ``vtkVolumeProperty`` describes.

    VTK's opacity is for ``ScalarOpacityUnitDistance``: along a step it takes ``1 - (1 - a)**(step / unit)``
    (``vtkOpenGLVolumeOpacityTable``), so ``extinction = -ln(1 - a) / unit``. Opacity and colour run straight between points,
    colour in the numbers of the display; points are put in so that both stay true (see `airlight.transfer.conversions`).

    Parameters
    ----------
    opacity
        A ``vtkPiecewiseFunction``, with midpoints and sharpness, or points ``(value, opacity)``.
    colour
        A ``vtkColorTransferFunction`` of any colour space, or points ``(value, r, g, b)`` with numbers in [0, 1].
    unit_distance
        ``ScalarOpacityUnitDistance``, in world units.
    encoding
        What VTK's colours are: ``"srgb"``, as it shows them on a display, or ``"linear"``.

    Raises
    ------
    ValueRangeError
        When values are out of order, or opacities, colours or the distance are out of range.
    """
    check_distance(unit_distance, "vtk.unit_distance")
    alpha, rgb = _vtk_track(opacity, 1, "vtk.opacity"), _vtk_track(colour, 3, "vtk.colour")
    return cls(crossed(_decoded(rgb, encoding), extinctions_of(alpha, unit_distance, alpha[0])))


def to_vtk(
    function: TransferFunction, unit_distance: float = 1.0, *, encoding: Encoding = "srgb"
) -> tuple[list[tuple[float, float]], list[tuple[float, float, float, float]]]:
    """Return the points of a ``vtkPiecewiseFunction`` and of a ``vtkColorTransferFunction``.

    ``AddPoint(*p)`` and ``AddRGBPoint(*p)`` take them; set ``ScalarOpacityUnitDistance`` to ``unit_distance``. The opacity is
    ``1 - exp(-extinction unit_distance)``, with points put in as `from_vtk` does. VTK keeps one point a value: the lower end
    of a step is moved down by the least that a float64 can.

    Parameters
    ----------
    unit_distance
        In world units.
    encoding
        What VTK's colours shall be: ``"srgb"``, for a display, or ``"linear"``.

    Raises
    ------
    ValueRangeError
        For associated functions, and colours brighter than 1, which VTK cannot hold.
    """
    check_distance(unit_distance, "vtk.unit_distance")
    _check_plain(function, "VTK")
    values, rows = simplified(*track(function))
    if rows[:, :3].max() > 1:
        raise ValueRangeError("transfer", "has colours brighter than 1, and VTK has none", "scale them down")
    alphas, alpha = opacities_of((values, rows[:, 3:]), unit_distance)
    places, rgb = _encoded((values, rows[:, :3]), encoding)
    return (
        [(v, a) for v, (a,) in zip(_parted(alphas), alpha.tolist(), strict=True)],
        [(v, r, g, b) for v, (r, g, b) in zip(_parted(places), rgb.tolist(), strict=True)],
    )


# -- OSPRay


def from_ospray(
    cls: type[TransferFunction],
    color: npt.ArrayLike,
    opacity: npt.ArrayLike,
    value_range: tuple[float, float],
    density_scale: float = 1.0,
) -> TransferFunction:
    """Return the function of OSPRay's transfer function ``piecewiseLinear`` and its volumetric model's ``densityScale``.

    OSPRay weakens light by ``exp(-opacity step densityScale)``: its opacity is an extinction already, ``extinction = opacity
    densityScale`` (``modules/cpu/render/scivis/volumes.ispc``). Nothing is approximated.

    Parameters
    ----------
    color
        Linear colours (n, 3), evenly spaced over the range, ends included.
    opacity
        Opacities (m,), evenly spaced over the range, ends included.
    value_range
        OSPRay's parameter ``value``: first and last value, in data units.
    density_scale
        The model's ``densityScale``.

    Raises
    ------
    ValueRangeError
        When an array has another shape, or numbers are out of range.
    """
    low, high = rising_range(value_range, "ospray.value")
    check_distance(density_scale, "ospray.densityScale")
    rgb = _checked_table(color, 3, "ospray.color")
    tau = _checked_table(np.asarray(opacity, dtype=np.float64)[..., None], 1, "ospray.opacity") * density_scale
    return cls(crossed(simplified(*even(rgb, low, high)), simplified(*even(tau, low, high))))


def to_ospray(function: TransferFunction, entries: int = 1024) -> dict[str, Any]:
    """Return OSPRay's parameters ``color`` (n, 3), ``opacity`` (n,), ``value`` (the range) and ``densityScale``.

    Opacities are ``extinction / densityScale`` with the greatest extinction as scale. The tables have evenly spaced entries
    and run straight between them: where no entry lies on a control point its corner is cut, and a step is as wide as an entry.

    Parameters
    ----------
    entries
        Size of the tables.

    Raises
    ------
    ValueRangeError
        For associated functions, functions of one value alone, and fewer than 2 entries.
    """
    rgb, tau = _sampled(function, entries, "OSPRay")
    scale = float(tau.max()) or 1.0
    return {"color": rgb, "opacity": tau / scale, "value": function.domain, "densityScale": scale}


# -- ANARI


def from_anari(
    cls: type[TransferFunction],
    color: npt.ArrayLike,
    opacity: npt.ArrayLike = 1.0,
    value_range: tuple[float, float] = (0.0, 1.0),
    unit_distance: float = 1.0,
) -> TransferFunction:
    """Return the function of ANARI's volume ``transferFunction1D``.

    Along a step light is weakened by ``(1 - a)**(step / unitDistance)``, where ``a`` is ``opacity`` times the fourth component
    of ``color`` (specification, extension ``KHR_VOLUME_TRANSFER_FUNCTION1D`` and its example algorithm): ``extinction = -ln(1 -
    a) / unitDistance``. Points are put in where ``a`` bends otherwise (see `airlight.transfer.conversions`).

    Parameters
    ----------
    color
        Linear colours (n, 3) or (n, 4), evenly spaced over the range, ends included; or one colour.
    opacity
        Opacities (m,), evenly spaced likewise, or one number.
    value_range
        ``valueRange``, in data units.
    unit_distance
        ``unitDistance``, in world units.

    Raises
    ------
    ValueRangeError
        When an array has another shape, or numbers are out of range.
    """
    low, high = rising_range(value_range, "anari.valueRange")
    check_distance(unit_distance, "anari.unitDistance")
    colours = np.atleast_2d(np.asarray(color, dtype=np.float64))
    rgba = _checked_table(colours, 4 if colours.shape[-1] == 4 else 3, "anari.color")
    own = _checked_table(np.atleast_1d(np.asarray(opacity, dtype=np.float64))[:, None], 1, "anari.opacity")
    factor = rgba[:, 3:] if rgba.shape[1] == 4 else np.ones((1, 1))
    rgb, factor_track, own_track = (simplified(*even(rows, low, high)) for rows in (rgba[:, :3], factor, own))
    return cls(crossed(rgb, extinctions_of(_product(own_track, factor_track), unit_distance)))


def to_anari(function: TransferFunction, unit_distance: float = 1.0, entries: int = 1024) -> dict[str, Any]:
    """Return ANARI's parameters ``color`` (n, 3), ``opacity`` (n,), ``valueRange`` and ``unitDistance``.

    ``opacity = 1 - exp(-extinction unitDistance)`` at evenly spaced entries, with straight lines between: where no entry lies
    on a control point its corner is cut, and a step is as wide as an entry.

    Parameters
    ----------
    unit_distance
        In world units.
    entries
        Size of the tables.

    Raises
    ------
    ValueRangeError
        For associated functions, functions of one value alone, and fewer than 2 entries.
    """
    rgb, tau = _sampled(function, entries, "ANARI")
    alpha = opacity_from_extinction(tau, unit_distance)
    return {"color": rgb, "opacity": alpha, "valueRange": function.domain, "unitDistance": float(unit_distance)}


# -- tables of colours


def from_table(
    cls: type[TransferFunction],
    table: npt.ArrayLike,
    value_range: tuple[float, float],
    unit_distance: float = 1.0,
    *,
    encoding: Encoding = "linear",
) -> TransferFunction:
    """Return the function of a look-up table whose nearest entry holds: exact steps.

    Entry k of n holds for values from ``low + k w`` up to ``low + (k + 1) w`` with ``w = (high - low) / n``, as in textures and
    ``vtkLookupTable``; the first and the last hold beyond the ends, too. ``extinction = -ln(1 - a) / unit_distance``.

    Parameters
    ----------
    table
        Red, green, blue, opacity (n, 4), all in [0, 1].
    value_range
        Outer edges of the first and of the last entry, in data units.
    unit_distance
        Way, in world units, for which the opacities are.
    encoding
        What the colours are: ``"linear"`` or ``"srgb"``.

    Raises
    ------
    ValueRangeError
        When the table has another shape, or numbers are out of range.
    """
    low, high = rising_range(value_range, "table.value_range")
    check_distance(unit_distance, "table.unit_distance")
    rgba = _checked_table(table, 4, "table")
    rgb = rgba[:, :3] if _is_linear(encoding) else srgb_to_linear(rgba[:, :3])
    tau = extinction_from_opacity(rgba[:, 3:], unit_distance)
    return cls(crossed(stepped(rgb, low, high), stepped(tau, low, high)))


# -- parts


def _vtk_track(given: Any, width: int, where: str) -> Track:
    """Return the rows (n, width) of a function object of VTK's, or of points (n, 1 + width)."""
    if hasattr(given, "GetNodeValue"):
        return _vtk_object(given, width)
    nodes = np.atleast_2d(np.asarray(given, dtype=np.float64))
    if nodes.shape[1] != 1 + width or len(nodes) == 0:
        remedy = f"give {1 + width} numbers a point, or the vtk object where it has midpoints and sharpness"
        raise ValueRangeError(where, f"has shape {nodes.shape}", remedy)
    if not np.isfinite(nodes[:, 0]).all() or (np.diff(nodes[:, 0]) < 0).any():
        raise ValueRangeError(where, "has values that are not finite or out of order", "sort the points")
    return nodes[:, 0], _checked_table(nodes[:, 1:], width, where)


def _vtk_object(given: Any, width: int) -> Track:
    """Return the rows of a function object: its nodes where it is straight between them, else what it tells itself."""
    nodes = np.zeros((given.GetSize(), width + 3))  # value, numbers, midpoint, sharpness
    for k in range(len(nodes)):
        row = [0.0] * (width + 3)
        given.GetNodeValue(k, row)
        nodes[k] = row
    if len(nodes) == 0:
        raise ValueRangeError(f"vtk.{'colour' if width == 3 else 'opacity'}", "has no points")
    evaluate = given.GetColor if width == 3 else given.GetValue
    bent = given.GetColorSpace() != VTK_RGB or given.UsingLogScale() if width == 3 else given.GetUseLogScale()
    values, rows = [nodes[:1, 0]], [nodes[:1, 1:-2]]
    for low, high in pairwise(nodes):
        if bent or low[-1] >= STRAIGHT or low[-2] != 0.5:
            # Steps may lie at the midpoint and at the nodes: there it is asked on both sides.
            step = low[-2]
            share = np.sort([0, step, step, 1, *SHARES])
            asked = np.sort([EDGE, step - EDGE, step + EDGE, 1 - EDGE, *np.clip(SHARES, EDGE, 1 - EDGE)])
            values.append(low[0] + share * (high[0] - low[0]))
            rows.append(np.array([np.atleast_1d(evaluate(low[0] + at * (high[0] - low[0]))) for at in asked]))
        values.append(high[:1])
        rows.append(high[None, 1:-2])
    if not given.GetClamping():
        nothing = np.zeros((1, width))
        values, rows = [nodes[:1, 0], *values, nodes[-1:, 0]], [nothing, *rows, nothing]
    return np.concatenate(values), np.clip(np.concatenate(rows), 0, 1)


def _decoded(colour: Track, encoding: Encoding) -> Track:
    """Return linear colours (n, 3) of encoded ones that run straight from row to row."""
    if _is_linear(encoding):
        return colour
    values, encoded = densified(*colour, lambda start, end: SHARES)
    return thinned(
        values, srgb_to_linear(encoded), lambda a, b: _colours_apart(linear_to_srgb(a), linear_to_srgb(b)), colour[0]
    )


def _encoded(colour: Track, encoding: Encoding) -> Track:
    """Return encoded colours (n, 3) of linear ones that run straight from row to row."""
    if _is_linear(encoding):
        return colour
    # Even in linear light and even in what the eye sees: the darkest tenth bends most.
    values, rgb = densified(*colour, lambda start, end: np.concatenate([SHARES, SHARES**3, 1 - SHARES**3]))
    return thinned(values, np.asarray(linear_to_srgb(rgb), dtype=np.float64), _colours_apart, colour[0])


def _colours_apart(straight: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(np.abs(straight - right).max(axis=1) / COLOUR_TOLERANCE)


def _product(a: Track, b: Track) -> Track:
    """Return the product (n, 1) of two tracks without steps, densely where both change: it is curved there."""
    knots = union(a[0], b[0])
    pairs = np.concatenate([sides(*a, knots)[1], sides(*b, knots)[1]], axis=1)
    values, pairs = densified(knots, pairs, lambda start, end: SHARES if (start != end).all() else ())
    return values, pairs[:, :1] * pairs[:, 1:]


def _parted(values: FloatArray) -> list[float]:
    """Return values of which no two are equal: the first of two is moved down."""
    lowered = values.copy()
    same = np.flatnonzero(np.diff(values) == 0)
    lowered[same] = np.nextafter(values[same], -np.inf)
    return [float(v) for v in lowered]


def _sampled(function: TransferFunction, entries: int, whose: str) -> tuple[FloatArray, FloatArray]:
    """Return colours (n, 3) and extinctions (n,) of a function at evenly spaced values."""
    _check_plain(function, whose)
    low, high = function.domain
    if low == high:
        raise ValueRangeError("transfer", f"has the one value {low:g}, and {whose} needs a range", "add a point")
    return function(np.linspace(low, high, whole(entries, "entries", 2)))


def _check_plain(function: TransferFunction, whose: str) -> None:
    if function.associated:
        raise ValueRangeError("transfer", f"is associated, and {whose} knows no glow without extinction")
    if function.surfaces:
        raise ValueRangeError("transfer", f"has surfaces, and {whose} knows none", "leave them out: with_surfaces(())")


def _checked_table(given: npt.ArrayLike, width: int, where: str) -> FloatArray:
    """Return a table (n, width) of numbers in [0, 1]."""
    table = np.asarray(given, dtype=np.float64)
    if table.ndim != 2 or table.shape[1] != width or len(table) == 0:
        raise ValueRangeError(where, f"has shape {table.shape}, must be (n, {width})")
    wrong = ~((table >= 0) & (table <= 1)).all(axis=1)
    if wrong.any():
        number = int(np.argmax(wrong))
        raise ValueRangeError(f"{where}[{number}]", f"is {table[number].tolist()}", "give numbers in [0, 1]")
    return table


def _is_linear(encoding: str) -> bool:
    if encoding not in ("srgb", "linear"):
        raise ValueRangeError("encoding", f"is {encoding!r}, must be srgb or linear")
    return encoding == "linear"
