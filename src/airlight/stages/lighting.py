"""Where within a slab light is evaluated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError, ValueRangeError
from ..keeping import Kept
from ..stage import (
    F32,
    U32,
    Context,
    DirectionGrid,
    LitDirections,
    Resource,
    Stage,
    Table,
    param,
    register,
    static,
)
from ..volume import FloatArray
from .directions import DODECAHEDRON, angles_to, annealed, as_texels, dodecahedron, spiral, volume_normals
from .field_channels import scalar_range

KEPT_NORMALS = 8  # sets of a volume


class Lighting(Stage):
    """Base of the lighting stages.

    ``lights_ends`` tells whether they keep how samples are lit, from the back of a slab to the front of the next.
    """

    slot: ClassVar[str] = "lighting"
    lights_ends: ClassVar[bool] = False

    @property
    def splits_slabs(self) -> bool:
        """Whether the transfer stage had better know which part of a slab's light comes from each of its ends."""
        return False


@register
@dataclass(frozen=True)
class Unlit(Lighting):
    """Nowhere: the slab keeps its own colour."""

    name: ClassVar[str] = "unlit"
    wgsl: ClassVar[str] = "lighting/unlit.wgsl"


@register
@dataclass(frozen=True)
class Sampled(Lighting):
    """At one place of the slab: where its light comes from on the mean, as the transfer stage's table tells.

    The middle of the slab is up to half a step away from there, which shows as bands; the front, where the classic forms of
    pre-integration take their one sample, up to a whole step. Both are here to be compared with.
    """

    name: ClassVar[str] = "sampled"
    wgsl: ClassVar[str] = "lighting/sampled.wgsl"
    at: str = static("light", choices=("light", "middle", "front"), help="the place: the slab's light, middle or front")

    @property
    def splits_slabs(self) -> bool:
        """Whether the place follows from the slab's light."""
        return self.at == "light"


@register
@dataclass(frozen=True)
class Supersampled(Lighting):
    """At two places of the slab, the nodes of Gauss' rule: smoother where normals turn within a slab, at twice the price.

    Lum, Wilson and Ma, section 2.1, after Roettger et al. 2003.
    """

    name: ClassVar[str] = "supersampled"
    wgsl: ClassVar[str] = "lighting/supersampled.wgsl"


@register
@dataclass(frozen=True)
class Averaged(Lighting):
    """Once, by the mean of the gradients at the slab's two ends (Engel and Ertl, section 7): one gradient a sample."""

    name: ClassVar[str] = "averaged"
    wgsl: ClassVar[str] = "lighting/averaged.wgsl"
    lights_ends: ClassVar[bool] = True


@register
@dataclass(frozen=True)
class Interpolated(Lighting):
    """At both ends, each with its part of the slab's colour: light that runs on from slab to slab, without bands.

    Lum, Wilson and Ma, section 3. One evaluation of light a sample. The parts come from the transfer stage's table.
    """

    name: ClassVar[str] = "interpolated"
    wgsl: ClassVar[str] = "lighting/interpolated.wgsl"
    lights_ends: ClassVar[bool] = True

    @property
    def splits_slabs(self) -> bool:
        """Whether each end is lit with its own part: it is."""
        return True


@dataclass(frozen=True)
class QuantisedUniforms:
    """A gradient steep enough to mean a surface."""

    steep: F32 = param(1.0, unit="data/world")


