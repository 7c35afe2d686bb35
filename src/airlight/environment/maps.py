"""What light a surface gets from an environment: maps by direction and roughness, made once from its picture.

Glossy light is the mean of the environment under the lobe that the GGX distribution reflects when eye and normal lie on the
mirrored direction (Karis 2013, Real Shading in Unreal Engine 4: ``N = V = R``). At roughness 1 that lobe is the cosine:
the last map is the scattered light, irradiance over pi, and a white environment gives the albedo back. A lobe depends on one
angle alone: along a ring of directions the mean is a circular convolution, done by Fourier transform, with the exact sum over
all pixels between rings.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..keeping import Kept
from ..volume import FloatArray
from .sources import Source, picture_of
from .sphere import cubic_at, linear_at, mean_of, octahedral_directions, resized, row_areas

TEXELS = 257  # of a side
ROWS = 256  # of pixels that a lobe is summed over at most: those of the texels' size
LEAST_ROWS = 64
ROWS_PER_WIDTH = 8.0  # pixels that a lobe needs, over the inverse of its width
LEAST_WIDTH, LAYERS_PER_OCTAVE = 1 / 64, 2
WIDTHS = tuple(LEAST_WIDTH * 2 ** (k / LAYERS_PER_OCTAVE) for k in range(13))  # GGX alpha of the layers behind the mirror's
LAYERS = len(WIDTHS) + 1
REFLECTION_TEXELS, HEIGHT_NODES, TURN_NODES = 64, 64, 8


_KEPT: Kept[Source, npt.NDArray[np.float32]] = Kept(4)


def light_maps(source: Source, progress: Callable[[str, int, int], None] | None = None) -> npt.NDArray[np.float32]:
    """Return octahedral maps (layers, n, n, 4), float32: the mirror, then rougher and rougher lobes, see ``layer_of``.

    The same array for an equal environment. Texels are at ``octahedral_directions``; those of an edge are equal in pairs.
    ``progress`` is told of the layers while they are made, a second or so.
    """
    return _KEPT.get(source, lambda: _made(source, progress or (lambda _what, _done, _total: None)))


def _made(source: Source, progress: Callable[[str, int, int], None]) -> npt.NDArray[np.float32]:
    progress("environment", 0, LAYERS)
    directions = octahedral_directions(TEXELS)
    picture = np.asarray(picture_of(source), dtype=np.float64)
    maps = np.ones((LAYERS, TEXELS, TEXELS, 4), dtype=np.float32)
    sharp = resized(picture, *(min(n, most) for n, most in zip(picture.shape[:2], (ROWS, 2 * ROWS), strict=True)))
    maps[0, ..., :3] = linear_at(sharp, directions)
    by_rows = [int(np.clip(ROWS_PER_WIDTH / alpha, LEAST_ROWS, ROWS)) for alpha in WIDTHS]

    def fill(rows: int) -> int:
        """Lobes that ask for equally fine pixels share them, and the way from rings to texels; return how many they are."""
        layers = [layer for layer, asked in enumerate(by_rows, start=1) if asked == rows]
        seen = resized(picture, rows, 2 * rows)
        rings = np.concatenate([means_on_rings(seen, WIDTHS[layer - 1]) for layer in layers], axis=-1)
        found = cubic_at(rings, directions).reshape(TEXELS, TEXELS, len(layers), 3)
        maps[layers, ..., :3] = np.maximum(np.moveaxis(found, 2, 0), 0.0)
        return len(layers)

    done = 1
    with ThreadPoolExecutor() as pool:
        for filled in as_completed([pool.submit(fill, rows) for rows in sorted(set(by_rows), reverse=True)]):
            done += filled.result()
            progress("environment", done, LAYERS)
    maps.setflags(write=False)
    return maps


@lru_cache(maxsize=4)
def mean_radiance(source: Source) -> tuple[float, float, float]:
    """Mean radiance of an environment over all directions."""
    r, g, b = (float(c) for c in mean_of(np.asarray(picture_of(source), dtype=np.float64)))
    return r, g, b


def layer_of(roughness: float) -> float:
    """Place of a roughness among the layers: evenly by the logarithm of GGX alpha, its square, and straight to the mirror."""
    alpha = roughness * roughness
    if alpha <= LEAST_WIDTH:
        return alpha / LEAST_WIDTH
    return 1 + LAYERS_PER_OCTAVE * math.log2(alpha / LEAST_WIDTH)


def lobe(cosine: FloatArray, alpha: float) -> FloatArray:
    """Weight of light at an angle from the lobe's axis, not normalised: GGX at the half vector, times the cosine."""
    # The squared cosine of the half vector is (1 + cosine) / 2.
    return np.asarray(np.maximum(cosine, 0.0) / (1 - (1 - alpha**2) * (1 + cosine) / 2) ** 2)


