"""What the ray of a place of the view meets: value, extinction and opacity along it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ...annotations.scale_bar import unit_text
from ...profiles import ray_profile
from ...transfer.given import share
from ..asking import answers
from .probe import layer_numbered, mean_distance, shown

if TYPE_CHECKING:
    from ..session import Session

STEP = 0.5
MOST_SAMPLES = 2048


@answers("profile")
def profile(session: Session, x: float, y: float, layer: int = 0) -> tuple[dict[str, Any], list[bytes]]:
    """The profile of a layer along a ray of the picture that is shown.

    Parameters
    ----------
    session
        Whose picture.
    x, y
        Place of the view, in parts of its width and height.
    layer
        Number of the layer in the scene; one that is not shown has no profile.

    Returns
    -------
    dict, list
        Number of samples, channels and units; ``t_mean``, the mean distance of what is seen, weighted by opacity, or None. The
        buffer holds float32 rows: distance, extinction, opacity, then the values of each channel, NaN where they are empty.
    """
    image, scene = shown(session)
    chosen = layer_numbered(session, layer)
    units = {"units": unit_text(chosen.volume.units), "value_unit": chosen.volume.value_unit}
    visible = [number for number, other in enumerate(scene.layers) if other.visible]
    if layer not in visible:
        return {"count": 0, "channels": 0, "t_mean": None} | units, [b""]
    width, height = image.size
    at = share(x, "profile.x") * width, share(y, "profile.y") * height
    # Long rays are told at fewer places: a plot has not that many columns.
    step = max(STEP, sum(chosen.volume.size) / MOST_SAMPLES)
    ray = ray_profile(scene, image.size, at, layer=visible.index(layer), step=step)
    mean = mean_distance(ray)
    values = ray.value.reshape(len(ray.t_world), -1).T
    rows = np.concatenate([[ray.t_world, ray.extinction, ray.opacity], values]).astype("<f4")
    origin, direction = scene.camera.ray(at, image.size)  # type: ignore[union-attr]
    way = {"origin": origin.tolist(), "direction": direction.tolist()}
    return {"count": len(ray.t_world), "channels": len(values), "t_mean": None if math.isnan(mean) else mean} | units | way, [
        rows.tobytes()
    ]
