"""Ambient occlusion: the share of light from all directions that comes through the volume, on a coarse grid of cells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..volume import FloatArray
from .clips import kept_by_all
from .field import field_value, trilinear
from .region import part_at
from .setup import Sample, Setup
from .shade import VISIBILITIES
from .transfer import TRANSFERS

LEAST_THROUGH = 1e-4


def ambient_occlusion(setup: Setup, light_index: int | None, p_world: FloatArray) -> FloatArray:
    """Openness (n, 3) at points; lights reach them all."""
    if light_index is not None:
        return np.ones_like(p_world)
    if "openness" not in setup.once:
        setup.once["openness"] = openness(setup)
    p_cell = (setup.index_of(p_world) + 0.5) / block_of(setup) - 0.5
    return np.repeat(trilinear(setup.once["openness"], p_cell)[:, None], 3, axis=1)


def block_of(setup: Setup) -> FloatArray:
    """Voxels (3,) of a cell along x, y and z: as many as make the cells of the longest side, and equally long in the world."""
    volume = setup.layer.volume
    size, spacing = np.array(volume.size, dtype=np.float64), np.array(volume.spacing)
    longest = (size * spacing).max()
    block: FloatArray = np.minimum(size, np.maximum(1.0, np.round(longest / (setup.stages["visibility"].cells * spacing))))
    return block


def cell_side(setup: Setup) -> float:
    """Mean side of a cell [world]."""
    return float(np.prod(block_of(setup) * setup.layer.volume.spacing) ** (1 / 3))


def openness(setup: Setup) -> FloatArray:
    """Openness of all cells: (z, y, x)."""
    depth = occluders(setup)
    z, y, x = np.indices(depth.shape).reshape(3, -1)
    others = [(other, occluders(other)) for other in hiding_beside(setup)]
    return seen_from(setup, depth, np.stack([x, y, z], axis=1).astype(np.float64), others).reshape(depth.shape)


def hiding_beside(setup: Setup) -> list[Setup]:
    """Return the other layers, with cells as the layer's own stage asks for them."""
    stage = setup.stages["visibility"]
    return [replace(other, stages={**other.stages, "visibility": stage}, once={}) for other in setup.beside]


@np.errstate(under="ignore")
def seen_from(
    setup: Setup, depth: FloatArray, p_cell: FloatArray, others: Sequence[tuple[Setup, FloatArray]] = ()
) -> FloatArray:
    """Transmittance from points (n, 3), in cells, averaged over directions all round."""
    stage, volume, side = setup.stages["visibility"], setup.layer.volume, cell_side(setup)
    sides = np.array(volume.size) * volume.spacing
    radius = max(0.15 * float(np.linalg.norm(sides)), 2 * side) if stage.radius is None else float(stage.radius)
    p_world = world_of(setup, p_cell)
    total = np.zeros(len(p_cell))
    for direction in directions(stage.directions):
        ways = [(setup, depth), *others]
        total += np.exp(-sum(met_between(one, cells, p_world, direction, side, radius) for one, cells in ways))
    return np.asarray(total / stage.directions)


def met_between(
    setup: Setup, depth: FloatArray, p_world: FloatArray, direction: FloatArray, near_world: float, far_world: float
) -> FloatArray:
    """Optical depth (n,) in a layer on the way from points, between two distances, in even steps of at most a cell's side.

    Cells finer than those that one looks from, whose side is ``near_world``, are passed in steps of half of that.
    """
    volume, side, block = setup.layer.volume, cell_side(setup), block_of(setup)
    steps = max(1, math.ceil((far_world - near_world) / max(side, near_world / 2)))
    step = (far_world - near_world) / steps
    beyond = np.array(volume.size) / block - 0.5
    met = np.zeros(len(p_world))
    for distance in near_world + (np.arange(steps) + 0.5) * step:
        place = (setup.index_of(p_world + distance * direction) + 0.5) / block - 0.5
        inside = ((place >= -0.5) & (place <= beyond)).all(axis=1)
        met += np.where(inside, trilinear(depth, place), 0.0)
    return met * step / side


def world_of(setup: Setup, p_cell: FloatArray) -> FloatArray:
    """Points (n, 3) of the world by cells, counted from the middle of the first."""
    matrix = setup.layer.volume.world_from_index
    return np.asarray(((p_cell + 0.5) * block_of(setup) - 0.5) @ matrix[:3, :3].T + matrix[:3, 3])


def directions(count: int) -> FloatArray:
    """Unit vectors (count, 3) on a spiral over the sphere, turned by the golden angle from one to the next."""
    number = np.arange(count)
    z, turn = 1 - (2 * number + 1) / count, np.pi * (3 - np.sqrt(5)) * number
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def occluders(setup: Setup) -> FloatArray:
    """Optical depth of grey light over a cell's side, (z, y, x)."""
    return coloured_occluders(setup, 0.0)[..., 0]


@np.errstate(under="ignore")
def coloured_occluders(setup: Setup, tint: float) -> FloatArray:
    """Optical depth by colour over a cell's side, (z, y, x, 3), by the mean of what lets light through at its voxels."""
    side = cell_side(setup)
    opacity = -np.expm1(-voxel_extinction(setup, tint) * side)
    mean = opacity
    for axis, block in enumerate(block_of(setup).astype(int)[::-1]):
        first = np.arange(0, opacity.shape[axis], block)
        voxels = np.diff(first, append=opacity.shape[axis])  # the last cell may have fewer
        mean = np.add.reduceat(mean, first, axis) / np.expand_dims(voxels, [n for n in range(4) if n != axis])
    return np.asarray(-np.log(np.maximum(1 - mean, LEAST_THROUGH)))


def voxel_extinction(setup: Setup, tint: float) -> FloatArray:
    """Mean extinction (z, y, x, 3) of the slabs from each voxel to its next neighbours, none where it is empty.

    With a tint of 1 there is none for light of a slab's own colour.
    """
    volume = setup.layer.volume
    nz, ny, nx = volume.size[::-1]
    z, y, x = np.indices((nz, ny, nx)).reshape(3, -1)
    voxels = np.stack([x, y, z], axis=1).astype(np.float64)
    here = _sample(setup, voxels)
    colour, shown = part_at(setup, voxels)
    total, kept = np.zeros((len(voxels), 3)), kept_by_all(setup.clips, here.p_world)
    for axis in range(3):
        next_voxels = voxels.copy()
        next_voxels[:, axis] = np.minimum(voxels[:, axis] + 1, volume.size[axis] - 1)
        there = _sample(setup, next_voxels).where_empty_take(here)
        length = volume.spacing[axis]
        rows = np.nonzero(~here.empty & kept)[0]
        sent = TRANSFERS[setup.stages["transfer"].name](setup, here[rows], there[rows], length * shown[rows])
        own = colour[rows] * np.clip(sent.rgb / np.maximum(sent.alpha, 1e-12)[:, None], 0.0, 1.0)
        total[rows] -= (1 - tint * own) * (np.log(np.maximum(1 - sent.alpha, 1e-7)) / length / 3)[:, None]
    return total.reshape(nz, ny, nx, 3)


def _sample(setup: Setup, p_index: FloatArray) -> Sample:
    matrix = setup.layer.volume.world_from_index
    return Sample(*field_value(setup, p_index), p_index, p_index @ matrix[:3, :3].T + matrix[:3, 3], np.zeros(len(p_index)))


VISIBILITIES["ambient_occlusion"] = ambient_occlusion
