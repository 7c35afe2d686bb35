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
from .compute import Pipeline, bind_groups, compiled
from .device import Device

FOUND_FORMAT = "rg32uint"
DEPTH_FORMAT = "depth32float"
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
    """A mesh with the pipeline that draws it, and what is bound to that."""

    triangles: Triangles
    pipeline: Pipeline
    groups: list[Any]


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


def targets_of(device: Device, size_px: tuple[int, int]) -> Targets:
    """Textures of a size."""
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING

    def texture(texel_format: str) -> Any:
        return device.gpu.create_texture(size=(*size_px, 1), format=texel_format, usage=usage).create_view()

    pixels = size_px[0] * size_px[1]
    return Targets(texture(FOUND_FORMAT), texture(DEPTH_FORMAT), texture(DEPTH_FORMAT), pixels * BYTES_PER_PIXEL)


def render_pipeline(device: Device, program: Program) -> Pipeline:
    """Compile a program that draws triangles with depths that fall from the eye on, or return it from the cache.

    Raises
    ------
    ShaderError
        With file and line of the WGSL at fault, and the compiler's words.
    """
    found: Pipeline = device.kept.get(("render pipeline", program.key), lambda: _compile(device, program))
    return found


def _compile(device: Device, program: Program) -> Pipeline:
    draws = "fragments" not in program.key.outputs  # what is gathered is written into buffers
    corner = {"array_stride": 12, "attributes": [{"format": "float32x3", "offset": 0, "shader_location": 0}]}

    def make(module: Any, layout: Any) -> Any:
        return device.gpu.create_render_pipeline(
            layout=layout,
            vertex={"module": module, "entry_point": "at_corner", "buffers": [corner]},
            primitive={"topology": "triangle-list", "cull_mode": "none"},
            depth_stencil={
                "format": DEPTH_FORMAT,
                "depth_write_enabled": draws,
                "depth_compare": "greater" if draws else "always",
            },
            fragment={"module": module, "entry_point": "nearest", "targets": [{"format": FOUND_FORMAT}] if draws else []},
        )

    return compiled(device, program, wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT, make)


def bound(device: Device, pipeline: Pipeline, triangles: Triangles, resources: Mapping[str, Any]) -> Drawn:
    """Mesh with the resources of a pipeline."""
    return Drawn(triangles, pipeline, bind_groups(device, pipeline, resources))


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
