"""Colours of surfaces by what they are like, instead of by their value: how they bend, and how far away they are."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from ..stage import Context
from ..transfer import TransferFunction
from .camera import Orthographic

if TYPE_CHECKING:
    from .integrate import FirstHit

COLOUR_BY = ("function", "mean_curvature", "gaussian_curvature", "greatest_curvature", "least_curvature", "distance")
ENTRIES = 1024
UNUSED_COLOURS = np.ones((1, 1, 1, 4), dtype=np.float32)
CURVATURE_VOXELS = 4.0
"""Radius, in voxels, of the ball whose curvature is the end of the colours unless told."""


def is_by_curvature(colour_by: str) -> bool:
    """Whether second derivatives are asked for."""
    return colour_by.endswith("curvature")


def check_colours(name: str, where: str) -> None:
    """Refuse an unknown colour map.

    Raises
    ------
    ValueRangeError
        With names that are close.
    """
    try:
        _map(name)
    except ValueRangeError as error:
        raise ValueRangeError(where, error.what, error.remedy) from None


@lru_cache(maxsize=16)
def _map(name: str) -> TransferFunction:
    return TransferFunction.from_colormap(name, (0, 1))


@lru_cache(maxsize=16)
def colour_table(name: str) -> npt.NDArray[np.float32]:
    """Texels (1, 1, 1024, 4) of a colour map, linear."""
    rgb, _ = _map(name)(np.linspace(0, 1, ENTRIES))
    return np.concatenate([rgb, np.ones((ENTRIES, 1))], axis=1).astype(np.float32)[None, None]


def colour_range(stage: FirstHit, context: Context) -> tuple[float, float]:
    """Numbers that have the first and the last colour: those of the stage, or what follows from the volume and the camera.

    Raises
    ------
    ValueRangeError
        When they do not rise.
    """
    low, high = _usual_range(stage, context)
    low, high = (low if stage.low is None else stage.low), (high if stage.high is None else stage.high)
    if not low < high:
        raise ValueRangeError("look.integrate.first_hit.low", f"is {low:g}, must be below high, {high:g}")
    return low, high


def _usual_range(stage: FirstHit, context: Context) -> tuple[float, float]:
    if is_by_curvature(stage.colour_by):
        most = 1 / (CURVATURE_VOXELS * min(context.volume.spacing))
        most = most * most if stage.colour_by == "gaussian_curvature" else most
        return -most, most
    corners = context.volume.corners_world()
    if stage.normal is not None:
        distances = (corners - np.array(stage.point or (0, 0, 0))) @ unit(stage.normal)
        return float(distances.min()), float(distances.max())
    middle, camera = corners.mean(axis=0), context.camera
    reach = float(np.linalg.norm(corners - middle, axis=1).max())
    way = middle - np.array(camera.eye if stage.point is None else stage.point)
    flat = stage.point is None and isinstance(camera, Orthographic)
    distance = float(way @ camera.basis()[2]) if flat else float(np.linalg.norm(way))
    return max(distance - reach, 0.0), distance + reach


def hit_colour_uniforms(stage: FirstHit, context: Context) -> dict[str, Any]:
    """Members of the stage's uniforms that tell how the numbers of hits become colours."""
    if stage.colour_by == "function":
        return {"world_from_index": np.eye(3)}
    low, high = colour_range(stage, context)
    volume = context.volume
    from_eye = stage.point is None and stage.normal is None
    point = volume.index_from_world @ (*(stage.point or (0, 0, 0)), 1.0)
    return {
        "low": low,
        "per_number": 1 / (high - low),
        "from_eye": from_eye,
        "point_index": tuple(point[:3]),
        "normal": (0.0, 0.0, 0.0) if stage.normal is None else tuple(unit(stage.normal)),
        "world_from_index": volume.world_from_index[:3, :3],
    }


def unit(vector: Any) -> npt.NDArray[np.float64]:
    """Vector of length one."""
    v = np.asarray(vector, dtype=np.float64)
    return v / np.linalg.norm(v)
