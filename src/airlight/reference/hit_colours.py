"""Colours of surfaces by how they bend, and by how far away they are."""

from __future__ import annotations

import numpy as np

from ..stage import Context
from ..stages.hit_colours import colour_range
from ..transfer import TransferFunction
from ..volume import FloatArray
from .gradient import field_gradient
from .setup import Sample, Setup

APART = 0.5  # of the gradients whose differences are the second derivatives, to each side [voxel]


def hit_colour(setup: Setup, hit: Sample) -> FloatArray:
    """Linear colours (n, 3) of hits by the number that the stage shows."""
    stage = setup.stages["integrate"]
    low, high = colour_range(
        stage,
        Context(setup.layer.volume, setup.function, setup.channels, 0, setup.spacing_world, setup.size_px, None, setup.camera),
    )
    share = np.clip((hit_number(setup, hit) - low) / (high - low), 0, 1)
    return np.asarray(TransferFunction.from_colormap(stage.colours, (0, 1))(share)[0])


def hit_number(setup: Setup, hit: Sample) -> FloatArray:
    """Curvature or distance (n,) of hits."""
    stage = setup.stages["integrate"]
    if stage.colour_by == "distance":
        if stage.point is None and stage.normal is None:
            return hit.t_world
        way = hit.p_world - np.array(stage.point or (0.0, 0.0, 0.0))
        if stage.normal is None:
            return np.asarray(np.linalg.norm(way, axis=1))
        return np.asarray(way @ np.array(stage.normal) / np.linalg.norm(stage.normal))
    greatest, least = curvatures(setup, hit.p_index)
    return {
        "mean_curvature": (greatest + least) / 2,
        "gaussian_curvature": greatest * least,
        "greatest_curvature": greatest,
        "least_curvature": least,
    }[stage.colour_by]


def curvatures(setup: Setup, p_index: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal curvatures (n,) of surfaces of equal value through points (n, 3), the greater first.

    The normal ``-g/|g|`` turns by ``-P H P / |g|`` along the surface, ``P`` the projection onto it (Kindlmann et al. 2003).
    """
    low, high = setup.domain
    gradient = field_gradient(setup, p_index)
    columns = []
    for axis in np.eye(3):
        near, far = np.maximum(p_index - APART * axis, low), np.minimum(p_index + APART * axis, high)
        way = np.maximum(np.linalg.norm(far - near, axis=1, keepdims=True), 1e-30)
        columns.append((field_gradient(setup, far) - field_gradient(setup, near)) / way)
    hessian = np.stack(columns, axis=-1) @ setup.layer.volume.index_from_world[:3, :3]
    hessian = (hessian + hessian.swapaxes(1, 2)) / 2
    steepness = np.linalg.norm(gradient, axis=1)
    steep = np.where(steepness > 0, steepness, 1.0)
    normal = gradient / steep[:, None]
    flat = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    bent = -flat @ hessian @ flat / steep[:, None, None]
    trace, squares = np.trace(bent, axis1=1, axis2=2), (bent * bent).sum(axis=(1, 2))
    apart = np.sqrt(np.maximum(2 * squares - trace * trace, 0))
    there = steepness > 0
    return np.where(there, (trace + apart) / 2, 0.0), np.where(there, (trace - apart) / 2, 0.0)
