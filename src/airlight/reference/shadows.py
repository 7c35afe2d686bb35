"""Shadow volumes: what comes through from lights to cells. ``half_angle.transmittance`` is what that comes near to."""

from __future__ import annotations

import numpy as np

from ..light import Light
from ..volume import FloatArray
from .field import trilinear
from .occlusion import block_of, cell_side, coloured_occluders, hiding_beside, world_of
from .setup import Setup
from .shade import VISIBILITIES

LEAST_SHARE = 1e-6  # of a way along one axis: less is none


def shadow_volume(setup: Setup, light_index: int | None, p_world: FloatArray) -> FloatArray:
    """What cells have (n, 3) of a light at points, looked up a bit towards it; ambient light and head lights reach them all."""
    if light_index is None or setup.lights[light_index].kind == "head":
        return np.ones_like(p_world)
    lamp, key = setup.lights[light_index], f"shadows {light_index}"
    if key not in setup.once:
        setup.once[key] = cells_reached(setup, lamp)
    bias = setup.stages["visibility"].bias
    place = nearer(lamp, p_world, cell_side(setup) if bias is None else bias * setup.spacing_world)
    return trilinear(setup.once[key], _cells_of(setup, place) + 0.5)


def nearer(lamp: Light, p_world: FloatArray, distance_world: float) -> FloatArray:
    """Points (n, 3) moved towards a light, as far as to it."""
    if lamp.kind == "directional":
        return p_world + distance_world * np.array(lamp.vector)
    way = np.array(lamp.vector) - p_world
    reach = np.linalg.norm(way, axis=1, keepdims=True)
    return np.asarray(p_world + way * np.minimum(distance_world / np.maximum(reach, 1e-20), 1.0))


def cells_reached(setup: Setup, lamp: Light) -> FloatArray:
    """What comes through to the middles of cells and of one more all round them: (z, y, x, 3)."""
    stage = setup.stages["visibility"]
    if "occluders" not in setup.once:
        setup.once["occluders"] = coloured_occluders(setup, stage.tint)
    reached = WAYS[stage.by](setup, setup.once["occluders"], lamp)
    places = world_of(setup, _middles(setup.once["occluders"]) - 0.5)
    for other in hiding_beside(setup):
        reached = reached * rays_from(other, coloured_occluders(other, stage.tint), _cells_of(other, places), lamp).reshape(
            reached.shape
        )
    return reached


def by_rays(setup: Setup, depth: FloatArray, lamp: Light) -> FloatArray:
    """Go from each cell to the light."""
    nz, ny, nx = (n + 2 for n in depth.shape[:3])
    return rays_from(setup, depth, _middles(depth), lamp).reshape(nz, ny, nx, 3)


def _middles(depth: FloatArray) -> FloatArray:
    """Middles (n, 3) of cells and of one more all round them."""
    counts = tuple(n + 2 for n in depth.shape[:3])
    return np.asarray(np.indices(counts).reshape(3, -1).T[:, ::-1].astype(np.float64) - 0.5)


def rays_from(setup: Setup, depth: FloatArray, p_cell: FloatArray, lamp: Light) -> FloatArray:
    """What comes through (n, 3) a layer to places anywhere."""
    way, _ = _ways(setup, lamp, p_cell)
    begin, end = _stretch(setup, p_cell, way)
    end = end if lamp.kind == "directional" else np.minimum(end, 1.0)
    meets = begin < end
    here = np.ones((len(p_cell), 3))
    here[meets] = _through(setup, depth, p_cell[meets], way[meets], begin[meets], end[meets])
    return here


