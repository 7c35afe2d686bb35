"""Passes over a finished picture, chosen by users: ``al.render(scene, passes=...)``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ..errors import StageError, ValueRangeError
from ..handed import BACKDROP, COLOUR, DEPTH, DOMAINS, NUMBER, PIXEL_BYTES, SLICES, Kind, PerPixel
from ..stage import F32, STAGES, Stage, Vec3f, make_stage, param, register
from ..transfer.given import listed, whole

__all__ = [
    "BACKDROP",
    "COLOUR",
    "DEPTH",
    "DOMAINS",
    "NUMBER",
    "SLICES",
    "BoundingBox",
    "Pass",
    "PerPixel",
    "SliceOutlines",
    "checked_passes",
]

OVER = ("scene", "display")
WHOLE_PX = 1 << 16
"""No image is wider or higher."""


class Pass(Stage):
    """Base of passes over a picture: WGSL that makes one value of each pixel, out of what other passes wrote.

    Attributes
    ----------
    reads, writes
        Names and types of what it looks at, and of the one thing it makes. To write a name that it reads, such as
        ``radiance``, is to change it; any other name is new and its own.
    over
        ``"scene"``: it is made over the radiance of the scene, before tones are mapped; ``"display"``: over what is shown.
    """

    slot: ClassVar[str] = "passes"
    reads: ClassVar[Mapping[str, Kind]] = {"radiance": COLOUR, "depth": DEPTH}
    writes: ClassVar[Mapping[str, Kind]] = {"radiance": COLOUR}
    over: ClassVar[str] = "display"

    def __post_init__(self) -> None:
        """Check what the class declares, and the parameters."""
        where = f"pass {self.name!r}"
        for what, names in (("reads", self.reads), ("writes", self.writes)):
            if not isinstance(names, Mapping):
                raise StageError(where, f"{what} {names!r}", f'e.g. {what} = {{"radiance": airlight.passes.COLOUR}}')
            for name, kind in names.items():
                if not (name.isidentifier() and isinstance(kind, Kind)):
                    remedy = f'e.g. {what} = {{"radiance": airlight.passes.COLOUR}}'
                    raise StageError(where, f"{what} {name!r} as {kind!r}, which is no name with a type", remedy)
                if isinstance(kind, PerPixel) and kind.wgsl not in PIXEL_BYTES:
                    raise StageError(where, f"{what} {name!r} as {kind}", "pixels have " + ", ".join(PIXEL_BYTES))
        if len(self.writes) != 1 or not isinstance(self.written, PerPixel):
            raise StageError(where, f"writes {', '.join(self.writes) or 'nothing'}", "a pass writes one value for each pixel")
        if self.over not in OVER:
            raise StageError(where, f"is made over {self.over!r}", "choose one of " + ", ".join(OVER))
        super().__post_init__()
        if self.reach_px() is not None:
            whole(self.reach_px(), f"{where}: reach_px()", 0, WHOLE_PX)

    @property
    def written(self) -> Kind:
        """Type of what the pass makes."""
        return next(iter(self.writes.values()))

    def reach_px(self) -> int | None:
        """Return how many pixels away the pass looks at most; None does not tell, and asks for the image in one piece."""
        return None


@dataclass(frozen=True)
class Backdrop(Pass):
    """What layers and meshes leave of pixels to an environment, of which all or nothing is seen."""

    name: ClassVar[str] = "backdrop"
    wgsl: ClassVar[str] = "overlays/backdrop.wgsl"
    reads: ClassVar[Mapping[str, Kind]] = {"radiance": COLOUR}
    writes: ClassVar[Mapping[str, Kind]] = {"backdrop": BACKDROP}
    seen: F32 = param(1.0, at_least=0, up_to=1)

    def reach_px(self) -> int:
        """Return 0: each pixel is made of itself."""
        return 0


@dataclass(frozen=True)
class Overlay(Pass):
    """What passes have in common that draw lines over the picture as it is shown."""

    color: Vec3f = param((1.0, 1.0, 1.0), at_least=0, up_to=1e3, help="of the lines, linear rgb")
    opacity: F32 = param(1.0, at_least=0, up_to=1, help="of the lines")
    width_px: F32 = param(1.5, unit="px", above=0, up_to=64, help="of the lines")

    def reach_px(self) -> int:
        """Return 0: each pixel is made of itself."""
        return 0


@register
@dataclass(frozen=True)
class BoundingBox(Overlay):
    """Edges of the domains of all layers. Those behind the volume are seen through what it lets pass."""

    name: ClassVar[str] = "bounding_box"
    wgsl: ClassVar[str] = "overlays/bounding_box.wgsl"
    reads: ClassVar[Mapping[str, Kind]] = {"radiance": COLOUR, "backdrop": BACKDROP, "depth": DEPTH, "domains": DOMAINS}


@register
@dataclass(frozen=True)
class SliceOutlines(Overlay):
    """Outlines of the slices that a slice driver draws of the first layer's domain; cameras inside see what lies behind.

    Vollrath, Weiskopf and Ertl, section 3.3. No polygons are asked: outlines are the contour lines of the slices' numbers on
    the faces of the domain.
    """

    name: ClassVar[str] = "slice_outlines"
    wgsl: ClassVar[str] = "overlays/slice_outlines.wgsl"
    reads: ClassVar[Mapping[str, Kind]] = {**BoundingBox.reads, "slices": SLICES}
    every: F32 = param(1.0, at_least=1, up_to=1e4, help="outline one slice of so many")


def checked_passes(given: Iterable[str | Stage]) -> tuple[Pass, ...]:
    """Return passes, each given by name or as it is, as a tuple.

    Raises
    ------
    AirlightError
        When they are no list, a name is unknown, or something else is among them.
    """
    parts: tuple[Any, ...] = listed(given, "passes", 'pass a list: passes=["bounding_box"]')
    for part in parts:
        if not isinstance(part, Stage) and not (isinstance(part, str) and part in STAGES["passes"]):
            known = ", ".join(sorted(STAGES["passes"])) or "none so far"
            raise ValueRangeError("passes", f"has {part!r}, must be a Pass or one of {known}", "airlight.register it first")
    found = tuple(make_stage("passes", part) for part in parts)
    for one in found:
        if not isinstance(one, Pass):
            raise StageError(f"pass {one.name!r}", "is no Pass", "derive its class from airlight.Pass")
    return found  # type: ignore[return-value]
