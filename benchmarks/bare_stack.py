"""The barest stack of slices: view-aligned polygons, one texture, one table of colours, blended by the device.

It draws what the driver ``slices`` draws of a linear field, post-classified and unshaded, by samples instead of slabs, without
skipping and without an early end, into 32-bit floats where the device blends them, else into 16 bits. It is what slice drivers
are measured against.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu
from plain_march import ENTRIES, function_texels

from airlight.gpu import compute, textures
from airlight.gpu.device import Device
from airlight.rendering.march import MarchFrame
from airlight.rendering.proxies.planes import slices_of
from airlight.rendering.proxies.polyhedra import box
from airlight.rendering.resources import grid_texture
from airlight.volume import domain_index

CODE = """
struct Uniforms { value_scale: f32, value_offset: f32, first_value: f32, per_value: f32, length: f32 }
@group(0) @binding(0) var<uniform> u: Uniforms;
@group(0) @binding(1) var volume: texture_3d<f32>;
@group(0) @binding(2) var volume_sampler: sampler;
@group(0) @binding(3) var function: texture_3d<f32>;

struct Corner { @builtin(position) place: vec4f, @location(0) p: vec3f }

@vertex fn at_corner(@location(0) place: vec4f, @location(1) p: vec3f) -> Corner { return Corner(place, p); }

