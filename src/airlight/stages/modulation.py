"""By what the extinction of a slab is multiplied, beside its transfer function: where the data change, more is seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..errors import StageError
from ..stage import F32, Context, Stage, param, register
from ..transfer import Channels
from .field_channels import scalar_range

SHARE_OF_RANGE = 0.1
FULL_AT = "change from which on extinction counts in full; a tenth of the data's range a voxel unless told"


class Modulation(Stage):
    """Base of the modulations.

    Attributes
    ----------
    uses_gradient, uses_values
        Whether the weight asks for gradients, and for values of samples.
    """

    slot: ClassVar[str] = "modulation"
    uses_gradient: ClassVar[bool] = False
    uses_values: ClassVar[bool] = False


@register
@dataclass(frozen=True)
class NoModulation(Modulation):
    """Nothing: extinction is that of the function alone."""

    name: ClassVar[str] = "none"
    wgsl: ClassVar[str] = "modulation/none.wgsl"


@dataclass(frozen=True)
class ModulationUniforms:
    """The change that counts in full, resolved."""

    full_at: F32 = param(1.0, unit="data/world")


class ByChange(Modulation):
    """Base of those whose weight rises with a change of the data, up to one."""

    uniform_type: ClassVar[type | None] = ModulationUniforms
    full_at: float | None

    def uniforms(self, context: Context) -> ModulationUniforms:
        """Return the change that counts in full."""
        if isinstance(context.transfer, Channels) and self.uses_values:
            found = "looks at one value along the ray, and a mixture has several"
            raise StageError(f"look.modulation {self.name!r}", found, "use gradient_magnitude, or draw one channel")
        if self.full_at is not None:
            return ModulationUniforms(self.full_at)
        rise = scalar_range(context, "minimum", "maximum")
        return ModulationUniforms(SHARE_OF_RANGE * rise / min(context.volume.spacing) if rise > 0 else 1.0)


@register
@dataclass(frozen=True)
class Change(ByChange):
    """By how much the value changes along the ray, per world unit: what is met head-on shows, whatever the step.

    Engel and Ertl, section 8.2 and figure 40 (left), there by the distance from a table's diagonal, which depends on the step.
    It asks for no gradient, and depends on the view: surfaces that are seen edge-on fade.
    """

    name: ClassVar[str] = "change"
    wgsl: ClassVar[str] = "modulation/change.wgsl"
    uses_values: ClassVar[bool] = True
    full_at: F32 | None = param(None, unit="data/world", above=0, help=FULL_AT)


@register
@dataclass(frozen=True)
class GradientMagnitude(ByChange):
    """By the magnitude of the gradient in the middle of the slab: boundaries show, homogeneous regions fade."""

    name: ClassVar[str] = "gradient_magnitude"
    wgsl: ClassVar[str] = "modulation/gradient_magnitude.wgsl"
    uses_gradient: ClassVar[bool] = True
    full_at: F32 | None = param(None, unit="data/world", above=0, help=FULL_AT)
