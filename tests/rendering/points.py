"""Values and gradients of a layer at single points, from the device and from the reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import airlight as al
from airlight import reference
from airlight.gpu import compute
from airlight.gpu.device import Device
from airlight.reference.field import field_scalar
from airlight.reference.gradient import field_gradient
from airlight.rendering.frame import drawn_layer
from airlight.rendering.layers import context_of
from airlight.rendering.resources import DrawnLayer, bound_resources, pack_uniforms, uniform_values
from airlight.shader.program import FrameUniforms, ProgramKey, Switches, build_program, stage_key

ROOT = """
import generated::pass::{segments, waiting};
import slot::field::{locate, field_scalar};
import slot::gradient::field_gradient;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let place = locate(waiting[id.x].xyz);
  segments[id.x] = vec4f(field_gradient(place), field_scalar(place));
}
"""
SIZE_PX = (64, 64)
FUNCTION = al.TransferFunction([(0, "black", 0), (1, "white", 1)])


def scene_of(volume: al.Volume, field, gradient, camera="front", transfer=FUNCTION) -> al.Scene:
    """Scene whose layer has these stages; it is lit, so that the gradient is kept."""
    return al.Scene(volume, transfer=transfer, look=al.Look(field=field, gradient=gradient), camera=camera)


def on_device(device: Device, drawn: al.Scene, p_index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (n,) and world gradients (n, 3) at points (n, 3) in index coordinates; of mixtures the number gradients are of."""
    camera = drawn.camera if isinstance(drawn.camera, al.Camera) else None
    layer = drawn_layer(drawn.layers[0], context_of(drawn.layers[0], 1.0, SIZE_PX, camera=camera))
    used = {slot: layer.stages[slot] for slot in ("field", "gradient")}
    alone = DrawnLayer(used, layer.context, {slot: layer.resources[slot] for slot in used})
    keys = tuple((slot, stage_key(stage, alone.resources[slot], stage.variant(layer.context))) for slot, stage in used.items())
    switches = Switches(has_empty=alone.field.masked)
    groups = alone.field.groups(layer.context)
    program = build_program(ProgramKey(ROOT, (), (keys,), ("segments", "waiting"), (), switches, device.traits, groups))
    anchor, count = np.zeros(3), -(-len(p_index) // 64) * 64
    points = np.zeros((count, 4), np.float32)
    points[: len(p_index), :3] = p_index
    values = uniform_values(device, {}, (alone,), anchor, lambda *_: None)
    bound = bound_resources(device, program, (alone,), {}, anchor, lambda *_: None)
    bound |= {
        "uniforms": compute.write_uniforms(device, "uniforms of points", pack_uniforms(program, FrameUniforms(), values)),
        "waiting": compute.write_records(device, "points", points),
        "segments": compute.storage_buffer(device, "found", points.nbytes),
    }
    pipeline = compute.pipeline_of(device, program)
    compute.dispatch(device, pipeline, compute.bind_groups(device, pipeline, bound), (count // 64, 1, 1))
    data = device.queue.read_buffer(bound["segments"], 0, points.nbytes)
    found = np.frombuffer(data, np.float32).reshape(-1, 4)[: len(p_index)].astype(np.float64)
    return found[:, 3], found[:, :3]


def in_reference(drawn: al.Scene, p_index: np.ndarray, size_px: tuple[int, int] = SIZE_PX) -> tuple[np.ndarray, np.ndarray]:
    """The same, float64."""
    setup = replace(reference.prepare(drawn), camera=drawn.camera, size_px=size_px)
    return field_scalar(setup, p_index)[0], field_gradient(setup, p_index)


def inside(volume: al.Volume, count: int, rng: np.random.Generator) -> np.ndarray:
    """Points (n, 3) within the outer voxel centres, as 32-bit floats hold them; some on voxels and on faces."""
    last = np.array(volume.size) - 1
    p = rng.uniform(0, 1, (count, 3)) * last
    p[: count // 8] = np.floor(p[: count // 8])
    p[count // 8 : count // 6] = last
    return p.astype(np.float32).astype(np.float64)
