"""Computed samples: fields with a formula, so that every error of reconstruction shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..volume import Volume

FloatArray = npt.NDArray[np.float64]


def marschner_lobb(size: int = 41, frequency: float = 6.0, amplitude: float = 0.25) -> Volume:
    """Test signal of Marschner and Lobb (1994) on [-1, 1]^3: rings whose frequency lies just below what 41 samples hold."""
    x, y, z, spacing = _grid(size, 1.0)
    rings = np.cos(2 * np.pi * frequency * np.cos(np.pi * np.hypot(x, y) / 2))
    values = (1 - np.sin(np.pi * z / 2) + amplitude * (1 + rings)) / (2 * (1 + amplitude))
    return _volume("marschner-lobb", values, spacing, 1.0)


def hydrogen(size: int = 96) -> Volume:
    """Wave function of the hydrogen atom in the state 4d (n = 4, l = 2, m = 0), in atomic units; it has both signs."""
    reach = 36.0
    x, y, z, spacing = _grid(size, reach)
    r_squared = x * x + y * y + z * z
    rho = np.sqrt(r_squared) / 2
    # rho^2 (3 cos^2 - 1) is written as (3 z^2 - r^2) / 4, which needs no division at the centre
    radial = np.sqrt(1 / 46080) * (6 - rho) * np.exp(-rho / 2)
    angular = np.sqrt(5 / (16 * np.pi)) * (3 * z * z - r_squared) / 4
    return _volume("hydrogen", radial * angular, spacing, reach, units="bohr", value_unit="bohr^-3/2")


def vortex(size: int = 96) -> Volume:
    """Speed of the flow of Arnold, Beltrami and Childress (A^2 = 3, B^2 = 2, C^2 = 1) over one period: tubes that cross."""
    x, y, z, spacing = _grid(size, np.pi)
    a, b, c = np.sqrt(3.0), np.sqrt(2.0), 1.0
    u = a * np.sin(z) + c * np.cos(y)
    v = b * np.sin(x) + a * np.cos(z)
    w = c * np.sin(y) + b * np.cos(x)
    return _volume("vortex", np.sqrt(u * u + v * v + w * w), spacing, np.pi)


def _grid(size: int, reach: float) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    if not 2 <= size <= 1024:
        raise DataError("size", f"is {size}, must lie in 2 to 1024")
    axis = np.linspace(-reach, reach, size)
    return axis[None, None, :], axis[None, :, None], axis[:, None, None], 2 * reach / (size - 1)


def _volume(
    name: str,
    values: FloatArray,
    spacing: float,
    reach: float,
    *,
    units: str = "",
    value_unit: str = "",
    channel_names: tuple[str, ...] = (),
) -> Volume:
    return Volume(
        values.astype(np.float32),
        spacing=(spacing, spacing, spacing),
        origin=(-reach, -reach, -reach),
        units=units,
        value_unit=value_unit,
        channel_names=channel_names,
        modality="simulation",
        name=name,
    )


@dataclass(frozen=True)
class Computed:
    """A formula, and the samples along each axis that it is computed with unless told."""

    title: str
    compute: Callable[[int], Volume]
    size: int


COMPUTED: dict[str, Computed] = {
    "marschner-lobb": Computed("the test signal of Marschner and Lobb, hard to reconstruct", marschner_lobb, 41),
    "hydrogen": Computed("an orbital (4d) of the hydrogen atom, with both signs", hydrogen, 96),
    "vortex": Computed("speed of a flow whose vortex tubes cross", vortex, 96),
}
