// The front surface at a value: opaque and lit.

import generated::first_hit::params;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::values::scalar_of;

struct Accumulated { rgb: vec3f, t_world: f32 }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), INFINITE); }

// A ray that begins beyond the value meets the surface where it begins.
fn surface(front: Sample, back: Sample) -> f32 {
  let s_front = scalar_of(front.value);
  let s_back = scalar_of(back.value);
  if (s_front >= params.iso) { return 0.0; }
  if (s_back < params.iso) { return 2.0; }
  return (params.iso - s_front) / (s_back - s_front);
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  if (length > 0.0) { return false; }
  (*acc).rgb = lit_rgb;
  (*acc).t_world = front.t_world;
  return true;
}

fn finish(acc: Accumulated) -> Result { return Result(acc.rgb, select(0.0, 1.0, acc.t_world < INFINITE), acc.t_world); }
