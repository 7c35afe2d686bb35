"""What the passes of a frame hand to each other: names stand for values of these types."""

from __future__ import annotations

from dataclasses import dataclass

PIXEL_BYTES = {"f32": 4, "i32": 4, "u32": 4, "vec2f": 8, "vec2i": 8, "vec2u": 8, "vec4f": 16, "vec4i": 16, "vec4u": 16}
"""Types of WGSL that pixels may have, and their bytes."""


@dataclass(frozen=True)
class PerPixel:
    """A number or a vector of a WGSL type for each pixel of the image."""

    wgsl: str = "vec4f"

    def __str__(self) -> str:
        return f"a {self.wgsl} for each pixel"


@dataclass(frozen=True)
class Rows:
    """A list of values of a WGSL type."""

    wgsl: str

    def __str__(self) -> str:
        return f"a list of {self.wgsl}"


@dataclass(frozen=True)
class Measured:
    """A number of the whole image."""

    def __str__(self) -> str:
        return "a number of the whole image"


@dataclass(frozen=True)
class Prepared:
    """Textures that stages of the frame look at."""

    def __str__(self) -> str:
        return "textures of stages"


Kind = PerPixel | Rows | Measured | Prepared

COLOUR = PerPixel("vec4f")
"""Of ``radiance``: premultiplied linear colour and opacity."""

DEPTH = PerPixel("vec2f")
"""Of ``depth``: distance from the eye in the world, ``package::ray::INFINITE`` where it is never reached, and samples."""

BACKDROP = PerPixel("f32")
"""Of ``backdrop``: the share of a pixel in which an environment is seen; without it opacity is that of layers and meshes."""

DOMAINS = Rows("mat4x4f")
"""Of ``domains``: from the unit cube to the domain of each visible layer, in the world of the device."""

SLICES = Rows("vec4f")
"""Of ``slices``: normal and first of the planes in the world of the device, the normal zero for shells; then their spacing,
and the number of shells before rays begin."""

NUMBER = Measured()
"""Of ``luminance``."""
