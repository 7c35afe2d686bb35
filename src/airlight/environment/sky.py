"""Daylight: the sky of Preetham, Shirley and Smits 1999 (A Practical Analytic Model for Daylight, appendix A), sun and ground.

Brightness is scaled so that a white surface that faces the zenith is white: intensities of environments mean the same.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..volume import FloatArray
from .sphere import averaged, pixel_directions, row_areas

SUN_RADIUS_RAD = math.radians(1.5)  # six times the true one, which no map of moderate size holds
SUN_EDGE_RAD = math.radians(0.4)
WAVELENGTHS_UM = np.array([0.61, 0.55, 0.465])

# Factors of turbidity and 1, for the five coefficients of Perez' formula: luminance Y, chromaticities x and y.
PEREZ = np.array(
    [
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
    ]
)
# Chromaticities at the zenith: factors of turbidity squared, turbidity, 1 by those of the sun's angle cubed, squared, angle, 1.
ZENITH_X = np.array(
    [[0.00166, -0.00375, 0.00209, 0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]
)
ZENITH_Y = np.array(
    [[0.00265, -0.00610, 0.00317, 0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]
)
RGB_FROM_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


def picture(
    to_sun: tuple[float, float, float], turbidity: float, sun: float, ground: tuple[float, float, float], rows: int
) -> npt.NDArray[np.float32]:
    """Radiance, float32 (rows, 2 rows, 3).

    Parameters
    ----------
    to_sun
        World direction towards the sun, of length one, at or above the horizon.
    turbidity
        Haze: 2 is very clear, 10 hazy.
    sun
        Irradiance of the sun on a surface that faces it, over that of the sky on level ground.
    ground
        Linear albedo of the ground, lit by sky and sun.
    rows
        Rows of the picture.
    """
    pixels = averaged(lambda directions: sky_radiance(directions, np.array(to_sun), turbidity), rows, 1)
    disc = averaged(lambda directions: _sun_disc(directions, np.array(to_sun)), rows)
    areas = row_areas(rows, 2 * rows)[:, None, None]
    up = np.maximum(pixel_directions(rows, 2 * rows)[..., 2:], 0.0)
    of_sky = (pixels * up * areas).sum(axis=(0, 1))
    luminance = of_sky @ np.array([0.2126, 0.7152, 0.0722])
    if sun > 0:
        pixels = pixels + disc * (sun * luminance * sun_colour(to_sun[2], turbidity) / (disc * areas).sum())
    level = (pixels * up * areas).sum(axis=(0, 1)) / np.pi
    pixels = pixels + averaged(lambda directions: (directions[..., 2:] < 0) * (np.array(ground) * level), rows, 1)
    return np.asarray(pixels / (level @ np.array([0.2126, 0.7152, 0.0722])), dtype=np.float32)


def sky_radiance(directions: FloatArray, to_sun: FloatArray, turbidity: float) -> FloatArray:
    """Linear RGB (..., 3) of the sky without the sun, in kcd/m2 of luminance; 0 below the horizon."""
    sun_angle = math.acos(min(1.0, float(to_sun[2])))
    cosine = np.maximum(directions[..., 2], 0.01)
    gamma = np.arccos(np.clip(directions @ to_sun, -1.0, 1.0))
    chi = (4 / 9 - turbidity / 120) * (math.pi - 2 * sun_angle)
    powers = np.array([sun_angle**3, sun_angle**2, sun_angle, 1.0])
    haze = np.array([turbidity**2, turbidity, 1.0])
    zenith = (
        (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192,
        float(haze @ ZENITH_X @ powers),
        float(haze @ ZENITH_Y @ powers),
    )
    bright, x, y = (
        top * _perez(cosine, gamma, c) / _perez(np.array(1.0), np.array(sun_angle), c)
        for top, c in zip(zenith, PEREZ @ np.array([turbidity, 1.0]), strict=True)
    )
    xyz = np.stack([x * bright / y, bright, (1 - x - y) * bright / y], axis=-1)
    return np.asarray(np.maximum(xyz @ RGB_FROM_XYZ.T, 0.0) * (directions[..., 2:] >= 0))


def _perez(cosine: FloatArray, gamma: FloatArray, c: FloatArray) -> FloatArray:
    return np.asarray((1 + c[0] * np.exp(c[1] / cosine)) * (1 + c[2] * np.exp(c[3] * gamma) + c[4] * np.cos(gamma) ** 2))


def _sun_disc(directions: FloatArray, to_sun: FloatArray) -> FloatArray:
    """1 in the sun, falling to 0 over its edge, (..., 1)."""
    angle = np.arccos(np.clip(directions @ to_sun, -1.0, 1.0))
    disc = np.clip((SUN_RADIUS_RAD + SUN_EDGE_RAD / 2 - angle) / SUN_EDGE_RAD, 0.0, 1.0) * (directions[..., 2] >= 0)
    return np.asarray(disc[..., None])


def sun_colour(height: float, turbidity: float) -> FloatArray:
    """Linear RGB (3,) of luminance 1 of the sun at a cosine from the zenith: what air and haze let through (appendix A.1)."""
    angle_deg = math.degrees(math.acos(min(1.0, height)))
    air_mass = 1 / (height + 0.15 * (93.885 - angle_deg) ** -1.253)
    rayleigh = 0.008735 * WAVELENGTHS_UM**-4.08
    aerosol = (0.04608 * turbidity - 0.04586) * WAVELENGTHS_UM**-1.3
    rgb = np.exp(-air_mass * (rayleigh + aerosol))
    return np.asarray(rgb / (rgb @ np.array([0.2126, 0.7152, 0.0722])))
