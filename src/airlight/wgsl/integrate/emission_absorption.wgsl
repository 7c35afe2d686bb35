// Front-to-back compositing.

import generated::emission_absorption::params;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};

struct Accumulated { rgb: vec3f, alpha: f32, t_half: f32 }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), 0.0, INFINITE); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  let through = 1.0 - (*acc).alpha;
  (*acc).rgb += through * lit_rgb;
  (*acc).alpha += through * slab.alpha;
  if (through > 0.5 && (*acc).alpha >= 0.5) {
    // Within the slab opacity grows as in a homogeneous medium.
    let share = log(0.5 / through) / log(max(1.0 - slab.alpha, 1e-30));
    (*acc).t_half = front.t_world + saturate(share) * length;
  }
  return (*acc).alpha >= params.opaque_at;
}

fn finish(acc: Accumulated) -> Result { return Result(acc.rgb, acc.alpha, acc.t_half); }
