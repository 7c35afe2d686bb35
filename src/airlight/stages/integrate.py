"""What becomes of the slabs along a ray."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..errors import ValueRangeError
from ..stage import F32, Bool, Conditions, Context, Mat3f, Resource, Stage, Table, Vec3f, param, register, static, value
from ..transfer.joint import JointFunction
from .field import needed_groups
from .hit_colours import COLOUR_BY, UNUSED_COLOURS, check_colours, colour_table, hit_colour_uniforms, is_by_curvature
from .transfer import Transfer, on_one_of


class Integrate(Stage):
    """Base of the integrate stages.

    ``uses_slabs`` tells whether colour is lit at all; ``classifies`` whether ``take`` looks at colour and opacity of slabs;
    ``uses_values`` whether it looks at values; ``skips_empty`` whether empty slabs leave the result as it is, ``surfaces_only``
    whether all slabs without a surface do; ``colours_samples`` whether ``medium`` is asked about samples of the field, not
    about numbers made of several, which lie nowhere; ``takes_covers`` whether semi-transparent meshes are taken in between, as
    slabs without length; ``thinned`` by what all extinctions are multiplied before slabs are classified; ``fills`` whether a
    ray that meets samples shows something even where nothing is; ``extreme`` which end of a range of values, "greatest" or
    "least", tells whether they may matter: the device half has ``settled``.
    """

    slot: ClassVar[str] = "integrate"
    uses_slabs: ClassVar[bool] = False
    classifies: ClassVar[bool] = False
    uses_values: ClassVar[bool] = True
    skips_empty: ClassVar[bool] = False
    surfaces_only: ClassVar[bool] = False
    colours_samples: ClassVar[bool] = True
    takes_covers: ClassVar[bool] = False
    thinned: ClassVar[float] = 1.0
    fills: ClassVar[bool] = False
    extreme: ClassVar[str] = "none"

    @property
    def uses_gradient(self) -> bool:
        """Whether the look's gradient stage is asked beside light."""
        return False

    def idle(self, transfer: Stage, context: Context) -> Conditions | None:
        """Return the conditions under which the field leaves the result as it is; None where no values tell."""
        return transfer.empty_where(context) if self.skips_empty and isinstance(transfer, Transfer) else None


@register
@dataclass(frozen=True)
class EmissionAbsorption(Integrate):
    """Front-to-back compositing of emitted and scattered light under absorption.

    Depth is where opacity passes one half.
    """

    name: ClassVar[str] = "emission_absorption"
    wgsl: ClassVar[str] = "integrate/emission_absorption.wgsl"
    uses_slabs: ClassVar[bool] = True
    classifies: ClassVar[bool] = True
    uses_values: ClassVar[bool] = False
    skips_empty: ClassVar[bool] = True
    takes_covers: ClassVar[bool] = True
    opaque_at: F32 = param(0.99995, above=0, up_to=1, help="opacity at which a ray ends")
    fills_rest: Bool = param(
        False, help="whether all that lies behind the end of a ray is taken to look as what lies before it: for quick pictures"
    )

    def converging(self) -> EmissionAbsorption:
        """Return the stage whose rays end where nothing is left to be seen."""
        return replace(self, opaque_at=1.0, fills_rest=False)


@register
@dataclass(frozen=True)
class Mip(Integrate):
    """Maximum intensity projection: the greatest value along the ray, in the function's colour. Depth is where it lies."""

    name: ClassVar[str] = "mip"
    wgsl: ClassVar[str] = "integrate/mip.wgsl"
    extreme: ClassVar[str] = "greatest"


@register
@dataclass(frozen=True)
class MinIp(Integrate):
    """Minimum intensity projection: the least value along the ray, in the function's colour. Depth is where it lies."""

    name: ClassVar[str] = "minip"
    wgsl: ClassVar[str] = "integrate/minip.wgsl"
    extreme: ClassVar[str] = "least"


@register
@dataclass(frozen=True)
class Mean(Integrate):
    """The mean value along the ray's way through the domain, in the function's colour. It has no depth."""

    name: ClassVar[str] = "mean"
    wgsl: ClassVar[str] = "integrate/mean.wgsl"
    colours_samples: ClassVar[bool] = False


@dataclass(frozen=True, eq=False)
class FirstHitUniforms:
    """First hit with the iso-value resolved, the colours of the function's surface there, and numbers shown as colours.

    Distances are told in index coordinates, since those of the device's world are shifted. A normal of zero is none.
    """

    iso: F32 = param(0.0, unit="data")
    coloured: Bool = param(False)
    front_rgb: Vec3f = param((1.0, 1.0, 1.0))
    back_rgb: Vec3f = param((1.0, 1.0, 1.0))
    low: F32 = param(0.0)
    per_number: F32 = param(1.0)
    from_eye: Bool = param(False)
    point_index: Vec3f = param((0.0, 0.0, 0.0), unit="voxel")
    normal: Vec3f = param((0.0, 0.0, 0.0))
    world_from_index: Mat3f = param(None, unit="world/voxel")


