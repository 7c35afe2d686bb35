"""The plainest possible march: one hand-written compute shader, without slots, stages or choices.

It draws what airlight draws with a linear field, post-classified, unshaded (or a maximum intensity projection): the same
texture, sampler, table look-up, sample positions, slabs, early end, workgroups and tiles. It is what the structure of slots
is measured against.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu

import airlight as al
from airlight.gpu import compute, textures
from airlight.gpu.device import Device
from airlight.gpu.tiles import Pace, Tile, run_tiles, tiles
from airlight.rendering.march import MarchFrame
from airlight.rendering.resources import grid_texture
from airlight.transfer.cells import value_axis

ENTRIES = 1024
DECLARATIONS = """
struct Uniforms {
  origin: vec3f, h: f32,            // of rays in texture coordinates; distance of samples [world]
  forward: vec3f, opaque_at: f32,   // per world unit, in texture coordinates
  right: vec3f, first_value: f32,
  up: vec3f, per_value: f32,
  low: vec3f, value_scale: f32,     // of the domain, in texture coordinates
  high: vec3f, value_offset: f32,
  right_world: vec3f, perspective: u32,
  up_world: vec3f, entries: u32,
  forward_world: vec3f, pad: u32,
  size: vec2u, tile_origin: vec2u,
  tile_size: vec2u, pad_2: vec2u,
}
@group(0) @binding(0) var<uniform> u: Uniforms;
@group(0) @binding(1) var volume: texture_3d<f32>;
@group(0) @binding(2) var volume_sampler: sampler;
@group(0) @binding(3) var function: texture_3d<f32>;
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> samples: array<vec2f>;

fn look_up(value: f32) -> vec4f {
  let last = f32(u.entries - 1u);
  let place = clamp((value - u.first_value) * u.per_value * last, 0.0, last);
  let low = min(u32(place), u.entries - 2u);
  let a = textureLoad(function, vec3u(low, 0u, 0u), 0);
  let b = textureLoad(function, vec3u(low + 1u, 0u, 0u), 0);
  return mix(a, b, place - f32(low));
}

fn value_at(p: vec3f) -> f32 {
  return textureSampleLevel(volume, volume_sampler, p, 0.0).r * u.value_scale + u.value_offset;
}
"""

MAIN = """
@compute @workgroup_size({x}, {y})
fn main(@builtin(global_invocation_id) id: vec3u) {{
  if (any(id.xy >= u.tile_size)) {{ return; }}
  let pixel = u.tile_origin + id.xy;
  let at = pixel.y * u.size.x + pixel.x;
  let aside = vec2f(2.0, -2.0) * (vec2f(pixel) + 0.5) / vec2f(u.size) + vec2f(-1.0, 1.0);
  var origin = u.origin;
  var direction = u.forward;
  if (u.perspective != 0u) {{
    let way = u.forward_world + aside.x * u.right_world + aside.y * u.up_world;
    direction = (u.forward + aside.x * u.right + aside.y * u.up) / length(way);
  }} else {{
    origin += aside.x * u.right + aside.y * u.up;
  }}
  let a = (u.low - origin) / direction;
  let b = (u.high - origin) / direction;
  let near = min(a, b);
  let far = max(a, b);
  let enter = max(max(near.x, near.y), max(near.z, 0.0));
  let leave = min(far.x, min(far.y, far.z));
  if (leave <= enter) {{
    radiance[at] = vec4f(0.0);
    samples[at] = vec2f(3.4e38, 0.0);
    return;
  }}
  var t = enter;
  var k = floor(enter / u.h) + 1.0;
  var count = 1.0;
  var front = value_at(origin + t * direction);
{loop}
}}
"""

COMPOSITE = """
  var rgb = vec3f(0.0);
  var alpha = 0.0;
  var front_medium = look_up(front);
  loop {
    let next = min(k * u.h, leave);
    let back = value_at(origin + next * direction);
    let medium = look_up(back);
    let extinction = 0.5 * (front_medium.a + medium.a);
    let opacity = 1.0 - exp(-extinction * (next - t));
    let weight = (1.0 - alpha) * opacity;
    rgb += weight * (0.5 * (front_medium.rgb * front_medium.a + medium.rgb * medium.a) / max(extinction, 1e-20));
    alpha += weight;
    k += 1.0;
    count += 1.0;
    t = next;
    front_medium = medium;
    if (alpha >= u.opaque_at || next >= leave) { break; }
  }
  radiance[at] = vec4f(rgb, alpha);
  samples[at] = vec2f(t, count);
