"""Environments as light and as background: the host half."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..environment import Environment as Surroundings
from ..environment.background import background_picture
from ..environment.maps import LAYERS, layer_of, light_maps, mean_radiance, reflection_table
from ..errors import StageError
from ..stage import F32, Bool, Context, Estimate, Mat3f, Resource, Stage, Table, Vec3f, param, register, value
from .shade import Shade, per_threshold


@dataclass(frozen=True, eq=False)
class EnvironmentUniforms:
    """Environment light with the layer of its roughness and the gradient threshold resolved, the latter as its inverse."""

    environment_from_world: Mat3f = param(None)
    mean: Vec3f = param((1.0, 1.0, 1.0), unit="radiance")
    layer: F32 = param(0.0)
    roughness: F32 = param(0.0)
    diffuse: F32 = param(1.0)
    metallic: F32 = param(0.0)
    reflectance: F32 = param(0.0)
    intensity: F32 = param(1.0)
    per_threshold: F32 = param(1e30, unit="world/data")
    two_sided: Bool = param(True)


@register
@dataclass(frozen=True)
class Environment(Shade):
    """Light from all directions: scattered in the medium's colour, reflected as by a coat of this roughness.

    A coat reflects the share ``A`` of a white environment (Schlick's Fresnel factor, GGX, Smith); what it lets through is
    scattered, or reflected in the medium's colour by the share ``metallic``: ``rgb * diffuse * (1 - A) * mix(scattered, glossy,
    metallic) + A * glossy``. No light is lost or made: a white environment gives white back for white, and without reflectance
    the albedo. Lights of the scene are not asked.
    """

    name: ClassVar[str] = "environment"
    wgsl: ClassVar[str] = "shade/environment.wgsl"
    asks_lights: ClassVar[bool] = False
    uniform_type: ClassVar[type] = EnvironmentUniforms
    environment: Surroundings = value(Surroundings.studio(), help="where light comes from")
    roughness: F32 = param(0.35, at_least=0, up_to=1, help="from a mirror to a dull coat")
    diffuse: F32 = param(1.0, at_least=0, help="factor of the light in the medium's colour")
    reflectance: F32 = param(0.04, at_least=0, up_to=1, help="share that is reflected where one looks straight at a surface")
    metallic: F32 = param(0.0, at_least=0, up_to=1, help="share of the colour that is reflected instead of scattered")
    intensity: F32 = param(1.0, at_least=0, help="factor of all light")
    gradient_threshold: F32 | None = param(
        None, unit="data/world", at_least=0, help="gradient below which the mean light is left; in full from twice of it on"
    )
    two_sided: Bool = param(True, help="whether the side that the eye sees is lit, wherever the gradient points")

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        _check(self.environment, "look.shade.environment")

    def uniforms(self, context: Context) -> EnvironmentUniforms:
        """Return the parameters with layer, mean and threshold resolved."""
        return EnvironmentUniforms(
            environment_from_world=self.environment.environment_from_world,
            mean=mean_radiance(self.environment.source),
            layer=layer_of(self.roughness),
            roughness=self.roughness,
            diffuse=self.diffuse,
            metallic=self.metallic,
            reflectance=self.reflectance,
            intensity=self.intensity,
            per_threshold=per_threshold(self, context),
            two_sided=self.two_sided,
        )

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the maps of the environment, and what is reflected of a white one."""
        return {"maps": Table(light_maps(self.environment.source, context.progress)), "reflection": Table(reflection_table())}

    def errors(self, context: Context) -> dict[str, Estimate]:
        """Return what lies between this roughness and the maps next to it: an eighth of how radiance bends over them."""
        return {} if layer_of(self.roughness).is_integer() else {"glossy radiance between roughnesses": self._bend}

    def _bend(self) -> float:
        layer = layer_of(self.roughness)
        middle = int(np.clip(round(layer), 1, LAYERS - 2))
        maps = light_maps(self.environment.source)[middle - 1 : middle + 2, ..., :3].astype(np.float64)
        return float(np.abs(maps[0] - 2 * maps[1] + maps[2]).max()) / 8


@dataclass(frozen=True, eq=False)
class BackgroundUniforms:
    """The way to the picture's directions."""

    environment_from_world: Mat3f = param(None)


@register
@dataclass(frozen=True)
class Background(Stage):
    """The environment, as it is seen from the eye: it lies at infinity."""

    slot: ClassVar[str] = "background"
    name: ClassVar[str] = "environment"
    wgsl: ClassVar[str] = "background/environment.wgsl"
    uniform_type: ClassVar[type] = BackgroundUniforms
    environment: Surroundings = value(Surroundings.studio(), help="what is seen")

    def __post_init__(self) -> None:
        """Check the environment."""
        super().__post_init__()
        _check(self.environment, "scene.background")

    def uniforms(self, context: Context) -> BackgroundUniforms:
        """Return how the environment is turned."""
        return BackgroundUniforms(self.environment.environment_from_world)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the picture."""
        return {"picture": Table(background_picture(self.environment.source))}


def _check(environment: object, where: str) -> None:
    if not isinstance(environment, Surroundings):
        raise StageError(where, f"is a {type(environment).__name__}", "pass an airlight.Environment, e.g. Environment.studio()")
