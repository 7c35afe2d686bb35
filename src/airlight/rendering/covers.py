"""Meshes, lines and points of a frame: drawn by the rasteriser, lit, and left as the covers that rays meet on their way.

First what is opaque, then what lets light pass: in one pass that keeps the triangles of each pixel, put in order afterwards.
Where a pixel has more than there is room for, again, with room for as many. The
rasteriser only finds which triangles are seen; where the pixel's own ray meets them is computed for the triangles themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..clips import Clip
from ..errors import StageError
from ..geometry.marks import mesh_of
from ..geometry.mesh import Mesh
from ..gpu import compute, raster
from ..gpu.tiles import Tile
from ..scene import Scene
from ..shader.program import FrameUniforms
from ..stage import Stage
from ..stages.shade import BlinnPhong, Shade
from ..stages.visibility import NoOcclusion
from ..volume import FloatArray
from .rasterised import Rasterised, meets_meshes, parts_of, tiles_of
from .resources import DrawnLayer, bound_resources, write_lights

if TYPE_CHECKING:
    from .march import MarchFrame

BYTES_PER_COVER = 20
SLOTS = 16  # for semi-transparent triangles of a pixel; where there are more, they are drawn again


@dataclass(eq=False)
class Covers:
    """Meshes of a frame, and what was found while they were drawn."""

    frame: MarchFrame

    def __post_init__(self) -> None:
        """Nothing is drawn yet."""
        self.counts = np.zeros(self.layers + 2, dtype=np.int64)

    @cached_property
    def meshes(self) -> list[Mesh]:
        """Triangles in the world of the user; those that face the image follow its camera."""
        scene = self.frame.given
        assert not isinstance(scene.camera, str)
        camera, size_px = scene.camera, self.frame.size_px
        drawn = (shape if isinstance(shape, Mesh) else mesh_of(shape, camera, size_px) for shape in scene.meshes)
        return [mesh for mesh in drawn if mesh is not None and mesh.opacity > 0]

    @cached_property
    def clips(self) -> tuple[Clip, ...]:
        """Clips that cut meshes."""
        return self.frame.given.clips if any(mesh.clipped for mesh in self.meshes) else ()

    @property
    def layers(self) -> int:
        """Most semi-transparent layers that are kept."""
        return int(getattr(self.frame.scene_stages["driver"], "mesh_layers", 4))

    @cached_property
    def see_through(self) -> bool:
        """Whether there are semi-transparent meshes."""
        return any(not mesh.opaque for mesh in self.meshes)

    @property
    def cut_slabs(self) -> bool:
        """Whether semi-transparent meshes lie between slabs."""
        return self.see_through and bool(getattr(self.frame.scene_stages["integrate"], "takes_covers", False))

    @property
    def bytes_per_pixel(self) -> int:
        """Bytes of the covers of a pixel."""
        return BYTES_PER_COVER * (1 + self.layers * self.see_through)

    @cached_property
    def light(self) -> DrawnLayer:
        """The shade stage of the first layer, for surfaces that are no gradients; Blinn-Phong where that is not lit."""
        layer = self.frame.layers[0]
        shade: Any = self.frame.given.drawn_layers[0].look.shade
        if isinstance(shade, Shade) and not shade.lit:
            shade = BlinnPhong()
        if hasattr(shade, "gradient_threshold"):
            shade = replace(shade, gradient_threshold=0.0)
        stages: dict[str, Stage] = {"field": layer.field, "shade": shade, "visibility": NoOcclusion()}
        resources = {slot: {} if slot == "field" else stage.resources(layer.context) for slot, stage in stages.items()}
        return DrawnLayer(stages, layer.context, resources)

    def buffer(self, pixels: int) -> Any:
        """Buffer of the covers of so many pixels."""
        return compute.storage_buffer(self.frame.device, "covers", pixels * self.bytes_per_pixel)

    def draw(self, band: Any, outlines: dict[str, Any]) -> Any:
        """Draw the meshes of a band of rows, cut by closed meshes with these ``outlines``; return the buffer of its covers."""
        frame = self.frame
        target = self.buffer(band.pixels)
        raster.clear_buffer(frame.device, target, band.pixels * self.bytes_per_pixel)
        shown = _Shown(self, band, target, outlines)
        for tile in tiles_of(frame, band, SLOTS * self.see_through):
            frame.check()
            shown.draw_tile(tile, SLOTS)
        frame.device.wait()
        return target

    def statistics(self) -> dict[str, Any]:
        """What ``image.stats`` says of meshes."""
        if not self.frame.given.meshes:
            return {}
        told: dict[str, Any] = {
            "triangles": sum(len(mesh.faces) for mesh in self.meshes),
            "opaque": sum(mesh.opaque for mesh in self.meshes),
            "semi_transparent": sum(not mesh.opaque for mesh in self.meshes),
        }
        if self.see_through:
            found = self.counts[1:].tolist()
            told |= {"layers": self.layers, "layer_pixels": found[:-1], "pixels_with_more_layers": found[-1]}
        return {"meshes": told}


class _Shown:
    """Programs, buffers and bindings for the meshes of one band."""

    def __init__(self, covers: Covers, band: Any, target: Any, outlines: dict[str, Any]) -> None:
        self.covers, self.frame, self.band = covers, covers.frame, band
        device, alone = self.frame.device, covers.light
        self.drawn = Rasterised(self.frame, covers.meshes, alone, covers.clips, outlines)
        vertices = ("mesh_vertices", "mesh_faces")
        self.programs = {
            "found": self.drawn.program("passes/covers.wgsl", ("covers", "triangles", *vertices), lit=True),
            "gathered": self.drawn.program(
                "passes/gathered.wgsl", ("covers", "cover_counts", "fragments", "fragment_counts", *vertices), lit=True
            ),
        }
        anchor, progress = self.frame.anchor_world, self.frame.progress
        self.bound = bound_resources(device, self.programs["found"], (alone,), {"camera": {}}, anchor, progress) | {
            "covers": target,
            "cover_counts": compute.storage_buffer(device, "cover counts", 4 * (covers.layers + 2)),
            "lights": write_lights(device, self.frame.scene.lights),
        }

    def draw_tile(self, tile: Tile, slots: int) -> None:
        """Draw what is opaque, then what lets light pass: in one pass, or two where that has too little room."""
        covers, targets = self.covers, self.drawn.targets(tile)
        clear = [n for n, mesh in enumerate(covers.meshes) if not mesh.opaque]
        self._draw_opaque(tile, targets)
        if not clear:
            return
        raster.clear_buffer(self.frame.device, self.bound["cover_counts"], 4 * (covers.layers + 2))
        part = replace(self._part(tile), fragment_slots=slots)
        fragments = self.drawn.gathered(clear, tile, targets, part, slots)
        if fragments.most:
            for smaller in parts_of(self.frame.device, tile, fragments.most):
                self.draw_tile(smaller, fragments.most)
            return
        program, resources = self.programs["gathered"], {"fragments": fragments.triangles, "fragment_counts": fragments.counts}
        seen = self.drawn.part_seen(clear, tile)  # the first counts for all
        for n in clear:
            told = self.drawn.uniforms(n, layers=covers.layers, is_first=n == clear[0])
            self.drawn.resolved(program, part, f"uniforms of mesh {n}", seen, n, self.bound | resources, mesh=told)
        covers.counts += self._counts()

    def _draw_opaque(self, tile: Tile, targets: raster.Targets) -> None:
        numbers = [n for n, mesh in enumerate(self.covers.meshes) if mesh.opaque]
        part, program = self._part(tile), self.programs["found"]
        raster.draw(self.frame.device, targets.found, targets.opaque, self.drawn.bound("raster", numbers, part, {}))
        for n in numbers:
            seen, resources = self.drawn.part_seen([n], tile), self.bound | {"triangles": targets.found}
            told = self.drawn.uniforms(n)
            self.drawn.resolved(program, part, f"uniforms of mesh {n}", seen, n, resources, mesh=told)

    def _counts(self) -> np.ndarray[Any, Any]:
        """Pixels with a triangle in each layer of the tile, from number 1 on."""
        size = 4 * (self.covers.layers + 2)
        data = self.frame.device.queue.read_buffer(self.bound["cover_counts"], 0, size)
        return np.frombuffer(data, dtype=np.uint32).astype(np.int64)

    def _part(self, tile: Tile) -> FrameUniforms:
        uniforms: FrameUniforms = self.band.uniforms(tile)
        return uniforms


def check_covers(frame: MarchFrame) -> None:
    """Refuse meshes where they cannot be drawn.

    Raises
    ------
    StageError
        For cameras whose images no rasteriser makes, stages that give semi-transparent meshes no place along the ray, and
        surfaces that are to be kept, which meshes are not.
    """
    if not frame.given.meshes:
        return
    camera, integrate = frame.scene_stages["camera"], frame.scene_stages["integrate"]
    if not meets_meshes(camera):
        raise StageError(
            f"camera {camera.name!r}", "draws no meshes: it tells neither clip_place nor seen_within", "leave them out"
        )
    if frame.keeps_hits or frame.found is not None:
        raise StageError("keep_hits", "keeps surfaces of volumes, not meshes", "leave them out, and grids, axes and pointers")
    orders = frame.covers.cut_slabs or getattr(integrate, "surfaces_only", False)
    if frame.covers.see_through and not orders:
        what = "makes one value of the whole ray, along which a semi-transparent mesh has no place"
        raise StageError(f"look.integrate {integrate.name!r}", what, "use an opaque mesh, or emission_absorption")


def visible_corners(scene: Scene) -> list[FloatArray]:
    """Corners (n, 3) of what is drawn beside volumes, in the world."""
    return [shape.corners_world for shape in scene.meshes]
