// The surface that a ray meets first, of any layer: how each looks for its own is told by `integrate/first_hit.wgsl`.

import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};

struct Accumulated { rgb: vec3f, t_world: f32 }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), INFINITE); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  if (slab.alpha <= 0.0) { return false; }
  (*acc).rgb = lit_rgb;
  (*acc).t_world = front.t_world;
  return true;
}

fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  if (front.t_world < INFINITE) { return front; }
  return back;
}

fn finish(acc: Accumulated) -> Result { return Result(acc.rgb, select(0.0, 1.0, acc.t_world < INFINITE), acc.t_world); }
