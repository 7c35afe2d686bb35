// Minimum intensity projection.

import package::integrate::extreme::{Extreme, falls_short, no_extreme, keep, show};
import package::sample::{Sample, Slab, Result};
import slot::values::scalar_of;

struct Accumulated { extreme: Extreme }

fn begin() -> Accumulated { return Accumulated(no_extreme()); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  var extreme = (*acc).extreme;
  keep(&extreme, front, scalar_of(front.value) < scalar_of(extreme.here.value));
  keep(&extreme, back, scalar_of(back.value) < scalar_of(extreme.here.value));
  (*acc).extreme = extreme;
  return false;
}

fn settled(acc: ptr<function, Accumulated>, bound: f32, t_world: f32) -> bool { return falls_short((*acc).extreme, bound); }

fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  var extreme = front.extreme;
  let better = scalar_of(back.extreme.here.value) < scalar_of(extreme.here.value);
  if (back.extreme.met > 0u) { keep(&extreme, back.extreme.here, better); }
  return Accumulated(extreme);
}

fn finish(acc: Accumulated) -> Result { return show(acc.extreme); }
