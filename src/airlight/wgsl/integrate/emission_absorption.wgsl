// Front-to-back compositing.

import generated::emission_absorption::params;
import generated::sizes::Values;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::transfer::opacity_share;

// The slab in which opacity passes one half is kept, and looked into once, at the end.
struct Accumulated {
  rgb: vec3f,
  alpha: f32,
  t_world: f32,
  length: f32,
  through: f32,
  slab_alpha: f32,
  front: Values,
  back: Values,
}

fn begin() -> Accumulated {
  var nothing: Accumulated;
  nothing.t_world = INFINITE;
  nothing.through = 1.0;
  nothing.slab_alpha = 0.5;
  return nothing;
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  let through = 1.0 - (*acc).alpha;
  let alpha = (*acc).alpha + through * slab.alpha;
  let passes = through > 0.5 && alpha >= 0.5;
  (*acc).rgb += through * lit_rgb;
  (*acc).alpha = alpha;
  (*acc).t_world = select((*acc).t_world, front.t_world, passes);
  (*acc).length = select((*acc).length, length, passes);
  (*acc).through = select((*acc).through, through, passes);
  (*acc).slab_alpha = select((*acc).slab_alpha, slab.alpha, passes);
  if (passes) {
    (*acc).front = front.value;
    (*acc).back = back.value;
  }
  return alpha >= params.opaque_at;
}

fn finish(acc: Accumulated) -> Result {
  let share = opacity_share(acc.front, acc.back, acc.length, acc.slab_alpha, 1.0 - 0.5 / acc.through);
  return Result(acc.rgb, acc.alpha, select(acc.t_world + share * acc.length, INFINITE, acc.t_world >= INFINITE));
}
