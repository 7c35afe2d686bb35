"""What a ray meets: values, extinction, colour and opacity along it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import ValueRangeError
from .first_picture import resolve
from .inspecting import labels_at, layer_of, pieces, sample_at, setup_of, values_at
from .reference.clips import kept_along
from .reference.clips import pieces as clipped
from .reference.integrate import EmissionAbsorption
from .reference.march import span
from .reference.setup import Setup
from .scene import Scene, check_scene
from .stage import make_stage
from .transfer.given import check_size, listed
from .volume import FloatArray

THIN = 1e-6
"""Length of slabs, as a share of a voxel, that stand for a point."""


@dataclass(frozen=True, eq=False)
class RayProfile:
    """A ray through a layer, sampled where it enters, at whole steps, where clips cut it, and where it leaves; or empty.

    Attributes
    ----------
    t_world
        Distance (n,) along the ray, as in ``image.depth``.
    p_world
        Points (n, 3), x, y, z.
    value
        (n,) in data units, of several channels (n, c); NaN where the data are empty.
    extinction
        (n,) per world unit of length, of the transfer function and the regions, 0 where clips cut it away; without the
        modulation.
    source
        (n, 3), linear light that is emitted per world unit of length, before lights shine on it.
    opacity
        (n,), accumulated from the eye on by extinction, regions and modulation; 0 at the first sample.
    label
        (n,) labels of the voxels; None without labels.
    """

    t_world: FloatArray
    p_world: FloatArray
    value: FloatArray
    extinction: FloatArray
    source: FloatArray
    opacity: FloatArray
    label: npt.NDArray[np.int64] | None = None

    @property
    def rgb(self) -> FloatArray:
        """Linear colours (n, 3): light per extinction; 0 where there is no extinction."""
        dense = self.extinction[:, None] > 0
        return np.where(dense, self.source / np.where(dense, self.extinction[:, None], 1.0), 0.0)


def ray_profile(
    scene: Scene,
    size: tuple[int, int],
    p_px: tuple[float, float],
    *,
    layer: int = 0,
    step: float = 0.5,
) -> RayProfile:
    """Return what the ray of a point of an image meets, in float64.

    Computed without the device, on the voxels along the ray alone, by what defines what is right. Slabs between samples are
    classified as the look's transfer stage does. Meshes, solid faces of clips and other layers are not in it.

    Parameters
    ----------
    scene
        What the image shows.
    size
        Width and height of the image in pixels.
    p_px
        Point of the image in pixels from its upper left corner; the centre of the pixel (x, y) is (x + 0.5, y + 0.5).
    layer
        Number of the visible layer.
    step
        Distance between samples, in smallest voxel spacings of the layer.

    Raises
    ------
    ValueRangeError
        For sizes that are none, points beside the image, a step that is not above zero, and layers that are not there.
    StageError
        When only the device knows the camera's rays.

    Examples
    --------
    >>> import airlight as al
    >>> scene = al.first_picture(al.samples.load("hydrogen", size=32))
    >>> ray = al.ray_profile(scene, (64, 64), (32, 32))
    >>> ray.t_world.shape == ray.opacity.shape
    True
    """
    check_scene(scene, "pass the airlight.Scene that the image shows")
    if not (isinstance(step, (int, float)) and 1e-3 <= step <= 1e3):
        raise ValueRangeError("step", f"is {step!r}, must lie in [0.001, 1000] voxels")
    check_size(size)
    x, y = _place(p_px, size)
    scene = resolve(scene, size)
    chosen = layer_of(scene, layer)
    setup = setup_of(scene, chosen, size)
    origin, direction = scene.camera.ray((x, y), size)  # type: ignore[union-attr]
    t_world = _distances(setup, origin, direction, step)
    p_world = origin + t_world[:, None] * direction
    parts = [_piece(near, p_world[run], t_world[run]) for run, near in pieces(setup, p_world)] if len(t_world) else []
    if not parts:
        none = np.zeros(0)
        return RayProfile(t_world, p_world, none, none, np.zeros((0, 3)), none, labels_at(chosen, p_world))
    value, extinction, source, alpha = (_joined([part[n] for part in parts], shared=n < 3) for n in range(4))
    ray = setup.clips, origin[None], direction[None]
    drawn, slab_drawn = (kept_along(*ray, t[None])[0] for t in (t_world, (t_world[1:] + t_world[:-1]) / 2))
    opacity = 1 - np.concatenate([[1.0], np.cumprod(1 - alpha * slab_drawn)])
    return RayProfile(t_world, p_world, value, extinction * drawn, source * drawn[:, None], opacity, labels_at(chosen, p_world))


def _place(p_px: Any, size: tuple[int, int]) -> tuple[float, float]:
    parts = listed(p_px, "p_px", "give (x, y) in pixels")
    if len(parts) != 2 or not all(isinstance(p, (int, float, np.number)) and math.isfinite(p) for p in parts):
        raise ValueRangeError("p_px", f"is {p_px!r}, must be two numbers")
    if not all(0 <= p <= n for p, n in zip(parts, size, strict=True)):
        raise ValueRangeError("p_px", f"is {p_px!r}, must lie in the image of {size[0]} x {size[1]}")
    return float(parts[0]), float(parts[1])


def _distances(setup: Setup, origin: FloatArray, direction: FloatArray, step: float) -> FloatArray:
    """Distances at which the ray is sampled; none where it misses the domain."""
    (enter,), (leave,) = span(setup, origin[None], direction[None])
    if leave <= enter:
        return np.zeros(0)
    h = step * setup.spacing_world
    lattice = h * np.arange(math.floor(enter / h) + 1, math.ceil(leave / h))
    ends = np.array([enter]), np.array([leave])
    cuts = [(cut.begin, cut.end) for cut in clipped(setup.clips, origin[None], direction[None], *ends)]
    return np.unique(np.concatenate([*ends, lattice, *(t for cut in cuts for t in cut)]))


def _piece(setup: Setup, p_world: FloatArray, t_world: FloatArray) -> tuple[FloatArray, ...]:
    """Values, extinction and source at points (n, 3), and opacities (n - 1,) of the slabs between them."""
    here = sample_at(setup, p_world, t_world)
    front, back = here[np.arange(len(t_world) - 1)], here[np.arange(1, len(t_world))]
    # As in pictures: half of a slab with one empty end is there, with the sample of the other.
    length = np.diff(t_world) * np.where(front.empty | back.empty, 0.5, 1.0)
    sent = EmissionAbsorption(setup).classify(front.where_empty_take(back), back.where_empty_take(front), length)
    alpha = np.where(front.empty & back.empty, 0.0, sent.alpha)
    plain = dataclasses.replace(setup, stages={**setup.stages, "modulation": make_stage("modulation", "none")})
    thin = np.full(len(t_world), THIN * setup.spacing_world)
    point = EmissionAbsorption(plain).classify(here, here, thin)
    there = ~here.empty
    with np.errstate(under="ignore", divide="ignore"):
        extinction = np.where(there, -np.log1p(-point.alpha) / thin, 0.0)
        # What a slab of one medium sends is its source times the share of its length that is seen.
        seen = np.where(point.alpha > 0, point.alpha / np.where(extinction > 0, extinction, 1.0), thin)
        source = np.where(there[:, None], point.rgb / seen[:, None], 0.0)
    return values_at(setup, p_world), extinction, source, alpha


def _joined(parts: list[FloatArray], shared: bool) -> FloatArray:
    """Arrays of runs one behind the other; ``shared`` ones begin with what the run before ends with."""
    return np.concatenate([parts[0], *(part[1:] if shared else part for part in parts[1:])])