@register
@dataclass(frozen=True)
class Quantised(Lighting):
    """By normals of the voxels rounded to a few directions, each lit once a frame; what they send is interpolated.

    Kreylos, "Fake" Phong illumination. One byte a voxel (two beyond 255 directions), and nothing but look-ups in the march,
    whatever the number of lights. It holds where all points see lights and eye in the same directions: orthographic views,
    directional and head lights, no occlusion. ``dodecahedron`` has 240 directions; a ``spiral`` any number, evenly spread;
    ``annealed`` ones are fitted to the volume's gradients, of a random choice that ``seed`` starts.
    """

    name: ClassVar[str] = "quantised"
    wgsl: ClassVar[str] = "lighting/quantised.wgsl"
    uniform_type: ClassVar[type | None] = QuantisedUniforms
    lights_ends: ClassVar[bool] = True
    directions: str = static("dodecahedron", choices=("dodecahedron", "spiral", "annealed"), help="set of normals")
    count: U32 = param(240, at_least=4, up_to=2047, help="number of normals")
    seed: U32 = param(0, help="start of the random choices of annealed ones")

    def __post_init__(self) -> None:
        """Check the parameters; only annealed directions are a matter of chance."""
        super().__post_init__()
        if self.seed and self.directions != "annealed":
            what = f"is {self.seed}, and nothing is random about {self.directions!r}"
            raise ValueRangeError("lighting.quantised.seed", what, 'use directions="annealed", or leave it out')

    @property
    def splits_slabs(self) -> bool:
        """Whether each end is lit with its own part: it is."""
        return True

    def uniforms(self, context: Context) -> QuantisedUniforms:
        """Return a gradient far above any threshold of the data's own size."""
        return QuantisedUniforms(1e4 * max(scalar_range(context, "minimum", "maximum") / min(context.volume.spacing), 1e-30))

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the numbers of the voxels' directions, and how these are lit."""
        normals = self.normals(context)
        return {"numbers": DirectionGrid(normals), "lit": LitDirections(normals)}

    def normals(self, context: Context) -> Table:
        """Return the set of normals, ``(1, 1, count, 4)``; the same table for the same volume.

        Raises
        ------
        StageError
            When the dodecahedron is asked for another number of directions than it has.
        """
        if self.directions == "dodecahedron" and self.count != DODECAHEDRON:
            found = f"is {self.count}, and the dodecahedron gives {DODECAHEDRON}"
            raise StageError("look.lighting.quantised.count", found, 'use directions="spiral" or "annealed" for other numbers')
        known: Kept[Any, Table] = context.volume.__dict__.setdefault("_normals", Kept(KEPT_NORMALS))
        return known.get((self, context.channels, context.time), lambda: Table(as_texels(self._vectors(context))))

    def errors(self, context: Context) -> dict[str, float]:
        """Return angles of the volume's normals to the nearest direction, the mean square's root and the greatest of some."""
        table = self.normals(context)

        def make() -> dict[str, float]:
            others = volume_normals(context.volume, context.channels, context.time, self.seed + 1)
            angles_deg = angles_to(table.texels[0, 0, :, :3].astype(np.float64), others)
            rms, most = float(np.sqrt((angles_deg**2).mean())), float(angles_deg.max())
            return {"angle rms [degree]": rms, "angle max [degree]": most}

        known: Kept[Any, dict[str, float]] = context.volume.__dict__.setdefault("_normal_errors", Kept(KEPT_NORMALS))
        return known.get((self, context.channels, context.time), make)

    def check(self, camera: Stage, shade: Stage, visibility: Stage, lights: Iterable[str]) -> None:
        """Check that light depends on nothing but the direction of a normal; ``lights`` are kinds of lights.

        Raises
        ------
        StageError
            Names what depends on a place, and what to use.
        """
        where, else_ = "look.lighting 'quantised'", 'or lighting="interpolated"'
        if camera.name != "orthographic":
            raise StageError(
                where,
                f"lights each direction once, and a {camera.name} view differs from pixel to pixel",
                f"use Camera.orthographic, {else_}",
            )
        if "point" in lights:
            raise StageError(
                where,
                "lights each direction once, and a point light comes from elsewhere at each place",
                f"use directional or head lights, {else_}",
            )
        if visibility.name != "none":
            raise StageError(
                where,
                f"lights each direction once, and visibility {visibility.name!r} differs from place to place",
                f'use visibility="none", {else_}',
            )
        if not getattr(shade, "by_direction", False):
            raise StageError(
                where,
                f"lights each direction once, and shade {shade.name!r} looks at more than normals",
                f'use shade="blinn_phong", {else_}',
            )

    def _vectors(self, context: Context) -> FloatArray:
        if self.directions == "dodecahedron":
            return dodecahedron()
        if self.directions == "spiral":
            return spiral(self.count)
        return annealed(volume_normals(context.volume, context.channels, context.time, self.seed), self.count, self.seed)
