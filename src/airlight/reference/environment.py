"""Environments: means of the picture under lobes by summing over its pixels, and what is seen of it behind a scene.

``environment`` is a function of the slot shade, ``seen`` what lies behind the layers.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..environment import Environment
from ..environment.sources import Source
from ..volume import FloatArray
from .setup import Lit, Sample, Setup
from .shade import SHADES, automatic_threshold, surfaceness, visibility

GRAZING = 0.2
ROWS_PER_WIDTH = 8
LEAST_ROWS = 64
NUMBERS_AT_ONCE = 1 << 17  # that fit into a cache


@np.errstate(under="ignore")
def environment(setup: Setup, sample: Sample, gradient: FloatArray, to_eye: FloatArray) -> Lit:
    """Scattered and reflected light of the environment; its mean where the gradient is too weak to mean a surface."""
    stage = setup.stages["shade"]
    threshold = automatic_threshold(setup) if stage.gradient_threshold is None else stage.gradient_threshold
    steepness = np.linalg.norm(gradient, axis=1)
    surface = surfaceness(steepness, threshold)[:, None]
    normal = -gradient / np.where(steepness > 0, steepness, 1.0)[:, None]
    n_v = (normal * to_eye).sum(axis=1, keepdims=True)
    # The side that the eye sees; near grazing angles its normal leans over to the eye.
    seen_share = np.minimum(np.abs(n_v) / GRAZING, 1.0)
    facing = seen_share * np.sign(n_v) * normal + (1 - seen_share) * to_eye
    facing = facing / np.linalg.norm(facing, axis=1, keepdims=True) if stage.two_sided else normal
    alpha = stage.roughness**2
    rows = np.nonzero(surface[:, 0] > 0)[0]
    scattered, glossy = np.zeros_like(normal), np.zeros_like(normal)
    scattered[rows] = radiance(stage.environment, facing[rows], 1.0)
    glossy[rows] = radiance(stage.environment, (2 * n_v * normal - to_eye)[rows], alpha)
    coat = surface * np.interp(np.abs(n_v), COSINES, _reflected(setup, alpha, stage.reflectance))
    sent = (1 - stage.metallic) * scattered + stage.metallic * glossy
    below = (1 - surface) * mean(stage.environment) + surface * sent
    arrives = stage.intensity * visibility(setup, None, sample.p_world)
    return Lit(arrives * stage.diffuse * (1 - coat) * below, arrives * coat * glossy)


@lru_cache(maxsize=4)
def _pixels(source: Source) -> FloatArray:
    return np.asarray(source.picture(), dtype=np.float64)


@lru_cache(maxsize=4)
def _lights(source: Source, rows: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions (n, 3), solid angles (n,) and colours (n, 3) of the pixels of a picture of so many rows."""
    to_light, areas = directions_and_areas(rows, 2 * rows)
    return to_light.reshape(-1, 3), areas.ravel(), _of_rows(_pixels(source), rows).reshape(-1, 3)


@lru_cache(maxsize=4)
def mean(surroundings: Environment) -> FloatArray:
    """Mean (3,) over all directions, computed once."""
    pixels = _pixels(surroundings.source)
    _, areas = directions_and_areas(*pixels.shape[:2])
    return np.asarray(np.einsum("hwc,hw->c", pixels, areas) / (4 * np.pi))


def seen(surroundings: Environment, direction: FloatArray) -> FloatArray:
    """Picture (n, 3) of an environment in world directions (n, 3), bilinear."""
    return _bilinear(_pixels(surroundings.source), direction @ surroundings.environment_from_world.T)


