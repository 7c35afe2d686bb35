"""What a mesh adds to a picture, against the bare raster pass of the same mesh on the same adapter.

*bare*: the triangles drawn by a program of their own as anybody would write it: indexed, positions and normals of the vertices
interpolated, lit by a head light, into one colour and one depth target. *blended*: the same with half opacity, blended as the
triangles come, tested against the depth but not written to it: what a rasteriser does with a semi-transparent mesh that it
does not put in order. *with* and *without*: the picture of a volume with the mesh in it, opaque or semi-transparent (two
layers), and without; what an opaque mesh hides is not marched. The mesh is a sphere of ``--triangles`` triangles that the
picture holds whole.
Bar: a mesh adds at most 1.3 times its bare pass.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import wgpu
from common import arguments, described, parsed, ratio, side_by_side, table, write_json
from volumes import bone, cropped, real_volume

import airlight as al
from airlight.gpu.device import Device, open_device

MOST = 1.3
BARE = """
struct Camera { clip_from_world: mat4x4f, to_eye: vec4f }
@group(0) @binding(0) var<uniform> camera: Camera;
struct Corner { @builtin(position) place: vec4f, @location(0) normal: vec3f }
@vertex
fn corner(@location(0) p: vec3f, @location(1) n: vec3f) -> Corner { return Corner(camera.clip_from_world * vec4f(p, 1.0), n); }
@fragment
fn lit(at: Corner) -> @location(0) vec4f {
  let facing = abs(dot(normalize(at.normal), camera.to_eye.xyz));
  return vec4f(vec3f(0.1 + 0.7 * facing + 0.2 * pow(facing, 20.0)), 1.0);
}
"""


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 where a mesh adds more than it may."""
    parser = arguments(__doc__, "meshes", repeats=7, size=512, step=1.0, clock="what is told: cpu where others are busy")
    parser.add_argument("--triangles", type=int, default=1_000_000, help="triangles of the mesh (default: %(default)s)")
    options = parsed(parser, argv, size=64, repeats=1, triangles=2000)
    device = open_device(options.device)
    about = described(device, options)
    volume = cropped(real_volume("ct_head"), 24) if options.quick else real_volume("ct_head")
    corners = volume.corners_world()
    camera = al.fit_camera("iso", corners, 1.0)
    mesh = sphere(options.triangles, corners.mean(axis=0), 0.35 * float(np.ptp(corners, axis=0).min()))
    scene = al.Scene(volume, transfer=bone(), camera=camera, background=None)

    with al.Renderer(options.device) as renderer:

        def picture(*meshes: al.Mesh) -> Callable[[], Any]:
            drawn = al.Scene(volume, transfer=scene.layers[0].transfer, camera=camera, background=None, meshes=meshes)
            return lambda: renderer.render(drawn, (options.size, options.size), step=options.step)

        clear = al.Mesh(mesh.vertices, mesh.faces, opacity=0.5)
        runs = {
            "bare": bare_pass(device, mesh, camera, options.size),
            "blended": bare_pass(device, mesh, camera, options.size, blends=True),
            "without": picture(),
            "opaque": picture(mesh),
            "semi-transparent": picture(clear),
        }
        found = side_by_side(runs, options.repeats)
    device.close()
    clock = options.clock
    bare, without = (np.median(getattr(found[name], clock)) for name in ("bare", "without"))
    rows = []
    for name in ("opaque", "semi-transparent"):
        added = np.array(getattr(found[name], clock)) - np.array(getattr(found["without"], clock))
        quotients = [ratio(added, getattr(found[way], clock))["median"] for way in ("bare", "blended")]
        passes_ms = found[name].result.stats["milliseconds"]["meshes"]
        rows.append(
            {
                "mesh": name,
                "its passes alone, wall ms": passes_ms,
                "adds ms": 1e3 * float(np.median(added)),
                "times the bare pass": quotients[0],
                "times the blended pass": quotients[1],
            }
        )
    print(f"{len(mesh.faces):,} triangles; bare pass {1e3 * bare:.0f} ms, picture without {1e3 * without:.0f} ms\n")
    print(table(rows))
    passes = rows[0]["times the bare pass"] <= MOST and rows[1]["times the blended pass"] <= MOST
    print(f"\n{'PASS' if passes else 'FAIL'}: a mesh may add {MOST} times its bare pass")
    shown = {"triangles": len(mesh.faces), "bare_ms": 1e3 * bare, "without_ms": 1e3 * without}
    write_json(options.out, about | shown | {"rows": rows, "passes": passes})
    return 0 if passes or options.quick else 1


