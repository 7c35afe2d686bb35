// Front-to-back compositing.

import generated::emission_absorption::params;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::modulation::weight;
import slot::transfer::opacity_share;

// The slab in which opacity passes one half is kept, and looked into once, at the end.
struct Accumulated {
  rgb: vec3f,
  alpha: f32,
  length: f32,
  through: f32,
  slab_alpha: f32,
  front: Sample,
  back: Sample,
}

fn begin() -> Accumulated {
  var nothing: Accumulated;
  nothing.front.t_world = INFINITE;
  nothing.through = 1.0;
  nothing.slab_alpha = 0.5;
  return nothing;
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  let through = 1.0 - (*acc).alpha;
  let alpha = (*acc).alpha + through * slab.alpha;
  let passes = through > 0.5 && alpha >= 0.5;
  let ends = alpha >= params.opaque_at;
  let fills = ends && params.fills_rest != 0u;
  (*acc).rgb = ((*acc).rgb + through * lit_rgb) * select(1.0, 1.0 / alpha, fills);
  (*acc).alpha = select(alpha, 1.0, fills);
  (*acc).length = select((*acc).length, length, passes);
  (*acc).through = select((*acc).through, through, passes);
  (*acc).slab_alpha = select((*acc).slab_alpha, slab.alpha, passes);
  if (passes) {
    (*acc).front = front;
    (*acc).back = back;
  }
  return ends;
}

// What gets through to the eye.
fn through(acc: Accumulated) -> f32 { return 1.0 - acc.alpha; }

fn finish(acc: Accumulated) -> Result {
  // Thinned as the march has it; what is drawn of labels does not count, since functions with surfaces go with none.
  let thinned = acc.length * weight(acc.front, acc.back, acc.length);
  let share = opacity_share(acc.front, acc.back, thinned, acc.slab_alpha, 1.0 - 0.5 / acc.through);
  let t_world = acc.front.t_world;
  return Result(acc.rgb, acc.alpha, select(t_world + share * acc.length, t_world, acc.length <= 0.0));
}

// Between two parts of a ray: where opacity passes one half is known by then, or lies ahead.
struct Paused { rgb: vec3f, alpha: f32, t_world: f32 }

fn pause(acc: Accumulated) -> Paused { return Paused(acc.rgb, acc.alpha, finish(acc).t_world); }

fn resume(paused: Paused) -> Accumulated {
  var acc = begin();
  acc.rgb = paused.rgb;
  acc.alpha = paused.alpha;
  acc.front.t_world = paused.t_world;
  return acc;
}

// Where opacity passes one half is not told by two parts.
fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  var acc = begin();
  acc.rgb = front.rgb + (1.0 - front.alpha) * back.rgb;
  acc.alpha = front.alpha + (1.0 - front.alpha) * back.alpha;
  return acc;
}
