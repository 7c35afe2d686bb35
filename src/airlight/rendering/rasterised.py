"""Meshes on the device, and the passes that find their triangles: what covers and outlines share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..clips import Clip, Solid
from ..geometry.mesh import Mesh
from ..gpu import compute, raster
from ..gpu.device import Device
from ..gpu.tiles import Tile
from ..shader.link import parse, stage_source
from ..shader.program import FrameUniforms, MeshUniforms, Program, ProgramKey, Switches, build_program, stage_key
from ..stage import Stage
from ..volume import FloatArray
from .clips import pack_clips
from .resources import DrawnLayer, light_count, pack_uniforms, uniform_values
from .shown import part_seen

if TYPE_CHECKING:
    from .march import MarchFrame

MOST_TILE = 2048
MOST_FRAGMENT_BYTES = 64 << 20  # of the triangles of a tile's pixels
NEAR = 1e-4  # of the distance of the farthest point: what is nearer to the eye is not drawn
SKIN_VOXELS = 1e-3
SKIN_PX = 1 / 64


def has_projection(camera: Stage) -> bool:
    """Whether triangles are triangles in a camera's images."""
    return _declares(camera, "clip_place")


def meets_meshes(camera: Stage) -> bool:
    """Whether a rasteriser finds what a camera's rays meet: triangles in its images, or the boxes that hold them there."""
    return has_projection(camera) or _declares(camera, "seen_within")


def _declares(camera: Stage, function: str) -> bool:
    return function in parse(stage_source(camera.wgsl, camera.name)).declared


def skin_world(frame: MarchFrame) -> float:
    """How far proxies are to lie outside of what they stand for, as a frame's camera sees its layers [world].

    Rasterisers round corners to 256ths of a pixel, and leave out pixels whose middle lies right on an edge.
    """
    camera: Any = frame.scene_stages["camera"]
    at_eye_world, per_world = camera.pixel_width(frame.size_px)
    corners = np.concatenate([layer.context.volume.corners_world(layer.field.cells) for layer in frame.layers])
    depths = (corners - frame.anchor_world - np.asarray(camera.eye)) @ camera.basis()[2]
    voxel = min(min(layer.context.volume.spacing) for layer in frame.layers)
    return float(max(SKIN_VOXELS * voxel, SKIN_PX * (at_eye_world + per_world * depths.max(initial=0.0))))


def depths_between(points: FloatArray, frame: MarchFrame) -> tuple[float, float]:
    """Depths along the view between which points (n, 3) of the device's world are drawn, and what lies between them."""
    camera: Any = frame.scene_stages["camera"]
    depths = (points - np.asarray(camera.eye)) @ camera.basis()[2]
    far = max(float(depths.max(initial=0.0)) * (1 + 1e-3), 1e-30)
    return NEAR * far, far


@dataclass(frozen=True, eq=False)
class Fragments:
    """Triangles that a tile's pixels meet, in no order; ``most`` is the most of a pixel where there are not enough places."""

    triangles: Any
    counts: Any
    most: int