@fragment fn blended(at: Corner) -> @location(0) vec4f {
  let value = textureSampleLevel(volume, volume_sampler, at.p, 0.0).r * u.value_scale + u.value_offset;
  let place = clamp((value - u.first_value) * u.per_value, 0.0, 1.0);
  let medium = textureSampleLevel(function, volume_sampler, vec3f(place, 0.5, 0.5), 0.0);
  let alpha = 1.0 - exp(-medium.a * u.length);
  return vec4f(medium.rgb * alpha, alpha);
}
"""
UNDER = {"src_factor": "one-minus-dst-alpha", "dst_factor": "one", "operation": "add"}


@dataclass(frozen=True, eq=False)
class BareStack:
    """A compiled stack of polygons with what it draws into."""

    device: Device
    pipeline: Any
    group: Any
    vertices: Any
    numbers: Any
    count: int
    target: Any
    texel_format: str
    size_px: tuple[int, int]

    def draw(self) -> np.ndarray[Any, Any]:
        """Draw all slices and read back: rgba (h, w, 4)."""
        width, height = self.size_px
        encoder = self.device.gpu.create_command_encoder()
        cleared = {"view": self.target.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
        work = encoder.begin_render_pass(color_attachments=[cleared])
        work.set_pipeline(self.pipeline)
        work.set_bind_group(0, self.group)
        work.set_vertex_buffer(0, self.vertices)
        work.set_index_buffer(self.numbers, "uint32")
        work.draw_indexed(self.count)
        work.end()
        self.device.queue.submit([encoder.finish()])
        kind = np.dtype(np.float32 if self.texel_format == "rgba32float" else np.float16)
        layout = {"bytes_per_row": 4 * kind.itemsize * width, "rows_per_image": height}
        data = self.device.queue.read_texture({"texture": self.target}, layout, (width, height, 1))
        return np.frombuffer(data, dtype=kind).reshape(height, width, 4)


def bare_stack(frame: MarchFrame) -> BareStack:
    """Compile the barest stack of a frame's scene, with slices a step apart."""
    device, layer = frame.device, frame.layers[0]
    volume, camera = layer.context.volume, frame.scene_stages["camera"]
    low, high = domain_index(volume.size, False)
    matrix = volume.world_from_index.copy()
    matrix[:3, 3] -= frame.anchor_world
    hull = box(low, high, matrix)
    forward, eye = camera.basis()[2], np.asarray(camera.eye)
    depth = (hull.vertices - eye) @ forward
    numbers = np.arange(np.ceil(depth.min() / frame.step_world), np.floor(depth.max() / frame.step_world) + 1)
    polygons = slices_of(hull, forward, float(forward @ eye) + numbers * frame.step_world)
    fans = [[f, f + k, f + k + 1] for f, n in zip(polygons.first, polygons.counts, strict=False) for k in range(1, n - 1)]
    indices = np.array(fans, dtype=np.uint32).ravel()
    p_index = (polygons.vertices - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
    corners = np.concatenate([places(camera, polygons.vertices, frame.size_px), (p_index + 0.5) / volume.size], axis=1)
    usage = wgpu.BufferUsage
    grid = grid_texture(device, layer.resources["field"]["grid"], frame.progress)
    first, last = layer.context.transfer.values[[0, -1]]
    encoding = grid.encodings[0]
    told = [encoding.scale, encoding.offset, first, 1 / (last - first), frame.step_world, 0, 0, 0]
    uniforms = np.array(told, dtype=np.float32)

    def upload(data: np.ndarray[Any, Any], use: int) -> Any:
        held = device.gpu.create_buffer(size=data.nbytes, usage=use | usage.COPY_DST)
        device.queue.write_buffer(held, 0, np.ascontiguousarray(data))
        return held

    both = wgpu.ShaderStage.FRAGMENT
    kind = "float" if device.traits.filters_float32 else "unfilterable-float"
    layout = device.gpu.create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": both, "buffer": {"type": "uniform"}},
            {"binding": 1, "visibility": both, "texture": {"sample_type": "float", "view_dimension": "3d"}},
            {"binding": 2, "visibility": both, "sampler": {"type": "filtering"}},
            {"binding": 3, "visibility": both, "texture": {"sample_type": kind, "view_dimension": "3d"}},
        ]
    )
    texel_format = "rgba32float" if "float32-blendable" in device.features else "rgba16float"
    module = device.gpu.create_shader_module(code=CODE)
    attributes = [
        {"format": "float32x4", "offset": 0, "shader_location": 0},
        {"format": "float32x3", "offset": 16, "shader_location": 1},
    ]
    pipeline = device.gpu.create_render_pipeline(
        layout=device.gpu.create_pipeline_layout(bind_group_layouts=[layout]),
        vertex={"module": module, "entry_point": "at_corner", "buffers": [{"array_stride": 28, "attributes": attributes}]},
        primitive={"topology": "triangle-list", "cull_mode": "none"},
        fragment={
            "module": module,
            "entry_point": "blended",
            "targets": [{"format": texel_format, "blend": {"color": UNDER, "alpha": UNDER}}],
        },
    )
    bound: tuple[Any, ...] = (
        {"buffer": upload(uniforms, usage.UNIFORM)},
        grid.texture.create_view(),
        compute.linear_sampler(device),
        textures.upload_table(device, function_texels(layer.context.transfer)).create_view(),
    )
    group = device.gpu.create_bind_group(layout=layout, entries=[{"binding": i, "resource": r} for i, r in enumerate(bound)])
    target = device.gpu.create_texture(
        size=(*frame.size_px, 1),
        format=texel_format,
        usage=wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC,
    )
    vertices, faces = upload(corners.astype(np.float32), usage.VERTEX), upload(indices, usage.INDEX)
    return BareStack(device, pipeline, group, vertices, faces, len(indices), target, texel_format, frame.size_px)


def places(camera: Any, p_world: np.ndarray[Any, Any], size_px: tuple[int, int]) -> np.ndarray[Any, Any]:
    """Clip coordinates (n, 4) of points (n, 3)."""
    right, up, forward = camera.basis()
    away = p_world - np.asarray(camera.eye)
    depth = away @ forward
    half = camera.half_height
    flat = camera.name == "orthographic"
    w = np.ones_like(depth) if flat else depth
    aspect = size_px[0] / size_px[1]
    return np.stack([away @ right / (half * aspect), away @ up / half, 0.5 * w, w], axis=1)


__all__ = ["ENTRIES", "BareStack", "bare_stack"]
