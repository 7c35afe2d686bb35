"""Meshes, lines and points of a frame: drawn by the rasteriser, lit, and left as the covers that rays meet on their way.

First what is opaque, then layer by layer what lets light pass, each behind the one before (depth peeling, Everitt 2001). The
rasteriser only finds which triangle is seen at a pixel; where the pixel's own ray meets it is computed for the triangle itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import StageError
from ..geometry.marks import mesh_of
from ..geometry.mesh import Mesh
from ..gpu import compute, raster
from ..gpu.tiles import Tile
from ..scene import Scene
from ..shader.link import parse, stage_source
from ..shader.program import MeshUniforms, Program, ProgramKey, Switches, build_program, stage_key
from ..stage import Stage
from ..stages.shade import BlinnPhong, Shade
from ..stages.visibility import NoOcclusion
from ..volume import FloatArray
from .resources import DrawnLayer, bound_resources, light_count, pack_uniforms, uniform_values, write_lights

if TYPE_CHECKING:
    from .march import MarchFrame

BYTES_PER_COVER = 20
MOST_TILE = 2048
NEAR = 1e-4  # of the distance of the farthest point: what is nearer to the eye is not drawn


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
    def depths_world(self) -> tuple[float, float]:
        """Depths along the view between which meshes are drawn."""
        camera: Any = self.frame.scene_stages["camera"]
        corners = np.concatenate([mesh.corners_world for mesh in self.meshes]) - self.frame.anchor_world
        depths = (corners - np.asarray(camera.eye)) @ camera.basis()[2]
        far = max(float(depths.max()), 1e-30) * (1 + 1e-5)
        return max(float(depths.min()) * (1 - 1e-5), NEAR * far), far

    @cached_property
    def light(self) -> DrawnLayer:
        """The shade stage of the first visible layer, for surfaces that are no gradients; Blinn-Phong where that is not lit."""
        layer = self.frame.layers[0]
        shade: Any = self.frame.given.visible_layers[0].look.shade
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

    def draw(self, band: Any) -> Any:
        """Draw the meshes of a band of rows; return the buffer of its covers."""
        frame = self.frame
        target = self.buffer(band.pixels)
        raster.clear_buffer(frame.device, target, band.pixels * self.bytes_per_pixel)
        shown = _Shown(self, band, target)
        for tile in _tiles(frame, band):
            frame.check()
            shown.draw_tile(tile)
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

    def __init__(self, covers: Covers, band: Any, target: Any) -> None:
        self.covers, self.frame, self.band = covers, covers.frame, band
        device = self.frame.device
        camera = {"camera": self.frame.scene_stages["camera"]}
        self.programs = {
            "raster": self._program("passes/raster.wgsl", camera, ()),
            "peel": self._program("passes/peel.wgsl", camera, ("peeled_depth", "opaque_depth")),
        }
        self.resolve = self._program(
            "passes/covers.wgsl", camera, ("covers", "cover_counts", "triangles", "mesh_vertices", "mesh_faces"), lit=True
        )
        alone, anchor, progress = covers.light, self.frame.anchor_world, self.frame.progress
        self.values = uniform_values(device, camera, (alone,), anchor, progress)
        counts = compute.storage_buffer(device, "cover counts", 4 * (covers.layers + 2))
        self.bound = bound_resources(device, self.resolve, (alone,), {"camera": {}}, anchor, progress) | {
            "covers": target,
            "cover_counts": counts,
            "lights": write_lights(device, self.frame.scene.lights),
        }
        self.triangles = [self._uploaded(mesh) for mesh in covers.meshes]

    def _program(self, root: str, scene: dict[str, Stage], outputs: tuple[str, ...], lit: bool = False) -> Program:
        alone, device = self.covers.light, self.frame.device
        keys = tuple((slot, stage_key(s, alone.resources[slot], s.variant(alone.context))) for slot, s in alone.stages.items())
        groups, lights = alone.field.groups(alone.context), light_count(self.frame.scene.lights)
        stages = tuple((slot, stage_key(stage)) for slot, stage in scene.items())
        return build_program(
            ProgramKey(root, stages, (keys,) if lit else (), outputs, ("mesh",), Switches(), device.traits, groups, lights)
        )

    def _uploaded(self, mesh: Mesh) -> raster.Triangles:
        device = self.frame.device
        owners = (mesh.vertices, mesh.faces, *([] if mesh.colors is None else [mesh.colors]))
        found: raster.Triangles = device.kept.get(
            ("mesh", mesh.smooth), lambda: raster.upload_triangles(device, mesh.faces, _attributes(mesh), "mesh"), *owners
        )
        return found

    def _mesh_uniforms(self, number: int, layer: int) -> MeshUniforms:
        mesh, anchor = self.covers.meshes[number], self.frame.anchor_world
        world_from_mesh = mesh.matrix @ _shift(_middle(mesh))
        world_from_mesh[:3, 3] -= anchor
        near, far = self.covers.depths_world
        return MeshUniforms(
            world_from_mesh=world_from_mesh,
            normal_from_mesh=_normal_matrix(mesh.matrix[:3, :3]),
            rgb=mesh.color,
            opacity=mesh.opacity,
            near_world=near,
            far_world=far,
            number=number,
            stride=self.triangles[number].stride,
            layer=layer,
            layers=self.covers.layers if self.covers.see_through else 0,
            is_smooth=mesh.smooth,
            is_lit=mesh.lit,
        )

    def draw_tile(self, tile: Tile) -> None:
        """Draw what is opaque, then layer after layer, until one is empty."""
        device, covers = self.frame.device, self.covers
        size = (tile.width, tile.height)
        targets: raster.Targets = device.kept.get(("targets", size), lambda: raster.targets_of(device, size))
        numbers = range(len(covers.meshes))
        opaque = [n for n in numbers if covers.meshes[n].opaque]
        clear = [n for n in numbers if not covers.meshes[n].opaque]
        self._layer(0, opaque, tile, targets, "raster", targets.opaque, {})
        if not clear:
            return
        raster.clear_buffer(device, self.bound["cover_counts"], 4 * (covers.layers + 2))
        depth, before = targets.depths
        raster.draw(device, self._pipeline("raster"), targets.found, before, [], clears_to=1.0)
        for layer in range(1, covers.layers + 2):
            self._layer(layer, clear, tile, targets, "peel", depth, {"peeled_depth": before, "opaque_depth": targets.opaque})
            data = device.queue.read_buffer(self.bound["cover_counts"], 4 * layer, 4)
            count = int(np.frombuffer(data, dtype=np.uint32)[0])
            covers.counts[layer] += count
            depth, before = before, depth
            if not count:
                break

    def _layer(
        self,
        layer: int,
        numbers: Sequence[int],
        tile: Tile,
        targets: raster.Targets,
        kind: str,
        depth: Any,
        read: dict[str, Any],
    ) -> None:
        device, pipeline = self.frame.device, self._pipeline(kind)
        part = replace(self.band.uniforms(), tile_origin_px=(tile.x, tile.y), tile_size_px=(tile.width, tile.height))
        uniforms = {n: self.values | {"mesh": self._mesh_uniforms(n, layer)} for n in numbers}
        drawn = []
        for n in numbers:
            packed = pack_uniforms(self.programs[kind], part, uniforms[n])
            resources = {**read, "uniforms": compute.write_uniforms(device, f"uniforms of mesh {n} in {kind}", packed)}
            drawn.append(raster.bound(device, pipeline, self.triangles[n], resources))
        raster.draw(device, pipeline, targets.found, depth, drawn)
        light = compute.pipeline_of(device, self.resolve)
        x, y = device.traits.workgroup
        for n in numbers:
            packed = pack_uniforms(self.resolve, part, uniforms[n])
            resources = {
                **self.bound,
                "uniforms": compute.write_uniforms(device, f"uniforms of mesh {n}", packed),
                "triangles": targets.found,
                "mesh_vertices": self.triangles[n].vertices,
                "mesh_faces": self.triangles[n].faces,
            }
            groups = compute.bind_groups(device, light, resources)
            compute.dispatch(device, light, groups, (-(-tile.width // x), -(-tile.height // y), 1))

    def _pipeline(self, kind: str) -> compute.Pipeline:
        return raster.render_pipeline(self.frame.device, self.programs[kind])


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
    if "clip_place" not in parse(stage_source(camera.wgsl, camera.name)).declared:
        raise StageError(f"camera {camera.name!r}", "draws no meshes", "use perspective or orthographic, or leave them out")
    if frame.keeps_hits or frame.found is not None:
        raise StageError("keep_hits", "keeps surfaces of volumes, not meshes", "leave out one of them")
    orders = frame.covers.cut_slabs or getattr(integrate, "surfaces_only", False)
    if frame.covers.see_through and not orders:
        what = "makes one value of the whole ray, along which a semi-transparent mesh has no place"
        raise StageError(f"look.integrate {integrate.name!r}", what, "use an opaque mesh, or emission_absorption")


def visible_corners(scene: Scene) -> list[FloatArray]:
    """Corners (n, 3) of what is drawn beside volumes, in the world."""
    return [shape.corners_world for shape in scene.meshes]


def _tiles(frame: MarchFrame, band: Any) -> Iterator[Tile]:
    """Parts of a band that fit into a texture."""
    most = min(MOST_TILE, frame.device.limits["max-texture-dimension-2d"])
    last = band.first_row + band.rows
    for y in range(band.first_row, last, most):
        for x in range(0, frame.size_px[0], most):
            yield Tile(x, y, min(most, frame.size_px[0] - x), min(most, last - y))


def _attributes(mesh: Mesh) -> np.ndarray[Any, np.dtype[np.float32]]:
    """What the device knows of vertices, (n, 2 or 3, 4): position from the middle of the mesh, normal, and colour if given."""
    found = np.zeros((len(mesh.vertices), 2 if mesh.colors is None else 3, 4), dtype=np.float32)
    found[:, 0, :3] = mesh.vertices - _middle(mesh)
    if mesh.smooth:
        found[:, 1, :3] = mesh.normals
    if mesh.colors is not None:
        found[:, 2] = mesh.colors
    return found


def _middle(mesh: Mesh) -> FloatArray:
    """Middle of a mesh, from which positions are counted on the device: near it, 32 bits are enough."""
    return np.asarray((mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2)


def _shift(way: FloatArray) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, 3] = way
    return matrix


def _normal_matrix(axes: FloatArray) -> FloatArray:
    """Matrix that keeps normals across surfaces, with entries of about one."""
    found = np.linalg.inv(axes).T
    return np.asarray(found / np.abs(found).max())