def radiance(surroundings: Environment, direction: FloatArray, alpha: float) -> FloatArray:
    """Mean (n, 3) under the lobe of GGX of a width whose eye and normal are a world direction (n, 3); the picture for 0."""
    if alpha == 0:
        return seen(surroundings, direction)
    rows = min(256, max(LEAST_ROWS, 2 ** round(np.log2(ROWS_PER_WIDTH / alpha))))
    to_light, areas, pixels = _lights(surroundings.source, rows)
    axis = direction @ surroundings.environment_from_world.T
    found = np.empty_like(axis)
    at_once = max(1, NUMBERS_AT_ONCE // len(areas))
    for first in range(0, len(axis), at_once):
        n_l = axis[first : first + at_once] @ to_light.T
        # GGX at the half vector, whose squared cosine is (1 + n_l) / 2; without the factors that all have.
        weight = np.maximum(n_l, 0) * areas / (1 - (1 - alpha**2) / 2 * (1 + n_l)) ** 2
        found[first : first + at_once] = weight @ pixels / weight.sum(axis=1, keepdims=True)
    return found


COSINES = np.linspace(0, 1, 257)


def _reflected(setup: Setup, alpha: float, reflectance: float) -> FloatArray:
    """Share of a white environment that a coat reflects, at ``COSINES``, computed once."""
    key = f"reflected {alpha!r} {reflectance!r}"
    if key not in setup.once:
        setup.once[key] = np.minimum(coat_albedo(COSINES, alpha, reflectance), 1.0)
    return setup.once[key]


def coat_albedo(n_v: FloatArray, alpha: float, reflectance: float, nodes: int = 64) -> FloatArray:
    """Albedo (n,) of GGX with Smith's correlated masking and Schlick's Fresnel factor, seen at cosines (n,).

    Over half vectors in proportion to what is seen of them: their squared tangent is ``alpha^2 u / (1 - u)``.
    """
    points, weights = np.polynomial.legendre.leggauss(nodes)
    u, around = np.meshgrid((points + 1) / 2, np.pi * (points + 1) / 2)
    weight = np.outer(weights, weights) / 4
    n_v = np.maximum(n_v, 1e-4)[:, None, None]
    tangent_squared = max(alpha, 1e-4) ** 2 * u / (1 - u)
    n_h = 1 / np.sqrt(1 + tangent_squared)
    v_h = np.sqrt(1 - n_v**2) * np.sqrt(tangent_squared) * n_h * np.cos(around) + n_v * n_h
    n_l = 2 * v_h * n_h - n_v
    reaches = (n_l > 0) & (v_h > 0)
    n_l, v_h = np.where(reaches, n_l, 1.0), np.where(reaches, v_h, 1.0)
    masking = 1 / (1 + _smith(n_v, alpha) + _smith(n_l, alpha))
    f90 = min(50 * reflectance, 1.0)
    fresnel = reflectance + (f90 - reflectance) * (1 - np.minimum(v_h, 1)) ** 5
    return np.asarray((np.where(reaches, fresnel * masking * v_h / (n_h * n_v), 0.0) * weight).sum(axis=(1, 2)))


def _smith(cosine: FloatArray, alpha: float) -> FloatArray:
    """Smith's Lambda of GGX."""
    return np.asarray((np.sqrt(1 + alpha**2 * np.maximum(1 / np.minimum(cosine, 1.0) ** 2 - 1, 0.0)) - 1) / 2)


def directions_and_areas(rows: int, columns: int) -> tuple[FloatArray, FloatArray]:
    """Directions (h, w, 3) and solid angles (h, w) of the pixels: zenith first, +y in the middle, +x to the right of it."""
    polar = (np.arange(rows) + 0.5) * np.pi / rows
    azimuth = ((np.arange(columns) + 0.5) / columns - 0.5) * 2 * np.pi
    theta, phi = np.meshgrid(polar, azimuth, indexing="ij")
    direction = np.stack([np.sin(theta) * np.sin(phi), np.sin(theta) * np.cos(phi), np.cos(theta)], axis=-1)
    half = np.pi / (2 * rows)
    return direction, (np.cos(theta - half) - np.cos(theta + half)) * 2 * np.pi / columns


def _of_rows(pixels: FloatArray, rows: int) -> FloatArray:
    """Picture of so many rows: means of whole blocks of pixels where it has more, else what lies between them."""
    height, width = pixels.shape[:2]
    if height == rows:
        return pixels
    if height < rows:
        return _bilinear(pixels, directions_and_areas(rows, 2 * rows)[0].reshape(-1, 3)).reshape(rows, 2 * rows, 3)
    if height % rows:
        # Blocks of whole pixels of a picture that is finer by a whole factor.
        return _of_rows(_of_rows(pixels, rows * -(-height // rows)), rows)
    _, areas = directions_and_areas(height, width)
    shape = (rows, height // rows, 2 * rows, width // (2 * rows))
    sums = (pixels * areas[..., None]).reshape(*shape, 3).sum(axis=(1, 3))
    return np.asarray(sums / areas.reshape(shape).sum(axis=(1, 3))[..., None])


def _bilinear(pixels: FloatArray, direction: FloatArray) -> FloatArray:
    """Picture (n, 3) at directions (n, 3) of its own space."""
    height, width = pixels.shape[:2]
    x = (np.arctan2(direction[:, 0], direction[:, 1]) / (2 * np.pi) + 0.5) * width - 0.5
    y = np.clip(np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2]) / np.pi * height - 0.5, 0, height - 1)
    left, top = np.floor(x), np.floor(y)
    found = np.zeros_like(direction)
    for down in (0, 1):
        for right in (0, 1):
            weight = np.abs(1 - right - (x - left)) * np.abs(1 - down - (y - top))
            row, column = np.minimum(top + down, height - 1), (left + right) % width
            found += weight[:, None] * pixels[row.astype(np.int64), column.astype(np.int64)]
    return found


SHADES["environment"] = environment