"""

MAXIMUM = """
  var t_best = t;
  loop {
    let next = min(k * u.h, leave);
    let back = value_at(origin + next * direction);
    if (back > front) { front = back; t_best = next; }
    k += 1.0;
    count += 1.0;
    if (next >= leave) { break; }
  }
  radiance[at] = vec4f(look_up(front).rgb, 1.0);
  samples[at] = vec2f(t_best, count);
"""


@dataclass(frozen=True, eq=False)
class PlainMarch:
    """A compiled shader with what it reads and writes."""

    device: Device
    pipeline: Any
    groups: Any
    uniforms: Any
    record: np.ndarray[Any, Any]
    outputs: tuple[Any, Any]
    size_px: tuple[int, int]
    pace: Pace

    def draw(self) -> tuple[np.ndarray[Any, Any], float]:
        """Draw all tiles and read back: rgba (h, w, 4) and the number of samples."""
        x, y = self.device.traits.workgroup
        width, height = self.size_px

        def submit(tile: Tile) -> None:
            self.record["tile_origin"], self.record["tile_size"] = (tile.x, tile.y), (tile.width, tile.height)
            self.device.queue.write_buffer(self.uniforms, 0, self.record.tobytes())
            encoder = self.device.gpu.create_command_encoder()
            work = encoder.begin_compute_pass()
            work.set_pipeline(self.pipeline)
            work.set_bind_group(0, self.groups)
            work.dispatch_workgroups(-(-tile.width // x), -(-tile.height // y), 1)
            work.end()
            self.device.queue.submit([encoder.finish()])

        run_tiles(self.device, tiles(width, 0, height, self.pace), submit, self.pace, lambda: None, lambda done: None)
        rgba, depth = (
            np.frombuffer(self.device.queue.read_buffer(buffer, 0, width * height * channels * 4), dtype=np.float32)
            for buffer, channels in zip(self.outputs, (4, 2), strict=True)
        )
        return rgba.reshape(height, width, 4), float(depth.reshape(-1, 2)[:, 1].sum(dtype=np.float64))


def plain_march(frame: MarchFrame) -> PlainMarch:
    """Compile the plainest march of a frame's scene."""
    device, layer = frame.device, frame.layers[0]
    maximum = layer_integrate(frame) == "mip"
    x, y = device.traits.workgroup
    code = DECLARATIONS + MAIN.format(x=x, y=y, loop=MAXIMUM if maximum else COMPOSITE)
    usage = wgpu.BufferUsage
    record = uniforms(frame)
    held = device.gpu.create_buffer(size=record.nbytes, usage=usage.UNIFORM | usage.COPY_DST)
    pixels = frame.size_px[0] * frame.size_px[1]
    outputs = tuple(device.gpu.create_buffer(size=pixels * n, usage=usage.STORAGE | usage.COPY_SRC) for n in (16, 8))
    table = textures.upload_table(device, function_texels(layer.context.transfer))
    grid = grid_texture(device, layer.resources["field"]["grid"], frame.progress)
    visible = {"visibility": wgpu.ShaderStage.COMPUTE}
    layout = device.gpu.create_bind_group_layout(
        entries=[
            {"binding": 0, "buffer": {"type": "uniform"}} | visible,
            {"binding": 1, "texture": {"sample_type": "float", "view_dimension": "3d"}} | visible,
            {"binding": 2, "sampler": {"type": "filtering"}} | visible,
            {"binding": 3, "texture": {"sample_type": "unfilterable-float", "view_dimension": "3d"}} | visible,
            {"binding": 4, "buffer": {"type": "storage"}} | visible,
            {"binding": 5, "buffer": {"type": "storage"}} | visible,
        ]
    )
    pipeline = device.gpu.create_compute_pipeline(
        layout=device.gpu.create_pipeline_layout(bind_group_layouts=[layout]),
        compute={"module": device.gpu.create_shader_module(code=code), "entry_point": "main"},
    )
    bound = (
        {"buffer": held},
        grid.texture.create_view(),
        compute.linear_sampler(device),
        table.create_view(),
        {"buffer": outputs[0]},
        {"buffer": outputs[1]},
    )
    groups = device.gpu.create_bind_group(
        layout=layout, entries=[{"binding": i, "resource": resource} for i, resource in enumerate(bound)]
    )
    return PlainMarch(device, pipeline, groups, held, record, outputs, frame.size_px, Pace())