@dataclass(eq=False)
class Rasterised:
    """Meshes of a frame as its camera sees them.

    ``alone`` is the layer whose stages light them; None where nothing does. ``clips`` cut those that are to be cut; of meshes
    among the clips ``outlines`` are known.
    """

    frame: MarchFrame
    meshes: Sequence[Mesh]
    alone: DrawnLayer | None = None
    clips: tuple[Clip, ...] = ()
    outlines: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Upload what is not there yet."""
        self.camera = {"camera": self.frame.scene_stages["camera"]}
        device, anchor, progress = self.frame.device, self.frame.anchor_world, self.frame.progress
        if self.alone is None:
            self.values = {slot: stage.uniforms(self.frame.layers[0].context) for slot, stage in self.camera.items()}
        else:
            self.values = uniform_values(device, self.camera, (self.alone,), anchor, progress)
        self.triangles = [self._uploaded(mesh) for mesh in self.meshes]
        counts = [len(mesh.faces) for mesh in self.meshes]
        self.first_triangles = [sum(counts[:number]) for number in range(len(counts))]
        self.in_boxes = not has_projection(self.camera["camera"])

    @cached_property
    def depths_world(self) -> tuple[float, float]:
        """Depths along the view between which meshes are drawn.

        Where triangles are drawn in boxes, none is too near, and the first is the distance at which depths are halved.
        """
        camera: Any = self.camera["camera"]
        corners = np.concatenate([mesh.corners_world for mesh in self.meshes]) - self.frame.anchor_world
        way = corners - np.asarray(camera.eye)
        depths = np.linalg.norm(way, axis=1) if self.in_boxes else way @ camera.basis()[2]
        far = max(float(depths.max()), 1e-30) * (1 + 1e-5)
        return NEAR * far if self.in_boxes else max(float(depths.min()) * (1 - 1e-5), NEAR * far), far

    def _uploaded(self, mesh: Mesh) -> raster.Triangles:
        device = self.frame.device
        owners = (mesh.vertices, mesh.faces, *([] if mesh.colors is None else [mesh.colors]))
        found: raster.Triangles = device.kept.get(
            ("mesh", mesh.smooth), lambda: raster.upload_triangles(device, mesh.faces, _attributes(mesh), "mesh"), *owners
        )
        return found

    def program(self, root: str, outputs: tuple[str, ...], extra: tuple[str, ...] = ("mesh",), lit: bool = False) -> Program:
        """Program of a pass with the frame's camera; ``lit`` with the stages that light."""
        device, stages = self.frame.device, tuple((slot, stage_key(stage)) for slot, stage in self.camera.items())
        keys: tuple[Any, ...] = ()
        groups, lights = 0, 1
        if lit:
            assert self.alone is not None
            alone, context = self.alone, self.alone.context
            keys = (tuple((s, stage_key(t, alone.resources[s], t.variant(context))) for s, t in alone.stages.items()),)
            groups, lights = alone.field.groups(context), light_count(self.frame.scene.lights)
        return build_program(ProgramKey(root, stages, keys, outputs, extra, Switches(), device.traits, groups, lights))

    def part_seen(self, numbers: Sequence[int], tile: Tile) -> Tile:
        """Part of a tile in which there may be triangles of meshes."""
        boxes_world = [self.meshes[number].corners_world for number in numbers]
        return part_seen(self.frame.given.camera, boxes_world, self.frame.size_px, tile)

    def uniforms(self, number: int, **told: Any) -> MeshUniforms:
        """Uniforms of a mesh."""
        mesh = self.meshes[number]
        world_from_mesh = mesh.matrix @ _shift(_middle(mesh))
        world_from_mesh[:3, 3] -= self.frame.anchor_world
        near, far = self.depths_world
        return MeshUniforms(
            world_from_mesh=world_from_mesh,
            normal_from_mesh=_normal_matrix(mesh.matrix[:3, :3]),
            rgb=mesh.color,
            opacity=mesh.opacity,
            near_world=near,
            far_world=far,
            number=number,
            stride=self.triangles[number].stride,
            first_triangle=self.first_triangles[number],
            triangles=len(mesh.faces),
            is_smooth=mesh.smooth,
            is_lit=mesh.lit,
            is_opaque=mesh.opaque,
            **told,
        )

    def packed(self, program: Program, part: FrameUniforms, name: str, **told: Any) -> Any:
        """Uniform buffer of a pass."""
        return compute.write_uniforms(self.frame.device, name, pack_uniforms(program, part, self.values | told))

    def bound(self, name: str, numbers: Sequence[int], part: FrameUniforms, read: dict[str, Any]) -> list[raster.Drawn]:
        """Meshes with what a render pass looks at; there are two passes of a name, for triangles and for boxes."""
        device, drawn = self.frame.device, []
        root = f"passes/{name}{'_boxes' * self.in_boxes}.wgsl"
        for n in numbers:
            looked_at = read | (self._corners(n) if self.in_boxes else {})
            looked_at |= self._cutting(n) if self.meshes[n].clipped else {}
            pipeline = raster.render_pipeline(device, self.program(root, tuple(looked_at)), self.in_boxes)
            uniforms = self.packed(pipeline.program, part, f"uniforms of mesh {n} in {root}", mesh=self.uniforms(n))
            resources = {**looked_at, "uniforms": uniforms}
            drawn.append(raster.bound(device, pipeline, self.triangles[n], resources, self.in_boxes))
        return drawn

    def _corners(self, number: int) -> dict[str, Any]:
        triangles = self.triangles[number]
        return {"mesh_vertices": triangles.vertices, "mesh_faces": triangles.faces}

    def _cutting(self, number: int) -> dict[str, Any]:
        """What clips look at that cut a mesh; nothing where there is none."""
        return self._packed_clips | self._corners(number) if self.clips else {}

    @cached_property
    def _packed_clips(self) -> dict[str, Any]:
        world_from_device = _shift(self.frame.anchor_world)
        packed = pack_clips((self.clips,), world_from_device, self.frame.outlines.solids)
        found = {"clips": compute.write_storage(self.frame.device, "clips of meshes", packed)}
        return found | (self.outlines if any(isinstance(clip, Solid) for clip in self.clips) else {})

    def gathered(
        self, numbers: Sequence[int], tile: Tile, targets: raster.Targets, part: FrameUniforms, slots: int
    ) -> Fragments:
        """Draw meshes once; keep all their triangles at each pixel that lie in front of what is opaque."""
        device = self.frame.device
        pixels = tile.width * tile.height
        triangles = compute.storage_buffer(device, "fragments", 4 * pixels * slots)
        counts = compute.storage_buffer(device, "fragment counts", 4 * pixels)
        most = compute.storage_buffer(device, "most fragments", 4)
        raster.clear_buffer(device, counts, 4 * pixels)
        raster.clear_buffer(device, most, 4)
        read = {"fragments": triangles, "fragment_counts": counts, "most_fragments": most, "opaque_depth": targets.opaque}
        drawn = self.bound("gather", numbers, replace(part, fragment_slots=slots), read)
        raster.draw(device, None, targets.unused, drawn)
        found = int(np.frombuffer(device.queue.read_buffer(most, 0, 4), dtype=np.uint32)[0])
        return Fragments(triangles, counts, found)

    def targets(self, tile: Tile) -> raster.Targets:
        """Textures of a tile's size."""
        return raster.targets_of_size(self.frame.device, (tile.width, tile.height))

    def resolved(
        self, program: Program, part: FrameUniforms, name: str, seen: Tile, number: int, resources: dict[str, Any], **told: Any
    ) -> None:
        """Run a pass that looks at the triangles of a mesh over a part of a tile; ``told`` are uniforms by name."""
        if not seen.width or not seen.height:
            return
        device, (x, y) = self.frame.device, part.tile_origin_px
        mesh = replace(told["mesh"], seen_px=(seen.x - x, seen.y - y))
        resources = resources | {"uniforms": self.packed(program, part, name, **told | {"mesh": mesh})}
        pipeline = compute.pipeline_of(device, program)
        groups = compute.bind_groups(device, pipeline, resources | self._corners(number))
        compute.dispatch_pixels(device, pipeline, groups, seen.width, seen.height)