def means_on_rings(picture: FloatArray, alpha: float) -> FloatArray:
    """Means (h + 1, w, 3) under a lobe round directions on rings from pole to pole, in the columns of the picture (h, w, 3)."""
    height, width = picture.shape[:2]
    half = np.arange(width // 2 + 1)
    around = np.cos(2 * np.pi * half / width)
    polar = np.pi * (np.arange(height) + 0.5) / height
    areas = row_areas(height, width)
    transform = np.fft.rfft(np.moveaxis(picture, 2, 0), axis=2) * areas[:, None]
    # Real and imaginary parts lie apart, row by row: what follows are products of real numbers along memory.
    waves = np.ascontiguousarray(np.concatenate([transform.real, transform.imag]))
    rings = np.empty((height + 1, width, 3))
    for ring in range(height // 2 + 1):
        at = np.pi * ring / height
        cosine = np.cos(at) * np.cos(polar)[:, None] + np.sin(at) * np.sin(polar)[:, None] * around
        # An even row is its own mirror image: its transform is real, and made of half of it.
        weights = np.fft.hfft(lobe(cosine, alpha), width, axis=1)[:, : len(half)]
        total = (weights[:, 0] * areas).sum()
        for place, seen in ((ring, waves), (height - ring, waves[:, ::-1])):
            parts = np.einsum("sm,csm->cm", weights, seen)
            rings[place] = np.fft.irfft(parts[:3] + 1j * parts[3:], width).T / total
    return rings


@lru_cache(maxsize=1)
def reflection_table() -> npt.NDArray[np.float32]:
    """Return what a white environment sends to the eye by reflection alone: (1, n, n, 4), float32.

    Columns are cosines between normal and eye, rows roughnesses, both from 0 to 1; the shares ``(a, b, 0, 0)`` make the
    albedo ``f0 a + f90 b`` under Schlick's Fresnel factor, with Smith's height-correlated shadowing.
    """
    n = REFLECTION_TEXELS
    cosines, roughness = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    n_v, alpha2 = np.maximum(cosines, 1e-4), np.maximum(roughness**2, 1e-4) ** 2
    table = np.zeros((1, n, n, 4))
    eye_aside, eye_root = np.sqrt(1 - n_v**2), np.sqrt(n_v**2 * (1 - alpha2) + alpha2)
    # Half vectors in proportion to GGX; either side of the eye is like the other.
    for u, weight in _nodes(HEIGHT_NODES):
        h_z = np.sqrt((1 - u) / (1 + (alpha2 - 1) * u))
        aside = eye_aside * np.sqrt(1 - h_z**2)
        # They turn about the normal as far as what they reflect stays above the surface.
        widest = np.arccos(np.clip(n_v * (0.5 / h_z - h_z) / np.maximum(aside, 1e-12), -1.0, 1.0))
        for turn, turn_weight in _nodes(TURN_NODES):
            v_h = aside * np.cos(widest * turn) + n_v * h_z
            n_l = np.maximum(2 * v_h * h_z - n_v, 0.0)
            smith = n_l * eye_root + n_v * np.sqrt(n_l**2 * (1 - alpha2) + alpha2)
            share = 2 * n_l * v_h / (h_z * smith) * (weight * turn_weight / np.pi) * widest
            grazing = (1 - np.clip(v_h, 0.0, 1.0)) ** 5
            table[0, ..., 0] += share * (1 - grazing)
            table[0, ..., 1] += share * grazing
    kept = table.astype(np.float32)
    kept.setflags(write=False)
    return kept


def _nodes(count: int) -> list[tuple[float, float]]:
    """Nodes of Gauss' rule on [0, 1] with their weights."""
    places, weights = np.polynomial.legendre.leggauss(count)
    return [(float(place + 1) / 2, float(weight) / 2) for place, weight in zip(places, weights, strict=True)]
