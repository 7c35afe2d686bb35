"""A shade stage of one's own: edges glow, faces that look at the eye stay dark. You should see tubes of a flow as outlines."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

import airlight as al
from airlight import reference
from airlight.reference.setup import Lit
from airlight.stage import F32, param


@al.register
@dataclass(frozen=True)
class Rim(al.shade.Shade):
    """Light where the surface turns away from the eye."""

    name: ClassVar[str] = "rim"
    power: F32 = param(2.0, above=0, up_to=100, help="larger means thinner edges")
    wgsl: ClassVar[str] = """
import generated::rim::params;
import package::sample::{Sample, Lit};

fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit {
  return Lit(vec3f(pow(1.0 - abs(dot(normal, to_eye)), params.power)), vec3f(0.0));
}
"""


def rim(setup, sample, gradient, to_eye):
    normal = -gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-30)
    facing = np.abs((normal * to_eye).sum(axis=1, keepdims=True))
    return Lit(np.maximum(1 - facing, 0) ** setup.stages["shade"].power * np.ones(3), np.zeros_like(to_eye))


reference.register("shade", "rim", rim)

if __name__ == "__main__":
    al.render(al.Scene(al.samples.load("vortex"), look=al.Look(shade=Rim()), camera="iso")).save("rim.png")
