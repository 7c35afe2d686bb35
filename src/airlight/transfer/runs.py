"""Runs of surfaces: what those from one to another send together in the order of a ray, and the medium between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from .cells import cut_at
from .function import FloatArray, TransferFunction

NODES = 6
PART_DEPTH = 4.0
IntArray = npt.NDArray[np.int64]


@lru_cache(maxsize=32)
def medium_of(function: TransferFunction) -> TransferFunction:
    """Return the function without its surfaces."""
    return replace(function, surfaces=())


def iso_values(function: TransferFunction) -> FloatArray:
    """Values (m,) of the surfaces."""
    return np.array([surface.value for surface in function.surfaces])


@dataclass(frozen=True, eq=False)
class Way:
    """Surfaces in the order in which a ray meets them, and the medium between them.

    ``values`` (m,); ``rgba`` (m, 4), colour and a one, and ``opacities`` (m,) of the sides that the ray sees. The medium is cut
    at ``borders`` (k + 1,) into cells with ``start`` and ``end`` (k, 4), colour and extinction just inside of them; surface i
    lies at border ``places[i]``.
    """

    values: FloatArray
    rgba: FloatArray
    opacities: FloatArray
    borders: FloatArray
    places: IntArray
    start: FloatArray
    end: FloatArray
    associated: bool


def way_of(function: TransferFunction, rises: bool) -> Way:
    """Return the surfaces and the medium between them for rays whose values rise, or fall."""
    values, medium = iso_values(function), medium_of(function)
    turn = slice(None) if rises else slice(None, None, -1)
    sides = [surface.front if rises else surface.back for surface in function.surfaces][turn]
    inside = medium.values[(medium.values > values[0]) & (medium.values < values[-1])]
    borders = np.union1d(values, inside)
    cells = cut_at(medium, borders) if len(borders) > 1 else None
    low, high = (np.zeros((0, 4)),) * 2 if cells is None else (cells.low[turn], cells.high[turn])
    return Way(
        values=values[turn],
        rgba=np.array([(*rgb, 1.0) for rgb, _ in sides]),
        opacities=np.array([opacity for _, opacity in sides]),
        borders=borders[turn],
        places=np.searchsorted(borders, values) if rises else len(borders) - 1 - np.searchsorted(borders, values)[::-1],
        start=low if rises else high,
        end=high if rises else low,
        associated=function.associated,
    )


def mean_extinction(way: Way, first: IntArray, last: IntArray) -> FloatArray:
    """Mean extinction (n,) between surfaces (n,), 0 between one and itself."""
    steps = np.abs(np.diff(way.borders)) * (way.start[:, 3] + way.end[:, 3]) / 2
    reach = np.concatenate([[0.0], np.cumsum(steps)])[way.places]
    return np.asarray((reach[last] - reach[first]) / _distance(way, first, last))


def _distance(way: Way, first: IntArray, last: IntArray) -> FloatArray:
    """How far two surfaces lie apart, in data units; 1 where they are the same."""
    apart = np.abs(way.values[last] - way.values[first])
    return np.where(apart > 0, apart, 1.0)


def runs(way: Way) -> tuple[FloatArray, FloatArray]:
    """Light (m, m, 4) of the surfaces from one to another, with nothing between them, and its moment (m, m, 4)."""
    m = len(way.values)
    light, moment = np.zeros((m, m, 4)), np.zeros((m, m, 4))
    through = np.ones(m)
    for last in range(m):
        # All runs that begin at or before this surface get one more.
        light[:last, last], moment[:last, last] = light[:last, last - 1], moment[:last, last - 1]
        added = through[: last + 1, None] * way.opacities[last] * way.rgba[last]
        light[: last + 1, last] += added
        moment[: last + 1, last] += added * (way.values[last] - way.values[: last + 1])[:, None]
        through[: last + 1] *= 1 - way.opacities[last]
    pairs = np.triu_indices(m)
    signed = _distance(way, *pairs) * (1 if m < 2 or way.values[0] < way.values[-1] else -1)
    moment[pairs] /= signed[:, None]
    return light, moment


def runs_in_medium(way: Way, first: IntArray, last: IntArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Light (n, lengths, 4) of runs of surfaces (n,) and of the medium between them, and its moment (n, lengths, 4).

    ``lengths`` are those of the way from the first to the last. Gauss' rule with six nodes over pieces of an optical depth of
    at most four.
    """
    distance = _distance(way, first, last)
    begins, ends = way.places[first], way.places[last]
    surface_at = {int(place): number for number, place in enumerate(way.places)}
    light = np.repeat((way.opacities[first, None] * way.rgba[first])[:, None], len(lengths), axis=1)
    moment = np.zeros_like(light)
    through = np.repeat((1 - way.opacities[first])[:, None], len(lengths), axis=1)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    for cell, (start, end) in enumerate(zip(way.start, way.end, strict=True)):
        rows = np.nonzero((begins <= cell) & (cell < ends))[0]
        share = abs(way.borders[cell + 1] - way.borders[cell]) / distance[rows]
        at = np.abs(way.borders[cell] - way.values[first[rows]]) / distance[rows]
        if start[3] or end[3] or (way.associated and (start[:3].any() or end[:3].any())):
            piece = lengths * share[:, None]
            depth = piece * (start[3] + end[3]) / 2
            parts = int(np.clip(np.ceil(depth.max(initial=0.0) / PART_DEPTH), 1, 256))
            x = ((np.arange(parts)[:, None] + (nodes + 1) / 2) / parts).ravel()
            medium = start + (end - start) * x[:, None]
            source = np.concatenate([medium[:, :3] * (1.0 if way.associated else medium[:, 3:]), medium[:, 3:]], axis=1)
            run = start[3] * x + (end[3] - start[3]) * x * x / 2
            w = np.exp(-np.minimum(piece[..., None] * run, 700.0)) * np.tile(weights / 2 / parts, parts)
            w *= (through[rows] * piece)[..., None]
            light[rows] += w @ source
            moment[rows] += (w * (at[:, None, None] + share[:, None, None] * x)) @ source
            through[rows] *= np.exp(-np.minimum(depth, 700.0))
        if cell + 1 in surface_at:
            number = surface_at[cell + 1]
            added = (through[rows] * way.opacities[number])[..., None] * way.rgba[number]
            light[rows] += added
            moment[rows] += added * (at + share)[:, None, None]
            through[rows] *= 1 - way.opacities[number]
    return light, moment
