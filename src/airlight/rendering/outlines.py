"""Closed meshes that clip: where the rays of pixels pass their surfaces, in order, and what is kept behind each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..clips import CUTS, Solid
from ..errors import LimitError, StageError
from ..gpu import compute, raster
from ..gpu.tiles import Tile
from ..shader.program import OutlineUniforms
from ..stages.driver import MOST_CLIP_LAYERS
from .rasterised import Rasterised, meets_meshes, tiles_of

if TYPE_CHECKING:
    from .march import MarchFrame

BYTES_PER_CHANGE = 8
INFINITE = np.float32(3.4e38).view(np.uint32)  # as `ray.wgsl` has it
BEGINS = 0x10000000  # as `outline.wgsl` has it


@dataclass(eq=False)
class Outlines:
    """Closed meshes that clip the layers or the meshes of a frame."""

    frame: MarchFrame

    @cached_property
    def solids(self) -> tuple[Solid, ...]:
        """Clips that are meshes, each once."""
        clips = (*self.frame.clips, *self.frame.covers.clips)
        return tuple(dict.fromkeys(clip for clip in clips if isinstance(clip, Solid)))

    @property
    def slots(self) -> int:
        """Most surfaces of each that a ray may pass."""
        return int(getattr(self.frame.scene_stages["driver"], "clip_layers", 16)) if self.solids else 0

    @property
    def bytes_per_pixel(self) -> int:
        """Bytes of the changes at a pixel, in one binding."""
        return BYTES_PER_CHANGE * (self.slots + 1) * len(self.solids)

    def draw(self, band: Any) -> Any:
        """Find the changes of a band of rows; return their buffer.

        Raises
        ------
        LimitError
            Where a ray passes more surfaces of a mesh than there is room for.
        """
        device = self.frame.device
        target = compute.storage_buffer(device, "changes", band.pixels * self.bytes_per_pixel)
        drawn = Rasterised(self.frame, [solid.closed for solid in self.solids])
        for number, solid in enumerate(self.solids):
            # The row of rays that pass none of its surfaces.
            keeps = solid.cuts != "volume" or solid.keep == "outside"
            unmet = np.array([INFINITE, 0 if keeps else BEGINS], dtype=np.uint32)
            first_byte = BYTES_PER_CHANGE * (self.slots + 1) * band.pixels * number
            compute.repeat(device, unmet, band.pixels, target, first_byte)
        for tile in tiles_of(self.frame, band, self.slots):
            self.frame.check()
            for number in range(len(self.solids)):
                self._draw_tile(drawn, number, band, tile, target)
        device.wait()
        return target

    def _draw_tile(self, drawn: Rasterised, number: int, band: Any, tile: Tile, target: Any) -> None:
        device, solid, targets = self.frame.device, self.solids[number], drawn.targets(tile)
        # No depth: nothing hides what clips.
        raster.draw(device, targets.found, targets.opaque, [])
        part = band.uniforms(tile, fragment_slots=self.slots)
        fragments = drawn.gathered([number], tile, targets, part, self.slots)
        if fragments.most:
            what = f"is a mesh with {fragments.most} surfaces behind one pixel, and rays pass {self.slots} at most"
            more = f"draw with driver=airlight.driver.March(clip_layers={fragments.most})"
            raise LimitError("scene.clips", what, more if fragments.most <= MOST_CLIP_LAYERS else "simplify it")
        names = ("changes", "fragments", "fragment_counts", "fragment_times", "mesh_vertices", "mesh_faces")
        program = drawn.program("passes/outlines.wgsl", names, ("mesh", "outline"))
        outline = OutlineUniforms(
            number, CUTS.index(solid.cuts), solid.keep == "inside", solid.capped, float(solid.closed.outward)
        )
        told = {"mesh": drawn.uniforms(number), "outline": outline}
        resources = {
            "changes": target,
            "fragments": fragments.triangles,
            "fragment_counts": fragments.counts,
            "fragment_times": compute.storage_buffer(device, "fragment times", 4 * tile.width * tile.height * self.slots),
        }
        seen = drawn.part_seen([number], tile)
        drawn.resolved(program, part, f"uniforms of outline {number}", seen, number, resources, **told)


def check_outlines(frame: MarchFrame) -> None:
    """Refuse meshes that clip where they cannot.

    Raises
    ------
    StageError
        For cameras whose images no rasteriser makes, and where something is to know of clips beside the rays of pixels.
    """
    camera = frame.scene_stages["camera"]
    if frame.outlines.solids and not meets_meshes(camera):
        what = "meets no meshes, and one clips: it tells neither clip_place nor seen_within"
        raise StageError(f"camera {camera.name!r}", what, "use another clip")
    for layer in frame.layers:
        visibility = frame.stages_of(layer)["visibility"]
        along = [clip for clip in layer.context.clips if isinstance(clip, Solid) or clip.cuts != "volume"]
        if along and visibility.name != "none":
            what = f"knows nothing of a {along[0].kind} that cuts rays of pixels"
            raise StageError(f"look.visibility {visibility.name!r}", what, 'use "none", or planes, boxes and spheres')
