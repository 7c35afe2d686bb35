"""Sets of directions to which normals are rounded (Kreylos, "Fake" Phong illumination): fixed ones, and ones that fit a volume.

A set is an array (n, 3) of unit vectors in world space; the normal of a voxel becomes that of the set which is nearest.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np
import numpy.typing as npt

from ..volume import AnyArray, FloatArray, Volume, is_empty

DODECAHEDRON = 240
SAMPLES, TRIED_VOXELS = 8192, 1 << 17
TURNS = 40  # moves of each direction


@lru_cache(maxsize=1)
def dodecahedron() -> FloatArray:
    """240 directions (n, 3): the dodecahedron's 60 triangles (face, edge) each split in four, their centres of gravity."""
    golden = (1 + np.sqrt(5)) / 2
    signs = [np.array(s) for s in product((-1.0, 1.0), repeat=3)]
    corners = [*signs, *(np.roll((0.0, a / golden, b * golden), k) for a, b in product((-1, 1), repeat=2) for k in range(3))]
    faces = [np.roll((0.0, a * golden, b), k) for a, b in product((-1, 1), repeat=2) for k in range(3)]
    found = []
    for face in faces:
        # The five corners nearest to a face lie round it; neighbours among them share an edge.
        around = sorted(corners, key=lambda c, face=face: -np.dot(c, face))[:5]  # type: ignore[misc]
        edges = [(a, b) for i, a in enumerate(around) for b in around[:i] if np.linalg.norm(a - b) < 2 / golden + 1e-6]
        for edge in edges:
            triangle = _unit(np.array([face, *edge]))
            middles = _unit(triangle + np.roll(triangle, -1, axis=0))
            found += [np.array([triangle[i], middles[i], middles[i - 1]]).mean(axis=0) for i in range(3)]
            found.append(middles.mean(axis=0))
    directions = _unit(np.array(found))
    directions.flags.writeable = False
    return directions


def spiral(count: int) -> FloatArray:
    """Directions (count, 3) spread evenly over the sphere, along a spiral of golden angles."""
    z = 1 - (2 * np.arange(count) + 1) / count
    angle_rad = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(angle_rad), across * np.sin(angle_rad), z], axis=1)


def annealed(samples: FloatArray, count: int, seed: int = 0) -> FloatArray:
    """Directions (count, 3) that are near to samples (n, 3) of unit length, by simulated annealing.

    The energy is the mean of ``1 - cos`` of the angles between samples and their nearest direction. A move turns one direction;
    turns and temperature fall from move to move. Same samples, count and seed give the same set.
    """
    rng = np.random.default_rng(seed)
    directions = spiral(count)
    cosines = directions @ samples.T
    nearest, best = cosines.argmax(axis=0), cosines.max(axis=0)
    moves = TURNS * count
    reach = 2 / np.sqrt(count)  # about the distance of neighbours
    for move in range(moves):
        left = 1 - move / moves
        k = int(rng.integers(count))
        turned = _unit(directions[k] + reach * left * rng.normal(size=3))
        column = samples @ turned
        # What was nearest to the direction that moves looks for its next one.
        mine = np.nonzero(nearest == k)[0]
        after = np.maximum(best, column)
        without = cosines[:, mine]
        without[k] = column[mine]
        after[mine] = without.max(axis=0)
        gain = float((after - best).sum())
        heat = 0.002 * left * left * reach * reach * len(samples) / count
        if gain < 0 and rng.random() >= np.exp(max(gain / max(heat, 1e-300), -700.0)):
            continue
        directions[k], cosines[k] = turned, column
        moved = column >= after
        nearest[mine] = without.argmax(axis=0)
        nearest[moved], best = k, after
    return directions


def volume_normals(volume: Volume, channels: tuple[int, ...], time: int, seed: int = 0) -> FloatArray:
    """Normals (n, 3) of random voxels of channels, by central differences, n at most ``SAMPLES`` of each channel.

    Steep places count more: voxels are chosen by the magnitude of their gradient. Without any gradient they are even.
    """
    rng = np.random.default_rng(seed)
    found = [_steep_normals(volume, volume.grid(channel, time), rng) for channel in channels]
    normals = np.concatenate(found)
    return normals if len(normals) else spiral(SAMPLES)


def _steep_normals(volume: Volume, grid: AnyArray, rng: np.random.Generator) -> FloatArray:
    places = rng.integers(0, grid.shape, size=(TRIED_VOXELS, 3))
    slopes = np.zeros((TRIED_VOXELS, 3))
    there = np.ones(TRIED_VOXELS, dtype=bool)
    for axis in range(3):
        ends = []
        for step in (-1, 1):
            z, y, x = np.clip(places + step * (np.arange(3) == axis), 0, np.array(grid.shape) - 1).T
            ends.append(grid[z, y, x])
            empty = is_empty(ends[-1], volume.no_data)
            there &= ~empty if empty is not None else True
        with np.errstate(invalid="ignore"):
            slopes[:, 2 - axis] = ends[1].astype(np.float64) - ends[0].astype(np.float64)
    gradients = slopes[there] @ volume.index_from_world[:3, :3]
    steepness = np.linalg.norm(gradients, axis=1)
    gradients, steepness = gradients[steepness > 0], steepness[steepness > 0]
    if not len(gradients):
        return np.empty((0, 3))
    chosen = rng.choice(len(gradients), size=SAMPLES, p=steepness / steepness.sum())
    return np.asarray(-gradients[chosen] / steepness[chosen, None])


def angles_to(directions: FloatArray, normals: FloatArray) -> FloatArray:
    """Angles (n,) in degrees between normals (n, 3) and the nearest of the directions."""
    return np.asarray(np.degrees(np.arccos(np.clip((normals @ directions.T).max(axis=1), -1, 1))))


def as_texels(directions: FloatArray) -> npt.NDArray[np.float32]:
    """Texels ``(1, 1, n, 4)`` of directions."""
    return np.pad(directions, ((0, 0), (0, 1))).astype(np.float32)[None, None]


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