def sphere(triangles: int, middle: np.ndarray, radius: float) -> al.Mesh:
    """Sphere of about so many triangles, in rows from pole to pole."""
    rows = max(3, round(np.sqrt(triangles / 4)))
    columns = 2 * rows
    polar, azimuth = np.linspace(0, np.pi, rows + 1), 2 * np.pi * np.arange(columns) / columns
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    unit = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=-1).reshape(-1, 3)
    here = (np.arange(rows)[:, None] * columns + np.arange(columns)).ravel()
    beside = (np.arange(rows)[:, None] * columns + (np.arange(columns) + 1) % columns).ravel()
    faces = np.stack([here, here + columns, beside, beside, here + columns, beside + columns], axis=1).reshape(-1, 3)
    return al.Mesh(middle + radius * unit, faces, color="#d8b090")


def bare_pass(device: Device, mesh: al.Mesh, camera: Any, size: int, blends: bool = False) -> Callable[[], None]:
    """Program that draws the triangles, opaque or blended with half opacity, and waits until they are drawn."""
    gpu, usage = device.gpu, wgpu.BufferUsage
    data = np.concatenate([mesh.vertices, mesh.normals], axis=1).astype(np.float32)
    vertices = gpu.create_buffer_with_data(data=data, usage=usage.VERTEX)
    indices = gpu.create_buffer_with_data(data=np.ascontiguousarray(mesh.faces), usage=usage.INDEX)
    right, up, forward = camera.basis()
    eye, scale = np.array(camera.eye), 1 / np.tan(np.radians(camera.fov_deg) / 2)
    depth = (mesh.vertices - eye) @ forward
    near, far = 0.9 * depth.min(), 1.1 * depth.max()
    rows = np.zeros((4, 4))
    rows[0, :3], rows[1, :3], rows[3, :3] = scale * right, scale * up, forward
    rows[2, :3] = forward * far / (far - near)
    rows[:, 3] = -rows[:, :3] @ eye
    rows[2, 3] -= far * near / (far - near)
    packed = np.concatenate([rows.T.ravel(), -forward, [0]]).astype(np.float32)
    uniforms = gpu.create_buffer_with_data(data=packed, usage=usage.UNIFORM)
    module = gpu.create_shader_module(code=BARE.replace("1.0);\n}", "0.5);\n}") if blends else BARE)
    over = {"operation": "add", "src_factor": "src-alpha", "dst_factor": "one-minus-src-alpha"}
    target = {"format": "rgba8unorm"} | ({"blend": {"color": over, "alpha": over}} if blends else {})
    layout = [
        {"array_stride": 24, "attributes": [{"format": "float32x3", "offset": 12 * n, "shader_location": n} for n in (0, 1)]}
    ]
    pipeline = gpu.create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "corner", "buffers": layout},
        primitive={"topology": "triangle-list", "cull_mode": "none"},
        depth_stencil={"format": "depth32float", "depth_write_enabled": not blends, "depth_compare": "less"},
        fragment={"module": module, "entry_point": "lit", "targets": [target]},
    )
    group = gpu.create_bind_group(
        layout=pipeline.get_bind_group_layout(0), entries=[{"binding": 0, "resource": {"buffer": uniforms}}]
    )
    made = {
        name: gpu.create_texture(size=(size, size, 1), format=name, usage=wgpu.TextureUsage.RENDER_ATTACHMENT)
        for name in ("rgba8unorm", "depth32float")
    }
    colour, depths = (texture.create_view() for texture in made.values())

    def draw() -> None:
        encoder = gpu.create_command_encoder()
        drawn = encoder.begin_render_pass(
            color_attachments=[{"view": colour, "load_op": "clear", "store_op": "store"}],
            depth_stencil_attachment={
                "view": depths,
                "depth_load_op": "clear",
                "depth_store_op": "store",
                "depth_clear_value": 1.0,
            },
        )
        drawn.set_pipeline(pipeline)
        drawn.set_bind_group(0, group)
        drawn.set_vertex_buffer(0, vertices)
        drawn.set_index_buffer(indices, "uint32")
        drawn.draw_indexed(mesh.faces.size)
        drawn.end()
        device.queue.submit([encoder.finish()])
        device.wait()

    return draw


if __name__ == "__main__":
    sys.exit(main())