@register
@dataclass(frozen=True)
class FirstHit(Integrate):
    """The front surface at the value ``iso``: opaque, lit, in the function's colour there. Depth is the hit.

    Without ``iso`` it is the value at which the transfer function reaches half of its greatest extinction. ``side`` tells what
    is solid (the alpha tests of Westermann and Ertl 1998): values of at least ``iso``, of at most ``iso``, or neither: a thin
    sheet that is met from both sides. Where the function has a ``Surface`` at this very value, the sheet has its colours.

    ``colour_by`` shows a number as a colour of the map ``colours`` from ``low`` to ``high`` instead: a curvature of the surface
    in 1/world (Gaussian: 1/world^2), positive where it is round like a ball of high values, by the look's gradients on all
    sides of the hit (Kindlmann et al. 2003); or a distance, from the eye, from a ``point``, or from the plane through the
    point that is perpendicular to ``normal``. Cut faces keep the function's colour.
    """

    name: ClassVar[str] = "first_hit"
    wgsl: ClassVar[str] = "integrate/first_hit.wgsl"
    surfaces_only: ClassVar[bool] = True
    uniform_type: ClassVar[type] = FirstHitUniforms
    uses_slabs: ClassVar[bool] = True
    iso: F32 | None = param(None, unit="data", help="value of the surface")
    side: str = static("above", choices=("above", "below", "both"), help="which values are solid; both: a sheet with two sides")
    colour_by: str = static("function", choices=COLOUR_BY, help="what of the surface is shown as a colour")
    colours: str = value("viridis", help="colour map of what is shown")
    low: F32 | None = param(None, unit="1/world, world", help="number of the first colour; None: by the volume")
    high: F32 | None = param(None, unit="1/world, world", help="number of the last colour; None: by the volume")
    point: Vec3f | None = param(None, unit="world", help="distances are those from here; None: from the eye")
    normal: Vec3f | None = param(None, help="distances are those from a plane, positive on this side of it")

    def __post_init__(self) -> None:
        """Check the numbers and the colour map."""
        super().__post_init__()
        if self.normal is not None and not np.any(self.normal):
            raise ValueRangeError("integrate.first_hit.normal", f"is {self.normal}, must have a length")
        if self.colour_by != "function":
            check_colours(self.colours, "integrate.first_hit.colours")

    @property
    def uses_gradient(self) -> bool:
        """Whether the look's gradient stage is asked, lit or not."""
        return is_by_curvature(self.colour_by)

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the colour map."""
        return {"colours": Table(UNUSED_COLOURS if self.colour_by == "function" else colour_table(self.colours))}

    def uniforms(self, context: Context) -> FirstHitUniforms:
        """Return the iso-value, and how numbers become colours.

        Raises
        ------
        ValueRangeError
            When it is left to a function of several variables, or of surfaces alone, which has none.
        """
        if self.iso is None and isinstance(context.transfer, JointFunction):
            what = "is left to the function, which is one of several variables"
            raise ValueRangeError("look.integrate.first_hit.iso", what, "give it: FirstHit(iso=...)")
        if self.iso is None and context.transfer.surfaces and not context.transfer.extinctions.any():
            value = context.transfer.surfaces[0].value
            what = "is left to the function, which has surfaces alone"
            raise ValueRangeError("look.integrate.first_hit.iso", what, f"give it: FirstHit(iso={value:g})")
        iso = context.transfer.half_extinction_value if self.iso is None else self.iso
        sheet = next((s for s in getattr(context.transfer, "surfaces", ()) if s.value == iso), None)
        if self.side == "below":
            iso = float(np.nextafter(np.float32(iso), np.float32(np.inf)))  # a sample on the very value is solid here, too
        shown = hit_colour_uniforms(self, context)
        if sheet is None:
            return FirstHitUniforms(iso, **shown)
        return FirstHitUniforms(iso, True, sheet.front[0], sheet.back[0], **shown)

    def idle(self, transfer: Stage, context: Context) -> Conditions | None:
        """Return what lies before the surface, and behind it where that is not solid."""
        iso = np.float32(self.uniforms(context).iso)
        before, behind = (-math.inf, float(np.nextafter(iso, np.float32(-np.inf)))), (float(iso), math.inf)
        stretches = {"above": (before,), "below": (behind,), "both": (before, behind)}[self.side]
        return on_one_of(stretches, 4 * needed_groups(context)[0])


from .projections import AttenuatedMip, DepthShadedMip, LocalMip, WeightedSum, XRay  # noqa: E402  (they are made of the above)

__all__ = [
    "AttenuatedMip",
    "DepthShadedMip",
    "EmissionAbsorption",
    "FirstHit",
    "Integrate",
    "LocalMip",
    "Mean",
    "MinIp",
    "Mip",
    "WeightedSum",
    "XRay",
]