def by_sweep(setup: Setup, depth: FloatArray, lamp: Light) -> FloatArray:
    """Go from slice to slice away from the light; each cell takes what came to the slice before, interpolated."""
    counts = np.array(depth.shape[2::-1]) + 2
    _, away = _ways(setup, lamp, np.zeros((1, 3)))
    axis = int(np.round(np.abs(away) / np.abs(away).max(), 6).argmax())  # the first of those that are as far
    u, v = (axis + 1) % 3, (axis + 2) % 3
    towards = 1.0 if away[axis] > 0 else -1.0
    found = np.ones((*counts, 3))  # x, y, z
    slices = np.moveaxis(found, (axis, u, v), (0, 2, 1))  # slice, v, u
    across = np.indices((counts[v], counts[u])).reshape(2, -1)
    order = range(counts[axis])
    before = None
    for place in reversed(order) if towards > 0 else order:
        middle = np.empty((across.shape[1], 3))
        middle[:, axis], middle[:, v], middle[:, u] = place - 0.5, across[0] - 0.5, across[1] - 0.5
        way, _ = _ways(setup, lamp, middle)
        pace = way[:, axis] * towards
        way = way / np.where(pace > 0, pace, 1.0)[:, None]
        begin, end = _stretch(setup, middle, way)
        meets = (pace > 0) & (begin < end)
        here = np.ones((len(middle), 3))
        here[meets] = _through(
            setup, depth, middle[meets], way[meets], np.minimum(begin, 1.0)[meets], np.minimum(end, 1.0)[meets]
        )
        inner = meets & (end > 1.0)
        if before is not None and inner.any():
            came = (middle + way)[inner]
            flat = np.stack([came[:, u], came[:, v], np.zeros(len(came))], axis=1) + 0.5
            here[inner] *= trilinear(before, flat)
        slices[place] = here.reshape(counts[v], counts[u], 3)
        before = slices[place][None]
    return np.ascontiguousarray(np.moveaxis(found, (0, 1, 2), (2, 1, 0)))


def _cells_of(setup: Setup, p_world: FloatArray) -> FloatArray:
    """Places in cells, from the corner of the volume."""
    return np.asarray((setup.index_of(p_world) + 0.5) / block_of(setup))


def _ways(setup: Setup, lamp: Light, p_cell: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ways (n, 3) from places to the light, in cells, and how far it is away (3,) along each axis."""
    if lamp.kind == "directional":
        way = setup.layer.volume.index_from_world[:3, :3] @ np.array(lamp.vector) / block_of(setup)
        return np.broadcast_to(way, p_cell.shape), way
    place = _cells_of(setup, np.array([lamp.vector]))[0]
    last = np.array(setup.layer.volume.size) / block_of(setup)
    return place - p_cell, np.maximum(place - last, 0.0) + np.minimum(place, 0.0)


def _stretch(setup: Setup, p_cell: FloatArray, way: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Multiples (n,) of ways between which they lie in the domain; nowhere where the first is not less than the other.

    A way along a face that begins on it is inside.
    """
    low, high = ((edge + 0.5) / block_of(setup) for edge in setup.domain)
    along = np.abs(way) <= LEAST_SHARE * np.abs(way).max(axis=1, keepdims=True)
    pace = np.where(along, 1.0, way)
    one, other = (low - p_cell) / pace, (high - p_cell) / pace
    misses = along & ((p_cell < low) | (p_cell > high))
    begin = np.where(along, np.where(misses, np.inf, 0.0), np.minimum(one, other)).max(axis=1)
    end = np.where(along, np.inf, np.maximum(one, other)).min(axis=1)
    return np.maximum(begin, 0.0), end


@np.errstate(under="ignore")
def _through(
    setup: Setup, depth: FloatArray, p_cell: FloatArray, way: FloatArray, begin: FloatArray, end: FloatArray
) -> FloatArray:
    """What comes through (n, 3) along parts of ways, in even steps of at most a cell along each axis, by their middles."""
    span_cells = np.maximum(end - begin, 0.0)
    steps = np.maximum(np.ceil((np.abs(way) * span_cells[:, None]).max(axis=1) - 1e-3), 1.0)
    world = setup.layer.volume.world_from_index[:3, :3] * block_of(setup)
    met = np.zeros((len(p_cell), 3))
    for k in range(int(steps.max(initial=0))):
        rows = np.nonzero((k < steps) & (span_cells > 0))[0]
        share = begin[rows] + (k + 0.5) / steps[rows] * span_cells[rows]
        met[rows] += trilinear(depth, p_cell[rows] + share[:, None] * way[rows] - 0.5)
    length = np.linalg.norm(way @ world.T, axis=1) * span_cells / steps
    return np.asarray(np.exp(-met * (length / cell_side(setup))[:, None]))


WAYS = {"sweep": by_sweep, "rays": by_rays}
VISIBILITIES["shadow_volume"] = shadow_volume