def tiles_of(frame: MarchFrame, band: Any, slots: int = 0) -> Iterator[Tile]:
    """Parts of a band for so many triangles a pixel; no part lies in two images."""
    width = frame.size_px[0]
    views = getattr(frame.scene_stages["camera"], "views", 1)
    edges = [width * view // views for view in range(views + 1)]
    for begin, end in pairwise(edges):
        yield from parts_of(frame.device, Tile(begin, band.first_row, end - begin, band.rows), slots)


def parts_of(device: Device, tile: Tile, slots: int) -> Iterator[Tile]:
    """Parts of a tile that fit into a texture, and into a buffer with so many triangles a pixel."""
    limits = device.limits
    most = min(MOST_TILE, limits["max-texture-dimension-2d"])
    if slots:
        room = min(MOST_FRAGMENT_BYTES, limits["max-storage-buffer-binding-size"])
        most = min(most, max(1, int((room / (4 * slots)) ** 0.5)))
    for y in range(0, tile.height, most):
        for x in range(0, tile.width, most):
            yield Tile(tile.x + x, tile.y + y, min(most, tile.width - x), min(most, tile.height - y))


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
    return np.asarray(mesh.bounds.mean(axis=0))


def _shift(way: FloatArray) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, 3] = way
    return matrix


def _normal_matrix(axes: FloatArray) -> FloatArray:
    """Matrix that keeps normals across surfaces, with entries of about one."""
    found = np.linalg.inv(axes).T
    return np.asarray(found / np.abs(found).max())
