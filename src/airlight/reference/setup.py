"""What the stages of the reference see: a layer made ready, samples along rays, slabs, light.

Functions of the reference let float64 underflow, ``np.errstate(under="ignore")``: light too faint for it is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..clips import Clip
from ..scene import Layer, Light
from ..volume import FloatArray, is_empty

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Setup:
    """One layer with its effective stages by slot, its function scaled by its density, and the lights."""

    layer: Layer
    function: Any
    stages: Mapping[str, Any]
    lights: tuple[Light, ...] = ()
    camera: Any = None
    size_px: tuple[int, int] = (1, 1)
    clips: tuple[Clip, ...] = ()
    least_spacing_world: float | None = None  # of all layers of a scene, where there are several
    beside: tuple[Setup, ...] = ()  # other layers, which hide light, too
    once: dict[str, FloatArray] = field(default_factory=dict)  # what a stage computes once for the volume, by its name

    @cached_property
    def channels(self) -> tuple[int, ...]:
        """Numbers of the channels that the function looks at."""
        return self.layer.channels

    @cached_property
    def grid(self) -> FloatArray:
        """Samples ``(z, y, x)``, of several channels ``(z, y, x, c)``, in data units; 0 where empty."""
        samples = self._stacked([self.layer.volume.grid(c, self.layer.time) for c in self.channels]).astype(np.float64)
        return samples if self.full is None else np.where(self.full > 0, samples, 0.0)

    @cached_property
    def full(self) -> FloatArray | None:
        """1 where a sample is not empty, 0 where it is, in the shape of ``grid``; None when no sample is empty."""
        volume = self.layer.volume
        grids = [volume.grid(c, self.layer.time) for c in self.channels]
        masks = [is_empty(grid, volume.no_data) for grid in grids]
        if all(mask is None for mask in masks):
            return None
        return 1.0 - self._stacked([np.zeros(grids[0].shape) if mask is None else mask.astype(np.float64) for mask in masks])

    @staticmethod
    def _stacked(grids: list[npt.NDArray[Any]]) -> npt.NDArray[Any]:
        return grids[0] if len(grids) == 1 else np.stack(grids, axis=-1)

    @cached_property
    def domain(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest index coordinates of the field: voxel centres, or cells where they are asked for or n is 1."""
        n = np.array(self.layer.volume.size, dtype=np.float64)
        cells = (n == 1) | bool(getattr(self.stages["field"], "cells", False))
        return np.where(cells, -0.5, 0.0), np.where(cells, n - 0.5, n - 1.0)

    @cached_property
    def spacing_world(self) -> float:
        """Smallest voxel spacing."""
        return float(np.linalg.norm(self.layer.volume.world_from_index[:3, :3], axis=0).min())

    @property
    def finest_world(self) -> float:
        """Smallest voxel spacing of all layers, in which steps count."""
        return self.spacing_world if self.least_spacing_world is None else self.least_spacing_world

    def index_of(self, p_world: FloatArray) -> FloatArray:
        """Index coordinates of world points (n, 3)."""
        matrix = self.layer.volume.index_from_world
        return np.asarray(p_world @ matrix[:3, :3].T + matrix[:3, 3])


@dataclass(frozen=True, eq=False)
class Sample:
    """Samples of the field, one a ray: ``value`` (n,), ``empty`` (n,), points (n, 3), ``t_world`` (n,).

    Of several channels ``value`` is (n, c), NaN where a channel is empty; ``empty`` are samples in which all are.
    """

    value: FloatArray
    empty: BoolArray
    p_index: FloatArray
    p_world: FloatArray
    t_world: FloatArray

    def __getitem__(self, rows: BoolArray | IntArray) -> Sample:
        return Sample(self.value[rows], self.empty[rows], self.p_index[rows], self.p_world[rows], self.t_world[rows])

    def towards(self, other: Sample, share: FloatArray) -> Sample:
        """Return the points at shares (n,) of the way to ``other``, with values in between."""

        def mix(name: str) -> FloatArray:
            mine, theirs = getattr(self, name), getattr(other, name)
            w = share.reshape(-1, *[1] * (mine.ndim - 1))
            return np.asarray((1 - w) * mine + w * theirs)

        return Sample(mix("value"), self.empty & other.empty, mix("p_index"), mix("p_world"), mix("t_world"))

    def where_empty_take(self, other: Sample) -> Sample:
        """Return the samples with the empty ones replaced by those of ``other``."""

        def pick(mine: Any, theirs: Any) -> Any:
            return np.where(self.empty if mine.ndim == 1 else self.empty[:, None], theirs, mine)

        return Sample(*(pick(getattr(self, f.name), getattr(other, f.name)) for f in fields(self)))


@dataclass(frozen=True, eq=False)
class Sent:
    """What slabs send to the eye: associated ``rgb`` (n, 3), opacity ``alpha`` (n,), and the parts of both from the back.

    Light from a share x of the length counts as x from the back and 1 - x from the front (Lum, Wilson and Ma, section 3).
    """

    rgb: FloatArray
    alpha: FloatArray
    back_rgb: FloatArray
    back_alpha: FloatArray


@dataclass(frozen=True, eq=False)
class Slab(Sent):
    """Pieces of rays between two samples, and what they send to the eye."""

    front: Sample
    back: Sample
    length: FloatArray

    def __getitem__(self, rows: BoolArray | IntArray) -> Slab:
        return Slab(*(getattr(self, field.name)[rows] for field in fields(self)))


def dark(n: int) -> Sent:
    """Return what slabs send that hold nothing."""
    return Sent(np.zeros((n, 3)), np.zeros(n), np.zeros((n, 3)), np.zeros(n))


def made_slab(light: Sent, front: Sample, back: Sample, length: FloatArray) -> Slab:
    """Return slabs between two samples that send this light."""
    return Slab(light.rgb, light.alpha, light.back_rgb, light.back_alpha, front, back, length)


@dataclass(frozen=True, eq=False)
class Lit:
    """Factors (n, 3) of the medium's colour, ``diffuse``, and of white weighted by opacity, ``specular``."""

    diffuse: FloatArray
    specular: FloatArray