def layer_integrate(frame: MarchFrame) -> str:
    """Name of the stage that integrates."""
    scene: al.Scene = frame.scene
    return scene.visible_layers[0].look.integrate.name


VEC3 = (np.float32, 3)
UNIFORMS = np.dtype(
    [
        *(("origin", *VEC3), ("h", np.float32), ("forward", *VEC3), ("opaque_at", np.float32)),
        *(("right", *VEC3), ("first_value", np.float32), ("up", *VEC3), ("per_value", np.float32)),
        *(("low", *VEC3), ("value_scale", np.float32), ("high", *VEC3), ("value_offset", np.float32)),
        *(("right_world", *VEC3), ("perspective", np.uint32), ("up_world", *VEC3), ("entries", np.uint32)),
        *(("forward_world", *VEC3), ("pad", np.uint32)),
        *(("size", np.uint32, 2), ("tile_origin", np.uint32, 2), ("tile_size", np.uint32, 2), ("pad_2", np.uint32, 2)),
    ]
)


def function_texels(function: al.TransferFunction) -> np.ndarray:
    """Colour and extinction at evenly spaced values, as one texture that every sample looks up."""
    rgb, extinction = function(np.linspace(*value_axis(function), ENTRIES))
    return np.concatenate([rgb, extinction[:, None]], axis=1).astype(np.float32)[None, None]


def uniforms(frame: MarchFrame) -> np.ndarray[Any, Any]:
    """Numbers of the shader: camera, domain and encoding in texture coordinates."""
    layer, camera = frame.layers[0], frame.scene.camera
    assert isinstance(camera, al.Camera)
    volume = layer.context.volume
    of_camera = camera.uniforms(layer.context)
    size = np.array(volume.size, dtype=np.float64)
    unit_from_world = volume.index_from_world[:3, :3] / size[:, None]
    encoding = grid_texture(frame.device, layer.resources["field"]["grid"], frame.progress).encoding
    first, last = value_axis(layer.context.transfer)
    record = np.zeros((), dtype=UNIFORMS)
    values = {
        "origin": ((volume.index_from_world @ [*of_camera.eye, 1.0])[:3] + 0.5) / size,
        "forward": unit_from_world @ of_camera.forward,
        "right": unit_from_world @ of_camera.right,
        "up": unit_from_world @ of_camera.up,
        "right_world": of_camera.right,
        "up_world": of_camera.up,
        "forward_world": of_camera.forward,
        "low": 0.5 / size,
        "high": (size - 0.5) / size,
        "h": frame.step_world,
        "opaque_at": getattr(frame.scene.visible_layers[0].look.integrate, "opaque_at", 1.0),
        "first_value": first,
        "per_value": 1 / (last - first),
        "entries": ENTRIES,
        "value_scale": encoding.scale,
        "value_offset": encoding.offset,
        "perspective": camera.name == "perspective",
        "size": frame.size_px,
    }
    for name, value in values.items():
        record[name] = value
    return record
