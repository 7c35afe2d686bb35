// The front surface at a value: opaque and lit.

import generated::first_hit::{params, SIDE};
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::values::scalar_of;

struct Accumulated { rgb: vec3f, t_world: f32 }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), INFINITE); }

const ABOVE = 0u;
const BOTH = 2u;
const LEAST_SHARE = 1e-7;  // a sheet that is passed is none in which a ray begins

// A ray that begins inside what is solid meets the surface where it begins; a sheet has no inside.
fn surface(front: Sample, back: Sample) -> f32 {
  let s_front = scalar_of(front.value);
  let s_back = scalar_of(back.value);
  let front_above = s_front >= params.iso;
  if (SIDE != BOTH && front_above == (SIDE == ABOVE)) { return 0.0; }
  if (front_above == (s_back >= params.iso)) { return 2.0; }
  return max((params.iso - s_front) / (s_back - s_front), LEAST_SHARE);
}

fn level(front: Sample, back: Sample) -> f32 { return params.iso; }

// Surfaces of the function have a colour for each side.
fn surface_rgb(front: Sample, back: Sample, rgb: vec3f) -> vec3f {
  if (params.coloured == 0u) { return rgb; }
  return select(params.back_rgb, params.front_rgb, scalar_of(back.value) > scalar_of(front.value));
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  if (slab.alpha <= 0.0) { return false; }
  (*acc).rgb = lit_rgb;
  (*acc).t_world = front.t_world;
  return true;
}

fn finish(acc: Accumulated) -> Result { return Result(acc.rgb, select(0.0, 1.0, acc.t_world < INFINITE), acc.t_world); }
