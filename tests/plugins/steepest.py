"""A stage from outside of the package: one dataclass, its WGSL, and its reference. For the tests of plugins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

import airlight as al
from airlight import reference
from airlight.reference.integrate import Integrate
from airlight.stage import F32


@al.register
@dataclass(frozen=True)
class Steepest(al.Stage):
    """The steepest rise of the value between two samples, as a grey."""

    slot: ClassVar[str] = "integrate"
    name: ClassVar[str] = "steepest"
    wgsl: ClassVar[str] = """
import generated::steepest::params;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};

struct Accumulated { rise: f32, t_world: f32 }

fn begin() -> Accumulated { return Accumulated(0.0, INFINITE); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  let rise = abs(back.value - front.value) / max(length, 1e-6);
  if (length > params.shortest && rise > (*acc).rise) { (*acc) = Accumulated(rise, front.t_world); }
  return false;
}

fn finish(acc: Accumulated) -> Result {
  return Result(vec3f(acc.rise / params.full), select(0.0, 1.0, acc.t_world < INFINITE), acc.t_world);
}
"""
    full: F32 = al.param(20.0, unit="data/world", above=0, help="rise that is shown as white")
    shortest: F32 = al.param(0.5, unit="world", at_least=0, help="slabs that are shorter are left out")


class SteepestReference(Integrate):
    """The same in float64."""

    def take(self, acc, rays, slab):
        rise = np.abs(slab.back.value - slab.front.value) / np.maximum(slab.length, 1e-6)
        better = (slab.length > self.stage.shortest) & (rise > acc.value[rays])
        acc.value[rays[better]] = rise[better]
        acc.t_world[rays[better]] = slab.front.t_world[better]
        return np.zeros(len(rays), dtype=bool)

    def finish(self, acc):
        acc.rgb[:] = (acc.value / self.stage.full)[:, None]
        acc.alpha[:] = np.isfinite(acc.t_world)
        return acc


reference.register("integrate", "steepest", SteepestReference)
