"""How a point answers to light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..stage import F32, Bool, Context, Stage, param, register
from .field_channels import scalar_range


class Shade(Stage):
    """Base of the shade stages.

    ``lit`` tells whether normals and lights are needed at all, ``asks_lights`` whether the scene's lights are; ``by_direction``
    whether nothing of a sample counts but its gradient, and its place for what lights send there.
    """

    slot: ClassVar[str] = "shade"
    lit: ClassVar[bool] = True
    asks_lights: ClassVar[bool] = True
    by_direction: ClassVar[bool] = False


@register
@dataclass(frozen=True)
class NoShade(Shade):
    """The transfer function's colour as it is: the medium glows."""

    name: ClassVar[str] = "none"
    wgsl: ClassVar[str] = "shade/none.wgsl"
    lit: ClassVar[bool] = False
    asks_lights: ClassVar[bool] = False


@dataclass(frozen=True)
class BlinnPhongUniforms:
    """Blinn-Phong with the gradient threshold resolved, as its inverse."""

    ambient: F32 = param(0.0)
    diffuse: F32 = param(0.0)
    specular: F32 = param(0.0)
    shininess: F32 = param(0.0)
    per_threshold: F32 = param(1e30, unit="world/data")
    two_sided: Bool = param(True)


@register
@dataclass(frozen=True)
class BlinnPhong(Shade):
    """Ambient, diffuse and specular light at the gradient, without the factor 1/pi; specular light is white.

    ``rgb * (ambient + sum_l L_l * diffuse * |n.l|) + sum_l L_l * specular * |n.h|^shininess``, weighted by opacity. Below
    ``gradient_threshold`` a normal means nothing and ambient light alone is left; up to twice of it light fades in. None takes
    1/2000 of the data's robust range (percentiles 0.5 to 99.5) per smallest voxel spacing.
    """

    name: ClassVar[str] = "blinn_phong"
    wgsl: ClassVar[str] = "shade/blinn_phong.wgsl"
    by_direction: ClassVar[bool] = True
    uniform_type: ClassVar[type] = BlinnPhongUniforms
    ambient: F32 = param(0.1, at_least=0, help="share of the colour that needs no light")
    diffuse: F32 = param(0.7, at_least=0, help="share of the colour that follows the angle to the light")
    specular: F32 = param(0.2, at_least=0, help="strength of the white highlight")
    shininess: F32 = param(20.0, unit="1", above=0, up_to=10_000, help="exponent: larger means a smaller highlight")
    gradient_threshold: F32 | None = param(
        None, unit="data/world", at_least=0, help="gradient below which only ambient light is left; in full from twice of it on"
    )
    two_sided: Bool = param(True, help="whether surfaces are lit from behind, too")

    def uniforms(self, context: Context) -> BlinnPhongUniforms:
        """Return the parameters with the automatic threshold resolved."""
        per = per_threshold(self, context)
        return BlinnPhongUniforms(self.ambient, self.diffuse, self.specular, self.shininess, per, self.two_sided)


@register
@dataclass(frozen=True)
class Phase(Shade):
    """Light scattered by particles: clouds, smoke, dust, tissue. Nothing depends on normals, and inner parts are lit, too.

    ``rgb * (ambient + sum_l L_l * strength * p)``, with Henyey and Greenstein's phase function ``p``, 1 where ``forward`` is 0.
    """

    name: ClassVar[str] = "phase"
    wgsl: ClassVar[str] = "shade/phase.wgsl"
    ambient: F32 = param(0.1, at_least=0, help="share of the colour that needs no light")
    strength: F32 = param(0.9, at_least=0, help="share of the colour that lights make")
    forward: F32 = param(
        0.0, at_least=-0.9, up_to=0.9, help="asymmetry: above 0 light goes on ahead, below 0 it comes back, at 0 all ways alike"
    )


def weakest_gradient(shade: Stage, context: Context) -> float:
    """Gradient [data/world] below which a shade stage takes nothing for a surface."""
    told = getattr(shade, "gradient_threshold", None)
    return automatic_threshold(context) if told is None else float(told)


def per_threshold(shade: Stage, context: Context) -> float:
    """Inverse of the weakest gradient of a shade stage, as large as devices hold."""
    threshold = weakest_gradient(shade, context)
    return min(1.0 / threshold, 1e36) if threshold > 0 else 1e36


def automatic_threshold(context: Context) -> float:
    """1/2000 of the robust range of what gradients are taken of per smallest spacing, in its units per world unit."""
    return 0.0005 * scalar_range(context, 0.5, 99.5) / min(context.volume.spacing)


from .environment import Environment as Environment  # noqa: E402  (it is made of the above)
