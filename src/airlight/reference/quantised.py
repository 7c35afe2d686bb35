"""Normals of voxels rounded to a few directions, each lit once; the light, not the normals, is interpolated.

Kreylos, "Fake" Phong illumination. The set of directions is data of the stage; what is done with it is told here.
"""

from __future__ import annotations

import numpy as np

from ..errors import StageError
from ..stage import Context
from ..volume import FloatArray
from .field import trilinear
from .gradient import voxel_gradients
from .setup import IntArray, Lit, Sample, Setup, Slab
from .shade import LIGHTINGS, SHADES, automatic_threshold


def quantised(setup: Setup, slab: Slab, to_eye: FloatArray) -> FloatArray:
    """Light both ends of slabs by what the directions of the eight voxels around send."""
    if len(to_eye) and np.abs(to_eye - to_eye[0]).max() > 1e-9:
        raise StageError("look.lighting 'quantised'", "lights each direction once, and rays differ", "use Camera.orthographic")
    if any(lamp.kind == "point" for lamp in setup.lights):
        raise StageError("look.lighting 'quantised'", "lights each direction once, and point lights are near", "use others")
    rgb, rows = slab.rgb.copy(), np.nonzero((slab.alpha > 0) | (slab.rgb > 0).any(axis=1))[0]
    if not len(rows):
        return rgb
    lit = _lit(setup, to_eye[:1])
    front_rgb, front_alpha = slab.rgb - slab.back_rgb, slab.alpha - slab.back_alpha
    total = np.zeros((len(rows), 3))
    for end, part_rgb, part_alpha in ((slab.front, front_rgb, front_alpha), (slab.back, slab.back_rgb, slab.back_alpha)):
        p_index = end.p_index[rows]
        total += part_rgb[rows] * trilinear(lit.diffuse, p_index) + part_alpha[rows, None] * trilinear(lit.specular, p_index)
    rgb[rows] = total
    return rgb


def _directions(setup: Setup) -> FloatArray:
    volume = setup.layer.volume
    context = Context(volume, setup.function, setup.channels, setup.layer.time, setup.spacing_world, (1, 1))
    table = setup.stages["lighting"].normals(context)
    return np.asarray(table.texels[0, 0, :, :3], dtype=np.float64)


def _lit(setup: Setup, to_eye: FloatArray) -> Lit:
    """Light of the voxels by their directions, seen from one side (1, 3): factors (z, y, x, 3)."""
    if "lit diffuse" not in setup.once:
        # A place without a direction, then each direction.
        steep = 1e6 * max(_threshold(setup), 1e-30)
        gradients = np.concatenate([np.zeros((1, 3)), -steep * _directions(setup)])
        zeros = np.zeros(len(gradients))
        here = Sample(zeros, zeros > 0, np.zeros_like(gradients), np.zeros_like(gradients), zeros)
        lit = SHADES[setup.stages["shade"].name](setup, here, gradients, np.broadcast_to(to_eye, gradients.shape))
        numbers = _numbers(setup)
        setup.once["lit diffuse"], setup.once["lit specular"] = lit.diffuse[numbers], lit.specular[numbers]
    return Lit(setup.once["lit diffuse"], setup.once["lit specular"])


def _numbers(setup: Setup) -> IntArray:
    """Numbers (z, y, x) of the directions nearest to the normals of the voxels, from 1; 0 where the gradient is too weak."""
    stage, directions = setup.stages["gradient"], _directions(setup)
    gradients = voxel_gradients(setup, getattr(stage, "method", stage.name))
    flat = gradients.reshape(-1, 3)
    parts = np.array_split(-flat, 1 + len(flat) // 16384)
    nearest = np.concatenate([(part @ directions.T).argmax(axis=1) for part in parts])
    weak = np.linalg.norm(flat, axis=1) <= _threshold(setup)
    return np.asarray(np.where(weak, 0, nearest + 1).reshape(gradients.shape[:3]))


def _threshold(setup: Setup) -> float:
    told = getattr(setup.stages["shade"], "gradient_threshold", None)
    return automatic_threshold(setup) if told is None else float(told)


LIGHTINGS["quantised"] = quantised
