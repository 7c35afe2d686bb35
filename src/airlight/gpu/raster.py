"""Triangles on the device, and render passes that find which of them is seen at each pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from ..errors import LimitError
from ..shader.program import Program
from .compute import Pipeline, bind_groups, buffer, compiled, write_uniforms
from .device import Device

FOUND_FORMAT = "rg32uint"
DEPTH_FORMAT = "depth32float"
CORNER = {"array_stride": 12, "attributes": [{"format": "float32x3", "offset": 0, "shader_location": 0}]}
BYTES_PER_PIXEL = 8 + 2 * 4


@dataclass(frozen=True, eq=False)
class Triangles:
    """Buffers of a mesh: corners and their numbers for the rasteriser, its vertices and faces for those who look closer."""

    corners: Any
    numbers: Any
    count: int
    vertices: Any
    faces: Any
    stride: int

    @property
    def bytes(self) -> int:
        """Bytes on the device."""
        return sum(int(b.size) for b in (self.corners, self.numbers, self.vertices, self.faces))


@dataclass(frozen=True, eq=False)
class Targets:
    """What passes draw into: numbers of triangles and meshes, depths of what is opaque, and what no pass looks at."""

    found: Any
    opaque: Any
    unused: Any
    bytes: int


@dataclass(frozen=True, eq=False)
class Drawn:
    """A mesh with the pipeline that draws it, and what is bound to that; in boxes it draws two for each triangle."""

    triangles: Triangles
    pipeline: Pipeline
    groups: list[Any]
    in_boxes: bool


def upload_triangles(
    device: Device, faces: npt.NDArray[np.uint32], attributes: npt.NDArray[np.float32], where: str
) -> Triangles:
    """Upload faces (m, 3) and what their vertices have, (n, k, 4): position, normal, and colour if k is 3.

    A flat number reaches the rasteriser's pixels from the first corner of their triangle. So each triangle gets a first corner
    of its own, the vertex of that number, which others use as second and third corners.

    Raises
    ------
    LimitError
        When the device's buffers are too small.
    """
    positions = attributes[:, 0, :3]
    count = len(faces)
    place = np.full(len(positions), -1, dtype=np.int64)
    place[faces[:, 0]] = np.arange(count)
    alone = np.unique(faces[:, 1:][place[faces[:, 1:]] < 0])
    place[alone] = count + np.arange(len(alone))
    corners = np.concatenate([positions[faces[:, 0]], positions[alone]])
    numbers = place[faces].astype(np.uint32)
    numbers[:, 0] = np.arange(count)
    most = device.limits["max-storage-buffer-binding-size"]
    largest = max(attributes.nbytes, faces.nbytes, corners.nbytes)
    if largest > most:
        what = f"with {count:,} triangles needs a buffer of {largest:,} bytes, the device holds {most:,} at most"
        raise LimitError(where, what, "split it into several meshes, or simplify it")
    usage = wgpu.BufferUsage

    def upload(data: npt.NDArray[Any], use: int) -> Any:
        buffer = device.gpu.create_buffer(size=data.nbytes, usage=use | usage.COPY_DST)
        device.queue.write_buffer(buffer, 0, np.ascontiguousarray(data))
        return buffer

    return Triangles(
        upload(corners, usage.VERTEX),
        upload(numbers, usage.INDEX),
        numbers.size,
        upload(attributes, usage.STORAGE),
        upload(faces, usage.STORAGE),
        attributes.shape[1],
    )


def targets_of_size(device: Device, size_px: tuple[int, int]) -> Targets:
    """Textures of a size, kept for the next frame."""

    def make() -> Targets:
        found, opaque, unused = (_target(device, size_px, each) for each in (FOUND_FORMAT, DEPTH_FORMAT, DEPTH_FORMAT))
        return Targets(found, opaque, unused, size_px[0] * size_px[1] * BYTES_PER_PIXEL)

    kept: Targets = device.kept.get(("targets", size_px), make)
    return kept


def _target(device: Device, size_px: tuple[int, int], texel_format: str) -> Any:
    """View of a new texture that passes draw into and look at."""
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
    return device.gpu.create_texture(size=(*size_px, 1), format=texel_format, usage=usage).create_view()


def _pipeline(
    device: Device,
    program: Program,
    entry: str,
    target: str | None,
    compare: str | None,
    cull: str = "none",
    buffers: Sequence[Any] = (CORNER,),
) -> Pipeline:
    """Compile a program that draws triangles, or return it from the cache.

    ``entry`` is that of pixels, ``target`` the format of the texture that they are drawn into, if any. ``compare`` tells which
    depths win; ``always`` makes no use of them, and None is for passes that have none. ``buffers`` hold the corners.
    """
    depths = {"format": DEPTH_FORMAT, "depth_write_enabled": compare != "always", "depth_compare": compare}

    def make(module: Any, layout: Any) -> Any:
        return device.gpu.create_render_pipeline(
            layout=layout,
            vertex={"module": module, "entry_point": "at_corner", "buffers": list(buffers)},
            primitive={"topology": "triangle-list", "front_face": "ccw", "cull_mode": cull},
            fragment={"module": module, "entry_point": entry, "targets": [] if target is None else [{"format": target}]},
            **({} if compare is None else {"depth_stencil": depths}),
        )

    seen_by = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    key = ("render pipeline", entry, program.key)
    found: Pipeline = device.kept.get(key, lambda: compiled(device, program, seen_by, make))
    return found


def render_pipeline(device: Device, program: Program, in_boxes: bool) -> Pipeline:
    """Compile a program that draws triangles with depths that fall from the eye on, or return it from the cache.

    ``in_boxes``: it finds their corners itself.

    Raises
    ------
    ShaderError
        With file and line of the WGSL at fault, and the compiler's words.
    """
    buffers = () if in_boxes else (CORNER,)
    if "fragments" in program.key.outputs:  # what is gathered is written into buffers
        return _pipeline(device, program, "nearest", None, "always", buffers=buffers)
    return _pipeline(device, program, "nearest", FOUND_FORMAT, "greater", buffers=buffers)


def sweep_pipeline(device: Device, program: Program, target: str | None = None) -> Pipeline:
    """Compile a program of a slice driver, or return it from the cache. It draws the triangles that face away from the eye.

    Into buffers, from the entry point ``take_group``; with a format of a ``target`` into a texture, from ``pass_group``.

    Raises
    ------
    ShaderError
        With file and line of the WGSL at fault, and the compiler's words.
    """
    if target is None:  # a pass has a target, of depths at least
        return _pipeline(device, program, "take_group", None, "always", cull="front")
    return _pipeline(device, program, "pass_group", target, None, cull="front")


def write_corners(device: Device, name: str, corners: npt.NDArray[np.float64]) -> Any:
    """Vertex buffer with corners (t, 3, 3) of triangles, kept by name for the next frame."""
    data = np.ascontiguousarray(corners, dtype=np.float32)
    usage = wgpu.BufferUsage
    target = buffer(device, name, max(data.nbytes, 36), usage.VERTEX | usage.COPY_DST)
    if data.size:
        device.queue.write_buffer(target, 0, data)
    return target


def draw_some(
    device: Device, pipeline: Pipeline, groups: list[Any], size_px: tuple[int, int], corners: Any, part: slice
) -> None:
    """Submit a pass that draws some triangles, by number, for what their fragments write into buffers."""
    depth = {"view": targets_of_size(device, size_px).unused, "depth_load_op": "clear", "depth_store_op": "discard"}
    kinds = {"color_attachments": [], "depth_stencil_attachment": {**depth, "depth_clear_value": 0.0}}
    _draw_part(device, pipeline, groups, kinds, corners, part)


def draw_into(device: Device, pipeline: Pipeline, groups: list[Any], target: Any, corners: Any, part: slice) -> None:
    """Submit a pass that draws some triangles, by number, over what is in a target."""
    kinds = {"color_attachments": [{"view": target, "load_op": "load", "store_op": "store"}]}
    _draw_part(device, pipeline, groups, kinds, corners, part)


def clear_target(device: Device, target: Any, value: tuple[float, float, float, float]) -> None:
    """Fill a texture."""
    encoder = device.gpu.create_command_encoder()
    cleared = {"view": target, "load_op": "clear", "store_op": "store", "clear_value": value}
    encoder.begin_render_pass(color_attachments=[cleared]).end()
    device.queue.submit([encoder.finish()])


def _draw_part(device: Device, pipeline: Pipeline, groups: list[Any], kinds: dict[str, Any], corners: Any, part: slice) -> None:
    encoder = device.gpu.create_command_encoder()
    pass_ = encoder.begin_render_pass(**kinds)
    pass_.set_pipeline(pipeline.pipeline)
    for number, group in enumerate(groups):
        pass_.set_bind_group(number, group)
    pass_.set_vertex_buffer(0, corners)
    pass_.draw(3 * (part.stop - part.start), 1, 3 * part.start)
    pass_.end()
    device.queue.submit([encoder.finish()])


def draw_extremes(
    device: Device, program: Program, size_px: tuple[int, int], triangles: npt.NDArray[np.float64], uniforms: bytes
) -> tuple[Any, Any]:
    """Draw triangles (t, 3, 3) twice: views of what ``first_face`` tells of the nearest, and ``last_face`` of the farthest.

    Where there is none, the first is as far as it can be told, and the last 0.
    """
    corners = write_corners(device, "corners of faces", triangles)
    views = device.kept.get(("extremes", size_px), lambda: _extremes_of(device, size_px))
    bound = {"uniforms": write_uniforms(device, "uniforms of faces", uniforms)}
    for (view, depth), entry, compare, empty in zip(
        views.pairs, ("first_face", "last_face"), ("greater", "less"), (3e38, 0.0), strict=True
    ):
        pipeline = _pipeline(device, program, entry, "r32float", compare)
        kinds = {
            "color_attachments": [{"view": view, "load_op": "clear", "store_op": "store", "clear_value": (empty, 0, 0, 0)}],
            "depth_stencil_attachment": {
                "view": depth,
                "depth_load_op": "clear",
                "depth_store_op": "discard",
                "depth_clear_value": 0.0 if compare == "greater" else 1.0,
            },
        }
        groups = bind_groups(device, pipeline, bound)
        _draw_part(device, pipeline, groups, kinds, corners, slice(0, len(triangles)))
    return views.pairs[0][0], views.pairs[1][0]


@dataclass(frozen=True, eq=False)
class Extremes:
    """Two pictures of distances, each with its depths."""

    pairs: tuple[tuple[Any, Any], tuple[Any, Any]]
    bytes: int


def _extremes_of(device: Device, size_px: tuple[int, int]) -> Extremes:
    pair = [(_target(device, size_px, "r32float"), _target(device, size_px, DEPTH_FORMAT)) for _ in range(2)]
    return Extremes((pair[0], pair[1]), 16 * size_px[0] * size_px[1])


def bound(device: Device, pipeline: Pipeline, triangles: Triangles, resources: Mapping[str, Any], in_boxes: bool) -> Drawn:
    """Mesh with the resources of a pipeline."""
    return Drawn(triangles, pipeline, bind_groups(device, pipeline, resources), in_boxes)


def draw(device: Device, found: Any, depth: Any, meshes: Sequence[Drawn]) -> None:
    """Submit a pass that draws meshes into cleared targets; ``found`` is None where it writes into buffers alone."""
    encoder = device.gpu.create_command_encoder()
    pass_ = encoder.begin_render_pass(
        color_attachments=[{"view": found, "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}]
        if found is not None
        else [],
        depth_stencil_attachment={
            "view": depth,
            "depth_load_op": "clear",
            "depth_store_op": "store",
            "depth_clear_value": 0.0,
        },
    )
    for mesh in meshes:
        pass_.set_pipeline(mesh.pipeline.pipeline)
        for number, group in enumerate(mesh.groups):
            pass_.set_bind_group(number, group)
        if mesh.in_boxes:
            pass_.draw(2 * mesh.triangles.count)
            continue
        pass_.set_vertex_buffer(0, mesh.triangles.corners)
        pass_.set_index_buffer(mesh.triangles.numbers, "uint32")
        pass_.draw_indexed(mesh.triangles.count)
    pass_.end()
    device.queue.submit([encoder.finish()])


def clear_buffer(device: Device, target: Any, size: int) -> None:
    """Fill the first bytes of a buffer with zeros."""
    encoder = device.gpu.create_command_encoder()
    encoder.clear_buffer(target, 0, size)
    device.queue.submit([encoder.finish()])
